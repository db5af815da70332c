// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Core>
#include <string>

#include "coupler/report/coupling_record.hpp"

namespace gabion {

/// One try to solve a step: the values of its last iteration, named as in docs/theory/coupling.md,
/// and what became of it.
struct Attempt {
  Eigen::VectorXd x = {};        ///< [m] displacement of the structures' wet surfaces, as guessed
  Eigen::VectorXd u = {};        ///< [m] H x, given to the soils
  Eigen::VectorXd f_soil = {};   ///< [N] answered by the soils
  Eigen::VectorXd f = {};        ///< [N] H^T f_soil
  Eigen::VectorXd f_given = {};  ///< [N] given to the structures; serial: f
  Eigen::VectorXd x_tilde = {};  ///< [m] answered by the structures

  bool soils_asked = false;      ///< they solve already (Sides::start_next)
  IterationRow row = {};         ///< row of the last iteration, with its request
  std::string status = {};       ///< empty until the last iteration is done
  std::string skipped = "none";  ///< | acceleration | structure
  std::string failure = {};      ///< why the step cannot be accepted; empty: it can
  bool solver_failed = false;    ///< a solver is the reason
  int soil_newton = 0;  ///< Newton iterations of the soils, summed over all coupling iterations
  int structure_newton = 0;

  int iterations() const { return row.request.iteration + 1; }
};

}  // namespace gabion
