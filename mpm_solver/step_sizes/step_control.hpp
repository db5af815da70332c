// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <limits>
#include <optional>

#include "common/run/state.hpp"
#include "common/settings/config_reader.hpp"

namespace gabion::mpm {

/// "step_control" of mpm.json; a limit that is not there does not act. Without the object none
/// does.
struct StepControlSettings {
  std::optional<double> time_error;  ///< of a displacement by the longest of a step, (0, 1]
  std::optional<double> advective;   ///< largest displacement of a point by the cell size, (0, 1]
  std::optional<double> strain;      ///< largest strain increment of a point, (0, 1]
  std::optional<double> newton_target;  ///< iterations beyond which dt shrinks, >= 1
  std::optional<double> approach;  ///< surface may go this share of a cell into the soil, (0, 1]
  bool any() const { return time_error || advective || strain || newton_target || approach; }
};
KeyTable step_control_keys();
/// @param any_implicit  false: limits that measure implicit steps do not act and are refused
StepControlSettings read_step_control(ConfigReader in, bool any_implicit);

/// Reason that keeps the next step from being twice as long: the codes of column `dt_limit`
/// (docs/results.md).
enum class DtLimit {
  none = 0,
  phase = 1,
  advective = 2,
  strain = 3,
  newton = 4,   ///< iterations of Newton's method
  failure = 5,  ///< a step that failed not long ago
  approach = 6,
  time_error = 7
};
const char* limit_name(DtLimit limit);

/// An accepted step, the same on all ranks.
struct StepMeasures {
  double dt = 0;              ///< [s]
  double error = 0;           ///< of the displacement, see step_error(); 0: not known [m]
  double speed = 0;           ///< that errors are measured by [m/s]
  double travel = 0;          ///< largest displacement of a material point by the cell size
  double strain = 0;          ///< largest strain increment of a material point
  int newton_iterations = 0;  ///< largest number of a solution of the step
  /// Largest step [s] in which no surface goes beyond its limit, at the speed of this step.
  double approach_dt = std::numeric_limits<double>::infinity();
};

struct DtProposal {
  double dt = 0;  ///< [s], 0: any
  DtLimit limit = DtLimit::none;
};

/// Proposes dt from the last accepted step:
///
///     dt' = min(e, dt advective / travel, dt strain / |dE|, approach_dt, w)
///
/// e = dt time_error (dt V) / error, V the largest speed since the start; it grows by 1.25 a step.
/// w follows Newton's method: it grows by 1.25 after a step with at most 4 iterations (to 2 dt at
/// most), is dt after one with more and dt target / n after one with n > target; a failed step
/// leaves dt / 2. With a raster of dt / 2^k that doubles dt after four easy steps.
class StepControl {
 public:
  explicit StepControl(const StepControlSettings& settings) : settings_(settings) {}

  const StepControlSettings& settings() const { return settings_; }
  /// @param phase_dt  largest step that the phase allows [s], 0: any
  DtProposal accept(const StepMeasures& step, double phase_dt);
  /// Note that Newton's method failed with a step of this dt [s].
  void fail(double dt);
  void visit_state(StateVisitor& visitor);

 private:
  void follow_error(const StepMeasures& step);
  void follow_newton(double dt, int iterations);

  StepControlSettings settings_;
  double fastest_ = 0;    // V
  double error_dt_ = 0;   // e; 0: no step yet
  double newton_dt_ = 0;  // w; 0: no step yet
  double failed_dt_ = 0;  // of the last failure, until w is back there; 0: none
};

}  // namespace gabion::mpm
