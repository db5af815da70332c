// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <mpi.h>

#include <optional>
#include <string>
#include <vector>

#include "common/mechanics/materials/rotation_warning.hpp"
#include "common/run/repeated_failure.hpp"
#include "common/run/solver.hpp"
#include "common/run/start.hpp"
#include "fem_solver/fem_config.hpp"
#include "fem_solver/interface/beam_surfaces.hpp"
#include "fem_solver/interface/changing_surfaces.hpp"
#include "fem_solver/interface/wet_surfaces.hpp"
#include "fem_solver/report/structure_report.hpp"
#include "fem_solver/step/first_period.hpp"
#include "fem_solver/step/structure_step.hpp"

namespace gabion::fem {

/// The structure: a finite element model that takes the forces on its wet surfaces and gives their
/// displacements (README.md).
/// @note Every function is collective over the ranks of `comm`.
template <int dim>
class FemSolver final : public Solver, public DisplacedAtStart, public ChangesFacets {
 public:
  /// @param settings       with the part of this rank of `comm`
  /// @param output_folder  folder of the frames; empty: none are written
  /// @throws ConfigError       contradictory settings
  /// @throws ConvergenceError  no initial equilibrium
  FemSolver(MPI_Comm comm, FemSettings<dim> settings, const std::string& output_folder);

  std::vector<InterfaceMesh> interfaces() const override;
  std::vector<std::string> probe_names() const override { return report_.probe_names(); }
  bool takes_force_kinds() const override { return true; }
  void set_force_kinds(const ForceKinds& kinds) override;
  InterfaceValues start_displacements() const override { return interface_displacements(state_); }
  InterfaceFacets facets() const override { return changing_.facets(); }
  StepReport solve_step(const StepRequest& request, const InterfaceValues& received,
                        InterfaceValues& sent) override;
  AcceptReport accept_step(const StepRequest& request, bool solved) override;
  void reject_step() override;
  void write_output(double time) override { report_.write_frame(time, state_); }
  std::vector<double> probes() const override { return report_.probes(state_); }
  Json summary() const override;
  bool keeps_state() const override { return true; }
  State save_state() override;
  void load_state(const State& state) override;
  bool joins_states() const override { return true; }
  void join_states(const State& first, std::span<const State> own) override;

  const StructureState& state() const { return state_; }
  /// Start from other displacements and velocities of the held nodes, num_nodes x dim [m, m/s], at
  /// time 0.
  void set_motion(std::vector<double> u, std::vector<double> v);
  const Mesh<dim>& mesh() const { return settings_.mesh; }  ///< the part of this rank
  const MeshRanks& ranks() const { return settings_.ranks; }

 private:
  CellHistory history_of(const HistoryRows& saved, const std::vector<double>& values) const;
  std::int64_t num_failed() const;
  ExternalForces interface_forces(const InterfaceValues& received, double dt) const;
  InterfaceValues interface_displacements(const StructureState& state) const;
  std::vector<Matrix<dim>> turns_of(const StructureState& state) const;

  FemSettings<dim> settings_;
  WetSurfaces<dim> wet_surfaces_;
  BeamSurfaces<dim> beam_surfaces_;
  ChangingSurfaces<dim> changing_;
  StructureStep<dim> step_;
  StructureReport<dim> report_;
  StructureState state_;
  std::optional<StructureState> trial_;
  RepeatedFailure failures_;  // of static steps
  RotationWarning rotation_;
  FirstPeriodCheck<dim> period_check_;
  bool warned_of_wet_failure_ = false;
};

}  // namespace gabion::fem
