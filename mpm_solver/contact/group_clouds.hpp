// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <limits>
#include <vector>

#include "common/mechanics/ranks/packet.hpp"
#include "mpm_solver/contact/body_groups.hpp"
#include "mpm_solver/contact/soil_surface.hpp"
#include "mpm_solver/grid/group_fields.hpp"

namespace gabion::mpm {

/// The points of one group that weigh on a node.
template <int dim>
struct GroupCloud {
  std::int32_t group = 0;
  Vector<dim> gradient = Vector<dim>::Zero();  ///< sum of volume times grad N: outward area [m^2]
  double modulus = std::numeric_limits<double>::infinity();  ///< smallest [Pa]
  std::vector<std::int32_t> points{};                        ///< numbers of GroupClouds
};

/// A node of the grid on which several groups weigh.
template <int dim>
struct SharedPlace {
  std::int32_t place = 0;
  bool owned = true;  ///< this rank carries its contact
  std::vector<GroupCloud<dim>> clouds{};
};

/// The nodes of the accepted state on which several groups weigh, with their points. A rank has the
/// nodes of its own points; those that it owns, and those around them, with the points of all
/// ranks. Refers to the soil.
template <int dim>
class GroupClouds {
 public:
  /// @note Collective.
  GroupClouds(const SoilSurface<dim>& soil, const BodyGroups& groups,
              const GroupsAtNodes<dim>& at_nodes);

  /// The shared places, in ascending order.
  const std::vector<SharedPlace<dim>>& places() const { return places_; }
  /// The shared place of a node, null: it is none.
  const SharedPlace<dim>* find(std::int32_t place) const {
    return number_[place] < 0 ? nullptr : &places_[number_[place]];
  }
  /// Place and radius of the contact sphere of a point [m].
  const Vector<dim>& x(std::int32_t p) const {
    return p < num_own_ ? soil_.points.x[p] : other_x_[p - num_own_];
  }
  double radius(std::int32_t p) const {
    return p < num_own_ ? soil_.points.depth[p] : other_radius_[p - num_own_];
  }

 private:
  void add_nodes(const CellGroup& group, const BodyGroups& groups,
                 const GroupsAtNodes<dim>& at_nodes);
  void add_points(const CellGroup& group, const BodyGroups& groups);
  void add_point(std::int32_t e, std::int32_t body, const std::vector<GroupCloud<dim>*>& clouds);
  void number_places();
  void add_points_of_others();
  void put(const std::vector<std::int32_t>& which, Packet& packet) const;
  void take(Packet& packet);
  void take_clouds(std::int32_t first_point, Packet& packet);

  const SoilSurface<dim>& soil_;
  std::int32_t num_own_;
  std::vector<SharedPlace<dim>> places_;
  SparseList<std::int32_t> number_;  // of each node of the grid in places_, -1: none
  std::vector<Vector<dim>> other_x_;
  std::vector<double> other_radius_;
};

}  // namespace gabion::mpm
