// SPDX-License-Identifier: BSD-3-Clause
#include "fem_solver/stress/cell_geometry.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <variant>

#include "common/base/require.hpp"
#include "common/mechanics/elements/shape_functions.hpp"
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
CellGeometry<dim> cell_geometry(const Mesh<dim>& mesh, const CellMaterial<dim>& material,
                                std::span<const std::int32_t> cells, const MeshRanks& ranks) {
  CellGeometry<dim> g;
  const int nodes = mesh.nodes_per_cell();
  const bool is_shell = material.formulation == Formulation::solid_shell;
  if constexpr (dim == 3) {
    if (is_shell) {
      const bool yields = std::holds_alternative<VonMises<dim>>(material.law);
      const int across = yields ? yielding_points_across : elastic_points_across;
      for (int axis = 0; axis < 3; ++axis) g.shells.rules.emplace_back(axis, across);
      g.shells.axes = thickness_axes(mesh, material, cells, ranks);
    }
  }
  auto rule =
      gauss_rule<dim>(mesh.cell_type, stiffness_degree(mesh.cell_type, material.formulation));
  if constexpr (dim == 3) {
    if (is_shell) rule = g.shells.rules[0].points;  // of ranks without such cells too
  }
  const std::size_t n = static_cast<std::size_t>(nodes);
  AnyShapeValues<dim> shape;
  Vector<dim> x[max_quadratic_nodes];
  for (std::size_t k = 0; k < cells.size(); ++k) {
    const std::int32_t c = cells[k];
    for (int a = 0; a < nodes; ++a) x[a] = mesh.nodes[mesh.cell(c)[a]];
    if constexpr (dim == 3) {
      if (is_shell) rule = g.shells.rule(k).points;
    }
    for (const auto& q : rule) {
      shape_functions<dim>(mesh.cell_type, q.xi, shape);
      const double jacobian = map_gradients<dim>(mesh.cell_type, x, shape);
      require<ConfigError>(jacobian > 0,
                           "mesh: cell {} has the Jacobian {:.3g} at a quadrature "
                           "point near ({:.6g}); allowed: convex cells of positive volume",
                           ranks.cell_of_all(c), jacobian,
                           fmt::join(x[0].data(), x[0].data() + dim, ", "));
      g.weights.push_back(q.weight * jacobian);
      g.gradients.insert(g.gradients.end(), shape.dN, shape.dN + nodes);
    }
    if constexpr (dim == 3) {
      if (is_shell) {
        g.shells.shapes.push_back(shell_shape(g.shells.rule(k), g.shells.axes[k], {x, n}));
        continue;
      }
    }
    if (material.formulation != Formulation::enhanced) continue;
    const auto modes = enhancing_modes<dim>({x, n}, rule);
    g.modes.insert(g.modes.end(), modes.begin(), modes.end());
  }
  g.points_per_cell = static_cast<int>(rule.size());
  return g;
}

template CellGeometry<2> cell_geometry(const Mesh<2>&, const CellMaterial<2>&,
                                       std::span<const std::int32_t>, const MeshRanks&);
template CellGeometry<3> cell_geometry(const Mesh<3>&, const CellMaterial<3>&,
                                       std::span<const std::int32_t>, const MeshRanks&);

}  // namespace gabion::fem
