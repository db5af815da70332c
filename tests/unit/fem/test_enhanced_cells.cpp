// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include <Eigen/Eigenvalues>
#include <Eigen/Geometry>
#include <random>

#include "tests/support/check_tangent.hpp"
#include "tests/support/expect_error.hpp"
#include "tests/unit/fem/cells_of_mesh.hpp"
#include "tests/unit/fem/fem_scene.hpp"

namespace gabion::test::test_enhanced_cells {
namespace {

constexpr double E = 1e6, nu = 0.3;

Json material_of(const std::string& law, const std::string& formulation) {
  Json material = elastic(law, E, nu, 1000);
  material["formulation"] = formulation;
  if (law == "von_mises") {
    material["yield_stress"] = 0.01 * E;
    material["hardening_modulus"] = 0.02 * E;
    material["kinematic_modulus"] = 0.05 * E;
  }
  return material;
}

template <int dim>
fem::FemSettings<dim> box_of(const Json& material, int cells) {
  const Json mesh =
      dim == 2 ? box_2d({2, 1}, {cells, cells}) : box_3d({2, 1, 1}, {cells, cells, cells});
  auto settings = fem_settings<dim>({{"dimension", dim}, {"mesh", mesh}, {"material", material}});
  if (cells == 1) return settings;
  std::mt19937 random(7);
  std::uniform_real_distribution<double> shift(-0.04, 0.04);
  std::vector<char> inner(settings.mesh.nodes.size(), 1);
  for (const auto& [name, facets] : settings.mesh.facet_groups) {
    for (const auto node : facets) inner[node] = 0;
  }
  for (std::size_t i = 0; i < inner.size(); ++i) {
    for (int c = 0; c < dim && inner[i]; ++c) settings.mesh.nodes[i][c] += shift(random);
  }
  return settings;
}

/// Under an affine displacement, plastic or not, enhanced cells say what full ones say: the modes
/// stay zero, inner nodes bear no force, and the forces are the same.
template <int dim>
void expect_patch(const std::string& law, double scale) {
  SCOPED_TRACE(law);
  const auto settings = box_of<dim>(material_of(law, "enhanced"), 3);
  const Cells<dim> enhanced(settings), full(box_of<dim>(material_of(law, "full"), 3));
  const Eigen::VectorXd u = affine<dim>(settings.mesh, some_gradient<dim>(scale));
  double energy = 0, expected_energy = 0;
  const Eigen::VectorXd f = enhanced.forces(u, &energy),
                        expected = full.forces(u, &expected_energy);
  EXPECT_LT((f - expected).cwiseAbs().maxCoeff(), 1e-13 * E);
  EXPECT_NEAR(energy, expected_energy, 1e-13 * E);
  std::vector<char> inner(settings.mesh.nodes.size(), 1);
  for (const auto& [name, facets] : settings.mesh.facet_groups) {
    for (const auto node : facets) inner[node] = 0;
  }
  for (std::size_t i = 0; i < inner.size(); ++i) {
    if (inner[i]) {
      EXPECT_LT(f.segment<dim>(static_cast<Eigen::Index>(i) * dim).norm(), 1e-13 * E);
    }
  }
}

TEST(EnhancedCells, patch_test_on_distorted_cells) {
  for (const std::string law : {"linear_elastic", "neo_hookean", "hencky_elastic", "von_mises"}) {
    expect_patch<2>(law, 1);
    expect_patch<3>(law, 1);
  }
}

template <int dim>
void expect_tangent(const std::string& law, const std::string& formulation) {
  SCOPED_TRACE(law + " " + formulation);
  const auto settings = box_of<dim>(material_of(law, formulation), 1);
  Cells<dim> cells(settings);
  std::mt19937 random(3);
  std::uniform_real_distribution<double> shift(-0.05, 0.05);
  Eigen::VectorXd first = affine<dim>(settings.mesh, some_gradient<dim>(0.3));
  for (double& value : first) value += shift(random);
  cells.accept(first);
  Eigen::VectorXd u = affine<dim>(settings.mesh, some_gradient<dim>(1));
  for (double& value : u) value += shift(random);
  const Eigen::MatrixXd K = cells.tangent(u);
  EXPECT_LT(tangent_error([&](const Eigen::VectorXd& x) { return cells.forces(x); }, u, K, 1e-4),
            1e-7);
  EXPECT_LT((K - K.transpose()).cwiseAbs().maxCoeff(), 1e-11 * E);
}

TEST(EnhancedCells, tangent_against_differences) {
  for (const std::string law : {"linear_elastic", "neo_hookean", "hencky_elastic", "von_mises"}) {
    expect_tangent<2>(law, "enhanced");
    expect_tangent<3>(law, "enhanced");
  }
  expect_tangent<2>("von_mises", "full");
  expect_tangent<3>("von_mises", "full");
}

/// A free cell has no stiffness against rigid motions, and against nothing else.
template <int dim>
void expect_rank() {
  const auto settings = box_of<dim>(material_of("neo_hookean", "enhanced"), 1);
  const Cells<dim> cells(settings);
  const Eigen::VectorXd u =
      Eigen::VectorXd::Zero(static_cast<Eigen::Index>(settings.mesh.nodes.size()) * dim);
  const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> eigen(cells.tangent(u));
  const int rigid = dim == 2 ? 3 : 6;
  EXPECT_LT(eigen.eigenvalues().head(rigid).cwiseAbs().maxCoeff(), 1e-9 * E);
  EXPECT_GT(eigen.eigenvalues()[rigid], 1e-3 * E);
}

TEST(EnhancedCells, free_cells_have_rigid_motions_only) {
  expect_rank<2>();
  expect_rank<3>();
}

TEST(EnhancedCells, a_rigid_rotation_gives_no_stress) {
  for (const std::string law : {"neo_hookean", "hencky_elastic", "von_mises"}) {
    const auto settings = box_of<3>(material_of(law, "enhanced"), 3);
    const Cells<3> cells(settings);
    const Matrix<3> R =
        Eigen::AngleAxisd(M_PI / 2, Vector<3>(1, 2, 3).normalized()).toRotationMatrix();
    const Eigen::VectorXd u = affine<3>(settings.mesh, R - Matrix<3>::Identity());
    EXPECT_LT(cells.forces(u).cwiseAbs().maxCoeff(), 1e-13 * E);
    const auto stresses = cells.integrals.cell_stresses(
        {u.data(), static_cast<std::size_t>(u.size())}, cells.history);
    for (const double value : stresses) EXPECT_NEAR(value, 0, 1e-12 * E);
  }
}

/// Tip of a clamped beam of ten by one cells with a force across, over that of Timoshenko's beam.
template <int dim>
double tip_over_exact(const std::string& formulation) {
  Json material = elastic("linear_elastic", E, nu, 1000);
  material["formulation"] = formulation;
  const Json mesh = dim == 2 ? box_2d({10, 1}, {10, 1}) : box_3d({10, 1, 1}, {10, 1, 1});
  Json json = {{"dimension", dim},
               {"mesh", mesh},
               {"material", material},
               {"analysis", "static"},
               {"supports", {{{"group", "left"}}}}};
  json["loads"] = {{{"group", "right"}, {"force", std::vector<double>(dim, 0.0)}}};
  json["loads"][0]["force"][dim - 1] = 1.0;
  json["probes"] = {{{"name", "A"}, {"point", std::vector<double>(dim, 0.0)}}};
  json["probes"][0]["point"][0] = 10.0;
  const auto solver = fem_solver<dim>(json);
  run_steps(*solver, 1, 1);
  const double modulus = dim == 2 ? E / (1 - nu * nu) : E;  // plane strain: of a plate
  const double G = E / (2 * (1 + nu));
  const double exact = 1000 / (3 * modulus / 12) + 10 / (5.0 / 6 * G);
  return probe(*solver, dim == 2 ? "A.uy" : "A.uz") / exact;
}

/// Ten cells along a beam of ratio 10 and one across: two thirds of the bending without
/// enhancement.
TEST(EnhancedCells, bend_as_a_beam) {
  EXPECT_NEAR(tip_over_exact<3>("full"), 0.643, 1e-3);
  EXPECT_NEAR(tip_over_exact<3>("enhanced"), 0.985, 1e-3);
  EXPECT_LT(tip_over_exact<2>("full"), 0.7);
  EXPECT_NEAR(tip_over_exact<2>("enhanced"), 1, 0.02);
}

/// A slender beam bent far: the elastica under an end force of 4 E I / L^2.
TEST(EnhancedCells, bend_far) {
  Json material = elastic("hencky_elastic", 1.2e6, 0, 1000);
  material["formulation"] = "enhanced";
  Json json = {{"dimension", 2},
               {"mesh", box_2d({10, 0.4}, {20, 1})},
               {"material", material},
               {"analysis", "static"},
               {"supports", {{{"group", "left"}}}}};
  json["newton"] = {{"max_iterations", 60}};
  json["loads"] = {{{"group", "right"}, {"force", {0.0, 256.0}}, {"table", {{0, 0}, {1, 1}}}}};
  json["probes"] = {{{"name", "A"}, {"point", {10.0, 0.0}}},
                    {{"name", "B"}, {"point", {10.0, 0.4}}}};
  const auto solver = fem_solver<2>(json);
  run_steps(*solver, 0.1, 10);
  EXPECT_NEAR(0.5 * (probe(*solver, "A.ux") + probe(*solver, "B.ux")), -3.2894, 0.03);
  EXPECT_NEAR(0.5 * (probe(*solver, "A.uy") + probe(*solver, "B.uy")), 6.6996, 0.03);
}

/// Volume that hardly changes does not lock: a block under pressure on half its top.
TEST(EnhancedCells, nearly_incompressible) {
  const auto settled = [](const std::string& formulation, double ratio) {
    Json material = elastic("linear_elastic", E, ratio, 1000);
    material["formulation"] = formulation;
    Json json = {{"dimension", 2},
                 {"mesh", box_2d({1, 1}, {8, 8})},
                 {"material", material},
                 {"analysis", "static"},
                 {"supports", {{{"group", "left"}}}},
                 {"tractions", {{{"group", "right"}, {"traction", {0.0, 1e3}}}}},
                 {"probes", {{{"name", "A"}, {"point", {1.0, 1.0}}}}}};
    const auto solver = fem_solver<2>(json);
    run_steps(*solver, 1, 1);
    return probe(*solver, "A.uy");
  };
  const double enhanced = settled("enhanced", 0.49999), softer = settled("enhanced", 0.49);
  EXPECT_NEAR(enhanced / softer, 1, 0.02);
  EXPECT_LT(settled("full", 0.49999), 0.8 * enhanced);
}

/// Newton's iteration ends as soon in a wall of millimetres as in one of metres, at small strain
/// too, and with cells that are ten times as long as wide.
TEST(EnhancedCells, iterations_do_not_depend_on_size) {
  for (const double size : {1e-3, 1.0, 100.0}) {
    for (const int cells_along : {40, 4}) {
      Json material = elastic("neo_hookean", 1e6, 0, 1100);
      material["formulation"] = "enhanced";
      Json json = {{"dimension", 2},
                   {"mesh", box_2d({size, 10 * size}, {4, cells_along})},
                   {"material", material},
                   {"analysis", "static"},
                   {"supports", {{{"group", "bottom"}}}},
                   {"tractions", {{{"group", "left"}, {"traction", {0.1, 0.0}}}}}};
      const auto solver = fem_solver<2>(json);
      InterfaceValues sent;
      EXPECT_LE(solver->solve_step({1, 0, 0, 1}, {}, sent).newton_iterations, 4) << size;
    }
  }
}

TEST(EnhancedCells, triangles_are_refused) {
  Json json = {{"dimension", 2},
               {"mesh", box_2d({1, 1}, {2, 2}, "tri3")},
               {"material", material_of("neo_hookean", "enhanced")}};
  expect_error<ConfigError>([&] { fem_solver<2>(json); },
                            {"/material", "enhanced", "tri3", "quad4, hex8"});
}

}  // namespace
}  // namespace gabion::test::test_enhanced_cells
