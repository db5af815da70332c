// SPDX-License-Identifier: BSD-3-Clause
#include "common/checkpoint/checkpoint_folder.hpp"

#include <fcntl.h>
#include <fmt/format.h>
#include <fmt/ranges.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <gabion_version.hpp>
#include <string_view>

#include "common/base/descriptor.hpp"
#include "common/base/log.hpp"
#include "common/base/require.hpp"
#include "common/checkpoint/state_file.hpp"
#include "common/run/result_files.hpp"
#include "common/run/run_record.hpp"

namespace gabion {

namespace fs = std::filesystem;

namespace {

constexpr int format = 1;
constexpr const char* manifest_name = "manifest.json";
constexpr const char* checkpoints_name = "checkpoints";
constexpr std::string_view step_prefix = "step_";

/// Until this returns, a power cut may undo what was written.
void flush_to_disk(const fs::path& path) {
  const Descriptor file(open(path.c_str(), O_RDONLY | O_CLOEXEC));
  const bool good = file.is_open() && fsync(file.number()) == 0;
  require(good, "{}: could not be flushed to the disk: {}", path.string(), std::strerror(errno));
}

/// Number of a folder "step_000123"; -1: it has another name.
std::int64_t step_of(const fs::path& folder) {
  const std::string name = folder.filename().string();
  if (!name.starts_with(step_prefix) || name.size() == step_prefix.size()) return -1;
  const std::string digits = name.substr(step_prefix.size());
  return digits.find_first_not_of("0123456789") == std::string::npos ? std::stoll(digits) : -1;
}

void remove_others(const fs::path& checkpoints, const fs::path& kept) {
  std::vector<fs::path> others;
  for (const auto& entry : fs::directory_iterator(checkpoints)) {
    if (step_of(entry.path()) >= 0 && entry.path() != kept) others.push_back(entry.path());
  }
  for (const auto& other : others) {
    fs::remove(other / manifest_name);  // first: a part of a checkpoint must not count
    remove_checkpoint_files(other);
  }
}

Json read_manifest(const fs::path& path) {
  std::ifstream in(path);
  Json manifest = Json::parse(in, nullptr, /*allow_exceptions=*/false);
  require(manifest.is_object(), "{}: not valid JSON", path.string());
  return manifest;
}

}  // namespace

const State& Checkpoint::state_of(const std::string& part) const {
  std::vector<std::string> names;
  for (const auto& entry : states) names.push_back(entry.first);
  require<ConfigError>(states.contains(part),
                       "checkpoint of step {}: found no state of \"{}\", but of {}", point.step,
                       part, fmt::join(names, ", "));
  return states.at(part);
}

std::string checkpoint_path(const std::string& results, const RunPoint& point) {
  const std::string step = fmt::format("{}{:06}", step_prefix, point.step);
  return (fs::path(results) / checkpoints_name / step).string();
}

void begin_checkpoint(const std::string& results, const RunPoint& point) {
  const fs::path folder = checkpoint_path(results, point);
  try {
    fs::remove(folder / manifest_name);
    if (fs::exists(folder)) remove_checkpoint_files(folder);
    fs::create_directories(folder);
  } catch (const fs::filesystem_error& error) {
    throw Error(fmt::format("checkpoint: {}", error.what()));
  }
}

void write_checkpoint(const std::string& results, const std::string& kind,
                      const Checkpoint& checkpoint) {
  const fs::path folder = checkpoint_path(results, checkpoint.point);
  const fs::path all = folder.parent_path();
  try {
    fs::create_directories(folder);
    Json files = Json::object(), own_files = Json::array();
    for (const auto& [name, state] : checkpoint.states) {
      const fs::path file = folder / (name + ".h5");
      if (state.file.empty()) {
        write_state(file.string(), state);
      } else {
        own_files.push_back(name);
      }
      flush_to_disk(file);
      files[name] = fs::file_size(file);
    }
    const Json manifest = {{"format", format},
                           {"program", kind},
                           {"version", version},
                           {"step", checkpoint.point.step},
                           {"time", checkpoint.point.time},
                           {"bytes", files},
                           {"own_files", own_files}};
    const fs::path draft = folder / "manifest.draft.json";
    write_json_file(draft.string(), manifest);
    flush_to_disk(draft);
    flush_to_disk(folder);
    flush_to_disk(all);
    fs::rename(draft, folder / manifest_name);
    flush_to_disk(folder);
    remove_others(all, folder);
  } catch (const fs::filesystem_error& error) {
    throw Error(fmt::format("checkpoint: {}", error.what()));
  }
}

std::string find_checkpoint(const std::string& results) {
  const fs::path all = fs::path(results) / checkpoints_name;
  fs::path last;
  std::error_code error;
  for (const auto& entry : fs::directory_iterator(all, error)) {
    if (step_of(entry.path()) < 0 || !fs::exists(entry.path() / manifest_name)) continue;
    if (last.empty() || step_of(entry.path()) > step_of(last)) last = entry.path();
  }
  require<ConfigError>(!last.empty(),
                       "--restart {}: found no checkpoint there, allowed: the results of "
                       "a run with checkpoints/step_N/manifest.json",
                       results);
  return last.string();
}

Checkpoint read_checkpoint(const std::string& path, const std::string& kind) {
  const fs::path folder(path);
  const Json manifest = read_manifest(folder / manifest_name);
  const auto refuse_unless = [&](bool good, const std::string& key, const std::string& allowed) {
    require<ConfigError>(good, "{}: at /{}: found {}, allowed: {}",
                         (folder / manifest_name).string(), key, manifest.value(key, Json()).dump(),
                         allowed);
  };
  refuse_unless(manifest.value("format", 0) == format, "format", std::to_string(format));
  refuse_unless(manifest.value("program", "") == kind, "program", "\"" + kind + "\"");
  const std::string writer = manifest.value("version", "");
  if (writer != version) {
    log::warn("{}: written by version {}, this is {}: last bits may differ", path, writer, version);
  }
  Checkpoint checkpoint;
  try {
    checkpoint.point = {manifest.at("step").get<std::int64_t>(), manifest.at("time").get<double>()};
    const auto own_files = manifest.value("own_files", std::vector<std::string>());
    for (const auto& [name, bytes] : manifest.at("bytes").items()) {
      const fs::path file = folder / (name + ".h5");
      const auto size = fs::exists(file) ? fs::file_size(file) : 0;
      require(size == bytes.get<std::uintmax_t>(),
              "{}: found {} bytes, the manifest says {}: damaged", file.string(), size,
              bytes.dump());
      if (std::ranges::find(own_files, name) != own_files.end()) {
        checkpoint.states[name].file = fs::absolute(file).lexically_normal().string();
      } else {
        checkpoint.states[name] = read_state(file.string());
      }
    }
  } catch (const Json::exception& error) {
    throw Error(fmt::format("{}: {}", (folder / manifest_name).string(), error.what()));
  }
  return checkpoint;
}

}  // namespace gabion
