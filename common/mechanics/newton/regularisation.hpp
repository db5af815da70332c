// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <algorithm>
#include <cstddef>
#include <span>

namespace gabion {

/// Regularisation at kinks of the equations: how much stiffness Newton's method adds there
/// (NewtonProblem::regularise), as a share of the full one, after the rule of Levenberg and Marquardt.
/// It starts at one and falls tenfold with each good step, a hundredfold where |r| fell tenfold;
/// below a thousandth plain steps come back. It rises tenfold after a refused step and after one
/// that raised |r|, and then stays for one good step. On the flat of a kink |r| hardly changes: up
/// to a tenth more counts as good.
///
/// @see Levenberg (1944); Marquardt (1963)
class Regularisation {
 public:
  double share() const { return share_; }  ///< 0: plain Newton
  bool active() const { return share_ > 0; }

  /// A step was refused, or iterations go in circles. @returns false where no more is possible
  bool raise() {
    if (share_ == full) return false;
    share_ = active() ? std::min(factor * share_, full) : full;
    return true;
  }
  /// A step was taken. @param norm_before, norm  |r| before and after it
  void follow(double norm_before, double norm) {
    if (!active()) return;
    if (norm > flat * norm_before) {
      share_ = std::min(factor * share_, full);
      stays_ = true;
    } else if (stays_) {
      stays_ = false;
    } else {
      share_ /= factor * norm < norm_before ? factor * factor : factor;
      if (share_ < smallest) share_ = 0;
    }
  }
  /// Whether a step with the regularisation may be taken: the path around a kink may pass through a
  /// larger |r|.
  static bool allows(double norm_before, double norm) { return norm <= growth * norm_before; }

 private:
  static constexpr double full = 1, factor = 10, flat = 1.1, growth = 2;
  static constexpr double smallest = 5e-4;  // 1, 0.1, 0.01, 0.001, then none
  double share_ = 0;
  bool stays_ = false;
};

/// Whether the last four residuals brought none below half of all before them: iterations that go
/// in circles, of whatever period.
inline bool go_in_circles(std::span<const double> residuals) {
  constexpr std::size_t window = 4, fewest_before = 2;
  constexpr double progress = 0.5;
  if (residuals.size() < window + fewest_before) return false;
  const auto last = residuals.last(window), before = residuals.first(residuals.size() - window);
  return *std::min_element(last.begin(), last.end()) >
         progress * *std::min_element(before.begin(), before.end());
}

}  // namespace gabion
