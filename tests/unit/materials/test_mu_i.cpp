// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <map>

#include "common/mechanics/materials/mu_i.hpp"
#include "tests/unit/materials/plastic_tangent.hpp"

namespace gabion::testing::test_mu_i {
namespace {

constexpr double lambda = 5e6, mu = 1e6, M = lambda + 2 * mu;

template <int dim>
using InSteps = LawInStep<MuI<dim>, dim>;

MuIParameters glass() {
  return {.lambda = lambda,
          .mu = mu,
          .static_friction = 0.38,
          .limit_friction = 0.64,
          .inertial_number = 0.279,
          .grain_size = 5.3e-4,
          .grain_density = 2450};
}

TEST(MuI, flow_solves_its_equation_over_many_orders) {
  const MuIParameters law = glass();
  for (const double P : {1e-6, 1., 1e3, 1e6}) {
    for (const double dt : {1e-9, 1e-6, 1e-4, 1e-2, 1e3}) {
      for (const double beyond : {1e-8, 1e-2, 1., 1e4}) {
        const double root = (law.static_friction + beyond) * P;
        const GranularFlow flow = solve_granular_flow(law, root, P, dt);
        const double I = flow.shear / dt * law.grain_size * std::sqrt(law.grain_density / P);
        const double friction = law.static_friction + (law.limit_friction - law.static_friction) *
                                                          I / (law.inertial_number + I);
        EXPECT_NEAR(flow.friction, friction, 1e-12) << P << " " << dt << " " << beyond;
        EXPECT_NEAR(root - mu * flow.shear, friction * P, 1e-12 * root);
        EXPECT_GE(flow.shear, 0);
        EXPECT_GE(flow.by_trial, 0);
        EXPECT_LE(flow.by_trial, 1);
      }
    }
  }
}

TEST(MuI, flow_derivatives_match_differences) {
  const MuIParameters law = glass();
  for (const double dt : {0., 1e-6, 1e-4, 1e-2, std::numeric_limits<double>::infinity()}) {
    const double root = 1500, P = 1000, h = 1e-3;
    const GranularFlow flow = solve_granular_flow(law, root, P, dt);
    const auto stress = [&](double r, double p) {
      return r - mu * solve_granular_flow(law, r, p, dt).shear;
    };
    EXPECT_NEAR(flow.by_trial, (stress(root + h, P) - stress(root - h, P)) / (2 * h), 1e-7) << dt;
    EXPECT_NEAR(flow.by_pressure, (stress(root, P + h) - stress(root, P - h)) / (2 * h), 1e-7)
        << dt;
  }
}

template <int dim>
void expect_tangent(const MuIParameters& parameters, double dt) {
  Random random(7);
  const MuI<dim> grains(parameters);
  const InSteps<dim> law{grains, {dt}};
  std::map<YieldRegion, int> count;
  for (int sample = 0; sample < 1500; ++sample) {
    MaterialState<dim> state_n;
    state_n.e = random.elastic_strain<dim>(0.01, random.uniform(-0.008, 0.003));
    if (sample % 3 == 0) state_n.gap = random.uniform(0, 0.02);
    const Matrix<dim> H = random.matrix<dim>(0.02);
    constexpr double step = 1e-6;
    const auto region = [&](const Matrix<dim>& at, const MaterialState<dim>& from) {
      return static_cast<int>(stress<dim>(law, at, from).region);
    };
    if (!smooth_about<dim>(region, H, state_n, step)) continue;
    const auto found = stress<dim>(law, H, state_n);
    const double pressure = -found.tau.template head<3>().sum() / 3;
    // I goes with sqrt(P), which the difference step has to resolve.
    if (found.region == YieldRegion::shear && pressure < 2e4) continue;
    Tangent<dim> A = tangent<dim>(law, H, state_n);
    if (found.region == YieldRegion::apex) A -= apex_regularisation<dim>(lambda, mu, H, state_n);
    const Tangent<dim> A_num = difference_tangent<dim>(law, H, state_n, step);
    ASSERT_LT((A - A_num).cwiseAbs().maxCoeff(), 1e-7 * M) << sample << " at dt " << dt;
    ++count[found.region];
    const double increment = found.plastic_increment.template head<3>().sum();
    if (found.region == YieldRegion::shear && state_n.gap == 0) {
      EXPECT_NEAR(increment, 0, 1e-14);
    }
  }
  EXPECT_GE(count[YieldRegion::shear], 50);
  EXPECT_GE(count[YieldRegion::apex], 10);
}

TEST(MuI, tangent_matches_differences) {
  for (const double dt : {0., 1e-5, 1e-3, 1., std::numeric_limits<double>::infinity()}) {
    expect_tangent<2>(glass(), dt);
    expect_tangent<3>(glass(), dt);
  }
}

/// Shear stress and pressure after simple shear at a rate, at constant volume, in steps of dt.
template <int dim>
std::pair<double, double> sheared(const MuIParameters& parameters, double P, double dt) {
  constexpr double rate = 10, strain = 1;
  const MuI<dim> law(parameters);
  MaterialState<dim> state;
  const double volumetric = -P / (lambda + 2 * mu / 3);
  for (int i = 0; i < 3; ++i) state.e[i] = std::expm1(2 * volumetric / 3);
  StressUpdate<dim> out;
  Matrix<dim> H = Matrix<dim>::Zero();
  H(0, 1) = rate * dt;
  for (int k = 0; k < std::lround(strain / (rate * dt)); ++k) {
    EXPECT_TRUE(law.update({.dt = dt}, H, state, out, nullptr));
    state = out.state;
  }
  return {out.tau[3], -out.tau.template head<3>().sum() / 3};
}

/// Glass beads under 1 kPa at 10/s: I = 0.00829581. Elastic strains tau / mu of 4e-4 and steps of
/// 1e-3 turn the stress by their products.
TEST(MuI, steady_shear_bears_the_friction_of_its_rate) {
  for (const double dt : {1e-5, 1e-4}) {
    const auto [tau, P] = sheared<2>(glass(), 1e3, dt);
    EXPECT_NEAR(P, 1e3, 1e-6);
    EXPECT_NEAR(tau / P, 0.387508, 2e-6);
    const auto [tau_3, P_3] = sheared<3>(glass(), 1e3, dt);
    EXPECT_NEAR(tau_3 / P_3, 0.387508, 2e-6);
  }
}

TEST(MuI, is_a_cone_of_constant_friction_where_both_are_equal) {
  MuIParameters constant = glass();
  constant.limit_friction = constant.static_friction;
  const PrincipalDruckerPrager cone{
      .lambda = lambda, .mu = mu, .eta = 0.38, .eta_bar = 0, .strength = 0};
  for (const Eigen::Vector3d& eps :
       {Eigen::Vector3d(0.01, -0.01, -0.02), Eigen::Vector3d(0.02, -0.03, -0.03)}) {
    const double trace = eps.sum();
    const Eigen::Vector3d tau = (lambda * trace + 2 * mu * eps.array()).matrix();
    const double p = tau.mean(), root = shear_size((tau.array() - p).matrix());
    for (const double dt : {1e-4, std::numeric_limits<double>::infinity()}) {
      const auto flow = solve_granular_flow(constant, root, -p, dt);
      const auto returned = return_to_cone(cone, eps, tau);
      EXPECT_NEAR(1 - mu * flow.shear / root, returned.shrinkage, 1e-13);
      EXPECT_NEAR(flow.by_trial, 0, 1e-15);
      EXPECT_NEAR(flow.by_pressure, 0.38, 1e-15);
    }
  }
}

/// The static friction holds in an infinite step, the limit of friction in one of no time.
TEST(MuI, bounds_of_friction_by_the_size_of_the_step) {
  const MuI<2> law(glass());
  MaterialState<2> state;
  for (int i = 0; i < 3; ++i) state.e[i] = std::expm1(-2e-3);
  Matrix<2> H = Matrix<2>::Zero();
  H(0, 1) = 0.05;
  const auto friction = [](const StressUpdate<2>& out) {
    const double p = out.tau.head<3>().sum() / 3;
    const double s = (out.tau.head<3>().array() - p).matrix().squaredNorm();
    return -std::sqrt(0.5 * s + out.tau[3] * out.tau[3]) / p;
  };
  StressUpdate<2> out;
  ASSERT_TRUE(law.update(H, state, out, nullptr));
  EXPECT_NEAR(friction(out), 0.38, 1e-12);
  ASSERT_TRUE(law.update({.dt = 0}, H, state, out, nullptr));
  EXPECT_NEAR(friction(out), 0.64, 1e-12);
  H(0, 1) = 0.0085;  // a friction of some 0.5, which it bears for no time
  ASSERT_TRUE(law.update({.dt = 0}, H, state, out, nullptr));
  EXPECT_FALSE(out.plastic());
  ASSERT_TRUE(law.update({.dt = 1e-3}, H, state, out, nullptr));
  EXPECT_TRUE(out.plastic());
}

}  // namespace
}  // namespace gabion::testing::test_mu_i
