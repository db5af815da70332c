// SPDX-License-Identifier: BSD-3-Clause
#include "common/base/run_record.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <fstream>

#include "common/base/log.hpp"
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

void move_to_previous(const fs::path& folder, const std::string& kind) {
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
  const fs::path previous = folder.string() + ".previous";
  if (fs::exists(previous)) {
    require<ConfigError>(fs::exists(previous / marker_name),
                         "{}: is to take the earlier results, but holds files that are "
                         "not Gabion results; move it away",
                         previous.string());
    fs::remove_all(previous);
  }
  fs::rename(folder, previous);
  log::info("earlier results moved to {}", previous.string());
}

void prepare_folder(const std::string& name, const std::string& kind) {
  fs::path folder = fs::path(name).lexically_normal();
  if (folder.filename().empty()) folder = folder.parent_path();
  try {
    require<ConfigError>(!fs::exists(folder) || fs::is_directory(folder),
                         "output folder {}: is not a folder", name);
    if (fs::exists(folder) && !fs::is_empty(folder)) move_to_previous(folder, kind);
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

bool OutputClock::due(double time) {
  constexpr double round_off = 1e-12;  // relative: a step that ends on a multiple counts as there
  const double multiples = time / interval_ * (1 + round_off);
  if (multiples < static_cast<double>(next_)) return false;
  next_ = static_cast<std::int64_t>(std::floor(multiples)) + 1;
  return true;
}

void DetailColumns::start(const Json& details) {
  started_ = true;
  names_.clear();
  for (const auto& item : details.items()) names_.push_back(item.key());
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
