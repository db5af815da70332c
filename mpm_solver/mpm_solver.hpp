// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <mpi.h>

#include <string>
#include <vector>

#include "common/base/timer.hpp"
#include "common/run/facets.hpp"
#include "common/run/repeated_failure.hpp"
#include "common/run/solver.hpp"
#include "mpm_solver/contact/thin_walls.hpp"
#include "mpm_solver/report/soil_report.hpp"
#include "mpm_solver/step/soil_step.hpp"

namespace gabion::mpm {

/// The soil: material point method, implicit or explicit, in updated Lagrangian form
/// (docs/theory/soil.md).
/// @note Every function is collective over the ranks of `comm`.
template <int dim>
class MpmSolver final : public Solver, public TakesFacets {
 public:
  /// @param output_folder  folder of the frames; empty: none are written
  /// @throws ConfigError  a body outside the grid; soil behind or inside a surface; initial stress
  ///                      that is not in balance
  MpmSolver(MPI_Comm comm, MpmSettings<dim> settings, const std::string& output_folder);

  std::vector<InterfaceMesh> interfaces() const override {
    return state_.surfaces.interface_meshes();
  }
  std::vector<std::string> probe_names() const override { return report_.probe_names(); }
  /// True with contact by facets alone and without boulders, which know interfaces by their facets.
  bool takes_facets() const override;
  void set_facets(const InterfaceFacets& facets) override;
  StepReport solve_step(const StepRequest& request, const InterfaceValues& received,
                        InterfaceValues& sent) override;
  AcceptReport accept_step(const StepRequest& request, bool solved) override;
  void reject_step() override { step_.reject(); }
  void write_output(double time) override;
  std::vector<double> probes() const override { return report_.probes(state_); }
  Json summary() const override { return report_.summary(state_, step_, times_); }
  bool keeps_state() const override { return true; }
  State save_state() override;
  void load_state(const State& state) override;
  bool joins_states() const override { return true; }
  void join_states(const State& first, std::span<const State> own) override;

  const MaterialPoints<dim>& points() const { return state_.points; }
  const Surfaces<dim>& surfaces() const { return state_.surfaces; }
  /// Start from other velocities [m/s] and accelerations [m/s^2] of this rank's points, num_points
  /// each, at time 0.
  void set_motion(std::vector<Vector<dim>> v, std::vector<Vector<dim>> a);

 private:
  void set_facets_as(const State& state);

  SoilModel<dim> model_;
  PhaseTimes times_;
  SoilState<dim> state_;
  SoilStep<dim> step_;
  SoilReport<dim> report_;
  ThinWalls<dim> thin_walls_;
  RepeatedFailure failures_;  // of quasi-static steps
  InterfaceFacets other_;     // facets of the interfaces that got others than at the beginning
  InterfaceFacets first_;     // those of the beginning, of the same
};

}  // namespace gabion::mpm
