// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <mpi.h>

#include <cstdint>
#include <memory>
#include <string>

#include "common/mechanics/output/xdmf_series.hpp"
#include "mpm_solver/points/material_points.hpp"

namespace gabion::mpm {

/// Frames of the material points, gathered on the first rank field by field and ordered by id:
/// displacement, velocity, Cauchy stress, mean pressure, plastic strain, volume ratio, volume,
/// body.
template <int dim>
class MpmOutput {
 public:
  /// @param folder  empty: nothing is written
  MpmOutput(MPI_Comm comm, const std::string& folder);
  /// @note Collective.
  void write(double time, const MaterialPoints<dim>& points);
  /// Size of a frame before compression.
  static std::int64_t frame_bytes(std::int64_t num_points);

 private:
  MPI_Comm comm_;
  std::unique_ptr<XdmfSeries> series_;  // on the first rank only
  bool writes_;
};

}  // namespace gabion::mpm
