// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include <algorithm>
#include <limits>

#include "common/base/unbalanced.hpp"
#include "tests/support/expect_error.hpp"
#include "tests/unit/newton/spring_chain.hpp"

namespace gabion::test_newton {
namespace {

using test::expect_parts;
using test::SpringChain;

/// A chain with all that a solve needs.
struct Bench {
  SpringChain chain;
  BlockMatrix<2> K;
  LinearSolver<2> linear;
  NewtonMatrix<2> matrix{K, linear};
  NewtonSettings settings;
  PhaseTimes times;
  std::vector<double> du;

  explicit Bench(SpringChain given = {}, const std::string& method = "auto")
      : chain(std::move(given)), linear(test::comm(), 2, LinearSolverSettings{.method = method}) {
    chain.set_pattern(K);
    du.assign(chain.num_dofs(), 0.0);
  }
  NewtonReport solve() { return solve_newton<2>(chain, matrix, settings, du, times); }
  std::string failure() {
    return test::error_of<UnbalancedError>([this] { solve(); });
  }
};

/// Strain under which a spring carries the load, by bisection.
double exact_strain(const SpringChain& chain) {
  double low = -1, high = 5;
  for (int k = 0; k < 200; ++k) {
    const double e = 0.5 * (low + high);
    const double force = chain.stiffness * (e + chain.quadratic * e * e + chain.cubic * e * e * e);
    (force < chain.load_x ? low : high) = e;
  }
  return low;
}

void expect_exact(const Bench& bench, double tolerance) {
  const double e = exact_strain(bench.chain);
  for (int i = 0; i <= bench.chain.num_springs; ++i) {
    EXPECT_NEAR(bench.du[2 * i], i * e * bench.chain.length, tolerance);
    EXPECT_NEAR(bench.du[2 * i + 1], i * bench.chain.load_y / bench.chain.stiffness, tolerance);
  }
}

TEST(Newton, finds_the_solution_of_a_nonlinear_chain) {
  Bench bench;
  const NewtonReport report = bench.solve();
  expect_exact(bench, 1e-8);
  EXPECT_EQ(report.residuals.size(), report.iterations + 1u);
  EXPECT_LE(report.residuals.back(), bench.settings.residual_tolerance);
  EXPECT_TRUE(bench.times.seconds().contains("solve"));
  EXPECT_TRUE(bench.times.seconds().contains("assembly"));
}

TEST(Newton, converges_quadratically) {
  Bench bench({}, "lu");
  bench.settings.residual_tolerance = 1e-12;
  const auto residuals = bench.solve().residuals;
  // Order from three residuals in the range where neither the start nor round-off rules.
  double order = 0;
  for (std::size_t k = 2; k < residuals.size(); ++k)
    if (residuals[k - 2] < 0.1 && residuals[k] > 1e-14)
      order =
          std::log(residuals[k] / residuals[k - 1]) / std::log(residuals[k - 1] / residuals[k - 2]);
  EXPECT_GT(order, 1.9);
  EXPECT_LT(order, 2.2);
}

TEST(Newton, inexact_linear_solves_cost_one_iteration_at_most) {
  for (const double load : {3.0, 30.0, 100.0}) {
    SpringChain chain;
    chain.num_springs = 40;
    chain.load_x = chain.load_y = load;
    Bench direct(chain, "lu"), krylov(chain, "bicgstab");
    const auto exact = direct.solve(), inexact = krylov.solve();
    EXPECT_GE(inexact.iterations, exact.iterations) << load;
    EXPECT_LE(inexact.iterations, exact.iterations + 1) << load;
    expect_exact(krylov, 1e-6);
    EXPECT_GT(inexact.linear_iterations, 0);
  }
}

TEST(Newton, wrong_tangent_converges_linearly) {
  SpringChain chain;
  chain.tangent_factor = 1.3;
  Bench bench(chain, "lu");
  bench.settings.max_iterations = 60;
  const auto report = bench.solve();
  expect_exact(bench, 1e-6);
  const auto& r = report.residuals;
  // The error shrinks by 1 - 1 / 1.3 an iteration.
  EXPECT_NEAR(r[r.size() - 1] / r[r.size() - 2], 0.3 / 1.3, 0.01);
}

TEST(Newton, linear_problem_needs_one_step_and_its_confirmation) {
  SpringChain chain;
  chain.quadratic = chain.cubic = 0;
  Bench bench(chain, "lu");
  const auto report = bench.solve();
  EXPECT_EQ(report.iterations, 2);
  // The second iterate is foreseen as the last: residual only.
  EXPECT_EQ(bench.chain.evaluations, 3);
  EXPECT_EQ(report.matrices, 2);
  expect_exact(bench, 1e-12);
}

TEST(Newton, warm_start_needs_no_iteration) {
  Bench bench;
  bench.solve();
  const auto solution = bench.du;
  const auto again = bench.solve();
  EXPECT_EQ(again.iterations, 0);
  EXPECT_EQ(bench.du, solution);
}

TEST(Newton, prediction_saves_the_last_matrix) {
  Bench bench;
  const auto report = bench.solve();
  EXPECT_EQ(report.matrices, report.iterations);
  EXPECT_EQ(bench.chain.evaluations, report.iterations + 1);
}

TEST(Newton, a_step_that_is_likely_the_last_gets_no_matrix_in_advance) {
  SpringChain linear;
  linear.quadratic = linear.cubic = 0;
  linear.likely_last = true;
  linear.load_x = 3;
  Bench bench(linear, "lu");
  bench.settings.increment_tolerance = 1;  // one step is enough
  EXPECT_EQ(bench.solve().matrices, 1);
  EXPECT_EQ(bench.chain.evaluations, 2);
}

TEST(Newton, a_wrong_guess_of_the_last_step_costs_evaluations_and_no_accuracy) {
  SpringChain optimist;
  optimist.likely_last = true;
  Bench bench(optimist, "lu"), other({}, "lu");
  const auto report = bench.solve(), expected = other.solve();
  EXPECT_EQ(report.residuals, expected.residuals);
  EXPECT_EQ(bench.du, other.du);
  EXPECT_EQ(report.matrices, report.iterations);
  EXPECT_GT(bench.chain.evaluations, other.chain.evaluations);
}

TEST(Newton, increment_criterion_is_enforced) {
  Bench loose, tight;
  loose.settings.residual_tolerance = tight.settings.residual_tolerance = 1e-2;
  loose.settings.increment_tolerance = 1;
  tight.settings.increment_tolerance = 1e-10;
  EXPECT_LT(loose.solve().iterations, tight.solve().iterations);
  expect_exact(tight, 1e-9);
}

TEST(Newton, line_search_saves_an_inadmissible_step) {
  // Soft at first, stiff in compression: the full first step turns springs inside out.
  SpringChain chain;
  chain.load_x = -150;
  chain.quadratic = 0;
  chain.cubic = 4;
  Bench bench(chain);
  const auto report = bench.solve();
  EXPECT_GE(report.line_search_cuts, 1);
  expect_exact(bench, 1e-7);
}

TEST(Newton, line_search_gives_up_with_the_reason) {
  // No spring can carry this: N(-1) = -500.
  SpringChain chain;
  chain.load_x = -600;
  chain.quadratic = 0;
  chain.cubic = 4;
  Bench bench(chain);
  bench.settings.max_iterations = 200;
  expect_parts(bench.failure(), {"line search failed: spring ", "is turned inside out"});
}

/// A load of twice the size fails with twice the residuals: relative ones would be the same.
TEST(Newton, a_failure_has_the_residuals_of_its_forces) {
  const auto residuals_of = [](double load) {
    SpringChain chain;
    chain.load_x = chain.load_y = load;
    chain.quadratic = chain.cubic = 0;
    Bench bench(chain);
    bench.settings.max_iterations = 0;
    try {
      bench.solve();
    } catch (const UnbalancedError& error) {
      return error.residuals();
    }
    return std::vector<double>();
  };
  const auto once = residuals_of(1), twice = residuals_of(2);
  ASSERT_EQ(once.size(), 1u);
  ASSERT_EQ(twice.size(), 1u);
  EXPECT_GT(once[0], 0);
  EXPECT_DOUBLE_EQ(twice[0], 2 * once[0]);
}

TEST(Newton, iteration_limit_names_the_worst_node_and_all_residuals) {
  Bench bench;
  bench.settings.max_iterations = 2;
  const std::string message = bench.failure();
  expect_parts(message, {"iteration 2: iteration limit", "worst node 10"});
  const std::string series = message.substr(message.find("|r|/scale: ") + 11);
  EXPECT_EQ(std::count(series.begin(), series.end(), 'e'), 3) << message;
}

TEST(Newton, of_many_residuals_the_first_and_the_last_are_named) {
  SpringChain chain;
  chain.tangent_factor = 20;  // slow
  Bench bench(chain, "lu");
  bench.settings.max_iterations = 30;
  const std::string message = bench.failure();
  const std::string series = message.substr(message.find("|r|/scale: ") + 11);
  EXPECT_NE(series.find(" (15 more) "), std::string::npos) << message;
  EXPECT_EQ(std::ranges::count(series, '.'), 4 + 12) << message;
}

TEST(Newton, residual_that_is_not_finite_fails_at_once) {
  SpringChain chain;
  chain.load_y = std::numeric_limits<double>::quiet_NaN();
  Bench bench(chain);
  expect_parts(bench.failure(), {"not finite, worst node 10", "iteration 0"});
  EXPECT_EQ(bench.chain.evaluations, 1);
}

TEST(Newton, inadmissible_guess_fails) {
  Bench bench;
  bench.du[6] = -5;
  expect_parts(bench.failure(), {"the guess is inadmissible: spring 2"});
}

TEST(Newton, singular_matrix_fails_with_the_iteration) {
  SpringChain chain;
  chain.tangent_factor = 0;
  Bench bench(chain);
  expect_parts(bench.failure(), {"iteration 0: linear solver: "});
}

TEST(Newton, without_forces_the_guess_is_the_solution) {
  SpringChain chain;
  chain.load_x = chain.load_y = 0;
  Bench bench(chain);
  const auto report = bench.solve();
  EXPECT_EQ(report.iterations, 0);
  EXPECT_EQ(report.residuals, std::vector<double>{0.0});
}

/// Ten load steps; every solve starts from the last solution.
std::int64_t load_history(bool reuse, std::vector<double>& du) {
  SpringChain chain;
  chain.quadratic = 0.1;
  chain.cubic = 0.2;
  Bench bench(chain, "lu");
  bench.settings.reuse_matrix = reuse;
  bench.settings.max_iterations = 40;
  for (int step = 1; step <= 10; ++step) {
    bench.chain.load_x = 3.0 * step;
    bench.solve();
    expect_exact(bench, 1e-7);
  }
  du = bench.du;
  return bench.linear.factorisations();
}

TEST(Newton, reused_matrix_gives_the_same_solution_with_fewer_factorisations) {
  std::vector<double> full, reused;
  const auto many = load_history(false, full);
  const auto few = load_history(true, reused);
  EXPECT_LT(3 * few, many);
  for (std::size_t k = 0; k < full.size(); ++k) EXPECT_NEAR(full[k], reused[k], 1e-8);
}

TEST(Newton, reused_matrix_that_no_longer_serves_is_replaced) {
  Bench bench({}, "lu");
  bench.settings.reuse_matrix = true;
  bench.settings.max_iterations = 40;
  bench.solve();
  EXPECT_TRUE(bench.matrix.is_usable);
  const auto before = bench.linear.factorisations();
  bench.chain.load_x = 3000;  // ten times stiffer
  bench.solve();
  expect_exact(bench, 1e-7);
  EXPECT_GT(bench.linear.factorisations(), before);
}

TEST(Newton, linear_problem_is_factorised_once_for_ever) {
  SpringChain chain;
  chain.quadratic = chain.cubic = 0;
  Bench bench(chain, "lu");
  bench.settings.reuse_matrix = true;
  for (int step = 1; step <= 5; ++step) {
    bench.chain.load_x = 2.0 * step;
    bench.solve();
    expect_exact(bench, 1e-12);
  }
  EXPECT_EQ(bench.linear.factorisations(), 1);
  EXPECT_EQ(bench.chain.tangents, 1);
}

TEST(Newton, failed_solve_forgets_the_matrix) {
  Bench bench({}, "lu");
  bench.settings.reuse_matrix = true;
  bench.solve();
  bench.chain.load_x = std::numeric_limits<double>::quiet_NaN();
  expect_parts(bench.failure(), {"not finite"});
  EXPECT_FALSE(bench.matrix.is_usable);
}

TEST(NewtonSettings, read_and_refused) {
  const Json json = {{"residual_tolerance", 1e-6}, {"max_iterations", 7}, {"reuse_matrix", true}};
  const auto settings = read_newton_settings(
      ConfigReader(json, "f.json", newton_keys({.increment_tolerance = 1e-3})));
  EXPECT_EQ(settings.residual_tolerance, 1e-6);
  EXPECT_EQ(settings.increment_tolerance, 1e-3);
  EXPECT_EQ(settings.max_iterations, 7);
  EXPECT_TRUE(settings.reuse_matrix);
  const auto refuses = [](const Json& wrong, const std::vector<std::string_view>& parts) {
    test::expect_error<ConfigError>(
        [&] { read_newton_settings(ConfigReader(wrong, "f.json", newton_keys())); }, parts);
  };
  refuses({{"residual_tolerance", 0}}, {"/residual_tolerance: found 0"});
  refuses({{"residual_tolerance", 2e-16}}, {"/residual_tolerance", "rounding of the forces"});
  const Json smallest = {{"residual_tolerance", 2.3e-16}};
  EXPECT_EQ(
      read_newton_settings(ConfigReader(smallest, "f.json", newton_keys())).residual_tolerance,
      2.3e-16);
  refuses({{"increment_tolerance", -1}}, {"/increment_tolerance: found -1", "(0, 1]"});
  refuses({{"max_iterations", 0}}, {"/max_iterations: found 0"});
  refuses({{"tolerance", 1e-6}}, {"/tolerance", "unknown"});
}

}  // namespace
}  // namespace gabion::test_newton
