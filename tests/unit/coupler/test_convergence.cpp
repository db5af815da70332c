// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include <limits>

#include "coupler/convergence/convergence.hpp"
#include "coupler/step/predictor.hpp"

namespace gabion::test_convergence {
namespace {

using Vector = Eigen::VectorXd;

ConvergenceSettings limits() {
  ConvergenceSettings s;
  s.displacement = {1e-3, 1e-2, 1e-6, {}};
  s.force = {1, 1e-2, 1e-3, {}};
  s.stagnation = 5;
  return s;
}

TEST(FieldLimits, the_smaller_of_absolute_and_relative_holds_and_the_floor_bounds_the_relative) {
  const FieldLimits l{1e-3, 1e-2, 1e-6, {}};
  EXPECT_EQ(l.limit(1), 1e-3);     // relative would be 1e-2
  EXPECT_EQ(l.limit(0.01), 1e-4);  // relative
  EXPECT_EQ(l.limit(1e-8), 1e-6);  // floor
  EXPECT_EQ(l.limit(0), 1e-6);
}

TEST(Convergence, the_norm_is_the_root_mean_square) {
  EXPECT_DOUBLE_EQ(rms(Vector::Constant(7, -3)), 3);
  EXPECT_DOUBLE_EQ(rms(Eigen::Vector2d(3, 4)), 5 / std::sqrt(2.0));
  EXPECT_EQ(rms(Vector()), 0);
  EXPECT_DOUBLE_EQ(rms(Vector::Constant(2, 1e200)), 1e200);  // no overflow
}

TEST(Convergence, needs_both_fields_and_two_iterations) {
  Convergence c(limits());
  c.begin_step();
  const Vector x = Vector::Constant(4, 0.01);
  const Vector f = Vector::Constant(4, 10);
  EXPECT_EQ(c.check(x, x, f).verdict, Verdict::going_on);  // no force residual yet
  EXPECT_EQ(c.check(x, x, f + Vector::Constant(4, 0.2)).verdict, Verdict::going_on);
  const auto state = c.check(x, x + Vector::Constant(4, 9e-5), f + Vector::Constant(4, 0.29));
  EXPECT_EQ(state.verdict, Verdict::converged);
  EXPECT_NEAR(*state.force_residual, 0.09, 1e-12);
  EXPECT_NEAR(*state.force_limit, 0.1029, 1e-12);
  c.begin_step();
  EXPECT_FALSE(c.check(x, x, f).force_residual.has_value());
}

TEST(Convergence, values_that_are_not_finite_never_converge) {
  const double infinity = std::numeric_limits<double>::infinity();
  const double nan = std::numeric_limits<double>::quiet_NaN();
  const Vector fine = Vector::Zero(3);
  for (const double bad : {infinity, -infinity, nan}) {
    Vector spoiled = fine;
    spoiled(1) = bad;
    for (int which = 0; which < 3; ++which) {
      Convergence c(limits());
      c.begin_step();
      c.check(fine, fine, fine);
      const auto state = c.check(which == 0 ? spoiled : fine, which == 1 ? spoiled : fine,
                                 which == 2 ? spoiled : fine);
      EXPECT_EQ(state.verdict, Verdict::not_finite) << bad << " in " << which;
    }
    EXPECT_EQ(Convergence::one_pass(fine, fine, spoiled).verdict, Verdict::not_finite);
  }
}

TEST(Convergence, no_progress_is_stagnation_and_growth_is_divergence) {
  Convergence c(limits());
  c.begin_step();
  const Vector x = Vector::Zero(2);
  const Vector f = Vector::Zero(2);
  Verdict verdict = Verdict::going_on;
  int checks = 0;
  for (; verdict == Verdict::going_on && checks < 100; ++checks) {
    verdict = c.check(x, x + Vector::Constant(2, 0.5), f).verdict;
  }
  EXPECT_EQ(verdict, Verdict::stagnated);
  EXPECT_EQ(checks, 6);  // the first one and five without progress

  c.begin_step();
  EXPECT_EQ(c.check(x, x + Vector::Constant(2, 1), f).verdict, Verdict::going_on);
  EXPECT_EQ(c.check(x, x + Vector::Constant(2, 999), f).verdict, Verdict::going_on);
  EXPECT_EQ(c.check(x, x + Vector::Constant(2, 1001), f).verdict, Verdict::diverged);
}

TEST(Convergence, growth_from_a_residual_below_the_limit_is_not_divergence) {
  Convergence c(limits());
  c.begin_step();
  const Vector x = Vector::Zero(2);
  c.check(x, x + Vector::Constant(2, 1e-12), x);
  EXPECT_EQ(c.check(x, x + Vector::Constant(2, 1e-5), x).verdict, Verdict::going_on);
}

TEST(Convergence, drop_is_relative_to_the_first_residual_of_the_step) {
  ConvergenceSettings s;
  s.displacement.drop = 0.01;
  Convergence c(s);
  const Vector x = Vector::Zero(3), f = Vector::Ones(3);
  for (const double first : {1.0, 1e-5}) {
    c.begin_step();
    EXPECT_EQ(c.check(x, Vector::Constant(3, first), f).verdict, Verdict::going_on);
    EXPECT_EQ(c.check(x, Vector::Constant(3, 0.011 * first), f).verdict, Verdict::going_on);
    const auto state = c.check(x, Vector::Constant(3, 0.009 * first), f);
    EXPECT_EQ(state.verdict, Verdict::converged);
    EXPECT_DOUBLE_EQ(*state.displacement_limit, 0.01 * first);
    EXPECT_FALSE(state.force_limit.has_value());
  }
}

TEST(Convergence, or_needs_one_criterion_of_one_field) {
  ConvergenceSettings s;
  s.combine = Combine::any;
  s.displacement.absolute = 1e-6;
  s.displacement.relative = 1e-2;  // the larger of the two limits counts
  s.force.absolute = 1e-9;
  Convergence c(s);
  c.begin_step();
  const Vector x = Vector::Ones(3), f = Vector::Ones(3);
  EXPECT_EQ(c.check(x, 1.1 * x, f).verdict, Verdict::going_on);
  EXPECT_EQ(c.check(x, 1.005 * x, 2 * f).verdict, Verdict::converged);
  c.begin_step();
  EXPECT_EQ(c.check(x, 2 * x, f, 2 * f).verdict, Verdict::going_on);
  EXPECT_EQ(c.check(x, 2 * x, f, f).verdict, Verdict::converged);  // the force alone
}

TEST(Convergence, the_parallel_scheme_knows_the_force_residual_at_once) {
  Convergence c(limits());
  c.begin_step();
  const Vector x = Vector::Constant(4, 0.01), f = Vector::Constant(4, 10);
  EXPECT_EQ(c.check(x, x, f + Vector::Ones(4), f).verdict, Verdict::going_on);
  EXPECT_EQ(c.check(x, x, f, f).verdict, Verdict::converged);
}

TEST(Convergence, a_limit_below_the_round_off_of_the_values_is_told) {
  ConvergenceSettings s;
  s.displacement.absolute = 1e-12;
  Convergence c(s);
  c.begin_step();
  const Vector f = Vector::Zero(2);
  EXPECT_EQ(c.check(f, Vector::Ones(2), f).below_round_off, "");
  EXPECT_EQ(c.check(f, Vector::Constant(2, 1e5), f).below_round_off, "displacement");
}

TEST(Predictor, reproduces_polynomials_of_its_order_with_unequal_steps) {
  const std::vector<double> times = {0, 0.3, 0.4, 1.1, 1.15};
  const Vector a = Eigen::Vector2d(1, -2), b = Eigen::Vector2d(0.5, 3), c = Eigen::Vector2d(-4, 1);
  for (int order = 0; order <= 2; ++order) {
    const auto polynomial = [&](double t) -> Vector {
      return a + (order > 0 ? t : 0) * b + (order > 1 ? t * t : 0) * c;
    };
    Predictor predictor(order);
    for (const double t : times) predictor.accept(t, polynomial(t));
    EXPECT_LE((predictor.predict(1.9) - polynomial(1.9)).norm(), 1e-12) << order;
    // One degree more is not reproduced: the test can fail.
    Predictor lower(order);
    for (const double t : times) lower.accept(t, a * std::pow(t, order + 1));
    EXPECT_GT((lower.predict(1.9) - a * std::pow(1.9, order + 1)).norm(), 0.1) << order;
  }
}

TEST(Predictor, uses_a_lower_order_at_the_start_and_keeps_rest_to_the_bit) {
  Predictor predictor(2);
  predictor.accept(0, Eigen::Vector2d(0.1, 0.7));
  EXPECT_EQ(predictor.predict(1), Eigen::Vector2d(0.1, 0.7));
  predictor.accept(0.1, Eigen::Vector2d(0.2, 0.7));
  EXPECT_LE((predictor.predict(0.3) - Eigen::Vector2d(0.4, 0.7)).norm(), 1e-15);
  Predictor rest(2);
  for (const double t : {0.0, 0.1, 0.3}) rest.accept(t, Eigen::Vector2d(0.1, 0.7));
  EXPECT_EQ(rest.predict(0.7), Eigen::Vector2d(0.1, 0.7));
}

}  // namespace
}  // namespace gabion::test_convergence
