// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <fstream>
#include <string>
#include <variant>
#include <vector>

namespace gabion {

/// One cell of a table. Numbers are written with the fewest digits that read back to the same bits,
/// those that are none (NaN) as empty cells.
using CsvValue = std::variant<double, std::int64_t, std::string>;

/// A CSV file whose rows are on disk as soon as they are written.
class CsvWriter {
 public:
  /// @throws Error  the file cannot be created
  CsvWriter(const std::string& path, const std::vector<std::string>& columns);

  /// @throws Error  wrong number of cells, or the row did not reach the disk (disk full)
  void row(const std::vector<CsvValue>& values);

 private:
  void write_line(const std::string& line);

  std::string path_;
  std::size_t num_columns_;
  std::ofstream out_;
};

}  // namespace gabion
