// SPDX-License-Identifier: BSD-3-Clause
// The structure of model.hpp behind the coupler: it asks, these functions answer.
//
//     structure --coupler tcp://host:port
#include <protocol/serve.hpp>

#include <csignal>
#include <cstdio>
#include <string_view>

#include "model.hpp"

namespace {

/// A step always starts from the accepted state; only accept_step moves that on.
class Structure : public gabion::Solver {
 public:
  std::vector<gabion::InterfaceMesh> interfaces() const override {
    return {
        {"wall", model::dimension, surface_.points, model::vertices_per_facet, surface_.facets}};
  }

  /// Nothing to do: implicit Euler adds dt F of momentum, be F the mean of the step or the force at
  /// its end.
  bool takes_force_kinds() const override { return true; }
  void set_force_kinds(const gabion::ForceKinds&) override {}

  gabion::StepReport solve_step(const gabion::StepRequest& request,
                                const gabion::InterfaceValues& received,
                                gabion::InterfaceValues& sent) override {
    std::vector<double> force(surface_.points.size());  // no contact
    if (!received.empty()) force = received.at("wall");
    trial_ = model::step(accepted_, request.dt, force);
    sent["wall"] = model::displacement(trial_, surface_.points.size() / model::dimension);
    return {};
  }

  gabion::AcceptReport accept_step(const gabion::StepRequest&, bool solved) override {
    if (solved) accepted_ = trial_;
    gabion::AcceptReport report;
    report.probes = probes();
    return report;
  }

  void reject_step() override {}
  void write_output(double) override {}

  std::vector<std::string> probe_names() const override {
    const std::vector<std::string> all = {"plate.ux", "plate.uy", "plate.uz"};
    return {all.begin(), all.begin() + model::dimension};
  }
  std::vector<double> probes() const override { return {accepted_.u.begin(), accepted_.u.end()}; }

  bool keeps_state() const override { return true; }
  gabion::State save_state() override {
    gabion::State state;
    state.reals["u"] = {accepted_.u.begin(), accepted_.u.end()};
    state.reals["v"] = {accepted_.v.begin(), accepted_.v.end()};
    return state;
  }
  void load_state(const gabion::State& state) override {
    for (std::size_t i = 0; i < model::dimension; ++i) {
      accepted_.u[i] = state.reals.at("u").at(i);
      accepted_.v[i] = state.reals.at("v").at(i);
    }
  }

  gabion::Json summary() const override { return {{"stiffness", model::stiffness}}; }

 private:
  model::Surface surface_ = model::surface();
  model::State accepted_, trial_;
};

}  // namespace

int main(int argc, char** argv) {
  if (argc != 3 || std::string_view(argv[1]) != "--coupler") {
    std::fputs("usage: structure --coupler tcp://host:port\n", stderr);
    return 2;
  }
  std::signal(SIGTERM, SIG_IGN);  // a signal ends the run, with a checkpoint, not this program
  std::signal(SIGINT, SIG_IGN);
  gabion::ParticipantSettings settings;
  settings.endpoint = argv[2];
  settings.name = "__NAME__";
  settings.program = "structure";
  settings.dimension = model::dimension;
  settings.receives = gabion::force();
  settings.sends = gabion::displacement();
  try {
    gabion::Connection connection(settings);
    Structure structure;
    gabion::serve(structure, connection);
  } catch (const gabion::Error& problem) {
    std::fprintf(stderr, "[__NAME__] error: %s\n", problem.what());
    return problem.exit_code();
  }
  return 0;
}
