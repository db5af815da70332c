// SPDX-License-Identifier: BSD-3-Clause
// Kinks of r where a plain Newton step jumps from one side to the other.
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <vector>

#include "common/base/unbalanced.hpp"
#include "common/mechanics/newton/newton.hpp"
#include "common/mechanics/newton/regularisation.hpp"
#include "tests/support/expect_error.hpp"
#include "tests/support/mpi_main.hpp"

namespace gabion::test_regularisation {
namespace {

/// A light node above a support that can only push, as a grain of cohesionless soil on a heap:
///
///     r(u) = -weight - light u - support min(u, 0) ,   u = -weight / (light + support)
///
/// Loose (u > 0) its stiffness is `light` alone, and a Newton step leads 1 / light away. It may
/// move along u alone: its second unknown has a stiffness and no force.
class LooseNode : public NewtonProblem<2> {
 public:
  double weight = 1e-3, light = 1e-6, support = 1;
  bool can_regularise = true;

  double solution() const { return -weight / (light + support); }
  double increment_scale() const override { return 1; }
  bool regularise(double share) override {
    share_ = share;
    return can_regularise;
  }
  Evaluation evaluate(std::span<const double> u, std::span<double> r, BlockMatrix<2>* K) override {
    r[0] = -weight - light * u[0] - support * std::min(u[0], 0.0);
    r[1] = 0;
    if (K) {
      K->set_zero();
      const double slope = light + (u[0] < 0 ? support : 0) + share_ * support;
      if (test::rank() == 0) K->add_diagonal(0, slope);
    }
    Evaluation evaluation;
    evaluation.force_scale = std::max(weight, std::abs(weight + r[0]));
    return evaluation;
  }

 private:
  double share_ = 0;
};

NewtonReport solve(NewtonProblem<2>& problem, double& u, const NewtonSettings& settings) {
  BlockMatrix<2> K;
  K.set_pattern(1, std::vector<std::int32_t>{0, 1}, std::vector<std::int32_t>{0});
  LinearSolver<2> linear(test::comm(), 2, {.method = "lu"});
  NewtonMatrix<2> matrix{K, linear};
  PhaseTimes times;
  std::array<double, 2> both = {u, 0};
  const NewtonReport report = solve_newton<2>(problem, matrix, settings, both, times);
  u = both[0];
  EXPECT_EQ(both[1], 0);
  return report;
}

NewtonReport solve(LooseNode& node, double& u, bool reuse_matrix = false) {
  return solve(node, u, NewtonSettings{.max_iterations = 30, .reuse_matrix = reuse_matrix});
}

TEST(LooseNode, defeats_the_line_search_without_a_brace) {
  LooseNode node;
  node.can_regularise = false;
  double u = 1e-3;
  test::expect_error<UnbalancedError>([&] { solve(node, u); }, {"line search failed"});
}

TEST(LooseNode, comes_to_rest_with_a_brace) {
  for (const double light : {1e-4, 1e-6, 1e-8}) {
    for (const double start : {1e-4, 1e-3, 1e-2, 1e-1}) {
      LooseNode node;
      node.light = light;
      double u = start;
      const NewtonReport report = solve(node, u);
      EXPECT_NEAR(u, node.solution(), 1e-10 * node.weight) << light << ' ' << start;
      EXPECT_GT(report.regularised, 0);
      EXPECT_LE(report.iterations, 16) << light << ' ' << start;
    }
  }
}

TEST(LooseNode, flies_where_nothing_stops_it) {
  LooseNode node;
  node.weight = -1e-3;
  double u = -1e-3;
  const NewtonReport report = solve(node, u);
  EXPECT_NEAR(u, 1e-3 / node.light, 1e-6);
  EXPECT_EQ(report.regularised, 0);
}

TEST(LooseNode, round_off_in_the_data_decides_nothing) {
  LooseNode first;
  double u_first = 0.7e-3;
  const int iterations = solve(first, u_first).iterations;
  for (int k = 1; k <= 10; ++k) {
    LooseNode node;
    node.weight *= 1 + k * 1e-14;
    double u = 0.7e-3;
    EXPECT_EQ(solve(node, u).iterations, iterations);
    EXPECT_NEAR(u, u_first, 1e-10 * first.weight);
  }
}

TEST(LooseNode, brace_and_kept_matrix_go_together) {
  LooseNode node;
  double u = 1e-3;
  solve(node, u, true);
  EXPECT_NEAR(u, node.solution(), 1e-8 * node.weight);
}

/// At u = 0 within the limit of |r|, with a small step to go; beyond, |r| jumps out of the limit.
class EdgeOfRest : public NewtonProblem<2> {
 public:
  double increment_scale() const override { return 1; }
  Evaluation evaluate(std::span<const double> u, std::span<double> r, BlockMatrix<2>* K) override {
    last_u = u[0];
    r[0] = u[0] < -0.5 ? -u[0] : u[0] > 0 ? 2e-5 : 5e-6 - u[0];
    r[1] = 0;
    if (K) {
      K->set_zero();
      if (test::rank() == 0) K->add_diagonal(0, 1);
    }
    Evaluation evaluation;
    evaluation.force_scale = 1;
    return evaluation;
  }
  double last_u = NAN;
};

TEST(EdgeOfRest, a_small_step_does_not_lead_out_of_the_limit_of_the_residual) {
  EdgeOfRest edge;
  const NewtonSettings settings{.residual_tolerance = 1e-5, .increment_tolerance = 1e-3};
  double u = -1;
  const NewtonReport report = solve(edge, u, settings);
  EXPECT_EQ(u, 0);
  EXPECT_EQ(edge.last_u, u);  // what the problem keeps belongs to the solution
  EXPECT_LE(report.residuals.back(), settings.residual_tolerance);
  EXPECT_EQ(report.iterations, 2);
}

TEST(Regularisation, comes_at_full_and_goes_with_good_steps) {
  Regularisation regularisation;
  EXPECT_FALSE(regularisation.active());
  regularisation.follow(1, 0.5);
  EXPECT_EQ(regularisation.share(), 0);
  EXPECT_TRUE(regularisation.raise());
  EXPECT_EQ(regularisation.share(), 1);
  EXPECT_FALSE(regularisation.raise());
  for (const double share : {1e-1, 1e-2, 1e-3, 0.0}) {
    regularisation.follow(1, 0.9);
    EXPECT_NEAR(regularisation.share(), share, 1e-12);
  }
  EXPECT_TRUE(regularisation.raise());
  regularisation.follow(1, 0.05);
  EXPECT_NEAR(regularisation.share(), 1e-2, 1e-12);
  regularisation.follow(1, 0.05);
  EXPECT_FALSE(regularisation.active());
}

TEST(Regularisation, rises_with_the_residual_and_then_stays_for_a_step) {
  Regularisation regularisation;
  regularisation.raise();
  regularisation.follow(1, 1.05);  // flat: as good
  regularisation.follow(1, 0.9);
  EXPECT_NEAR(regularisation.share(), 1e-2, 1e-12);
  regularisation.follow(1, 1.5);
  EXPECT_NEAR(regularisation.share(), 1e-1, 1e-12);
  regularisation.follow(1, 0.9);
  EXPECT_NEAR(regularisation.share(), 1e-1, 1e-12);
  regularisation.follow(1, 0.9);
  EXPECT_NEAR(regularisation.share(), 1e-2, 1e-12);
  EXPECT_TRUE(Regularisation::allows(1, 1.9));
  EXPECT_FALSE(Regularisation::allows(1, 2.1));
}

TEST(Regularisation, circles_of_any_period_are_seen_and_progress_is_not) {
  const auto circles = [](const std::vector<double>& residuals) {
    return go_in_circles(residuals);
  };
  EXPECT_TRUE(circles({1, 2, 1, 2, 1, 2}));
  EXPECT_TRUE(circles({1, 5, 40, 1, 5, 40, 1}));
  EXPECT_TRUE(circles({1, 2, 4, 8, 1, 2, 4, 8}));
  EXPECT_FALSE(circles({1, 1, 1, 1, 1}));  // too few to tell
  EXPECT_FALSE(circles({1, 1e-1, 2e-1, 3e-2, 5e-2, 1e-3}));
  EXPECT_FALSE(circles({1, 0.8, 0.64, 0.51, 0.41, 0.33}));
}

}  // namespace
}  // namespace gabion::test_regularisation
