// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>
#include <utility>
#include <vector>

#include "common/base/error.hpp"

namespace gabion {

/// Newton's method has found no balance: its residuals show whether two failures are the same one.
class UnbalancedError : public ConvergenceError {
 public:
  /// @param residuals  |r| of each iterate, in the unit of the forces
  UnbalancedError(const std::string& message, std::string cause, std::vector<double> residuals)
      : ConvergenceError(message, std::move(cause)), residuals_(std::move(residuals)) {}
  const std::vector<double>& residuals() const { return residuals_; }

 private:
  std::vector<double> residuals_;
};

/// Throw the error with another message; kind, cause and residuals stay.
[[noreturn]] inline void throw_as(const std::string& message, const ConvergenceError& error) {
  if (const auto* unbalanced = dynamic_cast<const UnbalancedError*>(&error)) {
    throw UnbalancedError(message, error.cause(), unbalanced->residuals());
  }
  throw ConvergenceError(message, error.cause());
}

}  // namespace gabion
