// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "mpm_solver/step/implicit_step.hpp"
#include "mpm_solver/step/seepage_balance.hpp"
#include "mpm_solver/step/seepage_borders.hpp"

namespace gabion::mpm {

/// Implicit steps of soil whose pore water drains: displacements and pressures of the nodes are
/// solved for together.
template <int dim>
class SeepageStep final : public ImplicitStep<dim> {
 public:
  using Parts = typename StepMethod<dim>::Parts;
  explicit SeepageStep(const Parts& parts);

  void begin(const StepStart& start) override;
  StepEnd<dim> end() override;
  void finish_points(MaterialPoints<dim>& points) const override;
  void remember(SoilState<dim>& state) const override;
  void release() override;
  std::vector<double> settlement(const StepStart& start, const Vector<dim>& gravity,
                                 const std::string& where) override;

 private:
  NewtonReport iterate(bool first, const NewtonSettings& settings) override;
  void make_water(const StepStart& start, double time, const Vector<dim>& gravity);
  std::vector<double> first_displacement();
  NewtonReport solve(const NewtonSettings& settings);
  Vector<dim> rain_at(double time) const;

  StressParts<dim> stress_parts() const;

  SeepageBorders<dim> borders_;
  std::optional<SeepageForces<dim>> water_;
  std::optional<SeepageBalance<dim>> balance_;
  std::optional<BlockMatrix<dim + 1>> K_;
  LinearSolver<dim + 1> solver_;
  PoolLevels pools_;       // at the end of the step
  std::vector<double> x_;  // of the balance
};

}  // namespace gabion::mpm
