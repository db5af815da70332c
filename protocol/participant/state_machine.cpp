// SPDX-License-Identifier: BSD-3-Clause
#include "protocol/participant/state_machine.hpp"

#include <fmt/format.h>

#include <algorithm>

#include "common/base/require.hpp"
#include "protocol/wire/exchange.hpp"
#include "protocol/wire/facets.hpp"
#include "protocol/wire/force_kinds.hpp"

namespace gabion {

RequestHandler::Answer RequestHandler::set_start(const InterfaceValues&) {
  throw ProtocolError("the coupler asked for \"set_start\" of a participant that takes none");
}

RequestHandler::Answer RequestHandler::set_facets(const InterfaceFacets&) {
  throw ProtocolError("the coupler asked for \"set_facets\" of a participant that takes none");
}

const std::vector<StateMachine::Rule>& StateMachine::rules() {
  static const std::vector<Rule> all = {
      {"solve_step", true, &StateMachine::solve},
      {"accept_step", true, &StateMachine::accept},
      {"reject_step", true, &StateMachine::reject},
      {"write_output", true, &StateMachine::write},
      {"summarize", true, &StateMachine::summarize},
      {"save", false, &StateMachine::save},
      {"load", false, &StateMachine::load},
      {"finish", true, &StateMachine::finish},
      {"set_force_kinds", false, &StateMachine::set_force_kinds},
      {"set_start", false, &StateMachine::set_start},
      {"set_facets", false, &StateMachine::set_facets},
  };
  return all;
}

StateMachine::StateMachine(RequestHandler& handler, std::string receives,
                           std::vector<InterfaceMesh> interfaces, std::string self)
    : handler_(handler),
      receives_(std::move(receives)),
      interfaces_(std::move(interfaces)),
      self_(std::move(self)) {}

void StateMachine::refuse(const std::string& type) const {
  throw ProtocolError(
      fmt::format("the coupler asked for \"{}\", which {} does not know", type, self_));
}

std::optional<Message> StateMachine::handle(Message request) {
  const auto rule = std::find_if(rules().begin(), rules().end(),
                                 [&](const Rule& entry) { return request.type == entry.type; });
  if (rule == rules().end()) refuse(request.type);
  const bool inside = order_.has_solution() || handler_.is_inside_step();
  require<ProtocolError>(rule->inside_step || !inside,
                         "the coupler asked for \"{}\" in the middle of a step", request.type);
  return (this->*rule->handle)(std::move(request));
}

StateMachine::Answer StateMachine::set_force_kinds(Message request) {
  return handler_.set_force_kinds(read_force_kinds(request, interfaces_));
}

StateMachine::Answer StateMachine::set_start(Message request) {
  require<ProtocolError>(!order_.has_begun(),
                         "the coupler asked for \"set_start\" after an accepted step");
  return handler_.set_start(read_values(std::move(request), receives_, interfaces_));
}

StateMachine::Answer StateMachine::set_facets(Message request) {
  return handler_.set_facets(read_facets(request, interfaces_));
}

/// Solve from the accepted state, whatever was solved before.
StateMachine::Answer StateMachine::solve(Message request) {
  const auto range = read_dt_range(request);
  if (range && !range->contains(proposed_dt_)) return new_message("passed");
  const StepRequest step = read_step_request(request);
  InterfaceValues received;
  if (!request.arrays.empty()) received = read_values(std::move(request), receives_, interfaces_);
  order_.check(step);
  order_.reject();
  Answer answer = handler_.solve_step(step, std::move(received));
  if (answer && answer->type == "solved") order_.solved(step);
  return answer;
}

StateMachine::Answer StateMachine::accept(Message request) {
  const StepRequest step = read_step_request(request);
  const bool with_solution = request.boolean("solved");
  require<ProtocolError>(
      !request.fields.contains("write_output") || !request.boolean("write_output"),
      "the coupler asks for output by \"accept_step\", allowed: by \"write_output\"");
  order_.accept(step, with_solution);
  Answer answer = handler_.accept_step(step, with_solution);
  proposed_dt_ = answer ? answer->number("proposed_dt") : 0;  // one that follows later has none
  return answer;
}

StateMachine::Answer StateMachine::reject(Message) {
  Answer answer = handler_.reject_step();
  order_.reject();
  return answer;
}

StateMachine::Answer StateMachine::write(Message request) {
  return handler_.write_output(request.number("time"));
}

StateMachine::Answer StateMachine::save(Message request) {
  return handler_.save_state(request.fields.contains("file") ? request.text("file") : "");
}

StateMachine::Answer StateMachine::load(Message request) {
  Answer answer = handler_.load_state(request);
  order_.forget();
  return answer;
}

StateMachine::Answer StateMachine::summarize(Message) {
  return handler_.summarize();
}

StateMachine::Answer StateMachine::finish(Message) {
  finished_ = true;
  return new_message("finished");
}

}  // namespace gabion
