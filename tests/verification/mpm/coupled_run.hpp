// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <unistd.h>

#include <filesystem>

#include "common/settings/config_reader.hpp"
#include "coupler/coupling_loop.hpp"
#include "fem_solver/fem_config.hpp"
#include "fem_solver/run_fem.hpp"
#include "tests/support/mpi_main.hpp"
#include "tests/support/temporary_scene.hpp"

namespace gabion::test {

/// The solver of a fem.json, made as the program makes it.
inline std::unique_ptr<Solver> make_fem(const Json& json) {
  const TemporaryScene folder("fem.json", json);
  const Scene scene(folder.path(), {});
  ConfigReader in = scene.reader("fem.json", fem::fem_keys());
  return make_fem_solver(scene, in, comm(), "", nullptr);
}

/// A solver that remembers the answer that was accepted last, and the probes after each step.
class Witness : public Solver {
 public:
  explicit Witness(Solver& solver) : solver_(solver) {}
  std::vector<InterfaceMesh> interfaces() const override { return solver_.interfaces(); }
  std::vector<std::string> probe_names() const override { return solver_.probe_names(); }
  bool takes_force_kinds() const override { return solver_.takes_force_kinds(); }
  void set_force_kinds(const ForceKinds& kinds) override { solver_.set_force_kinds(kinds); }
  StepReport solve_step(const StepRequest& request, const InterfaceValues& received,
                        InterfaceValues& sent) override {
    const StepReport report = solver_.solve_step(request, received, sent);
    answer = sent;
    return report;
  }
  AcceptReport accept_step(const StepRequest& request, bool solved) override {
    const AcceptReport report = solver_.accept_step(request, solved);
    time.push_back(request.time + request.dt);
    answers.push_back(answer);
    probe_rows.push_back(solver_.probes());
    return report;
  }
  void reject_step() override { solver_.reject_step(); }
  void write_output(double time_now) override { solver_.write_output(time_now); }
  std::vector<double> probes() const override { return solver_.probes(); }
  Json summary() const override { return solver_.summary(); }

  InterfaceValues answer;
  std::vector<double> time;  ///< of the accepted steps [s], like the two below
  std::vector<InterfaceValues> answers;
  std::vector<std::vector<double>> probe_rows;

 private:
  Solver& solver_;
};

/// The coupling loop between "soil" and "structure", in one process and without files left behind.
inline void run_coupled(const CouplerSettings& settings, Solver& soil, Solver& structure) {
  namespace fs = std::filesystem;
  const fs::path folder = fs::temp_directory_path() / ("gabion_loop_" + std::to_string(getpid()));
  fs::remove_all(folder);
  {
    RunRecord files(folder.string(), "coupler");
    CouplingLoop loop(settings, {{"soil", soil}, {"structure", structure}}, files);
    loop.run();
  }
  fs::remove_all(folder);
}

}  // namespace gabion::test
