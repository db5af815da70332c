// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "mpm_solver/step/explicit_motion.hpp"
#include "mpm_solver/step/stable_step.hpp"
#include "mpm_solver/step/step_method.hpp"

namespace gabion::mpm {

/// Effort of explicit steps; iterations of the coupling and repetitions included.
struct SubstepCounts {
  std::int64_t solutions = 0;
  std::int64_t substeps = 0;
  int largest = 0;                       ///< of a solution
  double smallest = 0;                   ///< [s], 0: none
  std::int64_t repeated = 0;             ///< solutions after the first one of a step
  std::int64_t repeated_whole = 0;       ///< of them, those that solved all of the soil
  std::int64_t repeated_points = 0;      ///< points of this rank in the substeps of repeated ones
  std::int64_t evaluated_points = 0;     ///< of them, those whose stresses were evaluated
  std::int64_t pressure_iterations = 0;  ///< of the solver of pore pressures that drain
};

/// Steps of explicit phases: equal substeps of central differences, as many as are stable.
/// Iterations after the first one take at least the number of substeps of the one before.
template <int dim>
class ExplicitStep final : public StepMethod<dim> {
 public:
  using Parts = typename StepMethod<dim>::Parts;
  /// @throws Error  pore water drains on several ranks
  explicit ExplicitStep(const Parts& parts);

  NewmarkBossak scheme(const Phase&, bool) const override { return starting_scheme; }
  void begin(const StepStart& start) override;
  StepReport solve(const StepRequest& request) override;
  std::span<const double> du() const override { return motion_->result().du; }
  std::vector<Vector<dim>> wall_forces() const override;
  StepEnd<dim> end() override;
  void finish_points(MaterialPoints<dim>& points) const override;
  void remember(SoilState<dim>& state) const override;
  void release() override { motion_.reset(); }

  const SubstepCounts& counts() const { return counts_; }

 private:
  void find_water();
  int count_for(double dt, double contact_rate) const;
  void add_repeated();
  void log_count(const StepRequest& request);
  NodalMotion<dim> nodal_motion() const;
  StepBalance<dim> balance() const;
  const GridNodes<dim>& nodes() const { return parts_.soil.nodes(); }
  const WallConditions<dim>& walls() const { return parts_.soil.walls(start_.phase); }

  Parts parts_;
  StableStep<dim> stable_;
  std::optional<SeepageBorders<dim>> borders_;  // where pore water drains in an explicit phase
  SubstepCounts counts_;
  double logged_dt_ = 0;  // of the last line in the log [s]

  // the current step
  StepStart start_;
  std::vector<double> f_body_start_, f_body_;  // besides gravity, at both ends; empty: none
  std::optional<WaterOfStep<dim>> water_;      // that drains
  std::optional<ExplicitMotion<dim>> motion_;
  double courant_ = 1;
  double soil_dt_ = 0;
  int count_ = 0;            // of substeps, of the last solution
  bool may_repeat_ = false;  // results of a solution may serve the next one
  bool repeats_ = false;     // it had a solution after the first one
  bool repeated_ = false;    // so had the step before it
};

}  // namespace gabion::mpm
