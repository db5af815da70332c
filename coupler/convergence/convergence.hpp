// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Core>
#include <optional>
#include <string>

#include "common/settings/config_reader.hpp"

namespace gabion {

/// Combination of the criteria of a run.
enum class Combine { all, any };

/// Criteria of one field; norms are root mean squares over its components.
struct FieldLimits {
  std::optional<double> absolute;  ///< [m] or [N], > 0
  std::optional<double> relative;  ///< limit over the field's norm, >= 1e-15
  double floor = 0;                ///< [m] or [N], >= 0: the relative limit is not taken below this
  std::optional<double> drop;      ///< limit over the first residual of the step, in (0, 1)

  bool given() const { return absolute || relative || drop; }
  /// The residual that is allowed for a field of this norm: the smallest of the limits where all
  /// criteria must hold, else the largest. Empty without a criterion that has a value.
  /// @param first  residual of the step's first iteration that has one
  std::optional<double> limit(double norm, std::optional<double> first = {},
                              Combine combine = Combine::all) const;
};

/// The "coupling/convergence" object of coupler.json.
struct ConvergenceSettings {
  FieldLimits displacement;
  FieldLimits force;
  Combine combine = Combine::all;  ///< criteria of both fields
  double divergence = 1e3;  ///< > 1: residual above this multiple of the step's first is "diverged"
  int stagnation = 20;      ///< >= 2: iterations without a new smallest residual are "stagnated"
};
KeyTable convergence_keys();
/// @throws ConfigError  also without any criterion
ConvergenceSettings read_convergence_settings(ConfigReader in);

enum class Verdict { going_on, converged, not_finite, limit_reached, stagnated, diverged };
std::string name(Verdict verdict);

/// Result of one check; a residual that does not exist yet is empty, and so is the limit of a field
/// that has no criterion.
struct ConvergenceState {
  Verdict verdict = Verdict::going_on;
  double displacement_residual = 0;          ///< [m]
  std::optional<double> displacement_limit;  ///< [m]
  std::optional<double> force_residual;  ///< [N]; serial: from the second iteration of a step on
  std::optional<double> force_limit;     ///< [N]
  /// "displacement" or "force" when that field's limit is below the round-off of its values, so
  /// that only luck can meet it; else empty.
  std::string below_round_off;
};

/// Judges the iterations of one step. Values that are not finite are found before anything is
/// compared, so that an overflow cannot pass as converged.
class Convergence {
 public:
  explicit Convergence(const ConvergenceSettings& settings) : settings_(settings) {}

  void begin_step();
  /// Serial scheme: residuals are x_tilde - x and the change of the force since the iteration
  /// before, so that a step takes two iterations where the force has a criterion.
  ConvergenceState check(const Eigen::VectorXd& x, const Eigen::VectorXd& x_tilde,
                         const Eigen::VectorXd& force);
  /// Parallel scheme: residuals are x_tilde - x and force - force_given.
  ConvergenceState check(const Eigen::VectorXd& x, const Eigen::VectorXd& x_tilde,
                         const Eigen::VectorXd& force_given, const Eigen::VectorXd& force);
  /// State of a step that is solved by one pass: tests only that everything is finite.
  static ConvergenceState one_pass(const Eigen::VectorXd& x, const Eigen::VectorXd& x_tilde,
                                   const Eigen::VectorXd& force);

 private:
  /// @param num_references  first checks of a step whose largest displacement residual is what
  ///                        divergence is measured by
  ConvergenceState check_pairs(const Eigen::VectorXd& x, const Eigen::VectorXd& x_tilde,
                               const Eigen::VectorXd& force_given, const Eigen::VectorXd& force,
                               int num_references);
  void set_limits(double displacement_norm, double force_norm, int num_references,
                  ConvergenceState& state);
  Verdict judge(const ConvergenceState& state);

  ConvergenceSettings settings_;
  Eigen::VectorXd force_last_;                // empty in the first iteration
  std::optional<double> first_displacement_;  // [m] residuals of this step
  std::optional<double> first_force_;         // [N]
  double reference_ = 0;                      // [m]
  double smallest_ = 0;                       // smallest residual over its limit
  bool complete_before_ = false;              // all residuals that have criteria were known
  int since_smallest_ = 0;
  int checks_ = 0;  // checks in this step
};

/// Root mean square over the components; 0 for an empty vector.
double rms(const Eigen::VectorXd& values);

}  // namespace gabion
