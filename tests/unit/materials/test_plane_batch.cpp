// SPDX-License-Identifier: BSD-3-Clause
#include "common/mechanics/materials/plane_batch.hpp"

#include <gtest/gtest.h>

#include <map>

#include "tests/unit/materials/random_state.hpp"

namespace gabion::testing {
namespace {

constexpr double lambda = 1.7e6, mu = 0.9e6;

/// Four states side by side and what the law makes of each alone.
struct Four {
  MaterialState<2> state[PlaneBatch::size];
  Tangent<2> A[PlaneBatch::size];
  PlaneBatch batch;

  Four() {
    for (int l = 0; l < PlaneBatch::size; ++l) {
      batch.state_n[l] = &state[l];
      batch.A[l] = &A[l];
    }
  }
};

void expect_equal(const StressUpdate<2>& a, const StressUpdate<2>& b, double stiffness) {
  EXPECT_EQ(a.region, b.region);
  EXPECT_NEAR(a.J, b.J, 1e-15);
  EXPECT_LT((a.P - b.P).norm(), 2e-13 * stiffness);
  EXPECT_LT((a.tau - b.tau).norm(), 2e-13 * stiffness);
  EXPECT_LT((a.state.e - b.state.e).norm(), 2e-14);
  EXPECT_LT((a.plastic_increment - b.plastic_increment).norm(), 2e-14);
  EXPECT_NEAR(a.state.gap, b.state.gap, 1e-15);
  EXPECT_NEAR(a.state.plastic_strain, b.state.plastic_strain, 1e-14);
  EXPECT_NEAR(a.energy, b.energy, 1e-13 * stiffness);
}

/// Batches of random steps from elastic states of all sizes, in tension and pressure, so that all
/// faces and all positions of the axis out of the plane occur, mixed in one batch.
template <class Law>
void compare_with_single_points(const Law& law, double mean_strain) {
  const double stiffness = lambda + 2 * mu;
  Random random(11);
  std::map<YieldRegion, int> regions;
  Four four;
  for (int trial = 0; trial < 3000; ++trial) {
    for (int l = 0; l < PlaneBatch::size; ++l) {
      const double size = std::pow(10, random.uniform(-8, -0.5));
      four.state[l] = {.e = random.elastic_strain<2>(size, mean_strain * random.uniform(-1, 1)),
                       .plastic_strain = random.uniform(0, 1),
                       .gap = trial % 2 == 0 ? 0 : random.uniform(0, 0.01)};
      four.batch.H[l] = random.matrix<2>(size);
    }
    ASSERT_TRUE(law.plane_return()->update(four.batch, true));
    for (int l = 0; l < PlaneBatch::size; ++l) {
      StressUpdate<2> alone;
      Tangent<2> A;
      ASSERT_TRUE(law.update(four.batch.H[l], four.state[l], alone, &A));
      expect_equal(four.batch.out[l], alone, stiffness);
      // G of nearly equal values loses digits by their difference
      EXPECT_LT((four.A[l] - A).norm(), 1e-7 * A.norm()) << trial;
      ++regions[alone.region];
    }
  }
  EXPECT_GT(regions[YieldRegion::elastic], 500);
  EXPECT_GT(regions[YieldRegion::shear], 500);
  if constexpr (std::is_same_v<Law, MohrCoulomb<2>>) {
    EXPECT_GT(regions[YieldRegion::apex], 500);
  }
}

TEST(PlaneBatch, gives_what_the_law_gives_for_each_point) {
  for (const auto apex_volume : {ApexVolume::gap, ApexVolume::forget}) {
    for (const double psi : {0.0, 10 * degree}) {
      compare_with_single_points(MohrCoulomb<2>(MohrCoulombParameters{.lambda = lambda,
                                                                      .mu = mu,
                                                                      .friction_angle = 30 * degree,
                                                                      .dilation_angle = psi,
                                                                      .cohesion = 2e3,
                                                                      .apex_volume = apex_volume}),
                                 1e-2);
    }
  }
  compare_with_single_points(
      Tresca<2>(TrescaParameters{.lambda = lambda, .mu = mu, .cohesion = 1e4}), 1e-2);
}

TEST(PlaneBatch, refuses_a_point_turned_inside_out) {
  const MohrCoulomb<2> law(lambda, mu, 30 * degree, 0, 0);
  Four four;
  for (auto& H : four.batch.H) H.setZero();
  EXPECT_TRUE(law.plane_return()->update(four.batch, false));
  four.batch.H[2](0, 0) = -1.1;
  EXPECT_FALSE(law.plane_return()->update(four.batch, false));
}

TEST(PlaneBatch, is_for_laws_without_a_cut_off) {
  EXPECT_EQ((Tresca<2>({.lambda = lambda, .mu = mu, .cohesion = 1e4, .tension_cutoff = 1e3})
                 .plane_return()),
            nullptr);
  EXPECT_EQ((MohrCoulomb<3>(lambda, mu, 30 * degree, 0, 0).plane_return()), nullptr);
}

}  // namespace
}  // namespace gabion::testing
