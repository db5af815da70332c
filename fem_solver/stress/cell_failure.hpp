// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "common/mechanics/mesh/mesh.hpp"
#include "fem_solver/ranks/mesh_ranks.hpp"
#include "fem_solver/stress/cell_integrals.hpp"

namespace gabion::fem {

/// A cell or line whose failure begins.
struct Failure {
  std::int32_t element = 0;  ///< of the mesh, lines behind its cells
  FailureReason reason = FailureReason::none;
  double value = 0, limit = 0;
};

/// Changes by an accepted step in the failure of cells and lines of this rank.
struct FailureChange {
  std::vector<double> history;  ///< from which the next step goes on; empty: nothing changes
  std::vector<Failure> begun;   ///< in this step
};

/// Data of an accepted step for the failure of cells.
struct AcceptedStep {
  std::span<const double> u;        ///< at its end [m]
  std::span<const double> history;  ///< at its end
  double time = 0;                  ///< of its end [s]
  double dt = 0;                    ///< [s]
  bool dynamic = true;
};

/// Whether cells or lines of some material may fail; the same on all ranks.
template <int dim>
bool may_fail(const CellIntegrals<dim>& cells);

/// Let cells and lines beyond a limit begin to fail; those that failed lose the share dt / fade
/// time of their stress, and at last all of it.
template <int dim>
FailureChange failure_after(const CellIntegrals<dim>& cells, const AcceptedStep& step);

/// Share of its stress that each cell, or each line, has lost.
template <int dim>
std::vector<double> lost_shares_of_cells(const CellIntegrals<dim>& cells,
                                         std::span<const double> history);
template <int dim>
std::vector<double> lost_shares_of_lines(const CellIntegrals<dim>& cells,
                                         std::span<const double> history, std::int32_t num_lines);

/// The history of a block of lines as it was solved: lines that began to fail at this time still
/// have all of their force.
/// @param history  of the block, accepted
/// @param time     of the accepted state [s]
template <int dim>
std::vector<double> history_before_failure(const LineBlock<dim>& block,
                                           std::span<const double> history, double time);

/// Number of cells and lines of this rank that failed.
template <int dim>
std::int64_t count_failed(const CellIntegrals<dim>& cells, std::span<const double> history);

/// A small stiffness at the nodes of cells and lines that are gone: for Newton's method in statics,
/// where nothing else may hold them.
template <int dim>
void hold_nodes_of_gone(const CellIntegrals<dim>& cells, const Mesh<dim>& mesh,
                        std::span<const double> history, BlockMatrix<dim>& K);

/// Sentence about a failure, with the number of the cell or line in the whole mesh.
template <int dim>
std::string describe(const Failure& failure, const Mesh<dim>& mesh, const MeshRanks& ranks);

}  // namespace gabion::fem
