// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <functional>
#include <string>
#include <vector>

#include "common/run/solver.hpp"

namespace gabion {

/// Outcome of one trial of a participant.
struct CheckRow {
  enum class Outcome {
    passed,
    inexact,  ///< equal to the solver's tolerance, as a warm start from the last solution makes it
    notice,   ///< right for some codes, a mistake in most
    failed,
    not_asked
  };
  std::string what;
  Outcome outcome = Outcome::passed;
  std::string found;  ///< why it is not passed
};

struct CheckSettings {
  double dt = 0;         ///< [s] > 0
  double amplitude = 0;  ///< > 0, of the random values sent to it: [N] forces or [m] displacements
  std::function<void(const CheckRow&)> report = {};  ///< gets each row as soon as it is known
  std::function<void()> finish = {};                 ///< ends the run: the last row
};

/// Drive a participant through what a coupled run may ask of it: the same request twice, another
/// trial in between, rejected steps, smaller dt, accepted steps, output, a state that is saved and
/// loaded after other steps, a skipped step. From one state, that is after reject_step and
/// accept_step, equal requests must give equal bits; after another trial of the same step, values
/// that agree to 1e-8 of the largest. The values sent are the same in every check.
///
/// Behaviour that is legal but mostly a mistake is a notice: an answer that depends neither on the
/// values nor on dt, or is the same after an accepted step.
///
/// A participant that is lost during the checks ends the table with a row that names the check.
std::vector<CheckRow> check_participant(Solver& solver, const CheckSettings& settings);

/// No row has failed.
bool all_passed(const std::vector<CheckRow>& rows);

/// A line, aligned with those of other rows.
std::string row_text(const CheckRow& row);
/// A line a row.
std::string table_text(const std::vector<CheckRow>& rows);

}  // namespace gabion
