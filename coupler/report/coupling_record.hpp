// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>
#include <utility>
#include <vector>

#include "common/run/run_record.hpp"
#include "common/run/solver.hpp"
#include "coupler/acceleration/acceleration.hpp"
#include "coupler/convergence/convergence.hpp"
#include "coupler/mapping/interface_map.hpp"
#include "coupler/report/coupling_counts.hpp"

namespace gabion {

/// Results of one coupling iteration for iterations.csv.
struct IterationRow {
  StepRequest request = {};
  ConvergenceState state = {};
  AccelerationCounters acceleration = {};  ///< call that made x; zeros for a predicted x
  Resultant soil = {};
  Resultant structure = {};
  int soil_newton = 0;
  int structure_newton = 0;
  double soil_seconds = 0;
  double structure_seconds = 0;
  double wall_seconds = 0;
};

/// Results of one accepted step for steps.csv.
struct StepRow {
  IterationRow last = {};
  double time = 0;          ///< [s] of the accepted state
  int iterations = 0;       ///< iterations of the accepted solution
  std::string status = {};  ///< converged, inactive, explicit, or why it was accepted all the same
  Skipped skipped = Skipped::nothing;
  int soil_newton = 0;  ///< all iterations of the accepted solution
  int structure_newton = 0;
  std::vector<Resultant> interfaces = {};  ///< on the structure, of each interface
  double soil_work = 0;       ///< [J] of the interface forces on the soils, in this step
  double structure_work = 0;  ///< [J] on the structures
  int cuts = 0;
  Json details = Json::object();  ///< "participant.name": number
  double acceleration_seconds = 0;
  double wall_seconds = 0;
};

/// iterations.csv, steps.csv and probes.csv of a coupled run. Columns that hold wall time end in
/// "_seconds" and stand last; all others are equal in two runs of one scene.
class CouplingRecord {
 public:
  /// @param interfaces  their names
  CouplingRecord(RunRecord& files, int dim, std::vector<std::string> interfaces)
      : files_(files), dim_(dim), interfaces_(std::move(interfaces)) {}

  void start(const std::vector<std::string>& probe_names);
  void iteration(const IterationRow& row);
  void step(const StepRow& row);
  void probes(double time, const std::vector<double>& values);
  /// Save or load the columns of steps.csv.
  void visit_state(StateVisitor& visitor) { details_.visit_state(visitor, "columns"); }

 private:
  void start_steps(const Json& details);
  std::vector<std::string> force_columns(const std::string& prefix) const;
  std::vector<std::string> interface_columns() const;

  RunRecord& files_;
  int dim_;
  std::vector<std::string> interfaces_;
  DetailColumns details_;
};

}  // namespace gabion
