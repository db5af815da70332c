// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include <limits>

#include "tests/unit/materials/plastic_return.hpp"

namespace gabion::testing::test_tresca {
namespace {

constexpr double lambda = 1.7, mu = 0.9, cohesion = 0.02;

TEST(TrescaReturn, equals_the_only_admissible_candidate) {
  const auto law = principal_law(Tresca<3>({lambda, mu, cohesion}));
  const auto planes = shear_planes(law);
  std::array<int, 3> count = {0, 0, 0};
  for (const auto& eps : yielding_trials(8000, [&](const Eigen::Vector3d& candidate) {
         return yields(law, stress_of(law, candidate));
       })) {
    const Eigen::Vector3d trial = stress_of(law, eps);
    const auto returned = return_to_tresca(law, eps, trial);
    const Eigen::Vector3d tau = stress_of(law, returned.eps_e);
    const auto candidates = admissible_returns(law, planes, trial);
    ASSERT_FALSE(candidates.empty());
    for (const auto& candidate : candidates)
      ASSERT_LT((tau - candidate).norm(), 1e-9 * (trial.norm() + law.strength));
    ASSERT_NEAR(tau[0] - tau[2], 2 * cohesion, 1e-14);
    ASSERT_NEAR(returned.plastic.sum(), 0, 1e-15);  // isochoric
    ++count[static_cast<int>(returned.face)];
  }
  for (const int faces : count) EXPECT_GT(faces, 500);
}

template <int dim>
void expect_isochoric_return() {
  const Tresca<dim> law({lambda, mu, cohesion});
  Random random(29);
  int plastic = 0;
  for (int sample = 0; sample < 2000; ++sample) {
    MaterialState<dim> state_n;
    state_n.e = random.elastic_strain<dim>(0.05, random.uniform(-0.15, 0.15));
    const Matrix<dim> H = random.matrix<dim>(0.05);
    const auto out = stress<dim>(law, H, state_n);
    const Eigen::Vector3d eps = trial_strain<dim>(H, state_n);
    ASSERT_NEAR(trace<dim>(out.tau), (3 * lambda + 2 * mu) * eps.sum(), 1e-14);
    if (!out.plastic()) continue;
    ++plastic;
    ASSERT_EQ(out.region, YieldRegion::shear);
    const Eigen::Vector3d tau = principal<dim>(out.tau);
    ASSERT_NEAR(tau[0] - tau[2], 2 * cohesion, 1e-14);
    const auto again = stress<dim>(law, Matrix<dim>::Zero(), out.state);
    ASSERT_FALSE(again.plastic());
    // Strains are kept to a few units of the round-off of 1; the moduli make stresses of them.
    ASSERT_LT((again.tau - out.tau).norm(),
              4 * std::numeric_limits<double>::epsilon() * (3 * lambda + 2 * mu));
  }
  EXPECT_GT(plastic, 500);
}

TEST(Tresca, tensor_return_keeps_the_pressure_and_is_idempotent) {
  expect_isochoric_return<2>();
  expect_isochoric_return<3>();
}

/// Undrained shear carries the cohesion whatever the pressure; the remainder is of the order of the
/// elastic strain squared, from the turning of the axes.
TEST(Tresca, simple_shear_carries_the_cohesion) {
  const double small_cohesion = 1e-4 * mu;
  for (const double pressure : {0.0, 1e-3}) {
    const Tresca<2> law({lambda, mu, small_cohesion});
    MaterialState<2> state;
    state.e = std::expm1(-2 * pressure / (3 * lambda + 2 * mu)) * Symmetric<2>{1, 1, 1, 0};
    Matrix<2> H = Matrix<2>::Zero();
    H(0, 1) = 1e-5;
    for (int step = 0; step < 200; ++step) state = stress<2>(law, H, state).state;
    const auto out = stress<2>(law, H, state);
    EXPECT_NEAR(out.tau[3], small_cohesion, 1e-7 * small_cohesion) << "pressure " << pressure;
    EXPECT_NEAR(trace<2>(out.tau) / 3, -pressure, 1e-13);
  }
}

TEST(Tresca, regions_have_names) {
  const Tresca<2> law({lambda, mu, cohesion});
  Matrix<2> H = Matrix<2>::Zero();
  EXPECT_EQ(region_name(stress<2>(law, H, {}).region), "elastic");
  H(0, 1) = 1;
  EXPECT_EQ(region_name(stress<2>(law, H, {}).region), "shear");
}

}  // namespace
}  // namespace gabion::testing::test_tresca
