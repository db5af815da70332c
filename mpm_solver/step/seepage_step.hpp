// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "mpm_solver/step/implicit_step.hpp"
#include "mpm_solver/step/seepage_balance.hpp"
#include "mpm_solver/step/seepage_borders.hpp"
#include "mpm_solver/step/steady_seepage.hpp"

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
  SteadyFlow find_steady_flow(const StepStart& start, const Vector<dim>& gravity,
                              const std::string& where) override;
  void balance_flow(const StepStart& start, const Vector<dim>& gravity,
                    const std::string& where) override;
  double pressure_of_flow(std::int32_t body, const Vector<dim>& x) const override;

 private:
  NewtonReport iterate(bool first, const NewtonSettings& settings) override;
  void make_water(const StepStart& start, double time, const Vector<dim>& gravity);
  std::vector<double> first_displacement();
  NewtonReport solve(const NewtonSettings& settings);
  void open_borders(const StepStart& start, const Vector<dim>& gravity);
  void begin_matrix();
  DrainedNodes drained_nodes(const StepStart& start, double time, const Vector<dim>& gravity) const;
  void accept_in_place();
  std::vector<double> pressures_of_points() const;
  void flow_for(double dt, const Vector<dim>& gravity);
  void flow_until_steady(double unit, const Vector<dim>& gravity, const std::string& where);
  void require_one_flow(const Vector<dim>& gravity, const std::string& where);

  StressParts<dim> stress_parts() const;

  SeepageBorders<dim> borders_;
  std::optional<SeepageForces<dim>> water_;
  std::optional<SeepageBalance<dim>> balance_;
  std::optional<BlockMatrix<dim + 1>> K_;
  LinearSolver<dim + 1> solver_;
  PoolLevels pools_;            // at the end of the step
  std::vector<double> x_;       // of the balance
  StepStart flow_start_;        // of the last flow_for()
  double discharge_ = 0;        // of it [m^3/s]
  HeadsOfNodes heads_of_flow_;  // in the steady flow
};

}  // namespace gabion::mpm
