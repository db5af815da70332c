// SPDX-License-Identifier: BSD-3-Clause
#include "common/run/results_folder.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <optional>

#include "common/base/json.hpp"
#include "common/base/log.hpp"
#include "common/base/require.hpp"
#include "common/run/result_files.hpp"

namespace gabion {

namespace fs = std::filesystem;

namespace {

constexpr const char* marker_name = ".gabion_results";
constexpr const char* lock_prefix = ".gabion_lock";
constexpr int most_links = 40;  // links to links, as many as the system allows

std::string first_line(const fs::path& path) {
  std::ifstream in(path);
  std::string line;
  std::getline(in, line);
  return line;
}

/// A summary that is missing or cannot be read is that of a run which was not completed.
bool completed(const fs::path& folder) {
  std::ifstream in(folder / "summary.json");
  const Json summary = Json::parse(in, nullptr, /*allow_exceptions=*/false);
  return summary.is_object() && summary.contains("completed") && summary.at("completed") == true;
}

/// The folder that a name leads to, there or not: no slash at its end, no link, no dot.
fs::path folder_of(const std::string& name) {
  fs::path folder = name;
  for (int links = 0;; ++links) {
    while (folder.filename().empty() && folder.has_relative_path()) folder = folder.parent_path();
    if (!fs::is_symlink(folder)) break;
    require<ConfigError>(links < most_links, "output folder {}: is a link that leads nowhere",
                         name);
    folder = folder.parent_path() / fs::read_symlink(folder);
  }
  const std::string last = folder.filename().string();
  return last.empty() || last == "." || last == ".." ? fs::weakly_canonical(folder) : folder;
}

fs::path place_beside(const fs::path& folder) {
  const std::string name = folder.string();
  const bool worse = completed(name + ".previous") && !completed(name);
  return name + (worse ? ".failed" : ".previous");
}

/// Whether it is there and holds more than lock files.
bool is_taken(const fs::path& folder) {
  if (!fs::exists(folder)) return false;
  return std::ranges::any_of(fs::directory_iterator(folder), [](const fs::directory_entry& entry) {
    return !entry.path().filename().string().starts_with(lock_prefix);
  });
}

void require_ours(const fs::path& folder, const std::string& kind) {
  const fs::path marker = folder / marker_name;
  require<ConfigError>(
      fs::exists(marker),
      "output folder {}: found files that are not Gabion results, allowed: a new or "
      "empty folder, or one with earlier results",
      folder.string());
  const std::string found = first_line(marker);
  require<ConfigError>(found == kind,
                       "output folder {}: found results of \"{}\", allowed: results of "
                       "\"{}\"; give another folder with --output",
                       folder.string(), found, kind);
}

void require_usable(const std::string& name, const fs::path& folder, const std::string& kind) {
  require<ConfigError>(!fs::exists(folder) || fs::is_directory(folder),
                       "output folder {}: is not a folder", name);
  if (!is_taken(folder)) return;
  require_ours(folder, kind);
  const fs::path place = place_beside(folder);
  require<ConfigError>(!is_taken(place) || fs::exists(place / marker_name),
                       "{}: is to take the earlier results, but holds files that are "
                       "not Gabion results; move it away",
                       place.string());
}

/// A name for what is kept, that nothing has yet.
fs::path place_to_keep(const fs::path& folder) {
  fs::path place = folder.string() + ".kept";
  for (int number = 2; fs::exists(fs::symlink_status(place)); ++number) {
    place = fmt::format("{}.kept_{}", folder.string(), number);
  }
  return place;
}

/// Make room for earlier results: remove those that are older.
void clear_place(const fs::path& place, const fs::path& folder) {
  if (!fs::exists(place)) return;
  const FolderLock nobody_else(place, FolderLock::Kind::alone);
  if (remove_result_files(place)) return;
  const fs::path kept = place_to_keep(folder);
  fs::rename(place, kept);
  log::info("files in {} that Gabion's programs have not written are kept in {}", place.string(),
            kept.string());
}

/// @param folder  locked
void move_earlier_results(const fs::path& folder) {
  const fs::path place = folder_of(place_beside(folder).string());
  clear_place(place, folder);
  fs::rename(folder, place);
  const bool failed = place.extension() == ".failed";
  log::info("earlier results{} moved to {}", failed ? ", of a run that was not completed," : "",
            place.string());
}

/// A folder that is there, locked; nobody else uses it.
FolderLock locked(const fs::path& folder) {
  fs::create_directories(folder);
  return FolderLock(folder, FolderLock::Kind::alone);
}

FolderLock empty_folder(const std::string& name, const fs::path& folder, const std::string& kind) {
  require_usable(name, folder, kind);  // before a lock file comes to be in a folder of others
  {
    FolderLock lock = locked(folder);
    require_usable(name, folder, kind);
    if (!is_taken(folder)) return lock;
    move_earlier_results(folder);
  }
  FolderLock lock = locked(folder);
  // Another program may have come in between.
  require<ConfigError>(!is_taken(folder), "output folder {}: another run has just started there",
                       name);
  return lock;
}

}  // namespace

std::string place_of_earlier_results(const std::string& folder) {
  return place_beside(folder_of(folder)).string();
}

void check_results_folder(const std::string& name, const std::string& kind) {
  try {
    const fs::path folder = folder_of(name);
    require_usable(name, folder, kind);
    if (!is_taken(folder)) return;
    const FolderLock nobody_else(folder, FolderLock::Kind::alone);
  } catch (const fs::filesystem_error& error) {
    throw ConfigError(fmt::format("output folder {}: {}", name, error.what()));
  }
}

FolderLock prepare_results_folder(const std::string& name, const std::string& kind) {
  try {
    const fs::path folder = folder_of(name);
    FolderLock lock = empty_folder(name, folder, kind);
    lock.sign(kind);  // first: a folder with a marker and no signature is one of a run that ended
    std::ofstream marker(folder / marker_name);
    marker << kind << '\n';
    marker.flush();
    require(marker.good(), "output folder {}: cannot be written", name);
    lock.share();
    return lock;
  } catch (const fs::filesystem_error& error) {
    throw ConfigError(fmt::format("output folder {}: {}", name, error.what()));
  }
}

}  // namespace gabion
