// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <mpi.h>

#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "common/mechanics/output/xdmf_series.hpp"
#include "mpm_solver/points/material_points.hpp"

namespace gabion::mpm {

/// Frames of the material points, ordered by id: displacement, velocity, Cauchy stress, mean
/// pressure, plastic strain, volume ratio, volume, body, and what laws remember besides. Each rank
/// writes its share of the rows.
template <int dim>
class MpmOutput {
 public:
  using MoreFields = std::function<std::vector<OutputField>(const MaterialPoints<dim>&)>;
  /// @param folder  empty: nothing is written
  /// @param bodies  have to live as long
  /// @param more    fields of the points that are written too
  MpmOutput(MPI_Comm comm, const std::string& folder, const std::vector<Body<dim>>& bodies,
            MoreFields more);
  /// @note Collective.
  void write(double time, const MaterialPoints<dim>& points);
  /// Size of a frame before compression.
  std::int64_t frame_bytes(std::int64_t num_points) const;

 private:
  std::vector<OutputField> fields(const MaterialPoints<dim>& points) const;

  MPI_Comm comm_;
  const std::vector<Body<dim>>& bodies_;
  MoreFields more_;
  std::optional<XdmfSeries> series_;
};

}  // namespace gabion::mpm
