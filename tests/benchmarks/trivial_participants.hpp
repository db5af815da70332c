// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <string>

namespace gabion::test {

/// A coupled run of three processes whose solvers do next to nothing: x_tilde_i = -m_i x_i +
/// b_i(t).
struct Overhead {
  std::string method = "constant";  ///< of acceleration
  std::int64_t num_nodes = 100;     ///< x 3 components
  int columns = 100;                ///< kept by a quasi-Newton method
  int steps = 20;                   ///< of which the second half is measured
  int iterations = 11;              ///< of each step, whatever the residual
};

/// Wall time of one coupling iteration [us] as the mean over the steps measured, and where it went.
struct OverheadResult {
  double all = 0;           ///< without the solvers' own work
  double messages = 0;      ///< both participants
  double acceleration = 0;  ///< with its share of the end of the step
  double rest = 0;          ///< mapping, sums of both sides, convergence, tables
  double resident_mb = 0;   ///< of the coupler at the end
};

/// Starts the participants as processes of their own by fork: call it before any thread exists.
OverheadResult measure_overhead(const Overhead& what);

}  // namespace gabion::test
