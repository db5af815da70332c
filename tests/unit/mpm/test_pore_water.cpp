// SPDX-License-Identifier: BSD-3-Clause
// Pore water without drainage: its pressure, what it adds to stress and tangent, shared volumes.
#include <gtest/gtest.h>

#include <Eigen/LU>
#include <cmath>
#include <numbers>
#include <optional>

#include "mpm_solver/stress/internal_forces.hpp"
#include "mpm_solver/stress/shared_volumes.hpp"
#include "tests/support/check_tangent.hpp"
#include "tests/unit/mpm/soil_patch.hpp"

namespace gabion::test::test_pore_water {
namespace {

using Eigen::VectorXd;

constexpr mpm::PoreWater water{
    .porosity = 0.4, .bulk_modulus = 2.2e9, .density = 1000, .table = std::nullopt};

TEST(PoreWater, pressure_of_a_volume) {
  const double content = water.content_at(0, 1);
  EXPECT_DOUBLE_EQ(content, 0.4);
  // -K_w ln((J - 1 + n0) / n0), and K_w / n of the present porosity.
  EXPECT_NEAR(water.at(content, 0.99).p, 55.6992e6, 50);
  EXPECT_NEAR(water.at(content, 0.99).stiffness, 2.2e9 / (1 - 0.6 / 0.99), 1);
  EXPECT_NEAR(water.modulus(), 5.5e9, 1e-3);
  // A small change of volume is resolved to rounding.
  EXPECT_NEAR(water.at(content, 1 - 1e-9).p, 5.5, 1e-6);
}

TEST(PoreWater, begins_under_a_given_pressure) {
  for (const double p : {0.0, 1e3, 2e5}) {
    for (const double J : {1.0, 0.997, 1.02}) {
      EXPECT_NEAR(water.at(water.content_at(p, J), J).p, p, 1e-5);
    }
  }
}

TEST(PoreWater, gives_way_at_the_limit_of_suction) {
  mpm::PoreWater sucking = water;
  sucking.cavitation = 5e4;
  const double content = 0.4;
  EXPECT_NEAR(sucking.at(content, 1 + 4e-6).p, -2.2e4, 1);
  EXPECT_EQ(sucking.at(content, 1.1).p, -5e4);
  EXPECT_EQ(sucking.at(content, 1.1).stiffness, 0);
  EXPECT_EQ(water.at(content, 1.001).p, 0);
  EXPECT_EQ(water.at(content, 1).p, 0);
}

TEST(PoreWater, energy_is_the_work_of_the_pressure) {
  mpm::PoreWater sucking = water;
  sucking.cavitation = 1e6;
  const double content = sucking.content_at(3e4, 0.99);
  for (const double J : {0.95, 0.989, 0.9901, 1.0, 1.05}) {
    const double d = 1e-5;
    const auto energy = [&](double at) { return sucking.at(content, at).energy; };
    const double slope =
        (8 * (energy(J + d) - energy(J - d)) - energy(J + 2 * d) + energy(J - 2 * d)) / (12 * d);
    EXPECT_NEAR(slope, -sucking.at(content, J).p, 1e-6 * 2.2e9 * 1e-2) << J;
  }
}

/// Internal forces of saturated soil under F-bar.
template <int dim>
struct SaturatedForces {
  SoilPatch<dim> soil;
  mpm::TrialPoints<dim> trial;
  std::optional<mpm::InternalForces<dim>> internal;
  BlockMatrix<dim> K;

  SaturatedForces(CellType type, const MaterialLaw<dim>& law, mpm::Basis basis)
      : soil(type, 2, basis) {
    soil.fill(type == CellType::tri3 ? 3 : type == CellType::hex8 ? 8 : 4);
    soil.bodies = {{"soil", {"", 1, law}, water}};
    if (num_nodes(type) == dim + 1) {
      soil.grid.patches = mpm::join_cells(soil.mesh, soil.grid.stored->locator);
    }
    soil.grid.splits_border = basis == mpm::Basis::bspline;
    auto& points = soil.points;
    mpm::add_water<dim>(soil.bodies, points);
    for (std::int32_t p = 0; p < points.size(); ++p) {
      points.J[p] = 0.99 + 0.005 * soil.random();
      points.water[p] = water.content_at(1e6 * (1 + soil.random()), points.J[p]);
      points.history[p].e.template head<3>().setConstant(-0.02 * (1 + 0.2 * soil.random()));
    }
    soil.to_grid();
    internal.emplace(mpm::StressParts<dim>{.bodies = soil.bodies,
                                           .points = points,
                                           .weights = soil.weights,
                                           .nodes = soil.nodes,
                                           .trial = trial},
                     0.5, 0, true);
    soil.set_pattern(K);
  }
  VectorXd forces(const VectorXd& du, BlockMatrix<dim>* matrix = nullptr) {
    mpm::RefusedPoint worst;
    EXPECT_TRUE(
        internal->evaluate({du.data(), static_cast<std::size_t>(du.size())}, matrix, worst));
    return Eigen::Map<const VectorXd>(internal->forces().data(), du.size());
  }
  Eigen::MatrixXd matrix(const VectorXd& du) {
    forces(du, &K);
    Eigen::MatrixXd dense(du.size(), du.size());
    VectorXd unit = VectorXd::Zero(du.size()), column(du.size());
    for (Eigen::Index k = 0; k < du.size(); ++k) {
      unit[k] = 1;
      K.multiply({unit.data(), soil.num_dofs()}, {column.data(), soil.num_dofs()});
      dense.col(k) = column;
      unit[k] = 0;
    }
    return dense;
  }
};

template <int dim>
void check_tangent(CellType type, const MaterialLaw<dim>& law, mpm::Basis basis) {
  SaturatedForces<dim> wet(type, law, basis);
  const auto values = wet.soil.random.values(wet.soil.num_dofs(), 2e-3);
  const VectorXd du = Eigen::Map<const VectorXd>(values.data(), std::ssize(values));
  const Eigen::MatrixXd tangent = wet.matrix(du);
  EXPECT_LT(tangent_error([&](const VectorXd& x) { return wet.forces(x); }, du, tangent, 1e-6),
            1e-7)
      << name(type) << " " << mpm::basis_name(basis) << " law " << law.index();
  EXPECT_LT((tangent - tangent.transpose()).cwiseAbs().maxCoeff(),
            1e-12 * tangent.cwiseAbs().maxCoeff());
}

TEST(PoreWater, tangent_of_the_forces) {
  for_each_basis([]<int dim>(CellType type, mpm::Basis basis) {
    constexpr double lambda = 1.2e7, mu = 0.8e7;
    check_tangent<dim>(type, HenckyElastic<dim>{lambda, mu}, basis);
    if (basis != mpm::Basis::linear) return;
    check_tangent<dim>(
        type,
        Tresca<dim>({.lambda = lambda, .mu = mu, .cohesion = 1e4, .tension_cutoff = no_cutoff}),
        basis);
  });
  check_tangent<2>(CellType::quad4, NeoHookean<2>{1.2e7, 0.8e7}, mpm::Basis::linear);
  check_tangent<3>(CellType::hex8, NeoHookean<3>{1.2e7, 0.8e7}, mpm::Basis::linear);
}

/// Total stress is that of the law less the pressure, and both are told apart.
TEST(PoreWater, total_and_effective_stress) {
  SaturatedForces<2> wet(CellType::quad4, HenckyElastic<2>{1.2e7, 0.8e7}, mpm::Basis::linear);
  SaturatedForces<2> dry(CellType::quad4, HenckyElastic<2>{1.2e7, 0.8e7}, mpm::Basis::linear);
  dry.soil.bodies[0].water.reset();
  const VectorXd du = VectorXd::Zero(std::ssize(wet.internal->forces()));
  wet.forces(du);
  dry.forces(du);
  for (std::int32_t e = 0; e < wet.soil.points.size(); ++e) {
    const std::int32_t p = wet.soil.weights.point[e];
    const double Jp = mpm::pore_tau<2>(wet.soil.bodies[0], wet.soil.points, p);
    EXPECT_GT(Jp, 0);
    EXPECT_NEAR((wet.trial.effective_tau(e) - dry.trial.tau[e]).norm(), 0, 1e-6);
    EXPECT_NEAR(dry.trial.tau[e][2] - wet.trial.tau[e][2], Jp, 1e-6);
    EXPECT_NEAR(wet.trial.pore_tau[e], Jp, 1e-6);
  }
}

TEST(PoreWater, closed_pores_are_inadmissible) {
  SaturatedForces<2> wet(CellType::quad4, HenckyElastic<2>{1.2e7, 0.8e7}, mpm::Basis::linear);
  std::vector<double> du(wet.soil.num_dofs());
  for (std::int32_t i = 0; i < wet.soil.nodes.size(); ++i) du[2 * i] = -0.39 * wet.soil.node(i)[0];
  mpm::RefusedPoint worst;
  EXPECT_FALSE(wet.internal->evaluate(du, nullptr, worst));
  EXPECT_GE(worst.point, 0);
  EXPECT_EQ(worst.refusal, Refusal::pores_closed);
}

/// Points of a group share the pressure over that of water at rest; volume and water are kept, and
/// the skeleton keeps its stress.
TEST(PoreWater, shared_pressure) {
  SoilPatch<2> soil(CellType::quad4, 1);
  soil.fill(4, 2000);
  mpm::PoreWater ground = water;
  ground.table = 0.8;
  ground.specific_weight = 9810;
  soil.bodies = {{"soil", {"", 2000, HenckyElastic<2>{1.2e7, 0.8e7}}, ground}};
  auto& points = soil.points;
  mpm::add_water<2>(soil.bodies, points);
  const double excess[] = {5e3, 1e3, 2e3, 4e3};
  for (std::int32_t p = 0; p < 4; ++p) {
    const double at_rest = ground.hydrostatic(points.x[p][1]);
    points.J[p] = 0.998 - 1e-4 * p;
    points.water[p] = ground.content_at(at_rest + excess[p], points.J[p]);
    points.history[p].e.head<3>().setConstant(-1e-3 * p);
    StressUpdate<2> skeleton;
    ASSERT_TRUE(update<2>(soil.bodies[0].material.law, Matrix<2>::Zero(), points.history[p],
                          skeleton, nullptr));
    points.tau[p] = skeleton.tau;
    points.tau[p].head<3>().array() -= points.J[p] * (at_rest + excess[p]);
    points.energy[p] = skeleton.energy + ground.at(points.water[p], points.J[p]).energy;
  }
  soil.to_grid();
  const auto effective = [&] {
    std::vector<Symmetric<2>> room;
    const auto all = mpm::skeleton_stresses<2>(soil.bodies, points, room);
    return std::vector<Symmetric<2>>(all.begin(), all.end());
  };
  const auto volume = [&] {
    double sum = 0;
    for (std::int32_t p = 0; p < 4; ++p) sum += points.V0[p] * points.J[p];
    return sum;
  };
  const auto energy = [&] {
    double sum = 0;
    for (std::int32_t p = 0; p < 4; ++p) sum += points.V0[p] * points.energy[p];
    return sum;
  };
  const double V = volume(), E = energy();
  const auto before = effective();
  const double lost = mpm::share_volumes<2>(soil.owners(), soil.bodies, points);
  EXPECT_NEAR(volume(), V, 1e-15);
  EXPECT_NEAR(lost, E - energy(), 1e-10);
  const auto after = effective();
  double first = 0;
  for (std::int32_t p = 0; p < 4; ++p) {
    const double over = mpm::pore_tau<2>(soil.bodies[0], points, p) / points.J[p] -
                        ground.hydrostatic(points.x[p][1]);
    if (p == 0) first = over;
    EXPECT_NEAR(over, first, 1e-5);
    EXPECT_NEAR((after[p] - before[p]).norm(), 0, 1e-5);
  }
  EXPECT_NEAR(first, 3e3, 50);
  EXPECT_EQ(mpm::share_volumes<2>(soil.owners(), soil.bodies, points), 0);  // nothing is left to do
}

}  // namespace
}  // namespace gabion::test::test_pore_water
