// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <mpi.h>

#include <algorithm>
#include <span>
#include <string>
#include <vector>

#include "mpm_solver/grid/transfer.hpp"
#include "mpm_solver/points/point_totals.hpp"
#include "mpm_solver/step/equilibrium.hpp"
#include "mpm_solver/walls/inelastic_projection.hpp"

namespace gabion::mpm {

/// Changes of energy and momentum of the grid in one solved step, summed over nodes and ranks.
/// Forces are those of the instant that the scheme balances.
template <int dim>
struct StepBalance {
  double kinetic_before = 0;   ///< of the velocity mapped from the points, before walls act [J]
  double kinetic_after = 0;    ///< of v' [J]
  double wall_loss = 0;        ///< kinetic energy of the components that walls stop [J]
  double time_damping = 0;     ///< docs/theory/soil.md, (S28) [J]
  double body_work = 0;        ///< of gravity and other body forces [J]
  double sharing_loss = 0;     ///< elastic energy that share_volumes took [J]
  double quadrature_loss = 0;  ///< work on what CellQuadrature adds to the points' volumes [J]
  double boundary_work = 0;    ///< of contacts and of moving walls [J]
  Vector<dim> body_force = Vector<dim>::Zero();      ///< [N]
  Vector<dim> boundary_force = Vector<dim>::Zero();  ///< [N]
  Vector<dim> step_force = Vector<dim>::Zero();      ///< of contacts whose force is constant [N]
  Vector<dim> wall_force = Vector<dim>::Zero();      ///< from the residual before projection [N]
  Vector<dim> wall_kick = Vector<dim>::Zero();  ///< impulse that stops the mapped velocity [kg m/s]
  Vector<dim> wall_hold = Vector<dim>::Zero();  ///< force that stops the mapped acceleration [N]
  Vector<dim> wall_step_force = Vector<dim>::Zero();  ///< that stops step_force [N]
  /// Force that stops the step_force of the step before, on the nodes of this one [N].
  Vector<dim> wall_step_force_start = Vector<dim>::Zero();
};

/// Count what the walls did before the nodes moved.
/// @param pic_share  that the points take of the nodes' momentum
template <int dim>
void add_stop(const typename InelasticProjection<dim>::Totals& stop, double pic_share,
              StepBalance<dim>& step) {
  step.kinetic_before += stop.loss;
  step.wall_loss += stop.loss + stop.work;
  step.boundary_work += stop.work;
  step.wall_kick += stop.impulse + pic_share * stop.of_nodes;
}

/// Replace the parts of this rank by their sums. @note Collective.
template <int dim>
void sum_parts(MPI_Comm comm, StepBalance<dim>& step);

/// @param equilibrium  with the stresses of exactly this du (InternalForces::finish)
/// @pre   the points have not moved yet
/// @note  Collective.
template <int dim>
StepBalance<dim> step_balance(const Equilibrium<dim>& equilibrium, std::span<const double> du,
                              const NodalMotion<dim>& motion);

/// Balance of energy and momentum since the start (docs/theory/soil.md, (S28), (S29)).
template <int dim>
class Ledger {
 public:
  explicit Ledger(MPI_Comm comm) : comm_(comm) {}

  /// Start the balance at this state, with all sums at 0.
  void start(const MaterialPoints<dim>& points);

  /// @param dissipated  plastic work of this rank's points in the step [J]
  /// @param points      at the end of the step
  void add_step(const StepBalance<dim>& step, const NewmarkBossak& scheme, double dt,
                double dissipated, const MaterialPoints<dim>& points);
  /// @param energy  of all contacts at the end of the step
  void set_contact_energy(const ContactEnergy& energy) {
    contact_created_ += std::max(0.0, contact_.loss - energy.loss);
    contact_ = energy;
  }

  /// Account for points that were taken out of the accepted state: what they took along stays in
  /// the balance.
  /// @param points   without them
  /// @param inertia  sum of their m a without their contact forces that are constant in a step, of
  ///                 all ranks [N]
  void remove(const MaterialPoints<dim>& points, const Vector<dim>& inertia);
  /// Totals that removed points took along; front has no meaning.
  const PointTotals<dim>& removed() const { return removed_; }

  /// Totals over the points in the accepted state.
  const PointTotals<dim>& totals() const { return totals_; }

  /// Columns of probes.csv.
  static std::vector<std::string> names();
  std::vector<double> values() const;

  void visit_state(StateVisitor& visitor);

 private:
  /// An external force in the scheme: its part of M a, and its impulse so far.
  struct Force {
    Vector<dim> inertia = Vector<dim>::Zero();  // [N]
    Vector<dim> impulse = Vector<dim>::Zero();  // [kg m/s]
    void add_step(const Vector<dim>& mean, const NewmarkBossak& scheme, double dt);
  };
  /// Kinetic, elastic and dissipated energy, that of removed points included, less the work that
  /// came in.
  double own_energy() const;

  MPI_Comm comm_;
  PointTotals<dim> totals_, totals_start_;
  Force body_, boundary_, walls_;
  Vector<dim> wall_step_force_ = Vector<dim>::Zero();  // of the last step [N]
  PointTotals<dim> removed_;                           // front has no meaning
  ContactEnergy contact_;
  double contact_created_ = 0;  // sum of the steps in which its loss fell
  double plastic_ = 0, time_damping_ = 0, transfer_loss_ = 0, wall_loss_ = 0, quadrature_loss_ = 0;
  double body_work_ = 0, boundary_work_ = 0;
  double lowest_energy_ = 0, created_ = 0;
};

}  // namespace gabion::mpm
