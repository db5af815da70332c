// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <span>
#include <string>

namespace gabion {

/// A new HDF5 file of arrays. It is written under the name `path` + ".part" and gets its own name
/// in `finish()`: whoever finds a file finds a whole one, even after a killed run. One that is not
/// finished is given up and removed.
class ArrayFile {
 public:
  /// Rows of one chunk of a dataset, which is compressed as a whole: the fastest of those measured
  /// that does not cost much in size.
  static constexpr int chunk_rows = 4096;
  /// Numbers of fewer bytes are not compressed: the list of chunks would take what that saves.
  static constexpr int smallest_compressed = 4096;

  ArrayFile() = default;
  virtual ~ArrayFile() = default;
  ArrayFile(const ArrayFile&) = delete;
  ArrayFile& operator=(const ArrayFile&) = delete;
  ArrayFile(ArrayFile&&) = delete;
  ArrayFile& operator=(ArrayFile&&) = delete;

  /// Write a row-major array of `columns` columns, with byte shuffle and deflate.
  /// @param dataset  such as "coordinates" or "point/velocity"; groups are made when missing
  /// @param values   of a file that several ranks write: rows of this rank, which stand behind
  ///                 those of the ranks before
  /// @throws Error   disk full, name already there
  void write(const std::string& dataset, int columns, std::span<const float> values);
  void write(const std::string& dataset, int columns, std::span<const double> values);
  void write(const std::string& dataset, int columns, std::span<const std::int32_t> values);
  void write(const std::string& dataset, int columns, std::span<const std::int64_t> values);
  /// @param text  the same on all ranks
  virtual void write_text(const std::string& dataset, const std::string& text) = 0;

  /// Close the file and give it its name.
  virtual void finish() = 0;

 protected:
  struct Numbers {
    std::int64_t type;  ///< HDF5's identifier
    std::size_t size;   ///< size of one value [bytes]
    std::size_t count;
    const void* data;
  };
  virtual void write_numbers(const std::string& dataset, int columns, const Numbers& numbers) = 0;
};

}  // namespace gabion
