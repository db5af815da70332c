// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <mpi.h>

#include <cstdint>

#include "common/run/state.hpp"
#include "mpm_solver/ranks/migration.hpp"

namespace gabion::mpm {

/// Distribution of the material points over ranks: each has those of its part of space, a cell (or
/// patch of cells) with all that lies in it. Refers to the grid. On one rank it does nothing.
/// Functions are collective.
template <int dim>
class PointRanks {
 public:
  PointRanks(MPI_Comm comm, const BackgroundGrid<dim>& grid) : comm_(comm), grid_(grid) {}

  /// Divide space anew by the places of the points, and send these to their ranks. Points may be on
  /// any rank before.
  /// @pre  the points are located
  void divide(MaterialPoints<dim>& points, Surfaces<dim>& surfaces);
  /// After points have moved, send them to their ranks; divide space anew when a rank has too many.
  void follow(MaterialPoints<dim>& points, Surfaces<dim>& surfaces);

  const Partition<dim>& partition() const { return partition_; }
  CellOwners<dim> owners() const { return {comm_, grid_, partition_}; }
  std::int64_t num_divisions() const { return num_divisions_; }  ///< after that of the start
  std::int64_t num_moved() const { return num_moved_; }          ///< points, after the start
  /// Points of the rank that has the most, over their mean; 1 without any.
  double largest_share(const MaterialPoints<dim>& points) const;

  void visit_state(StateVisitor& visitor);

 private:
  MPI_Comm comm_;
  const BackgroundGrid<dim>& grid_;
  Partition<dim> partition_;
  double allowed_share_ = 1;
  std::int64_t num_divisions_ = 0, num_moved_ = 0;
};

}  // namespace gabion::mpm
