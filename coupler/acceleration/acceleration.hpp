// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Core>
#include <memory>
#include <string>
#include <vector>

#include "common/run/state.hpp"
#include "common/settings/config_reader.hpp"
#include "coupler/acceleration/filter.hpp"

namespace gabion {

/// The "coupling/acceleration" object of coupler.json.
struct AccelerationSettings {
  std::string method = "mvqn";  ///< constant | aitken | iqn_ils | mvqn
  double relaxation = 0.5;      ///< omega in (0, 2]: constant factor, or the very first step
  Filter filter;                ///< which columns are dropped as dependent
  int history = 2;              ///< accepted steps whose columns are kept, >= 0
  int max_columns = 200;        ///< columns kept of all steps together, >= 1
  double damping = 1;           ///< beta in (0, 1], factor of the residual that no column covers
};
KeyTable acceleration_keys();
AccelerationSettings read_acceleration_settings(ConfigReader in);

/// Counts of the last `next`, for the log.
struct AccelerationCounters {
  double omega = 0;            ///< relaxation used; 0 when columns decided
  int columns = 0;             ///< number of columns in use
  int dropped_by_filter = 0;   ///< columns, in this call, as the next two
  int dropped_by_limit = 0;    ///< because there were more than max_columns
  int dropped_by_contact = 0;  ///< columns dropped before the call, because they would mislead
  bool fell_back = false;  ///< the filter led nowhere: from this call on the default one is used
};

/// Finds the fixed point x = x_tilde(x) of a coupled step from pairs (x, x_tilde), r = x_tilde - x.
///
///     begin_step, next, next, ..., end_step          step accepted
///     begin_step, next, next, ..., discard_step      step rejected: all it learned is forgotten
class Acceleration {
 public:
  virtual ~Acceleration() = default;

  virtual void begin_step() = 0;
  /// The next guess, from the last guess and the solvers' answer to it.
  virtual Eigen::VectorXd next(const Eigen::VectorXd& x, const Eigen::VectorXd& x_tilde) = 0;
  /// End a step that was accepted with this last pair, from which the method still learns.
  virtual void end_step(const Eigen::VectorXd& x, const Eigen::VectorXd& x_tilde) = 0;
  virtual void discard_step() = 0;
  /// Forget earlier steps, and all that was learned in this one.
  /// @returns number of columns that were forgotten
  virtual int reset() = 0;
  /// Multiply all kept vectors by these factors, by which x and x_tilde will be multiplied from now
  /// on.
  virtual void rescale(const Eigen::VectorXd& ratio) = 0;
  virtual AccelerationCounters counters() const = 0;
  /// Save or load what was learned from accepted steps. @pre no step is open
  virtual void visit_state(StateVisitor& visitor) = 0;
};

/// All names that AccelerationSettings::method may have.
const std::vector<std::string>& acceleration_methods();

/// @param fields  sizes of the fields that x consists of, one after the other: one, or displacement
///                and force, which are weighted (ScaledFields)
std::unique_ptr<Acceleration> make_acceleration(const AccelerationSettings& settings,
                                                const std::vector<Eigen::Index>& fields);

}  // namespace gabion
