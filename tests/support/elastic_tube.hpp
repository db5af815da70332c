// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Core>

#include "common/run/solver.hpp"

namespace gabion::test {

/// The elastic tube, the standard test of coupling methods for light structures: an incompressible
/// frictionless fluid of density 1 in a tube whose wall has no mass.
///
///     d(a)/dt   + d(a v)/dx               = 0
///     d(a v)/dt + d(a v^2)/dx + a d(p)/dx = 0
///     wall:  a = a0 (2 c^2 / (2 c^2 - p))^2 ,   c^2 = E / (2 r0) = E sqrt(pi) / 2
///
/// Length 10, E = 1e4, a0 = 1; inflow v = 10 + 3 sin(10 pi t); non-reflecting outlet. Backward
/// Euler, finite volumes, the momentum upwind, values between nodes by their mean.
/// @see Degroote, Bathe, Vierendeels (2009); the tutorial elastic-tube-1d of preCICE
///
/// Cast as soil and structure of the coupler: the flow "sends force", where the x component at a
/// node is its pressure, and the wall "sends displacement", where the x component is a - a0. The y
/// components are 0. Nothing is mapped (both sides have the same nodes), so that the coupler's
/// moments and works have no meaning here; residuals and columns have.
struct Tube {
  static constexpr int num_nodes = 101;
  static constexpr double length = 10;
  static constexpr double wave_speed_2 = 1e4 / 2 * 1.7724538509055159;  ///< c^2
  static InterfaceMesh mesh();
};

/// Pressure from area.
class TubeFlow : public Solver {
 public:
  TubeFlow();
  std::vector<InterfaceMesh> interfaces() const override { return {Tube::mesh()}; }
  std::vector<std::string> probe_names() const override { return {"p_mid"}; }
  std::vector<double> probes() const override { return {p_(Tube::num_nodes / 2)}; }
  StepReport solve_step(const StepRequest& request, const InterfaceValues& received,
                        InterfaceValues& sent) override;
  AcceptReport accept_step(const StepRequest& request, bool solved) override;
  void reject_step() override {}
  void write_output(double) override {}
  Json summary() const override { return Json::object(); }

 private:
  Eigen::VectorXd a_, v_, p_;  // accepted
  Eigen::VectorXd a_trial_, v_trial_, p_trial_;
};

/// Area from pressure, without memory.
class TubeWall : public Solver {
 public:
  std::vector<InterfaceMesh> interfaces() const override { return {Tube::mesh()}; }
  std::vector<std::string> probe_names() const override { return {"a_mid"}; }
  std::vector<double> probes() const override { return {1 + growth_mid_}; }
  StepReport solve_step(const StepRequest& request, const InterfaceValues& received,
                        InterfaceValues& sent) override;
  AcceptReport accept_step(const StepRequest&, bool) override;
  void reject_step() override {}
  void write_output(double) override {}
  Json summary() const override { return Json::object(); }

 private:
  double growth_mid_ = 0;
  double growth_mid_trial_ = 0;
};

}  // namespace gabion::test
