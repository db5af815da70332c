// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Core>
#include <optional>
#include <string>

#include "common/base/config_reader.hpp"

namespace gabion {

/// Limits of one field; norms are root mean squares over its components.
struct FieldLimits {
  double absolute = 0;  ///< [m] or [N], > 0
  double relative = 0;  ///< of the field's norm, > 0
  double floor = 0;     ///< [m] or [N], > 0: the relative limit is not taken below this
  /// The residual that is allowed for a field of this norm: both limits must hold.
  double limit(double norm) const;
};

/// The "coupling/convergence" object of coupler.json.
struct ConvergenceSettings {
  FieldLimits displacement;
  FieldLimits force;
  double divergence = 1e3;  ///< > 1: residual above this multiple of the step's first is "diverged"
  int stagnation = 20;      ///< >= 2: iterations without a new smallest residual are "stagnated"
};
ConvergenceSettings read_convergence_settings(ConfigReader in);

enum class Verdict { going_on, converged, not_finite, limit_reached, stagnated, diverged };
std::string name(Verdict verdict);

/// Result of one check; a residual that does not exist yet is empty.
struct ConvergenceState {
  Verdict verdict = Verdict::going_on;
  double displacement_residual = 0;      ///< [m]
  double displacement_limit = 0;         ///< [m]
  std::optional<double> force_residual;  ///< [N], from the second iteration of a step on
  double force_limit = 0;                ///< [N]
};

/// Judges the iterations of one step. Values that are not finite are found before anything is
/// compared, so that an overflow cannot pass as converged.
class Convergence {
 public:
  explicit Convergence(const ConvergenceSettings& settings) : settings_(settings) {}

  void begin_step();
  /// Converged when the displacement residual x_tilde - x and the change of the force since the
  /// iteration before are both within their limits: two iterations at least.
  ConvergenceState check(const Eigen::VectorXd& x, const Eigen::VectorXd& x_tilde,
                         const Eigen::VectorXd& force);
  /// For a step that is solved by one pass: only tests that everything is finite.
  static ConvergenceState one_pass(const Eigen::VectorXd& x, const Eigen::VectorXd& x_tilde,
                                   const Eigen::VectorXd& force);

 private:
  Verdict judge(const ConvergenceState& state);

  ConvergenceSettings settings_;
  Eigen::VectorXd force_last_;  // empty in the first iteration
  double reference_ = 0;        // [m] residual of the first iteration, not below its limit
  double smallest_ = 0;         // of the residuals divided by their limits
  int since_smallest_ = 0;
  bool first_ = true;
};

/// Root mean square over the components; 0 for an empty vector.
double rms(const Eigen::VectorXd& values);

}  // namespace gabion
