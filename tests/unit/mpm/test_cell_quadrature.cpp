// SPDX-License-Identifier: BSD-3-Clause
#include "mpm_solver/stress/cell_quadrature.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <set>

#include "common/mechanics/materials/material.hpp"
#include "mpm_solver/grid/point_inertia.hpp"
#include "mpm_solver/step/stable_step.hpp"
#include "mpm_solver/stress/internal_forces.hpp"
#include "tests/unit/mpm/soil_patch.hpp"

namespace gabion::test::test_cell_quadrature {
namespace {

/// A filled box whose points are moved by up to `shift` of a cell.
template <int dim>
SoilPatch<dim> stirred(CellType type, int points_per_cell, double shift, int cells = 6) {
  SoilPatch<dim> soil(type, cells);
  soil.fill(points_per_cell);
  for (auto& x : soil.points.x) {
    x += shift / cells * soil.random.template vector<dim>();
    x = x.cwiseMax(1e-6).cwiseMin(1 - 1e-6);
  }
  for (double& J : soil.points.J) J = 1 + 0.05 * soil.random();
  soil.to_grid();
  return soil;
}

/// All sides have walls.
template <int dim>
mpm::OpenNodes none_open(const SoilPatch<dim>& soil) {
  return {static_cast<std::size_t>(soil.grid.num_nodes_total()), 0};
}

template <int dim>
std::set<std::int32_t> inside(const SoilPatch<dim>& soil, const mpm::PointWeights<dim>& plain) {
  std::set<std::int32_t> cells;
  for (std::size_t e = 0; e < plain.point.size(); ++e) {
    if (soil.weights.volume[e] != plain.volume[e]) cells.insert(soil.points.cell[plain.point[e]]);
  }
  return cells;
}

/// Equation (S35) holds, and linear fields are still exact.
template <int dim>
void check_cells(CellType type, int points_per_cell) {
  SCOPED_TRACE(name(type));
  SoilPatch<dim> soil = stirred<dim>(type, points_per_cell, 0.1);
  const auto plain = soil.weights;
  mpm::CellQuadrature<dim> quadrature(soil.grid);
  quadrature.correct(none_open(soil), soil.points, soil.nodes, soil.weights);
  const auto cells = inside(soil, plain);
  EXPECT_EQ(std::ssize(cells), quadrature.num_inside());
  EXPECT_GT(std::ssize(cells), soil.grid.num_cells() / 2);
  for (const mpm::CellGroup& group : soil.weights.groups) {
    Vector<dim> corners[max_cell_nodes];
    soil.grid.corners(group.cell, corners);
    double volume = 0;
    Matrix<dim> mean = Matrix<dim>::Zero(), of_cell = Matrix<dim>::Zero();
    for (std::int32_t e = group.first; e < group.last; ++e) {
      const std::int32_t row = soil.weights.constant_gradient ? group.first : e;
      const double V = soil.weights.volume[e] * soil.points.J[soil.weights.point[e]];
      volume += V;
      Matrix<dim> identity = Matrix<dim>::Zero();
      for (int i = 0; i < group.num_nodes; ++i) {
        identity += corners[i] * soil.weights.grad_of(row)[i].transpose();
        // any field, such as |x|^2 in each component
        mean += V * corners[i].squaredNorm() * Vector<dim>::Ones() *
                soil.weights.grad_of(row)[i].transpose();
      }
      EXPECT_LT((identity - Matrix<dim>::Identity()).norm(), 1e-12);
    }
    if (!cells.contains(group.cell)) continue;
    const auto rule = gauss_rule<dim>(type, 3);
    ShapeValues<dim> shape;
    for (const auto& point : rule) {
      shape_functions<dim>(type, point.xi, shape);
      const double dV = point.weight * map_gradients<dim>(type, corners, shape);
      for (int i = 0; i < group.num_nodes; ++i) {
        of_cell += dV * corners[i].squaredNorm() * Vector<dim>::Ones() * shape.dN[i].transpose();
      }
    }
    EXPECT_NEAR(volume, mpm::cell_volume(soil.grid, group.cell), 1e-14);
    EXPECT_LT((mean - of_cell).norm(), 1e-13);
  }
}

TEST(CellQuadrature, points_inside_the_soil_integrate_like_their_cell) {
  check_cells<2>(CellType::quad4, 4);
  check_cells<2>(CellType::tri3, 6);
  check_cells<3>(CellType::hex8, 8);
  check_cells<3>(CellType::tet4, 4);
}

/// Cells at a side are inside only where a wall at rest closes it.
TEST(CellQuadrature, takes_sides_without_a_wall_for_the_border) {
  SoilPatch<2> soil(CellType::quad4, 4);
  soil.fill(4);
  soil.to_grid();
  const auto num_inside = [&](const std::vector<mpm::WallSettings>& walls) {
    mpm::CellQuadrature<2> quadrature(soil.grid);
    quadrature.correct(mpm::open_nodes(soil.grid, walls), soil.points, soil.nodes, soil.weights);
    return quadrature.num_inside();
  };
  mpm::WallSettings left, bottom, moving;
  left.group = "left";
  bottom.group = "bottom";
  moving.group = "right";
  moving.motion.velocity = {0.1, 0};
  EXPECT_EQ(num_inside({}), 2 * 2);
  EXPECT_EQ(num_inside({left, moving}), 3 * 2);
  EXPECT_EQ(num_inside({left, bottom}), 3 * 3);
}

/// Six columns, the last one empty; another body from the fifth row on, which sank into the fourth.
TEST(CellQuadrature, leaves_the_border_and_cells_of_two_bodies) {
  SoilPatch<2> soil(CellType::quad4, 6);
  soil.fill(4);
  soil.points.body_starts = {0, 4 * 6 * 4, 6 * 6 * 4};
  for (std::int32_t p = 0; p < soil.points.size(); ++p) {
    Vector<2>& x = soil.points.x[p];
    if (x[0] > 5.0 / 6) x[0] -= 1.0 / 6;
    if (p >= 4 * 6 * 4) x[1] -= 0.05;
  }
  soil.to_grid();
  const auto plain = soil.weights;
  mpm::CellQuadrature<2> quadrature(soil.grid);
  quadrature.correct(none_open(soil), soil.points, soil.nodes, soil.weights);
  EXPECT_EQ(quadrature.num_inside(), 4 * 5);
  for (std::size_t e = 0; e < plain.point.size(); ++e) {
    const Vector<2>& x = soil.points.x[plain.point[e]];
    const bool half_full = x[0] < 4.0 / 6 && x[1] > 5.0 / 6;  // and inside
    EXPECT_NEAR(soil.weights.volume[e], (half_full ? 2 : 1) * plain.volume[e], 1e-15);
  }

  for (std::int32_t p = 0; p < 4; ++p) soil.points.V0[p] *= 0.9 * mpm::least_filling;
  soil.to_grid();
  quadrature.correct(none_open(soil), soil.points, soil.nodes, soil.weights);
  EXPECT_EQ(quadrature.num_inside(), 4 * 5 - 4);  // that of these points and those around it
}

template <int dim>
mpm::StressParts<dim> parts_of(const SoilPatch<dim>& soil, mpm::TrialPoints<dim>& trial) {
  return {.bodies = soil.bodies,
          .points = soil.points,
          .weights = soil.weights,
          .nodes = soil.nodes,
          .trial = trial};
}

/// Forces of a constant stress on nodes whose cells are all inside.
template <int dim>
double largest_inner_force(SoilPatch<dim>& soil) {
  soil.bodies = {{"soil", {"", 1, LinearElastic<dim>(1, 0.2)}}};
  Symmetric<dim> tau = Symmetric<dim>::Zero();
  tau.template head<dim>().setConstant(-1);
  for (std::int32_t p = 0; p < soil.points.size(); ++p) soil.points.tau[p] = soil.points.J[p] * tau;
  mpm::TrialPoints<dim> trial;
  const mpm::InternalForces<dim> forces(parts_of(soil, trial), 1.0 / 6, 0);
  const auto f = forces.start_forces();
  double largest = 0;
  for (std::int32_t i = 0; i < soil.nodes.size(); ++i) {
    const Vector<dim>& x = soil.nodes.x[i];
    if (x.minCoeff() < 0.01 || x.maxCoeff() > 0.99) continue;
    largest = std::max(largest, Eigen::Map<const Vector<dim>>(&f[i * dim]).norm());
  }
  return largest;
}

TEST(CellQuadrature, a_constant_stress_pushes_no_node) {
  const auto check = [](auto soil) {
    const double plain = largest_inner_force(soil);
    EXPECT_GT(plain, 1e-3);
    mpm::CellQuadrature quadrature(soil.grid);
    quadrature.correct(none_open(soil), soil.points, soil.nodes, soil.weights);
    EXPECT_LT(largest_inner_force(soil), 1e-14);
  };
  check(stirred<2>(CellType::quad4, 9, 0.2));
  check(stirred<2>(CellType::tri3, 12, 0.1));
  check(stirred<3>(CellType::hex8, 27, 0.2));
}

/// Highest frequency of the points on their nodes, squared, by power iteration.
template <int dim>
double squared_frequency(const SoilPatch<dim>& soil) {
  constexpr double small = 1e-6;
  mpm::TrialPoints<dim> trial;
  mpm::InternalForces<dim> forces(parts_of(soil, trial), 1.0 / 6, 0);
  const mpm::PointInertia<dim> inertia(soil.points, soil.weights, soil.nodes);
  std::vector<double> u(soil.num_dofs(), 0.0), a(u.size());
  Random random;
  for (double& x : u) x = random();
  double rate = 0;
  for (int k = 0; k < 300; ++k) {
    double size = 0;
    for (const double x : u) size += x * x;
    for (double& x : u) x *= small / std::sqrt(size);
    mpm::RefusedPoint worst;
    EXPECT_TRUE(forces.evaluate(u, nullptr, worst));
    inertia.apply(forces.forces(), a);
    rate = 0;
    for (std::size_t i = 0; i < u.size(); ++i) rate += u[i] * a[i] / (small * small);
    u = a;
  }
  return rate;
}

/// A step that is stable without it is so with it.
template <int dim>
void check_frequency(CellType type, int points_per_cell) {
  SCOPED_TRACE(name(type));
  const LinearElastic<dim> law(1, dim == 2 ? 0.45 : 0.3);
  for (const double shift : {0.05, 0.2, 0.4, 0.8, 1.6}) {
    SoilPatch<dim> soil = stirred<dim>(type, points_per_cell, shift);
    soil.bodies = {{"soil", {"", 1, law}}};
    for (std::int32_t p = 0; p < soil.points.size(); ++p) soil.points.m[p] = soil.points.V0[p];
    mpm::CellQuadrature<dim> quadrature(soil.grid);
    quadrature.correct(none_open(soil), soil.points, soil.nodes, soil.weights);
    EXPECT_GT(quadrature.num_inside(), 0);
    const double limit = 4 * law.p_wave_modulus() / std::pow(mpm::effective_size(soil.grid, 0), 2);
    EXPECT_LT(squared_frequency(soil), 0.7 * limit) << shift;
  }
}

TEST(CellQuadrature, leaves_explicit_steps_stable) {
  check_frequency<2>(CellType::quad4, 4);
  check_frequency<2>(CellType::tri3, 3);
  check_frequency<3>(CellType::hex8, 8);
}

}  // namespace
}  // namespace gabion::test::test_cell_quadrature
