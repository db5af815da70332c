// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <mpi.h>

#include <functional>
#include <string>
#include <vector>

#include "common/run/facets.hpp"
#include "common/run/solver.hpp"
#include "common/run/start.hpp"
#include "solver_program/mpi_traffic.hpp"

namespace gabion {

/// A solver on several ranks as one: all of them call the same function with the same values, and
/// an error on any of them becomes one on all, the worst one. On one rank calls are passed on
/// directly.
/// @note Functions are collective; the solver's own answers are there on every rank.
class RankedSolver final : public Solver,
                           public DisplacedAtStart,
                           public TakesStart,
                           public ChangesFacets,
                           public TakesFacets {
 public:
  /// @param inner  outlives this object
  RankedSolver(MPI_Comm comm, Solver& inner);

  std::vector<InterfaceMesh> interfaces() const override { return inner_.interfaces(); }
  std::vector<std::string> probe_names() const override { return inner_.probe_names(); }
  bool takes_force_kinds() const override { return inner_.takes_force_kinds(); }
  void set_force_kinds(const ForceKinds& kinds) override;
  InterfaceValues start_displacements() const override;
  bool takes_start() const override { return gabion::takes_start(inner_); }
  void set_start(const InterfaceValues& displacements) override;
  InterfaceFacets facets() const override { return changing_facets(inner_); }
  bool takes_facets() const override { return gabion::takes_facets(inner_); }
  void set_facets(const InterfaceFacets& facets) override;
  StepReport solve_step(const StepRequest& request, const InterfaceValues& received,
                        InterfaceValues& sent) override;
  AcceptReport accept_step(const StepRequest& request, bool solved) override;
  void reject_step() override;
  void write_output(double time) override;
  std::vector<double> probes() const override;
  /// Summary of the solver, with `peak_memory` [bytes], `cpu_seconds` of the programs and
  /// `output_cpu_seconds` of them, spent on frames and checkpoints. On several ranks where
  /// mpi_traffic() is counted it has `mpi`, the messages of the steps: `largest_rank`, `all_ranks`.
  Json summary() const override;
  bool keeps_state() const override { return inner_.keeps_state(); }
  /// The parts of all ranks on the first one (gather_state).
  State save_state() override;
  /// Each rank writes its part of the file (write_ranked_state). Where a rank does not see the
  /// folder, being on another machine, it warns and acts as save_state().
  State save_state_to(const std::string& path) override;
  /// @param state  of all ranks; read on the first one only (load_gathered). A file: on all ranks
  void load_state(const State& state) override;

 private:
  void together(const std::function<void()>& work) const;
  void step_together(const std::function<void()>& work);
  void output_together(const std::function<void()>& work);
  template <class Number>
  Json over_ranks(Number own) const;

  MPI_Comm comm_;
  int size_ = 1;
  Solver& inner_;
  MpiTraffic traffic_;         // of the steps, where it is counted
  double output_seconds_ = 0;  // CPU time of frames and checkpoints
};

}  // namespace gabion
