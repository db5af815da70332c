// SPDX-License-Identifier: BSD-3-Clause
#include "fem_solver/flat_cells.hpp"

#include <algorithm>
#include <array>
#include <cstdint>
#include <ranges>
#include <vector>

#include "common/base/error.hpp"
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

/// Length of a cell over the thickness of the part that it lies in.
template <int dim>
class Flatness {
 public:
  explicit Flatness(const Mesh<dim>& mesh) : mesh_(mesh), neighbours_(cell_neighbours(mesh)) {}

  /// The largest of the axes of a cell; 0 where the part is thicker than half the length.
  double of(std::int32_t c) const {
    const auto widths = brick_widths(mesh_, c);
    const double length = std::ranges::max(widths);
    double flattest = 0;
    for (int axis = 0; axis < dim; ++axis) {
      const double limit = length / flat;
      double thickness = widths[axis];
      for (const int end : {0, 1}) add_beyond(c, brick_facet(dim, axis, end), limit, thickness);
      if (thickness <= limit) flattest = std::max(flattest, length / thickness);
    }
    return flattest;
  }

 private:
  static constexpr int num_facets = 2 * dim;

  /// Add the widths of the cells in a row beyond a facet of a cell, as far as `limit` [m].
  void add_beyond(std::int32_t c, int facet, double limit, double& thickness) const {
    for (std::int32_t next = neighbour(c, facet); next >= 0 && thickness <= limit;
         next = neighbour(c, facet)) {
      const auto [axis, end] = side_towards(next, c);
      thickness += brick_widths(mesh_, next)[axis];
      c = next;
      facet = brick_facet(dim, axis, 1 - end);
    }
  }
  std::int32_t neighbour(std::int32_t c, int facet) const {
    return neighbours_[static_cast<std::size_t>(c) * num_facets + static_cast<std::size_t>(facet)];
  }
  /// Axis and end of the facet that a cell has in common with a neighbour.
  std::array<int, 2> side_towards(std::int32_t c, std::int32_t other) const {
    for (int axis = 0; axis < dim; ++axis) {
      if (neighbour(c, brick_facet(dim, axis, 0)) == other) return {axis, 0};
      if (neighbour(c, brick_facet(dim, axis, 1)) == other) return {axis, 1};
    }
    throw Error("a cell that is no neighbour of its neighbour");
  }

  const Mesh<dim>& mesh_;
  std::vector<std::int32_t> neighbours_;
};

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
  const Flatness<dim> flatness(mesh);
  for (std::size_t m = 0; m < cells.size(); ++m) {
    if (!is_full(settings.materials[m])) continue;
    double worst = 0;
    std::size_t count = 0;
    for (const std::int32_t c : cells[m]) {
      const double found = flatness.of(c);
      worst = std::max(worst, found);
      if (found >= flat) ++count;
    }
    if (count == 0) continue;
    log::warn(
        "{}: found {} cells with \"formulation\" \"full\" that are up to {:.3g} times as long as "
        "their "
        "part is thick: they lock, so that it bends some {:.2g} times too little; allowed where it "
        "bends: \"enhanced\"{}, or shorter cells",
        settings.materials[m].where, count, worst, 1 + 0.35 * worst * worst,
        dim == 3 ? ", \"solid_shell\"" : "");
  }
}

template void warn_of_flat_cells(const FemSettings<2>&, MPI_Comm);
template void warn_of_flat_cells(const FemSettings<3>&, MPI_Comm);

}  // namespace gabion::fem
