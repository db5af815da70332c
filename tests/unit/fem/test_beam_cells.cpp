// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include <Eigen/Eigenvalues>
#include <Eigen/Geometry>
#include <cmath>
#include <numbers>
#include <random>

#include "tests/support/check_tangent.hpp"
#include "tests/unit/fem/beam_scene.hpp"

namespace gabion::test::test_beam_cells {
namespace {

using Eigen::MatrixXd;
using Eigen::VectorXd;

constexpr double E = 1e4;

Json skew_beam() {
  Json material = beam_material(E, 0.25, rectangle(0.3, 0.2), 10);
  material["orientation"] = {0.2, 1, 0.4};
  return material;
}

template <int dim>
fem::FemSettings<dim> settings_of(const LineText& text) {
  const TemporaryMesh mesh(text.file());
  Json material = skew_beam();
  if (dim == 2) material.erase("orientation");
  return fem_settings<dim>(line_scene(dim, mesh.path(), material));
}

template <int dim>
fem::CellIntegrals<dim> integrals(const fem::FemSettings<dim>& settings) {
  return {settings.mesh,
          settings.materials,
          settings.lumped_mass,
          {},
          fem::LinesOfMesh<dim>{settings.line_materials, settings.beam_nodes()}};
}

LineText bent_chain() {
  LineText text = chain(3, 3);
  text.nodes[1][1] = 0.3;
  text.nodes[2][0] = 1.7;
  return text;
}

/// Forces of a chain from unknowns, of places and then of rotations.
template <int dim>
struct Chain {
  fem::FemSettings<dim> settings;
  fem::CellIntegrals<dim> cells = integrals(settings);
  std::vector<double> accepted = std::vector<double>(cells.history_size(), 0.0);
  std::vector<double> trial = accepted;
  double energy = 0;

  std::size_t size() const { return settings.mesh.nodes.size() * dim; }
  VectorXd forces(const VectorXd& u, BlockMatrix<dim>* K = nullptr) {
    VectorXd f = VectorXd::Zero(u.size());
    const auto sum = cells.add_internal({u.data(), size()}, {f.data(), size()}, K,
                                        {.accepted = accepted, .trial = trial});
    EXPECT_EQ(sum.inadmissible_cell, -1) << sum.fault;
    energy = sum.energy;
    return f;
  }
  MatrixXd stiffness(const VectorXd& u) {
    BlockMatrix<dim> K;
    cells.set_pattern(K);
    K.set_zero();
    forces(u, &K);
    MatrixXd dense(size(), size());
    for (std::size_t i = 0; i < size(); ++i) {
      VectorXd x = VectorXd::Unit(dense.cols(), i), y = x;
      K.multiply({x.data(), size()}, {y.data(), size()});
      dense.col(i) = y;
    }
    return dense;
  }
};

/// Random unknowns of places and rotations; the second unknown of a rotation in the plane means
/// nothing.
template <int dim>
VectorXd random_unknowns(const Chain<dim>& chain, double size, int seed) {
  std::mt19937 random(seed);
  std::uniform_real_distribution<double> shift(-size, size);
  VectorXd u(chain.size());
  for (double& x : u) x = shift(random);
  return u;
}

template <int dim>
void expect_exact_tangent() {
  Chain<dim> chain{settings_of<dim>(bent_chain())};
  for (const double size : {0.0, 1e-3, 0.3}) {
    const VectorXd u_n = random_unknowns(chain, size, 3);
    chain.accepted.assign(chain.accepted.size(), 0.0);
    chain.forces(u_n);
    chain.accepted = chain.trial;  // turned already
    const VectorXd u = u_n + random_unknowns(chain, size, 4);
    const MatrixXd K = chain.stiffness(u);
    const auto force = [&](const VectorXd& at) { return chain.forces(at); };
    EXPECT_LT(tangent_error(force, u, K, 1e-3), 1e-9) << dim << " " << size;
  }
}

TEST(BeamCells, tangent_against_differences) {
  expect_exact_tangent<2>();
  expect_exact_tangent<3>();
}

/// In the plane, forces are the derivative of the energy; in space this holds at the start of a
/// step, with moments on spins.
template <int dim>
void expect_forces_of_energy() {
  Chain<dim> chain{settings_of<dim>(bent_chain())};
  const VectorXd u = random_unknowns(chain, 0.2, 5);
  chain.forces(u);
  chain.accepted = chain.trial;
  const auto energy = [&](const VectorXd& at) {
    chain.forces(at);
    return VectorXd(VectorXd::Constant(1, chain.energy));
  };
  const MatrixXd slope = difference_tangent(energy, u, 1e-3);
  const VectorXd f = chain.forces(u);
  EXPECT_LT((slope.row(0).transpose() - f).cwiseAbs().maxCoeff(), 1e-9 * f.cwiseAbs().maxCoeff());
}

TEST(BeamCells, forces_are_the_slope_of_the_energy) {
  expect_forces_of_energy<2>();
  expect_forces_of_energy<3>();
}

/// Unknowns of a chain that turns as a rigid body.
VectorXd rigid_turn(const Chain<3>& chain, const Vector<3>& turn) {
  const Matrix<3> R = Eigen::AngleAxisd(turn.norm(), turn.normalized()).toRotationMatrix();
  VectorXd u(chain.size());
  const auto places = static_cast<std::size_t>(chain.settings.num_places());
  for (std::size_t i = 0; i < chain.settings.mesh.nodes.size(); ++i) {
    const Vector<3>& x = chain.settings.mesh.nodes[i];
    u.segment<3>(3 * i) =
        i < places ? Vector<3>(R * x - x) : Vector<3>(chain.settings.rotation_length * turn);
  }
  return u;
}

TEST(BeamCells, a_rigid_rotation_is_no_strain) {
  Chain<3> chain{settings_of<3>(bent_chain())};
  const VectorXd u = rigid_turn(chain, {0.5, -1.1, 1.4});
  EXPECT_LT(chain.forces(u).cwiseAbs().maxCoeff(), 1e-12 * E);
  EXPECT_LT(chain.energy, 1e-20 * E);
}

/// A rotation on top of a deformed state turns the forces and keeps the energy.
TEST(BeamCells, objective) {
  Chain<3> chain{settings_of<3>(bent_chain())};
  const VectorXd u = random_unknowns(chain, 0.2, 6);
  const VectorXd f = chain.forces(u);
  const double energy = chain.energy;
  chain.accepted = chain.trial;
  const Vector<3> turn(0.4, 1.2, -0.7);
  const Matrix<3> R = Eigen::AngleAxisd(turn.norm(), turn.normalized()).toRotationMatrix();
  VectorXd turned = u;
  const auto places = static_cast<std::size_t>(chain.settings.num_places());
  for (std::size_t i = 0; i < chain.settings.mesh.nodes.size(); ++i) {
    const Vector<3>& x = chain.settings.mesh.nodes[i];
    if (i < places) {
      turned.segment<3>(3 * i) = R * (x + u.segment<3>(3 * i)) - x;
    } else {
      turned.segment<3>(3 * i) += chain.settings.rotation_length * turn;
    }
  }
  const VectorXd g = chain.forces(turned);
  EXPECT_NEAR(chain.energy, energy, 1e-12 * energy);
  for (std::size_t i = 0; i < chain.settings.mesh.nodes.size(); ++i) {
    EXPECT_LT((g.segment<3>(3 * i) - R * f.segment<3>(3 * i)).norm(), 1e-12 * f.norm()) << i;
  }
}

/// Forces and moments of a cell balance in any state.
TEST(BeamCells, balance) {
  Chain<3> chain{settings_of<3>(bent_chain())};
  const VectorXd u = random_unknowns(chain, 0.3, 8);
  const VectorXd f = chain.forces(u);
  Vector<3> force = Vector<3>::Zero(), moment = Vector<3>::Zero();
  const auto places = static_cast<std::size_t>(chain.settings.num_places());
  for (std::size_t i = 0; i < chain.settings.mesh.nodes.size(); ++i) {
    const Vector<3> own = f.segment<3>(3 * i);
    if (i < places) {
      force += own;
      moment += Vector<3>(chain.settings.mesh.nodes[i] + u.segment<3>(3 * i)).cross(own);
    } else {
      moment += chain.settings.rotation_length * own;
    }
  }
  EXPECT_LT(force.norm(), 1e-13 * f.norm());
  EXPECT_LT(moment.norm(), 1e-12 * f.norm());
}

TEST(BeamCells, a_free_beam_has_rigid_modes_only) {
  Chain<3> space{settings_of<3>(bent_chain())};
  const Eigen::SelfAdjointEigenSolver<MatrixXd> modes(space.stiffness(VectorXd::Zero(24)));
  EXPECT_LT(std::abs(modes.eigenvalues()[5]), 1e-9 * modes.eigenvalues()[23]);
  EXPECT_GT(modes.eigenvalues()[6], 1e-6 * modes.eigenvalues()[23]);
  Chain<2> plane{settings_of<2>(bent_chain())};  // and 4 unknowns without meaning
  const Eigen::SelfAdjointEigenSolver<MatrixXd> of_plane(plane.stiffness(VectorXd::Zero(16)));
  EXPECT_LT(std::abs(of_plane.eigenvalues()[6]), 1e-9 * of_plane.eigenvalues()[15]);
  EXPECT_GT(of_plane.eigenvalues()[7], 1e-6 * of_plane.eigenvalues()[15]);
}

/// A turn of 3 rad in a step is refused, not computed.
TEST(BeamCells, refuses_large_steps) {
  Chain<3> chain{settings_of<3>(bent_chain())};
  const VectorXd u = rigid_turn(chain, {0, 0, 3.01});
  VectorXd f = VectorXd::Zero(u.size());
  const auto sum =
      chain.cells.add_internal({u.data(), chain.size()}, {f.data(), chain.size()}, nullptr,
                               {.accepted = chain.accepted, .trial = chain.trial});
  EXPECT_EQ(sum.inadmissible_cell, 0);
  EXPECT_STREQ(sum.fault, "a rotation of 3 rad in a step");
}

}  // namespace
}  // namespace gabion::test::test_beam_cells
