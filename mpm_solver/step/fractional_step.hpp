// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <vector>

#include "mpm_solver/grid/point_inertia.hpp"
#include "mpm_solver/step/pressure_matrix.hpp"
#include "mpm_solver/step/pressure_solver.hpp"
#include "mpm_solver/step/seepage_borders.hpp"
#include "mpm_solver/stress/seepage_forces.hpp"
#include "mpm_solver/walls/wall_conditions.hpp"

namespace gabion::mpm {

/// The data on which the water of an explicit step depends.
template <int dim>
struct WaterOfStep {
  SeepageStepData<dim> data;  ///< without dt and inertia_slope, which are of substeps
  std::vector<OuterPoint<dim>> surface;
  DrainedNodes drained;
};

/// Pressures of pore water that drains in the substeps of an explicit step, by a fractional step
/// (docs/theory/water.md, (W21) to (W23)). The soil has moved under all other forces and the
/// pressure before, to u*; the pressures q at the end of the substep add
///
///     u' = u* + dt^2 A(F) ,  F = f(q) - f before ,  A(f) = Q W Q f ,
///
/// so that the balance of water r(u', q) = 0 of SeepageForces holds. Its derivative
///
///     dr/dq = S + dt^2 B^T Q W Q B ,  B = df/dq ,  S storage, seepage and stabilisation,
///
/// is symmetric and positive definite. Refers to its parts; valid for one step, on one rank.
template <int dim>
class FractionalStep {
 public:
  struct Parts {
    StressParts<dim> stress;
    const WaterOfStep<dim>& water;
    const WallConditions<dim>& walls;
    const PointInertia<dim>& inertia;
  };
  explicit FractionalStep(const Parts& parts) : parts_(parts) {}

  /// Go back to the accepted state, for substeps of dt [s].
  void begin(double dt);
  /// Find the pressures at the end of the next substep.
  /// @param u  num_nodes x dim [m]: u*, becomes u'
  /// @throws ConvergenceError  no balance is found, or points are squeezed until their pores close
  void solve(std::span<double> u);
  /// F of the last substep [N], A(F) [m/s^2] and the force of the pressure at its end [N],
  /// num_nodes x dim.
  const std::vector<double>& change() const { return F_; }
  const std::vector<double>& acceleration() const { return A_; }
  const std::vector<double>& forces() const { return water_->forces(); }
  /// End the substep. @param move  of the nodes in it [m]
  void end_substep(std::span<const double> move);

  /// The last substep was that of the end of the step: give the trial state of the points its
  /// pressures.
  /// @returns work against the pressure that did not become energy of the water in the points [J]
  double finish() { return -work_ - water_->finish(); }
  const SeepageForces<dim>& water() const { return *water_; }
  /// Volume of water that left in the step so far [m^3].
  double outflow() const;
  /// Work of pools and of the pressure beyond drained walls on water that comes in, and of pools on
  /// the skeleton, in the step so far [J], and their impulse on it [N s].
  double supplied_work() const;
  const Vector<dim>& pool_impulse() const { return pool_impulse_; }
  /// Take the forces of pools on the skeleton at the start of the step from internal forces that
  /// follow from the stresses of the points, num_nodes x dim [N].
  /// @returns whether there are pools
  bool subtract_pools(std::span<double> internal) const;
  /// Volumes of the rain that the soil took and did not take in the step so far [m^3].
  double rain_in() const { return rain_in_; }
  double rain_run_off() const { return rain_run_off_; }
  int iterations() const { return iterations_; }  ///< of conjugate gradients since begin()

 private:
  void make_pattern();
  void set_matrix();
  void update_outlets();
  void set_up(bool lump = false);
  void correct(double tolerance, std::vector<double>& dq);
  void respond(std::span<const double> f, std::vector<double>& A) const;
  double residual();
  void add_supplies(std::span<const double> move);
  void move(std::span<const double> u);
  void evaluate(bool with_K);

  Parts parts_;
  double dt_ = 0;
  std::optional<SeepageForces<dim>> water_;
  BlockMatrix<dim + 1> K_;
  std::optional<PressureMatrix<dim>> matrix_;
  double matrix_dt_ = 0;         // of the substeps that matrix_ is for
  std::vector<double> closed_;   // its storage() without outlets
  std::vector<char> held_;       // of each node: 1 dry, 2 drained
  std::vector<double> q_;        // of each node [Pa]
  std::vector<double> f_start_;  // force of the pressure at the start of the substep
  std::vector<double> f_old_;    // of q_ at the start of the substep
  std::vector<double> F_, A_, u_, r_;
  std::unique_ptr<PressureSolver> solver_;
  bool first_solver_ = false;  // it was set up at the start of a solution
  bool lumped_ = false;        // PressureMatrix::near
  int least_iterations_ = 0;   // of the first solution with solver_; 0: there is none
  double work_ = 0;            // of the pressure so far [J]
  double supplied_work_ = 0, rain_in_ = 0, rain_run_off_ = 0;
  Vector<dim> pool_impulse_ = Vector<dim>::Zero();
  std::vector<double> f_pool_start_;  // at the start of the substep
  int iterations_ = 0;
};

}  // namespace gabion::mpm
