// SPDX-License-Identifier: BSD-3-Clause
// What is computed once of the cells of a block: gradients, weights, enhancing modes, shells.
#include <fmt/format.h>
#include <fmt/ranges.h>

#include <utility>

#include "common/base/require.hpp"
#include "common/mechanics/elements/shape_functions.hpp"
#include "fem_solver/stress/cell_block.hpp"
#include "fem_solver/stress/crack_bands.hpp"
#include "fem_solver/stress/thickness_axes.hpp"

namespace gabion::fem {

namespace {

/// Degree that integrates the stiffness of an undistorted cell exactly; reduced integration has one
/// point less along each axis.
int stiffness_degree(CellType type, Formulation formulation) {
  if (is_simplex(type)) return is_quadratic(type) ? 2 : 1;
  return is_quadratic(type) && formulation != Formulation::reduced ? 5 : 3;
}

}  // namespace

template <int dim>
CellBlock<dim>::CellBlock(const Mesh<dim>& mesh, const CellMaterial<dim>& material,
                          std::vector<std::int32_t> cells, const MeshRanks& ranks)
    : material_(material),
      cells_(std::move(cells)),
      nodes_per_cell_(mesh.nodes_per_cell()),
      history_per_point_(static_cast<std::size_t>(fem::history_size<dim>(material.law))) {
  for (const std::int32_t c : cells_) {
    const auto nodes = mesh.cell(c);
    cell_nodes_.insert(cell_nodes_.end(), nodes.begin(), nodes.end());
  }
  if constexpr (dim == 3) {
    if (is_shell()) {
      const int across = yields() ? yielding_points_across : elastic_points_across;
      for (int axis = 0; axis < 3; ++axis) shells_.rules.emplace_back(axis, across);
      shells_.axes = thickness_axes(mesh, material_, cells_, ranks);
    }
  }
  compute_geometry(mesh, ranks);
  bands_ = crack_bands<dim>(mesh, material_, cells_, ranks);
  history_width_ = history_per_point_ * static_cast<std::size_t>(points_per_cell_) +
                   (is_shell()      ? num_shell_modes
                    : is_enhanced() ? num_modes<dim>
                                    : 0) +
                   (may_fail() ? failure_numbers : 0);
}

template <int dim>
void CellBlock<dim>::compute_geometry(const Mesh<dim>& mesh, const MeshRanks& ranks) {
  auto rule =
      gauss_rule<dim>(mesh.cell_type, stiffness_degree(mesh.cell_type, material_.formulation));
  const std::size_t n = static_cast<std::size_t>(nodes_per_cell_);
  AnyShapeValues<dim> shape;
  Vector<dim> x[max_quadratic_nodes];
  for (std::size_t k = 0; k < cells_.size(); ++k) {
    const std::int32_t c = cells_[k];
    for (int a = 0; a < nodes_per_cell_; ++a) x[a] = mesh.nodes[mesh.cell(c)[a]];
    if constexpr (dim == 3) {
      if (is_shell()) rule = shells_.rule(k).points;
    }
    for (const auto& q : rule) {
      shape_functions<dim>(mesh.cell_type, q.xi, shape);
      const double jacobian = map_gradients<dim>(mesh.cell_type, x, shape);
      require<ConfigError>(jacobian > 0,
                           "mesh: cell {} has the Jacobian {:.3g} at a quadrature "
                           "point near ({:.6g}); allowed: convex cells of positive volume",
                           ranks.cell_of_all(c), jacobian,
                           fmt::join(x[0].data(), x[0].data() + dim, ", "));
      weights_.push_back(q.weight * jacobian);
      gradients_.insert(gradients_.end(), shape.dN, shape.dN + nodes_per_cell_);
    }
    if constexpr (dim == 3) {
      if (is_shell()) {
        shells_.shapes.push_back(shell_shape(shells_.rule(k), shells_.axes[k], {x, n}));
        continue;
      }
    }
    if (!is_enhanced()) continue;
    const auto modes = enhancing_modes<dim>({x, n}, rule);
    modes_.insert(modes_.end(), modes.begin(), modes.end());
  }
  points_per_cell_ = static_cast<int>(rule.size());
}

template CellBlock<2>::CellBlock(const Mesh<2>&, const CellMaterial<2>&, std::vector<std::int32_t>,
                                 const MeshRanks&);
template CellBlock<3>::CellBlock(const Mesh<3>&, const CellMaterial<3>&, std::vector<std::int32_t>,
                                 const MeshRanks&);

}  // namespace gabion::fem
