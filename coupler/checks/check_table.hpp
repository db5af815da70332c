// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <functional>
#include <string>
#include <utility>
#include <vector>

#include "coupler/checks/answer_difference.hpp"
#include "coupler/checks/participant_check.hpp"

namespace gabion {

/// The rows of a check: each trial is run, and its outcome is added. A step without solution in a
/// trial is a failed row; other errors leave the table.
class CheckTable {
 public:
  /// @param report  gets each row as soon as it is known; may be empty
  explicit CheckTable(std::function<void(const CheckRow&)> report) : report_(std::move(report)) {}

  void add(const CheckRow& row);
  /// @param trial  returns the outcome, and why
  void judge(const std::string& what,
             const std::function<std::pair<CheckRow::Outcome, std::string>()>& trial);
  /// Two answers that should be equal.
  /// @param trial      returns how they differ
  /// @param tolerance  up to which they may, by AnswerDifference::relative
  void expect_equal(const std::string& what, const std::function<AnswerDifference()>& trial,
                    double tolerance = 0);
  /// Two answers that are equal in few codes only.
  /// @param trial    returns how they differ
  /// @param meaning  what it means when they do not
  void expect_change(const std::string& what, const std::function<AnswerDifference()>& trial,
                     const std::string& meaning);
  /// Check that an action ends without an error.
  void expect_done(const std::string& what, const std::function<void()>& action);

  const std::vector<CheckRow>& rows() const { return rows_; }
  const std::string& under_way() const { return under_way_; }  ///< trial of the row to come

 private:
  std::function<void(const CheckRow&)> report_;
  std::vector<CheckRow> rows_;
  std::string under_way_;
};

}  // namespace gabion
