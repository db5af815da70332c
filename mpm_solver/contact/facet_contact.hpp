// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <cmath>
#include <map>
#include <optional>

#include "mpm_solver/contact/contact.hpp"
#include "mpm_solver/contact/facet_hash.hpp"
#include "mpm_solver/contact/way_at_rest.hpp"
#include "mpm_solver/contact/way_out.hpp"
#include "mpm_solver/grid/surface_values.hpp"

namespace gabion::mpm {

/// Material points against the facets of a surface (docs/theory/interface.md). A point is a ball of
/// radius R, as deep as the point lies in the cell that it was laid in; it touches the surface
/// where the distance of its centre y has a local minimum x_m below R:
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
/// Each rank carries its own material points, and looks as far ahead as all ranks together would.
/// @see Kane, Repetto, Ortiz, Marsden (1999) for the time law; Bird et al. (2024) for points and
///      facets
template <int dim>
class FacetContact final : public Contact<dim> {
 public:
  FacetContact(const ContactSettings<dim>& settings, const FacetSettings& method);

  void begin_step(const SoilSurface<dim>& soil) override;
  bool can_touch() const override { return may_touch_; }
  bool symmetric() const override { return false; }
  /// A point's nodes are those of its group already.
  void append_cells(std::vector<std::int32_t>&, std::vector<std::int32_t>&) const override {}

  void set_displacement(std::span<const double> displacement) override;
  void add_forces(std::span<const double> du, std::span<double> r, BlockMatrix<dim>* K) override;
  bool is_step_force() const override { return true; }
  void add_step_force_change(std::span<double> f) const override;
  Vector<dim> step_force_on(std::span<const std::int64_t> ids) const override;

  void begin_substeps() override;
  void set_share(double share) override;
  void add_substep(std::span<const double> move, double share) override;
  void add_stiffness_sums(std::span<double> sums) const override;

  std::vector<double> forces_on_structure() const override;
  typename Contact<dim>::Resultant resultant() const override;
  double work_on_soil(std::span<const double> du) const override;
  ContactCounts counts() const override;
  double approach_step(double dt, double margin) const override;
  double allowed_way() const override { return watched_ - surface_motion_; }

  void begin_at_rest(const SoilAtRest<dim>& rest) override;
  void accept() override;
  ContactEnergy energy() const override { return energy_; }
  ContactFields<dim> fields(const MaterialPoints<dim>& points, double reach) const override;
  void give(std::span<const std::int64_t> ids, Packet& packet) override;
  void take(Packet& packet) override;
  void visit_state(StateVisitor& visitor, const std::string& prefix) override;

 private:
  /// A touch goes on in the next step where its normal turned by less than 60 degrees.
  static constexpr double same_normal = 0.5;
  /// Soil that was laid at a side nearer to the surface than this share of a cell rests on it,
  static constexpr double touching_share = 0.01;
  /// where the side is turned against the surface by no more than the angle of this cosine.
  static constexpr double along_side = 0.99;

  /// What a point remembers of a place where it touched in the accepted state.
  struct Memory {
    Vector<dim> normal = Vector<dim>::Zero();
    Vector<dim> force = Vector<dim>::Zero();  // of the last step, on the soil [N]
    Vector<dim> slip = Vector<dim>::Zero();  // elastic; along -normal what the touch began with [m]
    double part = 1;                         // of the tangential stiffness, in which the slip is

    double begun() const { return -normal.dot(slip); }
    Vector<dim> tangential() const { return slip + begun() * normal; }
  };
  /// A point that may touch in the step.
  struct Candidate {
    std::int64_t id = 0;
    std::int32_t body = 0;
    Vector<dim> x = Vector<dim>::Zero();          // of the ball
    Vector<dim> offset = Vector<dim>::Zero();     // of the ball from its point
    Matrix<dim> shape = Matrix<dim>::Identity();  // |shape^T n| is R in direction n
    double volume = 0;
    double modulus = 0;
    bool deforms = false;  // the ball is strained like the soil; else it is rigid
    double distance = 0;   // to the nearest facet at the start, 0 behind one
    std::int32_t first_value = 0, num_values = 0;
    std::int32_t first_facing = 0, num_facing = 0;
    SurfaceFeature<dim> nearest{};              // at the start
    Vector<dim> motion = Vector<dim>::Zero();   // in the step
    Matrix<dim> H = Matrix<dim>::Zero();        // its gradient
    std::optional<SurfaceValues<dim>> surface;  // none: functions are continued
    const std::vector<Memory>* memory = nullptr;
  };
  /// A place where a point touches.
  struct Touch {
    std::int32_t candidate = 0;
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
    std::vector<double> forces;  // on the vertices [N]
    typename Contact<dim>::Resultant resultant;
    double normal_work = 0, tangential_work = 0;  // of soil and surface on the contact [J]
    int closed = 0;                               // places that carried force, most of a substep
  };

  ContactLaw law_of(const Candidate& c, double part) const;
  void add_vertex_forces(const Touch& touch, double share, std::span<double> forces) const;
  void find_bounds();
  void add_candidates(const SoilSurface<dim>& soil, const FacetHash<dim>& hash);
  void add_values(const SoilSurface<dim>& soil, const CellGroup& group, std::int32_t entry);
  void list_facing(Candidate& candidate, std::span<const std::int32_t> near, double margin);
  void drop_far_side(const Candidate& candidate, const Vector<dim>& normal);
  double radius(const Candidate& c, const Vector<dim>& n) const { return (c.shape * n).norm(); }
  double mean_radius(const Candidate& c) const { return c.shape.norm() / std::sqrt(double{dim}); }
  FacingSurface<dim> surface_of(const Candidate& c, std::span<const Vector<dim>> end) const;
  Vector<dim> surface_motion(const SurfaceFeature<dim>& feature) const;
  ContactMark<dim> mark_of(const Touch& touch) const;
  void add_old_forces(double share, std::span<double> field) const;
  void visit_memory(StateVisitor& visitor, const std::string& prefix);
  void find_touches(std::int32_t candidate, std::span<const double> du);
  Touch touch_at(const Candidate& c, const SurfaceFeature<dim>& feature,
                 std::span<const double> du);
  static double most_begun(const Candidate& c);
  const Memory* remembered(const Candidate& c, const Vector<dim>& n) const;
  std::vector<RestingPlace<dim>> places_at_rest(const Candidate& c, const SoilAtRest<dim>& rest);
  void lay_on(std::span<const RestingPlace<dim>> places, Candidate& c);
  void remember_shear(const Touch& touch, std::span<const RestingPlace<dim>> places);
  void remember_touches();
  Memory memory_of(const Touch& touch) const;
  double stored_in_slip(const Touch& touch, const Memory& memory) const;
  double stored_in_depth(const Touch& touch) const;
  Vector<dim> offset_of(std::int64_t id) const;
  Matrix<dim> shape_of(std::int64_t id, double depth) const;
  double offset_after(const Touch& touch) const;
  void accept_offsets();
  void set_slip(const Candidate& c, Touch& touch) const;
  static void follow_part(Touch& touch);
  void share_depths(std::size_t first);
  Vector<dim> gap_slope(const Touch& touch, std::int32_t value) const;
  void add_stiffness(const Touch& touch, const Matrix<dim>& slope, BlockMatrix<dim>& K) const;
  void surface_weights(const Candidate& c, const Vector<dim>& n, double* w) const;
  void scatter(const Candidate& c, const double* w, const Vector<dim>& f,
               std::span<double> field) const;
  const double* weights_of(const Touch& touch) const { return w_.data() + touch.first_weight; }

  ContactMode mode_;
  double friction_;
  FacetSettings method_;
  ContactSurface<dim> surface_;
  std::vector<Simplex<dim>> simplices_;
  std::vector<Vector<dim>> start_, end_;    // of the vertices: accepted, and in the step
  std::vector<Vector<dim>> target_;         // at the end of the step
  std::vector<SimplexBounds<dim>> bounds_;  // at start_; empty: not known
  double size_ = 0;                         // of the largest simplex [m]
  std::map<std::int64_t, std::vector<Memory>> memory_;  // by the point's id
  std::map<std::int64_t, Vector<dim>> offset_;          // of balls from their points, by id
  std::map<std::int64_t, Matrix<dim>> shape_;           // of deforming points that are near, by id
  std::vector<ContactMark<dim>> marks_;                 // of the accepted step
  double last_motion_ = 0;                              // surface_motion_ of the accepted step
  double deepest_ = 0;  // touch of the accepted step, of all ranks [m]

  // the step under way
  std::vector<Candidate> candidates_;
  std::vector<double> N_;
  std::vector<Vector<dim>> grad_N_;
  std::vector<std::int32_t> nodes_;  // active ones
  std::vector<FacingSimplex> facing_;
  std::vector<Touch> touches_;
  std::vector<Touch> opened_;  // places where balls that do not touch keep an offset
  std::vector<double> w_;      // of the touches
  std::vector<SurfaceFeature<dim>> features_;
  MPI_Comm comm_ = MPI_COMM_SELF;
  double force_weight_ = 1;
  double cell_size_ = 0;
  double dt_ = 0;
  double surface_motion_ = 0;  // largest of a vertex in the step [m]
  double watched_ = 0;  // beyond its speed soil and surface may move by this much together [m]
  double margin_ = 0;   // at no speed: what is farther cannot be touched in the step [m]
  bool may_touch_ = false;
  double share_ = 1;                  // of the step at which end_ is
  std::optional<Substeps> substeps_;  // none: the step has none
  ContactEnergy energy_;              // accepted
  double stored_slip_ = 0;            // part of its energy in tangential springs
};

}  // namespace gabion::mpm
