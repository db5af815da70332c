// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <mpi.h>

#include <cstdint>
#include <span>
#include <vector>

#include "mpm_solver/points/material_points.hpp"

namespace gabion::mpm {

/// The rows of a file of all points, ordered by id, in as many shares as there are ranks: each
/// takes the ids of an equal number of chunks of the file. So the order does not depend on which
/// rank has which points, and no rank has all of them.
class PointRows {
 public:
  /// @param points  of this rank, ordered by id. @note Collective.
  template <int dim>
  PointRows(MPI_Comm comm, const MaterialPoints<dim>& points);

  /// From values of the points of this rank to those of its rows.
  /// @param own    num_points x width
  /// @returns      num_rows x width
  /// @note Collective.
  std::vector<double> gather_rows(std::vector<double> own, int width) const;

 private:
  template <class Value>
  std::vector<Value> exchange(std::span<const Value> own, std::size_t width) const;

  MPI_Comm comm_;
  std::vector<std::int32_t> starts_;  // first point of this rank whose row each rank has
  std::vector<std::size_t> order_;    // of what arrives, in the order of ranks: ascending ids
};

}  // namespace gabion::mpm
