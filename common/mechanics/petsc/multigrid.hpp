// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <petscksp.h>

#include <vector>

#include "common/mechanics/petsc/petsc_handle.hpp"

namespace gabion {

/// Algebraic multigrid by smoothed aggregation (PETSc's GAMG) for matrices of nodes with several
/// unknowns: a copy of the matrix by rows, as GAMG wants it, with its near-null space.
///
/// The unknowns of a node stay together. Rigid body motions, or constants without coordinates, are
/// interpolated exactly; edges of the graph below 1 % of their diagonals are dropped; levels are
/// smoothed by two steps of Chebyshev's method with Jacobi, the coarsest is factorised.
/// @see Vanek, Mandel, Brezina (1996)
class Multigrid {
 public:
  /// Positions of the nodes, node by node [m]; empty: unknown. They concern the next new pattern.
  /// @param dim  of space; the unknowns of a node are its displacements
  void set_coordinates(std::vector<double> coordinates, int dim);

  static void configure(PC pc);

  /// Take a copy of `matrix`, of the same pattern as before or a new one.
  /// @returns the matrix to set GAMG up with
  Mat copy(Mat matrix, bool new_pattern);

 private:
  void set_near_null_space();

  std::vector<double> coordinates_;
  int dim_ = 0;
  MatHandle rows_;
};

}  // namespace gabion
