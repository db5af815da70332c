// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include <cmath>

#include "common/mechanics/materials/herschel_bulkley.hpp"
#include "tests/unit/materials/random_state.hpp"

namespace gabion::testing::test_herschel_bulkley {
namespace {

constexpr double lambda = 5e6, mu = 1e5, M = lambda + 2 * mu;

template <int dim>
using InSteps = LawInStep<HerschelBulkley<dim>, dim>;

HerschelBulkleyParameters mud(double yield_stress, double consistency, double flow_index) {
  return {lambda, mu, yield_stress, consistency, flow_index};
}

class Fluid : public ::testing::TestWithParam<double> {};

TEST_P(Fluid, flow_solves_its_equation_over_many_orders) {
  for (const double K : {1e-3, 1., 50., 1e4}) {
    for (const double dt : {1e-7, 1e-4, 1e-2, 10.}) {
      for (const double excess : {1e-9, 1e-3, 1., 1e5}) {
        const auto law = mud(0, K, GetParam());
        ViscousFlow flow;
        ASSERT_TRUE(solve_viscous_flow(law, excess, dt, flow));
        const double found = mu * flow.shear + K * std::pow(flow.shear / dt, law.flow_index);
        EXPECT_NEAR(found, excess, 1e-12 * excess) << K << " " << dt;
        EXPECT_GE(flow.slope, 0);
        EXPECT_LE(flow.slope, 1);
      }
    }
  }
}

template <int dim>
void expect_tangent(const HerschelBulkleyParameters& parameters, double dt) {
  Random random(7);
  const HerschelBulkley<dim> fluid(parameters);
  const InSteps<dim> law{fluid, {dt}};
  int flowing = 0;
  for (int sample = 0; sample < 200; ++sample) {
    MaterialState<dim> state_n;
    state_n.e = random.elastic_strain<dim>(0.01, 0.005);
    const Matrix<dim> H = random.matrix<dim>(0.02);
    const auto found = stress<dim>(law, H, state_n);
    const Tangent<dim> A_num = difference_tangent<dim>(law, H, state_n, 1e-6);
    ASSERT_LT((tangent<dim>(law, H, state_n) - A_num).cwiseAbs().maxCoeff(), 1e-7 * M) << sample;
    if (found.plastic()) ++flowing;
    EXPECT_NEAR(
        found.plastic_increment[0] + found.plastic_increment[1] + found.plastic_increment[2], 0,
        1e-14);
  }
  EXPECT_GE(flowing, 100);
}

TEST_P(Fluid, tangent_matches_differences) {
  for (const double dt : {1e-5, 1e-3, 1.}) {
    expect_tangent<2>(mud(200, 20, GetParam()), dt);
    expect_tangent<3>(mud(200, 20, GetParam()), dt);
  }
  expect_tangent<2>(mud(0, 20, GetParam()), 1e-3);
  expect_tangent<3>(mud(0, 20, GetParam()), 1e-3);
}

/// Shear stress after steady simple shear at a rate, in steps of dt, to a strain of 10.
template <int dim>
double sheared(const HerschelBulkley<dim>& law, double rate, double dt) {
  MaterialState<dim> state;
  StressUpdate<dim> out;
  Matrix<dim> H = Matrix<dim>::Zero();
  H(0, 1) = rate * dt;
  const int steps = static_cast<int>(std::lround(10 / (rate * dt)));
  for (int k = 0; k < steps; ++k) {
    EXPECT_TRUE(law.update({.dt = dt}, H, state, out, nullptr));
    state = out.state;
  }
  return out.tau[3];
}

/// The elastic strain r = tau / mu turns the axes of stress and takes its part of the shear rate,
/// in leading order (1 + n) / 2 r^2 of the shear stress; steps take parts of step r and step^2.
TEST_P(Fluid, steady_shear_bears_the_flow_curve) {
  for (const double rate : {0.1, 10.}) {
    const auto law = mud(100, 50, GetParam());
    const double expected = 100 + 50 * std::pow(rate, GetParam());
    for (const double step : {1e-3, 1e-2}) {
      const double r = expected / mu;
      const double allowed =
          (0.5 * (1 + GetParam()) * r * r + 1.5 * step * r + step * step / 8) * expected;
      EXPECT_NEAR(sheared<2>(HerschelBulkley<2>(law), rate, step / rate), expected, allowed);
      EXPECT_NEAR(sheared<3>(HerschelBulkley<3>(law), rate, step / rate), expected, allowed);
    }
  }
}

INSTANTIATE_TEST_SUITE_P(FlowIndex, Fluid, ::testing::Values(0.1, 0.5, 1.0, 1.7, 2.0));

TEST(HerschelBulkley, is_elastic_without_time_and_below_the_yield_stress) {
  Random random(9);
  for (int sample = 0; sample < 50; ++sample) {
    MaterialState<2> state;
    state.e = random.elastic_strain<2>(0.01, 0);
    const Matrix<2> H = random.matrix<2>(0.02);
    const auto elastic = stress<2>(HenckyElastic<2>{lambda, mu}, H, state);
    const auto at_once = stress<2>(HerschelBulkley<2>(mud(1, 20, 1)), H, state);
    const HerschelBulkley<2> fluid(mud(1e9, 20, 1));
    const auto strong = stress<2>(InSteps<2>{fluid, {1.}}, H, state);
    EXPECT_LT((at_once.tau - elastic.tau).cwiseAbs().maxCoeff(), 1e-9 * mu);
    EXPECT_LT((strong.tau - elastic.tau).cwiseAbs().maxCoeff(), 1e-9 * mu);
    EXPECT_FALSE(at_once.plastic() || strong.plastic());
  }
}

/// A plug at rest keeps its yield stress, a Newtonian fluid relaxes by 1 / (1 + mu dt / K) a step.
TEST(HerschelBulkley, shear_stress_relaxes_to_the_yield_stress) {
  constexpr double K = 100, dt = 1e-4;
  for (const double yield_stress : {0., 100.}) {
    const HerschelBulkley<2> law(mud(yield_stress, K, 1));
    MaterialState<2> state;
    state.e << 0, 0, 0, 0.01;
    double over = stress<2>(law, Matrix<2>::Zero(), state).tau[3] - yield_stress;
    StressUpdate<2> out;
    for (int k = 0; k < 20; ++k) {
      ASSERT_TRUE(law.update({.dt = dt}, Matrix<2>::Zero(), state, out, nullptr));
      over /= 1 + mu * dt / K;
      EXPECT_NEAR(out.tau[3] - yield_stress, over, 2e-4 * (yield_stress + over));
      state = out.state;
    }
  }
}

}  // namespace
}  // namespace gabion::testing::test_herschel_bulkley
