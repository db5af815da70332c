// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Core>
#include <memory>
#include <string>
#include <vector>

#include "common/base/timer.hpp"
#include "common/run/loop_checkpoints.hpp"
#include "common/run/progress.hpp"
#include "common/run/run_record.hpp"
#include "common/run/solver.hpp"
#include "common/run/time_steps.hpp"
#include "coupler/coupler_config.hpp"
#include "coupler/mapping/interface_map.hpp"
#include "coupler/report/coupling_counts.hpp"
#include "coupler/report/coupling_record.hpp"
#include "coupler/step/contact_watch.hpp"
#include "coupler/step/convergence.hpp"
#include "coupler/step/interface_work.hpp"
#include "coupler/step/predictor.hpp"
#include "coupler/step/side.hpp"

namespace gabion {

/// A solver, in this process or behind a proxy, and the name that coupler.json gives it.
struct NamedSolver {
  std::string name;
  Solver& solver;
};

/// The coupled time loop: Dirichlet on the soils, Neumann on the structures (README.md section 1).
class CouplingLoop {
 public:
  /// @param participants  one for each entry of settings.participants, in any order
  /// @param keeper        null: no checkpoints; see run_alone()
  /// @throws ConfigError  participants or interfaces do not fit the settings
  CouplingLoop(const CouplerSettings& settings, const std::vector<NamedSolver>& participants,
               RunRecord& files, RunKeeper* keeper = nullptr);

  /// Run to the end. The files of a run that fails are complete up to the last accepted step, and
  /// summary.json says why it ended.
  /// @throws ConvergenceError  a step needs less than dt_min, or on_limit is "stop"
  /// @throws Interrupted       the keeper has got a signal; after a checkpoint
  void run();

 private:
  /// One try to solve a step; row.request is its last request.
  struct Attempt {
    Eigen::VectorXd x;                                         // given to the soils
    std::map<std::string, InterfaceValues> soil_displacement;  // H x, by the soil's name
    Eigen::VectorXd force_given;                               // to the structures
    Eigen::VectorXd force;                     // answered by the soils; serial: force_given too
    Eigen::VectorXd x_tilde;                   // answered by the structures
    std::vector<InterfaceValues> soil_forces;  // as each soil sent them
    IterationRow row;
    std::string status;
    std::string skipped = "none";
    std::string failure;  // empty: usable
    bool solver_failed = false;
    int soil_newton = 0;
    int structure_newton = 0;
  };

  void run_steps();
  void visit_state(StateVisitor& visitor);
  void visit_surfaces(StateVisitor& visitor) const;
  void advance();
  Attempt try_step(const StepRequest& request);
  Attempt iterate(StepRequest request);
  void predict(Attempt& now) const;
  bool solve_serial(Attempt& now);
  bool solve_parallel(Attempt& now);
  void solve_soils(Attempt& now);
  void start_soils(Attempt& now);
  void solve_structures(Attempt& now, bool may_sleep);
  void finish_soils(Attempt& now, const Stopwatch& watch);
  void finish_structures(Attempt& now, const std::vector<Side*>& started, const Stopwatch& watch);
  std::vector<Side*> start_structures(Attempt& now, bool may_sleep);
  bool contact_possible(const Attempt& now) const;
  void accelerate(Attempt& now);
  Eigen::VectorXd stacked(const Eigen::VectorXd& displacement, const Eigen::VectorXd& force) const;
  double allowed_dt(const Attempt& now, double proposed_dt) const;
  void check_one_pass(Attempt& now) const;
  bool finished(Attempt& now);
  void warn_of_round_off(const ConvergenceState& state);
  void log_iteration(Attempt& now, const Stopwatch& watch);
  void accept(const Attempt& now, int cuts, const Stopwatch& watch);
  std::vector<double> accept_sides(const Attempt& now, double& proposed_dt);
  void reject(const Attempt& now);
  void add_work(const Attempt& now, StepRow& row);
  void write_output();
  std::vector<Side*> sides();
  std::vector<StepReport> soil_reports() const;
  Json summary(bool participants_answer);

  CouplerSettings settings_;
  std::vector<Side> soils_;
  std::vector<Side> structures_;
  std::unique_ptr<InterfaceMap> map_;
  Json surfaces_ = Json::object();  // participant -> interface -> hash of its mesh
  std::unique_ptr<Acceleration> acceleration_;
  Predictor predictor_;
  Convergence convergence_;
  ContactWatch contact_;
  TimeSteps steps_;
  PhaseTimes phases_;
  LoopCheckpoints checkpoints_;
  OutputClock clock_;
  Progress progress_;
  RunRecord& files_;
  std::unique_ptr<CouplingRecord> record_;
  Eigen::VectorXd accepted_x_;
  int forgotten_columns_ = 0;  // by the last change of contact, until the next call of `next`
  bool warned_round_off_ = false;
  double acceleration_seconds_ = 0;  // since the last accepted step
  InterfaceWork soil_work_;
  InterfaceWork structure_work_;
  double written_ = -1;  // [s] time of the last frame

  CouplingCounts counts_;
  Stopwatch watch_;
};

}  // namespace gabion
