// SPDX-License-Identifier: BSD-3-Clause
#include "protocol/wire/exchange.hpp"

#include <fmt/format.h>

#include <cstring>
#include <filesystem>
#include <limits>

#include "common/base/require.hpp"
#include "protocol/wire/codec.hpp"

namespace gabion {

void put(Message& message, const StepRequest& request) {
  message.fields["step"] = request.step;
  message.fields["iteration"] = request.iteration;
  message.fields["time"] = request.time;
  message.fields["dt"] = request.dt;
}

namespace {

int small_integer(const Message& message, const std::string& key) {
  const std::int64_t value = message.integer(key);
  require<ProtocolError>(value >= 0 && value <= std::numeric_limits<int>::max(),
                         "message \"{}\", field \"{}\": expected a count, found {}", message.type,
                         key, value);
  return static_cast<int>(value);
}

const Json& object_field(const Message& message, const std::string& key) {
  const Json& value = message.field(key);
  require<ProtocolError>(value.is_object(),
                         "message \"{}\", field \"{}\": expected an object, found {}", message.type,
                         key, shortened(value));
  return value;
}

}  // namespace

StepRequest read_step_request(const Message& message) {
  StepRequest request;
  request.step = message.integer("step");
  request.iteration = small_integer(message, "iteration");
  request.time = message.number("time");
  request.dt = message.positive_number("dt");
  return request;
}

void put(Message& message, const DtRange& range) {
  message.fields["proposed_dt_from"] = range.from;
  if (range.below) message.fields["proposed_dt_below"] = *range.below;
}

std::optional<DtRange> read_dt_range(const Message& message) {
  if (!message.fields.contains("proposed_dt_from")) return std::nullopt;
  DtRange range{message.number("proposed_dt_from"), {}};
  if (message.fields.contains("proposed_dt_below")) {
    range.below = message.positive_number("proposed_dt_below");
  }
  return range;
}

void put(Message& message, const StepReport& report) {
  message.fields["newton_iterations"] = report.newton_iterations;
  message.fields["linear_iterations"] = report.linear_iterations;
  message.fields["interface_active"] = report.interface_active;
  message.fields["details"] = report.details;
}

StepReport read_step_report(const Message& message) {
  StepReport report;
  report.newton_iterations = small_integer(message, "newton_iterations");
  report.linear_iterations = message.integer("linear_iterations");
  report.interface_active = message.boolean("interface_active");
  report.details = object_field(message, "details");
  return report;
}

void put(Message& message, const AcceptReport& report) {
  message.fields["at_rest"] = report.at_rest;
  message.fields["proposed_dt"] = report.proposed_dt;
  message.fields["details"] = report.details;
  message.add("probes", {static_cast<std::int64_t>(report.probes.size())}, report.probes);
}

AcceptReport read_accept_report(const Message& message, std::size_t num_probes) {
  AcceptReport report;
  report.probes = message.reals("probes", {static_cast<std::int64_t>(num_probes)});
  report.at_rest = message.boolean("at_rest");
  report.proposed_dt = message.number("proposed_dt");
  require<ProtocolError>(report.proposed_dt >= 0,
                         "message \"{}\": expected proposed_dt >= 0, found {}", message.type,
                         report.proposed_dt);
  report.details = object_field(message, "details");
  return report;
}

void put_values(Message& message, const std::string& quantity,
                const std::vector<InterfaceMesh>& interfaces, InterfaceValues values) {
  require<ProtocolError>(values.size() == interfaces.size(),
                         "{}: expected values on {} interfaces, found {}", quantity,
                         interfaces.size(), values.size());
  for (const InterfaceMesh& mesh : interfaces) {
    const std::string name = quantity + ":" + mesh.name;
    const auto found = values.find(mesh.name);
    require<ProtocolError>(found != values.end(), "\"{}\" is missing", name);
    require<ProtocolError>(found->second.size() == mesh.coordinates.size(),
                           "\"{}\": expected {} x {} values, found {}", name, mesh.num_vertices(),
                           mesh.dim, found->second.size());
    require_finite(found->second, static_cast<std::size_t>(mesh.dim), name);
    message.add(name, {mesh.num_vertices(), mesh.dim}, std::move(found->second));
  }
}

InterfaceValues read_values(Message message, const std::string& quantity,
                            const std::vector<InterfaceMesh>& interfaces) {
  InterfaceValues values;
  for (const InterfaceMesh& mesh : interfaces) {
    const std::string name = quantity + ":" + mesh.name;
    auto list = message.take_reals(name, {mesh.num_vertices(), mesh.dim});
    require_finite(list, static_cast<std::size_t>(mesh.dim), name);
    values.emplace(mesh.name, std::move(list));
  }
  require<ProtocolError>(message.arrays.size() == interfaces.size(),
                         "message \"{}\": expected {} arrays, found {}", message.type,
                         interfaces.size(), message.arrays.size());
  return values;
}

namespace {

constexpr const char* real_prefix = "real:";
constexpr const char* integer_prefix = "integer:";
constexpr const char* bytes_name = "bytes";
constexpr std::size_t bytes_a_value = sizeof(std::int64_t);

}  // namespace

void put(Message& message, const State& state) {
  message.fields["state"] = state.facts;
  if (!state.file.empty()) message.fields["file"] = state.file;
  for (const auto& [name, values] : state.reals) {
    message.add(real_prefix + name, {static_cast<std::int64_t>(values.size())}, values);
  }
  for (const auto& [name, values] : state.integers) {
    message.add(integer_prefix + name, {static_cast<std::int64_t>(values.size())}, values);
  }
}

Message saved(const State& state) {
  Message message = new_message("saved");
  put(message, state);
  if (!state.file.empty()) {
    message.fields["file_bytes"] = std::filesystem::file_size(state.file);
  }
  return message;
}

Message loaded(const std::vector<double>& probes) {
  Message message = new_message("loaded");
  message.add("probes", {static_cast<std::int64_t>(probes.size())}, probes);
  return message;
}

Message start_set(const std::vector<double>& probes) {
  Message message = new_message("start_set");
  message.add("probes", {static_cast<std::int64_t>(probes.size())}, probes);
  return message;
}

State read_state(const Message& message) {
  State state;
  state.facts = object_field(message, "state");
  if (message.fields.contains("file")) state.file = message.text("file");
  for (const auto& array : message.arrays) {
    require<ProtocolError>(array.name.find('/') == std::string::npos,
                           "message \"{}\": array \"{}\" has a / in its name", message.type,
                           array.name);
    const std::string reals = real_prefix, integers = integer_prefix;
    if (array.name.starts_with(reals)) {
      state.reals[array.name.substr(reals.size())] = message.reals(array.name, {-1});
    } else if (array.name.starts_with(integers)) {
      state.integers[array.name.substr(integers.size())] = message.integers(array.name, {-1});
    }
  }
  return state;
}

State pack_bytes(std::span<const std::byte> bytes) {
  State state;
  state.facts[bytes_name] = bytes.size();
  std::vector<std::int64_t>& values = state.integers[bytes_name];
  values.resize((bytes.size() + bytes_a_value - 1) / bytes_a_value);
  if (!bytes.empty()) std::memcpy(values.data(), bytes.data(), bytes.size());
  return state;
}

std::vector<std::byte> unpack_bytes(const State& state) {
  const auto values = state.integers.find(bytes_name);
  const Json count = state.facts.value(bytes_name, Json());
  require<ProtocolError>(
      values != state.integers.end() && count.is_number_unsigned() &&
          values->second.size() == count.get<std::size_t>() / bytes_a_value +
                                       (count.get<std::size_t>() % bytes_a_value != 0),
      "state: expected an array of {} bytes, found {} values of 8 bytes", count.dump(),
      values == state.integers.end() ? 0 : values->second.size());
  std::vector<std::byte> bytes(count.get<std::size_t>());
  if (!bytes.empty()) std::memcpy(bytes.data(), values->second.data(), bytes.size());
  return bytes;
}

std::string describe(const Message& request) {
  if (request.type == "solve_step") {
    return fmt::format("solve_step {} iteration {}", request.integer("step"),
                       request.integer("iteration"));
  }
  if (request.type == "accept_step") {
    return fmt::format("accept_step {}", request.integer("step"));
  }
  return request.type;
}

}  // namespace gabion
