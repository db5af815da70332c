// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <span>
#include <string>

namespace gabion::test {

/// Criterion by which a row of the verification table is judged.
enum class Measure {
  relative_error,  ///< |computed - exact| / |exact|, at most the bound
  absolute_error,  ///< |computed - exact|, at most the bound
  order,           ///< computed is an observed order, exact the theoretical one; at least the bound
};

/// One result of a verification problem.
struct VerificationRow {
  std::string id;    ///< of the problem, such as "V7"
  std::string what;  ///< quantity, solver, dimension, cells
  double exact = 0;
  double computed = 0;
  Measure measure = Measure::relative_error;
  double bound = 0;
  std::string unit = {};  ///< of exact and computed
  /// Limit of the method, where the bound is wider than a reader would expect of it; the row is
  /// then marked "limit".
  std::string limitation = {};
};

/// Assert the bound of a row (a failure is a GoogleTest failure of the running case), and append
/// the row to the table that the environment variable GABION_VERIFICATION_TABLE names, if it is
/// set. Seconds of a row: since the row before it, or since the test case began.
/// @throws Error  the table cannot be written; relative error with exact = 0
/// @note On several ranks rank 0 alone writes; every rank asserts.
void verify(const VerificationRow& row);

/// Points of one curve of a figure of the verification table.
struct VerificationCurve {
  std::string id;      ///< of the problem
  std::string figure;  ///< curves with the same id and figure share their axes
  std::string x_label;
  std::string y_label;
  std::string label;
  bool logarithmic = true;  ///< both axes
};

/// Append the points of a curve to the table that the environment variable
/// GABION_VERIFICATION_CURVES names, if it is set.
/// @param x, y  one entry a point
/// @throws Error  the table cannot be written; sizes differ
void draw_curve(const VerificationCurve& curve, std::span<const double> x,
                std::span<const double> y);

}  // namespace gabion::test
