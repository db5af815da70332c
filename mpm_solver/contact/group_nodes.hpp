// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <vector>

#include "mpm_solver/contact/body_groups.hpp"
#include "mpm_solver/contact/soil_surface.hpp"
#include "mpm_solver/grid/group_fields.hpp"

namespace gabion::mpm {

/// A node of the grid on which bodies of two groups weigh, a contact node.
template <int dim>
struct GroupNode {
  std::int32_t place = 0;               ///< node of the grid
  std::int32_t pair = 0;                ///< of BodyGroups::pairs
  std::int32_t first = 0, second = 0;   ///< active nodes of the two groups
  Vector<dim> n = Vector<dim>::Zero();  ///< of length 1, from the first group to the second
  double gap = 0;                       ///< between the two at the node [m]
  bool separates = false;               ///< a plane lies between them; else the gap is never below
                                        ///< 0, however far they overlap
  double overlap = 0;                   ///< of the contact spheres of the nearest points [m]
  double area = 0;                      ///< of the contact that the node stands for [m^2]
  double modulus = 0;                   ///< the smaller P-wave modulus [Pa]
};

/// The contact nodes of the accepted state: normals and gaps by the points around, areas by the
/// gradients of volume (docs/theory/bodies.md, (G1) to (G4)).
/// @returns those that this rank carries, by place, then by pair
/// @note Collective.
template <int dim>
std::vector<GroupNode<dim>> find_contact_nodes(const SoilSurface<dim>& soil,
                                               const BodyGroups& groups,
                                               const GroupsAtNodes<dim>& at_nodes);

/// Nodes of a box within so many cells of a node along each axis, the node included.
template <int dim>
std::vector<std::int32_t> places_around(const BackgroundGrid<dim>& grid, std::int32_t place,
                                        int reach);

}  // namespace gabion::mpm
