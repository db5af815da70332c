// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <span>
#include <string>
#include <vector>

#include "mpm_solver/contact/contact.hpp"
#include "mpm_solver/contact/group_memory.hpp"
#include "mpm_solver/contact/group_nodes.hpp"

namespace gabion::mpm {

/// Bodies of different groups against each other (docs/theory/bodies.md), at the contact nodes, on
/// which both weigh:
///
///     g = g_0 + n . (du_B - du_A) ,  f_B = A Q t ,  f_A = -A Q t
///
/// with the normal n, the gap g_0 and the area A of find_contact_nodes, and t of ContactLaw. A node
/// that was closed in the step before keeps its gap and its area, which follow the points as far as
/// the soil moves through the cells. The slip of a new node is the mean of those of the closed ones
/// around it. None of that gives energy: keep_stored_energy. The force of a step is constant in it
/// (NewmarkBossak::step_force_weight). A member is a pair of groups. Refers to the groups. @pre one
/// rank
template <int dim>
class GroupContact final : public WholeContact<dim>, public ContactSubsteps<dim> {
 public:
  /// @param num_places  nodes of the grid
  GroupContact(const BodyGroups& groups, std::int32_t num_places)
      : groups_(groups),
        num_places_(num_places),
        accepted_(groups.pairs.size(), Vector<dim>::Zero()),
        resultants_(accepted_) {}

  void begin_step(const SoilSurface<dim>& soil) override;
  bool can_touch(std::size_t = 0) const override { return !contacts_.empty(); }
  bool symmetric() const override;
  void append_cells(std::vector<std::int32_t>& offsets,
                    std::vector<std::int32_t>& nodes) const override;

  void set_displacement(std::span<const double>, std::size_t = 0) override {}
  void add_forces(std::span<const double> du, std::span<double> r, BlockMatrix<dim>* K) override;
  bool is_step_force() const override { return true; }
  void add_step_force_change(std::span<double> f) const override;

  ContactSubsteps<dim>& substeps() override { return *this; }
  void begin_substeps() override;
  void add_substep(std::span<const double> move, double share) override;
  void add_stiffness_sums(std::span<double> sums) const override;

  std::vector<double> forces_on_structure(std::size_t = 0) const override { return {}; }
  /// None: the forces act between bodies.
  ContactResultant<dim> resultant(std::size_t = 0) const override { return {}; }
  /// Forces of the first groups of the pairs on the second ones in the accepted step, its mean [N].
  const std::vector<Vector<dim>>& forces() const { return accepted_; }
  double work_on_soil(std::span<const double> du) const override;
  ContactCounts counts(std::size_t pair) const override;
  double approach_step(double dt, double margin) const override;

  void accept() override;
  ContactEnergy energy() const override { return energy_; }
  bool drop(std::size_t, bool dropped) override;
  ContactFields<dim> fields(const MaterialPoints<dim>&, double, std::size_t = 0) const override {
    return {{}, 0};
  }
  std::span<const ContactMark<dim>> marks(std::size_t = 0) const override { return {}; }
  /// @throws Error  the state is of a run with other groups
  void visit_state(StateVisitor& visitor, const std::string& prefix) override;

 private:
  /// A contact node in the current step.
  struct ContactNode {
    GroupNode<dim> node;
    Matrix<dim> frame = Matrix<dim>::Identity();   // normal first
    bool goes_on = false;                          // it was closed when the step began
    Vector<dim> old_slip = Vector<dim>::Zero();    // elastic, then
    Vector<dim> old_force = Vector<dim>::Zero();   // of the step before
    Vector<dim> path = Vector<dim>::Zero();        // of the second group against the first
    Vector<dim> middle_way = Vector<dim>::Zero();  // mean of both
    double gap = 0;
    Vector<dim> slip = Vector<dim>::Zero();       // before the friction limit
    double slip_share = 1, slip_share_slope = 0;  // of the displacement path; over the gap [1/m]
    ContactTraction<dim> traction{};              // in the frame
    Vector<dim> force = Vector<dim>::Zero();      // on the second group [N]
  };
  /// A force of the step before at a node that no longer is a contact node.
  struct LeftForce {
    std::int32_t first, second;
    Vector<dim> force;
  };

  ContactLaw law_of(const ContactNode& contact) const;
  void follow(ContactNode& contact) const;
  void go_on_from_neighbours(const BackgroundGrid<dim>& grid, ContactNode& contact) const;
  double stored_at_start(const ContactNode& contact) const;
  void keep_stored_energy();
  void find_left_forces(const SoilSurface<dim>& soil, const GroupsAtNodes<dim>& at_nodes);
  std::string text_of_overlap(const SoilSurface<dim>& soil, const ContactNode& contact) const;
  std::string text_of_corner(const SoilSurface<dim>& soil, const GroupNode<dim>& node) const;
  void warn_once(const std::string& text, bool& said) const;
  void move(std::span<const double> du, ContactNode& contact) const;
  void set_slip(ContactNode& contact) const;
  void add_stiffness(const ContactNode& contact, const Matrix<dim>& slope,
                     BlockMatrix<dim>& K) const;
  void add_old_forces(double share, std::span<double> field) const;
  /// Energy in the springs of closed nodes, by direction, and what they remember.
  struct Springs {
    std::vector<RememberedNode<dim>> nodes;
    std::vector<double> pressed;        // of each node [J]
    double normal = 0, tangential = 0;  // sums [J]
  };
  void pay_back(Springs& springs) const;

  const BodyGroups& groups_;
  std::int32_t num_places_;
  GroupMemory<dim> own_;  // of the nodes that this rank carried
  ContactEnergy energy_;
  double stored_slip_ = 0;             // part of the stored energy in tangential springs [J]
  std::vector<Vector<dim>> accepted_;  // forces()
  bool said_overlap_ = false, said_corner_ = false;

  // the current step
  MPI_Comm comm_ = MPI_COMM_SELF;
  GroupMemory<dim> memory_;  // own_ of all ranks, together
  std::vector<ContactNode> contacts_;
  std::vector<LeftForce> left_;
  double force_weight_ = 1, cell_size_ = 0, strength_factor_ = 1;
  bool has_substeps_ = false;
  double normal_work_ = 0, tangential_work_ = 0;  // of the bodies on the contact in substeps [J]
  std::vector<Vector<dim>> resultants_;           // of the pairs, means over the substeps [N]
};

}  // namespace gabion::mpm
