// SPDX-License-Identifier: BSD-3-Clause
#include "fem_solver/flat_cells.hpp"

#include <algorithm>
#include <array>
#include <cstdint>
#include <span>
#include <utility>
#include <vector>

#include "common/base/log.hpp"
#include "common/mechanics/elements/cell_facets.hpp"
#include "common/mechanics/mesh/boundary.hpp"
#include "common/mechanics/ranks/sum.hpp"
#include "fem_solver/stress/cells_of_materials.hpp"

namespace gabion::fem {

namespace {

constexpr double flat = 2;  // length over thickness from which bending is twice too stiff

/// A pair of facets of a cell without common nodes.
struct Across {
  std::array<int, 2> facets;
  double distance;  ///< of their middles [m]
};

template <int dim>
std::vector<Across> pairs_of_facets(const Mesh<dim>& mesh, std::int32_t c) {
  const auto n = static_cast<std::size_t>(num_nodes(facet_type(mesh.cell_type)));
  std::vector<std::vector<std::int32_t>> facets;
  std::vector<Vector<dim>> middles;
  for (int f = 0; f < num_facets(mesh.cell_type); ++f) {
    const auto nodes = cell_facet(mesh, c, f);
    facets.emplace_back(nodes.begin(), nodes.begin() + n);
    Vector<dim>& middle = middles.emplace_back(Vector<dim>::Zero());
    for (const std::int32_t i : facets.back()) middle += mesh.nodes[i] / static_cast<double>(n);
  }
  std::vector<Across> pairs;
  for (std::size_t f = 0; f < facets.size(); ++f) {
    for (std::size_t g = f + 1; g < facets.size(); ++g) {
      const bool meet = std::ranges::find_first_of(facets[f], facets[g]) != facets[f].end();
      if (meet) continue;
      pairs.push_back(
          {{static_cast<int>(f), static_cast<int>(g)}, (middles[f] - middles[g]).norm()});
    }
  }
  return pairs;
}

/// Length of a cell over its thickness, that of the part; 0: it has neighbours on both sides.
template <int dim>
double flatness(const Mesh<dim>& mesh, std::int32_t c, std::span<const std::int32_t> neighbours) {
  const auto pairs = pairs_of_facets(mesh, c);
  double length = 0, thickness = 0;
  for (const Across& pair : pairs) {
    length = std::max(length, pair.distance);
    const bool free = neighbours[static_cast<std::size_t>(pair.facets[0])] < 0 &&
                      neighbours[static_cast<std::size_t>(pair.facets[1])] < 0;
    if (free && (thickness == 0 || pair.distance < thickness)) thickness = pair.distance;
  }
  return thickness > 0 ? length / thickness : 0;
}

}  // namespace

template <int dim>
void warn_of_flat_cells(const FemSettings<dim>& settings, MPI_Comm comm) {
  const Mesh<dim>& mesh = settings.mesh;
  const bool can_lock = mesh.cell_type == CellType::quad4 || mesh.cell_type == CellType::hex8;
  const auto is_full = [](const auto& material) {
    return material.formulation == Formulation::full;
  };
  if (!can_lock || num_ranks(comm) > 1 || std::ranges::none_of(settings.materials, is_full)) return;
  const auto cells = cells_of_materials<dim>(mesh, settings.materials, settings.ranks);
  const std::vector<std::int32_t> neighbours = cell_neighbours(mesh);
  const auto n = static_cast<std::size_t>(num_facets(mesh.cell_type));
  for (std::size_t m = 0; m < cells.size(); ++m) {
    if (!is_full(settings.materials[m])) continue;
    double worst = 0;
    std::size_t count = 0;
    for (const std::int32_t c : cells[m]) {
      const double found =
          flatness(mesh, c, std::span(neighbours).subspan(static_cast<std::size_t>(c) * n, n));
      worst = std::max(worst, found);
      if (found >= flat) ++count;
    }
    if (count == 0) continue;
    log::warn(
        "{}: found {} cells with \"formulation\" \"full\" that are the whole thickness of a part "
        "and "
        "up to {:.3g} times as long: they lock, so that the part bends some {:.2g} times too "
        "little; allowed where it bends: \"enhanced\"{}, or several shorter cells",
        settings.materials[m].where, count, worst, 1 + 0.35 * worst * worst,
        dim == 3 ? ", \"solid_shell\"" : "");
  }
}

template void warn_of_flat_cells(const FemSettings<2>&, MPI_Comm);
template void warn_of_flat_cells(const FemSettings<3>&, MPI_Comm);

}  // namespace gabion::fem
