// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <limits>
#include <string>

#include "common/run/state.hpp"
#include "mpm_solver/phases/strength_reduction.hpp"

namespace gabion::mpm {

/// Reason why a factor was not reached.
enum class SlopeEnd { none = 0, no_equilibrium = 1, displacement = 2 };

/// Search for the largest factor with an equilibrium; part of the accepted state.
///
/// Each step takes F + increment, or less where the soil moves far, since its displacement depends
/// on the increments. A step without equilibrium, or with one beyond the largest displacement, is
/// tried again with half the increment; one whose increment is no larger than the tolerance ends
/// the search. From then on the strength is that of `from` again.
class StrengthSearch {
 public:
  /// Start the search of a phase.
  void start(const StrengthReduction& settings, int phase);
  int phase() const { return static_cast<int>(phase_); }
  bool started() const { return phase_ >= 0; }
  /// Halve the increment where the step of next() moves the soil too far to resolve its path.
  /// @param displacement  largest of a material point in the step [m]
  /// @returns whether it did; false with increments of at most the tolerance
  bool shorten(const StrengthReduction& settings, double displacement);
  /// Factor of the next step.
  double next(const StrengthReduction& settings) const;
  /// Whether the search has ended: the bracket is as narrow as asked for, or `to` has an
  /// equilibrium.
  bool ended(const StrengthReduction& settings) const {
    return bracketed() || highest_ >= settings.to;
  }
  /// Whether the bracket is as narrow as asked for.
  bool bracketed() const { return end() != SlopeEnd::none; }
  /// Whether in addition the soil slid more and more before: then the bracket holds the factor of
  /// safety, not merely the place where Newton's method gave up.
  bool found() const;

  /// Note that the step of next() has an equilibrium.
  /// @param displacement  largest of a material point in the step [m]
  /// @returns false: it counts as failed, see fail()
  bool take(const StrengthReduction& settings, double displacement);
  /// Whether a failed step counts: not before `from` has an equilibrium, nor after the end.
  bool can_fail(const StrengthReduction& settings) const {
    return highest_ > 0 && !ended(settings);
  }
  /// Note that the step of next() has none.
  /// @param text  what was wrong with it
  /// @throws Error  not can_fail()
  void fail(const StrengthReduction& settings, SlopeEnd reason, const std::string& text);

  double highest() const { return highest_; }            ///< largest F with an equilibrium; 0: none
  double failed() const { return failed_; }              ///< smallest F without; infinite: none
  double displacement() const { return displacement_; }  ///< since `from`, at highest() [m]
  SlopeEnd end() const { return static_cast<SlopeEnd>(end_); }
  /// Displacement by F of the last step over that of the whole search; a last step that moved too
  /// far counts. 0: nothing moved.
  double knee() const;
  /// Share by which F grew over the second half of the displacement, that of the last step, which
  /// moved too far, included: small where the slope slides at a constant F. 0 with another end.
  double growth() const;

  /// Entry of summary.json, with the displacement at each F.
  Json summary() const;
  /// One line about the result.
  void log_result() const;

  void visit_state(StateVisitor& visitor);

 private:
  std::int64_t phase_ = -1;
  double from_ = 0;
  double highest_ = 0;
  double failed_ = std::numeric_limits<double>::infinity();
  double increment_ = 0;
  double displacement_ = 0;
  double last_rate_ = 0, failed_rate_ = 0;  // displacement by F [m]
  std::int64_t end_ = 0;
  Json steps_ = Json::array();  // F and displacement [m] of each step with an equilibrium
  Json reason_ = "";            // of the last failure
};

}  // namespace gabion::mpm
