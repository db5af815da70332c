// SPDX-License-Identifier: BSD-3-Clause
#include "tests/support/verification_row.hpp"

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdlib>
#include <fstream>

#include "common/base/require.hpp"
#include "tests/support/mpi_main.hpp"

namespace gabion::test {

namespace {

using Clock = std::chrono::system_clock;

double judged_value(const VerificationRow& row) {
  switch (row.measure) {
    case Measure::relative_error:
      require(row.exact != 0, row.id + ": a relative error needs an exact value other than 0");
      return std::abs(row.computed / row.exact - 1);
    case Measure::absolute_error:
      return std::abs(row.computed - row.exact);
    case Measure::order:
      return row.computed;
  }
  throw Error("unknown measure");
}

const char* name_of(Measure measure) {
  switch (measure) {
    case Measure::relative_error:
      return "relative_error";
    case Measure::absolute_error:
      return "absolute_error";
    case Measure::order:
      return "order";
  }
  throw Error("unknown measure");
}

std::string quoted(const std::string& text) {
  std::string result = "\"";
  for (const char c : text) result += c == '"' ? std::string("\"\"") : std::string(1, c);
  return result + '"';
}

std::string running_test() {
  const auto* info = testing::UnitTest::GetInstance()->current_test_info();
  require(info != nullptr, "verification rows belong to a test case");
  return std::string(info->test_suite_name()) + "." + info->name();
}

double seconds_of_row() {
  static Clock::time_point last;
  const auto* info = testing::UnitTest::GetInstance()->current_test_info();
  const Clock::time_point start{std::chrono::milliseconds(info->result()->start_timestamp())};
  const Clock::time_point now = Clock::now();
  const std::chrono::duration<double> passed = now - std::max(start, last);
  last = now;
  return passed.count();
}

// Append lines to the file named by an environment variable, below a head when the file is new.
void append(const char* variable, const std::string& head, const std::string& lines) {
  const char* path = std::getenv(variable);
  if (!path || rank() != 0) return;
  std::ofstream out(path, std::ios::app);
  if (out.tellp() == 0) out << head << '\n';
  out << lines;
  out.flush();
  require(out.good(), "{}={}: cannot be written", variable, path);
}

}  // namespace

void verify(const VerificationRow& row) {
  const double value = judged_value(row);
  const bool holds = row.measure == Measure::order ? value >= row.bound : value <= row.bound;
  append(
      "GABION_VERIFICATION_TABLE",
      "test,id,what,exact,computed,unit,measure,value,bound,holds,limitation,seconds",
      fmt::format("{},{},{},{},{},{},{},{},{},{},{},{:.3f}\n", running_test(), row.id,
                  quoted(row.what), row.exact, row.computed, quoted(row.unit), name_of(row.measure),
                  value, row.bound, holds, quoted(row.limitation), seconds_of_row()));
  EXPECT_TRUE(holds) << row.id << ", " << row.what << ": exact " << row.exact << ", computed "
                     << row.computed << " " << row.unit << "; " << name_of(row.measure) << " "
                     << value << ", bound " << row.bound;
}

void draw_curve(const VerificationCurve& curve, std::span<const double> x,
                std::span<const double> y) {
  require(x.size() == y.size(), curve.id + ": a curve needs as many x as y");
  std::string lines;
  for (std::size_t k = 0; k < x.size(); ++k) {
    lines += fmt::format("{},{},{},{},{},{},{},{}\n", curve.id, quoted(curve.figure),
                         quoted(curve.x_label), quoted(curve.y_label), quoted(curve.label),
                         curve.logarithmic, x[k], y[k]);
  }
  append("GABION_VERIFICATION_CURVES", "id,figure,x_label,y_label,label,logarithmic,x,y", lines);
}

}  // namespace gabion::test
