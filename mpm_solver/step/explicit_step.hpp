// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "common/base/timer.hpp"
#include "common/run/solver.hpp"
#include "mpm_solver/step/explicit_motion.hpp"
#include "mpm_solver/step/soil_on_grid.hpp"
#include "mpm_solver/step/soil_state.hpp"
#include "mpm_solver/step/stable_step.hpp"

namespace gabion::mpm {

/// What explicit steps took; iterations of the coupling and repetitions included.
struct SubstepCounts {
  std::int64_t solutions = 0;
  std::int64_t substeps = 0;
  int largest = 0;      ///< of a solution
  double smallest = 0;  ///< [s], 0: none
};

/// Steps of explicit phases: how many substeps, and what the end of the step needs of them. Refers
/// to its arguments. Functions are collective.
template <int dim>
class ExplicitStep {
 public:
  ExplicitStep(const SoilModel<dim>& model, SoilState<dim>& state, PhaseTimes& times)
      : model_(model), state_(state), times_(times), stable_(model) {}

  /// What a step starts from.
  struct Start {
    const Phase& phase;
    SoilOnGrid<dim>& soil;  ///< mapped
    const WallConditions<dim>& walls;
    TrialPoints<dim>& trial;
    std::span<const double> f_body_start, f_body;  ///< besides gravity, at both ends; empty: none
  };
  void begin(const StepRequest& request, const Start& start);
  /// Solve for the present place of the surfaces; iterations after the first one keep at least the
  /// number of substeps of the one before. @throws ConvergenceError
  void solve(const StepRequest& request);

  // Displacement and motion of the last solution.
  const std::vector<double>& du() const { return motion_->result().du; }
  NodalMotion<dim> nodal_motion() const;
  StepBalance<dim> balance() const;
  /// Mean force of the soil on each wall of the phase [N].
  std::vector<Vector<dim>> wall_forces() const;
  /// What grid_to_points leaves out.
  void finish_points(MaterialPoints<dim>& points) const;
  /// Plastic work of this rank's points [J].
  double plastic_work() const { return motion_->result().plastic_work; }
  double contact_rate() const { return motion_->result().contact_rate; }

  const SubstepCounts& counts() const { return counts_; }

 private:
  int count_for(double dt, double contact_rate) const;
  void log_count(const StepRequest& request);

  const SoilModel<dim>& model_;
  SoilState<dim>& state_;
  PhaseTimes& times_;
  StableStep<dim> stable_;
  SubstepCounts counts_;
  double logged_dt_ = 0;  // of the last line in the log [s]

  // the current step
  std::optional<ExplicitMotion<dim>> motion_;
  const GridNodes<dim>* nodes_ = nullptr;
  const WallConditions<dim>* walls_ = nullptr;
  double courant_ = 1;
  double soil_dt_ = 0;
  double dt_ = 0;
  int first_count_ = 0;  // of substeps, that follows from the accepted state
  int count_ = 0;        // of the last solution
};

}  // namespace gabion::mpm
