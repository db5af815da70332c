// SPDX-License-Identifier: BSD-3-Clause
#include "common/run/run_record.hpp"

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <gabion_version.hpp>

#include "common/base/log.hpp"
#include "common/base/names.hpp"
#include "common/base/require.hpp"
#include "common/run/results_folder.hpp"

namespace gabion {

namespace fs = std::filesystem;

RunRecord::RunRecord(const std::string& folder, const std::string& kind, bool writes)
    : folder_(folder), kind_(kind), writes_(writes) {
  if (writes_) lock_.emplace(prepare_results_folder(folder_, kind_));
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

void RunRecord::write_failure(const std::string& reason) const {
  if (!writes_ || fs::exists(path("summary.json"))) return;
  try {
    write_json("summary.json", {{"program", kind_},
                                {"version", version},
                                {"completed", false},
                                {"reason", reason},
                                {"end_time", 0}});
  } catch (const Error& error) {
    log::error("{}", error.what());
  }
}

double OutputClock::multiples(double time) const {
  constexpr double round_off = 1e-12;  // relative tolerance: a step may end short of a multiple by
                                       // rounding
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
