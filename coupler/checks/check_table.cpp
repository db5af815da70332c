// SPDX-License-Identifier: BSD-3-Clause
// What a check found, as text.
#include <fmt/format.h>

#include <algorithm>

#include "coupler/checks/participant_check.hpp"

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

bool all_passed(const std::vector<CheckRow>& rows) {
  return std::none_of(rows.begin(), rows.end(),
                      [](const CheckRow& row) { return row.outcome == CheckRow::Outcome::failed; });
}

std::string row_text(const CheckRow& row) {
  constexpr int width = 54;  // of the longest name of a check: rows are printed one by one
  return fmt::format("{:<{}}  {:<9}{}{}\n", row.what, width, name_of(row.outcome),
                     row.found.empty() ? "" : "  ", row.found);
}

std::string table_text(const std::vector<CheckRow>& rows) {
  std::string text;
  for (const CheckRow& row : rows) text += row_text(row);
  return text;
}

}  // namespace gabion
