// SPDX-License-Identifier: BSD-3-Clause
#include "protocol/server/remote_solver.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <filesystem>
#include <system_error>
#include <utility>

#include "common/base/require.hpp"
#include "common/run/repeated_failure.hpp"
#include "protocol/wire/exchange.hpp"
#include "protocol/wire/facets.hpp"
#include "protocol/wire/force_kinds.hpp"

namespace gabion {

RemoteSolver::RemoteSolver(Switchboard& switchboard, Hello hello)
    : switchboard_(switchboard), hello_(std::move(hello)), probes_(hello_.probes) {
  for (const InterfaceMesh& mesh : hello_.interfaces) {
    if (std::ranges::find(hello_.changing, mesh.name) == hello_.changing.end()) continue;
    facets_[mesh.name] = mesh.facets;
  }
}

void RemoteSolver::set_force_kinds(const ForceKinds& kinds) {
  call(to_message(kinds), "force_kinds_set");
}

void RemoteSolver::set_start(const InterfaceValues& displacements) {
  Message message = new_message("set_start");
  put_values(message, hello_.receives.name, hello_.interfaces, displacements);
  take_probes(call(std::move(message), "start_set"));
}

void RemoteSolver::set_facets(const InterfaceFacets& facets) {
  Message message = new_message("set_facets");
  put_facets(message, hello_.interfaces, facets);
  call(std::move(message), "facets_set");
}

StepReport RemoteSolver::solve_step(const StepRequest& request, const InterfaceValues& received,
                                    InterfaceValues& sent) {
  start_solve(request, received);
  return finish_solve(sent);
}

Message RemoteSolver::solve_request(const StepRequest& request,
                                    const InterfaceValues& received) const {
  Message message = new_message("solve_step");
  put(message, request);
  if (!received.empty()) {
    put_values(message, hello_.receives.name, hello_.interfaces, received);
  }
  return message;
}

void RemoteSolver::start_solve(const StepRequest& request, const InterfaceValues& received) {
  start(solve_request(request, received));
}

void RemoteSolver::start_next(const StepRequest& request, const InterfaceValues& received,
                              const DtRange& proposed) {
  require<ProtocolError>(
      takes_next_step() && outstanding_.size() == 1 && outstanding_.front().type == "accept_step",
      "participant \"{}\": step {} asked for at the wrong time", name(), request.step);
  Message message = solve_request(request, received);
  put(message, proposed);
  send(std::move(message));
}

void RemoteSolver::call_off_solve() {
  if (finish({"solved", "failed", "passed"}).type == "passed") return;
  const CallTimes solution = last_call_;
  reject_step();
  last_call_.seconds += solution.seconds;
  last_call_.busy_seconds += solution.busy_seconds;
}

ConvergenceError RemoteSolver::failure(const Message& reply) const {
  return switchboard_.guarded([&] {
    const bool at_any_dt = reply.fields.contains("at_any_dt") && reply.boolean("at_any_dt");
    return ConvergenceError(fmt::format("participant \"{}\": {}", name(), reply.text("reason")),
                            at_any_dt ? fails_at_any_dt : "other");
  });
}

StepReport RemoteSolver::finish_solve(InterfaceValues& sent) {
  Message reply = finish({"solved", "failed"});
  if (reply.type == "failed") throw failure(reply);
  return switchboard_.guarded([&] {
    try {
      const StepReport report = read_step_report(reply);
      sent = read_values(std::move(reply), hello_.sends.name, hello_.interfaces);
      return report;
    } catch (const ProtocolError& problem) {
      throw ProtocolError(
          fmt::format("participant \"{}\" answered wrongly: {}", name(), problem.what()));
    }
  });
}

void RemoteSolver::start_accept(const StepRequest& request, bool solved) {
  Message message = new_message("accept_step");
  put(message, request);
  message.fields["solved"] = solved;
  message.fields["write_output"] = false;  // participants up to 1.3 read it
  start(std::move(message));
}

AcceptReport RemoteSolver::finish_accept() {
  const Message reply = finish({"accepted"});
  return switchboard_.guarded([&] {
    try {
      const AcceptReport report = read_accept_report(reply, hello_.probe_names.size());
      probes_ = report.probes;
      for (auto& [name, facets] : read_facets(reply, hello_.interfaces)) {
        require<ProtocolError>(facets_.contains(name),
                               "found facets of interface \"{}\", allowed: of those with "
                               "\"facets_may_change\" in the hello",
                               name);
        facets_[name] = facets;
      }
      return report;
    } catch (const ProtocolError& problem) {
      throw ProtocolError(
          fmt::format("participant \"{}\" answered wrongly: {}", name(), problem.what()));
    }
  });
}

AcceptReport RemoteSolver::accept_step(const StepRequest& request, bool solved) {
  start_accept(request, solved);
  return finish_accept();
}

void RemoteSolver::reject_step() {
  call(new_message("reject_step"), "rejected");
}

void RemoteSolver::write_output(double time) {
  Message message = new_message("write_output");
  message.fields["time"] = time;
  call(std::move(message), "written");
}

Json RemoteSolver::summary() const {
  return call(new_message("summarize"), "summary").field("summary");
}

State RemoteSolver::save_state() {
  const Message reply = call(new_message("save"), "saved");
  return switchboard_.guarded([&] { return read_state(reply); });
}

State RemoteSolver::save_state_to(const std::string& path) {
  Message request = new_message("save");
  request.fields["file"] = path;
  const Message reply = call(std::move(request), "saved");
  return switchboard_.guarded([&] {
    State state = read_state(reply);
    if (state.file.empty()) return state;
    std::error_code error;
    const auto found = std::filesystem::file_size(path, error);
    const std::int64_t bytes = reply.integer("file_bytes");
    require<ProtocolError>(state.file == path && !error && std::cmp_equal(found, bytes),
                           "participant \"{}\" says that it wrote {} bytes to {}: found {} in {}",
                           name(), bytes, state.file,
                           error ? error.message() : fmt::format("{} bytes", found), path);
    return state;
  });
}

void RemoteSolver::load_state(const State& state) {
  Message message = new_message("load");
  put(message, state);
  take_probes(call(std::move(message), "loaded"));
}

void RemoteSolver::take_probes(const Message& reply) {
  probes_ = switchboard_.guarded([&] {
    return reply.reals("probes", {static_cast<std::int64_t>(hello_.probe_names.size())});
  });
}

void RemoteSolver::start(Message request) const {
  require<ProtocolError>(outstanding_.empty(),
                         "participant \"{}\": \"{}\" asked before the answer "
                         "to \"{}\" was taken",
                         name(), request.type,
                         outstanding_.empty() ? "" : outstanding_.back().type);
  send(std::move(request));
}

void RemoteSolver::send(Message request) const {
  const std::string type = request.type;
  const Stopwatch watch;
  outstanding_.push_back({type, switchboard_.send(name(), std::move(request)), watch});
}

Message RemoteSolver::finish(const std::vector<std::string>& allowed) const {
  require<ProtocolError>(!outstanding_.empty(), "participant \"{}\": nothing was asked", name());
  Message reply = switchboard_.wait_reply(name(), outstanding_.front().sequence);
  switchboard_.guarded([&] {
    require<ProtocolError>(std::find(allowed.begin(), allowed.end(), reply.type) != allowed.end(),
                           "participant \"{}\" answered \"{}\" with \"{}\", expected {}", name(),
                           outstanding_.front().type, reply.type, allowed);
    note_times(reply);
  });
  outstanding_.pop_front();
  if (!outstanding_.empty()) outstanding_.front().watch = Stopwatch();  // its turn comes now
  return reply;
}

Message RemoteSolver::call(Message request, const std::string& reply) const {
  start(std::move(request));
  return finish({reply});
}

void RemoteSolver::note_times(const Message& reply) const {
  last_call_ = {1, outstanding_.front().watch.seconds(), reply.number("busy_seconds")};
  CallTimes& total = times_[outstanding_.front().type];
  total.count += 1;
  total.seconds += last_call_.seconds;
  total.busy_seconds += last_call_.busy_seconds;
}

}  // namespace gabion
