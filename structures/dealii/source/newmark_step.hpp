// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <deal.II/lac/sparse_direct.h>

#include <memory>
#include <optional>

#include "elastic_solid.hpp"

namespace dealii_structure {

/// State at which a tangent was factorised.
struct TangentPoint {
  Vector u;       ///< [m]
  double dt = 0;  ///< [s]; 0: without inertia
};

/// Nodal forces of the coupler [N] in a step.
struct WetForces {
  Vector end;   ///< those that are meant at its end
  Vector mean;  ///< those that are constant over it
  bool operator==(const WetForces& other) const { return end == other.end && mean == other.mean; }
};

/// All that later steps depend on.
struct SolidState {
  Vector u, v, a;  ///< [m], [m/s], [m/s^2]
  WetForces forces;
  bool balanced = false;                        ///< at rest it stays at rest under the same forces
  std::shared_ptr<const TangentPoint> tangent;  ///< with which the next step begins; may be null
};

/// Steps of Newmark's family with Bossak's averaged inertia,
///
///     a' = du / (beta dt^2) - v / (beta dt) - (1 / (2 beta) - 1) a
///     v' = v + dt [(1 - gamma) a + gamma a']
///     r = f' + c F - (c - 1) F_o - f_int(u + du) - M [(1 - alpha) a' + alpha a] = 0
///
/// F the mean forces of this step, F_o of the one before, c = (1 - alpha) / (2 beta)
/// (docs/theory/structure.md, (T9)). A step is a function of the accepted state: its factor is that
/// of the state's tangent point as long as each iteration reduces |r| by more than a factor 4.
template <int dim>
class NewmarkStep {
 public:
  NewmarkStep(const Settings& settings, const ElasticSolid<dim>& solid);

  /// The state at rest under gravity, or in the reference configuration.
  /// @throws gabion::ConvergenceError
  SolidState initial_state();
  /// The state after dt [s]. @returns iterations  @throws gabion::ConvergenceError
  int solve(const SolidState& state, const WetForces& forces, double dt, SolidState& trial);
  /// Add the corrections by mean forces to velocity and acceleration of an accepted step.
  void complete(const SolidState& state, double dt, SolidState& trial);

  int num_factorisations() const { return factorisations_; }

 private:
  /// Data of one balance that are constant while du is sought.
  struct Balance {
    const SolidState& state;
    Vector load;    // [N], not condensed
    double dt = 0;  // 0: without inertia
  };
  Vector acceleration(const Balance& balance, const Vector& du) const;
  std::optional<double> residual(const Balance& balance, const Vector& du, Vector& r,
                                 double* scale) const;
  void factorise(std::shared_ptr<const TangentPoint> point);
  int find_balance(const Balance& balance, Vector& du, std::shared_ptr<const TangentPoint> point);
  double follow(const Balance& balance, Vector& du, Vector& r) const;
  double rounding(const Balance& balance, const Vector& du) const;
  Vector inverse_mass_times(const Vector& f);

  const ElasticSolid<dim>& solid_;
  NewtonSettings newton_;
  bool initial_equilibrium_;
  double alpha_, beta_, gamma_;
  dealii::SparseMatrix<double> K_;
  dealii::SparseDirectUMFPACK factor_;
  std::shared_ptr<const TangentPoint> held_;  // what factor_ is of
  std::unique_ptr<dealii::SparseDirectUMFPACK> mass_factor_;
  int factorisations_ = 0;
};

}  // namespace dealii_structure
