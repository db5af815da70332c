// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <cmath>
#include <limits>
#include <map>
#include <optional>

#include "mpm_solver/contact/contact.hpp"
#include "mpm_solver/contact/facet_search.hpp"
#include "mpm_solver/contact/front_features.hpp"
#include "mpm_solver/contact/way_at_rest.hpp"
#include "mpm_solver/contact/way_out.hpp"
#include "mpm_solver/grid/surface_values.hpp"

namespace gabion::mpm {

/// Material points against the facets of surfaces (docs/theory/interface.md), its members. A point
/// is a ball of radius R, as deep as the point lies in the cell that it was laid in; it touches the
/// surface where the distance of its centre y has a local minimum x_m below R:
///
///     g = (y - x_m) . n - R + n . sum_i (w_i - N_i) du_i ,  y = x_p + o + sum_i N_i du_i ,
///     d = o - R n ,  w_i = N_i(x_p) + grad N_i(x_p) . d ,
///     f_i = w_i A t ,  on vertex v  -phi_v A t ,  A = V / (2 R)
///
/// w continues the functions of the point to its surface, those of gimp and bspline as
/// SurfaceValues say: linear fields are met exactly, and force and place are those of both sides.
/// The ball of an elastic body is strained with it; the offset o carries what else the surface goes
/// against the centre from step to step. Penetration and friction follow ContactLaw; in inside
/// corners depths are those of WayOut. A touch of soil that was at rest under stress when the run
/// began has the depth of that stress from the beginning: its gap is less by it. A point that was
/// open slips from the moment when it touches, the way of the step being straight. The force F of a
/// step is constant in it (NewmarkBossak::step_force_weight): contact then takes energy or keeps
/// it, at any stiffness and dt.
///
/// The members are one surface for the search: where their rims meet, nothing but the friction and
/// the owner of the forces changes. Where two of them meet in a corner each pushes for itself
/// (surface_features.hpp).
///
/// Each rank carries its own material points, and looks as far ahead as all ranks together would.
/// @see Kane, Repetto, Ortiz, Marsden (1999) for the time law; Bird et al. (2024) for points and
///      facets
template <int dim>
class FacetContact final : public Contact<dim> {
 public:
  /// @param members  not empty, all with FacetSettings
  explicit FacetContact(const std::vector<const ContactSettings<dim>*>& members);

  void begin_step(const SoilSurface<dim>& soil) override;
  bool can_touch(std::size_t member = 0) const override { return members_[member].may_touch; }
  bool symmetric() const override { return false; }
  /// A point's nodes are those of its group already.
  void append_cells(std::vector<std::int32_t>&, std::vector<std::int32_t>&) const override {}

  void set_displacement(std::span<const double> displacement, std::size_t member = 0) override;
  void add_forces(std::span<const double> du, std::span<double> r, BlockMatrix<dim>* K) override;
  bool is_step_force() const override { return true; }
  void add_step_force_change(std::span<double> f) const override;
  Vector<dim> step_force_on(std::span<const std::int64_t> ids) const override;

  void add_lasting_forces(std::span<double> f) const override;
  void begin_substeps() override;
  void set_share(double share) override;
  void add_substep(std::span<const double> move, double share) override;
  void add_stiffness_sums(std::span<double> sums) const override;
  void mark_touched(std::span<char> nodes, std::size_t member = 0) const override;

  std::vector<double> forces_on_structure(std::size_t member = 0) const override;
  typename Contact<dim>::Resultant resultant(std::size_t member = 0) const override;
  double work_on_soil(std::span<const double> du) const override;
  ContactCounts counts(std::size_t member = 0) const override;
  double approach_step(double dt, double margin) const override;
  double allowed_way(std::size_t member = 0) const override {
    const Member& own = members_[member];
    return own.dropped ? std::numeric_limits<double>::infinity() : own.watched - own.motion;
  }

  void begin_at_rest(const SoilAtRest<dim>& rest) override;
  std::span<const Vector<dim>> accepted_vertices(std::size_t member) const override {
    const Member& own = members_[member];
    if (own.dropped) return {};
    return std::span(start_).subspan(own.first_vertex, own.num_vertices);
  }
  void accept() override;
  ContactEnergy energy() const override;
  bool drop(std::size_t member, bool dropped) override;
  ContactFields<dim> fields(const MaterialPoints<dim>& points, double reach,
                            std::size_t member = 0) const override;
  std::span<const ContactMark<dim>> marks(std::size_t member = 0) const override {
    return members_[member].marks;
  }
  void give(std::span<const std::int64_t> ids, Packet& packet) override;
  void take(Packet& packet) override;
  void visit_state(StateVisitor& visitor, const std::string& prefix) override;

 private:
  /// What an explicit step adds to the force that lasts, of its own force over that.
  static constexpr double lasting_share = 0.2;
  /// Soil that was laid at a side nearer to the surface than this share of a cell rests on it,
  static constexpr double touching_share = 0.01;
  /// where the side is turned against the surface by no more than the angle of this cosine.
  static constexpr double along_side = 0.99;

  /// What a point remembers of a place where it touched in the accepted state.
  struct Memory {
    std::int32_t owner = 0;  // the member
    Vector<dim> normal = Vector<dim>::Zero();
    Vector<dim> force = Vector<dim>::Zero();  // of the last step, on the soil [N]
    Vector<dim> slip = Vector<dim>::Zero();  // elastic; along -normal what the touch began with [m]
    double part = 1;                         // of the tangential stiffness, in which the slip is
    Vector<dim> lasting = Vector<dim>::Zero();  // part of the force that has lasted [N]
    bool took_weight = false;                   // as Candidate

    double begun() const { return -normal.dot(slip); }
    Vector<dim> tangential() const { return slip + begun() * normal; }
  };
  /// A point that is looked at in the step, closely only where it comes near a surface.
  struct Watched {
    std::int32_t entry = 0;               // of the weights
    std::int32_t candidate = -1;          // it is this one; -1: it never came near as yet
    Vector<dim> x = Vector<dim>::Zero();  // of the ball
    double reach = 0;                     // of the ball and its offset [m]
    const std::vector<Memory>* memory = nullptr;
    const Vector<dim>* offset = nullptr;
  };
  /// Those of a group of the weights, one after the other.
  struct WatchedGroup {
    std::int32_t group = 0;
    std::int32_t first = 0, last = 0;
    double clearance = 0;  // no simplex is nearer to a point when the step begins [m]
    double reach = 0;      // largest of a point; infinite: each has to be looked at [m]
  };
  /// A box of the displacements of some nodes [m].
  struct NodalBox {
    Vector<dim> middle, half;
  };
  /// Where a point is when the step begins.
  enum class Place : char {
    unknown,
    front,  // in front of the nearest simplex that it touched
    other,
  };
  /// A point that may touch in the step.
  struct Candidate {
    std::int64_t id = 0;
    std::int32_t body = 0;
    double margin = 0;            // what is farther cannot be touched [m]
    bool reaches_far = false;     // add_forces has to find places that the point does not touch
    bool found = false;           // the last add_forces found a place
    double touched_distance = 0;  // of the nearest simplex that it touched, at the start [m]
    double spread = 0;            // a node moved by this against the point, in the step [m]
    Place place = Place::unknown;
    bool is_listed = false;                       // what it faces
    Vector<dim> x = Vector<dim>::Zero();          // of the ball
    Vector<dim> offset = Vector<dim>::Zero();     // of the ball from its point
    Matrix<dim> shape = Matrix<dim>::Identity();  // |shape^T n| is R in direction n
    double volume = 0;
    double modulus = 0;
    bool took_weight = false;  // it began to touch in a step in which soil took its weight
    double weight = 0;         // SoilSurface::weights_of, of its body [Pa]
    bool deforms = false;      // the ball is strained like the soil; else it is rigid
    double distance = 0;       // to the nearest facet at the start, 0 behind one
    std::int32_t first_value = 0, num_values = 0;
    std::int32_t first_facing = 0, num_facing = 0;
    Vector<dim> motion = Vector<dim>::Zero();   // in the step
    Matrix<dim> H = Matrix<dim>::Zero();        // its gradient
    std::optional<SurfaceValues<dim>> surface;  // none: functions are continued
    const std::vector<Memory>* memory = nullptr;
  };
  /// What is nearest to a point of a member, when the step begins.
  struct Near {
    std::int32_t owner = 0;
    double distance = 0;  // [m], 0 behind a facet that is touched
    SurfaceFeature<dim> place{};
  };
  /// What a point faces when the step begins.
  struct Facing {
    std::vector<FacingSimplex> simplices;
    std::vector<Near> near;
    double distance = 0;  // to the nearest simplex, 0 behind one [m]
  };
  /// The facet that a point touched and is nearest to, when the step begins.
  struct Behind {
    double distance = std::numeric_limits<double>::infinity();  // [m]
    double height = 0;                                          // of the point above it [m]
    std::int32_t owner = 0;
    Vector<dim> normal = Vector<dim>::Zero();  // zero: the point is in front of it
  };
  /// A place where a point touches.
  struct Touch {
    std::int32_t candidate = 0;
    std::int32_t owner = 0;  // the member that has the feature
    SurfaceFeature<dim> feature;
    double radius = 0, area = 0;
    double begun = 0;                        // depth that it began with [m]
    double gap = 0;                          // less that depth
    std::int32_t first_weight = 0;           // of w, one for each value of the candidate
    std::array<std::int32_t, dim> others{};  // touches of the point, itself too
    std::array<double, dim> shares{};        // d depth / d their gaps, < 0 turned
    int num_others = 0;
    double part = 1;                              // of the tangential stiffness
    std::array<double, dim> part_slopes{};        // d part / d the gaps of others, < 0 turned
    double depth = 0;                             // that the traction follows
    double stored_depth = 0;                      // that the stored energy follows
    double slip_share = 1, slip_share_slope = 0;  // of the step after it touched; over gap [1/m]
    Vector<dim> motion = Vector<dim>::Zero();     // of the soil in the step
    Vector<dim> slip = Vector<dim>::Zero();       // elastic, before the friction limit
    Vector<dim> slip_part_slope = Vector<dim>::Zero();  // d slip / d part
    Vector<dim> old_slip = Vector<dim>::Zero();         // of the slip: what the step began with
    double old_part = 1;                                // of the tangential stiffness, then
    Vector<dim> relative = Vector<dim>::Zero();         // motion of the soil against the surface
    ContactTraction<dim> traction{};                    // in the frame
    Matrix<dim> frame = Matrix<dim>::Identity();
    Vector<dim> force = Vector<dim>::Zero();  // on the soil
  };

  /// Means and sums over the substeps of an explicit step.
  struct Substeps {
    typename Contact<dim>::Resultant resultant;
    double normal_work = 0, tangential_work = 0;  // of soil and surface on the contact [J]
    int closed = 0;                               // places that carried force, most of a substep
  };
  /// One of the surfaces.
  struct Member {
    ContactMode mode = ContactMode::contact;
    double friction = -1, drag = 0;
    FacetSettings method;
    ContactSurface<dim> surface;                        // reference
    std::int32_t first_vertex = 0, num_vertices = 0;    // of all members'
    std::int32_t first_simplex = 0, num_simplices = 0;  // of all members'
    bool dropped = false;                               // it acts no more
    std::vector<ContactMark<dim>> marks;                // of the accepted step
    double last_motion = 0;                             // `motion` of the accepted step
    ContactEnergy energy;                               // accepted
    double stored_slip = 0;                             // part of its energy in tangential springs
    // of the step under way
    double motion = 0;   // largest of a vertex [m]
    double watched = 0;  // beyond its speed soil and surface may move by this much together [m]
    bool may_touch = false;
    Substeps substeps;
  };

  void add_member(const ContactSettings<dim>& settings);
  void find_motion(Member& member);
  void order_touches();
  std::span<const std::int32_t> touches_of(std::size_t owner) const {
    return std::span(by_owner_).subspan(first_of_[owner], first_of_[owner + 1] - first_of_[owner]);
  }
  ContactLaw law_of(const Candidate& c, std::int32_t owner, double part) const;
  void accept_touches(std::size_t owner);
  void add_vertex_forces(const Touch& touch, double share, std::span<double> forces) const;
  void watch_points(double margin);
  void list_remembered();
  Watched watched(std::int32_t entry) const;
  bool is_near(const Vector<dim>& x, double margin);
  Candidate candidate_of(const Watched& point, const CellGroup& group) const;
  Candidate& complete(Watched& point, const CellGroup& group);
  void complete_all();
  void add_values(const CellGroup& group, std::int32_t entry);
  Facing facing_of(const Candidate& c) const;
  void list_facing(Candidate& c);
  void face(const Candidate& c, std::int32_t s, Facing& facing, Near& nearest,
            Behind& behind) const;
  void face_next_members(const Candidate& c, const Behind& behind, Facing& facing) const;
  void drop_far_side(const Behind& behind, Facing& facing) const;
  void mark_touching(const Watched& point, const CellGroup& group);
  Vector<dim> motion_of(std::int32_t entry, const CellGroup& group) const;
  Place place_of(Candidate& c);
  bool look_in_front(const Candidate& c, const FeatureReach& reach, double around);
  void find_features_of(Candidate& c, double reach);
  double reach_of(const Candidate& c) const;
  double touch_reach(const Candidate& c) const;
  void find_opened();
  NodalBox box_of(const CellGroup& group, std::span<const double> du) const;
  bool stays_away(const Watched& point, const CellGroup& group, const NodalBox& box) const;
  bool stays_away(const WatchedGroup& watched, const NodalBox& box) const;
  void add_group(std::int32_t group, std::int32_t first);
  double radius(const Candidate& c, const Vector<dim>& n) const { return (c.shape * n).norm(); }
  double mean_radius(const Candidate& c) const { return c.shape.norm() / std::sqrt(double{dim}); }
  FacingSurface<dim> surface_of(const Candidate& c, std::span<const Vector<dim>> end) const;
  Vector<dim> surface_motion(const SurfaceFeature<dim>& feature) const;
  ContactMark<dim> mark_of(const Touch& touch) const;
  void add_old_forces(std::int32_t owner, double share, std::span<double> field) const;
  void add_remembered(std::int32_t owner, Vector<dim> Memory::*force, double share,
                      std::span<double> field) const;
  void visit_memory(StateVisitor& visitor, const std::string& prefix);
  void find_touches(std::span<const double> du);
  void find_touches_of(std::int32_t candidate, std::span<const double> du);
  Touch touch_at(const Candidate& c, const SurfaceFeature<dim>& feature,
                 std::span<const double> du);
  static double most_begun(const Candidate& c);
  static constexpr std::int32_t any_owner = -1;
  const Memory* remembered(const Candidate& c, const Vector<dim>& n,
                           std::int32_t owner = any_owner) const;
  std::vector<RestingPlace<dim>> places_at_rest(Candidate& c, const SoilAtRest<dim>& rest);
  void lay_on(std::span<const RestingPlace<dim>> places, Candidate& c);
  void remember_shear(const Touch& touch, std::span<const RestingPlace<dim>> places);
  void remember_touches();
  Memory memory_of(const Touch& touch) const;
  Vector<dim> lasting_force(const Touch& touch) const;
  double stored_in_slip(const Touch& touch, const Memory& memory) const;
  double stored_in_depth(const Touch& touch) const;
  Vector<dim> offset_of(std::int64_t id) const;
  Matrix<dim> shape_of(std::int64_t id, double depth) const;
  double offset_after(const Touch& touch) const;
  void accept_offsets();
  void set_slip(const Candidate& c, Touch& touch) const;
  static void follow_part(Touch& touch);
  void share_depths(const Candidate& c, std::size_t first);
  void share_in_corners(const Candidate& c, std::size_t first);
  Vector<dim> gap_slope(const Touch& touch, std::int32_t value) const;
  void add_stiffness(const Touch& touch, const Matrix<dim>& slope, BlockMatrix<dim>& K) const;
  void surface_weights(const Candidate& c, const Vector<dim>& n, double* w) const;
  void scatter(const Candidate& c, const double* w, const Vector<dim>& f,
               std::span<double> field) const;
  const double* weights_of(const Touch& touch) const { return w_.data() + touch.first_weight; }

  std::vector<Member> members_;
  std::vector<Simplex<dim>> simplices_;      // of one member after the other
  std::vector<std::int32_t> owner_;          // of each simplex
  std::vector<char> rim_;                    // of each vertex: 1 on the rim of its surface
  std::vector<Vector<dim>> start_, end_;     // of the vertices: accepted, and in the step
  std::vector<Vector<dim>> target_;          // at the end of the step
  std::vector<Neighbours<dim>> neighbours_;  // of each simplex
  FacetSearch<dim> search_;                  // as start_ is
  std::map<std::int64_t, std::vector<Memory>> memory_;  // by the point's id
  std::map<std::int64_t, Vector<dim>> offset_;          // of balls from their points, by id
  std::map<std::int64_t, Matrix<dim>> shape_;           // of deforming points that are near, by id
  double deepest_ = 0;  // touch of the accepted step, of all ranks [m]

  // the step under way
  std::optional<SoilSurface<dim>> soil_;
  std::vector<Watched> watched_;
  std::vector<WatchedGroup> watched_groups_;
  std::vector<Candidate> candidates_;  // the watched points that came near, as they did
  std::vector<double> N_;
  std::vector<Vector<dim>> grad_N_;
  std::vector<std::int32_t> nodes_;  // active ones
  std::vector<FacingSimplex> facing_;
  IndexTable<1> remembered_;                           // ids of points with memory or offset
  std::vector<const std::vector<Memory>*> memory_of_;  // of them, or none
  std::vector<const Vector<dim>*> offset_of_;          // of them, or none
  std::vector<KnownTouch<dim>> known_;                 // room for what a point touched
  std::vector<double> du_;                             // of the last add_forces
  std::vector<char> at_rest_;                          // of each member, in the step
  std::vector<std::int32_t> near_;                     // room for a list
  std::vector<Touch> touches_;
  std::vector<std::int32_t> by_owner_, first_of_;  // touches_ of one member after the other
  std::vector<Touch> opened_;  // places where balls that do not touch keep an offset
  std::vector<double> w_;      // of the touches
  std::vector<SurfaceFeature<dim>> features_;
  MPI_Comm comm_ = MPI_COMM_SELF;
  double force_weight_ = 1;
  double cell_size_ = 0;
  double dt_ = 0;
  double surface_motion_ = 0;  // largest of a vertex in the step [m]
  double margin_ = 0;          // at no speed: what is farther cannot be touched in the step [m]
  double share_ = 1;           // of the step at which end_ is
  bool has_substeps_ = false;  // the step has them
  std::vector<double> substep_forces_;  // on the vertices, mean over the substeps [N]
};

}  // namespace gabion::mpm
