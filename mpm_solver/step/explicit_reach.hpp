// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <limits>
#include <span>
#include <vector>

#include "mpm_solver/stress/internal_forces.hpp"
#include "mpm_solver/stress/stress_parts.hpp"

namespace gabion::mpm {

/// The part of the soil that another place of the interfaces can change in the substeps of an
/// explicit step, and the results of the first solution elsewhere (docs/theory/soil.md, "Iterations
/// of an explicit step"). Per substep, from the nodes of the points in contact with an interface:
///
///     U = V_before + nodes of the points about F ,  F: forces of contacts that differ
///     D = groups with a node of U ,  I = nodes of D ,  V = U + nodes of the points about I
///
/// u differs in U alone, stresses in D, internal forces in I, v and A in V. All sets grow from
/// substep to substep. A contact that begins outside changes u outside U, where it is compared: the
/// step is then solved as a whole.
///
/// Refers to its parts; valid for one step. Functions are collective where they say so.
template <int dim>
class ExplicitReach {
 public:
  explicit ExplicitReach(const StressParts<dim>& parts);

  // The first solution: begin; for each substep find, keep_states, keep; then complete.

  /// Begin a solution of this number of substeps, which is to be kept.
  void begin(int count);
  /// Whether the solution is kept: not where its reach is most of the soil.
  bool keeps() const { return keeps_; }
  /// Find the sets of the next substep.
  /// @param F        of all contacts, num_nodes x dim [N]
  /// @param touched  1 for nodes of points in contact with an interface, num_nodes
  /// @note Collective.
  void find(std::span<const double> F, std::span<const char> touched);
  /// Keep the states from which the first points of D in this substep start.
  /// @param tau  stresses of the skeleton [Pa]; empty: no law depends on the path
  void keep_states(const MaterialPath<dim>& path, std::span<const Symmetric<dim>> tau);
  /// Ask for the forces of the groups about D: make room for StressParts::kept.
  void ask_for_forces(GroupForces<dim>& kept) const;
  /// Values at the end of a substep, nodal ones of all ranks.
  struct Fields {
    std::vector<double> du;        ///< [m]
    std::vector<double> internal;  ///< forces [N]
    std::vector<double> A;         ///< [m/s^2]
    std::vector<double> plastic;   ///< plastic_density of each entry; empty: no path
  };
  void keep(Fields fields, std::vector<double> group_forces);
  void complete() { is_complete_ = keeps_; }

  // The following solutions, if there is something to start from.

  /// Whether a solution of this number of substeps is known.
  bool knows(int count) const { return is_complete_ && std::ssize(substeps_) == count; }
  /// Whether u at the end of a substep is the known one outside U, on this rank.
  bool covers(int k, std::span<const double> du) const;
  /// Put back what keep_states took in this substep.
  void load_states(int k, MaterialPath<dim>& path, std::span<Symmetric<dim>> tau) const;
  /// D and the groups about it.
  ForcePart part(int k);
  /// Groups whose points reach V.
  std::vector<std::int32_t> responding_groups(int k) const;
  /// Fill in the known values where nothing differs: internal forces outside I, A outside V.
  void fill_internal(int k, std::span<double> internal) const;
  void fill_A(int k, std::span<double> A) const;
  const Fields& known(int k) const { return substeps_[k].fields; }
  /// Points of this rank in D.
  std::int64_t num_points(int k) const { return substeps_[k].num_points; }

 private:
  static constexpr std::int32_t never = std::numeric_limits<std::int32_t>::max();

  struct PointState {
    MaterialState<dim> history;
    InternalState internal = InternalState::Zero();
    Symmetric<dim> tau = Symmetric<dim>::Zero();
  };
  struct Substep {
    std::int64_t num_points = 0;
    std::vector<std::int32_t> first_groups;  // that D has in this substep first
    std::vector<PointState> states;          // of their points
    std::vector<std::int32_t> border;        // groups about D
    std::vector<double> border_forces;
    Fields fields;
  };

  std::span<const std::int32_t> nodes_of(const CellGroup& group) const {
    return std::span(parts_.nodes.of_groups)
        .subspan(static_cast<std::size_t>(group.first_node),
                 static_cast<std::size_t>(group.num_nodes));
  }
  /// Visit the points that D has in a substep first.
  template <class Visit>
  void for_each_first(const Substep& substep, const Visit& visit) const {
    for (const std::int32_t g : substep.first_groups) {
      const CellGroup& group = parts_.weights.groups[g];
      for (std::int32_t e = group.first; e < group.last; ++e) visit(parts_.weights.point[e]);
    }
  }
  bool any_since(const CellGroup& group, const std::vector<std::int32_t>& since) const;
  void add_points(const std::vector<char>& marks, std::vector<std::int32_t>& since) const;
  std::vector<char> pushed_nodes(std::span<const double> F, std::span<const char> touched) const;
  void find_evaluated();
  void find_border();
  bool pays() const;
  void share(std::vector<std::int32_t>& since) const;
  void share(std::vector<char>& marks) const;
  void replace(const std::vector<std::int32_t>& since, int k, std::span<const double> known,
               std::span<double> field) const;

  StressParts<dim> parts_;
  std::vector<std::int32_t> group_since_;                // since when a group is in D
  std::vector<std::int32_t> moved_, loaded_, answered_;  // since when a node is in U, I, V
  std::vector<Substep> substeps_;
  std::vector<GroupRange> ranges_;  // room for those of a part
  std::int32_t now_ = 0;            // the substep whose sets were found last
  int count_ = 0;
  bool keeps_ = false, is_complete_ = false;
};

}  // namespace gabion::mpm
