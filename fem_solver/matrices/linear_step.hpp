// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <list>
#include <memory>
#include <optional>

#include "common/base/timer.hpp"
#include "common/mechanics/time_integration/newmark.hpp"
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
  double time = 0;           ///< [s]
  Eigen::VectorXd u;         ///< displacement [m]
  Eigen::VectorXd v;         ///< velocity [m/s]
  Eigen::VectorXd a;         ///< acceleration [m/s^2]
  LinearForces f;            ///< of the last step
  bool balanced = false;     ///< the motion solves the equations under f
  double external_work = 0;  ///< of f since time 0 [J]
  double damping_work = 0;   ///< that damping took since time 0 [J]

  bool is_still() const { return v.isZero(0) && a.isZero(0); }
  /// Save or load; the vectors have their sizes already.
  void visit_state(StateVisitor& visitor);
};

/// Steps of K u + C v + M a = f from an accepted state, with the schemes of NewmarkBossak
/// (docs/theory/structure.md, (T10)). A solution is a back substitution with the factor of
///
///     A(dt) = K + gamma / (beta dt) C + inertia_slope(dt) M
///
/// The factors of the last `kept_factors` sizes of dt are kept.
class LinearStep {
 public:
  static constexpr std::size_t kept_factors = 6;

  /// Refers to the model.
  /// @throws ConfigError  M not positive definite (dynamic), K not positive definite (else)
  LinearStep(const LinearModel& model, const NewmarkBossak& scheme, bool dynamic);

  /// A state at time 0 from displacement and velocity; the acceleration follows from the load.
  LinearState state_of(Eigen::VectorXd u, Eigen::VectorXd v, const Eigen::VectorXd& load) const;
  /// K u = load at time 0. @throws ConfigError  K is not positive definite
  LinearState equilibrium(const Eigen::VectorXd& load) const;

  /// Displacement at the end of a step. A function of its arguments, equal in every bit when asked
  /// again.
  Eigen::VectorXd solve(const LinearState& state_n, const LinearForces& f, double dt);
  /// The state at the end of a step with the displacement `u` that solve() gave for these forces.
  LinearState after(const LinearState& state_n, LinearForces f, Eigen::VectorXd u, double dt) const;
  /// The accepted state is another one.
  void forget() { start_.reset(); }

  /// Loads equal those of the state in every bit, and it is at rest under them.
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
  /// What of the balance the state at the start of a step decides.
  struct Start {
    double dt = 0;
    Eigen::VectorXd forces;  // [N]
  };
  const SymmetricFactor& factor(double dt);
  const Eigen::VectorXd& start_forces(const LinearState& state_n, double dt);
  Eigen::VectorXd mean_force_change(const LinearState& state_n, const LinearForces& f) const;

  const LinearModel& model_;
  NewmarkBossak scheme_;
  bool dynamic_;
  std::optional<SymmetricFactor> mass_;
  struct KeptFactor {
    double dt = 0;
    std::unique_ptr<SymmetricFactor> factor;
  };
  std::list<KeptFactor> factors_;  // last used first
  std::optional<Start> start_;
  std::int64_t factorisations_ = 0, solves_ = 0, skipped_ = 0;
  PhaseTimes times_;
};

}  // namespace gabion::fem
