// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "common/mechanics/petsc/block_matrix.hpp"
#include "common/mechanics/tensor.hpp"
#include "fem_solver/beams/turn.hpp"

namespace gabion::fem {

/// Nodes that move with a node of beams as a rigid body, by stiff springs without length between
/// each of them and its place on that body.
template <int dim>
struct RigidLink {
  struct Arm {
    std::int32_t node;
    Vector<dim> reach;  ///< d, from the node of the beams, before loading [m]
  };
  std::int32_t place = 0;     ///< node of the beams
  std::int32_t rotation = 0;  ///< its rotation node
  std::vector<Arm> arms;
  double stiffness = 0;  ///< of each spring [N/m]
  /// Line of the mesh that is a beam and ends at the node, and which of its ends that is.
  std::int32_t line = 0;
  int end = 0;
};

/// Rigid links of a structure. With g = u_s - u_m - (R - 1) d of the node s of an arm and the node
/// m, the force on s is -k g, that on m its opposite with the moment R d x k g, so that forces and
/// moments balance in any state (docs/theory/structure.md).
template <int dim>
class RigidLinks {
 public:
  RigidLinks() = default;
  /// @param length  of the rotations' unknowns, see BeamNodes
  RigidLinks(std::vector<RigidLink<dim>> links, double length);

  std::span<const RigidLink<dim>> links() const { return links_; }
  std::size_t num_arms() const { return num_arms_; }
  /// Nodes that each arm acts on: its own, the place, the rotation; three an arm.
  std::vector<std::int32_t> nodes() const;

  /// Add the internal forces of the springs, and on demand their derivative.
  /// @param first    number of the first arm among the cells of K; the others follow
  /// @param history  accepted, of the beam at each link, one after the other; empty in the plane
  /// @returns their energy [J]
  double add_internal(std::span<const double> u, std::span<double> f_int, BlockMatrix<dim>* K,
                      std::int32_t first, std::span<const std::span<const double>> histories) const;

 private:
  std::vector<RigidLink<dim>> links_;
  std::size_t num_arms_ = 0;
  double length_ = 1;
};

}  // namespace gabion::fem
