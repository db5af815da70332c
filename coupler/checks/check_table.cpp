// SPDX-License-Identifier: BSD-3-Clause
#include "coupler/checks/check_table.hpp"

#include <fmt/format.h>

#include <algorithm>

#include "common/base/error.hpp"
#include "common/base/printable.hpp"

namespace gabion {
namespace {

const char* name_of(CheckRow::Outcome outcome) {
  switch (outcome) {
    case CheckRow::Outcome::passed:
      return "passed";
    case CheckRow::Outcome::inexact:
      return "inexact";
    case CheckRow::Outcome::notice:
      return "NOTICE";
    case CheckRow::Outcome::failed:
      return "FAILED";
    case CheckRow::Outcome::not_asked:
      return "not asked";
  }
  return "";
}

}  // namespace

void CheckTable::add(const CheckRow& row) {
  rows_.push_back(row);
  if (report_) report_(row);
}

void CheckTable::judge(const std::string& what,
                       const std::function<std::pair<CheckRow::Outcome, std::string>()>& trial) {
  under_way_ = what;
  try {
    const auto [outcome, found] = trial();
    add({what, outcome, found});
  } catch (const ConvergenceError& problem) {
    add({what, CheckRow::Outcome::failed,
         fmt::format("the step has no solution: {}", problem.what())});
  }
}

void CheckTable::expect_equal(const std::string& what,
                              const std::function<AnswerDifference()>& trial, double tolerance) {
  judge(what, [&] {
    const AnswerDifference found = trial();
    const auto outcome = found.text.empty()            ? CheckRow::Outcome::passed
                         : found.relative <= tolerance ? CheckRow::Outcome::inexact
                                                       : CheckRow::Outcome::failed;
    return std::pair(outcome, found.text);
  });
}

void CheckTable::expect_change(const std::string& what,
                               const std::function<AnswerDifference()>& trial,
                               const std::string& meaning) {
  judge(what, [&] {
    const bool changes = !trial().text.empty();
    return changes ? std::pair(CheckRow::Outcome::passed, std::string())
                   : std::pair(CheckRow::Outcome::notice, meaning);
  });
}

void CheckTable::expect_done(const std::string& what, const std::function<void()>& action) {
  judge(what, [&] {
    action();
    return std::pair(CheckRow::Outcome::passed, std::string());
  });
}

bool all_passed(const std::vector<CheckRow>& rows) {
  return std::none_of(rows.begin(), rows.end(),
                      [](const CheckRow& row) { return row.outcome == CheckRow::Outcome::failed; });
}

std::string row_text(const CheckRow& row) {
  constexpr int width = 54;  // length of the longest name of a check: rows are printed one by one
  return fmt::format("{:<{}}  {:<9}{}{}\n", row.what, width, name_of(row.outcome),
                     row.found.empty() ? "" : "  ", printable(row.found));
}

std::string table_text(const std::vector<CheckRow>& rows) {
  std::string text;
  for (const CheckRow& row : rows) text += row_text(row);
  return text;
}

}  // namespace gabion
