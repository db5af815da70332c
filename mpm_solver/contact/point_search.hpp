// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cmath>
#include <functional>
#include <optional>

#include "mpm_solver/contact/contact_memory.hpp"
#include "mpm_solver/contact/joint_surface.hpp"
#include "mpm_solver/contact/kept_motions.hpp"
#include "mpm_solver/contact/soil_surface.hpp"
#include "mpm_solver/grid/surface_values.hpp"

namespace gabion::mpm {

/// A material point that may come into contact with a surface in the step, with its contact sphere.
template <int dim>
struct ContactCandidate {
  /// Place of the point, relative to what it was in contact with, when the step begins.
  enum class Place : char {
    unknown,
    front,  ///< in front of the nearest simplex in contact
    other,
  };
  std::int64_t id = 0;
  std::int32_t body = 0;
  double margin = 0;            ///< places farther away are out of reach [m]
  bool reaches_far = false;     ///< find() looks for places without contact, too
  bool found = false;           ///< the last find() found a place
  double touched_distance = 0;  ///< of the nearest simplex in contact, at the start [m]
  double spread = 0;            ///< a node moved by this against the point, in the step [m]
  Place place = Place::unknown;
  bool is_listed = false;                       ///< what it faces
  Vector<dim> x = Vector<dim>::Zero();          ///< of the sphere [m]
  Vector<dim> offset = Vector<dim>::Zero();     ///< of the sphere from its point [m]
  Matrix<dim> shape = Matrix<dim>::Identity();  ///< |shape^T n| is R in direction n [m]
  double volume = 0;                            ///< [m^dim]
  double modulus = 0;                           ///< of P waves [Pa]
  bool took_weight = false;  ///< contact began in a step in which soil took its weight
  double weight = 0;         ///< SoilSurface::weights_of, of its body [Pa]
  double pore_pressure = 0;  ///< SoilSurface::pore_pressures [Pa]
  Symmetric<dim> grain_stress = Symmetric<dim>::Zero();  ///< SoilSurface::grain_stresses [Pa]
  bool deforms = false;  ///< the sphere is strained like the soil; else it is rigid
  double distance = 0;   ///< to the nearest facet at the start, 0 behind one [m]
  std::int32_t first_value = 0, num_values = 0;   ///< of the basis functions
  std::int32_t first_facing = 0, num_facing = 0;  ///< of what it faces
  /// Simplices that the point faces around a place, complete up to a distance [m]; 0: it is not
  /// listed.
  struct Around {
    Vector<dim> place = Vector<dim>::Zero();
    double within = 0;
    std::int32_t first = 0, count = 0, room = 0;
  };
  Around around;
  Vector<dim> motion = Vector<dim>::Zero();   ///< in the step [m]
  Matrix<dim> H = Matrix<dim>::Zero();        ///< its gradient
  std::optional<SurfaceValues<dim>> surface;  ///< none: functions are continued
  const RememberedContacts<dim>* memory = nullptr;

  double radius(const Vector<dim>& n) const { return (shape * n).norm(); }
  double mean_radius() const { return shape.norm() / std::sqrt(double{dim}); }
};

/// A box of the displacements of some nodes [m].
template <int dim>
struct NodalBox {
  Vector<dim> middle, half;
};

/// Search for the places of a surface that the material points of this rank may meet in a step.
/// Points far from the surface are only watched; a point that comes near becomes a candidate.
template <int dim>
class PointSearch {
 public:
  using Candidate = ContactCandidate<dim>;
  using Features = std::span<const SurfaceFeature<dim>>;
  /// Takes the places near a candidate.
  using Take = std::function<void(std::int32_t candidate, Features)>;

  /// Refers to both.
  PointSearch(JointSurface<dim>& surface, ContactMemory<dim>& memory)
      : surface_(surface), memory_(memory), limits_(surface.num_members()) {}

  /// Collective over soil.comm.
  /// @param deepest  penetration of the accepted state, of all ranks [m]
  void begin_step(const SoilSurface<dim>& soil, double deepest);
  /// The step is over: nothing is watched.
  void end_step();
  /// None between steps.
  const std::optional<SoilSurface<dim>>& soil() const { return soil_; }
  /// Whether a member may be in contact in the step.
  bool can_touch(std::size_t member) const { return limits_[member].may_touch; }
  /// Let a member act no more, or again.
  void drop(std::size_t member) { limits_[member].may_touch = false; }
  /// See Contact::allowed_motion.
  double allowed_motion(std::size_t member) const;
  /// See Contact::approach_step.
  double approach_step(double dt, double margin) const;

  std::vector<Candidate>& candidates() { return candidates_; }
  const std::vector<Candidate>& candidates() const { return candidates_; }
  /// The surface as a candidate faces it.
  FacingSurface<dim> view_of(const Candidate& c) const;
  /// Nodes of the candidate's functions, active ones.
  std::span<const std::int32_t> nodes_of(const Candidate& c) const {
    return std::span(nodes_).subspan(c.first_value, c.num_values);
  }
  /// The functions of the point where its sphere, as the step began, has its surface in the
  /// direction -n. @param[out] w  num_values
  void surface_weights(const Candidate& c, const Vector<dim>& n, double* w) const;
  /// Add w_i f at the candidate's nodes.
  void scatter(const Candidate& c, const double* w, const Vector<dim>& f,
               std::span<double> field) const;

  /// Places within reach of the points at the end of the step, point by point.
  /// @param du  of the soil, nodes x dim [m]
  void find(std::span<const double> du, const Take& take);
  /// Places where the spheres stand off from the surface at the end of the step, for rigid spheres,
  /// which find() searches only as far as they may come into contact.
  void find_opened(const Take& take);
  /// Displacements of the candidate's nodes in the last find() [m].
  void motions_of_nodes(const Candidate& c, std::vector<Vector<dim>>& motions) const;

  // Soil at rest when the run begins.

  /// Watched points within this distance of a surface, or nearer than the margin, become
  /// candidates.
  void complete_near(double distance);
  /// Places within this distance of a candidate where it is. @pre its margin is not less
  /// @returns valid until the next search
  Features features_at_rest(Candidate& c, double distance);
  /// Candidates refer to the memory as it is.
  void refer_to_memory();

 private:
  using Place = typename Candidate::Place;
  /// A point that is looked at in the step, closely only where it comes near a surface.
  struct Watched {
    std::int32_t entry = 0;               // of the weights
    std::int32_t candidate = -1;          // number; -1: it has not come near as yet
    Vector<dim> x = Vector<dim>::Zero();  // of the sphere
    double reach = 0;                     // of the sphere and its offset [m]
    double clearance = 0;                 // no simplex is nearer when the step begins [m]
    const RememberedContacts<dim>* memory = nullptr;
    const Vector<dim>* offset = nullptr;
  };
  /// Watched points of a group of the weights, one after the other.
  struct WatchedGroup {
    std::int32_t group = 0;
    std::int32_t first = 0, last = 0;
    double clearance = 0;  // no simplex is nearer to a point when the step begins [m]
    double reach = 0;      // largest of a point; infinite: each has to be looked at [m]
  };
  /// Simplex of a member that is nearest to a point, when the step begins.
  struct Near {
    std::int32_t owner = 0;
    double distance = 0;  // [m], 0 behind a facet in contact
    SurfaceFeature<dim> place{};
  };
  /// Simplices that a point faces when the step begins.
  struct Facing {
    std::vector<FacingSimplex> simplices;
    std::vector<Near> near;
    double distance = 0;  // to the nearest simplex, 0 behind one [m]
  };
  /// The facet in contact with a point that is nearest to it, when the step begins.
  struct Behind {
    double distance = std::numeric_limits<double>::infinity();  // [m]
    double height = 0;                                          // of the point above it [m]
    std::int32_t owner = 0;
    Vector<dim> normal = Vector<dim>::Zero();  // zero: the point is in front of it
  };
  /// Limits of the motion of a member in the step.
  struct Limits {
    double watched = 0;  // beyond its speed soil and surface may move by this much together [m]
    bool may_touch = false;
  };

  void watch_points(double margin);
  void watch_groups(std::span<const std::int32_t> groups, double margin);
  void forget_watched();
  Watched watched(std::int32_t entry) const;
  void add_group(std::int32_t group, std::int32_t first);
  bool is_near(const Vector<dim>& x, double margin);
  void mark_touching(const Watched& point, const CellGroup& group);
  Candidate candidate_of(const Watched& point, const CellGroup& group) const;
  Candidate& complete(Watched& point, const CellGroup& group);
  void add_values(const CellGroup& group, std::int32_t entry);

  Facing facing_of(const Candidate& c) const;
  void list_facing(Candidate& c);
  void face(const Candidate& c, std::int32_t s, Facing& facing, Near& nearest,
            Behind& behind) const;
  void face_next_members(const Candidate& c, const Behind& behind, Facing& facing) const;
  void drop_far_side(const Behind& behind, Facing& facing) const;

  Vector<dim> motion_of(std::int32_t entry, const CellGroup& group) const;
  bool stays_away(const Watched& point, const CellGroup& group, const NodalBox<dim>& box) const;
  bool stays_away(const WatchedGroup& watched, const NodalBox<dim>& box) const;
  void find_of(Candidate& c, std::span<const double> du);
  Place place_of(Candidate& c);
  bool look_in_front(Candidate& c, const FeatureReach& reach, double around);
  double list_around(Candidate& c, const FrontView<dim>& view, double needed);
  void find_features_of(Candidate& c, double reach);

  JointSurface<dim>& surface_;
  ContactMemory<dim>& memory_;
  std::vector<Limits> limits_;  // of the members

  // the current step
  std::optional<SoilSurface<dim>> soil_;
  double margin_ = 0;    // at any speed: places farther away are out of reach in the step [m]
  double farthest_ = 0;  // places farther away are out of reach of the fastest point, too [m]
  Eigen::AlignedBox<double, dim> box_;  // FacetSearch::box
  std::int32_t num_known_ = 0;          // watched points that the memory knows
  std::vector<Watched> watched_;
  std::vector<WatchedGroup> watched_groups_;
  std::vector<Candidate> candidates_;  // the watched points that came near, as they did
  std::vector<double> N_;
  std::vector<Vector<dim>> grad_N_;
  std::vector<std::int32_t> nodes_;  // active ones
  std::vector<FacingSimplex> facing_;
  std::vector<FacingSimplex> around_;  // of the candidates
  KeptMotions<dim> du_;
  std::vector<char> at_rest_;  // of each member, in the step
  std::vector<SurfaceFeature<dim>> features_;
  std::vector<KnownContact<dim>> known_;  // room for what a point was in contact with
  std::vector<std::int32_t> near_;        // room for a list
  std::vector<FacingSimplex> faced_;      // room for a list
};

}  // namespace gabion::mpm
