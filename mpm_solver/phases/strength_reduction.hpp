// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <limits>

#include "common/run/state.hpp"
#include "common/settings/config_reader.hpp"

namespace gabion::mpm {

/// "strength_reduction" of a phase: strengths are divided by a factor F that grows from step to
/// step until no equilibrium is found.
struct StrengthReduction {
  double from = 1;              ///< F of the first step, > 0
  double to = 5;                ///< largest F, > from
  double increment = 0.1;       ///< of F a step until the first failure, > 0
  double tolerance = 0.005;     ///< largest width of the bracket of F, > 0
  double max_displacement = 0;  ///< [m] since `from` beyond which the slope has failed, > 0
};

KeyTable strength_reduction_keys();
/// @throws ConfigError
StrengthReduction read_strength_reduction(ConfigReader in);

/// Why a factor was not reached.
enum class SlopeEnd { none = 0, no_equilibrium = 1, displacement = 2 };

/// Search for the largest factor with an equilibrium; part of the accepted state.
///
/// Each step takes F + increment. A step without equilibrium, or with one beyond the largest
/// displacement, is tried again with half the increment; one whose increment is no larger than the
/// tolerance ends the search. From then on the strength is that of `from` again.
class StrengthSearch {
 public:
  /// The search of a phase begins.
  void start(const StrengthReduction& settings, int phase);
  int phase() const { return static_cast<int>(phase_); }
  bool started() const { return phase_ >= 0; }
  /// Factor of the next step.
  double next(const StrengthReduction& settings) const;
  bool ended(const StrengthReduction& settings) const { return found() || highest_ >= settings.to; }
  bool found() const { return end() != SlopeEnd::none; }

  /// The step of next() has an equilibrium.
  /// @param displacement  largest of a material point in the step [m]
  /// @returns false: it counts as failed, see fail()
  bool take(const StrengthReduction& settings, double displacement);
  /// The step of next() has none.
  /// @returns false: no smaller step can help, `from` itself has no equilibrium
  bool fail(const StrengthReduction& settings, SlopeEnd reason);

  double highest() const { return highest_; }  ///< largest F with an equilibrium; 0: none yet
  double failed() const { return failed_; }    ///< smallest F without; infinite: none
  double displacement() const { return displacement_; }  ///< since `from`, at highest() [m]
  SlopeEnd end() const { return static_cast<SlopeEnd>(end_); }
  /// Displacement by F of the last step before the failure over that of the first [-].
  double knee() const { return first_rate_ > 0 ? last_rate_ / first_rate_ : 0; }

  void visit_state(StateVisitor& visitor);

 private:
  std::int64_t phase_ = -1;
  double highest_ = 0;
  double failed_ = std::numeric_limits<double>::infinity();
  double increment_ = 0;
  double displacement_ = 0;
  double first_rate_ = 0, last_rate_ = 0;  // displacement by F [m]
  std::int64_t end_ = 0;
};

}  // namespace gabion::mpm
