// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "common/base/json.hpp"
#include "common/run/csv_writer.hpp"
#include "common/run/folder_lock.hpp"
#include "common/run/state.hpp"

namespace gabion {

/// Write a JSON file in one piece: a reader sees the old file or the new one.
/// @throws Error  the file could not be written
void write_json_file(const std::string& path, const Json& value);

/// The folder of one run's results and the tables in it.
///
/// The folder is that of prepare_results_folder(), locked as long as this lives.
class RunRecord {
 public:
  /// @param folder  created with its parents
  /// @param kind    who writes here: "coupler", "mpm_solver", "fem_solver"
  /// @param writes  false on all ranks but the first: nothing is written, tables ignore their rows
  /// @throws ConfigError  the folder is in use, holds something else, or results of another kind
  /// @note  Other ranks may use the folder only after the first one has constructed its record.
  RunRecord(const std::string& folder, const std::string& kind, bool writes = true);

  const std::string& folder() const { return folder_; }
  const std::string& kind() const { return kind_; }
  bool writes() const { return writes_; }
  std::string path(const std::string& file) const;

  /// Begin the table `file`, such as "steps.csv". @throws Error  it cannot be created
  void open_table(const std::string& file, const std::vector<std::string>& columns);
  bool has_table(const std::string& file) const { return tables_.contains(file); }
  /// Append to a table that was opened.
  void row(const std::string& file, const std::vector<CsvValue>& values);

  /// write_json_file() below the folder; nothing where this record does not write.
  void write_json(const std::string& file, const Json& value) const;
  /// A summary.json of a run that ended before its time loop could write one; an error in writing
  /// it is logged.
  void write_failure(const std::string& reason) const;

 private:
  std::string folder_;
  std::string kind_;
  bool writes_;
  std::optional<FolderLock> lock_;
  std::map<std::string, CsvWriter> tables_;
};

/// Selection of the accepted steps that are written as frames: the first at or after each multiple
/// of `interval`.
class OutputClock {
 public:
  /// @param interval  [s] > 0
  explicit OutputClock(double interval) : interval_(interval) {}

  /// Whether the state accepted at `time` is to be written; true at time 0. Asking counts as
  /// writing: the next answer concerns the next multiple.
  bool due(double time);
  /// Like due(), but the state does not count as written.
  bool is_due(double time) const { return multiples(time) >= static_cast<double>(next_); }

 private:
  double multiples(double time) const;

  double interval_;
  std::int64_t next_ = 0;  // multiple
};

/// Numbers of a report by name, in the order of their names, as columns of a table. The first
/// report fixes the columns. Names that end in "_seconds" are wall times and come last.
class DetailColumns {
 public:
  void start(const Json& details);
  bool started() const { return started_; }
  const std::vector<std::string>& names() const { return names_; }
  /// Cells for these details; a name that is missing gives an empty cell.
  /// @throws Error  a name that the first report did not have, or a value that is not a number
  void append(const Json& details, std::vector<CsvValue>& cells) const;
  /// Save or load the columns.
  void visit_state(StateVisitor& visitor, const std::string& name);

 private:
  bool started_ = false;
  std::vector<std::string> names_;
};

}  // namespace gabion
