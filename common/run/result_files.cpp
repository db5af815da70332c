// SPDX-License-Identifier: BSD-3-Clause
#include "common/run/result_files.hpp"

#include <algorithm>
#include <array>
#include <fstream>
#include <functional>
#include <regex>
#include <set>
#include <string>
#include <vector>

#include "common/base/json.hpp"

namespace gabion {

namespace fs = std::filesystem;

namespace {

using Names = std::vector<std::regex>;

Names names(const std::vector<std::string>& patterns) {
  Names result;
  for (const std::string& pattern : patterns) result.emplace_back(pattern);
  return result;
}

bool is_one_of(const std::string& name, const Names& allowed) {
  return std::ranges::any_of(
      allowed, [&](const std::regex& pattern) { return std::regex_match(name, pattern); });
}

/// Whether the coupler, a solver that runs alone or a script wrote it, in the folder itself.
bool is_of_run(const std::string& name) {
  static const Names written =
      names({R"(\.gabion_results)", R"(\.gabion_lock\w*)", R"((steps|iterations|probes)\.csv)",
             R"(coupler\.log)", R"((summary|resolved_config)\.json(\.part)?)", R"(scene\.xdmf)",
             R"(report\.html)"});
  return is_one_of(name, written);
}

/// Whether a solver or a program in structures/ wrote it, in the folder of a participant.
bool is_of_participant(const std::string& name) {
  static const Names written =
      names({R"(\.gabion_lock)", R"(resolved_config\.json(\.part)?)",
             R"((soil|structure|lines|contact_.+)\.xdmf(\.part)?)",
             R"((soil|structure|lines|contact_.+)_\d{6,}\.h5)",
             R"((frames|reactions|section_forces|nodes)\.csv)", R"(frame_\d{6,}\.frd)",
             R"(frames\.pvd|frame_\d{4,}\.vtu)",
             R"(structure\.pvd|structure\d{6,}\.pvtu|structure(_p\d+_|_p)?\d{6,}\.vtu)"});
  return is_one_of(name, written);
}

bool is_of_checkpoint(const std::string& name) {
  static const Names written = names({R"(.+\.h5)", R"(manifest(\.draft)?\.json(\.part)?)"});
  return is_one_of(name, written);
}

/// scripts/plot, scripts/deposit and scripts/map.
bool is_of_script(const std::string& folder, const std::string& name) {
  static const Names pictures =
      names({R"((probes|residuals|iterations|energies|forces|wall_forces|moments|removed)\.png)",
             R"((gauges|column|compare|contact_.+)\.png)", R"((scene|space)\.(png|gif))",
             R"(envelope\.csv)"});
  static const Names rasters =
      names({R"((depth|opened|max_depth|max_speed)\.asc)", R"(deposit\.(csv|png))"});
  static const Names maps =
      names({R"((depth|max_depth|max_speed|max_dynamic_pressure|arrival)\.(asc|prj|tif|png))",
             R"(section_.+\.(csv|png))"});
  return is_one_of(name, folder == "plots" ? pictures : folder == "map" ? maps : rasters);
}

/// Folders of participants below those of a run, as its settings name them.
std::set<std::string> participants_of(const fs::path& folder) {
  std::set<std::string> result = {"mpm", "fem"};
  std::ifstream in(folder / "resolved_config.json");
  const Json files = Json::parse(in, nullptr, /*allow_exceptions=*/false);
  const Json::json_pointer place("/coupler.json/participants");
  if (!files.is_object() || !files.contains(place) || !files.at(place).is_object()) return result;
  for (const auto& item : files.at(place).items()) result.insert(item.key());
  return result;
}

using IsOurs = std::function<bool(const std::string& name)>;

/// Links are not followed, so that they stay.
std::vector<fs::directory_entry> entries_of(const fs::path& folder) {
  std::vector<fs::directory_entry> entries;
  for (const auto& entry : fs::directory_iterator(folder)) entries.push_back(entry);
  return entries;
}

/// Files in a folder, without those of folders in it, and the folder if that leaves it empty.
bool remove_files(const fs::path& folder, const IsOurs& is_ours) {
  for (const fs::directory_entry& entry : entries_of(folder)) {
    const bool is_file = fs::is_regular_file(entry.symlink_status());
    if (is_file && is_ours(entry.path().filename().string())) fs::remove(entry.path());
  }
  return fs::is_empty(folder) && fs::remove(folder);
}

void remove_checkpoints(const fs::path& folder) {
  static const std::regex step(R"(step_\d{6,})");
  for (const fs::directory_entry& entry : entries_of(folder)) {
    if (!fs::is_directory(entry.symlink_status())) continue;
    if (!std::regex_match(entry.path().filename().string(), step)) continue;
    remove_checkpoint_files(entry.path());
  }
  if (fs::is_empty(folder)) fs::remove(folder);
}

}  // namespace

bool remove_checkpoint_files(const fs::path& folder) {
  return remove_files(folder, is_of_checkpoint);
}

bool remove_result_files(const fs::path& folder) {
  const std::set<std::string> participants = participants_of(folder);
  for (const fs::directory_entry& entry : entries_of(folder)) {
    if (!fs::is_directory(entry.symlink_status())) continue;
    const std::string name = entry.path().filename().string();
    if (name == "checkpoints") {
      remove_checkpoints(entry.path());
    } else if (name == "plots" || name == "deposit" || name == "map") {
      remove_files(entry.path(), [&](const std::string& file) { return is_of_script(name, file); });
    } else if (participants.contains(name)) {
      remove_files(entry.path(), is_of_participant);
    }
  }
  return remove_files(folder, is_of_run);
}

}  // namespace gabion
