// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "coupler/coupler_config.hpp"
#include "tests/support/elastic_tube.hpp"

namespace gabion::test {

/// One run of the elastic tube through coupling loop, server and sockets.
struct TubeRun {
  AccelerationSettings acceleration;
  int predictor = 0;
  double dt = 0.01;  ///< [s]; the tube's own is 0.01
  int steps = 100;
  double tolerance = 1e-5;  ///< of area and pressure, relative to their norms
  int max_iterations = 100;
};

struct TubeResult {
  std::string failure;  ///< empty: every step converged
  double mean_iterations = 0;
  int first_step = 0;  ///< iterations
  int max = 0;
  double pressure = 0;  ///< at mid-node, at the end
  double area = 0;
};

TubeResult run_tube(const TubeRun& run);

}  // namespace gabion::test
