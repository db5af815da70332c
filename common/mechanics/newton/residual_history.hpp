// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cmath>
#include <cstddef>
#include <span>

// What |r| of the iterates so far, oldest first, says of the next one.
namespace gabion {

/// Quadratic convergence through the last two; infinite where they do not show it.
inline double predicted_residual(std::span<const double> residuals) {
  if (residuals.size() < 2) return HUGE_VAL;
  const double before = residuals[residuals.size() - 2], last = residuals.back();
  if (!(last < before)) return HUGE_VAL;
  return last * (last / before) * (last / before);
}

/// Whether a matrix that brought |r| from `before` to `last` brings it within `tolerance` by one
/// more step: its reduction again, 30 times worse. Theory says 2; where soil begins to yield 20 to
/// 60 were found.
inline bool matrix_serves_again(double before, double last, double tolerance) {
  constexpr double margin = 30;
  return margin * last * (last / before) <= tolerance;
}
inline bool matrix_serves_again(std::span<const double> residuals, double tolerance) {
  const std::size_t n = residuals.size();
  return n > 1 && matrix_serves_again(residuals[n - 2], residuals[n - 1], tolerance);
}
/// The same of the next matrix, by the predicted residual.
inline bool next_matrix_serves_again(std::span<const double> residuals, double tolerance) {
  return matrix_serves_again(residuals.back(), predicted_residual(residuals), tolerance);
}

/// Across a kink (contact that opens, a point that leaves the yield surface) full steps may jump to
/// and fro between two states for ever; half a step lands between them.
inline bool residuals_cycle(std::span<const double> residuals) {
  const std::size_t n = residuals.size();
  return n > 4 && residuals[n - 1] > 0.5 * residuals[n - 3] &&
         residuals[n - 2] > 0.5 * residuals[n - 4];
}

}  // namespace gabion
