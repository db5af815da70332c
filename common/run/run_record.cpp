// SPDX-License-Identifier: BSD-3-Clause
#include "common/run/run_record.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <fstream>

#include "common/base/log.hpp"
#include "common/base/names.hpp"
#include "common/base/require.hpp"

namespace gabion {

namespace fs = std::filesystem;

namespace {

constexpr const char* marker_name = ".gabion_results";

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

fs::path without_last_slash(const std::string& name) {
  fs::path folder = fs::path(name).lexically_normal();
  return folder.filename().empty() ? folder.parent_path() : folder;
}

void move_earlier_results(const fs::path& folder, const std::string& kind) {
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
  const fs::path place = place_of_earlier_results(folder.string());
  if (fs::exists(place)) {
    require<ConfigError>(fs::exists(place / marker_name),
                         "{}: is to take the earlier results, but holds files that are "
                         "not Gabion results; move it away",
                         place.string());
    fs::remove_all(place);
  }
  const bool failed = place.extension() == ".failed";
  fs::rename(folder, place);
  log::info("earlier results{} moved to {}", failed ? ", of a run that was not completed," : "",
            place.string());
}

void prepare_folder(const std::string& name, const std::string& kind) {
  const fs::path folder = without_last_slash(name);
  try {
    require<ConfigError>(!fs::exists(folder) || fs::is_directory(folder),
                         "output folder {}: is not a folder", name);
    if (fs::exists(folder) && !fs::is_empty(folder)) move_earlier_results(folder, kind);
    fs::create_directories(folder);
  } catch (const fs::filesystem_error& error) {
    throw ConfigError(fmt::format("output folder {}: {}", name, error.what()));
  }
  std::ofstream marker(folder / marker_name);
  marker << kind << '\n';
  marker.flush();
  require(marker.good(), "output folder {}: cannot be written", name);
}

}  // namespace

std::string place_of_earlier_results(const std::string& folder) {
  const std::string name = without_last_slash(folder).string();
  const bool worse = completed(name + ".previous") && !completed(name);
  return name + (worse ? ".failed" : ".previous");
}

RunRecord::RunRecord(const std::string& folder, const std::string& kind, bool writes)
    : folder_(folder), kind_(kind), writes_(writes) {
  if (writes_) prepare_folder(folder_, kind_);
}

std::string RunRecord::path(const std::string& file) const {
  return (fs::path(folder_) / file).string();
}

void RunRecord::open_table(const std::string& file, const std::vector<std::string>& columns) {
  if (writes_) tables_.try_emplace(file, path(file), columns);
}

void RunRecord::row(const std::string& file, const std::vector<CsvValue>& values) {
  if (writes_) tables_.at(file).row(values);
}

void write_json_file(const std::string& path, const Json& value) {
  const std::string draft = path + ".part";
  {
    std::ofstream out(draft);
    // Texts of errors may hold any bytes, such as the name of a file.
    out << value.dump(2, ' ', false, Json::error_handler_t::replace) << '\n';
    out.flush();
    require(out.good(), "{}: could not be written (disk full?)", path);
  }
  std::error_code error;
  fs::rename(draft, path, error);
  require(!error, "{}: could not be written: {}", path, error.message());
}

void RunRecord::write_json(const std::string& file, const Json& value) const {
  if (writes_) write_json_file(path(file), value);
}

double OutputClock::multiples(double time) const {
  constexpr double round_off = 1e-12;  // relative: a step that ends on a multiple counts as there
  return time / interval_ * (1 + round_off);
}

bool OutputClock::due(double time) {
  if (!is_due(time)) return false;
  constexpr double most = 9e18;  // an interval so short is over with every step
  next_ = static_cast<std::int64_t>(std::min(std::floor(multiples(time)), most)) + 1;
  return true;
}

void DetailColumns::start(const Json& details) {
  started_ = true;
  names_.clear();
  for (const auto& item : details.items()) {
    require(
        is_plain_name(item.key(), ". /()[]^*"),
        "solver reports a number named {}, allowed: letters, digits and one of \"_-. /()[]^*\", "
        "as it becomes a column of a table",
        Json(item.key()).dump(-1, ' ', true, Json::error_handler_t::replace));
    names_.push_back(item.key());
  }
  std::stable_partition(names_.begin(), names_.end(),
                        [](const std::string& name) { return !name.ends_with("_seconds"); });
}

void DetailColumns::append(const Json& details, std::vector<CsvValue>& cells) const {
  for (const auto& item : details.items()) {
    require(std::find(names_.begin(), names_.end(), item.key()) != names_.end(),
            "solver reports \"{}\", which its first report did not have", item.key());
    require(item.value().is_number(), "solver reports \"{}\" = {}, allowed: a number", item.key(),
            item.value().dump());
  }
  for (const auto& name : names_) {
    if (!details.contains(name)) {
      cells.emplace_back(std::string());
    } else if (details.at(name).is_number_integer()) {
      cells.emplace_back(details.at(name).get<std::int64_t>());
    } else {
      cells.emplace_back(details.at(name).get<double>());
    }
  }
}

void DetailColumns::visit_state(StateVisitor& visitor, const std::string& name) {
  Json columns = started_ ? Json(names_) : Json();
  visitor.fact(name, columns);
  started_ = !columns.is_null();
  if (started_) names_ = columns.get<std::vector<std::string>>();
}

}  // namespace gabion
