// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <mpi.h>

#include "common/mechanics/ranks/partition.hpp"
#include "mpm_solver/grid/basis.hpp"

namespace gabion::mpm {

/// The rank that has the material points of a cell, known to every rank. Refers to grid and
/// partition.
template <int dim>
struct CellOwners {
  MPI_Comm comm;
  const BackgroundGrid<dim>& grid;
  const Partition<dim>& partition;

  int of(std::int32_t cell) const { return partition.rank_of(grid.home(cell)); }
};

}  // namespace gabion::mpm
