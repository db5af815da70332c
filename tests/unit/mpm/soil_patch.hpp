// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cmath>
#include <optional>
#include <random>
#include <vector>

#include "common/mechanics/petsc/block_matrix.hpp"
#include "mpm_solver/grid/cell_owners.hpp"
#include "mpm_solver/grid/grid_nodes.hpp"
#include "mpm_solver/grid/soil_border.hpp"
#include "mpm_solver/grid/transfer.hpp"
#include "tests/support/mpi_main.hpp"

namespace gabion::test {

/// Numbers in [-1, 1), the same on every platform.
class Random {
 public:
  double operator()() { return 2.0 * static_cast<double>(engine_()) / 4294967296.0 - 1.0; }
  template <int dim>
  Vector<dim> vector() {
    Vector<dim> v;
    for (int d = 0; d < dim; ++d) v[d] = (*this)();
    return v;
  }
  std::vector<double> values(std::size_t n, double size) {
    std::vector<double> result(n);
    for (double& value : result) value = size * (*this)();
    return result;
  }

 private:
  std::mt19937 engine_{20260};
};

template <int dim>
Mesh<dim> unit_box(CellType type, int cells, double size = 1) {
  return box_mesh<dim>(Vector<dim>::Zero(), Vector<dim>::Constant(size),
                       Eigen::Matrix<int, dim, 1>::Constant(cells), type);
}

/// A unit box as background grid, and one body of material points in it.
template <int dim>
struct SoilPatch {
  Mesh<dim> mesh;
  mpm::BackgroundGrid<dim> grid;  ///< of this mesh
  std::vector<mpm::Body<dim>> bodies;
  mpm::MaterialPoints<dim> points;
  mpm::PointWeights<dim> weights;
  mpm::GridNodes<dim> nodes;
  Partition<dim> whole;  ///< one rank has all
  Random random;

  explicit SoilPatch(CellType type, int cells = 3, mpm::Basis basis = mpm::Basis::linear)
      : mesh(unit_box<dim>(type, cells)), grid(mesh, basis) {}

  /// Fill the grid with the regular points of each cell.
  void fill(int points_per_cell, double density = 1) {
    const bool with_domains = grid.basis == mpm::Basis::gimp;
    lay_points<dim>({.mesh = mesh,
                     .points_per_cell = points_per_cell,
                     .placement = with_domains ? PointPlacement::regular : PointPlacement::gauss,
                     .with_domains = with_domains},
                    density, {}, points);
  }
  /// `count` points at random places with random mass, velocity and acceleration.
  void scatter(int count) {
    points.body_starts = {0, 0};
    for (int p = 0; p < count; ++p) add(0.5 * (random.vector<dim>() + Vector<dim>::Ones()));
  }
  void add(const Vector<dim>& x) {
    const double m = 2 + random();
    mpm::NewPoint<dim> point{.id = points.size(), .x = x, .m = m, .V0 = m};
    point.v = random.vector<dim>();
    const Vector<dim> acceleration = random.vector<dim>();
    if (grid.basis == mpm::Basis::gimp) {
      point.half_length =
          grid.box->spacing.cwiseProduct(0.3 * Vector<dim>::Ones() + 0.19 * random.vector<dim>());
    }
    add_point(point, points);
    points.a.back() = acceleration;
    if (points.body_starts.empty()) points.body_starts = {0, 0};
    points.body_starts.back() = points.size();
  }
  void to_grid() {
    if (!find_cells(grid, points).empty()) throw Error("a material point lies outside the grid");
    std::optional<mpm::SoilBorder<dim>> border;
    if (grid.splits_border) border.emplace(owners(), cells_with_points(grid, points));
    evaluate_basis(grid, points, weights, border ? &*border : nullptr);
    activate_nodes<dim>(comm(), grid, weights, {}, nodes);
    points_to_grid(points, weights, nodes);
  }
  /// The pattern of the groups of the points.
  void set_pattern(BlockMatrix<dim>& K) const {
    std::vector<std::int32_t> offsets = {0}, active;
    for (const auto& group : weights.groups) {
      for (const std::int32_t node : weights.nodes_of(group)) active.push_back(nodes.active[node]);
      offsets.push_back(static_cast<std::int32_t>(active.size()));
    }
    K.set_pattern(nodes.size(), offsets, active);
  }
  mpm::CellOwners<dim> owners() const { return {comm(), grid, whole}; }
  const Vector<dim>& node(std::int32_t active) const { return mesh.nodes[nodes.grid_node[active]]; }
  mpm::SparseList<char> occupied() const { return cells_with_points(grid, points); }
  std::size_t num_dofs() const { return static_cast<std::size_t>(nodes.size()) * dim; }
};

/// x ^ f: in 2D the third component only.
template <int dim>
auto cross(const Vector<dim>& x, const Vector<dim>& f) {
  if constexpr (dim == 2) {
    return Vector<1>(x[0] * f[1] - x[1] * f[0]);
  } else {
    return Vector<3>(x[1] * f[2] - x[2] * f[1], x[2] * f[0] - x[0] * f[2],
                     x[0] * f[1] - x[1] * f[0]);
  }
}

/// Resultant force and moment about the origin.
template <int dim>
struct ForceAndMoment {
  Vector<dim> force = Vector<dim>::Zero();
  Vector<dim == 2 ? 1 : 3> moment = Vector < dim == 2 ? 1 : 3 > ::Zero();
  double size = 0;  // sum of |f|

  void add(const Vector<dim>& x, const Vector<dim>& f) {
    force += f;
    moment += cross<dim>(x, f);
    size += f.norm();
  }
};

/// Call check<dim>(type) for each cell type.
template <class Check>
void for_each_cell_type(const Check& check) {
  check.template operator()<2>(CellType::tri3);
  check.template operator()<2>(CellType::quad4);
  check.template operator()<3>(CellType::tet4);
  check.template operator()<3>(CellType::hex8);
}

/// Call check<dim>(type, basis) for the linear basis on each cell type and for the others.
template <class Check>
void for_each_basis(const Check& check) {
  for_each_cell_type(
      [&]<int dim>(CellType type) { check.template operator()<dim>(type, mpm::Basis::linear); });
  for (const mpm::Basis basis : {mpm::Basis::gimp, mpm::Basis::bspline}) {
    check.template operator()<2>(CellType::quad4, basis);
    check.template operator()<3>(CellType::hex8, basis);
  }
}

}  // namespace gabion::test
