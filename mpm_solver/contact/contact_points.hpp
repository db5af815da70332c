// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "mpm_solver/contact/facet_laws.hpp"

namespace gabion::mpm {

/// A place where a contact sphere meets the surface.
template <int dim>
struct ContactPoint {
  std::int32_t candidate = 0;
  std::int32_t owner = 0;  ///< the member that has the feature
  SurfaceFeature<dim> feature;
  double radius = 0, area = 0;             ///< of the sphere [m], of the contact [m^(dim-1)]
  double initial_penetration = 0;          ///< [m]
  double gap = 0;                          ///< less that depth [m]
  std::int32_t first_weight = 0;           ///< of its weights, one for each value of the candidate
  std::array<std::int32_t, dim> others{};  ///< those of its material point, itself too
  std::array<double, dim> shares{};        ///< d depth / d their gaps, < 0 turned
  int num_others = 0;
  double part = 1;                              ///< of the tangential stiffness
  std::array<double, dim> part_slopes{};        ///< d part / d the gaps of others, < 0 turned
  double depth = 0;                             ///< that the traction follows [m]
  double stored_depth = 0;                      ///< that the stored energy follows [m]
  double slip_share = 1, slip_share_slope = 0;  ///< of the step after contact began; over gap [1/m]
  Vector<dim> motion = Vector<dim>::Zero();     ///< of the soil in the step [m]
  Vector<dim> slip = Vector<dim>::Zero();       ///< elastic, before the friction limit [m]
  Vector<dim> slip_part_slope = Vector<dim>::Zero();  ///< d slip / d part [m]
  Vector<dim> old_slip = Vector<dim>::Zero();         ///< of the slip: what the step began with [m]
  double old_part = 1;                                ///< of the tangential stiffness, then
  Vector<dim> relative = Vector<dim>::Zero();         ///< motion of the soil on the surface [m]
  ContactTraction<dim> traction{};                    ///< in the frame
  Matrix<dim> frame = Matrix<dim>::Identity();        ///< columns: normal, tangents
  Vector<dim> force = Vector<dim>::Zero();            ///< on the soil [N]
};

/// The contact points of the current step: where the spheres of the candidates meet the surface for
/// a motion of the soil, how deep, and how far they have slipped. Forces follow from them.
template <int dim>
class ContactPoints {
 public:
  using Candidate = ContactCandidate<dim>;
  using Point = ContactPoint<dim>;

  /// Refers to all of them.
  ContactPoints(const JointSurface<dim>& surface, PointSearch<dim>& search,
                const FacetLaws<dim>& laws)
      : surface_(surface), search_(search), laws_(laws) {
    clear();
  }

  /// Remove all contact points.
  void clear();
  /// Find the contact points at the end of the step. @param du  of the soil, nodes x dim [m]
  void find(std::span<const double> du);
  /// Add to opened() the spheres that find() searches only as far as they may come into contact.
  void find_opened();

  /// All of them, in the order in which they were found; those of a material point follow each
  /// other.
  std::vector<Point>& all() { return points_; }
  const std::vector<Point>& all() const { return points_; }
  /// Places where spheres without contact keep an offset.
  const std::vector<Point>& opened() const { return opened_; }
  /// Numbers of the points of a member, as they were found.
  std::span<const std::int32_t> of(std::size_t owner) const {
    return std::span(by_owner_).subspan(first_of_[owner], first_of_[owner + 1] - first_of_[owner]);
  }
  /// Numbers of all of them, one member after the other.
  std::span<const std::int32_t> by_owner() const { return by_owner_; }

  const Candidate& candidate(const Point& point) const {
    return search_.candidates()[point.candidate];
  }
  /// The functions of the soil at the point, one for each value of its candidate.
  const double* weights_of(const Point& point) const { return w_.data() + point.first_weight; }
  /// The law at a point, in dry soil. @param part  of the tangential stiffness
  ContactLaw law_of(const Point& point, double part) const {
    return laws_.law_of(candidate(point), point.owner, part);
  }

 private:
  void add(std::int32_t candidate, std::span<const SurfaceFeature<dim>> features);
  Point point_at(const Candidate& c, const SurfaceFeature<dim>& feature);
  void set_slip(const Candidate& c, Point& point) const;
  void share_in_corners(const Candidate& c, std::size_t first);
  void order();

  const JointSurface<dim>& surface_;
  PointSearch<dim>& search_;
  const FacetLaws<dim>& laws_;
  std::vector<Point> points_, opened_;
  std::vector<std::int32_t> by_owner_, first_of_;
  std::vector<double> w_;             // of the points
  std::vector<Vector<dim>> motions_;  // of the nodes of a candidate [m]
};

}  // namespace gabion::mpm
