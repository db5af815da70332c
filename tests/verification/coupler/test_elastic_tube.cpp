// SPDX-License-Identifier: BSD-3-Clause
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <vector>

#include "tests/support/tube_run.hpp"
#include "tests/support/verification_row.hpp"

namespace gabion {
namespace {

using test::Measure;
using test::run_tube;
using test::TubeResult;
using test::TubeRun;
using test::verify;

TubeRun run_of(const std::string& method, const Filter& filter, int history, int predictor) {
  TubeRun run;
  run.acceleration.method = method;
  run.acceleration.relaxation = 0.01;
  run.acceleration.filter = filter;
  run.acceleration.history = history;
  run.acceleration.max_columns = 1000;
  run.predictor = predictor;
  return run;
}

/// Mean iterations of an independent implementation with the same equations, relative 1e-5 on area
/// and pressure, omega 0.01.
TubeResult expect_iterations(const std::string& what, const TubeRun& run, double reference) {
  const TubeResult result = run_tube(run);
  EXPECT_EQ(result.failure, "") << what;
  verify({.id = "C1",
          .what = "mean iterations, " + what,
          .exact = reference,
          .computed = result.mean_iterations,
          .measure = Measure::absolute_error,
          .bound = 0.3,
          .unit = "iterations a step"});
  return result;
}

TEST(C1_ElasticTube, takes_the_iterations_of_an_independent_implementation) {
  const Filter qr2{FilterKind::qr2, 1e-3};
  expect_iterations("IQN-ILS, 8 steps reused", run_of("iqn_ils", qr2, 8, 0), 8.42);
  expect_iterations("IQN-ILS, 2 steps reused", run_of("iqn_ils", qr2, 2, 0), 9.95);
  expect_iterations("multi-vector, 100 steps reused", run_of("mvqn", {}, 100, 0), 8.33);
  // Its multi-vector method forgets what earlier steps found, this one does not.
  EXPECT_LE(run_tube(run_of("mvqn", {}, 8, 0)).mean_iterations, 10.0);
}

/// Aitken's iterations on the tube hang on round-off: a relaxation that differs by 1e-12 changes
/// the mean by up to 1.5, and one of 13 such runs diverged. So the median of five runs counts.
double median_of_aitken(double omega) {
  std::vector<double> means;
  for (int k = -2; k <= 2; ++k) {
    TubeRun run = run_of("aitken", {}, 0, 0);
    run.acceleration.relaxation = omega * (1 + 1e-12 * k);
    run.max_iterations = 300;
    run.accept_at_limit = true;
    const TubeResult result = run_tube(run);
    EXPECT_LE(result.at_limit, 5) << omega;
    means.push_back(result.mean_iterations);
  }
  std::sort(means.begin(), means.end());
  return means[2];
}

/// That implementation accepts the steps that reach its limit of 300 iterations, and counts them:
/// its means are 74.6 and 69.4, without those steps they are what stands here.
TEST(C1_ElasticTube, aitken_takes_the_iterations_of_an_independent_implementation) {
  for (const auto& [omega, reference] : {std::pair{0.1, 62.7}, {0.01, 59.8}}) {
    verify({.id = "C1",
            .what = fmt::format("median of mean iterations, Aitken, relaxation {}", omega),
            .exact = reference,
            .computed = median_of_aitken(omega),
            .measure = Measure::absolute_error,
            .bound = 5,
            .unit = "iterations a step"});
  }
}

/// Messages carry all bits of a double: nothing changes.
TEST(C1_ElasticTube, is_the_same_through_sockets) {
  TubeRun run = run_of("mvqn", {}, 8, 1);
  run.steps = 10;
  const TubeResult direct = run_tube(run);
  run.through_sockets = true;
  const TubeResult sent = run_tube(run);
  ASSERT_EQ(sent.failure, "");
  EXPECT_EQ(sent.mean_iterations, direct.mean_iterations);
  verify({.id = "C1",
          .what = "pressure at mid-node, through sockets against within one process",
          .exact = direct.pressure,
          .computed = sent.pressure,
          .bound = 0,
          .unit = "Pa"});
}

TEST(C1_ElasticTube, a_quadratic_predictor_saves_a_quarter) {
  const Filter qr2{FilterKind::qr2, 1e-3};
  const TubeResult result =
      expect_iterations("IQN-ILS, 8 steps reused, predictor 2", run_of("iqn_ils", qr2, 8, 2), 6.25);
  const TubeResult constant = run_tube(run_of("iqn_ils", qr2, 8, 0));
  EXPECT_LE(result.mean_iterations, 0.75 * constant.mean_iterations);
}

/// p = -222.8517 +- 1e-4 is what converging methods agree on at the tolerance 1e-5.
TEST(C1_ElasticTube, reaches_the_reference_values_at_mid_node) {
  TubeRun run = run_of("iqn_ils", {FilterKind::qr2, 1e-3}, 8, 2);
  run.tolerance = 1e-9;
  const TubeResult result = run_tube(run);
  ASSERT_EQ(result.failure, "");
  verify({.id = "C1",
          .what = "pressure at mid-node after 100 steps",
          .exact = -222.8517,
          .computed = result.pressure,
          .bound = 1e-6,
          .unit = "Pa"});
  verify({.id = "C1",
          .what = "area at mid-node after 100 steps",
          .exact = 0.97532030,
          .computed = result.area,
          .bound = 1e-7,
          .unit = "m^2"});
}

/// A part of the grid that scripts/bench coupling covers in full: the fewest columns, where steps
/// of half the size failed when columns of earlier steps were overwritten.
TEST(C1_ElasticTube, mvqn_converges_without_tuning) {
  int failures = 0, runs = 0;
  for (const auto& [label, filter] : test::grid_filters()) {
    for (const double relaxation : {0.01, 0.1, 0.5}) {
      for (const double dt : {0.005, 0.02}) {
        const TubeRun run = test::grid_run(filter, relaxation, 20, dt);
        const TubeResult result = run_tube(run);
        EXPECT_EQ(result.failure, "") << label << " " << relaxation << " " << dt;
        failures += !result.failure.empty();
        ++runs;
      }
    }
  }
  verify({.id = "C1",
          .what = std::to_string(runs) + " settings of MVQN with 20 columns, failures",
          .exact = 0,
          .computed = double(failures),
          .measure = Measure::absolute_error,
          .bound = 0});
}

}  // namespace
}  // namespace gabion
