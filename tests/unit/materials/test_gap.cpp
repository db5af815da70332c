// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include "tests/unit/materials/random_state.hpp"

namespace gabion::testing::test_gap {
namespace {

constexpr double lambda = 1.7e6, mu = 0.9e6, bulk = lambda + 2 * mu / 3;

template <class Parameters>
Parameters soil(double psi, double cohesion, ApexVolume apex_volume) {
  return {.lambda = lambda,
          .mu = mu,
          .friction_angle = 30 * degree,
          .dilation_angle = psi * degree,
          .cohesion = cohesion,
          .apex_volume = apex_volume};
}
constexpr auto mohr = soil<MohrCoulombParameters>;
constexpr auto cone = soil<DruckerPragerParameters>;

template <int dim>
double elastic_volume(const MaterialState<dim>& state) {
  return principal<dim>(state.e).unaryExpr([](double x) { return 0.5 * std::log1p(x); }).sum();
}

/// With psi = 0 the plastic flow off the apex keeps the volume, so that elastic volume and gap add
/// up to ln J on any path.
template <int dim>
void expect_volume_balance(const auto& law) {
  Random random(71);
  MaterialState<dim> state;
  double log_J = 0;
  int open = 0, closed = 0;
  for (int step = 0; step < 3000; ++step) {
    // the mean volume drifts to and fro between -2 % and 6 %
    const double drive = log_J > 0.06 ? -1 : log_J < -0.02 ? 1 : random.uniform(-1, 1);
    const Matrix<dim> H = random.matrix<dim>(0.01) + 0.004 * drive * Matrix<dim>::Identity();
    const auto out = stress<dim>(law, H, state);
    state = out.state;
    log_J += std::log(out.J);
    ASSERT_NEAR(elastic_volume<dim>(state) + state.gap, log_J, 1e-12) << "step " << step;
    ASSERT_GE(state.gap, -1e-16);
    (state.gap > 1e-3 ? open : closed) += 1;
  }
  EXPECT_GT(open, 300);
  EXPECT_GT(closed, 300);
}

TEST(Gap, and_elastic_volume_add_up_to_the_volume) {
  for (const double cohesion : {0.0, 2e4}) {
    expect_volume_balance<2>(MohrCoulomb<2>(mohr(0, cohesion, ApexVolume::gap)));
    expect_volume_balance<3>(MohrCoulomb<3>(mohr(0, cohesion, ApexVolume::gap)));
    expect_volume_balance<2>(DruckerPrager<2>(cone(0, cohesion, ApexVolume::gap)));
    expect_volume_balance<3>(DruckerPrager<3>(cone(0, cohesion, ApexVolume::gap)));
  }
}

/// Splash: open by 20 % of volume in steps, stir, close, `cycles` times over; returns the mean
/// stress that is left at the volume of the start.
template <int dim>
double mean_stress_after_splashes(const auto& law, int cycles) {
  Random random(73);
  constexpr int steps = 20;
  const double stretch = std::pow(1.2, 1.0 / (steps * dim));
  MaterialState<dim> state;
  for (int cycle = 0; cycle < cycles; ++cycle) {
    for (int step = 0; step < steps; ++step)
      state = stress<dim>(law, (stretch - 1) * Matrix<dim>::Identity(), state).state;
    for (int step = 0; step < steps; ++step) {
      const Matrix<dim> H = random.rotation<dim>() - Matrix<dim>::Identity();
      state = stress<dim>(law, H, state).state;
    }
    for (int step = 0; step < steps; ++step)
      state = stress<dim>(law, (1 / stretch - 1) * Matrix<dim>::Identity(), state).state;
  }
  return trace<dim>(stress<dim>(law, Matrix<dim>::Zero(), state).tau) / 3;
}

/// The reason for the default: a splash must not leave pressure behind, that is, more volume
/// without stress than before. Forgetting, each splash adds its volume.
template <int dim>
void expect_no_growth(const auto& keeps, const auto& forgets) {
  for (const int cycles : {1, 10}) {
    EXPECT_NEAR(mean_stress_after_splashes<dim>(keeps, cycles), 0, 1e-12 * bulk);
  }
  EXPECT_NEAR(mean_stress_after_splashes<dim>(forgets, 1), -bulk * std::log(1.2), 1e-9 * bulk);
}

TEST(Gap, net_volume_without_stress_does_not_grow_in_splashes) {
  EXPECT_EQ(MohrCoulombParameters{}.apex_volume, ApexVolume::gap);
  EXPECT_EQ(DruckerPragerParameters{}.apex_volume, ApexVolume::gap);
  const auto gap = ApexVolume::gap, forget = ApexVolume::forget;
  // in plane strain the splash shears the point as well, which dilates it if psi > 0
  expect_no_growth<2>(MohrCoulomb<2>(mohr(0, 0, gap)), MohrCoulomb<2>(mohr(0, 0, forget)));
  expect_no_growth<2>(DruckerPrager<2>(cone(0, 0, gap)), DruckerPrager<2>(cone(0, 0, forget)));
  for (const double psi : {0.0, 10.0}) {
    expect_no_growth<3>(MohrCoulomb<3>(mohr(psi, 0, gap)), MohrCoulomb<3>(mohr(psi, 0, forget)));
    expect_no_growth<3>(DruckerPrager<3>(cone(psi, 0, gap)),
                        DruckerPrager<3>(cone(psi, 0, forget)));
  }
}

/// One step that closes the gap half-way builds the stress of the rest of its volume change; an
/// open gap stays as it is when nothing moves.
TEST(Gap, closes_before_pressure_builds) {
  const MohrCoulomb<3> law(mohr(0, 0, ApexVolume::gap));
  const Matrix<3> one = Matrix<3>::Identity();
  const auto opened = stress<3>(law, (std::exp(0.01) - 1) * one, {});
  EXPECT_EQ(opened.region, YieldRegion::apex);
  EXPECT_NEAR(opened.state.gap, 0.03, 1e-15);
  EXPECT_EQ(opened.state.plastic_strain, 0);
  const auto idle = stress<3>(law, Matrix<3>::Zero(), opened.state);
  EXPECT_EQ(idle.state.gap, opened.state.gap);
  EXPECT_EQ(idle.tau.norm(), 0);

  const auto half = stress<3>(law, (std::exp(-0.005) - 1) * one, opened.state);
  EXPECT_NEAR(half.state.gap, 0.015, 1e-15);
  EXPECT_EQ(half.tau.norm(), 0);

  const auto closed = stress<3>(law, (std::exp(-0.015) - 1) * one, opened.state);
  EXPECT_EQ(closed.region, YieldRegion::elastic);
  EXPECT_EQ(closed.state.gap, 0);
  for (int i = 0; i < 3; ++i) EXPECT_NEAR(closed.tau[i], -3 * bulk * 0.005, 1e-12 * bulk);
  const auto again = stress<3>(law, Matrix<3>::Zero(), closed.state);
  EXPECT_LT((again.tau - closed.tau).norm(), 1e-12 * bulk);
}

/// Cohesive soil keeps the tension of its apex while the gap is open.
TEST(Gap, of_cohesive_soil_opens_at_the_apex_stress) {
  const double c = 2e4, apex = c / std::tan(30 * degree);
  const MohrCoulomb<2> law(mohr(0, c, ApexVolume::gap));
  const auto opened = stress<2>(law, 0.05 * Matrix<2>::Identity(), {});
  for (int i = 0; i < 3; ++i) EXPECT_NEAR(opened.tau[i], apex, 1e-12 * apex);
  EXPECT_NEAR(opened.state.gap, 2 * std::log(1.05) - apex / bulk, 1e-15);
}

}  // namespace
}  // namespace gabion::testing::test_gap
