// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "common/mechanics/petsc/block_matrix.hpp"
#include "common/mechanics/tensor.hpp"

namespace gabion::mpm {

/// Part of a contact in the balance of momentum: the forces on the soil and their stiffness.
template <int dim>
class ContactAssembly {
 public:
  virtual ~ContactAssembly() = default;

  /// Whether the stiffness of this step is symmetric.
  virtual bool symmetric() const = 0;
  /// Cells that carry contact terms, as lists of active nodes (for the matrix pattern).
  virtual void append_cells(std::vector<std::int32_t>& offsets,
                            std::vector<std::int32_t>& nodes) const = 0;
  /// Add the contact force, as the balance at the end of the step sees it, to r and its stiffness
  /// -df/du to K (may be null).
  virtual void add_forces(std::span<const double> du, std::span<double> r, BlockMatrix<dim>* K) = 0;
  /// Set to 1 the active nodes of the points that were in contact with a member in the last
  /// add_forces.
  virtual void mark_touched(std::span<char> nodes, std::size_t member = 0) const {
    static_cast<void>(nodes), static_cast<void>(member);
  }
  /// Work on the soil in this step by the trapezoidal rule, from the forces of the accepted state
  /// and those of the last add_forces [J].
  virtual double work_on_soil(std::span<const double> du) const = 0;

  /// Whether the force is constant in a step, see NewmarkBossak::step_force_weight. The resultant
  /// is then that force, not what add_forces added.
  virtual bool is_step_force() const { return false; }
  /// A step force: add F - F_o, its change since the step before, to a nodal field [N].
  virtual void add_step_force_change(std::span<double>) const {}
  /// The step force on these material points of this rank, in the accepted state [N].
  virtual Vector<dim> step_force_on(std::span<const std::int64_t> ids) const {
    static_cast<void>(ids);
    return Vector<dim>::Zero();
  }
};

}  // namespace gabion::mpm
