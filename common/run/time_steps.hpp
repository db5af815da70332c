// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <string>

#include "common/run/dt_range.hpp"
#include "common/run/state.hpp"
#include "common/settings/config_reader.hpp"

namespace gabion {

/// The "time" object of coupler.json (or of a solver's own file when it runs alone).
struct TimeSettings {
  double end = 0;     ///< [s] > 0
  double dt = 0;      ///< [s] > 0, first step
  double dt_min = 0;  ///< [s], 0 < dt_min <= dt; a step that needs less ends the run with an error
  double dt_max = 0;  ///< [s] >= dt, largest step; 0: dt
};
KeyTable time_keys();
KeyTable output_keys();  ///< keys of "output"
TimeSettings read_time_settings(ConfigReader in);

/// Step sizes dt / 2^level, with negative levels up to dt_max. Time is counted in whole multiples
/// of dt / 2^max_level, so equal schedules give equal bits and a run that was cut comes back onto
/// the original raster.
class TimeSteps {
 public:
  explicit TimeSteps(const TimeSettings& settings);

  bool finished() const;
  std::int64_t step() const { return step_; }  ///< number of the current step, from 1
  double time() const;                         ///< [s] of the accepted state
  double dt() const;  ///< size of the current step [s]; the last one ends at `end`
  /// The step was accepted. After 4 accepted steps of one size dt doubles where dt_max and the
  /// raster allow it: steps of 2 dt start at multiples of 2 dt.
  /// @param proposed_dt  [s] wish of the solvers, 0 = none: the next step is the largest of the
  /// raster
  ///                     that is not above it, but never below the smallest one. A solver that
  ///                     cannot do with that fails the step.
  void accept(double proposed_dt = 0);
  /// The time steps as they are after accept().
  TimeSteps after(double proposed_dt) const;
  /// The wishes that lead to the same next step as this one.
  DtRange same_next(double proposed_dt) const;
  /// The step is to be repeated with dt/2.
  /// @throws ConvergenceError  dt_min reached; the message carries `reason`
  void cut(const std::string& reason);
  int cuts() const { return cuts_; }  ///< since this object was made

  /// Save or load where the run stands. The end may be another one than it was when saved; a run
  /// that has passed it is finished.
  void visit_state(StateVisitor& visitor);

 private:
  std::int64_t level_ticks(int level) const { return std::int64_t{1} << (max_level_ - level); }
  std::int64_t ticks_under_way() const;
  double level_dt(int level) const;

  void count_end_ticks();
  double raster_time() const;

  TimeSettings settings_;
  int min_level_ = 0;  // level of the largest step, <= 0
  double origin_ = 0;  // [s] start of the raster: 0, or the end of the run that this one extends
  int max_level_ = 0;
  std::int64_t end_ticks_ = 0;  // rounded up: the last tick is shorter when `end` is off the raster
  int level_ = 0;
  int accepted_at_level_ = 0;
  int cuts_ = 0;
  std::int64_t step_ = 1;
  std::int64_t ticks_ = 0;  // accepted time from origin_ on in units of dt / 2^max_level
};

}  // namespace gabion
