// SPDX-License-Identifier: BSD-3-Clause
#include "coupler/coupler_config.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <map>
#include <set>

#include "protocol/wire/handshake.hpp"

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

KeyTable step_control_keys() {
  const DtByIterations defaults;
  return {"step_control",
          "Size of the next step by the number of coupling iterations that the last one needed.",
          {key::integer("few",
                        "dt may grow only while steps need no more iterations than this; 0: off.")
               .in(non_negative())
               .or_else(defaults.few),
           key::integer("many",
                        "The next step is halved after one that needed this many or more; larger "
                        "than `few`; 0: off.")
               .in(non_negative())
               .or_else(defaults.many)}};
}

KeyTable coupling_keys() {
  const CouplingSettings defaults;
  return {
      "coupling",
      "How a step is solved.",
      {key::choice(
           "scheme", {"serial_implicit", "parallel_implicit", "explicit"},
           "`serial_implicit`: soil, then structure, until they agree; `parallel_implicit`: both "
           "at once, until they agree; `explicit`: soil, then structure, once.")
           .or_else(name(defaults.scheme)),
       key::integer("max_iterations", "Largest number of coupling iterations in a step.")
           .in(at_least(2))
           .or_else(defaults.max_iterations),
       key::choice(
           "on_limit", {"cut", "stop", "accept"},
           "What happens to a step that does not converge. `cut`: it is repeated with half of dt; "
           "`stop`: the run ends; `accept`: it is accepted after `max_iterations` or when it "
           "stagnates.")
           .or_else("cut"),
       key::integer("predictor",
                    "Order of the extrapolation from accepted steps that gives the "
                    "first guess of a step.")
           .in(between(0, 2))
           .or_else(defaults.predictor),
       key::object("step_control", step_control_keys(),
                   "Size of the next step by the number of iterations.")
           .or_empty(),
       key::object("acceleration", acceleration_keys(), "How the next guess is made.").or_empty(),
       key::object("convergence", convergence_keys(), "When a step has converged.")
           .when("scheme", {"serial_implicit", "parallel_implicit"}),
       key::object("convergence", convergence_keys(), "Not used.")
           .or_none()
           .when("scheme", {"explicit"}),
       key::object("mapping", mapping_keys(),
                   "Mapping between the vertices of soil and structure.")}};
}

KeyTable participant_keys() {
  return {
      "participant",
      "A program or foreign code that takes part. Its name: 1 to 64 letters, digits, `_`, `-`, "
      "`.`.",
      {key::choice("sends", {"force", "displacement"},
                   "A soil sends force, a structure displacement."),
       key::texts("command",
                  "Program and arguments of a foreign code or a further solver, which "
                  "`scripts/run` starts in the scene's folder with `--coupler ENDPOINT` appended.")
           .not_empty()
           .or_none()}};
}

KeyTable interface_keys() {
  return {"interface",
          "A surface that a soil and a structure share.",
          {key::plain_name("Name by which both participants know it; each interface has its own."),
           key::text("soil", "Participant that sends force."),
           key::text("structure", "Participant that sends displacement."),
           key::vector("moment_about", "m",
                       "Point about which steps.csv gives the moment on the structure, such as its "
                       "foot; none: the origin.")
               .or_none()}};
}

DtByIterations read_step_control(ConfigReader in) {
  DtByIterations control;
  control.few = in.integer("few");
  control.many = in.integer("many");
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
  s.scheme = schemes.at(in.choice("scheme"));
  const bool implicit = s.scheme != Scheme::explicit_;
  s.max_iterations = in.integer("max_iterations");
  s.on_limit = on_limit.at(in.choice("on_limit"));
  s.predictor = in.integer("predictor");
  s.step_control = read_step_control(in.object("step_control"));
  s.acceleration = read_acceleration_settings(in.object("acceleration"));
  if (implicit || in.has("convergence")) {
    s.convergence = read_convergence_settings(in.object("convergence"));
  }
  if (s.scheme == Scheme::parallel_implicit && !s.convergence.force.given()) {
    in.fail(
        "convergence",
        "found no \"force\" with the scheme \"parallel_implicit\", allowed: limits of \"force\", "
        "with those of \"displacement\" or without: the structure's answer to a force that was "
        "guessed says nothing of the soil's");
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
    const std::string sends = entry.choice("sends");
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

/// Fail because no participant sends a quantity that one side of every interface has to send.
[[noreturn]] void fail_for_lack_of_senders(ConfigReader& in, const std::string& key,
                                           const std::string& found,
                                           const std::vector<ParticipantRole>& participants,
                                           const std::string& what) {
  const auto named = std::find_if(participants.begin(), participants.end(),
                                  [&](const ParticipantRole& p) { return p.name == found; });
  if (named == participants.end()) {
    in.fail("participants", fmt::format("found none that sends {}, allowed: one or more", what));
  }
  in.fail(fmt::format("participants/{}/sends", found),
          fmt::format("found \"{}\" of a participant that \"interfaces\" names as {}, allowed: {}",
                      named->sends_force ? "force" : "displacement", key, what));
}

void require_participant(ConfigReader& in, const ConfigReader& entry,
                         const InterfaceSettings& names,
                         const std::vector<ParticipantRole>& participants, bool sends_force) {
  const std::string key = sends_force ? "soil" : "structure";
  const std::string& found = sends_force ? names.soil : names.structure;
  std::vector<std::string> allowed;
  for (const auto& p : participants) {
    if (p.sends_force == sends_force) allowed.push_back(p.name);
  }
  if (std::find(allowed.begin(), allowed.end(), found) != allowed.end()) return;
  const std::string what = sends_force ? "force" : "displacement";
  if (allowed.empty()) fail_for_lack_of_senders(in, key, found, participants, what);
  entry.fail(key, fmt::format("found \"{}\", allowed: a participant that sends {}: {}", found, what,
                              fmt::join(allowed, ", ")));
}

std::vector<InterfaceSettings> read_interfaces(ConfigReader& in,
                                               const std::vector<ParticipantRole>& participants) {
  std::vector<InterfaceSettings> result;
  std::set<std::string> names;
  std::set<std::string> used;
  for (auto& entry : in.objects("interfaces")) {
    InterfaceSettings s{entry.name("name"), entry.text("soil"), entry.text("structure")};
    s.moment_about = entry.optional_vector("moment_about").value_or(std::vector<double>{});
    s.where = fmt::format("{}/{}", in.where("interfaces"), result.size());
    entry.finish();
    if (!names.insert(s.name).second) {
      entry.fail("name", fmt::format("found \"{}\" twice, allowed: each name once", s.name));
    }
    for (const bool force : {true, false}) require_participant(in, entry, s, participants, force);
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

KeyTable coupler_keys() {
  return {
      "coupler",
      "Settings of the coupler and of the run.",
      {key::schema(), key::object("time", time_keys(), "Steps of the run."),
       key::object("output", output_keys(), "Frames of the run."),
       key::object("checkpoint", checkpoint_keys(), "Checkpoints of the run.").or_empty(),
       key::named_objects("participants", participant_keys(), "Programs that take part, by name."),
       key::objects("interfaces", interface_keys(), "Surfaces that are coupled.").not_empty(),
       key::object("coupling", coupling_keys(), "How a step is solved."),
       key::object("protocol", server_keys(), "Connection between the programs.").or_empty()}};
}

CouplerSettings read_coupler_settings(ConfigReader in) {
  CouplerSettings s;
  s.time = read_time_settings(in.object("time"));
  ConfigReader output = in.object("output");
  s.output_interval = output.number("interval");
  output.finish();
  s.checkpoint = read_checkpoint_settings(in);
  s.participants = read_participants(in);
  s.interfaces = read_interfaces(in, s.participants);
  s.coupling = read_coupling(in.object("coupling"));
  s.server = read_server_settings(in.object("protocol"));
  if (in.has("$schema")) in.text("$schema");
  in.finish();
  return s;
}

}  // namespace gabion
