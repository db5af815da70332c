// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <random>
#include <variant>

#include "fem_solver/stress/cell_integrals.hpp"
#include "tests/support/check_tangent.hpp"
#include "tests/unit/fem/cells_of_mesh.hpp"
#include "tests/unit/fem/fem_scene.hpp"

namespace gabion::test::test_cell_integrals {
namespace {

constexpr double E = 1e6, nu = 0.3;
const std::vector<std::string> laws = {"linear_elastic", "neo_hookean", "hencky_elastic"};

template <int dim>
Json box_json(const std::string& type, const std::string& law) {
  Json mesh;
  if constexpr (dim == 2) mesh = box_2d({2, 1}, {4, 3}, type);
  if constexpr (dim == 3) mesh = box_3d({2, 1, 1}, {3, 3, 3}, type);
  return {{"dimension", dim}, {"mesh", mesh}, {"material", elastic(law, E, nu, 1000)}};
}

/// A box whose inner nodes are moved by up to a tenth of a cell.
template <int dim>
fem::FemSettings<dim> distorted_box(const std::string& type, const std::string& law) {
  auto settings = fem_settings<dim>(box_json<dim>(type, law));
  std::mt19937 random(7);
  std::uniform_real_distribution<double> shift(-0.033, 0.033);
  const auto inner = inner_nodes(settings.mesh);
  for (std::size_t i = 0; i < inner.size(); ++i) {
    for (int c = 0; c < dim && inner[i]; ++c) settings.mesh.nodes[i][c] += shift(random);
  }
  return settings;
}

template <int dim>
fem::CellIntegrals<dim> integrals_of(const fem::FemSettings<dim>& s, bool lumped = false) {
  return fem::CellIntegrals<dim>(s.mesh, s.materials, lumped);
}

template <int dim>
std::vector<double> affine(const Mesh<dim>& mesh, const Matrix<dim>& G) {
  std::vector<double> u;
  for (const auto& x : mesh.nodes) {
    const Vector<dim> value = G * x;
    u.insert(u.end(), value.data(), value.data() + dim);
  }
  return u;
}

template <int dim>
Matrix<dim> gradient() {
  Matrix<3> G;
  G << 0.11, -0.23, 0.05, 0.17, -0.08, 0.12, -0.06, 0.04, 0.14;
  return G.template topLeftCorner<dim, dim>();
}

/// Under an affine displacement the stress is uniform: no force on inner nodes, and P n A on a
/// side.
template <int dim>
void patch_test(const std::string& type, const std::string& law) {
  SCOPED_TRACE(type + " " + law);
  const auto settings = distorted_box<dim>(type, law);
  const Matrix<dim> G = gradient<dim>();
  StressUpdate<dim> exact;
  std::visit(
      [&]<class Law>(const Law& m) {
        if constexpr (!fem::LawWithHistory<Law>) {
          ASSERT_TRUE(m.update(G, {}, exact, nullptr));
        }
      },
      settings.materials[0].law);
  std::vector<double> f(settings.mesh.nodes.size() * dim, 0.0);
  const auto integrals = integrals_of(settings);
  const auto result =
      integrals.add_internal(affine(settings.mesh, G), std::span<double>(f), nullptr);
  ASSERT_EQ(result.inadmissible_cell, -1);
  // Volume 2, forces of the order E x side 1.
  EXPECT_NEAR(result.energy, 2 * exact.energy, 1e-12 * E);
  const auto inner = inner_nodes(settings.mesh);
  for (std::size_t i = 0; i < f.size(); ++i) {
    if (inner[i / dim]) {
      EXPECT_NEAR(f[i], 0, 1e-12 * E);
    }
  }
  Vector<dim> moment_of_x = Vector<dim>::Zero();  // sum f_i x = volume P_ix, by virtual work
  for (std::size_t i = 0; i < f.size(); ++i) {
    moment_of_x[i % dim] += f[i] * settings.mesh.nodes[i / dim][0];
  }
  EXPECT_LT((moment_of_x - 2 * exact.P.col(0)).norm(), 1e-12 * E);
}

TEST(CellIntegrals, patch_test_of_each_cell_and_law) {
  for (const auto& law : laws) {
    patch_test<2>("tri3", law);
    patch_test<2>("quad4", law);
    patch_test<3>("tet4", law);
    patch_test<3>("hex8", law);
  }
}

template <int dim>
void rotation_test(const std::string& type, const std::string& law) {
  SCOPED_TRACE(type + " " + law);
  const auto settings = distorted_box<dim>(type, law);
  Matrix<3> R3 = Eigen::AngleAxisd(0.7, Vector<3>::UnitZ()).toRotationMatrix();
  if (dim == 3) R3 = R3 * Eigen::AngleAxisd(-1.1, Vector<3>(1, 2, 3).normalized());
  const Matrix<dim> G = R3.topLeftCorner<dim, dim>() - Matrix<dim>::Identity();
  const auto u = affine(settings.mesh, G);
  std::vector<double> f(u.size(), 0.0);
  const auto integrals = integrals_of(settings);
  const auto result = integrals.add_internal(u, std::span<double>(f), nullptr);
  for (const double value : f) EXPECT_NEAR(value, 0, 1e-13 * E);
  EXPECT_NEAR(result.energy, 0, 1e-13 * E);
  for (const double value : integrals.cell_stresses(u)) EXPECT_NEAR(value, 0, 1e-12 * E);
}

TEST(CellIntegrals, rigid_rotation_gives_no_stress) {
  for (const std::string law : {"neo_hookean", "hencky_elastic"}) {
    rotation_test<2>("tri3", law);
    rotation_test<2>("quad4", law);
    rotation_test<3>("tet4", law);
    rotation_test<3>("hex8", law);
  }
}

template <int dim>
void tangent_test(const std::string& type, const std::string& law) {
  SCOPED_TRACE(type + " " + law);
  Json json = box_json<dim>(type, law);
  json["mesh"]["box"]["cells"] = std::vector<int>(dim, 1);
  const auto settings = fem_settings<dim>(json);
  const auto integrals = integrals_of(settings);
  auto start = affine(settings.mesh, gradient<dim>());
  std::mt19937 random(3);
  std::uniform_real_distribution<double> shift(-0.05, 0.05);
  for (auto& value : start) value += shift(random);
  const auto n = static_cast<Eigen::Index>(start.size());
  BlockMatrix<dim> K;
  integrals.set_pattern(K);
  K.set_zero();
  std::vector<double> f(start.size(), 0.0);
  ASSERT_EQ(integrals.add_internal(start, std::span<double>(f), &K).inadmissible_cell, -1);
  Eigen::MatrixXd tangent(n, n);
  for (Eigen::Index k = 0; k < n; ++k) {
    std::vector<double> unit(start.size(), 0.0), column(start.size(), 0.0);
    unit[k] = 1;
    K.multiply(unit, column);
    tangent.col(k) = Eigen::Map<Eigen::VectorXd>(column.data(), n);
  }
  const auto force = [&](const Eigen::VectorXd& u) {
    Eigen::VectorXd result = Eigen::VectorXd::Zero(n);
    integrals.add_internal(std::span<const double>(u.data(), n),
                           std::span<double>(result.data(), n), nullptr);
    return result;
  };
  const Eigen::VectorXd u = Eigen::Map<Eigen::VectorXd>(start.data(), n);
  EXPECT_LT(tangent_error(force, u, tangent, 1e-3), 1e-8);
  EXPECT_LT((tangent - tangent.transpose()).cwiseAbs().maxCoeff(), 1e-11 * E);
}

TEST(CellIntegrals, tangent_against_differences) {
  for (const auto& law : laws) {
    tangent_test<2>("tri3", law);
    tangent_test<2>("quad4", law);
    tangent_test<3>("tet4", law);
    tangent_test<3>("hex8", law);
  }
}

/// Both masses carry the total 1000 x 2, and a linear velocity field has the same momentum.
TEST(CellIntegrals, mass_is_that_of_the_volume) {
  for (const std::string type : {"tri3", "quad4"}) {
    for (const bool lumped : {false, true}) {
      const auto settings = distorted_box<2>(type, "linear_elastic");
      const auto integrals = integrals_of(settings, lumped);
      std::vector<double> v, momentum(settings.mesh.nodes.size() * 2, 0.0);
      for (const auto& x : settings.mesh.nodes) v.insert(v.end(), {1.0, x[0]});
      integrals.add_mass_times(v, momentum);
      double px = 0, py = 0;
      for (std::size_t i = 0; i < momentum.size(); i += 2) px += momentum[i], py += momentum[i + 1];
      EXPECT_NEAR(px, 2000, 1e-9);
      EXPECT_NEAR(py, 2000, 1e-9);  // mean x is 1
    }
  }
}

TEST(CellIntegrals, inverted_state_is_reported) {
  const auto settings = distorted_box<2>("quad4", "neo_hookean");
  Matrix<2> G = Matrix<2>::Zero();
  G(0, 0) = -1.5;
  std::vector<double> f(settings.mesh.nodes.size() * 2, 0.0);
  const auto result =
      integrals_of(settings).add_internal(affine(settings.mesh, G), std::span<double>(f), nullptr);
  EXPECT_EQ(result.inadmissible_cell, 0);
}

/// The angle is that of R in F = R U, whatever U is.
TEST(CellIntegrals, largest_rotation_of_a_cell) {
  for (const double degrees : {0.0, 12.0, 75.0, 170.0}) {
    const double angle = degrees * M_PI / 180;
    const auto flat = distorted_box<2>("quad4", "linear_elastic");
    const Matrix<2> R = Eigen::Rotation2D<double>(-angle).toRotationMatrix();
    const Matrix<2> U{{1.3, 0.2}, {0.2, 0.9}};
    EXPECT_NEAR(
        integrals_of(flat).largest_rotation(affine<2>(flat.mesh, R * U - Matrix<2>::Identity())),
        angle, 1e-12);
    const auto solid = distorted_box<3>("hex8", "linear_elastic");
    const Matrix<3> turn =
        Eigen::AngleAxis<double>(angle, Vector<3>(1, 2, -1).normalized()).toRotationMatrix();
    const Matrix<3> V{{1.3, 0.2, 0}, {0.2, 0.9, 0.1}, {0, 0.1, 1}};
    EXPECT_NEAR(integrals_of(solid).largest_rotation(
                    affine<3>(solid.mesh, turn * V - Matrix<3>::Identity())),
                angle, 1e-7);
  }
}

}  // namespace
}  // namespace gabion::test::test_cell_integrals
