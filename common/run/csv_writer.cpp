// SPDX-License-Identifier: BSD-3-Clause
#include "common/run/csv_writer.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <cmath>

#include "common/base/require.hpp"

namespace gabion {

namespace {
std::string cell_text(const CsvValue& value) {
  const auto* number = std::get_if<double>(&value);
  if (number != nullptr && std::isnan(*number)) return "";
  return std::visit([](const auto& v) { return fmt::format("{}", v); }, value);
}
}  // namespace

CsvWriter::CsvWriter(const std::string& path, const std::vector<std::string>& columns)
    : path_(path), num_columns_(columns.size()), out_(path) {
  require(out_.good(), "{}: cannot be created", path);
  write_line(fmt::format("{}\n", fmt::join(columns, ",")));
}

void CsvWriter::row(const std::vector<CsvValue>& values) {
  require(values.size() == num_columns_, "{}: row of {} cells, table has {} columns", path_,
          values.size(), num_columns_);
  std::vector<std::string> cells;
  for (const auto& value : values) cells.push_back(cell_text(value));
  write_line(fmt::format("{}\n", fmt::join(cells, ",")));
}

void CsvWriter::write_line(const std::string& line) {
  out_ << line;
  out_.flush();
  require(out_.good(), "{}: row could not be written (disk full?)", path_);
}

}  // namespace gabion
