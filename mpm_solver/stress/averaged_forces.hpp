// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <span>
#include <vector>

#include "common/mechanics/petsc/block_matrix.hpp"
#include "mpm_solver/stress/averaged_batch.hpp"
#include "mpm_solver/stress/cell_sums.hpp"
#include "mpm_solver/stress/point_stresses.hpp"

namespace gabion::mpm {

/// Internal forces under F-bar, see AveragedBatch. The points of a group are on one rank.
template <int dim>
class AveragedForces {
 public:
  explicit AveragedForces(const StressParts<dim>& parts) : parts_(parts) {}

  struct Target {
    std::span<const double> du;  ///< of the active nodes, num_nodes x dim [m]
    BlockMatrix<dim>* K;         ///< null, or gets the derivative of the forces
    std::span<double> f;         ///< gets the forces, num_nodes x dim [N]
    RefusedPoint& worst;         ///< set to the point that made the state inadmissible
  };
  /// Add the internal forces of this rank's points.
  /// @returns false when a point of this rank has no stress, or would be squeezed below min_J_ratio
  ///          of its volume
  bool evaluate(const Target& target);
  /// Evaluate the groups of a range.
  bool evaluate(const GroupRange& range, const Target& target);
  /// Forces of the accepted stresses, those of du = 0: `num_values` = num_nodes x dim [N].
  std::vector<double> start_forces(std::size_t num_values) const {
    return AveragedForces(parts_).find_start_forces(num_values);
  }

 private:
  using Batch = AveragedBatch<dim>;
  template <class OfEntry>
  Lanes of_groups(std::size_t b, const OfEntry& of_group) const;

  // The three passes over the groups of a range.
  /// @tparam n  see EntryValues
  template <int n>
  bool evaluate_range(const Body<dim>& body, const GroupRange& range, const Target& target);
  template <int n>
  bool find_volumes(const GroupRange& range, std::span<const double> du, RefusedPoint& worst);
  template <class Law>
  bool find_stresses(const Law& law, bool with_K, RefusedPoint& worst);
  void sum_pressures(bool with_K);
  template <int n>
  void add_forces(const GroupRange& range, std::span<double> f);
  template <int n>
  void add_all(const GroupRange& range, BlockMatrix<dim>& K, std::span<double> f);
  template <int n>
  void add_cell(std::int32_t g, CellSums<dim, Batch::num_fields, n>& sums, BlockMatrix<dim>& K);
  void order_forces();
  void order_all();

  std::vector<double> find_start_forces(std::size_t num_values);
  void start(const GroupRange& range);
  void set_volumes();

  StressParts<dim> parts_;
  // The members below belong to the current range.
  PointStresses<dim> stresses_;
  std::vector<Batch> averages_;
  std::vector<GroupSums> sums_;         // of each group
  std::vector<std::int32_t> group_of_;  // of each entry, the last one fills up
  std::vector<PointTerms<dim, 1>> force_terms_;
  std::vector<typename Batch::Terms> terms_;
};

}  // namespace gabion::mpm
