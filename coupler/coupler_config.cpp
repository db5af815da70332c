// SPDX-License-Identifier: BSD-3-Clause
#include "coupler/coupler_config.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <map>
#include <set>

#include "protocol/handshake.hpp"

namespace gabion {

std::string name(Scheme scheme) {
  switch (scheme) {
    case Scheme::serial_implicit:
      return "serial_implicit";
    case Scheme::parallel_implicit:
      return "parallel_implicit";
    case Scheme::explicit_:
      return "explicit";
  }
  return "unknown";
}

namespace {

DtByIterations read_step_control(ConfigReader in) {
  DtByIterations control;
  control.few = in.integer_or("few", control.few, non_negative());
  control.many = in.integer_or("many", control.many, non_negative());
  in.finish();
  if (control.many > 0 && control.many <= control.few) {
    in.fail("many", fmt::format("found {}, allowed: 0 (off) or more than few = {}", control.many,
                                control.few));
  }
  return control;
}

CouplingSettings read_coupling(ConfigReader in) {
  static const std::map<std::string, OnLimit> on_limit = {
      {"cut", OnLimit::cut}, {"stop", OnLimit::stop}, {"accept", OnLimit::accept}};
  CouplingSettings s;
  static const std::map<std::string, Scheme> schemes = {
      {name(Scheme::serial_implicit), Scheme::serial_implicit},
      {name(Scheme::parallel_implicit), Scheme::parallel_implicit},
      {name(Scheme::explicit_), Scheme::explicit_}};
  s.scheme = schemes.at(
      in.choice_or("scheme", {"serial_implicit", "parallel_implicit", "explicit"}, name(s.scheme)));
  const bool implicit = s.scheme != Scheme::explicit_;
  s.max_iterations = in.integer_or("max_iterations", s.max_iterations, at_least(2));
  s.on_limit = on_limit.at(in.choice_or("on_limit", {"cut", "stop", "accept"}, "cut"));
  s.predictor = in.integer_or("predictor", s.predictor, between(0, 2));
  s.step_control = read_step_control(in.object_or_empty("step_control"));
  s.acceleration = read_acceleration_settings(in.object_or_empty("acceleration"));
  if (implicit || in.has("convergence")) {
    s.convergence = read_convergence_settings(in.object("convergence"));
  }
  s.mapping = read_mapping_settings(in.object("mapping"));
  in.finish();
  return s;
}

std::vector<ParticipantRole> read_participants(ConfigReader& in) {
  std::vector<ParticipantRole> result;
  for (auto& [name, entry] : in.named_objects("participants")) {
    if (!is_participant_name(name)) {
      in.fail("participants", fmt::format("found the name {}, allowed: 1 to 64 letters, digits, _, "
                                          "- and .",
                                          Json(name).dump()));
    }
    const std::string sends = entry.choice("sends", {"force", "displacement"});
    std::vector<std::string> command;
    if (entry.has("command")) {
      command = entry.texts("command");
      if (command.empty() || command.front().empty()) {
        entry.fail("command", "found no program, allowed: [program, argument, ...]");
      }
    }
    entry.finish();
    result.push_back({name, sends == "force", command});
  }
  return result;
}

void require_participant(const ConfigReader& entry, const std::string& key,
                         const std::string& found, const std::vector<ParticipantRole>& participants,
                         bool sends_force) {
  std::vector<std::string> allowed;
  for (const auto& p : participants) {
    if (p.sends_force == sends_force) allowed.push_back(p.name);
  }
  if (std::find(allowed.begin(), allowed.end(), found) != allowed.end()) return;
  entry.fail(key, fmt::format("found \"{}\", allowed: a participant that sends {}: {}", found,
                              sends_force ? "force" : "displacement", fmt::join(allowed, ", ")));
}

std::vector<InterfaceSettings> read_interfaces(ConfigReader& in,
                                               const std::vector<ParticipantRole>& participants) {
  std::vector<InterfaceSettings> result;
  std::set<std::string> names;
  std::set<std::string> used;
  for (auto& entry : in.objects("interfaces")) {
    const InterfaceSettings s{entry.name("name"), entry.text("soil"), entry.text("structure")};
    entry.finish();
    if (!names.insert(s.name).second) {
      entry.fail("name", fmt::format("found \"{}\" twice, allowed: each name once", s.name));
    }
    require_participant(entry, "soil", s.soil, participants, true);
    require_participant(entry, "structure", s.structure, participants, false);
    used.insert({s.soil, s.structure});
    result.push_back(s);
  }
  if (result.empty()) in.fail("interfaces", "found none, allowed: one or more");
  for (const auto& p : participants) {
    if (!used.contains(p.name)) {
      in.fail("participants/" + p.name, "no entry of \"interfaces\" names this participant");
    }
  }
  return result;
}

}  // namespace

CouplerSettings read_coupler_settings(ConfigReader in) {
  CouplerSettings s;
  s.time = read_time_settings(in.object("time"));
  ConfigReader output = in.object("output");
  s.output_interval = output.number("interval", positive());
  output.finish();
  s.checkpoint = read_checkpoint_settings(in);
  s.participants = read_participants(in);
  s.interfaces = read_interfaces(in, s.participants);
  s.coupling = read_coupling(in.object("coupling"));
  s.server = read_server_settings(in.object_or_empty("protocol"));
  in.finish();
  return s;
}

}  // namespace gabion
