// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include <fmt/ranges.h>
#include <unistd.h>

#include <atomic>
#include <filesystem>
#include <fstream>
#include <sstream>
#include <thread>

#include "common/run/repeated_failure.hpp"
#include "coupler/coupling_loop.hpp"
#include "tests/support/expect_error.hpp"
#include "tests/support/solver_server.hpp"
#include "tests/unit/coupler/mass_springs.hpp"

namespace gabion::test_coupling_loop {
namespace {

namespace fs = std::filesystem;
using test::expect_error;
using test::SoilSprings;
using test::StructureSprings;

CouplerSettings settings_for_test() {
  CouplerSettings s;
  s.time = {0.2, 0.01, 0.01 / 64};
  s.output_interval = 0.05;
  s.participants = {{"soil", true}, {"structure", false}};
  s.interfaces = {{"wall", "soil", "structure"}};
  s.coupling.convergence.displacement = {1e-11, 1e-9, 1e-14, {}};
  s.coupling.convergence.force = {1e-8, 1e-9, 1e-12, {}};
  s.coupling.mapping.tolerance = 1e-9;
  return s;
}

/// One coupled run in a folder of its own.
struct CoupledRun {
  explicit CoupledRun(const std::string& name)
      : folder(fs::temp_directory_path() /
               ("gabion_loop_" + std::to_string(getpid()) + "_" + name)) {
    fs::remove_all(folder);
    soil.load = [](double) { return 5.0; };
  }
  ~CoupledRun() {
    fs::remove_all(folder);
    fs::remove_all(folder.string() + ".previous");
  }
  CoupledRun(const CoupledRun&) = delete;
  CoupledRun& operator=(const CoupledRun&) = delete;
  CoupledRun(CoupledRun&&) = delete;
  CoupledRun& operator=(CoupledRun&&) = delete;

  void go() {
    RunRecord files(folder.string(), "coupler");
    CouplingLoop loop(settings, {{"structure", structure}, {"soil", soil}}, files);
    loop.run();
  }
  /// Like go(), with the solvers behind sockets, each in a thread of its own.
  void go_behind_the_wire() {
    RunRecord files(folder.string(), "coupler");
    test::couple_through_sockets(settings, soil, structure, files);
  }
  /// Rows of a table, without the columns of wall time.
  std::vector<std::vector<std::string>> table(const std::string& file) const {
    std::ifstream in(folder / file);
    std::vector<std::vector<std::string>> rows;
    std::size_t keep = 0;
    for (std::string line; std::getline(in, line);) {
      std::vector<std::string> cells;
      std::stringstream stream(line);
      for (std::string cell; std::getline(stream, cell, ',');) {
        if (rows.empty() && cell.ends_with("_seconds")) break;
        if (!rows.empty() && cells.size() == keep) break;
        cells.push_back(cell);
      }
      if (rows.empty()) keep = cells.size();
      rows.push_back(cells);
    }
    return rows;
  }
  /// The run ends with a ConvergenceError that says all this, and so does its summary.
  void expect_failure(const std::vector<std::string_view>& parts) {
    expect_error<ConvergenceError>([this] { go(); }, parts);
    EXPECT_EQ(summary()["completed"], false);
    test::expect_parts(summary()["reason"], parts);
  }
  std::vector<std::string> column(const std::string& file, const std::string& name) const {
    const auto rows = table(file);
    const auto at = std::find(rows[0].begin(), rows[0].end(), name) - rows[0].begin();
    std::vector<std::string> result;
    for (std::size_t i = 1; i < rows.size(); ++i) result.push_back(rows[i].at(std::size_t(at)));
    return result;
  }
  Json summary() const {
    std::ifstream in(folder / "summary.json");
    return Json::parse(in);
  }

  fs::path folder;
  CouplerSettings settings = settings_for_test();
  SoilSprings soil{3, 2, 10};
  StructureSprings structure{2, 1, 100};
};

/// Both sides as one system: M = M_structure + H^T M_soil H, and likewise K and the load.
Eigen::VectorXd monolithic_history(double dt, int steps) {
  Eigen::MatrixXd H(6, 4);
  H << 1, 0, 0, 0, 0, 1, 0, 0, .5, 0, .5, 0, 0, .5, 0, .5, 0, 0, 1, 0, 0, 0, 0, 1;
  const auto diagonal = [](double value, int n) {
    Eigen::MatrixXd m = Eigen::MatrixXd::Zero(n, n);
    for (int i = 0; i < n; ++i) m(i, i) = value * (1 + double(i / 2) / n);
    return m;
  };
  const Eigen::MatrixXd M = diagonal(1, 4) + H.transpose() * diagonal(2, 6) * H;
  const Eigen::MatrixXd K = diagonal(100, 4) + H.transpose() * diagonal(10, 6) * H;
  Eigen::VectorXd load(6);
  load << 5, 2.5, 5, 2.5, 5, 2.5;
  const Eigen::VectorXd F = H.transpose() * load;
  Eigen::VectorXd u = Eigen::VectorXd::Zero(4), v = u, a = u;
  Eigen::VectorXd history(steps);
  for (int n = 0; n < steps; ++n) {
    const Eigen::VectorXd a_at_u_n = -v * 4 / dt - a;  // trapezoidal rule, beta = 1/4
    const Eigen::VectorXd du = (M * 4 / (dt * dt) + K).ldlt().solve(F - K * u - M * a_at_u_n);
    const Eigen::VectorXd a_new = du * 4 / (dt * dt) + a_at_u_n;
    v += dt / 2 * (a + a_new);
    a = a_new;
    u += du;
    history(n) = u(0);
  }
  return history;
}

struct Setting {
  Scheme scheme = Scheme::serial_implicit;
  std::string method;
  int predictor = 0;
};

/// Every method in both implicit schemes, with every predictor. But Aitken's single factor finds no
/// fixed point of [x; f], whose iteration has complex eigenvalues.
std::vector<Setting> all_ways() {
  std::vector<Setting> paths;
  for (const Scheme scheme : {Scheme::serial_implicit, Scheme::parallel_implicit}) {
    for (const std::string& method : acceleration_methods()) {
      if (scheme == Scheme::parallel_implicit && method == "aitken") continue;
      for (const int predictor : {0, 1, 2}) paths.push_back({scheme, method, predictor});
    }
  }
  return paths;
}

TEST(CouplingLoop, equals_the_monolithic_solution_for_every_method_and_predictor) {
  const Eigen::VectorXd expected = monolithic_history(0.01, 20);
  for (const auto& [scheme, method, predictor] : all_ways()) {
    SCOPED_TRACE(fmt::format("{} {} predictor {}", name(scheme), method, predictor));
    CoupledRun run("monolithic");
    run.settings.coupling.scheme = scheme;
    run.settings.coupling.acceleration.method = method;
    run.settings.coupling.predictor = predictor;
    if (method == "constant") {  // the soil is as heavy as four structures
      run.settings.coupling.acceleration.relaxation = 0.05;
      run.settings.coupling.max_iterations = 3000;
      run.settings.coupling.convergence.stagnation = 1000;
    }
    run.go();
    const auto u = run.column("probes.csv", "structure.u");
    ASSERT_EQ(u.size(), 21u);
    EXPECT_EQ(std::stod(u[0]), 0);
    for (int n = 0; n < 20; ++n) {
      EXPECT_NEAR(std::stod(u[std::size_t(n) + 1]), expected(n), 1e-8 * expected.maxCoeff())
          << "step " << n;
    }
    const Json summary = run.summary();
    EXPECT_EQ(summary["completed"], true);
    EXPECT_EQ(summary["steps"], 20);
    EXPECT_EQ(summary["end_time"], 0.2);
    EXPECT_EQ(summary["methods"]["acceleration"], method);
    EXPECT_EQ(summary["methods"]["scheme"], name(scheme));
    EXPECT_EQ(summary["participants"]["soil"]["linear_solver"], "none");
  }
}

TEST(CouplingLoop, force_balance_is_logged_at_round_off) {
  CoupledRun run("balance");
  run.go();
  for (const std::string name : {"mismatch_force", "mismatch_moment"}) {
    for (const auto& cell : run.column("iterations.csv", name)) EXPECT_LE(std::stod(cell), 1e-11);
  }
  EXPECT_GT(std::abs(std::stod(run.column("steps.csv", "fx")[3])), 0.1);
  EXPECT_EQ(run.column("steps.csv", "soil.work")[3], "6");
}

TEST(CouplingLoop, forces_and_moments_of_an_interface_have_columns) {
  CoupledRun origin("origin"), foot("foot");
  foot.settings.interfaces[0].moment_about = {1, 2};
  origin.go();
  foot.go();
  EXPECT_EQ(foot.column("steps.csv", "wall.fx"), foot.column("steps.csv", "fx"));
  EXPECT_EQ(foot.column("steps.csv", "wall.fy"), foot.column("steps.csv", "fy"));
  const auto fx = foot.column("steps.csv", "fx"), fy = foot.column("steps.csv", "fy");
  const auto about_origin = origin.column("steps.csv", "wall.mz");
  const auto about_foot = foot.column("steps.csv", "wall.mz");
  ASSERT_EQ(about_foot.size(), 20u);
  for (std::size_t n = 0; n < 20; ++n) {
    const double shift = std::stod(fy[n]) - 2 * std::stod(fx[n]);
    EXPECT_NEAR(std::stod(about_foot[n]), std::stod(about_origin[n]) - shift, 1e-12) << n;
    EXPECT_GT(std::abs(shift), 1e-3);
  }
}

TEST(CouplingLoop, interface_work_is_the_energy_of_the_structure_and_cancels) {
  CoupledRun run("work");
  run.go();
  const auto energy = run.column("probes.csv", "structure.energy");
  const auto structure = run.column("steps.csv", "structure_work");
  const auto soil = run.column("steps.csv", "soil_work");
  const auto sum = run.column("steps.csv", "work_sum");
  double largest = 0;
  for (const auto& cell : structure) largest = std::max(largest, std::abs(std::stod(cell)));
  EXPECT_GT(largest, 0.01);
  for (std::size_t n = 0; n < 20; ++n) {
    const double gain = std::stod(energy[n + 1]) - std::stod(energy[n]);
    EXPECT_NEAR(std::stod(structure[n]), gain, 1e-12 * largest) << "step " << n;
    EXPECT_NEAR(std::stod(soil[n]), -gain, 1e-7 * largest) << "step " << n;
    EXPECT_EQ(std::stod(sum[n]), std::stod(soil[n]) + std::stod(structure[n]));
  }
}

/// A structure that takes the force as constant over the step where it is told so.
class MeanSprings : public StructureSprings {
 public:
  using StructureSprings::StructureSprings;
  bool takes_force_kinds() const override { return true; }
  void set_force_kinds(const ForceKinds& kinds) override { kind = kinds.at("wall"); }
  StepReport solve_step(const StepRequest& request, const InterfaceValues& received,
                        InterfaceValues& sent) override {
    if (kind == ForceKind::end_of_step) {
      return StructureSprings::solve_step(request, received, sent);
    }
    const NewmarkBossak newmark;
    const double c = newmark.step_force_weight();
    force_ = Eigen::Map<const Eigen::VectorXd>(received.at("wall").data(), u_.size());
    if (before_.size() == 0) before_ = Eigen::VectorXd::Zero(u_.size());
    const Eigen::VectorXd balanced = c * force_ - (c - 1) * before_;
    const StepReport report =
        StructureSprings::solve_step(request, {{"wall", {balanced.begin(), balanced.end()}}}, sent);
    for (Eigen::Index i = 0; i < u_.size(); ++i) {
      const double change = (force_(i) - before_(i)) / (factor(i) * mass_);
      v_trial_(i) += request.dt * newmark.step_force_velocity() * change;
      a_trial_(i) -= newmark.step_force_acceleration() * change;
    }
    return report;
  }
  AcceptReport accept_step(const StepRequest& request, bool solved) override {
    if (solved) before_ = force_;
    return StructureSprings::accept_step(request, solved);
  }

  ForceKind kind = ForceKind::end_of_step;

 private:
  Eigen::VectorXd force_, before_;  // of this step, of the one before
};

/// A run whose soil sends mean forces, with this structure.
struct MeanForces {
  explicit MeanForces(const std::string& name) : run("mean_" + name) {
    run.soil.force_kind(ForceKind::step_mean);
  }
  void go(Solver& structure, bool wire = false) {
    RunRecord files(run.folder.string(), "coupler");
    if (wire) return test::couple_through_sockets(run.settings, run.soil, structure, files);
    CouplingLoop(run.settings, {{"structure", structure}, {"soil", run.soil}}, files).run();
  }

  CoupledRun run;
};

TEST(CouplingLoop, mean_forces_of_a_step_work_as_they_are) {
  MeanForces local("local"), remote("remote");
  MeanSprings structure(2, 1, 100), behind_the_wire(2, 1, 100);
  local.go(structure);
  EXPECT_EQ(structure.kind, ForceKind::step_mean);
  const auto energy = local.run.column("probes.csv", "structure.energy");
  const auto work = local.run.column("steps.csv", "structure_work");
  const auto sum = local.run.column("steps.csv", "work_sum");
  double largest = 0;
  for (const auto& cell : work) largest = std::max(largest, std::abs(std::stod(cell)));
  EXPECT_GT(largest, 0.01);
  for (std::size_t n = 0; n < 20; ++n) {
    const double gain = std::stod(energy[n + 1]) - std::stod(energy[n]);
    EXPECT_NEAR(std::stod(work[n]), gain, 1e-12 * largest) << "step " << n;
    EXPECT_NEAR(std::stod(sum[n]), 0, 1e-7 * largest) << "step " << n;
  }
  remote.go(behind_the_wire, true);
  EXPECT_EQ(behind_the_wire.kind, ForceKind::step_mean);
  for (const std::string file : {"iterations.csv", "steps.csv", "probes.csv"}) {
    EXPECT_EQ(remote.run.table(file), local.run.table(file)) << file;
  }
}

/// A structure that takes them as forces of the end of the step still runs, and work_sum shows the
/// error.
TEST(CouplingLoop, mean_forces_taken_for_others_show_in_the_work) {
  for (const bool wire : {false, true}) {
    MeanForces old("old");
    StructureSprings structure(2, 1, 100);
    old.go(structure, wire);
    EXPECT_EQ(old.run.summary()["completed"], true);
    const auto energy = old.run.column("probes.csv", "structure.energy");
    const auto work = old.run.column("steps.csv", "structure_work");
    double largest = 0;
    for (std::size_t n = 0; n < 20; ++n) {
      const double gain = std::stod(energy[n + 1]) - std::stod(energy[n]);
      EXPECT_NEAR(std::stod(work[n]), gain, 1e-12) << "step " << n;
      largest = std::max(largest, std::abs(std::stod(old.run.column("steps.csv", "work_sum")[n])));
    }
    EXPECT_GT(largest, 1e-4);
  }
}

TEST(CouplingLoop, the_explicit_scheme_makes_work) {
  CoupledRun run("lag");
  run.settings.coupling.scheme = Scheme::explicit_;
  run.settings.time.end = 0.05;
  run.go();
  double largest = 0;
  for (const auto& cell : run.column("steps.csv", "work_sum")) {
    largest = std::max(largest, std::abs(std::stod(cell)));
  }
  EXPECT_GT(largest, 1e-5);
}

TEST(CouplingLoop, numbers_of_solution_and_acceptance_are_in_the_steps) {
  CoupledRun run("numbers");
  run.soil.load = [](double t) { return t > 0.055 ? 5.0 : 0.0; };
  run.structure.on_solve = [](const StepRequest& request) {
    if (request.step == 9 && request.dt > 0.006) throw ConvergenceError("too large");
  };
  run.go();
  const auto iterations = run.column("steps.csv", "iterations");
  const auto skipped = run.column("steps.csv", "skipped");
  const auto soil = run.column("steps.csv", "soil.linear_iterations");
  const auto structure = run.column("steps.csv", "structure.linear_iterations");
  const auto accepted = run.column("steps.csv", "structure.accepted_steps");
  int solved = 0;
  for (std::size_t n = 0; n < iterations.size(); ++n) {
    const int count = std::stoi(iterations[n]);
    const bool slept = skipped[n] == "structure";
    EXPECT_EQ(std::stoi(soil[n]), 7 * count);
    EXPECT_EQ(std::stoi(structure[n]), slept ? 0 : 7 * count);
    EXPECT_EQ(accepted[n], slept ? "" : std::to_string(++solved));
  }
  EXPECT_GT(solved, 10);
}

TEST(CouplingLoop, wall_times_of_a_step_add_up) {
  CoupledRun run("seconds");
  run.settings.time.end = 0.05;
  run.structure.on_solve = [](const StepRequest& request) {
    if (request.step != 4 || request.dt < 0.006) return;
    std::this_thread::sleep_for(std::chrono::milliseconds(20));
    throw ConvergenceError("too large");  // its time counts
  };
  run.go();
  std::ifstream in(run.folder / "steps.csv");
  const std::vector<std::string> last = {"soil.busy_seconds",         "soil.message_seconds",
                                         "soil.waiting_seconds",      "structure.busy_seconds",
                                         "structure.message_seconds", "structure.waiting_seconds",
                                         "acceleration_seconds",      "wall_seconds"};
  std::string line;
  std::getline(in, line);
  EXPECT_TRUE(line.ends_with(fmt::format(",{}", fmt::join(last, ",")))) << line;
  for (int step = 1; std::getline(in, line); ++step) {
    std::vector<double> cells;
    std::stringstream stream(line);
    for (std::string cell; std::getline(stream, cell, ',');) {
      cells.push_back(cell.find_first_not_of("0123456789.e+-") == cell.npos ? std::atof(cell.data())
                                                                            : 0);
    }
    const double* t = cells.data() + cells.size() - 8;
    EXPECT_NEAR(t[0] + t[1] + t[2], t[7], 1e-12);
    EXPECT_NEAR(t[3] + t[4] + t[5], t[7], 1e-12);
    EXPECT_EQ(t[1], 0);  // no messages
    EXPECT_GT(t[0], 0);
    EXPECT_GT(t[2], 0);
    EXPECT_LE(t[0] + t[3] + t[6], t[7]);
    if (step == 4) {
      EXPECT_GE(t[3], 0.02);
    }
  }
}

TEST(CouplingLoop, two_runs_write_the_same_tables) {
  CoupledRun first("first");
  CoupledRun second("second");
  first.go();
  second.go();
  for (const std::string file : {"iterations.csv", "steps.csv", "probes.csv"}) {
    const auto rows = first.table(file);
    EXPECT_GT(rows.size(), 20u);
    EXPECT_EQ(rows, second.table(file)) << file;
  }
}

TEST(CouplingLoop, frames_are_written_at_the_start_at_multiples_and_at_the_end) {
  CoupledRun run("frames");
  run.settings.time.end = 0.17;
  run.go();
  ASSERT_EQ(run.soil.written.size(), 5u);
  const std::vector<double> expected = {0, 0.05, 0.1, 0.15, 0.17};
  for (std::size_t i = 0; i < 5; ++i) EXPECT_NEAR(run.soil.written[i], expected[i], 1e-14);
  EXPECT_EQ(run.structure.written, run.soil.written);
}

TEST(CouplingLoop, a_solver_that_fails_at_large_steps_gets_smaller_ones) {
  CoupledRun run("cut");
  run.structure.on_solve = [](const StepRequest& request) {
    if (request.time > 0.045 && request.time < 0.075 && request.dt > 0.006) {
      throw ConvergenceError("too large");
    }
  };
  run.go();
  const Json summary = run.summary();
  EXPECT_EQ(summary["completed"], true);
  EXPECT_GE(summary["cuts"], 1);
  EXPECT_EQ(summary["cuts"], run.structure.rejected);
  EXPECT_EQ(run.soil.rejected, run.structure.rejected);
  EXPECT_EQ(run.soil.accepted, summary["steps"]);
  const auto times = run.column("steps.csv", "time");
  EXPECT_EQ(times.back(), "0.2");
  EXPECT_NE(std::find(times.begin(), times.end(), "0.055"), times.end());
  EXPECT_NE(std::find(times.begin(), times.end(), "0.14"), times.end());  // on the raster again
}

/// A structure with inertia yields with dt^2: columns of a step four times as long promise too
/// much.
TEST(CouplingLoop, columns_of_much_longer_steps_are_dropped) {
  for (const double shortest : {0.006, 0.003}) {  // dt that is solved: a half, a quarter
    CoupledRun run("cut_columns");
    run.structure.on_solve = [&](const StepRequest& request) {
      if (request.time > 0.045 && request.time < 0.065 && request.dt > shortest) {
        throw ConvergenceError("too large");
      }
    };
    run.go();
    const Json summary = run.summary();
    EXPECT_EQ(summary["completed"], true);
    EXPECT_EQ(summary["history_resets"], shortest > 0.005 ? 0 : 1);
  }
}

TEST(CouplingLoop, failure_below_dt_min_ends_the_run_and_keeps_what_was_written) {
  CoupledRun run("dt_min");
  run.structure.on_solve = [](const StepRequest& request) {
    if (request.time > 0.045) throw ConvergenceError("wall is gone");
  };
  run.expect_failure({"wall is gone", "dt_min"});
  EXPECT_EQ(run.summary()["steps"], 5);
  EXPECT_EQ(run.table("steps.csv").size(), 6u);
  EXPECT_NEAR(run.soil.written.back(), 0.05, 1e-14);
}

TEST(CouplingLoop, a_step_that_fails_at_any_dt_is_not_cut) {
  for (const bool wire : {false, true}) {
    CoupledRun run("any_dt");
    run.soil.on_solve = [](const StepRequest& request) {
      if (request.time < 0.045) return;
      throw ConvergenceError("too much at once", request.dt < 0.006 ? fails_at_any_dt : "line");
    };
    expect_error<ConvergenceError>([&] { wire ? run.go_behind_the_wire() : run.go(); },
                                   {"too much at once"});
    const Json summary = run.summary();
    test::expect_parts(summary["reason"], {"too much at once"});
    EXPECT_EQ(summary["cuts"], 1);
    EXPECT_EQ(summary["steps"], 5);
    EXPECT_NEAR(run.soil.written.back(), 0.05, 1e-14);
  }
}

TEST(CouplingLoop, the_iteration_limit_is_never_a_silent_success) {
  CoupledRun cut("limit_cut");
  cut.settings.coupling.max_iterations = 2;
  cut.settings.coupling.predictor = 0;
  cut.expect_failure({"coupling limit_reached after 2 iterations", "dt_min"});
  EXPECT_EQ(cut.summary()["steps"], 0);

  CoupledRun stop("limit_stop");
  stop.settings.coupling.max_iterations = 2;
  stop.settings.coupling.on_limit = OnLimit::stop;
  stop.expect_failure({"coupling limit_reached after 2 iterations", "(on_limit is \"stop\")"});
  EXPECT_EQ(stop.summary()["cuts"], 0);

  CoupledRun accept("limit_accept");
  accept.settings.coupling.max_iterations = 2;
  accept.settings.coupling.on_limit = OnLimit::accept;
  accept.go();
  EXPECT_EQ(accept.summary()["completed"], true);
  EXPECT_EQ(accept.summary()["accepted_unconverged"], 20);
  EXPECT_EQ(accept.column("steps.csv", "status")[0], "limit_reached");
}

TEST(CouplingLoop, gauss_seidel_with_a_heavy_soil_diverges_even_when_limits_are_accepted) {
  CoupledRun run("gauss_seidel");
  run.settings.coupling.acceleration.method = "constant";
  run.settings.coupling.acceleration.relaxation = 1;
  run.settings.coupling.on_limit = OnLimit::accept;
  run.soil.scatter = run.structure.scatter = 0;
  run.expect_failure({"coupling diverged after"});
}

TEST(CouplingLoop, without_contact_there_is_one_pass_and_no_structure_solve) {
  CoupledRun run("skip");
  run.soil.load = [](double t) { return t > 0.105 && t < 0.155 ? 5.0 : 0.0; };
  run.go();
  const auto skipped = run.column("steps.csv", "skipped");
  const auto status = run.column("steps.csv", "status");
  ASSERT_EQ(skipped.size(), 20u);
  EXPECT_EQ(skipped[0], "acceleration");  // nobody knows yet that the structure is at rest
  for (int n = 1; n < 10; ++n) EXPECT_EQ(skipped[std::size_t(n)], "structure") << n;
  for (int n = 10; n < 15; ++n) EXPECT_EQ(skipped[std::size_t(n)], "none") << n;
  for (int n = 15; n < 20; ++n)
    EXPECT_EQ(skipped[std::size_t(n)], "acceleration") << n;  // it swings
  EXPECT_EQ(status[3], "inactive");
  EXPECT_EQ(status[12], "converged");
  EXPECT_EQ(run.structure.slept, 9);
  const Json summary = run.summary();
  EXPECT_EQ(summary["skipped"]["structure"], 9);
  EXPECT_EQ(summary["skipped"]["acceleration"], 15);
  EXPECT_EQ(summary["steps_in_contact"], 5);
  EXPECT_EQ(summary["history_resets"], 1);
  EXPECT_EQ(run.column("steps.csv", "iterations")[3], "1");
}

TEST(CouplingLoop, the_parallel_scheme_skips_without_contact_and_solves_again_when_it_ends) {
  CoupledRun serial("skip_serial");
  CoupledRun parallel("skip_parallel");
  parallel.settings.coupling.scheme = Scheme::parallel_implicit;
  for (CoupledRun* run : {&serial, &parallel}) {
    run->soil.load = [](double t) { return t > 0.105 && t < 0.155 ? 5.0 : 0.0; };
    run->go();
  }
  for (const std::string name : {"skipped", "status"}) {
    EXPECT_EQ(parallel.column("steps.csv", name), serial.column("steps.csv", name));
  }
  EXPECT_EQ(parallel.structure.slept, serial.structure.slept);
  const auto a = serial.column("probes.csv", "structure.u");
  const auto b = parallel.column("probes.csv", "structure.u");
  for (std::size_t n = 0; n < a.size(); ++n) EXPECT_NEAR(std::stod(a[n]), std::stod(b[n]), 1e-10);
}

TEST(CouplingLoop, contact_that_is_possible_but_has_no_force_is_solved_in_every_scheme) {
  CoupledRun serial("near_serial"), parallel("near_parallel");
  parallel.settings.coupling.scheme = Scheme::parallel_implicit;
  for (CoupledRun* run : {&serial, &parallel}) {
    run->soil.near = true;
    run->soil.load = [](double t) { return t > 0.105 ? 5.0 : 0.0; };
    run->go();
    EXPECT_EQ(run->summary()["cuts"], 0);
    EXPECT_EQ(run->structure.slept, 0);
    const auto iterations = run->column("steps.csv", "iterations");
    for (std::size_t n = 1; n < 10; ++n) EXPECT_EQ(iterations[n], "2") << n;
    for (const std::string& skipped : run->column("steps.csv", "skipped")) {
      EXPECT_EQ(skipped, "none");
    }
  }
  const auto a = serial.column("probes.csv", "structure.u");
  const auto b = parallel.column("probes.csv", "structure.u");
  ASSERT_EQ(a.size(), b.size());
  for (std::size_t n = 0; n < a.size(); ++n) EXPECT_NEAR(std::stod(a[n]), std::stod(b[n]), 1e-10);
}

TEST(CouplingLoop, one_structure_swings_while_the_soil_is_near_another_one_at_rest) {
  for (const Scheme scheme : {Scheme::serial_implicit, Scheme::parallel_implicit}) {
    SCOPED_TRACE(name(scheme));
    CoupledRun run("two_structures");
    run.settings.coupling.scheme = scheme;
    run.settings.participants.insert(run.settings.participants.end(),
                                     {{"far_soil", true}, {"far_structure", false}});
    run.settings.interfaces.push_back({"far_wall", "far_soil", "far_structure"});
    SoilSprings far_soil(3, 2, 10);
    StructureSprings far_structure(2, 1, 100);
    far_soil.rename_interface("far_wall");
    far_structure.rename_interface("far_wall");
    run.soil.load = [](double t) { return t > 0.035 && t < 0.075 ? 5.0 : 0.0; };
    far_soil.near = true;
    RunRecord files(run.folder.string(), "coupler");
    CouplingLoop(run.settings,
                 {{"structure", run.structure},
                  {"soil", run.soil},
                  {"far_soil", far_soil},
                  {"far_structure", far_structure}},
                 files)
        .run();
    EXPECT_EQ(run.summary()["cuts"], 0);
    EXPECT_EQ(run.summary()["steps_in_contact"], 20);
    EXPECT_GT(run.structure.probes()[1], 0);
    EXPECT_NEAR(far_structure.probes()[1], 0, 1e-20);
    EXPECT_EQ(run.structure.slept + far_structure.slept, 0);
  }
}

TEST(CouplingLoop, a_failure_in_the_parallel_scheme_leaves_nothing_under_way) {
  for (const auto& [of_soil, wire] :
       {std::pair(true, false), {false, false}, {true, true}, {false, true}}) {
    CoupledRun run("parallel_cut");
    run.settings.coupling.scheme = Scheme::parallel_implicit;
    auto& solver = of_soil ? static_cast<test::MassSprings&>(run.soil) : run.structure;
    solver.on_solve = [](const StepRequest& request) {
      if (request.step == 4 && request.dt > 0.006) throw ConvergenceError("too large");
    };
    wire ? run.go_behind_the_wire() : run.go();
    EXPECT_EQ(run.summary()["completed"], true);
    EXPECT_EQ(run.summary()["cuts"], 1);
    EXPECT_EQ(run.soil.solves, run.structure.solves + (run.structure.slept ? 1 : 0));
  }
}

/// The dt that a solver proposes changes, so that the next step comes otherwise than it was asked
/// for; frames, cuts and a limit by iterations come between.
void propose_and_fail(CoupledRun& run, bool of_soil) {
  test::MassSprings& solver = of_soil ? static_cast<test::MassSprings&>(run.soil) : run.structure;
  solver.propose = [](int step) { return step % 5 == 0 ? 0.003 : step % 3 == 0 ? 0.02 : 0.006; };
  run.soil.on_solve = [](const StepRequest& request) {
    if (request.step == 8 && request.dt > 0.002) throw ConvergenceError("too large");
  };
  run.settings.coupling.step_control = {4, 0};
}

TEST(CouplingLoop, a_next_step_that_is_asked_for_early_changes_no_row) {
  for (const Scheme scheme : {Scheme::serial_implicit, Scheme::parallel_implicit}) {
    for (const bool of_soil : {true, false}) {
      SCOPED_TRACE(fmt::format("{} soil {}", name(scheme), of_soil));
      CoupledRun local("early_local"), remote("early_remote");
      for (CoupledRun* run : {&local, &remote}) {
        propose_and_fail(*run, of_soil);
        run->settings.coupling.scheme = scheme;
        run == &local ? run->go() : run->go_behind_the_wire();
      }
      for (const std::string file : {"iterations.csv", "steps.csv", "probes.csv"}) {
        EXPECT_EQ(remote.table(file), local.table(file)) << file;
      }
      EXPECT_EQ(local.summary()["started_early"], 0);
      const Json summary = remote.summary();
      EXPECT_GT(summary["started_early"], 10);
      if (of_soil) {
        EXPECT_GT(summary["called_off"], 0);
        EXPECT_LT(summary["called_off"], summary["started_early"]);
      } else {  // known before the soil is asked
        EXPECT_EQ(summary["called_off"], 0);
      }
      EXPECT_EQ(remote.soil.written, local.soil.written);
      const Json& soil = summary["messages"]["soil"];
      EXPECT_EQ(soil["accept_step"]["count"], summary["steps"]);
      EXPECT_EQ(remote.soil.solves, local.soil.solves);  // passed, not solved
    }
  }
}

/// Checkpoints that come unforeseen, as at a signal.
struct SuddenKeeper final : RunKeeper {
  explicit SuddenKeeper(const test::MassSprings& soil) : soil_(soil) {}
  const RestartPoint* start() const override { return nullptr; }
  bool due(std::int64_t step) override { return step % 4 == 0; }
  bool is_due(std::int64_t) const override { return false; }
  void save(const RunPoint& point, const State&) override {
    ++saved;
    EXPECT_EQ(soil_.accepted, point.step);
    EXPECT_EQ(soil_.rejected + (point.step == 20), saved);  // at the end nothing is under way
  }
  int signal() override { return 0; }

  int saved = 0;

 private:
  const test::MassSprings& soil_;
};

TEST(CouplingLoop, a_checkpoint_gives_up_what_was_asked_for_early) {
  CoupledRun run("sudden"), reference("sudden_reference");
  reference.settings.output_interval = run.settings.output_interval = run.settings.time.end;
  reference.go();
  SuddenKeeper keeper(run.soil);
  RunRecord files(run.folder.string(), "coupler");
  test::couple_through_sockets(run.settings, run.soil, run.structure, files, &keeper);
  EXPECT_EQ(keeper.saved, 5);
  EXPECT_EQ(run.summary()["called_off"], 4);
  EXPECT_EQ(run.table("steps.csv"), reference.table("steps.csv"));
}

TEST(CouplingLoop, many_iterations_halve_dt_and_few_let_it_grow) {
  CoupledRun run("step_control");
  run.settings.coupling.step_control = {3, 5};
  run.settings.coupling.predictor = 0;
  run.soil.load = [](double t) { return t < 0.105 ? 5.0 : 0.0; };
  run.go();
  const auto dt = run.column("steps.csv", "dt");
  const auto iterations = run.column("steps.csv", "iterations");
  bool halved = false, grown = false;
  for (std::size_t n = 1; n < dt.size(); ++n) {
    const double ratio = std::stod(dt[n]) / std::stod(dt[n - 1]);
    const int before = std::stoi(iterations[n - 1]);
    if (before >= 5 && std::stod(dt[n - 1]) > 0.01 / 64) {
      EXPECT_EQ(ratio, 0.5) << n;
    }
    if (before > 3) {
      EXPECT_LE(ratio, 1) << n;
    }
    halved = halved || ratio == 0.5;
    grown = grown || ratio == 2;
  }
  EXPECT_TRUE(halved);
  EXPECT_TRUE(grown);
  EXPECT_EQ(run.summary()["cuts"], 0);
  EXPECT_EQ(run.summary()["end_time"], 0.2);
}

TEST(CouplingLoop, every_method_ends_with_a_reason_and_never_in_success) {
  for (const Scheme scheme : {Scheme::serial_implicit, Scheme::parallel_implicit}) {
    for (const std::string& method : acceleration_methods()) {
      SCOPED_TRACE(name(scheme) + " " + method);
      CoupledRun run("reasons");
      run.settings.coupling.scheme = scheme;
      run.settings.coupling.acceleration.method = method;
      run.settings.coupling.max_iterations = 1000;  // new minima by chance get rare
      // A soil that trembles: no fixed point within the limits.
      int solves = 0;
      run.soil.on_solve = [&](const StepRequest&) { ++solves; };
      run.soil.load = [&](double) { return 5 + 1e-3 * (solves % 3); };
      const std::string text = test::error_of<ConvergenceError>([&] { run.go(); });
      const std::string status = run.column("iterations.csv", "status").back();
      EXPECT_TRUE(status == "stagnated" || status == "diverged") << status;
      test::expect_parts(text, {"coupling " + status + " after"});
      EXPECT_EQ(run.summary()["completed"], false);
      EXPECT_EQ(run.summary()["reason"], text);
    }
  }
}

TEST(CouplingLoop, a_limit_below_round_off_is_named_when_it_is_missed) {
  CoupledRun run("round_off");
  run.settings.coupling.convergence.force = {1e-30, {}, 0, {}};
  int solves = 0;
  run.soil.on_solve = [&](const StepRequest&) { ++solves; };
  run.soil.load = [&](double) { return 5 + 1e-3 * (solves % 3); };
  run.expect_failure({"the limit of the force is below the round-off of its values"});
}

TEST(CouplingLoop, skipping_does_not_change_the_result) {
  const auto pulse = [](double t) { return t > 0.105 ? 5.0 : 0.0; };
  CoupledRun skipping("skipping");
  skipping.soil.load = pulse;
  skipping.go();
  CoupledRun solving("solving");
  solving.soil.load = [&](double t) {
    return pulse(t) + 1e-300;
  };  // contact is possible all the time
  solving.go();
  const auto a = skipping.column("probes.csv", "structure.u");
  const auto b = solving.column("probes.csv", "structure.u");
  for (std::size_t n = 0; n < a.size(); ++n) EXPECT_NEAR(std::stod(a[n]), std::stod(b[n]), 1e-11);
  EXPECT_LT(skipping.structure.solves, solving.structure.solves);
}

TEST(CouplingLoop, a_soil_that_pushes_but_calls_itself_inactive_is_refused) {
  CoupledRun run("pretend");
  run.soil.pretend_inactive = true;
  expect_error<Error>([&] { run.go(); },
                      {"the soil sends a force (largest component 7.5 N) and says "
                       "that its interfaces are not active"});
  EXPECT_EQ(run.summary()["completed"], false);
}

TEST(CouplingLoop, values_that_are_not_finite_are_cut_and_end_the_run) {
  CoupledRun run("nan");
  run.soil.load = [](double t) { return t > 0.055 ? std::nan("") : 5.0; };
  run.expect_failure({"coupling not_finite after 1 iterations", "dt_min"});
  const auto status = run.column("iterations.csv", "status");
  EXPECT_EQ(status.back(), "not_finite");
  EXPECT_GT(run.summary()["cuts"], 0);
}

TEST(CouplingLoop, deformed_positions_of_surfaces_that_fit_change_nothing_but_rounding) {
  CoupledRun reference("reference");
  reference.go();
  CoupledRun deformed("deformed");
  deformed.settings.coupling.mapping.deformed = true;
  deformed.settings.coupling.mapping.moved = 0;
  deformed.go();
  EXPECT_EQ(reference.summary()["mapping"]["wall"]["set_ups"], 1);
  EXPECT_EQ(deformed.summary()["mapping"]["wall"]["set_ups"], 21);  // each of the steps moves it
  const auto expected = reference.column("probes.csv", "structure.u");
  const auto found = deformed.column("probes.csv", "structure.u");
  ASSERT_EQ(found.size(), expected.size());
  for (std::size_t i = 0; i < found.size(); ++i) {
    EXPECT_NEAR(std::stod(found[i]), std::stod(expected[i]), 1e-12);
  }
}

TEST(CouplingLoop, explicit_scheme_makes_one_pass_a_step) {
  CoupledRun run("explicit");
  run.settings.coupling.scheme = Scheme::explicit_;
  run.settings.time.end = 0.05;
  run.go();
  EXPECT_EQ(run.soil.solves, 5);
  EXPECT_EQ(run.structure.solves, 5);
  EXPECT_EQ(run.column("steps.csv", "status")[0], "explicit");
}

TEST(CouplingLoop, is_the_same_to_the_bit_with_participants_behind_the_wire) {
  CoupledRun local("local");
  local.structure.on_solve = [](const StepRequest& request) {
    if (request.step == 4 && request.dt > 0.006) throw ConvergenceError("too large");
  };
  local.go();

  CoupledRun remote("remote");
  remote.structure.on_solve = local.structure.on_solve;
  remote.go_behind_the_wire();
  for (const std::string file : {"iterations.csv", "steps.csv", "probes.csv"}) {
    EXPECT_EQ(remote.table(file), local.table(file)) << file;
  }
  EXPECT_EQ(remote.summary()["cuts"], 1);
}

TEST(CouplingLoop, both_solvers_work_at_once_in_the_parallel_scheme) {
  CoupledRun local("local_parallel");
  local.settings.coupling.scheme = Scheme::parallel_implicit;
  local.settings.time.end = 0.05;
  local.go();
  CoupledRun remote("remote_parallel");
  remote.settings = local.settings;
  std::atomic<int> soil_began{0}, structure_began{0}, missed{0};
  // Each waits inside its solution until the other one is in its own.
  const auto meet = [&](std::atomic<int>& mine, std::atomic<int>& theirs) {
    const int now = ++mine;
    const Stopwatch watch;
    while (theirs < now && watch.seconds() < 60) std::this_thread::yield();
    if (theirs < now) ++missed;
  };
  remote.soil.on_solve = [&](const StepRequest&) { meet(soil_began, structure_began); };
  remote.structure.on_solve = [&](const StepRequest&) { meet(structure_began, soil_began); };
  remote.go_behind_the_wire();
  EXPECT_EQ(missed, 0);
  EXPECT_GT(soil_began, 10);
  for (const std::string file : {"iterations.csv", "steps.csv", "probes.csv"}) {
    EXPECT_EQ(remote.table(file), local.table(file)) << file;
  }
}

TEST(CouplingLoop, a_participant_that_is_missing_is_named) {
  CoupledRun run("missing");
  RunRecord files(run.folder.string(), "coupler");
  expect_error<ConfigError>(
      [&] {
        CouplingLoop(run.settings, {{"soil", run.soil}}, files);
      },
      {"participant \"structure\" of coupler.json is missing"});
}

}  // namespace
}  // namespace gabion::test_coupling_loop
