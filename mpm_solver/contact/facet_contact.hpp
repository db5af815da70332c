// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>

#include "mpm_solver/contact/penetration_at_rest.hpp"
#include "mpm_solver/contact/point_search.hpp"

namespace gabion::mpm {

/// Material points against the facets of surfaces (docs/theory/interface.md), its members. A point
/// has a contact sphere of radius R, as deep as the point lies in the cell that it was laid in; the
/// sphere touches the surface where the distance of its centre y has a local minimum x_m below R:
///
///     g = (y - x_m) . n - R + n . sum_i (w_i - N_i) du_i ,  y = x_p + o + sum_i N_i du_i ,
///     d = o - R n ,  w_i = N_i(x_p) + grad N_i(x_p) . d ,
///     f_i = w_i A t ,  on vertex v  -phi_v A t ,  A = V / (2 R)
///
/// w continues the functions of the point to its surface, those of gimp and bspline as
/// SurfaceValues say: linear fields are met exactly, and force and place are those of both sides.
/// The sphere of an elastic body is strained with it; the offset o carries what else the surface
/// goes against the centre from step to step. Penetration and friction follow ContactLaw; in inside
/// corners depths are those of ShortestExit. A contact point of soil that was at rest under stress
/// when the run began has the depth of that stress from the beginning: its gap is less by it. A
/// point that was open slips from the moment when it touches, its path in the step being straight.
/// The force F of a step is constant in it (NewmarkBossak::step_force_weight): contact then takes
/// energy or keeps it, at any stiffness and dt.
///
/// The members are one surface for the search: where their rims meet, nothing but the friction and
/// the owner of the forces changes. Where two of them meet in a corner each pushes for itself
/// (surface_features.hpp). PointSearch finds the places, ContactMemory has what is remembered of
/// them, and the contact points are here.
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
  bool can_touch(std::size_t member = 0) const override { return search_.can_touch(member); }
  bool symmetric() const override { return false; }
  /// A point's nodes are those of its group already.
  void append_cells(std::vector<std::int32_t>&, std::vector<std::int32_t>&) const override {}

  void set_displacement(std::span<const double> displacement, std::size_t member = 0) override {
    surface_.set_displacement(displacement, member);
  }
  void add_forces(std::span<const double> du, std::span<double> r, BlockMatrix<dim>* K) override;
  bool is_step_force() const override { return true; }
  void add_step_force_change(std::span<double> f) const override;
  Vector<dim> step_force_on(std::span<const std::int64_t> ids) const override {
    return memory_.force_on(ids, members_.size());
  }

  void add_lasting_forces(std::span<double> f) const override;
  void begin_substeps() override;
  void set_share(double share) override { surface_.set_share(share); }
  void add_substep(std::span<const double> move, double share) override;
  void add_stiffness_sums(std::span<double> sums) const override;
  void mark_touched(std::span<char> nodes, std::size_t member = 0) const override;

  std::vector<double> forces_on_structure(std::size_t member = 0) const override;
  typename Contact<dim>::Resultant resultant(std::size_t member = 0) const override;
  std::size_t num_members() const override { return members_.size(); }
  double work_on_soil(std::span<const double> du) const override;
  ContactCounts counts(std::size_t member = 0) const override;
  double approach_step(double dt, double margin) const override {
    return search_.approach_step(dt, margin);
  }
  double allowed_motion(std::size_t member = 0) const override {
    return search_.allowed_motion(member);
  }

  void begin_at_rest(const SoilAtRest<dim>& rest) override;
  std::span<const Vector<dim>> accepted_vertices(std::size_t member) const override {
    if (surface_.member(member).dropped) return {};
    return surface_.start_of(member);
  }
  void accept() override;
  ContactEnergy energy() const override;
  bool drop(std::size_t member, bool dropped) override;
  ContactFields<dim> fields(const MaterialPoints<dim>& points, double reach,
                            std::size_t member = 0) const override;
  std::span<const ContactMark<dim>> marks(std::size_t member = 0) const override {
    return members_[member].marks;
  }
  void give(std::span<const std::int64_t> ids, Packet& packet) override {
    memory_.give(ids, packet);
  }
  void take(Packet& packet) override { memory_.take(packet); }
  void visit_state(StateVisitor& visitor, const std::string& prefix) override;

 private:
  using Candidate = ContactCandidate<dim>;
  using Remembered = RememberedContact<dim>;
  /// Share of an explicit step's own force, beyond the force that lasts, that is added to it.
  static constexpr double lasting_share = 0.2;
  /// Soil that was laid at a side nearer to the surface than this share of a cell rests on it,
  static constexpr double touching_share = 0.01;
  /// where the side is turned against the surface by no more than the angle of this cosine.
  static constexpr double along_side = 0.99;

  /// A place where a contact sphere meets the surface.
  struct ContactPoint {
    std::int32_t candidate = 0;
    std::int32_t owner = 0;  // the member that has the feature
    SurfaceFeature<dim> feature;
    double radius = 0, area = 0;
    double initial_penetration = 0;          // [m]
    double gap = 0;                          // less that depth
    std::int32_t first_weight = 0;           // of w, one for each value of the candidate
    std::array<std::int32_t, dim> others{};  // those of its material point, itself too
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
  /// What one of the surfaces does to the soil.
  struct Member {
    ContactMode mode = ContactMode::contact;
    double friction = -1, drag = 0;
    FrictionFall weakening{};
    bool drained = false;
    FacetSettings method;
    std::vector<ContactMark<dim>> marks;  // of the accepted step
    ContactEnergy energy;                 // accepted
    double stored_slip = 0;               // part of its energy in tangential springs
    Substeps substeps;                    // of the step under way
  };

  void order_contacts();
  std::span<const std::int32_t> contacts_of(std::size_t owner) const {
    return std::span(by_owner_).subspan(first_of_[owner], first_of_[owner + 1] - first_of_[owner]);
  }
  const Candidate& candidate(const ContactPoint& contact) const {
    return search_.candidates()[contact.candidate];
  }
  const double* weights_of(const ContactPoint& contact) const {
    return w_.data() + contact.first_weight;
  }

  // The law at a contact point.
  ContactLaw law_of(const Candidate& c, std::int32_t owner, double part) const;
  // The same in the step under way: with the pore pressure and the speed along the surface.
  ContactLaw law_now(const ContactPoint& contact) const;
  // The pore pressure at the surface: none where it is drained, else that without flow along its
  // normal.
  double pore_pressure_at(const ContactPoint& contact) const;
  void add_contacts(std::int32_t candidate, std::span<const SurfaceFeature<dim>> features,
                    std::span<const double> du);
  ContactPoint contact_at(const Candidate& c, const SurfaceFeature<dim>& feature,
                          std::span<const double> du);
  void set_slip(const Candidate& c, ContactPoint& contact) const;
  static void follow_part(ContactPoint& contact);
  void share_depths(const Candidate& c, std::size_t first);
  void share_in_corners(const Candidate& c, std::size_t first);
  Vector<dim> gap_slope(const ContactPoint& contact, std::int32_t value) const;
  Matrix<dim> slope_by_speed(const ContactPoint& contact) const;
  void add_stiffness(const ContactPoint& contact, const Matrix<dim>& slope,
                     BlockMatrix<dim>& K) const;
  void add_old_forces(std::int32_t owner, double share, std::span<double> field) const;
  void add_remembered(std::int32_t owner, Vector<dim> Remembered::*force, double share,
                      std::span<double> field) const;
  void add_vertex_forces(const ContactPoint& contact, double share, std::span<double> forces) const;

  // Soil at rest when the run begins.
  std::vector<RestingPlace<dim>> places_at_rest(Candidate& c, const SoilAtRest<dim>& rest);
  void set_off(std::span<const RestingPlace<dim>> places, Candidate& c);
  void remember_depths(std::span<const RestingPlace<dim>> places, Candidate& c);
  void remember_shear(const ContactPoint& contact, std::span<const RestingPlace<dim>> places);
  void remember_contacts(const SoilAtRest<dim>& rest);

  // The accepted state.
  void accept_contacts(std::size_t owner);
  void accept_offsets();
  double offset_after(const ContactPoint& contact) const;
  Remembered memory_of(const ContactPoint& contact) const;
  Vector<dim> lasting_force(const ContactPoint& contact) const;
  double stored_in_slip(const ContactPoint& contact, const Remembered& memory) const;
  double stored_in_depth(const ContactPoint& contact) const;
  ContactMark<dim> mark_of(const ContactPoint& contact) const;

  std::vector<Member> members_;
  JointSurface<dim> surface_;
  ContactMemory<dim> memory_;
  PointSearch<dim> search_{surface_, memory_};
  double deepest_ = 0;  // penetration in the accepted step, of all ranks [m]

  // the step under way
  std::vector<ContactPoint> contacts_;
  std::vector<std::int32_t> by_owner_, first_of_;  // contacts_ of one member after the other
  std::vector<ContactPoint> opened_;  // places where spheres that do not touch keep an offset
  std::vector<double> w_;             // of the contact points
  MPI_Comm comm_ = MPI_COMM_SELF;
  double force_weight_ = 1;
  double cell_size_ = 0;
  double dt_ = 0;
  bool has_substeps_ = false;           // the step has them
  std::vector<double> substep_forces_;  // on the vertices, mean over the substeps [N]
};

}  // namespace gabion::mpm
