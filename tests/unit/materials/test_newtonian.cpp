// SPDX-License-Identifier: BSD-3-Clause
#include "common/mechanics/materials/newtonian.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "tests/unit/materials/random_state.hpp"

namespace gabion::testing::test_newtonian {
namespace {

constexpr double K = 2e6;

NewtonianParameters oil() {
  return {.bulk_modulus = K, .viscosity = 20};
}

/// Compressed by the Hencky strain `volumetric`, or torn where that is positive.
template <int dim>
MaterialState<dim> resting(double volumetric) {
  MaterialState<dim> state;
  if (volumetric > 0) {
    state.gap = volumetric;
  } else {
    state.e.template head<3>().setConstant(strain_from_hencky(volumetric / 3));
  }
  return state;
}

template <int dim>
void expect_tangent(double dt, double cavitation_pressure) {
  Random random(5);
  NewtonianParameters parameters = oil();
  parameters.cavitation_pressure = cavitation_pressure;
  const Newtonian<dim> fluid(parameters);
  const LawInStep<Newtonian<dim>, dim> law{fluid, {dt}};
  const double stiffest = K + (std::isfinite(dt) ? 2 * parameters.viscosity / dt : 0);
  int torn = 0, whole = 0;
  for (int sample = 0; sample < 200; ++sample) {
    const auto state_n = resting<dim>(random.uniform(-0.05, 0.05));
    const Matrix<dim> H = random.matrix<dim>(0.05);
    const auto found = stress<dim>(law, H, state_n);
    const double beyond = found.state.e.template head<3>().sum() / 2 + found.state.gap;
    if (std::abs(beyond - cavitation_pressure / K) < 1e-4) continue;  // too near to the kink
    Tangent<dim> A = tangent<dim>(law, H, state_n);
    const Tangent<dim> A_num = difference_tangent<dim>(law, H, state_n, 1e-6);
    const bool tears = found.region == YieldRegion::apex;
    const double allowed = tears ? 1e-4 * 1.5 * K * dim : 1e-7 * stiffest;
    ASSERT_LT((A - A_num).cwiseAbs().maxCoeff(), allowed) << sample << " at dt " << dt;
    ASSERT_LT((A - A.transpose()).cwiseAbs().maxCoeff(), 1e-12 * stiffest);
    ++(tears ? torn : whole);
  }
  EXPECT_GE(torn, 40);
  EXPECT_GE(whole, 40);
}

TEST(Newtonian, tangent_matches_differences) {
  for (const double dt : {1e-5, 1e-3, 1., std::numeric_limits<double>::infinity()}) {
    for (const double cavitation_pressure : {0., 1e4}) {
      expect_tangent<2>(dt, cavitation_pressure);
      expect_tangent<3>(dt, cavitation_pressure);
    }
  }
}

/// Simple shear of gamma in a step has ln(F F^T) / 2 of the size asinh(gamma / 2), turned by half
/// the angle whose tangent is gamma / 2 from the diagonal.
TEST(Newtonian, shear_stress_is_viscosity_times_rate_in_plane_and_space) {
  constexpr double rate = 50;
  for (const double dt : {1e-6, 1e-3, 1e-2}) {
    const double half = rate * dt / 2;
    const double expected = 2 * oil().viscosity / dt * std::asinh(half) / std::hypot(1, half);
    Matrix<2> H = Matrix<2>::Zero();
    H(0, 1) = rate * dt;
    const auto found =
        stress<2>(LawInStep<Newtonian<2>, 2>{Newtonian<2>(oil()), {dt}}, H, MaterialState<2>{});
    EXPECT_NEAR(found.tau[3], expected, 1e-10 * expected);
    EXPECT_EQ(found.region, YieldRegion::shear);
    Matrix<3> H_3 = Matrix<3>::Zero();
    H_3(0, 1) = rate * dt;
    const auto in_space =
        stress<3>(LawInStep<Newtonian<3>, 3>{Newtonian<3>(oil()), {dt}}, H_3, MaterialState<3>{});
    EXPECT_NEAR(in_space.tau[3], expected, 1e-10 * expected);
  }
}

/// Pulled along one axis at constant volume: the viscosity of Trouton, three times that in shear.
TEST(Newtonian, stretch_has_the_viscosity_of_trouton) {
  constexpr double dt = 1e-3, eps = 0.01;
  Matrix<3> H = Matrix<3>::Zero();
  H.diagonal() << std::expm1(eps), std::expm1(-eps / 2), std::expm1(-eps / 2);
  const auto found =
      stress<3>(LawInStep<Newtonian<3>, 3>{Newtonian<3>(oil()), {dt}}, H, MaterialState<3>{});
  EXPECT_NEAR(found.tau[0] - found.tau[1], 3 * oil().viscosity * eps / dt, 1e-6);
}

template <int dim>
void expect_objective() {
  Random random(3);
  for (int sample = 0; sample < 50; ++sample) {
    const auto state = resting<dim>(random.uniform(-0.05, 0.02));
    const Newtonian<dim> fluid(oil());
    const LawInStep<Newtonian<dim>, dim> law{fluid, {1e-3}};
    const Matrix<dim> R = random.rotation<dim>(), one = Matrix<dim>::Identity();
    const Matrix<dim> F = one + random.matrix<dim>(0.1);
    const auto plain = stress<dim>(law, F - one, state);
    const auto turned = stress<dim>(law, R * F - one, state);
    EXPECT_LT((turned.P - R * plain.P).cwiseAbs().maxCoeff(), 1e-9 * K);
    const auto only_turned = stress<dim>(law, R - one, state);
    EXPECT_NEAR(only_turned.plastic_increment.norm(), 0, 1e-12);
  }
}

TEST(Newtonian, rotations_turn_the_stress_and_make_none) {
  expect_objective<2>();
  expect_objective<3>();
}

/// Shear is not remembered; volume comes back to the same pressure.
TEST(Newtonian, remembers_the_volume_alone) {
  Random random(11);
  const Newtonian<3> fluid(oil());
  const LawInStep<Newtonian<3>, 3> law{fluid, {1e-3}};
  MaterialState<3> state = resting<3>(-0.2);
  double J = std::exp(-0.2);
  for (int step = 0; step < 50; ++step) {
    const auto found = stress<3>(law, random.matrix<3>(0.01), state);
    J *= found.J;
    state = found.state;
    EXPECT_NEAR(found.tau.head<3>().sum() / 3, K * std::log(J), 1e-8 * K);
    EXPECT_EQ(state.gap, 0);
  }
  const auto rests = stress<3>(law, Matrix<3>::Zero(), state);
  EXPECT_NEAR(rests.tau[0], K * std::log(J), 1e-8 * K);
  EXPECT_EQ(rests.tau[3], 0);
  EXPECT_EQ(rests.region, YieldRegion::elastic);
}

/// Opened volume has to close before pressure builds, whatever the path.
TEST(Newtonian, cavity_opens_and_closes_without_a_change_of_volume) {
  for (const double tension : {0., 1e4}) {
    NewtonianParameters parameters = oil();
    parameters.viscosity = 0;
    parameters.cavitation_pressure = tension;
    const Newtonian<2> fluid(parameters);
    const LawInStep<Newtonian<2>, 2> law{fluid, {1e-3}};
    MaterialState<2> state = resting<2>(-0.01);
    const auto by = [&](double volumetric) {
      const double stretch = std::expm1(volumetric / 2);
      Matrix<2> H = Matrix<2>::Zero();
      H.diagonal() << stretch, stretch;
      const auto found = stress<2>(law, H, state);
      state = found.state;
      return found;
    };
    auto found = by(0.2);
    EXPECT_EQ(found.region, YieldRegion::apex);
    EXPECT_NEAR(found.tau[0], tension, 1e-9 * K);
    EXPECT_NEAR(state.gap, 0.19 - tension / K, 1e-14);
    found = by(-0.1);
    EXPECT_NEAR(found.tau[0], tension, 1e-9 * K);
    found = by(-0.1);
    EXPECT_EQ(state.gap, 0);
    EXPECT_NEAR(found.tau[0], -0.01 * K, 1e-9 * K);
  }
}

/// The heat of a step is the work of its viscous stress, never negative.
TEST(Newtonian, viscous_work_is_heat) {
  Random random(2);
  for (int sample = 0; sample < 50; ++sample) {
    const Newtonian<3> fluid(oil());
    const auto found = stress<3>(LawInStep<Newtonian<3>, 3>{fluid, {1e-3}}, random.matrix<3>(0.05),
                                 resting<3>(-0.1));
    const double heat = (full<3>(found.tau).cwiseProduct(full<3>(found.plastic_increment))).sum();
    EXPECT_GT(heat, 0);
  }
}

TEST(Newtonian, without_time_or_in_the_end_there_is_pressure_alone) {
  Matrix<2> H = Matrix<2>::Zero();
  H(0, 1) = 0.1;
  const Newtonian<2> fluid(oil());
  StressUpdate<2> out;
  ASSERT_TRUE(fluid.update(H, resting<2>(-0.01), out, nullptr));
  EXPECT_NEAR(out.tau[3], 0, 1e-9 * K);
  EXPECT_NEAR(out.tau[0], -0.01 * K, 1e-9 * K);
  ASSERT_TRUE(fluid.update({.dt = 0}, H, resting<2>(-0.01), out, nullptr));
  EXPECT_NEAR(out.tau[3], 0, 1e-9 * K);
  H(0, 0) = -1.1;
  EXPECT_FALSE(fluid.update({.dt = 1}, H, resting<2>(-0.01), out, nullptr));
  EXPECT_EQ(out.refusal, Refusal::squeezed);
}

}  // namespace
}  // namespace gabion::testing::test_newtonian
