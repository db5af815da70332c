// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <mpi.h>

#include <array>

#include "mpm_solver/step/soil_state.hpp"
#include "mpm_solver/step/soil_step.hpp"

namespace gabion::mpm {

/// Memory of the data that grow with the soil, at its largest in a step: material points, their
/// weights on the nodes and their trial state; nodes; values and pattern of the stiffness (one
/// rank: with PETSc's list of columns); the preconditioner.
template <int dim>
class Memory {
 public:
  /// Look at the fields of this rank as a step has left them.
  void look(const SoilState<dim>& state, const SoilStep<dim>& step);
  /// Sums over the ranks [bytes]. @note Collective.
  Json json(MPI_Comm comm) const;

 private:
  static constexpr std::array names_ = {"points",    "weights", "trial",         "nodes",
                                        "stiffness", "pattern", "preconditioner"};
  std::array<double, names_.size()> largest_ = {};
};

}  // namespace gabion::mpm
