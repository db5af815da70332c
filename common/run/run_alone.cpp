// SPDX-License-Identifier: BSD-3-Clause
#include "common/run/run_alone.hpp"

#include <fmt/format.h>

#include <ctime>
#include <gabion_version.hpp>

#include "common/base/log.hpp"
#include "common/base/timer.hpp"
#include "common/run/balance_watch.hpp"
#include "common/run/loop_checkpoints.hpp"
#include "common/run/progress.hpp"
#include "common/run/repeated_failure.hpp"

namespace gabion {

namespace {

class LoneRun {
 public:
  LoneRun(Solver& solver, const TimeSettings& settings, double output_interval, RunRecord& record,
          RunKeeper* keeper)
      : solver_(solver),
        record_(record),
        steps_(settings),
        checkpoints_(
            keeper, steps_, [this](StateVisitor& visitor) { visit_state(visitor); }, phases_),
        clock_(output_interval),
        progress_(settings.end, record.writes()) {}

  void run() {
    std::vector<std::string> columns = solver_.probe_names();
    balances_.start(columns);
    columns.insert(columns.begin(), "time");
    record_.open_table("probes.csv", columns);
    if (checkpoints_.go_on()) {
      clock_.due(steps_.time());  // what is due here was written by the run that is continued
    } else {
      probe_row(solver_.probes());
      write_output_if(clock_.due(0));
    }
    while (!steps_.finished()) {
      advance();
      checkpoints_.after_step();
    }
    write_output_if(written_ != steps_.time());
    checkpoints_.at_end();
  }

  /// Log what its balances say.
  void report() const { balances_.report(); }

  /// The accepted state of a run that ended early.
  void write_last_state() { write_output_if(written_ != steps_.time()); }

  Json summary() const {
    Json wall(phases_.seconds());
    wall["total"] = watch_.seconds();
    Json summary = {{"program", record_.kind()},
                    {"version", version},
                    {"end_time", steps_.time()},
                    {"cuts", steps_.cuts()},
                    {"newton_iterations", newton_iterations_},
                    {"linear_iterations", linear_iterations_},
                    {"wall_seconds", wall},
                    {"cpu_seconds", static_cast<double>(std::clock()) / CLOCKS_PER_SEC},
                    {"solver", solver_.summary()}};
    summary.update(checkpoints_.summary());
    return summary;
  }

 private:
  void visit_state(StateVisitor& visitor) {
    steps_.visit_state(visitor);
    details_.visit_state(visitor, "columns");
  }

  void advance() {
    const Stopwatch watch;
    const int cuts_before = steps_.cuts();
    StepReport report;
    while (!solve(report)) {
    }
    const StepRequest request{steps_.step(), 0, steps_.time(), steps_.dt()};
    AcceptReport accepted;
    {
      const ScopedTimer timer(phases_, "accept");
      accepted = solver_.accept_step(request, /*solved=*/true);
    }
    steps_.accept(accepted.proposed_dt);
    newton_iterations_ += report.newton_iterations;
    linear_iterations_ += report.linear_iterations;
    report.details.update(accepted.details);
    balances_.add_cuts(steps_.cuts() - cuts_before);
    probe_row(accepted.probes);
    step_row(request, report, steps_.cuts() - cuts_before, watch);
    write_output_if(clock_.due(steps_.time()));
    progress_.update(request.step, steps_.time(), request.dt, report.newton_iterations);
  }

  bool solve(StepReport& report) {
    const StepRequest request{steps_.step(), 0, steps_.time(), steps_.dt()};
    const ScopedTimer timer(phases_, "solve");
    try {
      InterfaceValues sent;
      report = solver_.solve_step(request, {}, sent);
      return true;
    } catch (const ConvergenceError& error) {
      solver_.reject_step();
      if (error.cause() == fails_at_any_dt) throw;
      steps_.cut(error.what());
      log::warn("step {} at {} s: dt cut to {} s: {}", request.step, request.time, steps_.dt(),
                error.what());
      return false;
    }
  }

  void step_row(const StepRequest& request, const StepReport& report, int cuts,
                const Stopwatch& watch) {
    if (!record_.has_table("steps.csv")) {
      if (!details_.started()) details_.start(report.details);
      std::vector<std::string> columns = {
          "step", "time", "dt", "newton_iterations", "linear_iterations", "cuts"};
      columns.insert(columns.end(), details_.names().begin(), details_.names().end());
      columns.push_back("wall_seconds");
      record_.open_table("steps.csv", columns);
    }
    if (!record_.writes()) return;
    std::vector<CsvValue> cells = {request.step,
                                   steps_.time(),
                                   request.dt,
                                   std::int64_t{report.newton_iterations},
                                   report.linear_iterations,
                                   std::int64_t{cuts}};
    details_.append(report.details, cells);
    cells.emplace_back(watch.seconds());
    record_.row("steps.csv", cells);
  }

  void probe_row(const std::vector<double>& probes) {
    balances_.add(probes);
    std::vector<CsvValue> cells = {steps_.time()};
    cells.insert(cells.end(), probes.begin(), probes.end());
    record_.row("probes.csv", cells);
  }

  void write_output_if(bool wanted) {
    if (!wanted) return;
    const ScopedTimer timer(phases_, "output");
    solver_.write_output(steps_.time());
    written_ = steps_.time();
  }

  Solver& solver_;
  RunRecord& record_;
  TimeSteps steps_;
  PhaseTimes phases_;
  LoopCheckpoints checkpoints_;
  OutputClock clock_;
  Progress progress_;
  DetailColumns details_;
  BalanceWatch balances_;
  Stopwatch watch_;
  double written_ = -1;  // [s] time of the last frame
  std::int64_t newton_iterations_ = 0;
  std::int64_t linear_iterations_ = 0;
};

void write_failure(const LoneRun& run, const RunRecord& record, const std::string& reason) {
  Json summary = run.summary();
  summary["completed"] = false;
  summary["reason"] = reason;
  record.write_json("summary.json", summary);
  run.report();
}

}  // namespace

void run_alone(Solver& solver, const TimeSettings& settings, double output_interval,
               RunRecord& record, RunKeeper* keeper) {
  LoneRun run(solver, settings, output_interval, record, keeper);
  try {
    run.run();
  } catch (const ConvergenceError& error) {
    write_failure(run, record, error.what());
    run.write_last_state();
    throw;
  } catch (const std::exception& error) {
    write_failure(run, record, error.what());
    throw;
  }
  Json summary = run.summary();
  summary["completed"] = true;
  record.write_json("summary.json", summary);
  run.report();
}

}  // namespace gabion
