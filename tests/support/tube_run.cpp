// SPDX-License-Identifier: BSD-3-Clause
#include "tests/support/tube_run.hpp"

#include <unistd.h>

#include <atomic>
#include <cmath>
#include <filesystem>
#include <fstream>

#include "tests/support/solver_server.hpp"

namespace gabion::test {

namespace {

namespace fs = std::filesystem;

CouplerSettings settings_of(const TubeRun& run) {
  CouplerSettings s;
  s.time = {run.steps * run.dt, run.dt, run.dt};  // no smaller step: a failure shall be seen
  s.output_interval = s.time.end;
  s.participants = {{"soil", true}, {"structure", false}};
  s.interfaces = {{"wall", "soil", "structure"}};
  s.coupling.acceleration = run.acceleration;
  s.coupling.predictor = run.predictor;
  s.coupling.max_iterations = run.max_iterations;
  s.coupling.on_limit = run.accept_at_limit ? OnLimit::accept : OnLimit::stop;
  s.coupling.mapping.method = "nearest_neighbor";
  s.coupling.mapping.tolerance = 1e-9;
  // |a| = 1 within some percent, and half of all components are the zeros of y.
  s.coupling.convergence.displacement.absolute = run.tolerance / std::sqrt(2.0);
  s.coupling.convergence.force.relative = run.tolerance;
  s.coupling.convergence.divergence = 1e6;
  // The first iterations of the first step lead away from the solution, by orders of magnitude.
  s.coupling.convergence.stagnation = run.max_iterations;
  return s;
}

/// Counts the coupling iterations of each step.
class CountingFlow : public TubeFlow {
 public:
  StepReport solve_step(const StepRequest& request, const InterfaceValues& received,
                        InterfaceValues& sent) override {
    iterations = request.iteration + 1;
    return TubeFlow::solve_step(request, received, sent);
  }
  AcceptReport accept_step(const StepRequest& request, bool solved) override {
    total += iterations;
    if (request.step == 1) first = iterations;
    max = std::max(max, iterations);
    return TubeFlow::accept_step(request, solved);
  }
  int iterations = 0, total = 0, first = 0, max = 0;
};

}  // namespace

std::vector<std::pair<std::string, Filter>> grid_filters() {
  return {{"none", {FilterKind::none, 0}},
          {"qr1 1e-2", {FilterKind::qr1, 1e-2}},
          {"qr1 1e-6", {FilterKind::qr1, 1e-6}},
          {"qr1_absolute 1e-8", {FilterKind::qr1_absolute, 1e-8}},
          {"qr2 1e-2", {FilterKind::qr2, 1e-2}},
          {"qr2 1e-6", {FilterKind::qr2, 1e-6}},
          {"qr3 1e-2", {FilterKind::qr3, 1e-2}}};
}

TubeRun grid_run(const Filter& filter, double relaxation, int columns, double dt) {
  TubeRun run;
  run.acceleration.filter = filter;
  run.acceleration.relaxation = relaxation;
  run.acceleration.max_columns = columns;
  run.predictor = 1;
  run.dt = dt;
  run.steps = static_cast<int>(std::lround(1 / dt));
  return run;
}

TubeResult run_tube(const TubeRun& run) {
  static std::atomic<int> count = 0;
  const fs::path folder = fs::temp_directory_path() / ("gabion_tube_" + std::to_string(getpid()) +
                                                       "_" + std::to_string(++count));
  CountingFlow flow;
  TubeWall wall;
  TubeResult result;
  try {
    RunRecord files(folder.string(), "coupler");
    if (run.through_sockets) {
      couple_through_sockets(settings_of(run), flow, wall, files);
    } else {
      CouplingLoop(settings_of(run), {{"soil", flow}, {"structure", wall}}, files).run();
    }
  } catch (const ConvergenceError& error) {
    result.failure = error.what();
  }
  Json summary;
  std::ifstream(folder / "summary.json") >> summary;
  result.at_limit = summary.at("accepted_unconverged");
  fs::remove_all(folder);
  result.mean_iterations = static_cast<double>(flow.total) / run.steps;
  result.first_step = flow.first;
  result.max = flow.max;
  result.pressure = flow.probes()[0];
  result.area = wall.probes()[0];
  return result;
}

}  // namespace gabion::test
