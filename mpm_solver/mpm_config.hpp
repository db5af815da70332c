// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "common/mechanics/newton/newton.hpp"
#include "common/mechanics/petsc/linear_solver.hpp"
#include "common/settings/scene.hpp"
#include "mpm_solver/boulders/boulder_settings.hpp"
#include "mpm_solver/contact/body_groups.hpp"
#include "mpm_solver/contact/contact_config.hpp"
#include "mpm_solver/gauges/gauge.hpp"
#include "mpm_solver/parameters/point_laws.hpp"
#include "mpm_solver/phases/phases.hpp"
#include "mpm_solver/points/initial_stress.hpp"
#include "mpm_solver/points/material_points.hpp"
#include "mpm_solver/points/pool.hpp"
#include "mpm_solver/small_cuts/small_cuts.hpp"
#include "mpm_solver/step_sizes/step_control.hpp"
#include "mpm_solver/stress/cell_quadrature.hpp"
#include "mpm_solver/stress/locking.hpp"
#include "mpm_solver/stress/softening_average.hpp"
#include "solver_program/solver_program.hpp"

namespace gabion::mpm {

/// A named place whose motion is reported: the material point nearest to it at the start.
template <int dim>
struct PointProbe {
  std::string name;
  Vector<dim> point;  ///< [m]
};

/// Settings of mpm.json.
template <int dim>
struct MpmSettings {
  BackgroundGrid<dim> grid;
  std::vector<Body<dim>> bodies;
  VaryingMaterials<dim> varying;          ///< of each body; shorter: none of the others has any
  std::string bodies_where;               ///< their place in the config, for error messages
  std::vector<PointLayout<dim>> layouts;  ///< of each body
  std::vector<std::optional<InitialStress>> initial_stress;  ///< of each body
  std::vector<SofteningAverage> softening_averages;  ///< of each body; empty: none acts
  BodyGroups body_groups;  ///< none: all bodies share the nodes of the grid
  Vector<dim> gravity = Vector<dim>::Zero();
  std::vector<Phase> phases;         ///< at least one
  std::vector<Pool> pools;           ///< of free water, see read_pools()
  std::optional<TimeFunction> rain;  ///< volume by horizontal area [m/s]; none: no rain
  /// Acceleration [m/s^2] that acts on material points besides gravity, from their position at the
  /// start [m] and the time [s]; empty: none. For manufactured solutions, not a key of mpm.json.
  std::function<Vector<dim>(const Vector<dim>& reference_position, double time)> body_acceleration;
  /// Solve all of the soil in each iteration of an explicit step, not only what the contact can
  /// reach (ExplicitReach). For comparisons, not a key of mpm.json.
  bool whole_iterations = false;
  double pic_share = 0;      ///< of the velocity, 0 = FLIP to 1 = PIC
  double noise_damping = 0;  ///< see NoiseDamping
  bool tpic = false;         ///< PIC whose points carry the gradients of velocity and acceleration
  Quadrature quadrature = Quadrature::points;
  LockingCure locking;
  SmallCutSettings small_cuts;
  /// Quadratic convergence: a last increment of 1e-3 cells leaves an error of about 1e-6 cells.
  NewtonSettings newton{.residual_tolerance = 1e-5, .increment_tolerance = 1e-3};
  /// Iteration limit in place of newton.max_iterations in steps without inertia: sand that takes
  /// its weight from the unstressed state is far from its first state of rest, and a shorter step
  /// does not bring it nearer.
  int iterations_without_inertia = 200;
  StepControlSettings step_control;
  LinearSolverSettings linear_solver;
  std::vector<ContactSettings<dim>> interfaces;
  std::vector<RigidWallSettings<dim>> rigid_walls;  ///< those of the boulders at the end
  std::vector<BoulderSettings<dim>> boulders;
  std::vector<PointProbe<dim>> probes;
  std::vector<Gauge<dim>> gauges;
  Outside outside = Outside::error;
};

/// Default of noise_damping in scenes where a body yields: e^-4 of the noise of soil that does not
/// flow is left when sqrt(stress / density) has crossed a cell.
inline constexpr double noise_damping_of_soil = 4;

/// Keys of mpm.json.
KeyTable mpm_keys();

/// Read mpm.json, all but "dimension". A scene without coupler.json has the keys "time" and
/// "output" too, read into `alone`.
/// @throws ConfigError
template <int dim>
MpmSettings<dim> read_mpm_settings(const Scene& scene, ConfigReader& in, AloneSettings* alone);

}  // namespace gabion::mpm
