// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Core>
#include <string>

#include "coupler/report/coupling_record.hpp"

namespace gabion {

/// Outcome of an attempt.
enum class Outcome {
  iterating,
  converged,    ///< the residuals are within their limits
  one_pass,     ///< the explicit scheme has no residual
  no_contact,   ///< no soil can push: one pass is exact
  unconverged,  ///< the verdict says why; accepted all the same, by "on_limit"
  failed,       ///< the verdict says why; the step cannot be accepted
  unsolved      ///< a solver could not solve its side; the step cannot be accepted
};

/// One try to solve a step: the values of its last iteration, named as in docs/theory/coupling.md,
/// and its outcome.
struct Attempt {
  StepRequest request = {};      ///< of the current iteration, or of the last one
  Eigen::VectorXd x = {};        ///< [m] displacement of the structures' wet surfaces, as guessed
  Eigen::VectorXd u = {};        ///< [m] H x, given to the soils
  Eigen::VectorXd f_soil = {};   ///< [N] answered by the soils
  Eigen::VectorXd f = {};        ///< [N] H^T f_soil
  Eigen::VectorXd f_given = {};  ///< [N] given to the structures; serial: f
  Eigen::VectorXd x_tilde = {};  ///< [m] answered by the structures

  bool soils_asked = false;  ///< they solve already (Sides::start_next)
  IterationRow row = {};     ///< row of the last iteration
  Outcome outcome = Outcome::iterating;
  Skipped skipped = Skipped::nothing;
  std::string reason = {};  ///< why the attempt failed, or a solver could not solve
  bool at_any_dt = false;   ///< a solver says that a smaller dt is of no use
  int soil_newton = 0;      ///< Newton iterations of the soils, summed over all coupling iterations
  int structure_newton = 0;

  int iterations() const { return request.iteration + 1; }
  bool acceptable() const { return outcome != Outcome::failed && outcome != Outcome::unsolved; }
};

/// The word of `status` in steps.csv.
std::string status(const Attempt& attempt);

}  // namespace gabion
