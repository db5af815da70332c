// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>
#include <utility>
#include <vector>

#include "coupler/coupler_config.hpp"
#include "tests/support/elastic_tube.hpp"

namespace gabion::test {

/// One run of the elastic tube through the coupling loop.
struct TubeRun {
  AccelerationSettings acceleration;
  int predictor = 0;
  double dt = 0.01;  ///< [s]; the tube's own is 0.01
  int steps = 100;
  double tolerance = 1e-5;  ///< of area and pressure, relative to their norms
  int max_iterations = 100;
  bool accept_at_limit = false;  ///< a step with so many iterations is accepted all the same
  bool through_sockets = false;  ///< server, two threads and messages between; else direct calls
};

struct TubeResult {
  std::string failure;  ///< empty: every step converged
  double mean_iterations = 0;
  int first_step = 0;  ///< iterations
  int max = 0;
  int at_limit = 0;     ///< steps that were accepted without convergence
  double pressure = 0;  ///< at mid-node, at the end
  double area = 0;
};

/// Filters of the robustness grid, by name.
std::vector<std::pair<std::string, Filter>> grid_filters();
/// One second of the tube by MVQN with linear prediction: a setting of the robustness grid.
TubeRun grid_run(const Filter& filter, double relaxation, int columns, double dt);

/// May be called from several threads at once.
TubeResult run_tube(const TubeRun& run);

}  // namespace gabion::test
