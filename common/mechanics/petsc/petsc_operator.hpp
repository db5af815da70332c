// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <memory>

#include "common/mechanics/petsc/linear_method.hpp"
#include "common/mechanics/petsc/parts_preconditioner.hpp"
#include "common/mechanics/petsc/petsc_handle.hpp"

namespace gabion {

/// A matrix as PetscSolver needs it.
class PetscOperator {
 public:
  virtual ~PetscOperator() = default;
  /// Matrix by which vectors are multiplied.
  virtual Mat get() const = 0;
  /// This matrix with its entries, for direct methods and multigrid. @note Collective.
  virtual Mat rows() = 0;
  /// The preconditioner of the method for the present values, where get() has no entries; else
  /// null.
  /// @note Collective.
  virtual std::unique_ptr<PartsPreconditioner> preconditioner(const LinearMethod& method) const = 0;
};

}  // namespace gabion
