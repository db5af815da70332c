// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <type_traits>

#include "mpm_solver/stress/cell_stiffness.hpp"
#include "mpm_solver/stress/element_stiffness.hpp"
#include "mpm_solver/stress/nodal_sums.hpp"
#include "mpm_solver/stress/stress_parts.hpp"

namespace gabion::mpm {

/// Forces and stiffness of the cell at hand.
/// @tparam n  see EntryValues
template <int dim, int num_fields, int n>
class CellSums {
 public:
  NodalSums<dim, num_fields, n> fields;
  std::conditional_t<n == 0, CellStiffness<dim>, ElementStiffness<dim, n>> K;

  void start(int num_nodes) { fields.start(num_nodes); }
  /// @param entry  of PointWeights
  void add_forces(const PointWeights<dim>& weights, std::int32_t entry,
                  const PointTerms<dim, num_fields>& terms) {
    const EntryValues<dim, n> values(weights, entry);
    fields.add(values.n, values.local, values.grad, terms.nodal[0]);
  }
  void add_stiffness(const PointWeights<dim>& weights, std::int32_t entry,
                     const PointTerms<dim, num_fields>& terms) {
    const EntryValues<dim, n> values(weights, entry);
    K.add_point(values.n, values.local, values.grad, terms.A);
  }
  /// Add the forces to those of the active nodes; StressParts::kept takes them too.
  void scatter(const StressParts<dim>& parts, const CellGroup& group, double* f) const {
    std::int32_t active[max_group_nodes<dim>];
    parts.nodes.list_active(parts.weights.nodes_of(group), active);
    fields.scatter(group.num_nodes, active, f);
    if (parts.kept != nullptr && !parts.kept->place.empty()) keep(parts, group);
  }

 private:
  void keep(const StressParts<dim>& parts, const CellGroup& group) const {
    const std::int32_t place = parts.kept->place[&group - parts.weights.groups.data()];
    if (place >= 0) fields.take(group.num_nodes, 0, parts.kept->values.data() + place);
  }
};

}  // namespace gabion::mpm
