// SPDX-License-Identifier: BSD-3-Clause
#include "fem_solver/flat_cells.hpp"

#include <algorithm>
#include <cstdint>
#include <ranges>
#include <span>
#include <vector>

#include "common/base/log.hpp"
#include "common/mechanics/elements/cell_facets.hpp"
#include "common/mechanics/mesh/boundary.hpp"
#include "common/mechanics/ranks/sum.hpp"
#include "fem_solver/stress/brick_widths.hpp"
#include "fem_solver/stress/cells_of_materials.hpp"

namespace gabion::fem {

namespace {

// Length over thickness from which bending is more than twice too stiff; 2 but for rounding.
constexpr double flat = 2 * (1 - 1e-9);

/// The largest width of a cell over the smallest one.
template <int dim>
double slenderness(const Mesh<dim>& mesh, std::int32_t c) {
  const auto widths = brick_widths(mesh, c);
  return std::ranges::max(widths) / std::ranges::min(widths);
}

/// Length of a cell over its thickness, that of the part; 0: it has neighbours on both sides.
/// @param neighbours  of its facets, see cell_neighbours()
template <int dim>
double flatness(const Mesh<dim>& mesh, std::int32_t c, std::span<const std::int32_t> neighbours) {
  const auto widths = brick_widths(mesh, c);
  double flattest = 0;
  for (int axis = 0; axis < dim; ++axis) {
    const bool is_whole =
        neighbours[brick_facet(dim, axis, 0)] < 0 && neighbours[brick_facet(dim, axis, 1)] < 0;
    if (is_whole) flattest = std::max(flattest, std::ranges::max(widths) / widths[axis]);
  }
  return flattest;
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
  const auto all = std::views::iota(0, mesh.num_cells());
  if (std::ranges::none_of(all, [&](int c) { return slenderness(mesh, c) >= flat; })) return;
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
        "and up to {:.3g} times as long: they lock, so that the part bends some {:.2g} times too "
        "little; allowed where it bends: \"enhanced\"{}, or several shorter cells",
        settings.materials[m].where, count, worst, 1 + 0.35 * worst * worst,
        dim == 3 ? ", \"solid_shell\"" : "");
  }
}

template void warn_of_flat_cells(const FemSettings<2>&, MPI_Comm);
template void warn_of_flat_cells(const FemSettings<3>&, MPI_Comm);

}  // namespace gabion::fem
