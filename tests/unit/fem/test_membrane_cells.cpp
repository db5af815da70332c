// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include <Eigen/Dense>
#include <Eigen/Geometry>

#include "fem_solver/stress/membranes.hpp"
#include "tests/unit/fem/sheet_scene.hpp"

namespace gabion::test::test_membrane_cells {
namespace {

using fem::MembraneMaterial;
using fem::MembraneResponse;
using fem::MembraneState;
using Strain = fem::StrainVector<2>;

MembraneMaterial material(bool tension_only, double prestress = 0) {
  return {.group = "net",
          .where = "",
          .density = 900,
          .young_modulus = 2e6,
          .poisson_ratio = 0.3,
          .thickness = 0.004,
          .prestress = prestress,
          .tension_only = tension_only};
}

/// One strain in each state, not along the axes.
const std::vector<std::pair<Strain, MembraneState>> states = {
    {Strain(0.02, 0.01, 0.004), MembraneState::taut},
    {Strain(0.02, -0.015, 0.02), MembraneState::wrinkled},
    {Strain(-0.02, -0.01, 0.004), MembraneState::slack}};

TEST(MembraneLaw, stress_and_tangent_are_derivatives_of_the_energy) {
  for (const bool tension_only : {false, true}) {
    const MembraneMaterial net = material(tension_only);
    for (const auto& [E, state] : states) {
      const MembraneResponse at = respond(net, E);
      EXPECT_EQ(at.state, tension_only ? state : MembraneState::taut);
      const double h = 1e-6;
      for (int k = 0; k < 3; ++k) {
        const MembraneResponse more = respond(net, E + h * Strain::Unit(k)),
                               less = respond(net, E - h * Strain::Unit(k));
        EXPECT_NEAR((more.energy - less.energy) / (2 * h), at.stress.S[k], 1e-7 * 2e6 * 0.02);
        const Strain slope = (more.stress.S - less.stress.S) / (2 * h);
        EXPECT_LT((slope - at.stress.D.col(k)).norm(), 1e-7 * 2e6);
      }
    }
  }
}

/// The relaxed energy is the least one over additional strains >= 0, and its stress has no
/// compression; stress and energy do not jump where the state changes.
TEST(MembraneLaw, relaxed_energy_is_the_least_one) {
  const MembraneMaterial net = material(true), full = material(false);
  for (const auto& [E, state] : states) {
    const double relaxed = respond(net, E).energy;
    double least = respond(full, E).energy;
    for (int a = 0; a <= 60; ++a) {
      for (int b = 0; b <= 60; ++b) {
        for (int turn = 0; turn < 60; ++turn) {
          const double angle = std::numbers::pi * turn / 60;
          const Vector<2> n(std::cos(angle), std::sin(angle)), t(-n[1], n[0]);
          const Matrix<2> more = 1e-3 * a * n * n.transpose() + 1e-3 * b * t * t.transpose();
          const double energy = respond(full, E + fem::strain_vector<2>(more)).energy;
          EXPECT_GE(energy, relaxed * (1 - 1e-12));
          least = std::min(least, energy);
        }
      }
    }
    EXPECT_NEAR(least, relaxed, 2e6 * 1e-6);
  }
  for (const double E_1 : {0.01, 1e-9}) {
    const Strain above(E_1, -0.3 * E_1 * (1 - 1e-9), 0), below(E_1, -0.3 * E_1 * (1 + 1e-9), 0);
    EXPECT_EQ(respond(net, above).state, MembraneState::taut);
    EXPECT_EQ(respond(net, below).state, MembraneState::wrinkled);
    EXPECT_LT((respond(net, above).stress.S - respond(net, below).stress.S).norm(),
              1e-8 * 2e6 * E_1);
  }
}

/// Membranes of a mesh as functions of the displacement.
struct Sheets {
  Sheets(const SheetText& text, const MembraneMaterial& net, bool lumped = false) {
    const TemporaryMesh file(text.file());
    mesh = read_gmsh<3>(file.path(), std::set<std::string>{"net"});
    const std::vector<MembraneMaterial> materials = {net};
    fem::add_sheets<3>(mesh, materials);
    membranes = fem::Membranes<3>(mesh, materials, lumped);
    std::vector<std::int32_t> offsets = {0}, nodes;
    membranes.add_to_pattern(offsets, nodes);
    K.set_pattern(mesh.num_nodes_total(), offsets, nodes);
  }
  Eigen::Index size() const { return 3 * static_cast<Eigen::Index>(mesh.nodes.size()); }
  Eigen::VectorXd forces(const Eigen::VectorXd& u, double* energy = nullptr) const {
    Eigen::VectorXd f = Eigen::VectorXd::Zero(size());
    const double own =
        membranes.add_internal({u.data(), static_cast<std::size_t>(size())},
                               {f.data(), static_cast<std::size_t>(size())}, nullptr, 0);
    if (energy) *energy = own;
    return f;
  }
  Eigen::MatrixXd dense() const {
    Eigen::MatrixXd all(size(), size());
    for (Eigen::Index k = 0; k < size(); ++k) {
      std::vector<double> unit(static_cast<std::size_t>(size()), 0.0), column(unit.size());
      unit[static_cast<std::size_t>(k)] = 1;
      K.multiply(unit, column);
      all.col(k) = Eigen::Map<Eigen::VectorXd>(column.data(), size());
    }
    return all;
  }
  Eigen::MatrixXd tangent(const Eigen::VectorXd& u) {
    Eigen::VectorXd f = Eigen::VectorXd::Zero(size());
    K.set_zero();
    membranes.add_internal({u.data(), static_cast<std::size_t>(size())},
                           {f.data(), static_cast<std::size_t>(size())}, &K, 0);
    return dense();
  }
  Eigen::MatrixXd mass() {
    K.set_zero();
    membranes.add_mass(1, K, 0);
    return dense();
  }
  /// Some displacements of all nodes, smooth and rough.
  Eigen::VectorXd some(double size_of_it) const {
    Eigen::VectorXd u(size());
    for (Eigen::Index k = 0; k < size(); ++k) u[k] = size_of_it * std::sin(1.7 * k * k + 0.3);
    return u;
  }

  Mesh<3> mesh;
  fem::Membranes<3> membranes;
  BlockMatrix<3> K;
};

TEST(MembraneCells, tangent_against_differences) {
  for (const bool triangles : {false, true}) {
    for (const bool tension_only : {false, true}) {
      Sheets net(sheet(3, 2, curved, triangles), material(tension_only, 2e3));
      const Eigen::VectorXd u = net.some(0.03);
      const Eigen::MatrixXd K = net.tangent(u);
      const Eigen::VectorXd f = net.forces(u);
      EXPECT_LT((K - K.transpose()).norm(), 1e-13 * K.norm());
      const double h = 1e-6;
      double worst_force = 0, worst_tangent = 0;
      for (Eigen::Index k = 0; k < net.size(); ++k) {
        Eigen::VectorXd more = u, less = u;
        more[k] += h;
        less[k] -= h;
        double high = 0, low = 0;
        const Eigen::VectorXd slope = (net.forces(more, &high) - net.forces(less, &low)) / (2 * h);
        worst_force = std::max(worst_force, std::abs((high - low) / (2 * h) - f[k]));
        worst_tangent = std::max(worst_tangent, (slope - K.col(k)).cwiseAbs().maxCoeff());
      }
      EXPECT_LT(worst_force, 1e-7 * f.cwiseAbs().maxCoeff());
      EXPECT_LT(worst_tangent, 1e-7 * K.cwiseAbs().maxCoeff());
    }
  }
}

/// A rotation after a deformation turns the forces and leaves the energy; alone it makes none.
TEST(MembraneCells, objectivity) {
  const Matrix<3> R = Eigen::AngleAxisd(2.1, Vector<3>(1, -2, 0.5).normalized()).toRotationMatrix();
  for (const bool triangles : {false, true}) {
    for (const bool tension_only : {false, true}) {
      const Sheets net(sheet(3, 2, curved, triangles), material(tension_only));
      const Eigen::VectorXd u = net.some(0.03);
      Eigen::VectorXd turned = u, only = u, rotated_forces = u;
      double energy = 0, energy_turned = 0, energy_only = 0;
      const Eigen::VectorXd f = net.forces(u, &energy);
      for (std::size_t i = 0; i < net.mesh.nodes.size(); ++i) {
        const Vector<3> X = net.mesh.nodes[i];
        const auto k = static_cast<Eigen::Index>(3 * i);
        turned.segment<3>(k) = R * (X + u.segment<3>(k)) - X;
        only.segment<3>(k) = R * X - X;
        rotated_forces.segment<3>(k) = R * f.segment<3>(k);
      }
      EXPECT_LT((net.forces(turned, &energy_turned) - rotated_forces).norm(), 1e-12 * f.norm());
      EXPECT_NEAR(energy_turned, energy, 1e-12 * energy);
      EXPECT_LT(net.forces(only, &energy_only).norm(), 1e-12 * f.norm());
      EXPECT_NEAR(energy_only, 0, 1e-12 * energy);
    }
  }
}

/// A free cell has the zero eigenvalues of a rigid body and, being flat, those across its plane.
TEST(MembraneCells, rank_of_a_flat_cell) {
  for (const bool triangles : {false, true}) {
    Sheets net(sheet(1, 1, flat(1, 1), triangles), material(false));
    const Eigen::MatrixXd K = net.tangent(Eigen::VectorXd::Zero(net.size()));
    const Eigen::VectorXd values = Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd>(K).eigenvalues();
    const auto zeros = (values.array().abs() < 1e-10 * values.maxCoeff()).count();
    EXPECT_EQ(zeros, 4 + 3);
  }
}

/// MacNeal and Harder (1985), in a turned plane: an affine motion leaves inner nodes without force,
/// and each cell with the same stress.
TEST(MembraneCells, patch_of_distorted_cells) {
  for (const bool triangles : {false, true}) {
    const SheetText text = sheet(4, 3, distorted_plane(), triangles);
    const Sheets net(text, material(false, 1e3));
    Matrix<3> G;
    G << 0.11, -0.23, 0.05, 0.17, -0.08, 0.12, -0.06, 0.04, 0.14;
    Eigen::VectorXd u(net.size());
    for (std::size_t i = 0; i < net.mesh.nodes.size(); ++i) {
      u.segment<3>(static_cast<Eigen::Index>(3 * i)) = G * net.mesh.nodes[i];
    }
    const Eigen::VectorXd f = net.forces(u);
    std::vector<char> inner(net.mesh.nodes.size(), 1);
    for (const std::int32_t i : net.mesh.node_groups.at("rim"))
      inner[static_cast<std::size_t>(i)] = 0;
    double worst = 0;
    for (std::size_t i = 0; i < inner.size(); ++i) {
      if (inner[i]) {
        worst = std::max(worst, f.segment<3>(static_cast<Eigen::Index>(3 * i)).norm());
      }
    }
    EXPECT_LT(worst, 1e-13 * f.norm());
    const auto values =
        net.membranes.blocks()[0].values({u.data(), static_cast<std::size_t>(u.size())});
    for (const auto& own : values) {
      EXPECT_LT((own.force - values[0].force).norm(), 1e-12 * values[0].force.norm());
      EXPECT_NEAR(own.strain, values[0].strain, 1e-13);
    }
  }
}

/// Stretched along an axis by 1.2: S = E / (1 - nu^2) E_11, N = S t 1.2 along it per length across.
TEST(MembraneCells, forces_of_a_stretched_sheet) {
  const Sheets net(sheet(2, 2, flat(1, 1)), material(false));
  Eigen::VectorXd u(net.size());
  for (std::size_t i = 0; i < net.mesh.nodes.size(); ++i) {
    u.segment<3>(static_cast<Eigen::Index>(3 * i)) = Vector<3>(0.2 * net.mesh.nodes[i][0], 0, 0);
  }
  const double S = 2e6 / (1 - 0.09) * 0.22;
  for (const auto& own :
       net.membranes.blocks()[0].values({u.data(), static_cast<std::size_t>(u.size())})) {
    EXPECT_NEAR(own.principal[0], 0.004 * S * 1.2, 1e-9 * S);
    EXPECT_NEAR(own.principal[1], 0.004 * 0.3 * S / 1.2, 1e-9 * S);
    EXPECT_NEAR(own.force[0], own.principal[0], 1e-9 * S);
    EXPECT_NEAR(own.strain, 0.2, 1e-12);
  }
}

/// Simple shear g of a sheet that wrinkles: E_1 = g^2 / 4 + g / 2 sqrt(1 + g^2 / 4), and one force
/// N = E t E_1 (1 + 2 E_1) along the wrinkles.
TEST(MembraneCells, forces_of_a_sheared_sheet_that_wrinkles) {
  const double g = 0.1, E_1 = g * g / 4 + g / 2 * std::sqrt(1 + g * g / 4);
  for (const bool triangles : {false, true}) {
    const Sheets net(sheet(3, 2, flat(1, 1), triangles), material(true));
    Eigen::VectorXd u(net.size());
    for (std::size_t i = 0; i < net.mesh.nodes.size(); ++i) {
      u.segment<3>(static_cast<Eigen::Index>(3 * i)) = Vector<3>(0, g * net.mesh.nodes[i][0], 0);
    }
    for (const auto& own :
         net.membranes.blocks()[0].values({u.data(), static_cast<std::size_t>(u.size())})) {
      EXPECT_EQ(own.state, MembraneState::wrinkled);
      EXPECT_NEAR(own.principal[0], 2e6 * 0.004 * E_1 * (1 + 2 * E_1), 1e-9);
      EXPECT_NEAR(own.principal[1], 0, 1e-9);
    }
  }
}

/// The prestress is the force over length and thickness in the mesh, whose boundary it pulls at.
TEST(MembraneCells, prestress_is_that_of_the_mesh) {
  for (const bool tension_only : {false, true}) {
    const Sheets net(sheet(4, 3, distorted_plane()), material(tension_only, 5e4));
    const Eigen::VectorXd u = Eigen::VectorXd::Zero(net.size());
    const Eigen::VectorXd f = net.forces(u);
    Vector<3> pull = Vector<3>::Zero();
    for (const std::int32_t i : net.mesh.node_groups.at("high")) {
      pull += f.segment<3>(static_cast<Eigen::Index>(3 * i));
    }
    EXPECT_NEAR(pull.dot(Vector<3>(std::cos(0.7), 0, std::sin(0.7))), 5e4 * 0.004, 1e-9);
    for (const auto& own :
         net.membranes.blocks()[0].values({u.data(), static_cast<std::size_t>(u.size())})) {
      EXPECT_NEAR(own.principal[0], 5e4 * 0.004, 1e-9);
      EXPECT_NEAR(own.principal[1], 5e4 * 0.004, 1e-9);
    }
  }
}

/// Lowest frequency of a square sheet of 2 m under tension, rim held: f = sqrt(2 N / m) / (2 L),
/// from above with the consistent mass, from below with the lumped one.
TEST(MembraneCells, frequency_of_a_prestressed_sheet) {
  MembraneMaterial net = material(false, 1e4);
  const double stretch = net.stretch(), mass = net.density * net.thickness / (stretch * stretch);
  const double exact = std::sqrt(2 * 1e4 * 0.004 / mass) / (2 * 2);
  for (const bool triangles : {false, true}) {
    for (const bool lumped : {false, true}) {
      std::vector<double> errors;
      for (const int n : {4, 8}) {
        Sheets sheets(sheet(n, n, flat(2, 2), triangles), net, lumped);
        const Eigen::MatrixXd K = sheets.tangent(Eigen::VectorXd::Zero(sheets.size()));
        const Eigen::MatrixXd M = sheets.mass();
        std::vector<Eigen::Index> free;  // across the plane
        std::vector<char> held(sheets.mesh.nodes.size(), 0);
        for (const std::int32_t i : sheets.mesh.node_groups.at("rim"))
          held[static_cast<std::size_t>(i)] = 1;
        for (std::size_t i = 0; i < held.size(); ++i) {
          if (!held[i]) free.push_back(static_cast<Eigen::Index>(3 * i + 2));
        }
        const Eigen::GeneralizedSelfAdjointEigenSolver<Eigen::MatrixXd> eigen(K(free, free),
                                                                              M(free, free));
        const double f = std::sqrt(eigen.eigenvalues()[0]) / (2 * std::numbers::pi);
        errors.push_back(f / exact - 1);
        EXPECT_NEAR(M.sum(), 3 * 4 * mass, 1e-10 * mass);
      }
      EXPECT_LT(std::abs(errors[1]), 0.02) << triangles << lumped;
      EXPECT_GT(std::log2(errors[0] / errors[1]), 1.8) << triangles << lumped;
      EXPECT_TRUE(triangles || (errors[1] < 0) == lumped);
    }
  }
}

}  // namespace
}  // namespace gabion::test::test_membrane_cells
