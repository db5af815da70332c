// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "mpm_solver/contact/facet_search.hpp"

namespace gabion::mpm {

/// The surfaces of a contact by facets, its members, one after the other: one surface for the
/// search, with the places of its vertices in the accepted state and in the step under way.
template <int dim>
class JointSurface {
 public:
  struct Member {
    std::string name;                                   ///< of the interface or wall
    ContactSurface<dim> surface;                        ///< reference
    std::int32_t first_vertex = 0, num_vertices = 0;    ///< of all members'
    std::int32_t first_simplex = 0, num_simplices = 0;  ///< of all members'
    bool dropped = false;                               ///< it acts no more
    double motion = 0;                                  ///< largest of a vertex in the step [m]
    double last_motion = 0;                             ///< `motion` of the accepted step [m]
  };

  /// @param members  not empty
  explicit JointSurface(const std::vector<const ContactSettings<dim>*>& members);

  std::int32_t num_members() const { return static_cast<std::int32_t>(members_.size()); }
  const Member& member(std::size_t m) const { return members_[m]; }
  std::span<const Simplex<dim>> simplices() const { return simplices_; }
  /// The member that has a simplex.
  std::int32_t owner(std::int32_t simplex) const { return owner_[simplex]; }
  std::span<const Neighbours<dim>> neighbours() const { return neighbours_; }
  const FacetSearch<dim>& search() const { return search_; }
  /// All vertices in the accepted state [m].
  const std::vector<Vector<dim>>& start() const { return start_; }
  /// Vertices of a member in the accepted state [m].
  std::span<const Vector<dim>> start_of(std::size_t m) const {
    return std::span(start_).subspan(members_[m].first_vertex, members_[m].num_vertices);
  }
  /// Corners of a simplex in the accepted state [m].
  std::array<Vector<dim>, dim> corners(std::int32_t simplex) const {
    return corners_of<dim>(simplices_[simplex], start_);
  }

  /// @param sphere  diameter of the largest contact sphere [m]
  /// @returns FacetSearch::box
  Eigen::AlignedBox<double, dim> begin_step(double sphere) {
    search_.begin_step(simplices_, start_, sphere);
    return search_.box();
  }
  /// FacetSearch::make_ready. @pre begin_step was called
  void make_ready() { search_.make_ready(); }
  /// Set the displacement, see Contact::set_displacement.
  void set_displacement(std::span<const double> displacement, std::size_t member);
  /// Move to a share of the step, see ContactSubsteps::set_share.
  void set_share(double share);
  /// The share of the step at which the vertices are.
  double share() const { return share_; }
  /// Largest motion of a vertex in the step [m].
  double motion() const { return motion_; }
  /// Motion of a place in the step [m].
  Vector<dim> motion_at(const SurfaceFeature<dim>& place) const;
  /// The surface as a point sees it in the step.
  /// @param seam  rims that are nearer to a simplex meet it [m]
  FacingSurface<dim> view(std::span<const FacingSimplex> facing, double seam) const;

  /// Make the end of the step the accepted state.
  void accept();
  /// Let a member have other facets, of the same vertices.
  void set_facets(std::size_t member, std::vector<std::int32_t> facets);
  /// Let a member act no more, or again, see Contact::drop.
  void drop(std::size_t member, bool dropped);
  void visit_vertices(StateVisitor& visitor, const std::string& prefix);
  void visit_member(std::size_t m, StateVisitor& visitor, const std::string& prefix) {
    visitor.real(prefix + "last_motion", members_[m].last_motion);
  }

 private:
  void add(const ContactSettings<dim>& settings);
  void cut(Member& member);
  void find_motion(Member& member);

  std::vector<Member> members_;
  std::vector<Simplex<dim>> simplices_;      // of one member after the other
  std::vector<std::int32_t> owner_;          // of each simplex
  std::vector<char> rim_;                    // of each vertex: 1 on the rim of its surface
  std::vector<Neighbours<dim>> neighbours_;  // of each simplex
  FacetSearch<dim> search_;                  // as start_ is
  std::vector<Vector<dim>> start_, end_;     // of the vertices: accepted, and in the step
  std::vector<Vector<dim>> target_;          // at the end of the step
  double motion_ = 0;
  double share_ = 1;
};

}  // namespace gabion::mpm
