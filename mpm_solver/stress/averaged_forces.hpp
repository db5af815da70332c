// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <span>
#include <vector>

#include "common/mechanics/petsc/block_matrix.hpp"
#include "mpm_solver/stress/averaged_group.hpp"
#include "mpm_solver/stress/point_stresses.hpp"

namespace gabion::mpm {

/// Internal forces under F-bar, see AveragedGroup. The points of a group are on one rank.
template <int dim>
class AveragedForces {
 public:
  explicit AveragedForces(const StressParts<dim>& parts) : parts_(parts) {}

  struct Target {
    std::span<const double> du;  ///< of the active nodes, num_nodes x dim [m]
    BlockMatrix<dim>* K;         ///< null, or gets the derivative of the forces
    std::span<double> f;         ///< gets the forces, num_nodes x dim [N]
    std::int32_t& worst;         ///< set to the point that made the state inadmissible
  };
  /// Add the internal forces of this rank's points.
  /// @returns false when a point of this rank would be squeezed below min_J_ratio of its volume
  bool evaluate(const Target& target);
  /// Forces of the accepted stresses, those of du = 0: `num_values` = num_nodes x dim [N].
  std::vector<double> start_forces(std::size_t num_values) const;

 private:
  void add_accepted_stresses(std::int32_t g, AveragedGroup<dim>& average) const;

  // The three passes over one group.
  bool add_points(std::int32_t g, std::span<const double> du, AveragedGroup<dim>& average,
                  std::int32_t& worst) const;
  template <class Law>
  bool add_stresses(const Law& law, std::int32_t g, bool with_K,
                    std::span<AveragedGroup<dim>> averages, std::int32_t& worst);
  template <class Law>
  bool group_forces(const Law& law, std::int32_t first, std::int32_t last, const Target& target);
  void add_forces(std::int32_t g, const double* gradient, AveragedGroup<dim>& average,
                  BlockMatrix<dim>* K, std::span<double> f) const;

  StressParts<dim> parts_;
  std::vector<AveragedGroup<dim>> averages_;  // of the groups at hand
  PointStresses<dim> stresses_;               // the same
};

}  // namespace gabion::mpm
