// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <mpi.h>

#include <cstdint>
#include <optional>
#include <span>
#include <string>

#include "common/hdf5/hdf5_file.hpp"

namespace gabion {

/// A new HDF5 file that all ranks write, each its own rows, through MPI-IO; one rank writes a
/// Hdf5File. The datasets are the same for any number of ranks; as there the file gets its name
/// when it is whole, and compression stays (each rank compresses what it has).
///
/// Before the ranks write, the first one reserves the room on the disk: version 1.10 of the library
/// waits for ever where the write of one rank fails.
/// @note Every function is collective, the destructor too; errors are thrown on all ranks.
class RankedHdf5File {
 public:
  /// @param comm  MPI_COMM_NULL: this process is alone
  /// @throws Error  names the file; a rank that does not see the folder of the others
  RankedHdf5File(std::string path, MPI_Comm comm);
  ~RankedHdf5File();  ///< gives up an unfinished file and removes it
  RankedHdf5File(const RankedHdf5File&) = delete;
  RankedHdf5File& operator=(const RankedHdf5File&) = delete;
  RankedHdf5File(RankedHdf5File&&) = delete;
  RankedHdf5File& operator=(RankedHdf5File&&) = delete;

  /// Write an array of `columns` columns, see Hdf5File::write.
  /// @param values  rows of this rank; they stand in the file behind those of the ranks before
  void write(const std::string& dataset, int columns, std::span<const float> values);
  void write(const std::string& dataset, int columns, std::span<const double> values);
  void write(const std::string& dataset, int columns, std::span<const std::int32_t> values);
  void write(const std::string& dataset, int columns, std::span<const std::int64_t> values);
  /// @param text  the same on all ranks
  void write_text(const std::string& dataset, const std::string& text);

  /// Close the file and give it its name.
  void finish();

 private:
  struct Rows {
    std::int64_t type;  // HDF5's identifier
    std::size_t value_size;
    std::size_t count;  // of values
    const void* values;
  };
  void open();
  void reserve(std::int64_t bytes);
  void write_rows(const std::string& dataset, int columns, const Rows& rows);
  void require_on_all(bool good, const std::string& what, const std::string& cause) const;
  void abandon();

  std::string path_;
  std::string part_path_;
  MPI_Comm comm_;
  std::optional<Hdf5File> alone_;  // instead of all below
  int room_file_ = -1;             // the system's, on the first rank: reserves the room
  std::int64_t room_ = 0;          // [bytes] reserved
  std::int64_t file_ = -1;         // HDF5's identifier; negative when closed
};

}  // namespace gabion
