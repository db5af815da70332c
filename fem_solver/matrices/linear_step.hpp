// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <list>
#include <memory>
#include <optional>

#include "common/base/timer.hpp"
#include "common/mechanics/time_integration/step_force_filter.hpp"
#include "common/run/state.hpp"
#include "fem_solver/matrices/linear_model.hpp"
#include "fem_solver/matrices/symmetric_factor.hpp"

namespace gabion::fem {

/// Forces on the unknowns.
struct LinearForces {
  Eigen::VectorXd end;   ///< at the end of the step, loads included [N]
  Eigen::VectorXd step;  ///< means over the step [N]
};

/// Everything that the next step depends on.
struct LinearState {
  double time = 0;    ///< [s]
  Eigen::VectorXd u;  ///< displacement [m]
  Eigen::VectorXd v;  ///< velocity [m/s]
  Eigen::VectorXd a;  ///< acceleration [m/s^2]
  /// Velocity and acceleration by Newmark's formulas from the displacements alone, without the
  /// corrections for mean forces: the velocity that damping sees, and its acceleration. Empty where
  /// they are v and a.
  Eigen::VectorXd v_u, a_u;
  LinearForces f;            ///< of the last step
  bool balanced = false;     ///< the motion solves the equations under f
  double external_work = 0;  ///< of f since time 0 [J]
  double damping_work = 0;   ///< that damping took since time 0 [J]

  bool is_still() const { return v.isZero(0) && a.isZero(0) && v_u.isZero(0) && a_u.isZero(0); }
  /// Save or load; the vectors have their sizes already.
  void visit_state(StateVisitor& visitor);
};

/// Steps of K u + C v + M a = f from an accepted state, with the schemes of NewmarkBossak
/// (docs/theory/structure.md, (T10)). A solution is a back substitution with the factor of
///
///     A(dt) = K + gamma / (beta dt) C + inertia_slope(dt) M
///
/// The factors of the last `kept_factors` sizes of dt are kept. With damping, and with rho_inf = 0,
/// mean forces change velocities by the inverse of a matrix between M and A in place of M^-1 (T13).
class LinearStep {
 public:
  static constexpr std::size_t kept_factors = 6;

  /// Refers to the model.
  /// @throws ConfigError  M not positive definite or C not positive semidefinite (dynamic), K not
  ///                      positive definite (else)
  LinearStep(const LinearModel& model, const NewmarkBossak& scheme, bool dynamic);

  /// A state at time 0 from displacement and velocity; the acceleration follows from the load.
  LinearState state_of(Eigen::VectorXd u, Eigen::VectorXd v, const Eigen::VectorXd& load) const;
  /// K u = load at time 0. @throws ConfigError  K is not positive definite
  LinearState equilibrium(const Eigen::VectorXd& load) const;

  /// Displacement at the end of a step. It is a function of its arguments, equal in every bit when
  /// called again.
  Eigen::VectorXd solve(const LinearState& state_n, const LinearForces& f, double dt);
  /// The state at the end of a step with the displacement `u` that solve() gave for these forces.
  LinearState after(const LinearState& state_n, LinearForces f, Eigen::VectorXd u, double dt);
  /// Forget the start of the step: the accepted state has changed.
  void forget() { start_.reset(); }

  /// Whether the loads equal those of the state in every bit, and it is at rest under them.
  bool nothing_changes(const LinearState& state_n, const LinearForces& f) const;

  double elastic_energy(const LinearState& state) const;
  double kinetic_energy(const LinearState& state) const;
  const LinearModel& model() const { return model_; }
  const NewmarkBossak& scheme() const { return scheme_; }
  std::int64_t factorisations() const { return factorisations_; }
  std::int64_t solves() const { return solves_; }
  std::int64_t skipped() const { return skipped_; }
  const PhaseTimes& times() const { return times_; }

 private:
  /// Parts of the balance that follow from the state at the start of a step.
  struct Start {
    double dt = 0;
    Eigen::VectorXd forces;  // [N]
  };
  SparseMatrix matrix(double dt) const;
  const SymmetricFactor& factor(double dt);
  const SymmetricFactor& step_force_factor(double dt);
  const Eigen::VectorXd& start_forces(const LinearState& state_n, double dt);
  void move(const LinearState& state_n, const Eigen::VectorXd& du, double dt,
            LinearState& next) const;
  Eigen::VectorXd mean_force_change(const LinearState& state_n, const LinearForces& f, double dt);
  void add_mean_forces(const LinearState& state_n, const LinearForces& f, double dt,
                       Eigen::VectorXd& r);
  /// Whether damping and mean forces need velocities of their own.
  bool tracks_displacements() const {
    return dynamic_ && model_.damped() && scheme_.step_force_velocity() != 0;
  }
  /// Share of A in the matrix that takes the place of M for the changes of mean forces.
  double implicit_share() const {
    return model_.damped() || step_force_is_implicit(scheme_) ? step_force_filter(scheme_) : 0;
  }

  const LinearModel& model_;
  NewmarkBossak scheme_;
  bool dynamic_;
  std::optional<SymmetricFactor> mass_;
  struct KeptFactor {
    double dt = 0;
    std::unique_ptr<SymmetricFactor> factor;
    std::unique_ptr<SymmetricFactor> of_step_forces = nullptr;  // made at first use
  };
  std::list<KeptFactor> factors_;  // last used first
  std::optional<Start> start_;
  std::int64_t factorisations_ = 0, solves_ = 0, skipped_ = 0;
  PhaseTimes times_;
};

}  // namespace gabion::fem
