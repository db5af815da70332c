// SPDX-License-Identifier: BSD-3-Clause
#include "tests/benchmarks/trivial_participants.hpp"

#include <sys/wait.h>
#include <unistd.h>

#include <cmath>
#include <filesystem>
#include <fstream>
#include <map>
#include <sstream>
#include <vector>

#include "common/base/log.hpp"
#include "common/base/require.hpp"
#include "common/program/freed_memory.hpp"
#include "coupler/coupling_loop.hpp"
#include "coupler/run_coupler.hpp"
#include "protocol/serve.hpp"

namespace gabion::test {

namespace {

namespace fs = std::filesystem;

/// Soil: f_i = m_i x_i. Structure: x_tilde_i = b_i(t) - f_i.
class Trivial : public Solver {
 public:
  Trivial(std::int64_t num_nodes, bool is_soil) : is_soil_(is_soil) {
    mesh_.name = "wall";
    mesh_.dim = 3;
    mesh_.vertices_per_facet = 0;
    for (std::int64_t i = 0; i < num_nodes; ++i) {
      mesh_.coordinates.insert(mesh_.coordinates.end(), {double(i), 0, 0});
    }
  }
  std::vector<InterfaceMesh> interfaces() const override { return {mesh_}; }
  std::vector<std::string> probe_names() const override { return {}; }
  std::vector<double> probes() const override { return {}; }
  StepReport solve_step(const StepRequest& request, const InterfaceValues& received,
                        InterfaceValues& sent) override {
    const std::vector<double>& in = received.at("wall");
    std::vector<double>& out = sent["wall"];
    out.resize(in.size());
    const double t = request.time + request.dt;
    for (std::size_t i = 0; i < in.size(); ++i) {
      const double y = double(i) / double(in.size());
      out[i] = is_soil_ ? 0.9 * y * in[i] : std::cos(y + t) - in[i];
    }
    return {};
  }
  AcceptReport accept_step(const StepRequest&, bool) override { return {}; }
  void reject_step() override {}
  void write_output(double) override {}
  Json summary() const override { return Json::object(); }

 private:
  bool is_soil_;
  InterfaceMesh mesh_;
};

/// A participant in a process of its own; reads the endpoint from the pipe.
pid_t start_participant(std::int64_t num_nodes, bool is_soil, int (&to_child)[2]) {
  require(pipe(to_child) == 0, "no pipe to a participant");
  const pid_t pid = fork();
  require(pid >= 0, "no process for a participant");
  if (pid > 0) {
    close(to_child[0]);
    return pid;
  }
  close(to_child[1]);
  int code = 1;
  try {
    char endpoint[256] = {};
    require(read(to_child[0], endpoint, sizeof endpoint - 1) > 0, "the coupler gave no endpoint");
    ParticipantSettings settings;
    settings.endpoint = endpoint;
    settings.name = is_soil ? "soil" : "structure";
    settings.program = "trivial";
    settings.dimension = 3;
    settings.receives = is_soil ? displacement() : force();
    settings.sends = is_soil ? force() : displacement();
    Trivial solver(num_nodes, is_soil);
    Connection connection(settings);
    serve(solver, connection);
    code = 0;
  } catch (const std::exception& error) {
    log::error("{}", error.what());
  }
  _exit(code);
}

CouplerSettings settings_of(const Overhead& what) {
  CouplerSettings s;
  s.time = {what.steps * 0.01, 0.01, 0.01};
  s.output_interval = s.time.end;
  s.participants = {{"soil", true}, {"structure", false}};
  s.interfaces = {{"wall", "soil", "structure"}};
  s.coupling.acceleration.method = what.method;
  s.coupling.acceleration.filter = {FilterKind::none, 0};
  s.coupling.acceleration.history = 1000;
  s.coupling.acceleration.max_columns = what.columns;
  s.coupling.max_iterations = what.iterations;
  s.coupling.on_limit = OnLimit::accept;  // the residual is not the point here
  s.coupling.convergence.displacement.absolute = 1e-300;
  s.coupling.convergence.divergence = 1e300;
  s.coupling.convergence.stagnation = 1000;
  s.coupling.mapping.method = "nearest_neighbor";
  s.coupling.mapping.tolerance = 1e-9;
  return s;
}

/// Sum of a column of steps.csv over the second half of the steps.
std::map<std::string, double> sums_of_second_half(const fs::path& table, int steps) {
  std::ifstream in(table);
  std::string line, cell;
  std::getline(in, line);
  std::vector<std::string> names;
  for (std::stringstream head(line); std::getline(head, cell, ',');) names.push_back(cell);
  std::map<std::string, double> sums;
  for (int step = 1; std::getline(in, line); ++step) {
    if (step <= steps / 2) continue;
    std::stringstream cells(line);
    for (const std::string& name : names) {
      std::getline(cells, cell, ',');
      sums[name] += std::strtod(cell.c_str(), nullptr);
    }
  }
  return sums;
}

double resident_mb() {
  std::ifstream in("/proc/self/statm");
  double total = 0, resident = 0;
  in >> total >> resident;
  return resident * static_cast<double>(sysconf(_SC_PAGESIZE)) / 1e6;
}

}  // namespace

OverheadResult measure_overhead(const Overhead& what) {
  keep_freed_memory();  // as the programs do
  int soil_pipe[2], structure_pipe[2];
  const pid_t soil = start_participant(what.num_nodes, true, soil_pipe);
  const pid_t structure = start_participant(what.num_nodes, false, structure_pipe);
  const fs::path folder =
      fs::temp_directory_path() / ("gabion_overhead_" + std::to_string(getpid()));
  OverheadResult result;
  {
    Server server({"tcp://127.0.0.1:*", {}});
    const std::string endpoint = server.endpoint();
    for (const int end : {soil_pipe[1], structure_pipe[1]}) {
      require(write(end, endpoint.data(), endpoint.size()) > 0, "a participant is gone");
      close(end);
    }
    const CouplerSettings settings = settings_of(what);
    const auto solvers = server.wait_for(expected_participants(settings, "any"));
    RunRecord files(folder.string(), "coupler");
    CouplingLoop loop(
        settings, {{"soil", *solvers.at("soil")}, {"structure", *solvers.at("structure")}}, files);
    loop.run();
    result.resident_mb = resident_mb();
    server.finish();
  }
  for (const pid_t pid : {soil, structure}) {
    int status = 0;
    require(waitpid(pid, &status, 0) == pid && status == 0, "a participant failed");
  }
  auto sums = sums_of_second_half(folder / "steps.csv", what.steps);
  fs::remove_all(folder);
  const double us = 1e6 / sums["iterations"];
  const double busy = sums["soil.busy_seconds"] + sums["structure.busy_seconds"];
  result.all = us * (sums["wall_seconds"] - busy);
  result.messages = us * (sums["soil.message_seconds"] + sums["structure.message_seconds"]);
  result.acceleration = us * sums["acceleration_seconds"];
  result.rest = result.all - result.messages - result.acceleration;
  return result;
}

}  // namespace gabion::test
