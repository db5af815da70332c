// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <functional>
#include <span>
#include <string>
#include <vector>

#include "common/mechanics/elements/cell_type.hpp"

namespace gabion {

/// Values on the points or cells of one frame.
struct OutputField {
  std::string name;
  /// 1: scalar; 2, 3: vector (2 is padded to 3 for readers); 4, 6: symmetric tensor
  int components = 1;
  std::span<const double> values = {};
  bool on_cells = false;
  /// Instead of `values`: makes them when they are written, and they are given up then.
  std::function<std::vector<double>()> make = {};
};

/// What is written of one instant.
struct OutputFrame {
  double time = 0;                      ///< [s]
  int dim = 2;                          ///< of the space of the points, 2 or 3
  std::span<const double> coordinates;  ///< num_points x dim [m]
  CellType cell_type = CellType::point1;
  /// num_cells x num_nodes(cell_type); empty for CellType::point1: each point a cell
  std::span<const std::int32_t> connectivity = {};
  std::vector<OutputField> fields = {};
};

/// A time series that ParaView opens: one HDF5 file a frame (written under another name, then
/// renamed, so that a killed run never leaves a broken frame) and one .xdmf file that lists them.
class XdmfSeries {
 public:
  /// The first frame creates `folder` when missing. Files are folder/name_000000.h5 ... and
  /// folder/name.xdmf.
  XdmfSeries(std::string folder, std::string name);

  /// @throws Error  disk full, folder gone, values that do not fit the points or cells
  void write(OutputFrame frame);

  /// Size of a frame with these fields before compression, without what HDF5 itself takes (some
  /// kB). The values of the fields are not looked at.
  static std::int64_t frame_bytes(std::int64_t num_points, CellType type, std::int64_t num_cells,
                                  const std::vector<OutputField>& fields);

  int num_frames() const { return static_cast<int>(times_.size()); }

 private:
  void check(const OutputFrame& frame) const;
  void make_folder() const;
  std::string grid_text(const OutputFrame& frame, const std::string& file_name) const;
  void write_index() const;
  std::string folder_;
  std::string name_;
  std::vector<double> times_;
  std::vector<std::string> grids_;  // XML of each frame
};

}  // namespace gabion
