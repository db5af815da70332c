// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <mpi.h>

#include <span>
#include <vector>

#include "common/mechanics/petsc/block_matrix.hpp"
#include "mpm_solver/stress/averaged_group.hpp"
#include "mpm_solver/stress/point_stresses.hpp"

namespace gabion::mpm {

/// Internal forces under F-bar, see AveragedGroup. A group with points on several ranks (as
/// share_groups found them) is averaged over all of them: the result does not depend on the number
/// of ranks.
template <int dim>
class AveragedForces {
 public:
  AveragedForces(MPI_Comm comm, const StressParts<dim>& parts);

  /// Add the internal forces of this rank's points and, when K is given, their derivative.
  /// @param du     of the active nodes, num_nodes x dim [m]
  /// @param f      num_nodes x dim [N]
  /// @param worst  set to the point that made the state inadmissible, on the rank that has it
  /// @returns false when a point of this rank would be squeezed below min_J_ratio of its volume; of
  ///          a group that ranks share, on all ranks
  /// @note Collective.
  bool evaluate(std::span<const double> du, BlockMatrix<dim>* K, std::span<double> f,
                std::int32_t& worst);
  /// Forces of the accepted stresses, those of du = 0: `num_values` = num_nodes x dim [N].
  /// @note Collective.
  std::vector<double> start_forces(std::size_t num_values) const;

 private:
  /// What `evaluate` adds to.
  struct Target {
    std::span<const double> du;
    BlockMatrix<dim>* K;
    std::span<double> f;
    std::int32_t& worst;
  };

  void add_start_forces(std::span<double> f);
  void add_accepted_stresses(std::int32_t g, AveragedGroup<dim>& average) const;
  bool private_forces(const Target& target);
  bool shared_forces(std::span<const double> du, BlockMatrix<dim>* K, std::span<double> f,
                     std::int32_t& worst);
  bool share_volumes(bool admissible);
  bool share_pressures(bool admissible, bool with_K);

  // The three passes over one group.
  bool add_points(std::int32_t g, std::span<const double> du, AveragedGroup<dim>& average,
                  std::int32_t& worst) const;
  template <class Law>
  bool add_stresses(const Law& law, std::int32_t g, bool with_K,
                    std::span<AveragedGroup<dim>> averages, std::int32_t& worst);
  template <class Law>
  bool private_groups(const Law& law, std::int32_t first, std::int32_t last, const Target& target);
  void add_forces(std::int32_t g, const double* gradient, AveragedGroup<dim>& average,
                  BlockMatrix<dim>* K, std::span<double> f) const;

  MPI_Comm comm_;
  StressParts<dim> parts_;
  std::vector<AveragedGroup<dim>> own_;            // the private groups at hand
  PointStresses<dim> stresses_;                    // of the groups at hand
  std::vector<std::int32_t> shared_;               // groups with points on other ranks too
  std::vector<AveragedGroup<dim>> shared_groups_;  // of each of them
  std::vector<double> sums_;
};

}  // namespace gabion::mpm
