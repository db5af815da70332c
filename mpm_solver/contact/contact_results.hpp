// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Geometry>
#include <vector>

#include "common/mechanics/tensor.hpp"

namespace gabion::mpm {

/// Counts of the contact points after the last add_forces.
struct ContactCounts {
  int closed = 0;          ///< places that carry force, or carried it in a substep
  int sliding = 0;         ///< of them, those at the friction limit
  double penetration = 0;  ///< largest [m]
};

/// Sum of forces on a structure, and the sum of their moments about the origin.
template <int dim>
struct ContactResultant {
  Vector<dim> force = Vector<dim>::Zero();                                 ///< [N]
  Vector<dim == 2 ? 1 : 3> moment = Vector < dim == 2 ? 1 : 3 > ::Zero();  ///< [N m]

  void add(const Vector<dim>& x, const Vector<dim>& f) {
    force += f;
    if constexpr (dim == 2) {
      moment[0] += x[0] * f[1] - x[1] * f[0];
    } else {
      moment += x.cross(f);
    }
  }
};

/// Action of a contact on its members, the surfaces, in the current step: all values are those of
/// the last ContactAssembly::add_forces.
template <int dim>
class ContactResults {
 public:
  virtual ~ContactResults() = default;

  /// Nodal forces of the soil on the structure, num_vertices of the member x dim [N].
  virtual std::vector<double> forces_on_structure(std::size_t member = 0) const = 0;
  /// Resultant of these forces, at the positions at the start of the step.
  virtual ContactResultant<dim> resultant(std::size_t member = 0) const = 0;
  virtual ContactCounts counts(std::size_t member = 0) const = 0;
};

}  // namespace gabion::mpm
