// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <mpi.h>

#include <vector>

#include "common/mechanics/newton/newton.hpp"
#include "common/mechanics/time_integration/newmark.hpp"
#include "mpm_solver/contact/contact.hpp"
#include "mpm_solver/grid/basis.hpp"
#include "mpm_solver/grid/grid_nodes.hpp"
#include "mpm_solver/small_cuts/ghost_stiffness.hpp"
#include "mpm_solver/stress/internal_forces.hpp"
#include "mpm_solver/walls/wall_conditions.hpp"

namespace gabion::mpm {

/// Balance of momentum of the active nodes at the end of a step,
///
///     r_i = f'_i + force_memory f_i - m_i inertia(a'_i, a_i) ,
///     f'_i = m_i g + f_body,i - sum_p V0_p P_p grad N_ip + f_contact,i +
///            f_ghost,i
///
/// with the weights of NewmarkBossak and P the first Piola-Kirchhoff stress relative to the
/// configuration at the start of the step. f_i is that of the accepted stresses on the nodes of
/// this step; it is evaluated only where it has a weight. In quasi-static analysis inertia is left
/// out: r_i = f'_i. Refers to the parts of a solver; valid for one step.
template <int dim>
class Equilibrium final : public NewtonProblem<dim> {
 public:
  struct Parts {
    MPI_Comm comm;
    const BackgroundGrid<dim>& grid;
    const std::vector<Body<dim>>& bodies;
    const MaterialPoints<dim>& points;
    const PointWeights<dim>& weights;
    const GridNodes<dim>& nodes;
    const WallConditions<dim>& walls;
    const Contacts<dim>& contacts;
    TrialPoints<dim>& trial;
    const NewmarkBossak& scheme;
    Vector<dim> gravity;        ///< at the end of the step [m/s^2]
    Vector<dim> gravity_start;  ///< at its start
    double cell_size;
    double same_strain;  ///< see InternalForces
    double dt;
    bool with_inertia = true;             ///< false: quasi-static
    bool repeats = true;                  ///< several solutions, as in a coupled step
    bool nearly_linear = false;           ///< one Newton iteration likely suffices
    std::span<const double> f_body = {};  ///< besides gravity [N], num_nodes x dim; empty: none
    std::span<const double> f_body_start = {};  ///< that force at the start of the step
    /// Forces of pore water that drains on the skeleton [N], num_nodes x dim; empty: none. It may
    /// change between evaluations.
    std::span<const double> f_pore = {};
    bool average_volumes = false;                        ///< F-bar, see AveragedForces
    const GhostStiffness<dim>* ghost = nullptr;          ///< null: none
    std::span<const MaterialLaw<dim>* const> laws = {};  ///< StressParts::laws
    SofteningAverages averages = {};                     ///< of the bodies
  };
  explicit Equilibrium(const Parts& parts);

  const SharedNodes& shared() const override { return parts_.nodes.shared; }
  Evaluation evaluate(std::span<const double> du, std::span<double> r,
                      BlockMatrix<dim>* K) override;
  /// The balance linearised at du = 0, for a guess that spreads the motion of walls over the soil
  /// instead of leaving it to the cells beside them: r(0) - K(0) w, projected, and K(0).
  /// @param wall_step  w, zero but for the held directions of wall nodes
  Evaluation linearise(std::span<const double> wall_step, std::span<double> r, BlockMatrix<dim>& K);
  /// The stiffness of points that yielded since the solution began (YieldingPoints).
  bool regularise(double share) override;
  /// Add stiffness in quasi-static analysis with contact, where bodies may have to move before a
  /// surface holds them.
  bool support(bool on) override;
  double increment_scale() const override { return parts_.cell_size; }
  std::string describe_node(std::size_t i) const override;
  /// Number, body, position, strain increment, volume ratio and yield region of the material point
  /// with the largest |E| (point_motion.hpp).
  std::string describe_worst_point(std::span<const double> du) const override;
  /// Number, body and place of a material point, for messages.
  std::string describe_point(std::int32_t p) const;

  /// Begin a new solution, with other interface values.
  void begin_solution() {
    first_evaluation_ = true;
    internal_.begin_solution();
  }
  InternalForces<dim>& internal_forces() { return internal_; }
  const InternalForces<dim>& internal_forces() const { return internal_; }
  const Parts& parts() const { return parts_; }
  /// Mass that inertia and gravity act on [kg], num_nodes: the lumped one with the floor.
  const std::vector<double>& inertia_mass() const { return m_; }

  /// Cells of the matrix pattern, as lists of active nodes: cells with points of this rank, then
  /// the cells with contact, then the facets of the ghost stiffness.
  void pattern(std::vector<std::int32_t>& offsets, std::vector<std::int32_t>& nodes) const;

  /// Nodal velocity at the start of the step with the wall conditions, num_nodes x dim.
  const std::vector<double>& start_velocity() const { return v_; }
  const std::vector<double>& start_acceleration() const { return a_; }

  /// Force of the soil on each wall in the state of the last evaluation [N]. @note Collective.
  std::vector<Vector<dim>> wall_forces() const;
  /// F - F_o of the step forces of all contacts, see NewmarkBossak::step_force_weight: num_nodes x
  /// dim [N]; empty where no contact has one. @note Collective.
  std::vector<double> step_force_change() const;

 private:
  void remember_start_forces();
  void subtract_wall_step(const BlockMatrix<dim>& K, std::span<double> r) const;
  /// Squares over the nodes that this rank owns, then over all nodes.
  struct Sums {
    double internal = 0, external = 0, inertial = 0, stopping = 0, residual = 0;
    double inadmissible = 0, neighbours = 0;  // ranks with such a state, such a matrix
  };
  void sum_forces(std::span<const double> du, std::span<double> r, BlockMatrix<dim>* K);
  void add_weight(std::span<double> r, Sums& sums) const;
  void add_inertia(std::span<const double> du, std::span<double> r, BlockMatrix<dim>* K,
                   Sums& sums) const;
  Evaluation assess(Sums sums, const RefusedPoint& worst);

  Parts parts_;
  StepContext<dim> context_;  // of the step, for internal_
  InternalForces<dim> internal_;
  bool first_evaluation_ = true;       // of a solution
  bool supported_ = false;             // K holds a little stiffness everywhere
  double regularisation_ = 0;          // share of the stiffness that K holds besides the tangent
  std::vector<double> v_, a_;          // walls applied
  std::vector<double> m_;              // nodal mass; with inertia not below the floor
  std::span<const double> wall_step_;  // see linearise(); empty otherwise
  std::vector<double> r_before_walls_;
  std::vector<double> f_sum_;    // internal forces, of all ranks
  std::vector<double> f_start_;  // force_memory f, empty where it is 0
};

}  // namespace gabion::mpm
