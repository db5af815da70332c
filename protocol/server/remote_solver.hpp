// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <deque>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "common/base/timer.hpp"
#include "common/run/asynchronous_solver.hpp"
#include "common/run/facets.hpp"
#include "common/run/start.hpp"
#include "protocol/server/switchboard.hpp"
#include "protocol/wire/handshake.hpp"

namespace gabion {

/// A participant in another process, as the coupling loop sees it. Every call waits for the reply;
/// where both solvers shall work at once, use the start_/finish_ pairs.
///
/// All calls throw ProtocolError when the participant is lost; the coupling is over then.
class RemoteSolver : public AsynchronousSolver,
                     public DisplacedAtStart,
                     public TakesStart,
                     public ChangesFacets,
                     public TakesFacets {
 public:
  /// @param switchboard  must outlive this
  RemoteSolver(Switchboard& switchboard, Hello hello);

  const std::string& name() const { return hello_.participant; }
  const Hello& hello() const { return hello_; }

  std::vector<InterfaceMesh> interfaces() const override { return hello_.interfaces; }
  std::vector<std::string> probe_names() const override { return hello_.probe_names; }

  bool takes_force_kinds() const override { return hello_.takes_force_kinds; }
  void set_force_kinds(const ForceKinds& kinds) override;
  InterfaceValues start_displacements() const override { return hello_.start; }
  bool takes_start() const override { return hello_.takes_start; }
  void set_start(const InterfaceValues& displacements) override;
  /// The facets that the participant told in its last answers.
  InterfaceFacets facets() const override { return facets_; }
  bool takes_facets() const override { return hello_.takes_facets; }
  void set_facets(const InterfaceFacets& facets) override;
  StepReport solve_step(const StepRequest& request, const InterfaceValues& received,
                        InterfaceValues& sent) override;
  AcceptReport accept_step(const StepRequest& request, bool solved) override;
  void reject_step() override;
  void write_output(double time) override;
  std::vector<double> probes() const override { return probes_; }
  /// The participant's summary, which is requested from it: call this before Server::finish.
  Json summary() const override;
  bool keeps_state() const override { return hello_.keeps_state; }
  State save_state() override;
  /// @throws ProtocolError  the participant wrote a file that is not there, or is of another size
  State save_state_to(const std::string& path) override;
  void load_state(const State& state) override;
  std::optional<double> last_busy_seconds() const override { return last_call_.busy_seconds; }

  void start_solve(const StepRequest& request, const InterfaceValues& received) override;
  StepReport finish_solve(InterfaceValues& sent) override;
  void start_accept(const StepRequest& request, bool solved) override;
  AcceptReport finish_accept() override;
  bool takes_next_step() const override { return hello_.takes_next_step; }
  void start_next(const StepRequest& request, const InterfaceValues& received,
                  const DtRange& proposed) override;
  void call_off_solve() override;

  const CallTimes& last_call() const { return last_call_; }  ///< count is 1
  const std::map<std::string, CallTimes>& call_times() const override { return times_; }

 private:
  Message solve_request(const StepRequest& request, const InterfaceValues& received) const;
  ConvergenceError failure(const Message& reply) const;
  void start(Message request) const;
  void send(Message request) const;
  Message finish(const std::vector<std::string>& allowed) const;
  Message call(Message request, const std::string& reply) const;
  void take_probes(const Message& reply);
  void note_times(const Message& reply) const;

  struct Outstanding {
    std::string type;
    std::uint64_t sequence;
    Stopwatch watch;
  };

  Switchboard& switchboard_;
  Hello hello_;
  std::vector<double> probes_;
  InterfaceFacets facets_;                       // of the interfaces that may get others
  mutable std::deque<Outstanding> outstanding_;  // oldest first
  mutable CallTimes last_call_;
  mutable std::map<std::string, CallTimes> times_;
};

}  // namespace gabion
