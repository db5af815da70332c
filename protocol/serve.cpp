// SPDX-License-Identifier: BSD-3-Clause
#include "protocol/serve.hpp"

#include <fmt/format.h>

#include "common/base/require.hpp"
#include "common/base/timer.hpp"
#include "protocol/exchange.hpp"
#include "protocol/step_order.hpp"

namespace gabion {
namespace {

/// The solver as the coupler's requests drive it.
class Service {
 public:
  Service(Solver& solver, const ParticipantSettings& settings)
      : solver_(solver), settings_(settings), interfaces_(solver.interfaces()) {}

  Message answer(Message request) {
    const Stopwatch busy;
    Message reply = dispatch(std::move(request));
    reply.fields["busy_seconds"] = busy.seconds();
    return reply;
  }

 private:
  Message dispatch(Message request) {
    if (request.type == "solve_step") return solve(std::move(request));
    if (request.type == "accept_step") return accept(request);
    if (request.type == "reject_step") return reject();
    if (request.type == "write_output") return write(request);
    if (request.type == "summarize") return summarize();
    if (request.type == "save") return save(request);
    if (request.type == "load") return load(request);
    if (request.type == "finish") return new_message("finished");
    throw ProtocolError(fmt::format("the coupler asked for \"{}\", which protocol {} does not know",
                                    request.type, protocol_version));
  }

  Message solve(Message request) {
    const StepRequest step = read_step_request(request);
    InterfaceValues received;
    if (!request.arrays.empty()) {
      received = read_values(std::move(request), settings_.receives.name, interfaces_);
    }
    InterfaceValues sent;
    order_.check(step);
    order_.reject();
    try {
      const StepReport report = solver_.solve_step(step, received, sent);
      order_.solved(step);
      Message reply = new_message("solved");
      put(reply, report);
      put_values(reply, settings_.sends.name, interfaces_, std::move(sent));
      return reply;
    } catch (const ConvergenceError& problem) {
      Message reply = new_message("failed");
      reply.fields["reason"] = problem.what();
      return reply;
    }
  }

  Message accept(const Message& request) {
    const StepRequest step = read_step_request(request);
    const bool solved = request.boolean("solved");
    order_.accept(step, solved);
    const AcceptReport report = solver_.accept_step(step, solved);
    if (request.boolean("write_output")) solver_.write_output(request.number("output_time"));
    Message reply = new_message("accepted");
    put(reply, report);
    return reply;
  }

  Message reject() {
    solver_.reject_step();
    order_.reject();
    return new_message("rejected");
  }

  Message write(const Message& request) {
    solver_.write_output(request.number("time"));
    return new_message("written");
  }

  Message summarize() {
    Message reply = new_message("summary");
    reply.fields["summary"] = solver_.summary();
    return reply;
  }

  Message save(const Message& request) {
    require_between_steps(request);
    return saved(solver_.save_state());
  }

  Message load(const Message& request) {
    require_between_steps(request);
    solver_.load_state(read_state(request));
    order_.forget();
    return loaded(solver_.probes());
  }

  void require_between_steps(const Message& request) const {
    require<ProtocolError>(!order_.has_solution(),
                           "the coupler asked for \"{}\" in the middle of a step", request.type);
  }

  Solver& solver_;
  const ParticipantSettings& settings_;
  std::vector<InterfaceMesh> interfaces_;
  StepOrder order_;
};

void answer_requests(Solver& solver, Connection& connection,
                     const std::function<void()>& welcomed) {
  if (!connection.welcomed()) connection.handshake(solver);
  if (welcomed) welcomed();
  Service service(solver, connection.settings());
  for (;;) {
    Message request = connection.next_request();
    const bool last = request.type == "finish";
    connection.reply(service.answer(std::move(request)));
    if (last) break;
  }
  connection.close();
}

}  // namespace

void serve(Solver& solver, Connection& connection, const std::function<void()>& welcomed) {
  try {
    answer_requests(solver, connection, welcomed);
  } catch (const std::exception& problem) {
    connection.abort(problem.what());
    throw;
  } catch (...) {
    connection.abort("an exception of unknown type");
    throw;
  }
}

}  // namespace gabion
