// SPDX-License-Identifier: BSD-3-Clause
#include "coupler/checks/scene_check.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <optional>

#include "common/base/require.hpp"

namespace gabion {

namespace {

using Names = std::vector<std::string>;

const ParticipantRole* find_role(const CouplerSettings& settings, const std::string& name) {
  const auto& all = settings.participants;
  const auto found = std::find_if(all.begin(), all.end(),
                                  [&](const ParticipantRole& role) { return role.name == name; });
  return found == all.end() ? nullptr : &*found;
}

bool contains(const Names& names, const std::string& name) {
  return std::find(names.begin(), names.end(), name) != names.end();
}

/// "soil: mpm.json, structure: fem.json"
std::string solver_files_text() {
  Names texts;
  for (const ProgramEntry& own : solver_programs())
    texts.push_back(own.participant + ": " + own.file);
  return fmt::format("{}", fmt::join(texts, ", "));
}

std::string list_text(const Names& names, const std::string& found) {
  if (names.empty()) return "none";
  return fmt::format("{}; did you mean \"{}\"?", fmt::join(names, ", "),
                     nearest_word(found, names));
}

/// Names of "interfaces" in order; empty when the list is not one that its solver will accept.
std::optional<Names> interface_names(const Json& file) {
  Names names;
  if (!file.is_object()) return std::nullopt;
  for (const Json& entry : file.value("interfaces", Json::array())) {
    if (!entry.is_object() || !entry.contains("name") || !entry.at("name").is_string()) {
      return std::nullopt;
    }
    names.push_back(entry.at("name").get<std::string>());
  }
  return names;
}

Names coupled_names(const CouplerSettings& settings, const std::string& participant) {
  Names names;
  for (const InterfaceSettings& entry : settings.interfaces) {
    if (entry.soil == participant || entry.structure == participant) names.push_back(entry.name);
  }
  return names;
}

void check_interfaces(const Scene& scene, const CouplerSettings& settings,
                      const ProgramEntry& own) {
  const auto there = interface_names(scene.settings().at(own.file));
  if (!there) return;
  for (std::size_t i = 0; i < settings.interfaces.size(); ++i) {
    const InterfaceSettings& entry = settings.interfaces[i];
    if (entry.soil != own.participant && entry.structure != own.participant) continue;
    require<ConfigError>(contains(*there, entry.name),
                         "{}: at /interfaces/{}/name: found \"{}\", allowed: an "
                         "interface of {} (participant \"{}\"): {}",
                         scene.path("coupler.json"), i, entry.name, own.file, own.participant,
                         list_text(*there, entry.name));
  }
  const Names coupled = coupled_names(settings, own.participant);
  for (std::size_t i = 0; i < there->size(); ++i) {
    const std::string& name = (*there)[i];
    require<ConfigError>(contains(coupled, name),
                         "{}: at /interfaces/{}/name: found \"{}\", which \"interfaces\" in "
                         "coupler.json does not couple for \"{}\"; allowed: {}",
                         scene.path(own.file), i, name, own.participant, list_text(coupled, name));
  }
}

/// 2 or 3; 0 when it is not what the solver will accept.
int dimension(const Json& file) {
  const Json found = file.is_object() ? file.value("dimension", Json()) : Json();
  return found == 2 ? 2 : found == 3 ? 3 : 0;
}

void check_dimensions(const Scene& scene, const std::vector<ProgramEntry>& files) {
  for (const ProgramEntry& own : files) {
    const ProgramEntry& first = files.front();
    const int found = dimension(scene.settings().at(own.file));
    const int expected = dimension(scene.settings().at(first.file));
    require<ConfigError>(found == expected || found == 0 || expected == 0,
                         "{}: at /dimension: found {} for \"{}\", allowed: {}, the "
                         "dimension of \"{}\" ({})",
                         scene.path(own.file), found, own.participant, expected, first.participant,
                         first.file);
  }
}

/// [m/s^2]; empty when it is not what the solver will accept, or part of a load beside matrices.
std::optional<std::vector<double>> gravity(const Json& file, std::size_t dim) {
  if (file.is_object() && file.contains("matrices")) return std::nullopt;
  if (!file.is_object() || !file.contains("gravity")) return std::vector<double>(dim, 0.0);
  std::vector<double> g;
  if (!file.at("gravity").is_array()) return std::nullopt;
  for (const Json& component : file.at("gravity")) {
    if (!component.is_number()) return std::nullopt;
    g.push_back(component.get<double>());
  }
  return g.size() == dim ? std::optional(g) : std::nullopt;
}

std::string gravity_text(const Json& file, const std::vector<double>& g) {
  return fmt::format("[{}]{}", fmt::join(g, ", "),
                     file.contains("gravity") ? "" : " (the default)");
}

void compare_gravity(const Scene& scene, const std::vector<ProgramEntry>& files, Names& warnings) {
  if (files.size() < 2) return;
  const Json& first = scene.settings().at(files.front().file);
  const std::size_t dim = dimension(first) == 3 ? 3 : 2;
  const auto expected = gravity(first, dim);
  for (std::size_t k = 1; k < files.size(); ++k) {
    const Json& file = scene.settings().at(files[k].file);
    const auto found = gravity(file, dim);
    if (!expected || !found || *found == *expected) continue;
    warnings.push_back(fmt::format("{}: at /gravity: found {} for \"{}\", but {} for \"{}\" ({})",
                                   scene.path(files[k].file), gravity_text(file, *found),
                                   files[k].participant, gravity_text(first, *expected),
                                   files.front().participant, files.front().file));
  }
}

}  // namespace

std::vector<ProgramEntry> files_read(const Scene& scene, const CouplerSettings& settings,
                                     const std::function<bool(const std::string&)>& is_launched) {
  std::vector<ProgramEntry> files;
  for (const ProgramEntry& own : solver_programs()) {
    const ParticipantRole* role = find_role(settings, own.participant);
    const bool is_own = role && role->command.empty();
    if (is_own && scene.has(own.file) && is_launched(own.name)) files.push_back(own);
  }
  return files;
}

std::vector<std::string> check_files(const Scene& scene, const CouplerSettings& settings,
                                     const std::vector<ProgramEntry>& files) {
  for (const ProgramEntry& own : files) check_interfaces(scene, settings, own);
  check_dimensions(scene, files);
  Names warnings;
  compare_gravity(scene, files, warnings);
  return warnings;
}

std::set<std::string> participants_here(const CouplerSettings& settings,
                                        const std::vector<ProgramEntry>& files) {
  std::set<std::string> names;
  for (const ParticipantRole& role : settings.participants) {
    if (!role.command.empty()) names.insert(role.name);
  }
  for (const ProgramEntry& own : files) names.insert(own.participant);
  return names;
}

std::vector<std::string> check_attendance(const Scene& scene, const CouplerSettings& settings,
                                          const std::vector<ProgramEntry>& files) {
  Names names;
  for (const ParticipantRole& role : settings.participants) names.push_back(role.name);
  const std::set<std::string> here = participants_here(settings, files);
  Names warnings;
  for (const ProgramEntry& own : solver_programs()) {
    if (!scene.has(own.file)) continue;
    const ParticipantRole* role = find_role(settings, own.participant);
    std::string reason;
    if (role && role->command.empty() && here.contains(own.participant)) continue;
    if (!role) {
      reason = fmt::format("coupler.json: at /participants: found no \"{}\", it has: {}",
                           own.participant, list_text(names, own.participant));
    } else if (!role->command.empty()) {
      reason = fmt::format("coupler.json: at /participants/{}/command: another program",
                           own.participant);
    } else {
      reason = fmt::format("{} is not part of this launch", own.name);
    }
    warnings.push_back(
        fmt::format("{}: no participant reads this file; {}", scene.path(own.file), reason));
  }
  for (const ParticipantRole& role : settings.participants) {
    if (here.contains(role.name)) continue;
    warnings.push_back(fmt::format(
        "{}: at /participants/{}: has neither a \"command\" nor a file that is read ({}): it has "
        "to come from outside, and is not checked",
        scene.path("coupler.json"), role.name, solver_files_text()));
  }
  return warnings;
}

}  // namespace gabion
