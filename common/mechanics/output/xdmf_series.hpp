// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <mpi.h>

#include <cstdint>
#include <functional>
#include <span>
#include <string>
#include <vector>

#include "common/hdf5/pressed_chunks.hpp"
#include "common/mechanics/elements/cell_type.hpp"

namespace gabion {

/// Values on the points or cells of one frame. On several ranks: on those of this rank.
struct OutputField {
  std::string name;
  /// 1: scalar; 2, 3: vector (2 is padded to 3 for readers); 4, 6: symmetric tensor
  int components = 1;
  std::span<const double> values = {};
  bool on_cells = false;
  /// Instead of `values`: makes them when they are written, and they are released then. On several
  /// ranks it may be collective.
  std::function<std::vector<double>()> make = {};
};

/// Data of one frame. On several ranks: points and cells of this rank, which stand behind those of
/// the ranks before; node numbers count the points of all.
struct OutputFrame {
  double time = 0;                      ///< [s]
  int dim = 2;                          ///< dimension of the space of the points, 2 or 3
  std::span<const double> coordinates;  ///< num_points x dim [m]
  CellType cell_type = CellType::point1;
  /// num_cells x num_nodes(cell_type), in Gmsh's order; the file has VTK's, which differs for
  /// tet10, hex20 and hex27. Empty for CellType::point1: each point a cell
  std::span<const std::int32_t> connectivity = {};
  std::vector<OutputField> fields = {};
};

/// A time series that ParaView opens: one HDF5 file a frame (written under another name, then
/// renamed, so that a killed run never leaves a broken frame) and one .xdmf file that lists them.
/// On several ranks each writes its own rows (ArrayFile).
class XdmfSeries {
 public:
  /// The first frame creates `folder` when missing. Files are folder/name_000000.h5 ... and
  /// folder/name.xdmf.
  /// @param comm  the ranks that write together; MPI_COMM_NULL: this process is alone
  XdmfSeries(std::string folder, std::string name, MPI_Comm comm = MPI_COMM_NULL);

  /// @throws Error  disk full, folder gone, values that do not fit the points or cells
  /// @note Collective.
  void write(OutputFrame frame);

  /// Size of a frame with these fields before compression, without what HDF5 itself takes (some
  /// kB). The values of the fields are not looked at.
  static std::int64_t frame_bytes(std::int64_t num_points, CellType type, std::int64_t num_cells,
                                  const std::vector<OutputField>& fields);

  int num_frames() const { return static_cast<int>(times_.size()); }

 private:
  struct Rows;  // rows of a frame, over the ranks
  void check(const OutputFrame& frame) const;
  void make_folder() const;
  std::string grid_text(const OutputFrame& frame, const Rows& rows,
                        const std::string& file_name) const;
  void write_index() const;
  std::string folder_;
  std::string name_;
  MPI_Comm comm_;
  std::vector<double> times_;
  std::vector<std::string> grids_;  // XML of each frame
  KeptChunks kept_;                 // the mesh, where it stays the same
};

}  // namespace gabion
