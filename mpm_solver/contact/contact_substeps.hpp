// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <span>

namespace gabion::mpm {

/// Part of a contact in the substeps of an explicit step: begin_substeps, then for each one
/// set_share, add_forces with the motion since the start of the step, add_substep; at last
/// add_forces with the motion of the whole step. Forces on the structure and their resultant are
/// then means over the substeps. This class itself serves a contact whose forces need no substeps.
template <int dim>
class ContactSubsteps {
 public:
  virtual ~ContactSubsteps() = default;

  /// Add the force that has lasted up to the accepted state, to which substeps look ahead: at rest
  /// that of the contact [N].
  virtual void add_lasting_forces(std::span<double>) const {}
  virtual void begin_substeps() {}
  /// Move the surfaces to their places at this share of the step, on the line to that of
  /// set_displacement.
  virtual void set_share(double) {}
  /// The forces of the last add_forces acted over this share of the step.
  /// @param move  of the soil in that time [m], num_nodes x dim
  virtual void add_substep(std::span<const double> move, double share) {
    static_cast<void>(move), static_cast<void>(share);
  }
  /// Add the row sums of the stiffness of the last add_forces, sum_j |K_ij|, each contact point by
  /// itself: num_nodes [N/m].
  virtual void add_stiffness_sums(std::span<double>) const {}
};

}  // namespace gabion::mpm
