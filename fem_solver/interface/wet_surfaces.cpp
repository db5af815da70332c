// SPDX-License-Identifier: BSD-3-Clause
#include "fem_solver/interface/wet_surfaces.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <utility>

#include "common/base/require.hpp"
#include "common/mechanics/elements/quadratic_cells.hpp"
#include "common/mechanics/mesh/cell_groups.hpp"
#include "common/mechanics/ranks/gather.hpp"

namespace gabion::fem {

namespace {

/// Facets of an interface on all ranks: each gives its own, with group and place in it.
template <int dim>
std::vector<std::int64_t> gather_facets(const Mesh<dim>& mesh, const MeshRanks& ranks,
                                        const WetSurfaceSettings& interface) {
  if (ranks.alone()) return facets_of(mesh, interface);
  const std::size_t n = num_nodes(facet_type(mesh.cell_type)), width = n + 2;
  std::vector<std::int64_t> own;
  for (std::size_t g = 0; g < interface.groups.size(); ++g) {
    const auto& facets = mesh.facets(interface.groups[g], interface.where);
    const auto numbers = ranks.facet_numbers(interface.groups[g]);
    for (std::size_t f = 0; f < numbers.size(); ++f) {
      own.insert(own.end(), {static_cast<std::int64_t>(g), numbers[f]});
      for (std::size_t a = 0; a < n; ++a) own.push_back(ranks.node_of_all(facets[f * n + a]));
    }
  }
  const auto all = gather_on_all<std::int64_t>(ranks.comm(), own);
  std::vector<const std::int64_t*> rows;
  for (std::size_t first = 0; first < all.size(); first += width) rows.push_back(&all[first]);
  std::ranges::sort(rows, [](const std::int64_t* a, const std::int64_t* b) {
    return std::pair(a[0], a[1]) < std::pair(b[0], b[1]);
  });
  std::vector<std::int64_t> facets;
  for (const std::int64_t* row : rows) facets.insert(facets.end(), row + 2, row + width);
  return facets;
}

/// Split quadratic facets into linear ones on all of their nodes: the forces and displacements of
/// the vertices are those of the nodes, so work is the same on both sides. Linear facets stay.
std::vector<std::int64_t> split_facets(std::span<const std::int64_t> facets, CellType type) {
  const auto parts = linear_parts(type);
  std::vector<std::int64_t> result;
  for (std::size_t f = 0; f < facets.size(); f += num_nodes(type)) {
    for (const int place : parts) result.push_back(facets[f + place]);
  }
  return result;
}

}  // namespace

template <int dim>
std::vector<std::int64_t> facets_of(const Mesh<dim>& mesh, const WetSurfaceSettings& interface) {
  std::vector<std::int64_t> facets;
  for (const auto& group : interface.groups) {
    const auto& part = mesh.facets(group, interface.where);
    facets.insert(facets.end(), part.begin(), part.end());
  }
  return facets;
}

template <int dim>
WetSurfaces<dim>::WetSurfaces(const Mesh<dim>& structure,
                              const std::vector<WetSurfaceSettings>& interfaces,
                              const MeshRanks& ranks)
    : shared_(ranks.shared()), num_dofs_(structure.nodes.size() * dim) {
  for (const auto& interface : interfaces) {
    const auto facets = gather_facets(structure, ranks, interface);
    std::vector<std::int64_t> nodes = facets;
    if (!interface.behind.empty()) {
      const auto cells = cells_of_groups(structure, interface.behind, interface.behind_where);
      for (const std::int32_t node : nodes_of_cells(structure, cells)) nodes.push_back(node);
    }
    std::sort(nodes.begin(), nodes.end());
    nodes.erase(std::unique(nodes.begin(), nodes.end()), nodes.end());

    InterfaceMesh mesh;
    mesh.name = interface.name;
    mesh.dim = dim;
    const CellType facet = facet_type(structure.cell_type);
    mesh.vertices_per_facet = linear_part_nodes(facet);
    for (const auto node : split_facets(facets, facet)) {
      mesh.facets.push_back(std::lower_bound(nodes.begin(), nodes.end(), node) - nodes.begin());
    }
    auto& held = nodes_.emplace_back();
    for (const auto node : nodes) {
      held.push_back(ranks.held_node(static_cast<std::int32_t>(node)));
    }
    mesh.coordinates =
        of_vertices(held, [&](std::int32_t node) { return structure.nodes[node].data(); });
    meshes_.push_back(std::move(mesh));
    kinds_.push_back(ForceKind::end_of_step);
  }
}

/// Values of the vertices, each from the rank that owns its node.
template <int dim>
template <class Values>
std::vector<double> WetSurfaces<dim>::of_vertices(std::span<const std::int32_t> nodes,
                                                  const Values& of_node) const {
  std::vector<double> values(nodes.size() * dim, 0.0);
  for (std::size_t k = 0; k < nodes.size(); ++k) {
    if (nodes[k] < 0 || !shared_.owns(nodes[k])) continue;
    std::copy_n(of_node(nodes[k]), dim, &values[k * dim]);
  }
  shared_.total(values);
  return values;
}

template <int dim>
void WetSurfaces<dim>::set_force_kinds(const ForceKinds& kinds) {
  kinds_.assign(meshes_.size(), ForceKind::end_of_step);
  for (const auto& [name, kind] : kinds) {
    const auto found = std::find_if(meshes_.begin(), meshes_.end(),
                                    [&](const InterfaceMesh& mesh) { return mesh.name == name; });
    require(found != meshes_.end(), "kinds of forces: found interface \"{}\", which is none here",
            name);
    kinds_[static_cast<std::size_t>(found - meshes_.begin())] = kind;
  }
}

template <int dim>
ExternalForces WetSurfaces<dim>::nodal_forces(const InterfaceValues& received) const {
  if (received.empty()) return {};
  require(received.size() == meshes_.size(), "received forces of {} interfaces, expected {}",
          received.size(), meshes_.size());
  ExternalForces forces;
  forces.end.assign(num_dofs_, 0.0);
  forces.step.assign(num_dofs_, 0.0);
  for (std::size_t s = 0; s < meshes_.size(); ++s) {
    const auto found = received.find(meshes_[s].name);
    require(found != received.end(), "received no forces of interface \"{}\"", meshes_[s].name);
    const auto& values = found->second;
    require(values.size() == nodes_[s].size() * dim,
            "interface \"{}\": received {} force values, expected {} vertices x {}",
            meshes_[s].name, values.size(), nodes_[s].size(), dim);
    auto& f = kinds_[s] == ForceKind::step_mean ? forces.step : forces.end;
    for (std::size_t k = 0; k < nodes_[s].size(); ++k) {
      for (int c = 0; c < dim && nodes_[s][k] >= 0; ++c) {
        f[static_cast<std::size_t>(nodes_[s][k]) * dim + c] += values[k * dim + c];
      }
    }
  }
  return forces;
}

template <int dim>
InterfaceValues WetSurfaces<dim>::displacements(std::span<const double> u) const {
  InterfaceValues result;
  for (std::size_t s = 0; s < meshes_.size(); ++s) {
    result[meshes_[s].name] = of_vertices(nodes_[s], [&](std::int32_t node) {
      return u.data() + static_cast<std::size_t>(node) * dim;
    });
  }
  return result;
}

template std::vector<std::int64_t> facets_of(const Mesh<2>&, const WetSurfaceSettings&);
template std::vector<std::int64_t> facets_of(const Mesh<3>&, const WetSurfaceSettings&);
template class WetSurfaces<2>;
template class WetSurfaces<3>;

}  // namespace gabion::fem
