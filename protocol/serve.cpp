// SPDX-License-Identifier: BSD-3-Clause
#include "protocol/serve.hpp"

#include "common/base/timer.hpp"
#include "common/run/facets.hpp"
#include "common/run/repeated_failure.hpp"
#include "common/run/start.hpp"
#include "protocol/participant/state_machine.hpp"
#include "protocol/wire/exchange.hpp"
#include "protocol/wire/facets.hpp"

namespace gabion {
namespace {

/// A solver that the coupler's requests drive: every answer is there at once.
class DrivenSolver final : public RequestHandler {
 public:
  DrivenSolver(Solver& solver, const Quantity& sends)
      : solver_(solver),
        sends_(sends),
        interfaces_(solver.interfaces()),
        sent_facets_(changing_facets(solver)) {}

  Answer set_force_kinds(const ForceKinds& kinds) override {
    solver_.set_force_kinds(kinds);
    return new_message("force_kinds_set");
  }

  Answer set_start(const InterfaceValues& displacements) override {
    gabion::set_start(solver_, displacements);
    return start_set(solver_.probes());
  }

  Answer set_facets(const InterfaceFacets& facets) override {
    gabion::set_facets(solver_, facets);
    return new_message("facets_set");
  }

  Answer solve_step(const StepRequest& step, InterfaceValues received) override {
    InterfaceValues sent;
    try {
      const StepReport report = solver_.solve_step(step, received, sent);
      Message reply = new_message("solved");
      put(reply, report);
      put_values(reply, sends_.name, interfaces_, std::move(sent));
      return reply;
    } catch (const ConvergenceError& problem) {
      Message reply = new_message("failed", {{"reason", problem.what()}});
      if (problem.cause() == fails_at_any_dt) reply.fields["at_any_dt"] = true;
      return reply;
    }
  }

  Answer accept_step(const StepRequest& step, bool solved) override {
    const AcceptReport report = solver_.accept_step(step, solved);
    Message reply = new_message("accepted");
    put(reply, report);
    sent_facets_.put_changed(reply, interfaces_, changing_facets(solver_));
    return reply;
  }

  Answer reject_step() override {
    solver_.reject_step();
    return new_message("rejected");
  }

  Answer write_output(double time) override {
    solver_.write_output(time);
    return new_message("written");
  }

  Answer save_state(const std::string& file) override {
    return saved(file.empty() ? solver_.save_state() : solver_.save_state_to(file));
  }

  Answer load_state(const Message& request) override {
    solver_.load_state(read_state(request));
    sent_facets_.forget();
    return loaded(solver_.probes());
  }

  Answer summarize() override { return new_message("summary", {{"summary", solver_.summary()}}); }

 private:
  Solver& solver_;
  Quantity sends_;
  std::vector<InterfaceMesh> interfaces_;
  SentFacets sent_facets_;
};

}  // namespace

void answer_requests(Solver& solver, const Quantity& receives, const Quantity& sends,
                     RequestSource& requests) {
  DrivenSolver driven(solver, sends);
  StateMachine machine(driven, receives.name, solver.interfaces(),
                       std::string("protocol ") + protocol_version);
  while (!machine.is_finished()) {
    Message request = requests.next_request(nullptr);
    const Stopwatch busy;
    Message reply = machine.handle(std::move(request)).value();
    reply.fields["busy_seconds"] = busy.seconds();
    requests.reply(std::move(reply));
  }
}

void serve(Solver& solver, Connection& connection, const std::function<void()>& welcomed) {
  connection.guarded([&] {
    if (!connection.welcomed()) connection.handshake(solver);
    if (welcomed) welcomed();
  });
  serve(solver, connection, connection);
}

void serve(Solver& solver, Connection& connection, RequestSource& requests) {
  connection.guarded([&] {
    const ParticipantSettings& settings = connection.settings();
    answer_requests(solver, settings.receives, settings.sends, requests);
    connection.close();
  });
}

}  // namespace gabion
