// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <fstream>
#include <string>

#include "common/hdf5/array_file.hpp"
#include "common/hdf5/pressed_chunks.hpp"

namespace gabion {

/// An ArrayFile that this process writes alone. (The data of a finished one may still be in the
/// system's cache: a power cut is not covered.)
///
/// HDF5 builds the file in memory and we write its bytes: version 1.10 of the library ends a
/// program with a crash after a write to a full disk has failed.
class Hdf5File final : public ArrayFile {
 public:
  /// @param kept     what may be taken over from the file before; has to live as long as the file
  /// @throws Error   names the file and what HDF5 and the system say
  explicit Hdf5File(std::string path, KeptChunks* kept = nullptr);
  ~Hdf5File() override;
  Hdf5File(const Hdf5File&) = delete;
  Hdf5File& operator=(const Hdf5File&) = delete;
  Hdf5File(Hdf5File&&) = delete;
  Hdf5File& operator=(Hdf5File&&) = delete;

  void write_text(const std::string& dataset, const std::string& text) override;
  void finish() override;

 private:
  [[noreturn]] void fail(const std::string& what, const std::string& cause) const;
  void write_numbers(const std::string& dataset, int columns, const Numbers& numbers) override;
  /// @param data  identifier of a dataset with chunks of so many rows
  bool write_chunks(const std::string& dataset, std::int64_t data, const ArrayBytes& array,
                    std::size_t rows_a_chunk);
  void abandon();

  std::string path_;
  std::string part_path_;
  std::ofstream out_;
  std::int64_t file_ = -1;  // HDF5's identifier; negative when closed
  KeptChunks* kept_;        // null: none
};

}  // namespace gabion
