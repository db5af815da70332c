// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <functional>

#include "common/run/progress.hpp"
#include "common/run/repeated_failure.hpp"
#include "common/run/results_folder.hpp"
#include "common/run/run_alone.hpp"
#include "common/run/run_record.hpp"
#include "tests/support/expect_error.hpp"
#include "tests/support/temp_folder.hpp"

namespace gabion::test_run_alone {
namespace {

namespace fs = std::filesystem;

std::vector<std::string> lines(const std::string& path) {
  std::ifstream in(path);
  std::vector<std::string> result;
  for (std::string line; std::getline(in, line);) result.push_back(line);
  return result;
}

/// v' = 1: the exact value is the time.
class ClockSolver : public Solver {
 public:
  std::vector<InterfaceMesh> interfaces() const override { return {}; }
  std::vector<std::string> probe_names() const override { return {"value"}; }
  StepReport solve_step(const StepRequest& request, const InterfaceValues& received,
                        InterfaceValues&) override {
    EXPECT_TRUE(received.empty());
    if (on_solve) on_solve(request);
    trial_ = value_ + request.dt;
    StepReport report;
    report.newton_iterations = 3;
    report.details = {{"solve_seconds", 0.5}, {"work", 2.5}, {"points", 7}};
    return report;
  }
  AcceptReport accept_step(const StepRequest&, bool) override {
    value_ = trial_;
    return {{value_}, false, 0, {{"moved", 4}}};
  }
  void reject_step() override { ++rejected; }
  void write_output(double time) override { frames.push_back(time); }
  std::vector<double> probes() const override { return {value_}; }
  Json summary() const override { return {{"linear_solver", "none"}}; }

  std::function<void(const StepRequest&)> on_solve;
  std::vector<double> frames;
  int rejected = 0;

 private:
  double value_ = 0;
  double trial_ = 0;
};

TEST(Progress, wall_times_as_text) {
  const std::vector<std::pair<double, std::string>> cases = {
      {0.2, "0 s"},          {100, "100 s"},          {119.4, "119 s"},  {119.6, "2 min 0 s"},
      {150.2, "2 min 30 s"}, {3599.4, "59 min 59 s"}, {3599.6, "1.0 h"}, {5400, "1.5 h"}};
  for (const auto& [seconds, text] : cases) EXPECT_EQ(duration_text(seconds), text);
}

TEST(RunAlone, steps_probes_frames_and_summary) {
  const test::TempFolder temp;
  ClockSolver solver;
  RunRecord record(temp / "out", "fem_solver");
  run_alone(solver, {0.9, 0.2, 0.05}, 0.3, record);
  EXPECT_EQ(solver.frames, (std::vector<double>{0, 0.4, 0.6000000000000001, 0.9}));
  const auto steps = lines(temp / "out/steps.csv");
  ASSERT_EQ(steps.size(), 6u);
  EXPECT_EQ(steps[0],
            "step,time,dt,newton_iterations,linear_iterations,cuts,moved,points,work,solve_seconds,"
            "wall_seconds");
  EXPECT_EQ(steps[1].find("1,0.2,0.2,3,0,0,4,7,2.5,0.5,"), 0u) << steps[1];
  EXPECT_EQ(steps[5].find("5,0.9,"), 0u) << steps[5];
  const auto probes = lines(temp / "out/probes.csv");
  ASSERT_EQ(probes.size(), 7u);
  EXPECT_EQ(probes[0], "time,value");
  EXPECT_EQ(probes[1], "0,0");
  const Json summary = Json::parse(std::ifstream(temp / "out/summary.json"));
  EXPECT_EQ(summary["completed"], true);
  EXPECT_EQ(summary["steps"], 5);
  EXPECT_EQ(summary["end_time"], 0.9);
  EXPECT_EQ(summary["newton_iterations"], 15);
  EXPECT_EQ(summary["solver"]["linear_solver"], "none");
  EXPECT_TRUE(summary["wall_seconds"].contains("solve"));
  EXPECT_TRUE(summary.contains("cpu_seconds"));
}

TEST(RunAlone, a_failing_step_is_cut_and_counted) {
  const test::TempFolder temp;
  ClockSolver solver;
  solver.on_solve = [](const StepRequest& request) {
    if (request.step == 2 && request.dt > 0.06) throw ConvergenceError("too large");
  };
  RunRecord record(temp / "out", "fem_solver");
  run_alone(solver, {1, 0.2, 0.01}, 1, record);
  EXPECT_EQ(solver.rejected, 2);
  EXPECT_EQ(lines(temp / "out/steps.csv")[2].find("2,0.25,0.05,3,0,2,"), 0u);
  EXPECT_NEAR(solver.probes()[0], 1, 1e-14);
}

TEST(RunAlone, a_run_that_fails_says_so_and_keeps_the_last_state) {
  const test::TempFolder temp;
  ClockSolver solver;
  solver.on_solve = [](const StepRequest& request) {
    if (request.time > 0.3) throw ConvergenceError("soil exploded");
  };
  RunRecord record(temp / "out", "mpm_solver");
  test::expect_error<ConvergenceError>(
      [&] {
        run_alone(solver, {1, 0.2, 0.01}, 1, record);
      },
      {"soil exploded", "dt_min = 0.01"});
  const Json summary = Json::parse(std::ifstream(temp / "out/summary.json"));
  EXPECT_EQ(summary["completed"], false);
  EXPECT_NE(summary["reason"].get<std::string>().find("soil exploded"), std::string::npos);
  EXPECT_EQ(summary["end_time"], 0.4);
  EXPECT_EQ(solver.frames, (std::vector<double>{0, 0.4}));
  EXPECT_EQ(lines(temp / "out/steps.csv").size(), 3u);
}

TEST(RunAlone, a_step_that_fails_at_any_dt_is_not_cut) {
  const test::TempFolder temp;
  ClockSolver solver;
  solver.on_solve = [](const StepRequest& request) {
    if (request.step == 2) throw ConvergenceError("too much at once", fails_at_any_dt);
  };
  RunRecord record(temp / "out", "fem_solver");
  test::expect_error<ConvergenceError>(
      [&] {
        run_alone(solver, {1, 0.2, 0.01}, 1, record);
      },
      {"too much at once"});
  EXPECT_EQ(solver.rejected, 1);
  EXPECT_EQ(solver.frames, (std::vector<double>{0, 0.2}));
  const Json summary = Json::parse(std::ifstream(temp / "out/summary.json"));
  EXPECT_EQ(summary["reason"], "too much at once");
  EXPECT_EQ(summary["cuts"], 0);
}

TEST(RunAlone, ranks_that_do_not_write_touch_nothing) {
  const test::TempFolder temp;
  ClockSolver solver;
  RunRecord record(temp / "out", "fem_solver", /*writes=*/false);
  run_alone(solver, {1, 0.2, 0.01}, 0.5, record);
  EXPECT_EQ(solver.frames.size(), 3u);  // output is collective
  EXPECT_FALSE(fs::exists(temp / "out"));
}

TEST(RunRecord, earlier_results_of_the_same_kind_move_to_previous) {
  const test::TempFolder temp;
  for (const std::string text : {"first", "second", "third"}) {
    RunRecord record(temp / "out/", "coupler");
    record.write_json("summary.json", {{"run", text}});
  }
  EXPECT_EQ(Json::parse(std::ifstream(temp / "out/summary.json"))["run"], "third");
  EXPECT_EQ(Json::parse(std::ifstream(temp / "out.previous/summary.json"))["run"], "second");
}

void expect_folder_refused(const std::string& folder, const std::string& kind,
                           const std::vector<std::string_view>& parts) {
  test::expect_error<ConfigError>([&] { RunRecord record(folder, kind); }, parts);
}

TEST(RunRecord, completed_results_are_not_replaced_by_those_of_a_failed_run) {
  const test::TempFolder temp;
  const auto run = [&](int number, const Json& summary) {
    RunRecord record(temp / "out", "coupler");
    std::ofstream(temp / "out/number") << number;
    if (!summary.is_null()) record.write_json("summary.json", summary);
  };
  const auto number_in = [&](const std::string& folder) {
    return fs::exists(temp / folder) ? lines(temp / (folder + "/number")).at(0) : "none";
  };
  run(1, {{"completed", false}});
  run(2, {{"completed", true}});  // nothing better there: the first one is kept as the previous one
  EXPECT_EQ(number_in("out.previous"), "1");
  run(3, {{"completed", false}});
  EXPECT_EQ(number_in("out.previous"), "2");
  EXPECT_EQ(place_of_earlier_results(temp / "out/"), temp / "out.failed");
  run(4, nullptr);  // killed: no summary
  EXPECT_EQ(number_in("out.previous"), "2");
  EXPECT_EQ(number_in("out.failed"), "3");
  run(5, {{"completed", true}});
  EXPECT_EQ(number_in("out.previous"), "2");
  EXPECT_EQ(number_in("out.failed"), "4");
  run(6, {{"completed", "half"}});
  EXPECT_EQ(number_in("out.previous"), "5");
  EXPECT_EQ(number_in("out.failed"), "4");

  fs::remove_all(temp / "out.failed");
  fs::create_directories(temp / "out.failed");
  std::ofstream(temp / "out.failed/thesis.tex") << "years of work";
  expect_folder_refused(temp / "out", "coupler", {"move it away"});
  EXPECT_EQ(lines(temp / "out.failed/thesis.tex")[0], "years of work");
}

TEST(RunRecord, foreign_files_are_never_touched) {
  const test::TempFolder temp;
  fs::create_directories(temp / "papers");
  std::ofstream(temp / "papers/thesis.tex") << "years of work";
  expect_folder_refused(temp / "papers", "coupler", {"not Gabion results"});
  EXPECT_EQ(lines(temp / "papers/thesis.tex")[0], "years of work");

  RunRecord ours(temp / "out", "fem_solver");
  expect_folder_refused(temp / "out", "coupler", {"found results of \"fem_solver\""});

  fs::create_directories(temp / "out.previous");
  std::ofstream(temp / "out.previous/thesis.tex") << "years of work";
  expect_folder_refused(temp / "out", "fem_solver", {"move it away"});
  EXPECT_EQ(lines(temp / "out.previous/thesis.tex")[0], "years of work");
  expect_folder_refused(temp / "out/.gabion_results", "coupler", {"output folder"});
}

TEST(OutputClock, first_time_at_or_after_each_multiple) {
  OutputClock clock(0.1);
  std::vector<double> due;
  for (int n = 0; n <= 40; ++n) {
    const double t = 0.03 * n;
    const bool is_due = clock.is_due(t);
    EXPECT_EQ(clock.due(t), is_due);
    if (is_due) due.push_back(t);
  }
  ASSERT_EQ(due.size(), 13u);
  for (int k = 0; k < 13; ++k) {
    EXPECT_GE(due[std::size_t(k)], 0.1 * k * (1 - 1e-12));
    EXPECT_LT(due[std::size_t(k)], 0.1 * k + 0.03);
  }
  OutputClock wide_steps(0.1);
  EXPECT_TRUE(wide_steps.due(0));
  EXPECT_TRUE(wide_steps.due(0.55));  // several multiples at once: one frame
  EXPECT_FALSE(wide_steps.due(0.58));
  EXPECT_TRUE(wide_steps.due(0.6));
}

TEST(DetailColumns, unknown_names_and_texts_are_refused) {
  DetailColumns columns;
  columns.start({{"b", 1}, {"a_seconds", 2}, {"c", 3}});
  EXPECT_EQ(columns.names(), (std::vector<std::string>{"b", "c", "a_seconds"}));
  std::vector<CsvValue> cells;
  columns.append({{"c", 4.5}}, cells);
  ASSERT_EQ(cells.size(), 3u);
  EXPECT_EQ(std::get<std::string>(cells[0]), "");
  EXPECT_EQ(std::get<double>(cells[1]), 4.5);
  test::expect_error<Error>(
      [&] {
        columns.append({{"d", 1}}, cells);
      },
      {"solver reports \"d\"", "first report"});
  test::expect_error<Error>(
      [&] {
        columns.append({{"b", "text"}}, cells);
      },
      {"solver reports \"b\" = \"text\"", "a number"});
}

}  // namespace
}  // namespace gabion::test_run_alone
