// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <random>
#include <string>
#include <vector>

#include "common/run/run_record.hpp"
#include "common/run/solver.hpp"
#include "coupler/checks/answer_difference.hpp"
#include "coupler/checks/participant_check.hpp"

namespace gabion {

/// A participant under test, and the step at which it stands. Steps have `part` of the settings'
/// dt.
class DrivenParticipant {
 public:
  DrivenParticipant(Solver& solver, const CheckSettings& settings)
      : solver_(solver), settings_(settings), meshes_(solver.interfaces()) {}

  /// Tell a structure that asks for kinds of force that all of them are means of a step: the kind
  /// that needs the force of the step before, which then belongs to the accepted state.
  void tell_force_kinds();
  /// Tell a soil that asks for it where its interfaces start: not displaced, so that they cannot
  /// enclose soil that they did not before.
  void tell_start();
  /// Tell a soil that takes other facets those that it has.
  void tell_facets();
  /// Vertices of the facets of a structure that may change, in the accepted state.
  std::vector<double> vertices_of_facets() const;
  /// Random values: equal in every check, different at every call.
  InterfaceValues random_values();

  InterfaceValues solve(const InterfaceValues& values, double part = 1);
  /// Solve, and compare with an earlier answer to these values.
  AnswerDifference again(const InterfaceValues& values, const InterfaceValues& before,
                         double part = 1);
  void compare(const InterfaceValues& before, const InterfaceValues& now,
               AnswerDifference& difference) const;
  void accept(double part = 1);
  /// Accept a step in which the participant is not asked.
  void skip_step();
  void reject() { solver_.reject_step(); }
  void write_output() { solver_.write_output(time_); }
  Solver& solver() { return solver_; }

  /// Number and start time of the next step.
  struct Place {
    std::int64_t step = 1;
    double time = 0;  ///< [s]
  };
  Place place() const { return {step_, time_}; }
  void load(const State& state, const Place& place);

  std::int64_t step() const { return step_; }
  bool at_rest() const { return at_rest_; }                       ///< after the last step
  const StepReport& last_report() const { return last_report_; }  ///< report of the last solution
  /// Why the numbers of its reports would not fit into the table of steps; empty: they do.
  const std::string& details_problem() const { return details_problem_; }

 private:
  StepRequest request(double part) const { return {step_, 0, time_, part * settings_.dt}; }
  void end_step(const StepRequest& done);
  void note_details(const Json& of_solution, const Json& of_acceptance);

  Solver& solver_;
  CheckSettings settings_;
  std::vector<InterfaceMesh> meshes_;
  std::mt19937_64 random_{1};
  StepReport last_report_;
  DetailColumns details_;
  std::string details_problem_;
  std::int64_t step_ = 1;
  double time_ = 0;
  bool at_rest_ = false;
};

}  // namespace gabion
