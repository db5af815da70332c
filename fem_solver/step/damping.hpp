// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <span>

#include "common/mechanics/petsc/block_matrix.hpp"
#include "fem_solver/fem_config.hpp"
#include "fem_solver/stress/cell_integrals.hpp"

namespace gabion::fem {

/// Constant damping matrix of a mesh, or of a rank's part of one. Over the materials of cells it is
/// a M + b K_0, with M their mass without that at nodes and K_0 their elastic stiffness before
/// loading. Dashpots from nodes to the ground are added (docs/theory/structure.md, (T4a)). The
/// matrix is symmetric and positive semidefinite.
template <int dim>
class Damping {
 public:
  /// @param cells  of the same settings
  /// @throws ConfigError  a dashpot without nodes
  /// @note Collective.
  Damping(const FemSettings<dim>& settings, const CellIntegrals<dim>& cells);

  /// f += C v, of this rank. [N]
  void add_times(std::span<const double> v, std::span<double> f) const;
  /// K += scale C. @param K  with the pattern of the cells
  void add(double scale, BlockMatrix<dim>& K) const;

 private:
  void add_mass(const FemSettings<dim>& settings);
  void add_stiffness(const CellIntegrals<dim>& cells);

  BlockMatrix<dim> C_;
};

/// Whether some material or dashpot damps.
template <int dim>
bool is_damped(const FemSettings<dim>& settings);

}  // namespace gabion::fem
