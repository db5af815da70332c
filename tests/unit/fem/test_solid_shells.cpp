// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include <Eigen/Eigenvalues>
#include <Eigen/Geometry>
#include <random>

#include "tests/support/check_tangent.hpp"
#include "tests/support/expect_error.hpp"
#include "tests/unit/fem/cells_of_mesh.hpp"
#include "tests/unit/fem/fem_scene.hpp"

namespace gabion::test::test_solid_shells {
namespace {

constexpr double E = 1e6, nu = 0.3;
const std::vector<std::string> laws = {"linear_elastic", "neo_hookean", "hencky_elastic",
                                       "von_mises"};

Json shell_of(const std::string& law, double poisson = nu) {
  Json material = elastic(law, E, poisson, 1000);
  material["formulation"] = "solid_shell";
  if (law == "von_mises") {
    material["yield_stress"] = 0.01 * E;
    material["hardening_modulus"] = 0.02 * E;
    material["kinematic_modulus"] = 0.05 * E;
  }
  return material;
}

/// A plate 2 by 1 with the thickness t along z, 3 by 3 cells in its plane, whose cells there are
/// distorted; the material by the words of fem.json.
fem::FemSettings<3> plate_of(const Json& material, double t, int across = 1) {
  auto settings = fem_settings<3>(
      {{"dimension", 3}, {"mesh", box_3d({2, 1, t}, {3, 3, across})}, {"material", material}});
  for (Vector<3>& x : settings.mesh.nodes) {
    const auto inside = [](double s) { return s > 1e-9 && s < 1 - 1e-9; };
    if (!inside(x[0] / 2) || !inside(x[1])) continue;
    const double r = x[0], s = x[1];
    x[0] += 0.15 * std::sin(3 * r + 5 * s);
    x[1] += 0.08 * std::cos(4 * r - 7 * s);
  }
  return settings;
}

/// Cells numbered by other corners first, so that every axis, either way, lies across.
void turn_numbers(Mesh<3>& mesh) {
  constexpr int cyclic[8] = {0, 3, 7, 4, 1, 2, 6, 5};  // zeta along the old x
  constexpr int mirrored[8] = {6, 5, 4, 7, 2, 1, 0, 3};
  for (std::int32_t c = 0; c < mesh.num_cells(); ++c) {
    for (int n = 0; n < c % 6; ++n) {
      std::array<std::int32_t, 8> old;
      std::copy_n(mesh.cells.begin() + c * 8, 8, old.begin());
      for (int a = 0; a < 8; ++a) mesh.cells[c * 8 + a] = old[n == 2 ? mirrored[a] : cyclic[a]];
    }
  }
}

/// In-plane strain and a change of thickness, turned in space where the law allows it.
Matrix<3> without_shear_across(const std::string& law) {
  Matrix<3> G = some_gradient<3>(1);
  G(0, 2) = G(1, 2) = G(2, 0) = G(2, 1) = 0;
  if (law == "linear_elastic") return G;
  const Matrix<3> R = Eigen::AngleAxisd(0.8, Vector<3>(2, 1, -1).normalized()).toRotationMatrix();
  return R * (Matrix<3>::Identity() + G) - Matrix<3>::Identity();
}

/// Under an affine displacement without shear across, plastic or not, cells of a flat plate say
/// what full ones say.
TEST(SolidShells, patch_test_of_uniform_strain) {
  for (const std::string& law : laws) {
    SCOPED_TRACE(law);
    for (const int across : {1, 2}) {
      Json full = shell_of(law);
      full["formulation"] = "full";
      const auto settings = plate_of(shell_of(law), 0.1, across);
      const Cells<3> shells(settings), cells(plate_of(full, 0.1, across));
      const Eigen::VectorXd u = affine<3>(settings.mesh, without_shear_across(law));
      double energy = 0, expected_energy = 0;
      const Eigen::VectorXd f = shells.forces(u, &energy),
                            expected = cells.forces(u, &expected_energy);
      EXPECT_LT((f - expected).cwiseAbs().maxCoeff(), 1e-13 * E);
      EXPECT_NEAR(energy, expected_energy, 1e-13 * E);
      const auto stresses = shells.integrals.cell_stresses(
          {u.data(), static_cast<std::size_t>(u.size())}, shells.history);
      const auto of_full = cells.integrals.cell_stresses(
          {u.data(), static_cast<std::size_t>(u.size())}, cells.history);
      for (std::size_t i = 0; i < stresses.size(); ++i) {
        EXPECT_NEAR(stresses[i], of_full[i], 1e-12 * E);
      }
    }
  }
}

/// w with the curvatures xx, yy, xy: bending and twist of a plate without load, exact in space.
Eigen::VectorXd bent(const Mesh<3>& mesh, double t, const Vector<3>& k) {
  Eigen::VectorXd u(static_cast<Eigen::Index>(mesh.nodes.size()) * 3);
  for (std::size_t i = 0; i < mesh.nodes.size(); ++i) {
    const Vector<3>& x = mesh.nodes[i];
    const double z = x[2] - t / 2;
    const double w = 0.5 * (k[0] * x[0] * x[0] + k[1] * x[1] * x[1]) + k[2] * x[0] * x[1];
    u.segment<3>(static_cast<Eigen::Index>(i) * 3) =
        Vector<3>(-z * (k[0] * x[0] + k[2] * x[1]), -z * (k[1] * x[1] + k[2] * x[0]),
                  w + nu / (1 - nu) * z * z / 2 * (k[0] + k[1]));
  }
  return u;
}

/// Constant moments in a plate of distorted cells, thick and thin: nodes within bear no force, and
/// the energy is that of Kirchhoff's plate.
TEST(SolidShells, patch_test_of_bending_and_twist) {
  for (const double t : {0.1, 1e-3}) {
    const auto settings = plate_of(shell_of("linear_elastic"), t);
    const Cells<3> cells(settings);
    for (const Vector<3>& k : {Vector<3>(1, 0, 0), Vector<3>(0, 1, 0), Vector<3>(0, 0, 1),
                               Vector<3>(1e-3, 1e-3, 5e-4)}) {
      double energy = 0;
      const Eigen::VectorXd f = cells.forces(bent(settings.mesh, t, k), &energy);
      const double D = E * t * t * t / 12 / (1 - nu * nu);
      const double exact =
          0.5 * D * 2 *
          (k[0] * k[0] + k[1] * k[1] + 2 * nu * k[0] * k[1] + 2 * (1 - nu) * k[2] * k[2]);
      EXPECT_NEAR(energy / exact, 1, 1e-10) << t;
      for (std::size_t i = 0; i < settings.mesh.nodes.size(); ++i) {
        const Vector<3>& x = settings.mesh.nodes[i];
        const bool inside = x[0] > 1e-9 && x[0] < 2 - 1e-9 && x[1] > 1e-9 && x[1] < 1 - 1e-9;
        const double at_node = f.segment<3>(static_cast<Eigen::Index>(i) * 3).norm();
        if (!inside) continue;
        EXPECT_LT(at_node, 1e-9 * f.cwiseAbs().maxCoeff()) << t << " " << k.transpose();
      }
    }
  }
}

/// A cell of the box a by b by c, its corners moved a little.
fem::FemSettings<3> one_cell(const Json& material, std::vector<double> box) {
  const double least = *std::min_element(box.begin(), box.end());
  auto settings = fem_settings<3>(
      {{"dimension", 3}, {"mesh", box_3d(std::move(box), {1, 1, 1})}, {"material", material}});
  std::mt19937 random(7);
  std::uniform_real_distribution<double> shift(-0.1 * least, 0.1 * least);
  for (Vector<3>& x : settings.mesh.nodes) {
    for (int i = 0; i < 3; ++i) x[i] += shift(random);
  }
  return settings;
}

TEST(SolidShells, tangent_against_differences) {
  for (const std::string& law : laws) {
    for (const std::vector<double>& box :
         {std::vector<double>{2, 1, 0.4}, {0.4, 2, 1}, {1, 0.4, 2}}) {
      SCOPED_TRACE(law);
      const auto settings = one_cell(shell_of(law), box);
      Cells<3> cells(settings);
      std::mt19937 random(3);
      std::uniform_real_distribution<double> shift(-0.02, 0.02);
      Eigen::VectorXd first = affine<3>(settings.mesh, some_gradient<3>(0.3));
      for (double& value : first) value += shift(random);
      cells.accept(first);
      Eigen::VectorXd u = affine<3>(settings.mesh, some_gradient<3>(1));
      for (double& value : u) value += shift(random);
      const Eigen::MatrixXd K = cells.tangent(u);
      EXPECT_LT(
          tangent_error([&](const Eigen::VectorXd& x) { return cells.forces(x); }, u, K, 3e-5),
          1e-7);
      EXPECT_LT((K - K.transpose()).cwiseAbs().maxCoeff(), 1e-11 * K.cwiseAbs().maxCoeff());
    }
  }
}

TEST(SolidShells, free_cells_have_rigid_motions_only) {
  const auto settings = one_cell(shell_of("neo_hookean"), {2, 1, 0.1});
  const Cells<3> cells(settings);
  const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> eigen(
      cells.tangent(Eigen::VectorXd::Zero(24)));
  EXPECT_LT(eigen.eigenvalues().head(6).cwiseAbs().maxCoeff(), 1e-12 * eigen.eigenvalues()[23]);
  EXPECT_GT(eigen.eigenvalues()[6], 1e-3 * 0.1 * 0.1 * 0.1 * E);
}

TEST(SolidShells, a_rigid_rotation_gives_no_stress) {
  for (const std::string law : {"neo_hookean", "hencky_elastic", "von_mises"}) {
    const auto settings = one_cell(shell_of(law), {2, 1, 0.1});
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

/// Forces do not depend on the corner with which a cell's numbers begin; when the cell is rotated,
/// they rotate with it; in millimetres they are those in metres.
TEST(SolidShells, numbering_direction_and_unit_do_not_matter) {
  for (const std::string law : {"neo_hookean", "von_mises"}) {
    auto settings = plate_of(shell_of(law), 0.1);
    const Eigen::VectorXd u = 3 * bent(settings.mesh, 0.1, {0.05, -0.02, 0.03}) +
                              affine<3>(settings.mesh, some_gradient<3>(0.05));
    const Eigen::VectorXd expected = Cells<3>(settings).forces(u);
    const double size = expected.cwiseAbs().maxCoeff();
    auto other = settings;
    turn_numbers(other.mesh);
    EXPECT_LT((Cells<3>(other).forces(u) - expected).cwiseAbs().maxCoeff(), 1e-12 * size);

    other = settings;
    const Matrix<3> R =
        Eigen::AngleAxisd(0.9, Vector<3>(1, -2, 0.5).normalized()).toRotationMatrix();
    Eigen::VectorXd turned = u, expected_turned = expected;
    for (std::size_t i = 0; i < other.mesh.nodes.size(); ++i) {
      const auto at = static_cast<Eigen::Index>(i) * 3;
      other.mesh.nodes[i] = R * other.mesh.nodes[i] + Vector<3>(10, 20, -30);
      turned.segment<3>(at) = R * u.segment<3>(at);
      expected_turned.segment<3>(at) = R * expected.segment<3>(at);
    }
    EXPECT_LT((Cells<3>(other).forces(turned) - expected_turned).cwiseAbs().maxCoeff(),
              1e-11 * size);

    other = settings;
    for (Vector<3>& x : other.mesh.nodes) x *= 1e-3;
    const Eigen::VectorXd small = Cells<3>(other).forces(1e-3 * u);
    EXPECT_LT((1e6 * small - expected).cwiseAbs().maxCoeff(), 1e-11 * size);
  }
}

/// The thickness by numbering and by a side is that of the shortest axis.
TEST(SolidShells, ways_to_say_the_thickness) {
  Json material = shell_of("neo_hookean");
  const auto settings = plate_of(material, 0.1);
  const Eigen::VectorXd u = bent(settings.mesh, 0.1, {0.05, -0.02, 0.03});
  const Eigen::VectorXd expected = Cells<3>(settings).forces(u);
  material["thickness"] = "numbering";
  EXPECT_EQ(Cells<3>(plate_of(material, 0.1)).forces(u), expected);
  material["thickness"] = "side";
  for (const std::string side : {"bottom", "top"}) {
    material["thickness_side"] = side;
    EXPECT_EQ(Cells<3>(plate_of(material, 0.1)).forces(u), expected);
  }
}

/// A strip of ten cells, clamped, with a force across its end, over the beam's: at any slenderness.
double tip_over_exact(double slenderness, double angle) {
  const double t = 10 / slenderness;
  Json material = shell_of("linear_elastic", 0);
  material["thickness"] = "numbering";
  Json json = {{"dimension", 3},
               {"mesh", box_3d({10, 1, t}, {10, 1, 1})},
               {"material", material},
               {"analysis", "static"},
               {"supports", {{{"group", "left"}}}}};
  if (slenderness > 10) {  // what rounding of thin cells' nodes leaves
    json["newton"] = {{"residual_tolerance", slenderness > 100 ? 1e-2 : 1e-5},
                      {"increment_tolerance", 1e-4}};
    json["linear_solver"] = {{"tolerance", slenderness > 100 ? 1e-2 : 1e-5}};
  }
  auto settings = fem_settings<3>(json);
  const Matrix<3> R = Eigen::AngleAxisd(angle, Vector<3>::UnitY()).toRotationMatrix();
  for (Vector<3>& x : settings.mesh.nodes) x = R * x;
  const double force = E * t * t * t / 12;
  settings.tractions.push_back({.group = "right", .traction = force / t * R.col(2), .where = ""});
  settings.probes.push_back({.name = "A", .point = R * Vector<3>(10, 0, 0), .where = ""});
  fem::FemSolver<3> solver(comm(), std::move(settings), "");
  run_steps(solver, 1, 1);
  const Vector<3> moved(probe(solver, "A.ux"), probe(solver, "A.uy"), probe(solver, "A.uz"));
  return moved.dot(R.col(2)) / (1000.0 / 3 + 10 * t * t / 6 / (5.0 / 6));
}

/// Each cell has a constant curvature, which takes 1 / (4 n^2) of the deflection.
TEST(SolidShells, bend_at_any_slenderness) {
  for (const double slenderness : {10.0, 100.0, 1e3}) {
    for (const double angle : {0.0, 0.7}) {
      EXPECT_NEAR(tip_over_exact(slenderness, angle), 1 - 1 / 400.0,
                  slenderness < 1e3 ? 2e-3 : 5e-3)
          << slenderness << " " << angle;
    }
  }
}

TEST(SolidShells, what_is_not_clear_is_refused) {
  const auto make = [](Json material, const Json& mesh) {
    fem_solver<3>({{"dimension", 3}, {"mesh", mesh}, {"material", std::move(material)}});
  };
  const Json material = shell_of("neo_hookean");
  expect_error<ConfigError>(
      [&] {
        make(material, box_3d({2, 1, 1}, {2, 1, 1}, "tet4"));
      },
      {"/material", "solid_shell", "tet4", "hex8"});
  expect_error<ConfigError>(
      [&] {
        make(material, box_3d({2, 2, 0.6}, {2, 2, 1}));
      },
      {"/material", "cell 0", "1 by 1 by 0.6", "half", "side"});
  // Cells shorter along the plate than it is thick.
  expect_error<ConfigError>(
      [&] {
        make(material, box_3d({2, 1, 1}, {10, 1, 1}));
      },
      {"/material", "cell 0", "shortest axis leads to other cells", "side"});
  Json by_side = material;
  by_side["thickness"] = "side";
  expect_error<ConfigError>(
      [&] {
        make(by_side, box_3d({2, 2, 0.1}, {2, 2, 1}));
      },
      {"/material", "thickness_side"});
  by_side["thickness_side"] = "lid";
  expect_error<ConfigError>(
      [&] {
        make(by_side, box_3d({2, 2, 0.1}, {2, 2, 1}));
      },
      {"/material/thickness_side", "lid", "top"});
  by_side["thickness_side"] = "left";
  expect_error<ConfigError>(
      [&] {
        make(by_side, box_3d({2, 2, 0.1}, {2, 2, 1}));
      },
      {"/material", "cell 1", "left", "0 of its axes"});
  Json full = material;
  full["formulation"] = "full";
  full["thickness"] = "numbering";
  expect_error<ConfigError>(
      [&] {
        make(full, box_3d({2, 2, 0.1}, {2, 2, 1}));
      },
      {"/material", "thickness"});
  expect_error<ConfigError>(
      [&] {
        fem_solver<2>(
            {{"dimension", 2}, {"mesh", box_2d({2, 0.1}, {2, 1})}, {"material", material}});
      },
      {"/material", "solid_shell", "quad4", "hex8"});
}

}  // namespace
}  // namespace gabion::test::test_solid_shells
