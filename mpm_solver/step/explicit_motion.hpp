// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <functional>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "mpm_solver/contact/surfaces.hpp"
#include "mpm_solver/grid/point_inertia.hpp"
#include "mpm_solver/step/explicit_reach.hpp"
#include "mpm_solver/step/fractional_step.hpp"
#include "mpm_solver/stress/internal_forces.hpp"
#include "mpm_solver/walls/wall_conditions.hpp"

namespace gabion::mpm {

/// The explicit solution of one step: `count` equal substeps of central differences on the nodes
/// of the step, whose weights stay (docs/theory/soil.md, (S30) to (S33)),
///
///     u* = u + dt v + dt^2/2 A(f) ,  u' = u* + dt^2/2 A(F(u*)) ,  f = f_body - f_int(u)
///     v' = v + dt/2 [A(f) + A(f')] + dt A(F(u*)) ,  A(f) = Q W Q f
///
/// from v = Q v_i + w / step: W of PointInertia, Q and w of the walls, F of the contacts, whose
/// surfaces move evenly over the step. Pore water that drains moves the nodes, too
/// (FractionalStep). The stresses are evaluated once a substep and continue from those of the
/// substep before. A solution with as many substeps as the one before it evaluates only what the
/// interfaces can reach (ExplicitReach), with the bits of a whole solution. Refers to its parts;
/// valid for one step.
template <int dim>
class ExplicitMotion {
 public:
  struct Parts {
    StressParts<dim> stress;
    const BackgroundGrid<dim>& grid;
    SofteningAverages averages;  ///< of the bodies
    const WallConditions<dim>& walls;
    Surfaces<dim>& surfaces;
    double cell_size;
    double dt;  ///< of the step [s]
    bool average_volumes;
    double largest_courant;  ///< that contacts may lead to, see squared_courant
    /// Body force at a share of the step, num_nodes x dim [N].
    std::function<std::vector<double>(double share)> body_force;
    const WaterOfStep<dim>* water = nullptr;  ///< that drains; null: there is none
  };
  explicit ExplicitMotion(const Parts& parts);

  /// Results of the substeps, summed over them; works of the nodes that this rank owns, fields
  /// num_nodes x dim.
  struct Result {
    std::vector<double> du;          ///< in the step [m]
    std::vector<double> v;           ///< mapped back from the points, at the end [m/s]
    std::vector<double> impulse;     ///< that reaches the nodes [N s]
    std::vector<double> a;           ///< at the end, f / m [m/s^2]
    std::vector<double> wall_force;  ///< mean force that the walls take [N], before they act
    double internal_work = 0, body_work = 0, contact_work = 0, wall_work = 0;  // [J]
    double plastic_work = 0;                            ///< of this rank's points [J]
    Vector<dim> body_impulse = Vector<dim>::Zero();     // [N s]
    Vector<dim> contact_impulse = Vector<dim>::Zero();  // [N s]
    double contact_rate = 0;     ///< StableStep's, largest of the substeps [1/s^2]
    std::int64_t evaluated = 0;  ///< stresses of this rank's points, in all substeps
    bool within_reach = false;   ///< ExplicitReach, of all that would be evaluated else
  };

  /// Solve the step for the present place of the surfaces.
  /// @param soil_dt  StableStep::of_soil [s]
  /// @param repeats  solutions for other places of the interfaces are to be expected after this one
  /// @returns false where a contact became too stiff for a substep of this length: only
  ///          contact_rate has a meaning then
  /// @throws ConvergenceError  a point would be squeezed below min_J_ratio; values are not finite
  /// @note Collective.
  bool solve(int count, double soil_dt, bool repeats = false);

  const Result& result() const { return result_; }
  /// Mapped velocity with the walls, num_nodes x dim [m/s].
  const std::vector<double>& start_velocity() const { return v_start_; }
  const PointInertia<dim>& inertia() const { return inertia_; }
  /// Pore water that drains, in the last solution; null: there is none.
  FractionalStep<dim>* water() const { return water_.get(); }

 private:
  enum class Outcome { solved, too_stiff, beyond_reach };
  /// Substep k of `count`.
  struct Substep {
    int k, count;
    double share() const { return static_cast<double>(k + 1) / count; }
    double dt(double step) const { return step / count; }
  };
  /// Forces and acceleration at one end of a substep.
  struct Forces {
    std::vector<double> body, internal;  // [N]
    std::vector<double> A;               // [m/s^2]
  };
  void respond(std::span<const double> f, std::vector<double>& A) const;
  void set_acceleration(Forces& forces) const;
  void set_acceleration_within(int k, Forces& forces) const;
  void find_lasting();
  bool add_contact(std::span<const double> u, double share, double dt, double soil_dt);
  const StressParts<dim>& with_path();
  void begin_path(int count);
  void advance_path(int k);
  Outcome run(int count, double soil_dt);
  Outcome do_substep(const Substep& substep, double soil_dt, Forces& before);
  void find_reach();
  bool evaluate(int k, RefusedPoint& worst);
  Forces forces_at(const Substep& substep);
  void keep(const Forces& forces);
  void add_works(std::span<const double> move, const Forces& before, const Forces& after,
                 double dt);
  void finish(const Forces& last);

  Parts parts_;
  StepContext<dim> context_;         // of the substeps
  MaterialPath<dim> path_;           // StressParts::path; empty: nothing depends on it
  std::vector<Symmetric<dim>> tau_;  // at the start of the current substep [Pa]
  std::vector<double> plastic_;      // plastic_density of each entry in it [J/m^3]
  GroupForces<dim> kept_;            // StressParts::kept
  PointInertia<dim> inertia_;
  std::unique_ptr<FractionalStep<dim>> water_;
  InternalForces<dim> internal_;
  std::vector<double> v_start_;
  Forces start_;
  bool may_touch_ = false;
  bool touches_ = false;                        // in the current substep, on any rank
  std::vector<double> F_, A_F_;                 // of the contacts
  std::vector<double> A_lasting_;               // of their force that lasts; empty where none does
  std::vector<double> raw_;                     // impulse of all forces but those of walls
  std::optional<ExplicitReach<dim>> reach_;     // none: solutions do not repeat
  bool within_ = false;                         // this solution evaluates only what is in reach
  std::vector<double> star_, move_, foreseen_;  // room for those of a substep
  Result result_;
};

}  // namespace gabion::mpm
