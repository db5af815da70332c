// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <functional>
#include <future>
#include <string>
#include <vector>

#include "protocol/participant/connection.hpp"
#include "protocol/serve.hpp"
#include "protocol/server/server.hpp"

namespace gabion::test {

/// Answers `factor` times what it receives plus its accepted value, which grows by dt a step.
class DummySolver : public Solver {
 public:
  DummySolver(std::int64_t num_vertices, int dim, double factor) : factor_(factor) {
    mesh_.name = "wall";
    mesh_.dim = dim;
    mesh_.coordinates.resize(static_cast<std::size_t>(num_vertices * dim));
    for (std::size_t i = 0; i < mesh_.coordinates.size(); ++i)
      mesh_.coordinates[i] = 0.1 * double(i);
    mesh_.vertices_per_facet = 2;
    for (std::int64_t i = 0; i + 1 < num_vertices; ++i) {
      mesh_.facets.insert(mesh_.facets.end(), {i, i + 1});
    }
  }

  std::vector<InterfaceMesh> interfaces() const override { return {mesh_}; }
  std::vector<std::string> probe_names() const override { return {"tip"}; }
  StepReport solve_step(const StepRequest& request, const InterfaceValues& received,
                        InterfaceValues& sent) override {
    if (on_solve) on_solve(request);
    std::vector<double> values(mesh_.coordinates.size(), accepted_);
    if (!received.empty()) {
      for (std::size_t i = 0; i < values.size(); ++i) values[i] += factor_ * received.at("wall")[i];
    }
    trial_ = accepted_ + request.dt;
    sent = {{"wall", values}};
    if (spoil) spoil(sent);
    StepReport report;
    report.newton_iterations = 3;
    report.linear_iterations = 70;
    report.interface_active = !received.empty();
    report.details = {{"energy", 0.1}};
    return report;
  }
  AcceptReport accept_step(const StepRequest&, bool solved) override {
    calls.push_back(solved ? "accept" : "skip");
    if (solved) accepted_ = trial_;
    return {{accepted_}, !solved, 0.25, {{"heat", 1.0 / 3}}};
  }
  void reject_step() override { calls.push_back("reject"); }
  void write_output(double time) override { calls.push_back("write " + std::to_string(time)); }
  std::vector<double> probes() const override { return {accepted_}; }
  Json summary() const override { return {{"linear_solver", "none"}}; }

  std::function<void(const StepRequest&)> on_solve;
  std::function<void(InterfaceValues&)> spoil;
  std::vector<std::string> calls;

 private:
  InterfaceMesh mesh_;
  double factor_;
  double accepted_ = 1;
  double trial_ = 1;
};

inline ParticipantSettings participant(const std::string& name, const std::string& endpoint) {
  ParticipantSettings settings;
  settings.endpoint = endpoint;
  settings.name = name;
  settings.program = name == "soil" ? "mpm_solver" : "fem_solver";
  settings.scene_hash = "abc";
  settings.dimension = 2;
  settings.receives = name == "soil" ? displacement() : force();
  settings.sends = name == "soil" ? force() : displacement();
  settings.connect_deadline = 50;
  settings.exit_when_coupler_is_lost = false;
  return settings;
}

inline Expected expected(const std::string& name) {
  Expected out;
  out.name = name;
  out.scene_hash = "abc";
  out.dimension = 2;
  out.interfaces = {"wall"};
  out.receives = name == "soil" ? displacement() : force();
  out.sends = name == "soil" ? force() : displacement();
  return out;
}

/// No deadline passes in a test, however loaded the machine is: what is noticed is noticed at once.
inline ServerSettings patient_settings() {
  ServerSettings settings;
  settings.deadlines.connect = 50;
  settings.deadlines.silence = 50;
  settings.deadlines.answer = 50;
  settings.deadlines.idle = 50;
  settings.deadlines.heartbeat = 0.1;
  return settings;
}

/// The text of the exception of type `Thrown` that `action` throws; empty when it throws none.
template <class Thrown, class Action>
std::string message_of(Action action) {
  try {
    action();
  } catch (const Thrown& problem) {
    return problem.what();
  }
  return "";
}

/// A participant in a thread; the future holds what serve() threw, as text.
inline std::future<std::string> serve_aside(DummySolver& solver,
                                            const ParticipantSettings& settings) {
  return std::async(std::launch::async, [&solver, settings] {
    return message_of<Error>([&] {
      Connection connection(settings);
      serve(solver, connection);
    });
  });
}

}  // namespace gabion::test
