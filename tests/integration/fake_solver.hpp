// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <unistd.h>

#include <chrono>
#include <csignal>
#include <cstdio>
#include <ctime>
#include <string>
#include <thread>

#include "common/run/solver.hpp"

namespace gabion::test {

/// Misdeed of a participant, and when it happens. Steps are numbered from 1; phases: handshake
///   connected, before the hello before_solve step 2 is accepted, step 3 is awaited inside_solve in
///   the first solution of step 3 after_solve that solution is sent output while the state after
///   step 4 is written
struct Misdeed {
  std::string kind = "none";  ///< killed, stopped, slow, announced, or one of a liar
  std::string phase;
  double seconds = 0;  ///< of "slow"
};

inline void sleep_for(double seconds) {
  std::this_thread::sleep_for(std::chrono::duration<double>(seconds));
}

/// Says on the system's monotonic clock when it happened.
inline void note_strike() {
  timespec now{};
  clock_gettime(CLOCK_MONOTONIC, &now);
  std::printf("strike %.6f\n",
              static_cast<double>(now.tv_sec) + 1e-9 * static_cast<double>(now.tv_nsec));
  std::fflush(stdout);
}

inline void strike(const Misdeed& misdeed) {
  note_strike();
  if (misdeed.kind == "killed") kill(getpid(), SIGKILL);
  if (misdeed.kind == "stopped") kill(getpid(), SIGSTOP);
  if (misdeed.kind == "slow") sleep_for(misdeed.seconds);
}

/// Spring (structure) or load (soil) on the four corners of a wall of 0.01 m x 0.05 m. The load
/// grows with the third power of time, so that no predictor is right and every step iterates.
class FakeSolver : public Solver {
 public:
  /// @param pause  [s] that accepting step 2 and solving step 3 take, so that the other one's
  ///               misdeed before or after its solution finds this one at work
  FakeSolver(bool is_soil, Misdeed misdeed, double pause)
      : is_soil_(is_soil), misdeed_(std::move(misdeed)), pause_(pause) {}

  std::vector<InterfaceMesh> interfaces() const override {
    return {{"wall", 2, {0.26, 0, 0.26, 0.05, 0.25, 0.05, 0.25, 0}, 2, {0, 1, 1, 2, 2, 3}}};
  }
  std::vector<std::string> probe_names() const override { return {"tip"}; }

  StepReport solve_step(const StepRequest& request, const InterfaceValues& received,
                        InterfaceValues& sent) override {
    const bool now = request.step == 3 && request.iteration == 0;
    if (now) at("inside_solve");
    if (request.step == 3) sleep_for(pause_);
    sent["wall"] = answer(request.time + request.dt, received);
    if (now) soon_after("after_solve");
    return {.newton_iterations = 1, .linear_iterations = 1};
  }

  std::vector<double> answer(double time, const InterfaceValues& received) const {
    std::vector<double> values(8, is_soil_ ? 1e4 * time * time * time : 0.0);
    if (received.empty()) return values;
    for (std::size_t i = 0; i < 8; ++i)
      values[i] += (is_soil_ ? -100 : 1e-3) * received.at("wall")[i];
    return values;
  }

  AcceptReport accept_step(const StepRequest& request, bool) override {
    if (request.step == 2) {
      sleep_for(pause_);
      misdeed_.kind == "slow" || misdeed_.kind == "announced" ? at("before_solve")
                                                              : soon_after("before_solve");
    }
    if (request.step == 3 && misdeed_.kind == "slow") at("after_solve");
    return {.probes = {0.5}};
  }
  void reject_step() override {}
  void write_output(double time) override {
    if (time <= 0.03 || time >= 0.045) return;
    at("output");
    if (misdeed_.kind == "announced") sleep_for(pause_);  // for the coupler to be struck here
  }
  std::vector<double> probes() const override { return {0}; }
  Json summary() const override { return Json::object(); }

  void at(const std::string& phase) const {
    if (phase == misdeed_.phase) strike(misdeed_);
  }

 private:
  /// Misbehave soon after the answer of this phase is sent.
  void soon_after(const std::string& phase) const {
    if (phase != misdeed_.phase || misdeed_.kind == "slow") return;
    std::thread([misdeed = misdeed_] {
      sleep_for(0.15);
      strike(misdeed);
    }).detach();
  }

  bool is_soil_;
  Misdeed misdeed_;
  double pause_;
};

}  // namespace gabion::test
