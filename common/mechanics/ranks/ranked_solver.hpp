// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <mpi.h>

#include <functional>
#include <string>
#include <vector>

#include "common/run/solver.hpp"

namespace gabion {

/// A solver on several ranks, driven from the first one: what rank 0 calls, the others do too.
///
/// Rank 0 uses this object as the solver; the other ranks sit in `follow()`, asleep between calls.
/// The inner solver's functions are collective; an error on any rank becomes one on all of them.
/// On one rank every call goes straight through.
class RankedSolver final : public Solver {
 public:
  /// @param inner  outlives this object
  RankedSolver(MPI_Comm comm, Solver& inner);

  std::vector<InterfaceMesh> interfaces() const override;
  std::vector<std::string> probe_names() const override;
  StepReport solve_step(const StepRequest& request, const InterfaceValues& received,
                        InterfaceValues& sent) override;
  AcceptReport accept_step(const StepRequest& request, bool solved) override;
  void reject_step() override;
  void write_output(double time) override;
  std::vector<double> probes() const override;
  Json summary() const override;
  bool keeps_state() const override { return inner_.keeps_state(); }
  /// The parts of all ranks (gather_state).
  State save_state() override;
  void load_state(const State& state) override;

  /// Rank 0: release the other ranks from `follow()`. @param error  empty, or why the run failed
  void stop(const std::string& error = "");
  /// The other ranks: do what rank 0 does until it stops.
  /// @throws Error  an error that ended the run, on this rank or another
  void follow();

 private:
  enum class Call {
    solve_step,
    accept_step,
    reject_step,
    write_output,
    probes,
    summary,
    save_state,
    load_state,
    stop
  };
  void announce(Call call, const Json& arguments) const;
  void together(const std::function<void()>& work) const;
  void follow_call(Call call, const Json& arguments);

  MPI_Comm comm_;
  int size_ = 1;
  Solver& inner_;
  mutable bool followers_left_ = false;
};

/// Run `drive` with this solver on rank 0 and follow it on all other ranks.
/// @throws what drive or the solver threw; on all ranks together
void drive_ranks(MPI_Comm comm, Solver& solver, const std::function<void(Solver&)>& drive);

}  // namespace gabion
