// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "common/mechanics/petsc/block_matrix.hpp"
#include "common/mechanics/tensor.hpp"

namespace gabion::fem {

/// Masses at nodes and linear springs from nodes to the ground, of the nodes that a rank owns. A
/// spring is without force where its node has no displacement; it acts along the axes.
template <int dim>
class NodalParts {
 public:
  void add_mass_at(std::int32_t node, double mass);  ///< [kg]
  /// @param stiffness  along each axis [N/m]
  void add_spring_at(std::int32_t node, const Vector<dim>& stiffness);

  /// f_int += k u, K += k. @returns the energy of the springs [J]
  double add_internal(std::span<const double> u, std::span<double> f_int,
                      BlockMatrix<dim>* K) const;
  void add_mass_times(std::span<const double> a, std::span<double> f) const;
  void add_mass(double scale, BlockMatrix<dim>& K) const;

 private:
  struct Mass {
    std::int32_t node;
    double mass;
  };
  struct Spring {
    std::int32_t node;
    Vector<dim> stiffness;
  };
  std::vector<Mass> masses_;
  std::vector<Spring> springs_;
};

}  // namespace gabion::fem
