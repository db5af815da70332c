// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <mpi.h>

#include <cstdint>
#include <memory>
#include <string>

#include "common/base/descriptor.hpp"
#include "common/hdf5/array_file.hpp"
#include "common/hdf5/pressed_chunks.hpp"

namespace gabion {

/// An ArrayFile that all ranks write, each its own rows, through MPI-IO; each compresses what it
/// has. The datasets are the same for any number of ranks.
///
/// Before the ranks write, the first one reserves the room on the disk: version 1.10 of the library
/// waits for ever where the write of one rank fails.
/// @note Every function is collective, the destructor too; errors are thrown on all ranks.
class RankedHdf5File final : public ArrayFile {
 public:
  /// @throws Error  names the file; a rank does not see the folder of the others
  RankedHdf5File(std::string path, MPI_Comm comm);
  ~RankedHdf5File() override;
  RankedHdf5File(const RankedHdf5File&) = delete;
  RankedHdf5File& operator=(const RankedHdf5File&) = delete;
  RankedHdf5File(RankedHdf5File&&) = delete;
  RankedHdf5File& operator=(RankedHdf5File&&) = delete;

  void write_text(const std::string& dataset, const std::string& text) override;
  void finish() override;

 private:
  void open();
  void reserve(std::int64_t bytes);
  void write_numbers(const std::string& dataset, int columns, const Numbers& numbers) override;
  void require_on_all(bool good, const std::string& what, const std::string& cause) const;
  void abandon();

  std::string path_;
  std::string part_path_;
  MPI_Comm comm_;
  Descriptor room_file_;    // the system's, on the first rank: reserves the room
  std::int64_t room_ = 0;   // [bytes] reserved
  std::int64_t file_ = -1;  // HDF5's identifier; negative when closed
};

/// The file of one process or of several.
/// @param comm  MPI_COMM_NULL: this process is alone
/// @param kept  what a process that is alone may take over from the file before
/// @note Collective.
std::unique_ptr<ArrayFile> new_array_file(const std::string& path, MPI_Comm comm,
                                          KeptChunks* kept = nullptr);

}  // namespace gabion
