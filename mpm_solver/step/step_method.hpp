// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <optional>
#include <span>
#include <vector>

#include "common/base/timer.hpp"
#include "common/run/solver.hpp"
#include "mpm_solver/step/end_of_step.hpp"
#include "mpm_solver/step/ledger.hpp"
#include "mpm_solver/step/soil_on_grid.hpp"
#include "mpm_solver/step/soil_state.hpp"
#include "mpm_solver/step_sizes/step_sizes.hpp"

namespace gabion::mpm {

/// Newmark's method with these parameters needs no acceleration at the start of a step: du = dt v +
/// dt^2 a' / 2, v' = v + dt a'; the impulse of a force is dt F.
inline constexpr NewmarkBossak starting_scheme = {.beta = 0.5, .gamma = 1};

/// A step that begins.
struct StepStart {
  double time = 0;             ///< of the accepted state [s]
  double dt = 0;               ///< [s]
  std::size_t phase = 0;       ///< number in MpmSettings::phases
  bool with_inertia = true;    ///< false: quasi-static
  bool forces_jump = false;    ///< its forces differ from those before it, so no acceleration is
                               ///< known
  bool takes_weight = false;   ///< SoilSurface::takes_weight
  NewmarkBossak scheme = {};   ///< StepMethod::scheme
  double strength_factor = 1;  ///< by which strengths are divided
};

/// Results of the last solution that the end of a step needs.
template <int dim>
struct StepEnd {
  NodalMotion<dim> motion;
  StepBalance<dim> balance;
  double plastic_work = 0;         ///< of this rank's points [J]
  std::optional<StepError> error;  ///< not set: not known, or no limit asks for it
};

/// Method of the steps of a phase: the solution for the present place of the surfaces and, once it
/// is accepted, its results. The soil is on the nodes of its grid, and the surfaces have started
/// the step. Functions are collective.
template <int dim>
class StepMethod {
 public:
  /// The parts that a method works on, and refers to.
  struct Parts {
    const SoilModel<dim>& model;
    SoilState<dim>& state;
    SoilOnGrid<dim>& soil;
    TrialPoints<dim>& trial;  ///< set to the state of the points in the last solution
    StepSizes& sizes;
    PhaseTimes& times;
  };

  StepMethod() = default;
  StepMethod(const StepMethod&) = delete;
  StepMethod& operator=(const StepMethod&) = delete;
  StepMethod(StepMethod&&) = delete;
  StepMethod& operator=(StepMethod&&) = delete;
  virtual ~StepMethod() = default;

  /// Parameters with which Newmark's method would make a step of this phase: they say what weight a
  /// force has in it.
  /// @param forces_jump  StepStart::forces_jump
  virtual NewmarkBossak scheme(const Phase& phase, bool forces_jump) const = 0;

  /// Begin a step: do all that does not depend on the place of the surfaces.
  /// @throws ConvergenceError
  virtual void begin(const StepStart& start) = 0;
  /// Solve for the present place of the surfaces. Iteration 0 of a step starts from the accepted
  /// state alone, the following ones from the last solution.
  /// @throws ConvergenceError
  virtual StepReport solve(const StepRequest& request) = 0;

  /// Displacement of the active nodes in the last solution, num_nodes x dim [m].
  virtual std::span<const double> du() const = 0;
  /// Force of the soil on each wall of the phase in the last solution [N].
  virtual std::vector<Vector<dim>> wall_forces() const = 0;

  /// Accept the last solution: bring the trial state of the points to exactly its end.
  /// @pre  the points have not moved, and wall_forces() is not asked for any more
  virtual StepEnd<dim> end() = 0;
  /// Update the points by what grid_to_points leaves out.
  virtual void finish_points(MaterialPoints<dim>&) const {}
  /// Put the data of this step that later steps need into the state.
  virtual void remember(SoilState<dim>& state) const = 0;

  /// Release the memory that only a step needs, until the next one begins.
  virtual void release() = 0;
};

}  // namespace gabion::mpm
