// SPDX-License-Identifier: BSD-3-Clause
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <cmath>

#include "mpm_solver/grid/surface_values.hpp"
#include "tests/unit/mpm/soil_patch.hpp"

namespace gabion::test::test_surface_values {
namespace {

constexpr int cells = 6, per_cell = 2;
constexpr double h = 1.0 / cells, step = h / per_cell;

/// Points in a regular lattice, 3 cells wide, whose lower corner lies `shift` beyond the node at h.
template <int dim>
void add_block(SoilPatch<dim>& soil, double shift) {
  constexpr int width = 3 * per_cell;
  for (int number = 0; number < std::pow(width, dim); ++number) {
    mpm::NewPoint<dim> point{.id = number, .m = 1, .V0 = std::pow(step, dim)};
    for (int d = 0, rest = number; d < dim; ++d, rest /= width) {
      point.x[d] = h + shift + (rest % width + 0.5) * step;
    }
    point.half_length = Vector<dim>::Constant(step / 2);
    add_point(point, soil.points);
  }
  soil.points.body_starts = {0, soil.points.size()};
  soil.to_grid();
}

/// Nodal forces of the same pressure in all points and on all sides of the block: it is at rest.
template <int dim>
double largest_force(mpm::Basis basis, double shift) {
  SoilPatch<dim> soil(dim == 2 ? CellType::quad4 : CellType::hex8, cells, basis);
  add_block(soil, shift);
  std::vector<Vector<dim>> f(soil.nodes.size(), Vector<dim>::Zero());
  for (const auto& group : soil.weights.groups) {
    const auto nodes = soil.weights.nodes_of(group);
    for (std::int32_t e = group.first; e < group.last; ++e) {
      const std::int32_t p = soil.weights.point[e];
      const int n = soil.weights.num_nodes(e);
      const auto node = [&](int i) {
        return soil.nodes.active[nodes[soil.weights.local_of(e)[i]]];
      };
      for (int i = 0; i < n; ++i) f[node(i)] += soil.points.V0[p] * soil.weights.grad_of(e)[i];
      const mpm::SurfaceValues<dim> surface(soil.grid, soil.points, p);
      for (int d = 0; d < dim; ++d) {
        const double low = soil.points.x[p][d] - step / 2 - h - shift;
        for (const double side : {-1.0, 1.0}) {
          if (std::abs(side < 0 ? low : low + step - 3 * h) > 0.1 * step) continue;
          std::vector<double> w(n);
          surface.at(-side * Vector<dim>::Unit(d), step / 2, w.data());
          for (int i = 0; i < n; ++i) f[node(i)][d] -= side * std::pow(step, dim - 1) * w[i];
        }
      }
    }
  }
  double largest = 0;
  for (const auto& force : f) largest = std::max(largest, force.norm());
  return largest / std::pow(step, dim - 1);
}

TEST(SurfaceValues, pressure_on_all_sides_is_in_balance_wherever_the_grid_lies) {
  for (const auto basis : {mpm::Basis::gimp, mpm::Basis::bspline}) {
    for (const double share : {0.0, 1e-6, 0.01, 0.1, 0.25, 0.3, 0.49, 0.5, 0.51, 0.75, 0.9}) {
      const std::string where = fmt::format("{}, {} of a cell", mpm::basis_name(basis), share);
      EXPECT_LT(largest_force<2>(basis, share * h), 1e-12) << where;
      EXPECT_LT(largest_force<3>(basis, share * h), 1e-12) << where;
    }
  }
}

template <int dim>
void check_moments(mpm::Basis basis) {
  SoilPatch<dim> soil(dim == 2 ? CellType::quad4 : CellType::hex8, cells, basis);
  soil.scatter(40);
  soil.to_grid();
  for (const auto& group : soil.weights.groups) {
    const auto nodes = soil.weights.nodes_of(group);
    for (std::int32_t e = group.first; e < group.last; ++e) {
      const std::int32_t p = soil.weights.point[e];
      const Vector<dim> n = soil.random.template vector<dim>().normalized();
      std::vector<double> w(soil.weights.num_nodes(e));
      Vector<dim> place =
          mpm::SurfaceValues<dim>(soil.grid, soil.points, p).at(n, 0.2 * h, w.data());
      double sum = 0;
      for (std::size_t i = 0; i < w.size(); ++i) {
        sum += w[i];
        place -= w[i] * (soil.mesh.nodes[nodes[soil.weights.local_of(e)[i]]] - soil.points.x[p]);
      }
      EXPECT_NEAR(sum, 1, 1e-13);
      EXPECT_LT(place.norm(), 1e-13) << mpm::basis_name(basis) << ", point " << p;
    }
  }
}

TEST(SurfaceValues, add_up_to_one_and_reproduce_the_place_in_any_direction) {
  for (const auto basis : {mpm::Basis::gimp, mpm::Basis::bspline}) {
    check_moments<2>(basis);
    check_moments<3>(basis);
  }
}

}  // namespace
}  // namespace gabion::test::test_surface_values
