// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

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
void expect_iterations(const std::string& what, const TubeRun& run, double reference) {
  const TubeResult result = run_tube(run);
  ASSERT_EQ(result.failure, "") << what;
  verify({.id = "C1",
          .what = "mean iterations, " + what,
          .exact = reference,
          .computed = result.mean_iterations,
          .measure = Measure::absolute_error,
          .bound = 0.3,
          .unit = "iterations a step"});
}

TEST(C1_ElasticTube, takes_the_iterations_of_an_independent_implementation) {
  const Filter qr2{FilterKind::qr2, 1e-3};
  expect_iterations("IQN-ILS, 8 steps reused", run_of("iqn_ils", qr2, 8, 0), 8.42);
  expect_iterations("IQN-ILS, 2 steps reused", run_of("iqn_ils", qr2, 2, 0), 9.95);
  expect_iterations("multi-vector, 100 steps reused", run_of("mvqn", {}, 100, 0), 8.33);
  expect_iterations("multi-vector, 8 steps reused", run_of("mvqn", {}, 8, 0), 10.0);
}

TEST(C1_ElasticTube, a_quadratic_predictor_saves_a_quarter) {
  const TubeResult result = run_tube(run_of("iqn_ils", {FilterKind::qr2, 1e-3}, 8, 2));
  ASSERT_EQ(result.failure, "");
  verify({.id = "C1",
          .what = "mean iterations, IQN-ILS, 8 steps reused, predictor 2",
          .exact = 6.25,
          .computed = result.mean_iterations,
          .measure = Measure::absolute_error,
          .bound = 0.3,
          .unit = "iterations a step"});
  EXPECT_LE(result.mean_iterations, 6.3);
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

/// Corners of the grid that scripts/bench coupling covers in full.
TEST(C1_ElasticTube, mvqn_converges_without_tuning) {
  const std::vector<Filter> filters = {{FilterKind::none, 0},
                                       {FilterKind::qr1, 1e-2},
                                       {FilterKind::qr1_absolute, 1e-8},
                                       {FilterKind::qr2, 1e-2}};
  for (const Filter& filter : filters) {
    for (const double relaxation : {0.01, 0.5}) {
      for (const double dt : {0.005, 0.02}) {
        TubeRun run;
        run.acceleration.relaxation = relaxation;
        run.acceleration.filter = filter;
        run.acceleration.max_columns = dt < 0.01 ? 20 : 100;
        run.predictor = 1;
        run.dt = dt;
        run.steps = 10;
        EXPECT_EQ(run_tube(run).failure, "") << int(filter.kind) << " " << relaxation << " " << dt;
      }
    }
  }
  verify({.id = "C1",
          .what = "MVQN, 16 settings, failures",
          .exact = 0,
          .computed = HasFailure() ? 1.0 : 0.0,
          .measure = Measure::absolute_error,
          .bound = 0});
}

}  // namespace
}  // namespace gabion
