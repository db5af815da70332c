// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Geometry>
#include <cstdint>
#include <span>
#include <vector>

#include "mpm_solver/contact/facet_lattice.hpp"

namespace gabion::mpm {

/// Search for the simplices of the members of a contact that are near a place when a step begins:
/// begin_step; then make_ready where there are places to ask for. Bounds and lists of members at
/// rest are kept from step to step.
template <int dim>
class FacetSearch {
 public:
  /// Members follow each other in the contact's simplices.
  void add_member(std::size_t num_simplices);

  /// @param simplices, vertices  of the contact; they outlive the step, vertices do not move in it
  /// @param diameter  diameter of the largest contact sphere [m]
  void begin_step(std::span<const Simplex<dim>> simplices, std::span<const Vector<dim>> vertices,
                  double diameter);
  /// A box around the bounding spheres of all simplices of members that act.
  Eigen::AlignedBox<double, dim> box();
  /// Find the bounds and make the lists that the functions below have.
  void make_ready();
  /// The accepted place of a member has changed; a vertex moved by up to this [m].
  void add_motion(std::size_t member, double path);
  /// Forget bounds and lists: vertices are those of another state.
  void forget();
  /// Let a member act no more, so that it has no simplices near any place, or again.
  void drop(std::size_t member, bool dropped) { members_[member].dropped = dropped; }

  /// All bounds at the start of the step; those of members that do not act are undefined.
  std::span<const SimplexBounds<dim>> bounds() const { return bounds_; }
  /// Diameter of the largest bounding sphere of a simplex [m].
  double size() const { return size_; }

  /// Simplices of one member, see FacetLattice::near.
  std::span<const std::int32_t> near(std::size_t member, const Vector<dim>& x, double distance,
                                     std::vector<std::int32_t>& room) const;
  /// Simplices of all members that are near.
  std::span<const std::int32_t> near(const Vector<dim>& x, double distance,
                                     std::vector<std::int32_t>& room) const;
  /// See FacetLattice::at_least, of the nearest member.
  double at_least(const Vector<dim>& middle, const Vector<dim>& half) const;
  double at_least(std::size_t member, const Vector<dim>& middle, const Vector<dim>& half) const;
  /// Like at_least, for larger boxes and up to larger distances.
  double far_at_least(const Vector<dim>& middle, const Vector<dim>& half) const;
  /// Lists for distances up to this are kept [m].
  double reach() const { return reach_; }

 private:
  struct Member {
    std::int32_t first = 0, count = 0;
    bool dropped = false;
    bool bounds_known = false, has_lattice = false;
    double size = 0;                     // of its largest simplex [m]
    Eigen::AlignedBox<double, dim> box;  // around its bounding spheres; empty: not known [m]
    FacetLattice<dim> lattice, far;
  };
  LatticeSurface<dim> surface_of(const Member& member) const {
    return {simplices_.subspan(member.first, member.count), member.first, vertices_,
            std::span(bounds_).subspan(member.first, member.count)};
  }
  void find_bounds(Member& member);
  void find_box(Member& member) const;

  std::vector<Member> members_;
  std::vector<SimplexBounds<dim>> bounds_;
  double size_ = 0;
  double reach_ = 0;
  std::span<const Simplex<dim>> simplices_;
  std::span<const Vector<dim>> vertices_;
  mutable std::vector<std::int32_t> of_member_;  // room
};

}  // namespace gabion::mpm
