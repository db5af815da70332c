// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <string>
#include <vector>

namespace gabion {

/// Values first .. first + count - 1 of a dataset of one extent.
struct ValueRange {
  std::int64_t first = 0;
  std::int64_t count = 0;
};

/// Reads what Hdf5File wrote.
class Hdf5Reader {
 public:
  /// @throws Error  no such file, or not one of HDF5; names the file
  explicit Hdf5Reader(std::string path);
  ~Hdf5Reader();
  Hdf5Reader(const Hdf5Reader&) = delete;
  Hdf5Reader& operator=(const Hdf5Reader&) = delete;
  Hdf5Reader(Hdf5Reader&&) = delete;
  Hdf5Reader& operator=(Hdf5Reader&&) = delete;

  /// Names in a group; none when the group is missing.
  std::vector<std::string> names(const std::string& group) const;
  /// All values of a dataset, row-major.
  /// @throws Error  no such dataset, damaged, or of a type of number that does not fit, with both
  std::vector<double> reals(const std::string& dataset) const;
  std::vector<std::int64_t> integers(const std::string& dataset) const;
  /// Like reals(), and integers too, rounded to a double above 2^53.
  std::vector<double> numbers(const std::string& dataset) const;
  /// The values of `range`. @throws Error  it has fewer
  std::vector<double> reals(const std::string& dataset, const ValueRange& range) const;
  std::vector<std::int64_t> integers(const std::string& dataset, const ValueRange& range) const;
  /// Number of values. @throws Error  no such dataset
  std::int64_t size(const std::string& dataset) const;
  /// Numbers of values along its axes; none of a single value. @throws Error  no such dataset
  std::vector<std::int64_t> shape(const std::string& dataset) const;
  /// @throws Error  no such dataset, or not one text of fixed length with an end
  std::string text(const std::string& dataset) const;

 private:
  template <class Value>
  std::vector<Value> read(const std::string& dataset, const ValueRange* range) const;
  void require_stored(const std::string& dataset, std::int64_t id, std::uint64_t bytes) const;
  [[noreturn]] void fail(const std::string& what) const;

  std::string path_;
  std::int64_t file_ = -1;  // HDF5's identifier
};

}  // namespace gabion
