// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include <Eigen/Eigenvalues>
#include <cmath>
#include <numbers>
#include <random>

#include "tests/support/check_tangent.hpp"
#include "tests/unit/fem/line_scene.hpp"

namespace gabion::test::test_line_cells {
namespace {

using Eigen::MatrixXd;
using Eigen::VectorXd;

template <int dim>
fem::CellIntegrals<dim> integrals(const fem::FemSettings<dim>& settings) {
  return {settings.mesh, settings.materials, settings.lumped_mass, {}, {settings.line_materials}};
}

template <int dim>
MatrixXd dense(const BlockMatrix<dim>& K) {
  const int n = K.num_nodes() * dim;
  MatrixXd result(n, n);
  for (int i = 0; i < n; ++i) {
    std::vector<double> x(n, 0.0), y(n, 0.0);
    x[i] = 1;
    K.multiply(x, y);
    result.col(i) = Eigen::Map<VectorXd>(y.data(), n);
  }
  return result;
}

template <int dim>
void expect_exact_tangent(const Json& material) {
  SCOPED_TRACE(material.dump());
  LineText text = chain(3, 3);
  const TemporaryMesh mesh(text.file());
  const auto settings = fem_settings<dim>(line_scene(dim, mesh.path(), material));
  const auto cells = integrals(settings);
  std::mt19937 random(7);
  std::uniform_real_distribution<double> shift(-0.4, 0.4);
  VectorXd u(4 * dim);
  for (double& x : u) x = shift(random);
  const std::vector<double> history(cells.history_size(), 0.05);
  std::vector<double> trial(history.size());
  const fem::HistoryStep step{.accepted = history, .trial = trial};
  const auto force = [&](const VectorXd& at) {
    VectorXd f = VectorXd::Zero(u.size());
    cells.add_internal({at.data(), static_cast<std::size_t>(at.size())},
                       {f.data(), static_cast<std::size_t>(f.size())}, nullptr, step);
    return f;
  };
  BlockMatrix<dim> K;
  cells.set_pattern(K);
  K.set_zero();
  std::vector<double> f(u.size());
  const auto sum = cells.add_internal({u.data(), static_cast<std::size_t>(u.size())}, f, &K, step);
  EXPECT_GT(sum.energy, 0);
  EXPECT_LT(tangent_error(force, u, dense(K), 1e-4), 1e-9);
}

TEST(LineCells, tangent_against_differences) {
  Json truss = line_material("truss", 1e5, 0.01), cable = line_material("cable", 1e5, 0.01),
       brake = line_material("brake", 1e5, 0.01);
  cable["length_ratio"] = 0.9;
  brake["brake_table"] = {{0, 50}, {0.1, 120}, {0.3, 90}};
  for (const Json& material : {truss, cable, brake}) {
    expect_exact_tangent<2>(material);
    expect_exact_tangent<3>(material);
  }
}

/// Two bars of half span 1 and rise 0.2 pushed through: P = -2 N (h - w) / l, N = E A (l - L) / L.
TEST(LineCells, two_bars_snap_through) {
  LineText text{.nodes = {{-1, 0, 0}, {0, 0.2, 0}, {1, 0, 0}},
                .lines = {{"rope", {{1, 2}, {2, 3}}}},
                .points = {{"feet", {1, 3}}, {"top", {2}}}};
  const TemporaryMesh mesh(text.file());
  Json json = line_scene(2, mesh.path(), line_material("truss", 1e8, 1e-3));
  json["analysis"] = "static";
  json["supports"] = {{{"group", "feet"}, {"report_reaction", true}}};
  json["prescribed"] = {{{"group", "top"}, {"component", "y"}, {"rate", -0.5}},
                        {{"group", "top"}, {"component", "x"}, {"rate", 0.0}}};
  const auto solver = fem_solver<2>(json);
  const double L = std::hypot(1, 0.2);
  for (int n = 1; n <= 20; ++n) {
    advance(*solver, n, 0.04);
    const double w = 0.02 * n, l = std::hypot(1, 0.2 - w), N = 1e5 * (l - L) / L;
    EXPECT_NEAR(probe(*solver, "reaction_feet_y"), -2 * N * (0.2 - w) / l, 1e-7) << n;
    EXPECT_NEAR(probe(*solver, "axial_max_rope"), N, 1e-7);
    EXPECT_NEAR(probe(*solver, "elastic_energy"), 1e5 * (l - L) * (l - L) / L, 1e-7);
  }
}

/// A bar that turns by a right angle in one step has no force.
TEST(LineCells, rotation_is_no_strain) {
  const TemporaryMesh mesh(chain(2, 1).file());
  Json json = line_scene(2, mesh.path(), line_material("truss", 1e8, 1e-3));
  json["analysis"] = "static";
  json["supports"] = {{{"group", "low"}}};
  json["prescribed"] = {{{"group", "high"}, {"component", "x"}, {"rate", -2.0}},
                        {{"group", "high"}, {"component", "y"}, {"rate", 2.0}}};
  const auto solver = fem_solver<2>(json);
  advance(*solver, 1, 1);
  EXPECT_NEAR(probe(*solver, "axial_max_rope"), 0, 1e-7);
}

/// Frequencies of a string of length 10, force 1e4, mass 0.5 a metre; the exact first is 7.0711 Hz.
std::vector<double> string_frequencies(const std::string& law, const std::string& mass) {
  const TemporaryMesh mesh(chain(10, 10).file());
  Json material = line_material(law, 1e9, 1e-3, 500);
  material["pretension"] = 1e4;
  Json json = line_scene(2, mesh.path(), material);
  json["mass"] = mass;
  const auto settings = fem_settings<2>(json);
  const auto cells = integrals(settings);
  BlockMatrix<2> K, M;
  cells.set_pattern(K);
  cells.set_pattern(M);
  K.set_zero();
  M.set_zero();
  std::vector<double> u(22, 0.0), f(22, 0.0);
  cells.add_internal(u, f, &K);
  cells.add_mass(1 / settings.line_materials[0].length_ratio, M);
  std::vector<int> across;
  for (int i = 1; i < 10; ++i) across.push_back(2 * i + 1);
  const Eigen::GeneralizedSelfAdjointEigenSolver<MatrixXd> modes(dense(K)(across, across),
                                                                 dense(M)(across, across));
  std::vector<double> result;
  for (int k = 0; k < 3; ++k) {
    result.push_back(std::sqrt(modes.eigenvalues()[k]) / (2 * std::numbers::pi));
  }
  return result;
}

TEST(LineCells, frequencies_of_a_string) {
  const auto consistent = string_frequencies("truss", "consistent"),
             lumped = string_frequencies("truss", "lumped");
  EXPECT_EQ(string_frequencies("cable", "consistent"), lumped);
  const std::vector<double> expected = {7.1002, 14.376, 22.004};
  const std::vector<double> expected_lumped = {7.0420, 13.911, 20.437};
  for (int k = 0; k < 3; ++k) {
    EXPECT_NEAR(consistent[k], expected[k], 1e-4 * expected[k]);
    EXPECT_NEAR(lumped[k], expected_lumped[k], 1e-4 * expected_lumped[k]);
  }
}

/// The mass of a rope is that of its stress-free length, however it is lumped.
TEST(LineCells, mass_of_the_stress_free_length) {
  for (const char* mass : {"consistent", "lumped"}) {
    const TemporaryMesh mesh(chain(10, 5).file());
    Json material = line_material("cable", 1e9, 1e-3, 500);
    material["length_ratio"] = 1.2;
    Json json = line_scene(3, mesh.path(), material);
    json["mass"] = mass;
    const auto settings = fem_settings<3>(json);
    std::vector<double> ones(18, 1.0), momentum(18, 0.0);
    integrals(settings).add_mass_times(ones, momentum);
    double sum = 0;
    for (const double m : momentum) sum += m / 3;
    EXPECT_NEAR(sum, 6, 1e-12);
  }
}

}  // namespace
}  // namespace gabion::test::test_line_cells
