// SPDX-License-Identifier: BSD-3-Clause
#include "protocol/participant.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>

#include "common/base/log.hpp"
#include "common/base/require.hpp"
#include "protocol/wire/exchange.hpp"

namespace gabion {
namespace {

constexpr double same_time = 1e-12;  // share of a step: less is round-off of sub-steps

Message accepted_of(const std::vector<double>& probes) {
  AcceptReport report;
  report.probes = probes;
  Message message = new_message("accepted");
  put(message, report);
  return message;
}

}  // namespace

Participant::Participant(ParticipantSettings settings) : settings_(std::move(settings)) {
  require<UsageError>(settings_.dimension == 2 || settings_.dimension == 3,
                      "dimension: found {}, allowed: 2 or 3", settings_.dimension);
}

Participant::~Participant() = default;

void Participant::set_interface(const std::string& name, std::span<const double> coordinates,
                                int vertices_per_facet, std::span<const std::int64_t> facets) {
  before_initialize("set_interface");
  const auto dim = static_cast<std::size_t>(settings_.dimension);
  require<UsageError>(!coordinates.empty() && coordinates.size() % dim == 0,
                      "interface \"{}\": found {} coordinates, allowed: num_vertices x {}", name,
                      coordinates.size(), dim);
  require<UsageError>(
      vertices_per_facet == 0 || (vertices_per_facet >= 2 && vertices_per_facet <= 4),
      "interface \"{}\": found {} vertices per facet, allowed: 0, 2, 3, 4", name,
      vertices_per_facet);
  const std::size_t width = vertices_per_facet == 0 ? 1 : std::size_t(vertices_per_facet);
  require<UsageError>(facets.size() % width == 0 && (vertices_per_facet > 0 || facets.empty()),
                      "interface \"{}\": found {} facet entries, allowed: num_facets x {}", name,
                      facets.size(), vertices_per_facet);
  meshes_.push_back({name,
                     settings_.dimension,
                     {coordinates.begin(), coordinates.end()},
                     vertices_per_facet,
                     {facets.begin(), facets.end()}});
}

void Participant::set_force_kind(const std::string& interface, ForceKind kind) {
  before_initialize("set_force_kind");
  require<UsageError>(settings_.sends == force(),
                      "set_force_kind: found a participant that sends {}, allowed: one that sends "
                      "force",
                      settings_.sends.name);
  const InterfaceMesh& surface = mesh(interface);
  meshes_[static_cast<std::size_t>(&surface - meshes_.data())].force_kind = kind;
}

void Participant::set_probes(std::vector<std::string> names, std::span<const double> values) {
  before_initialize("set_probes");
  probe_names_ = std::move(names);
  write_probes(values);
}

void Participant::write_probes(std::span<const double> values) {
  require<UsageError>(values.size() == probe_names_.size(),
                      "probes: found {} values, allowed: as many as names, {}", values.size(),
                      probe_names_.size());
  probes_.assign(values.begin(), values.end());
}

void Participant::set_output(std::function<void(double)> write) {
  before_initialize("set_output");
  output_ = std::move(write);
}

void Participant::set_summary(Json summary) {
  summary_ = std::move(summary);
}

void Participant::initialize() {
  before_initialize("initialize");
  require<UsageError>(!meshes_.empty(), "interfaces: found none, allowed: one or more");
  // The hello is read back by the rules of the coupler, so that what it would refuse is found here.
  accepted_probes_ = probes_;
  const Introduction introduction{.interfaces = meshes_,
                                  .probe_names = probe_names_,
                                  .probes = probes_,
                                  .keeps_state = save_ != nullptr,
                                  .takes_force_kinds = settings_.receives == force(),
                                  .start = start_,
                                  .takes_start = take_start_ != nullptr,
                                  .takes_facets = take_facets_ != nullptr,
                                  .changing = facets_.names()};
  try {
    read_hello(to_message(hello_of(settings_, introduction)));
  } catch (const ProtocolError& problem) {
    throw UsageError(problem.what());
  }
  connection_ = std::make_unique<Connection>(settings_);
  machine_ = std::make_unique<StateMachine>(static_cast<RequestHandler&>(*this),
                                            settings_.receives.name, meshes_, "this participant");
  connection_->guarded([&] { connection_->handshake(introduction); });
  must_write_ = true;
  settle();
}

const Json& Participant::run_settings() const {
  after_initialize();
  return connection_->run_settings();
}

bool Participant::is_coupling_ongoing() {
  settle();
  return !machine_->is_finished();
}

bool Participant::is_time_window_complete() const {
  after_initialize();
  return window_complete_;
}

double Participant::get_max_time_step_size() {
  settle();
  return remaining_;
}

double Participant::get_time() {
  return open_step("get_time").time;
}

bool Participant::requires_writing_checkpoint() {
  settle();
  return std::exchange(must_write_, false) && !machine_->is_finished();
}

bool Participant::requires_reading_checkpoint() {
  after_initialize();
  return std::exchange(must_read_, false);
}

ForceKind Participant::force_kind(const std::string& interface) {
  settle();
  asked_force_kind_ = true;
  const auto found = force_kinds_.find(mesh(interface).name);
  return found == force_kinds_.end() ? ForceKind::end_of_step : found->second;
}

/// Warn once a code that never asked for the kind of its forces.
void Participant::warn_of_step_means() {
  for (const auto& [name, kind] : force_kinds_) {
    if (asked_force_kind_ || kind == ForceKind::end_of_step) continue;
    log::warn(
        "interface \"{}\": its forces are means over the step; this code does not ask "
        "force_kind(), so it may take them as those of its end",
        name);
    asked_force_kind_ = true;
  }
}

std::vector<double> Participant::read_data(const std::string& interface) {
  open_step("read_data");
  const InterfaceMesh& surface = mesh(interface);
  if (!received_.empty()) return received_.at(interface);
  require<ProtocolError>(
      settings_.receives == force(),
      "the coupler gives no displacement of \"{}\" in this step: the interface is free", interface);
  return std::vector<double>(surface.coordinates.size(), 0.0);  // a free surface carries no force
}

void Participant::write_data(const std::string& interface, std::span<const double> values) {
  open_step("write_data");
  const std::size_t expected = num_values(interface);
  require<UsageError>(values.size() == expected,
                      "write_data: found {} values for \"{}\", allowed: {}", values.size(),
                      interface, expected);
  written_[interface].assign(values.begin(), values.end());
}

void Participant::advance(double dt, const StepReport& report) {
  const StepRequest& request = checked_step("advance");
  warn_of_step_means();
  const double tolerance = same_time * request.dt;
  require<UsageError>(dt > 0 && dt <= remaining_ + tolerance,
                      "advance: found dt {} s, allowed: > 0 and at most {} s", dt, remaining_);
  window_complete_ = false;
  remaining_ -= dt;
  if (remaining_ > tolerance) return;
  for (const InterfaceMesh& surface : meshes_) {
    require<UsageError>(written_.contains(surface.name), "advance: nothing was written for \"{}\"",
                        surface.name);
  }
  Message answer = new_message("solved");
  put(answer, report);
  put_values(answer, settings_.sends.name, meshes_, std::move(written_));
  const StepRequest solved = request;  // answer_step() closes the open one
  answer_step(std::move(answer));
  machine_->solved(solved);
  connection_->guarded([this] { await_verdict(); });
}

void Participant::fail_step(const std::string& reason) {
  checked_step("fail_step");
  window_complete_ = false;
  Message answer = new_message("failed");
  answer.fields["reason"] = reason;
  answer_step(std::move(answer));
  connection_->guarded([this] { await_verdict(); });
}

void Participant::finalize() {
  if (!connection_) return;
  if (!machine_->is_finished()) {
    connection_->abort("the participant ended before the run was finished");
  }
  connection_->close();
}

/// Wait until a step is open, or the run is finished.
void Participant::settle() {
  after_initialize();
  if (request_ || machine_->is_finished()) return;
  require<UsageError>(
      !must_read_,
      "the last step was not accepted: call requires_reading_checkpoint() and go back first");
  connection_->guarded([this] { await_step(); });
}

void Participant::await_step() {
  if (pending_) {
    reply(std::move(*pending_));
    pending_.reset();
  }
  while (!request_ && !machine_->is_finished()) do_next_request();
}

/// Serve after an answer to solve_step until the coupler accepts it, rejects it or asks again.
void Participant::await_verdict() {
  while (awaits_verdict_ && !machine_->is_finished()) do_next_request();
}

void Participant::do_next_request() {
  Message request = connection_->next_request();
  busy_ = Stopwatch();
  if (auto answer = machine_->handle(std::move(request))) reply(std::move(*answer));
  if (machine_->is_finished()) connection_->close();
}

Participant::Answer Participant::set_force_kinds(const ForceKinds& kinds) {
  force_kinds_ = kinds;
  return new_message("force_kinds_set");
}

Participant::Answer Participant::solve_step(const StepRequest& step, InterfaceValues received) {
  if (std::exchange(awaits_verdict_, false)) must_read_ = true;
  received_ = std::move(received);
  written_.clear();
  remaining_ = step.dt;
  request_ = step;
  return {};
}

Participant::Answer Participant::accept_step(const StepRequest&, bool solved) {
  const bool was_tried = std::exchange(awaits_verdict_, false);
  if (was_tried && !solved) {
    must_read_ = true;  // accepted as if it had not been asked: the accepted state stays
  } else if (was_tried) {
    accepted_probes_ = probes_;
    must_write_ = window_complete_ = true;
  }
  Message answer = accepted_of(accepted_probes_);
  if (!was_tried) return answer;
  pending_ = std::move(answer);
  return {};
}

Participant::Answer Participant::reject_step() {
  Message answer = new_message("rejected");
  if (!std::exchange(awaits_verdict_, false)) return answer;
  must_read_ = true;
  pending_ = std::move(answer);
  return {};
}

Participant::Answer Participant::write_output(double time) {
  require<ProtocolError>(!awaits_verdict_ || !output_,
                         "the coupler wants the accepted state on disk in the middle of a step: "
                         "this participant writes it between steps only");
  if (output_) output_(time);
  return new_message("written");
}

Participant::Answer Participant::summarize() {
  return new_message("summary", {{"summary", summary_}});
}

void Participant::reply(Message message) {
  if (message.type == "accepted") facets_.put_changed(message, meshes_);
  message.fields["busy_seconds"] = busy_.seconds();
  connection_->reply(std::move(message));
}

void Participant::answer_step(Message message) {
  connection_->guarded([&] { reply(std::move(message)); });
  request_.reset();
  remaining_ = 0;
  awaits_verdict_ = true;
}

void Participant::before_initialize(const char* call) const {
  require<UsageError>(!connection_, "{}: allowed before initialize() only, once", call);
}

void Participant::after_initialize() const {
  require<UsageError>(connection_ != nullptr, "initialize() comes first");
}

const StepRequest& Participant::open_step(const char* call) {
  settle();
  require<UsageError>(request_.has_value(), "{}: the coupling has ended; ask is_coupling_ongoing()",
                      call);
  return *request_;
}

const StepRequest& Participant::checked_step(const char* call) {
  const StepRequest& request = open_step(call);
  for (const auto& [due, question] : {std::pair(must_read_, "requires_reading_checkpoint"),
                                      std::pair(must_write_, "requires_writing_checkpoint")}) {
    require<UsageError>(!due, "{}: call {}() in this step first, or repeated steps are spoilt",
                        call, question);
  }
  return request;
}

const InterfaceMesh& Participant::mesh(const std::string& name) const {
  const auto found = std::find_if(meshes_.begin(), meshes_.end(),
                                  [&](const InterfaceMesh& m) { return m.name == name; });
  std::vector<std::string> names;
  for (const InterfaceMesh& surface : meshes_) names.push_back(surface.name);
  require<UsageError>(found != meshes_.end(), "found interface \"{}\", allowed: {}", name, names);
  return *found;
}

std::size_t Participant::num_values(const std::string& interface) const {
  return mesh(interface).coordinates.size();
}

}  // namespace gabion
