// SPDX-License-Identifier: BSD-3-Clause
#include "fem_solver/interface/changing_surfaces.hpp"

#include <algorithm>

#include "common/base/require.hpp"
#include "common/mechanics/elements/cell_type.hpp"
#include "common/mechanics/mesh/cell_groups.hpp"
#include "common/run/list_lengths.hpp"

namespace gabion::fem {

namespace {

/// Whether a cell is gone: its whole stress is lost.
constexpr double all_of_it = 1;

}  // namespace

template <int dim>
ChangingSurfaces<dim>::ChangingSurfaces(const FemSettings<dim>& settings,
                                        const WetSurfaces<dim>& surfaces)
    : settings_(settings) {
  const Mesh<dim>& mesh = settings.mesh;
  const auto changes = [](const WetSurfaceSettings& s) { return !s.behind.empty(); };
  const auto changing = std::ranges::find_if(settings.interfaces, changes);
  if (changing == settings.interfaces.end()) return;
  require<ConfigError>(
      std::ranges::any_of(settings.materials, [](const auto& m) { return m.failure.any(); }),
      "{}: found cells behind an interface, and no material of cells that fails, allowed: with "
      "\"failure_plastic_strain\" in \"material\", of concrete \"failure_strain\" or "
      "\"failure_crushing_strain\"",
      changing->behind_where);
  owner_.assign(static_cast<std::size_t>(mesh.num_cells()), -1);
  for (std::size_t s = 0; s < settings.interfaces.size(); ++s) {
    const WetSurfaceSettings& interface = settings.interfaces[s];
    if (!changes(interface)) continue;
    require<ConfigError>(settings.ranks.alone(),
                         "{}: found cells behind an interface on several ranks, allowed: one rank",
                         interface.behind_where);
    require<ConfigError>(!is_quadratic(mesh.cell_type),
                         "{}: found quadratic cells, allowed: linear ones, whose facets are those "
                         "of the interface",
                         interface.behind_where);
    const auto cells = cells_of_groups(mesh, interface.behind, interface.behind_where);
    for (const std::int32_t c : cells) {
      require<ConfigError>(owner_[c] < 0,
                           "{}: found cell {}, which is behind another interface too, allowed: "
                           "each cell behind one",
                           interface.behind_where, c);
      owner_[c] = static_cast<std::int32_t>(s);
    }
    surfaces_.push_back({interface.name, surfaces.nodes(s),
                         ExposedFacets<dim>(mesh, facets_of(mesh, interface), cells)});
  }
  for (std::size_t s = 0; s < settings.interfaces.size(); ++s) {
    const WetSurfaceSettings& interface = settings.interfaces[s];
    std::vector<std::int32_t> others;
    for (std::int32_t c = 0; c < mesh.num_cells(); ++c) {
      if (owner_[c] >= 0 && owner_[c] != static_cast<std::int32_t>(s)) others.push_back(c);
    }
    const ExposedFacets<dim> seen(mesh, facets_of(mesh, interface), others);
    const auto found = std::ranges::find_if(seen.cells(), [](std::int32_t c) { return c >= 0; });
    if (found == seen.cells().end()) continue;
    throw ConfigError(interface.where + ": found a facet of cell " + std::to_string(*found) +
                      ", which is behind the interface \"" +
                      settings.interfaces[owner_[*found]].name +
                      "\", allowed: all wet facets of cells that may leave in that interface");
  }
  find_facets(std::vector<double>(static_cast<std::size_t>(mesh.num_cells()), 0.0));
}

template <int dim>
void ChangingSurfaces<dim>::find_facets(std::span<const double> lost) {
  std::vector<char> gone;
  for (const double share : lost) gone.push_back(share == all_of_it ? 1 : 0);
  num_gone_ = std::ranges::count(gone, char{1});
  for (const Surface& surface : surfaces_) {
    std::vector<std::int64_t>& facets = facets_[surface.name];
    facets.clear();
    for (const std::int64_t node : surface.exposed.facets(gone)) {
      const auto vertex = std::ranges::lower_bound(surface.nodes, node);
      facets.push_back(vertex - surface.nodes.begin());
    }
  }
}

/// Nodes of cells that are gone, and of none that remains.
template <int dim>
std::vector<std::int64_t> ChangingSurfaces<dim>::loose_nodes(std::span<const double> lost) const {
  const Mesh<dim>& mesh = settings_.mesh;
  std::vector<char> held(mesh.nodes.size(), 0), left(mesh.nodes.size(), 0);
  for (std::int32_t c = 0; c < mesh.num_cells(); ++c) {
    for (const std::int32_t node : mesh.cell(c)) (lost[c] == all_of_it ? left : held)[node] = 1;
  }
  for (const std::int32_t node : mesh.lines) held[node] = 1;
  std::vector<std::int64_t> loose;
  for (std::size_t k = 0; k < held.size(); ++k) {
    if (left[k] != 0 && held[k] == 0) loose.push_back(static_cast<std::int64_t>(k));
  }
  return loose;
}

template <int dim>
void ChangingSurfaces<dim>::accept(std::span<const double> lost, std::span<const double> u) {
  if (std::ranges::count(lost, all_of_it) == num_gone_) return;
  find_facets(lost);
  std::vector<double> places;
  const std::vector<std::int64_t> loose = loose_nodes(lost);
  for (const std::int64_t node : loose) {
    const auto before = std::ranges::lower_bound(loose_, node);
    const double* place = before != loose_.end() && *before == node
                              ? &places_[static_cast<std::size_t>(before - loose_.begin()) * dim]
                              : &u[static_cast<std::size_t>(node) * dim];
    places.insert(places.end(), place, place + dim);
  }
  loose_ = loose;
  places_ = std::move(places);
}

template <int dim>
void ChangingSurfaces<dim>::load(std::span<const double> lost) {
  require(loose_ == loose_nodes(lost),
          "saved state: \"loose_nodes\": found {} nodes, allowed: those of the cells that are gone",
          loose_.size());
  find_facets(lost);
}

template <int dim>
void ChangingSurfaces<dim>::hold(InterfaceValues& displacements) const {
  if (loose_.empty()) return;
  for (const Surface& surface : surfaces_) {
    std::vector<double>& values = displacements.at(surface.name);
    for (std::size_t v = 0; v < surface.nodes.size(); ++v) {
      const auto node = std::ranges::lower_bound(loose_, surface.nodes[v]);
      if (node == loose_.end() || *node != surface.nodes[v]) continue;
      std::copy_n(&places_[static_cast<std::size_t>(node - loose_.begin()) * dim], dim,
                  &values[v * dim]);
    }
  }
}

template <int dim>
void ChangingSurfaces<dim>::visit_state(StateVisitor& visitor) {
  visitor.list("loose_nodes", loose_);
  visitor.list("loose_places", places_);
  require_values_each("loose_places", places_.size(), loose_.size(), dim);
}

template class ChangingSurfaces<2>;
template class ChangingSurfaces<3>;

}  // namespace gabion::fem
