// SPDX-License-Identifier: BSD-3-Clause
#include "common/mechanics/materials/material.hpp"

#include <gtest/gtest.h>

#include <cstring>
#include <map>
#include <vector>

#include "tests/unit/materials/random_state.hpp"

namespace gabion::testing::test_batch_return {
namespace {

constexpr double lambda = 1.7e6, mu = 0.9e6;

/// Four states side by side and where their results go.
template <int dim>
struct Four {
  MaterialState<dim> state[num_lanes], next[num_lanes];
  Symmetric<dim> tau[num_lanes], plastic_increment[num_lanes];
  double J[num_lanes], energy[num_lanes];
  YieldRegion region[num_lanes];
  PointBatch<dim> batch;

  Four() {
    for (int l = 0; l < num_lanes; ++l) batch.state_n[l] = &state[l];
    batch.out = {next, tau, J, energy, plastic_increment, region};
  }
  StressUpdate<dim> result(int l) const {
    return {batch.stress(l),      tau[l], next[l], J[l], energy[l], plastic_increment[l], region[l],
            InternalState::Zero()};
  }
};

template <int dim>
void expect_equal(const StressUpdate<dim>& a, const StressUpdate<dim>& b, double stiffness) {
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
/// faces and all orders of the axes occur, mixed in one batch.
template <int dim, class Law>
void compare_with_single_points(const Law& law, double mean_strain) {
  const double stiffness = lambda + 2 * mu;
  Random random(11);
  std::map<YieldRegion, int> regions;
  Four<dim> four;
  for (int trial = 0; trial < 3000; ++trial) {
    for (int l = 0; l < num_lanes; ++l) {
      const double size = std::pow(10, random.uniform(-8, -0.5));
      four.state[l] = {.e = random.elastic_strain<dim>(size, mean_strain * random.uniform(-1, 1)),
                       .plastic_strain = random.uniform(0, 1),
                       .gap = trial % 2 == 0 ? 0 : random.uniform(0, 0.01)};
      four.batch.set_gradient(l, random.matrix<dim>(size));
    }
    ASSERT_TRUE(law.batch_return()->update(four.batch, true));
    for (int l = 0; l < num_lanes; ++l) {
      StressUpdate<dim> alone;
      Tangent<dim> A;
      ASSERT_TRUE(law.update(four.batch.gradient(l), four.state[l], alone, &A));
      expect_equal(four.result(l), alone, stiffness);
      // G of nearly equal values loses digits by their difference
      EXPECT_LT((four.batch.tangent(l) - A).norm(), 1e-7 * A.norm()) << trial;
      ++regions[alone.region];
    }
  }
  EXPECT_GT(regions[YieldRegion::elastic], 500);
  EXPECT_GT(regions[YieldRegion::shear], 500);
  if constexpr (std::is_same_v<Law, MohrCoulomb<dim>>) {
    EXPECT_GT(regions[YieldRegion::apex], 500);
  }
}

/// Every number of a result, to compare bits.
template <int dim>
std::vector<double> numbers_of(const Four<dim>& four, int l) {
  const StressUpdate<dim> r = four.result(l);
  std::vector<double> all = {r.J, r.energy, r.state.gap, r.state.plastic_strain};
  const auto add = [&all](const auto& x) { all.insert(all.end(), x.data(), x.data() + x.size()); };
  add(r.P), add(r.tau), add(r.state.e), add(r.plastic_increment);
  return all;
}

/// A point in a batch of mixed states has the bits that it has in other company: explicit steps
/// evaluate some points of a cell again, and not others.
template <int dim>
void compare_company() {
  const MohrCoulomb<dim> law(lambda, mu, 30 * degree, 0, 2e3);
  Random random(12);
  Four<dim> four, same;
  for (int trial = 0; trial < 3000; ++trial) {
    for (int l = 0; l < num_lanes; ++l) {
      const double size = trial % 7 == l ? 0 : std::pow(10, random.uniform(-12, -0.5));
      four.state[l] = {.e = random.elastic_strain<dim>(size, 1e-2 * random.uniform(-1, 1)),
                       .plastic_strain = random.uniform(0, 1),
                       .gap = trial % 2 == 0 ? 0 : random.uniform(0, 0.01)};
      if (trial % 5 == l) four.state[l].e.setZero();
      four.batch.set_gradient(l, random.matrix<dim>(size));
    }
    ASSERT_TRUE(law.batch_return()->update(four.batch, false));
    for (int l = 0; l < num_lanes; ++l) {
      for (int k = 0; k < num_lanes; ++k) {
        same.state[k] = four.state[l];
        same.batch.set_gradient(k, four.batch.gradient(l));
      }
      ASSERT_TRUE(law.batch_return()->update(same.batch, false));
      const auto a = numbers_of(four, l), b = numbers_of(same, l);
      EXPECT_EQ(std::memcmp(a.data(), b.data(), a.size() * sizeof(double)), 0) << trial;
    }
  }
}

TEST(BatchReturn, does_not_depend_on_the_other_points_of_a_batch) {
  compare_company<2>();
  compare_company<3>();
}

template <int dim>
void compare_laws() {
  for (const auto apex_volume : {ApexVolume::gap, ApexVolume::forget}) {
    for (const double psi : {0.0, 10 * degree}) {
      const MohrCoulombParameters parameters{.lambda = lambda,
                                             .mu = mu,
                                             .friction_angle = 30 * degree,
                                             .dilation_angle = psi,
                                             .cohesion = 2e3,
                                             .apex_volume = apex_volume};
      compare_with_single_points<dim>(MohrCoulomb<dim>(parameters), 1e-2);
    }
  }
  compare_with_single_points<dim>(
      Tresca<dim>(TrescaParameters{.lambda = lambda, .mu = mu, .cohesion = 1e4}), 1e-2);
}

TEST(BatchReturn, gives_in_the_plane_what_the_law_gives_for_each_point) {
  compare_laws<2>();
}

TEST(BatchReturn, gives_in_space_what_the_law_gives_for_each_point) {
  compare_laws<3>();
}

// Equal principal values: any axes will do, and the slopes have their limits.
TEST(BatchReturn, bears_equal_principal_values_in_space) {
  const MohrCoulomb<3> law(lambda, mu, 30 * degree, 0, 2e3);
  Four<3> four;
  for (Lanes& H : four.batch.H) H = Lanes{};
  four.state[1].e << -1e-3, -1e-3, -1e-3, 0, 0, 0;
  four.state[2].e << -1e-3, -1e-3, -2e-3, 0, 0, 0;
  four.state[3].e << -1e-3, -1e-2, -1e-2, 0, 0, 0;
  ASSERT_TRUE(law.batch_return()->update(four.batch, true));
  for (int l = 0; l < num_lanes; ++l) {
    StressUpdate<3> alone;
    Tangent<3> A;
    ASSERT_TRUE(law.update(four.batch.gradient(l), four.state[l], alone, &A));
    expect_equal(four.result(l), alone, lambda + 2 * mu);
    EXPECT_LT((four.batch.tangent(l) - A).norm(), 1e-12 * A.norm()) << l;
  }
}

TEST(BatchReturn, refuses_a_point_turned_inside_out) {
  const MohrCoulomb<2> law(lambda, mu, 30 * degree, 0, 0);
  Four<2> four;
  for (Lanes& H : four.batch.H) H = Lanes{};
  EXPECT_TRUE(law.batch_return()->update(four.batch, false));
  four.batch.H[0][2] = -1.1;
  EXPECT_FALSE(law.batch_return()->update(four.batch, false));
}

TEST(BatchReturn, is_for_laws_without_a_cut_off) {
  EXPECT_EQ((Tresca<2>({.lambda = lambda, .mu = mu, .cohesion = 1e4, .tension_cutoff = 1e3})
                 .batch_return()),
            nullptr);
  EXPECT_NE((MohrCoulomb<3>(lambda, mu, 30 * degree, 0, 0).batch_return()), nullptr);
}

}  // namespace
}  // namespace gabion::testing::test_batch_return
