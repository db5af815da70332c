// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <initializer_list>
#include <map>
#include <span>
#include <string>
#include <vector>

namespace gabion {

/// Statements of a run on its balances and its convergence when it ends: those that scripts/watch
/// marks as bad (docs/results.md, the page of a run), from the same columns.
class BalanceWatch {
 public:
  /// Names of the columns of probes.csv: PARTICIPANT.COLUMN, or COLUMN of a run without coupler.
  void start(const std::vector<std::string>& probe_names);
  /// The values at time 0, or of the first step of a continued run, and of each accepted step.
  void add(std::span<const double> probes);
  /// Work of the interfaces in an accepted step [J].
  /// @param made  of soil and structure together
  void add_work(double soil_work, double made);
  /// Rejected tries of the step that add() tells of next.
  void add_cuts(int cuts) { cuts_ += cuts; }

  /// Sentences; empty: nothing is amiss.
  std::vector<std::string> faults() const;
  /// Log them as warnings.
  void report() const;

 private:
  struct Column {
    double first = 0, last = 0, largest = 0, lowest = 0;  // largest: by its amount
  };
  const Column& column(const std::string& owner, const std::string& name) const;
  double largest(const std::string& owner, std::initializer_list<const char*> names) const;
  std::vector<std::string> owners(const std::string& name) const;
  void judge_soil(const std::string& owner, std::vector<std::string>& faults) const;
  void judge_structure(const std::string& owner, std::vector<std::string>& faults) const;

  std::vector<std::string> names_;  // names of all columns
  std::map<std::string, Column> columns_;
  std::int64_t rows_ = 0, cuts_ = 0;
  double soil_work_ = 0, most_soil_work_ = 0, made_work_ = 0;
};

}  // namespace gabion
