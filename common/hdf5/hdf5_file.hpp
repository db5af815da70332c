// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <fstream>
#include <span>
#include <string>

namespace gabion {

/// A new HDF5 file of arrays, serial. It is written under the name `path` + ".part" and gets its
/// own name in `finish()`: whoever finds a file finds a whole one, even after a killed run. (The
/// data may still be in the system's cache: a power cut is not covered.)
///
/// HDF5 builds the file in memory and we write its bytes: version 1.10 of the library ends a
/// program with a crash after a write to a full disk has failed.
class Hdf5File {
 public:
  /// Rows of one chunk of a dataset, which is compressed as a whole: the fastest of those measured
  /// that does not cost much in size.
  static constexpr int chunk_rows = 4096;

  /// @throws Error  names the file and what HDF5 and the system say
  explicit Hdf5File(std::string path);
  ~Hdf5File();  ///< gives up an unfinished file and removes it
  Hdf5File(const Hdf5File&) = delete;
  Hdf5File& operator=(const Hdf5File&) = delete;
  Hdf5File(Hdf5File&&) = delete;
  Hdf5File& operator=(Hdf5File&&) = delete;

  /// Write a row-major array of `columns` columns, with byte shuffle and deflate level 1.
  /// @param dataset  such as "coordinates" or "point/velocity"; groups are made when missing
  /// @throws Error   disk full, name already there
  void write(const std::string& dataset, int columns, std::span<const float> values);
  void write(const std::string& dataset, int columns, std::span<const double> values);
  void write(const std::string& dataset, int columns, std::span<const std::int32_t> values);
  void write(const std::string& dataset, int columns, std::span<const std::int64_t> values);
  void write_text(const std::string& dataset, const std::string& text);

  /// Close the file and give it its name.
  void finish();

 private:
  [[noreturn]] void fail(const std::string& what, const std::string& cause) const;
  void write_values(const std::string& dataset, int columns, std::size_t count, std::int64_t type,
                    const void* values);
  void abandon();

  std::string path_;
  std::string part_path_;
  std::ofstream out_;
  std::int64_t file_ = -1;  // HDF5's identifier; negative when closed
};

}  // namespace gabion
