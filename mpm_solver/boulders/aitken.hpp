// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <vector>

namespace gabion::mpm {

/// Aitken's relaxation of a fixed point.
class AitkenRelaxation {
 public:
  /// @param difference  of what the last values lead to and these values
  /// @returns the share of the difference to add
  double next(const std::vector<double>& difference) {
    if (!last_.empty()) {
      double product = 0, square = 0;
      for (std::size_t k = 0; k < difference.size(); ++k) {
        const double change = difference[k] - last_[k];
        product += last_[k] * change;
        square += change * change;
      }
      if (square > 0) share_ *= -product / square;
    }
    last_ = difference;
    return share_;
  }

 private:
  std::vector<double> last_;
  double share_ = 1;
};

}  // namespace gabion::mpm
