// SPDX-License-Identifier: BSD-3-Clause
// A foreign code in C++ that is driven: the spring k u = f (resultant over the wall).
//
//     spring_in_cpp tcp://host:port
#include <common/run/start.hpp>
#include <protocol/serve.hpp>

#include <cstdio>

namespace {

class Spring : public gabion::Solver, public gabion::DisplacedAtStart {
 public:
  std::vector<gabion::InterfaceMesh> interfaces() const override {
    return {{"wall", 2, {0.26, 0, 0.26, 0.05, 0.25, 0.05}, 2, {0, 1, 1, 2}}};
  }
  gabion::InterfaceValues start_displacements() const override {
    return {{"wall",
             {accepted_[0], accepted_[1], accepted_[0], accepted_[1], accepted_[0], accepted_[1]}}};
  }
  std::vector<std::string> probe_names() const override { return {"ux"}; }
  std::vector<double> probes() const override { return {accepted_[0]}; }
  gabion::StepReport solve_step(const gabion::StepRequest&, const gabion::InterfaceValues& received,
                                gabion::InterfaceValues& sent) override {
    const std::vector<double>& force = received.at("wall");
    trial_[0] = (force[0] + force[2] + force[4]) / 1e4;
    trial_[1] = (force[1] + force[3] + force[5]) / 1e4;
    sent["wall"] = {trial_[0], trial_[1], trial_[0], trial_[1], trial_[0], trial_[1]};
    return {};
  }
  gabion::AcceptReport accept_step(const gabion::StepRequest&, bool solved) override {
    if (solved) {
      accepted_[0] = trial_[0];
      accepted_[1] = trial_[1];
    }
    gabion::AcceptReport report;
    report.probes = probes();
    report.at_rest = true;  // it has no mass
    return report;
  }
  void reject_step() override {}
  void write_output(double) override {}
  gabion::Json summary() const override { return {{"stiffness", 1e4}}; }

 private:
  double accepted_[2] = {0, 0};
  double trial_[2] = {0, 0};
};

}  // namespace

int main(int argc, char** argv) {
  if (argc != 2) return 2;
  gabion::ParticipantSettings settings;
  settings.endpoint = argv[1];
  settings.name = "structure";
  settings.program = "spring";
  settings.dimension = 2;
  settings.receives = gabion::force();
  settings.sends = gabion::displacement();
  try {
    gabion::Connection connection(settings);
    Spring spring;
    gabion::serve(spring, connection);
  } catch (const gabion::Error& problem) {
    std::fprintf(stderr, "[spring] error: %s\n", problem.what());
    return problem.exit_code();
  }
  return 0;
}
