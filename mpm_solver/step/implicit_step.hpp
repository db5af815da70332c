// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "mpm_solver/step/linear_system.hpp"
#include "mpm_solver/step/step_method.hpp"

namespace gabion::mpm {

/// Steady flow of pore water through the skeleton at rest.
struct SteadyFlow {
  std::vector<double> pressures;  ///< of the points of this rank [Pa]
  double discharge = 0;           ///< volume that leaves, and enters, by time [m^3/s]
};

/// Steps of implicit phases: the balance of momentum at the end of the step, solved by Newton's
/// method.
template <int dim>
class ImplicitStep : public StepMethod<dim> {
 public:
  using Parts = typename StepMethod<dim>::Parts;
  explicit ImplicitStep(const Parts& parts);

  NewmarkBossak scheme(const Phase& phase, bool forces_jump) const override {
    return phase.dynamic && !forces_jump ? phase.scheme : starting_scheme;
  }
  void begin(const StepStart& start) override;
  StepReport solve(const StepRequest& request) override;
  std::span<const double> du() const override { return du_; }
  std::vector<Vector<dim>> wall_forces() const override { return equilibrium_->wall_forces(); }
  StepEnd<dim> end() override;
  void remember(SoilState<dim>& state) const override;
  void release() override;

  /// Displacement that would balance the stress of the accepted state with gravity, without
  /// inertia, num_nodes x dim [m]; wall_forces() are then those of that state.
  /// @param start  of a quasi-static step
  /// @param where  of the initial stress, file and pointer, for the message
  /// @throws ConfigError  there is none: some of the soil is held nowhere
  virtual std::vector<double> settlement(const StepStart& start, const Vector<dim>& gravity,
                                         const std::string& where);

  /// Find the steady flow at the start, and leave its pressures in the water of the points. Without
  /// soil that drains there is none.
  /// @param where  of the setting that asks for it, for the message
  /// @throws ConfigError  there is none, or several
  virtual SteadyFlow find_steady_flow(const StepStart&, const Vector<dim>&, const std::string&) {
    return {};
  }
  /// Replace the stresses of the points by those in balance under the pressures of that flow, which
  /// stay, and so do the places of the points.
  /// @throws ConfigError  there is no balance
  virtual void balance_flow(const StepStart&, const Vector<dim>&, const std::string&) {}
  /// Pressure of that flow at a place in the soil or beside it [Pa].
  virtual double pressure_of_flow(std::int32_t, const Vector<dim>&) const { return 0; }

  const LinearSolver<dim>& linear_solver() const { return system_.solver(); }
  const BlockMatrix<dim>& stiffness() const { return system_.K(); }
  /// Iterations of the linear solver in all solutions so far.
  std::int64_t linear_iterations() const { return linear_iterations_; }

 protected:
  /// Gravity at both ends of a step [m/s^2].
  struct Gravity {
    Vector<dim> start, end;
  };
  void make_equilibrium(const Gravity& gravity);
  LinearRegime regime() const;
  void reduce_strength();
  NewtonReport solve_balance(const StepRequest& request);
  /// Newton's method from the start of a step (`first`), or from the last solution.
  virtual NewtonReport iterate(bool first, const NewtonSettings& settings);
  std::vector<char> touched_nodes() const;

  Parts parts_;
  LinearSystem<dim> system_;
  std::int64_t linear_iterations_ = 0;

  // the current step
  StepStart start_;
  std::vector<Body<dim>> weaker_;              // with reduced strength; empty: as in the settings
  PointLaws<dim> weaker_laws_;                 // laws of the points with reduced strength; empty:
                                               // as in the settings
  int first_iterations_ = 0;                   // of Newton's method, of the first solution
  std::vector<double> f_body_, f_body_start_;  // at both ends; empty where nobody needs them
  std::optional<Equilibrium<dim>> equilibrium_;
  std::span<const double> f_pore_;  // Equilibrium::Parts::f_pore
  std::vector<double> du_;
};

}  // namespace gabion::mpm
