// SPDX-License-Identifier: BSD-3-Clause
#include "common/checkpoint/checkpoint_folder.hpp"

#include <fcntl.h>
#include <fmt/format.h>
#include <fmt/ranges.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <charconv>
#include <cstring>
#include <filesystem>
#include <gabion_version.hpp>
#include <string_view>

#include "common/base/descriptor.hpp"
#include "common/base/log.hpp"
#include "common/base/names.hpp"
#include "common/base/read_file.hpp"
#include "common/base/require.hpp"
#include "common/checkpoint/file_crc32.hpp"
#include "common/checkpoint/state_file.hpp"
#include "common/run/result_files.hpp"
#include "common/run/run_record.hpp"
#include "common/settings/json_text.hpp"

namespace gabion {

namespace fs = std::filesystem;

namespace {

/// Manifests of format 1 have no checksums.
constexpr int format = 2, format_without_checksums = 1;
constexpr std::int64_t most_steps = std::int64_t{1} << 62;
constexpr const char* manifest_name = "manifest.json";
constexpr const char* checkpoints_name = "checkpoints";
constexpr std::string_view step_prefix = "step_";

/// Flush a file to the disk: until this returns, a power cut may undo what was written.
void flush_to_disk(const fs::path& path) {
  const Descriptor file(open(path.c_str(), O_RDONLY | O_CLOEXEC));
  const bool good = file.is_open() && fsync(file.number()) == 0;
  require(good, "{}: could not be flushed to the disk: {}", path.string(), std::strerror(errno));
}

/// Number of a folder "step_000123"; -1: it has another name.
std::int64_t step_of(const fs::path& folder) {
  const std::string name = folder.filename().string();
  if (!name.starts_with(step_prefix) || name.size() == step_prefix.size()) return -1;
  std::int64_t step = -1;
  const char* const end = name.data() + name.size();
  const auto [stop, error] = std::from_chars(name.data() + step_prefix.size(), end, step);
  return error == std::errc{} && stop == end ? step : -1;
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

Json read_manifest(const std::string& path) {
  Json manifest = parse_settings(read_file(path, "manifest of a checkpoint"), path);
  require<ConfigError>(manifest.is_object(), "{}: found {}, allowed: an object", path,
                       manifest.type_name());
  return manifest;
}

/// What a manifest says of the file of one part.
struct PartFile {
  std::string name;
  Json bytes;
  Json crc32;        // null in manifests of format 1
  bool own = false;  // a solver has written it
};

/// Refuse a file that is not the one that was written. A name must not lead out of its folder.
/// @returns its path
fs::path whole_file(const fs::path& folder, const PartFile& part) {
  require(is_plain_name(part.name, "."), "{}: found a part named {}, allowed: a plain name",
          (folder / manifest_name).string(), Json(part.name).dump());
  const fs::path file = folder / (part.name + ".h5");
  const std::string way_out =
      "damaged; restart from the results of an earlier part of the run, or begin it anew without "
      "--restart";
  const auto size = fs::is_regular_file(file) ? fs::file_size(file) : 0;
  require(part.bytes.is_number_unsigned() && size == part.bytes.get<std::uintmax_t>(),
          "{}: found {} bytes, the manifest says {}: {}", file.string(), size, part.bytes.dump(),
          way_out);
  if (part.crc32.is_null()) return file;
  const std::string found = file_crc32(file.string());
  require(part.crc32 == found, "{}: found bytes of CRC-32 \"{}\", the manifest says {}: {}",
          file.string(), found, part.crc32.dump(), way_out);
  return file;
}

State read_part(const fs::path& folder, const PartFile& part) {
  const fs::path file = whole_file(folder, part);
  if (!part.own) return read_state(file.string());
  State state;
  state.file = fs::absolute(file).lexically_normal().string();
  return state;
}

void warn_of_other_version(const std::string& path, const Json& written_by) {
  if (written_by == version) return;
  log::warn("{}: written by version {}, this is version {}: the last digits of results may differ",
            path, written_by.dump(), version);
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
    Json files = Json::object(), checksums = Json::object(), own_files = Json::array();
    for (const auto& [name, state] : checkpoint.states) {
      const fs::path file = folder / (name + ".h5");
      if (state.file.empty()) {
        write_state(file.string(), state);
      } else {
        own_files.push_back(name);
      }
      flush_to_disk(file);
      files[name] = fs::file_size(file);
      checksums[name] = file_crc32(file.string());
    }
    const Json manifest = {{"format", format},
                           {"program", kind},
                           {"version", version},
                           {"step", checkpoint.point.step},
                           {"time", checkpoint.point.time},
                           {"bytes", files},
                           {"crc32", checksums},
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
  const std::string manifest_path = (folder / manifest_name).string();
  const Json manifest = read_manifest(manifest_path);
  const auto refuse_unless = [&](bool good, const std::string& key, const std::string& allowed) {
    require<ConfigError>(good, "{}: at /{}: found {}, allowed: {}", manifest_path, key,
                         manifest.value(key, Json()).dump(), allowed);
  };
  const auto value = [&manifest](const char* key) { return manifest.value(key, Json()); };
  const bool has_checksums = value("format") == format;
  refuse_unless(has_checksums || value("format") == format_without_checksums, "format",
                fmt::format("{}, {}", format_without_checksums, format));
  refuse_unless(value("program") == kind, "program", "\"" + kind + "\"");
  warn_of_other_version(path, value("version"));
  refuse_unless(value("step").is_number_unsigned() && value("step") <= most_steps, "step",
                "a number of steps");
  refuse_unless(value("time").is_number() && value("time") >= 0, "time", "a time >= 0");
  refuse_unless(value("bytes").is_object(), "bytes", "an object");
  if (!has_checksums) {
    log::warn("{}: of format {}, without checksums: damage that leaves the sizes is not noticed",
              manifest_path, format_without_checksums);
  }
  Checkpoint checkpoint;
  checkpoint.point = {manifest.at("step").get<std::int64_t>(), manifest.at("time").get<double>()};
  const Json own_files = value("own_files");
  for (const auto& [name, bytes] : manifest.at("bytes").items()) {
    PartFile part{.name = name, .bytes = bytes, .crc32 = Json()};
    part.own = std::find(own_files.begin(), own_files.end(), name) != own_files.end();
    if (has_checksums) {
      const Json crc32 = value("crc32");
      refuse_unless(crc32.is_object() && crc32.contains(name) && crc32.at(name).is_string(),
                    "crc32", fmt::format("an object with a text for \"{}\"", name));
      part.crc32 = crc32.at(name);
    }
    checkpoint.states[name] = read_part(folder, part);
  }
  return checkpoint;
}

}  // namespace gabion
