// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include <Eigen/Eigenvalues>

#include "mpm_solver/small_cuts/ghost_stiffness.hpp"
#include "tests/unit/mpm/mpm_scene.hpp"
#include "tests/unit/mpm/soil_patch.hpp"

namespace gabion::test::test_small_cuts {
namespace {

constexpr double E = 1000, factor = 0.05;

/// Soil that fills some cells of a grid to a small share.
template <int dim>
struct CutSoil {
  SoilPatch<dim> soil;
  std::optional<mpm::GhostStiffness<dim>> ghost;
  BlockMatrix<dim> K;

  CutSoil(CellType type, int cells) : soil(type, cells) {
    soil.bodies = {{"soil", {"", 1, NeoHookean<dim>{0, E / 2}}}};
  }
  void begin() {
    soil.to_grid();
    ghost.emplace(soil.grid, soil.bodies, factor);
    ghost->find_facets(soil.owners(), soil.points, soil.weights);
    ghost->begin_step(soil.nodes);
    std::vector<std::int32_t> offsets{0}, nodes;
    ghost->append_cells(offsets, nodes);
    K.set_pattern(soil.nodes.size(), offsets, nodes);
    K.set_zero();
  }
  std::vector<double> forces(const std::vector<double>& du) {
    std::vector<double> r(soil.num_dofs(), 0.0);
    ghost->add_forces(du, r, &K);
    return r;
  }
  double work(const std::vector<double>& du) {
    const auto f = forces(du);
    double sum = 0;
    for (std::size_t k = 0; k < f.size(); ++k) sum += f[k] * du[k];
    return sum;
  }
};

/// Few points, each with a fifth of a cell: every cell with points is a small cut.
template <int dim>
struct SparseSoil : CutSoil<dim> {
  explicit SparseSoil(CellType type) : CutSoil<dim>(type, 3) {
    this->soil.scatter(dim == 2 ? 20 : 60);
    for (double& V0 : this->soil.points.V0) V0 = 0.03 * std::pow(1.0 / 3, dim);
    this->begin();
    EXPECT_GT(this->ghost->num_facets(), 3);
  }
};

TEST(GhostStiffness, no_force_on_linear_fields) {
  for_each_cell_type([]<int dim>(CellType type) {
    SparseSoil<dim> cut(type);
    Matrix<dim> slope;
    for (int d = 0; d < dim; ++d) slope.col(d) = cut.soil.random.template vector<dim>();
    std::vector<double> du;
    for (std::int32_t i = 0; i < cut.soil.nodes.size(); ++i) {
      const Vector<dim> u = Vector<dim>::Constant(0.3) + slope * cut.soil.node(i);
      du.insert(du.end(), u.data(), u.data() + dim);
    }
    for (const double f : cut.forces(du)) EXPECT_NEAR(f, 0, 1e-12 * E) << name(type);
  });
}

/// No resultant, no moment about the positions at the start and at the end, and no energy made.
TEST(GhostStiffness, keeps_momentum_and_takes_energy) {
  for_each_cell_type([]<int dim>(CellType type) {
    SparseSoil<dim> cut(type);
    const auto du = cut.soil.random.values(cut.soil.num_dofs(), 0.1);
    const auto f = cut.forces(du);
    ForceAndMoment<dim> start, end;
    for (std::int32_t i = 0; i < cut.soil.nodes.size(); ++i) {
      const Eigen::Map<const Vector<dim>> f_i(f.data() + i * dim), du_i(du.data() + i * dim);
      start.add(cut.soil.node(i), f_i);
      end.add(cut.soil.node(i) + du_i, f_i);
    }
    EXPECT_GT(start.size, 1e-3 * E) << name(type);
    EXPECT_LT(start.force.norm(), 1e-13 * start.size) << name(type);
    EXPECT_LT(start.moment.norm(), 1e-13 * start.size) << name(type);
    EXPECT_LT(end.moment.norm(), 1e-13 * end.size) << name(type);
    EXPECT_LT(cut.work(du), -1e-6 * E) << name(type);
  });
}

/// r is linear in du: the matrix applied to du gives it back to the bit of rounding.
TEST(GhostStiffness, matrix_is_the_derivative_of_the_force) {
  for_each_cell_type([]<int dim>(CellType type) {
    SparseSoil<dim> cut(type);
    const auto du = cut.soil.random.values(cut.soil.num_dofs(), 1);
    const auto f = cut.forces(du);
    std::vector<double> product(f.size());
    cut.K.multiply(du, product);
    for (std::size_t k = 0; k < f.size(); ++k) EXPECT_NEAR(product[k], -f[k], 1e-12 * E);
  });
}

/// du = max(0, s) d with s the distance from the facet and |d| = 1 has a jump of 1 in its normal
/// slope: energy factor E h / 3 times the area of the facet.
template <int dim>
void check_kink(CellType type, int cells, const Vector<dim>& normal, double offset, double h,
                double area) {
  CutSoil<dim> cut(type, cells);
  cut.soil.fill(type == CellType::tri3 || type == CellType::tet4 ? 1 : 1 << dim);
  for (double& V0 : cut.soil.points.V0) V0 *= 0.5;
  cut.begin();
  std::vector<double> du;
  const Vector<dim> d = Vector<dim>::Ones().normalized();
  for (std::int32_t i = 0; i < cut.soil.nodes.size(); ++i) {
    const Vector<dim> u = std::max(0.0, normal.dot(cut.soil.node(i)) - offset) * d;
    du.insert(du.end(), u.data(), u.data() + dim);
  }
  EXPECT_NEAR(cut.work(du), -factor * E * h / 3 * area, 1e-12 * E) << name(type);
}

TEST(GhostStiffness, energy_of_a_kink) {
  check_kink<2>(CellType::quad4, 2, {1, 0}, 0.5, 0.5, 1);
  check_kink<3>(CellType::hex8, 2, {0, 1, 0}, 0.5, 0.5, 1);
  const double across = std::sqrt(0.5);
  const auto mesh = unit_box<2>(CellType::tri3, 1);
  const auto diagonal = mesh.cell(0);
  const bool rises = std::find(diagonal.begin(), diagonal.end(), 0) != diagonal.end() &&
                     std::find(diagonal.begin(), diagonal.end(), 3) != diagonal.end();
  const Vector<2> normal = rises ? Vector<2>(across, -across) : Vector<2>(across, across);
  check_kink<2>(CellType::tri3, 1, normal, rises ? 0 : across, across, std::sqrt(2));
}

TEST(GhostStiffness, nothing_to_do_where_cells_are_full) {
  for_each_cell_type([]<int dim>(CellType type) {
    CutSoil<dim> cut(type, 2);
    cut.soil.fill(type == CellType::hex8 ? 8 : type == CellType::tri3 ? 3 : 4);
    cut.begin();
    EXPECT_EQ(cut.ghost->num_facets(), 0) << name(type);
    for (double& J : cut.soil.points.J) J = 0.59;
    cut.begin();
    EXPECT_GT(cut.ghost->num_facets(), 0) << name(type);
  });
}

/// Stiffness of a block of 4 x 2 cells with one point above it, of a quarter of a cell, whose lower
/// side is held.
Eigen::MatrixXd stiffness_below(const Vector<2>& lone_point, bool with_ghost) {
  CutSoil<2> cut(CellType::quad4, 4);
  auto& soil = cut.soil;
  lay_points<2>(
      {box_mesh<2>({0.0, 0.0}, {1.0, 0.5}, {4, 2}, CellType::quad4), 4, Vector<2>::Zero()}, 1, {},
      soil.points);
  soil.add(lone_point);
  soil.points.V0.back() = 1.0 / 64;
  cut.begin();
  std::vector<std::int32_t> offsets{0}, nodes;
  for (const auto& group : soil.weights.groups) {
    for (const auto node : soil.weights.nodes_of(group)) nodes.push_back(soil.nodes.active[node]);
    offsets.push_back(static_cast<std::int32_t>(nodes.size()));
  }
  cut.ghost->append_cells(offsets, nodes);
  cut.K.set_pattern(soil.nodes.size(), offsets, nodes);
  mpm::TrialPoints<2> trial;
  mpm::InternalForces<2> internal({soil.bodies, soil.points, soil.weights, soil.nodes, trial}, 0.25,
                                  0);
  const std::vector<double> still(soil.num_dofs(), 0.0);
  std::vector<double> r(still);
  mpm::RefusedPoint worst;
  EXPECT_TRUE(internal.evaluate(still, &cut.K, worst));
  if (with_ghost) cut.ghost->add_forces(still, r, &cut.K);
  const auto n = static_cast<Eigen::Index>(soil.num_dofs());
  Eigen::MatrixXd K(n, n);
  std::vector<Eigen::Index> free;
  for (Eigen::Index k = 0; k < n; ++k) {
    const Eigen::VectorXd unit = Eigen::VectorXd::Unit(n, k);
    cut.K.multiply({unit.data(), static_cast<std::size_t>(n)},
                   {K.col(k).data(), static_cast<std::size_t>(n)});
    if (soil.node(static_cast<std::int32_t>(k / 2))[1] > 0) free.push_back(k);
  }
  return K(free, free);
}

/// Condition number of the matrix scaled by its diagonal, as a Krylov method with Jacobi's
/// preconditioner sees it.
double condition_number(const Eigen::MatrixXd& K) {
  const Eigen::VectorXd scale = K.diagonal().cwiseSqrt().cwiseInverse();
  const Eigen::VectorXd values =
      Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd>(scale.asDiagonal() * K * scale.asDiagonal())
          .eigenvalues();
  return values.maxCoeff() / std::max(values.minCoeff(), 1e-16);
}

/// A point that rises out of a surface leaves a mechanism in its cell, at any height.
TEST(GhostStiffness, condition_number_stays_bounded_while_a_point_is_swept_through_its_cell) {
  for (int k = 0; k < 20; ++k) {
    const Vector<2> lone_point(0.37, 0.5 + 0.25 * (k + 1e-3) / 20);
    EXPECT_GT(condition_number(stiffness_below(lone_point, false)), 1e12) << k;
    EXPECT_LT(condition_number(stiffness_below(lone_point, true)), 500) << k;
  }
}

/// Two blocks that meet obliquely across cells.
Json cut_collision(const Json& small_cuts, const std::string& basis) {
  const Json soft = elastic_soil("linear_elastic", 1e3, 0.2, 1);
  return {{"dimension", 2},
          {"grid", box({0, 0}, {4, 2}, {16, 8}, "quad4")},
          {"basis", basis},
          {"bodies",
           {body("left", box({0.5, 0.5}, {1.5, 1.5}, {8, 8}, "quad4"), 4, soft, {2, 0.1}),
            body("right", box({2.0, 0.6}, {3.0, 1.6}, {8, 8}, "quad4"), 4, soft, {-1, 0.3})}},
          {"newton", exact_newton},
          {"small_cuts", small_cuts},
          {"time_integration", trapezoid}};
}

void check_collision(const std::string& method, const std::string& basis) {
  SCOPED_TRACE(method + " " + basis);
  Json cuts = {{"method", method}};
  if (method == "mass_cutoff") cuts["mass_share"] = 0.01;
  const auto solver = mpm_solver<2>(cut_collision(cuts, basis));
  const double energy = probe(*solver, "kinetic_energy");
  run_steps(*solver, 0.01, 40);
  const double bound = basis == "gimp" ? 1e-7 : 4e-12;  // mass floor where domains hardly reach
  EXPECT_NEAR(probe(*solver, "momentum_x"), 2 - 1, bound);
  EXPECT_NEAR(probe(*solver, "momentum_y"), 0.4, bound);
  EXPECT_LT(probe(*solver, "kinetic_energy") + probe(*solver, "elastic_energy"), 1.001 * energy);
  EXPECT_NEAR(probe(*solver, "energy_balance"), 0, 1e-11 * energy);
  const Json summary = solver->summary().at("small_cuts");
  EXPECT_EQ(summary.at("method"), method);
  if (method == "ghost") {
    EXPECT_GT(summary.at("facets"), 100);
  }
  EXPECT_EQ(summary.at("joined_nodes") > 10, method == "mass_cutoff");
}

TEST(SmallCuts, every_method_conserves_momentum_and_makes_no_energy) {
  for (const std::string basis : {"linear", "gimp"}) {
    for (const char* method : {"none", "ghost", "mass_cutoff"}) check_collision(method, basis);
  }
}

}  // namespace
}  // namespace gabion::test::test_small_cuts
