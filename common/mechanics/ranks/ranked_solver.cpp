// SPDX-License-Identifier: BSD-3-Clause
#include "common/mechanics/ranks/ranked_solver.hpp"

#include <fmt/format.h>

#include <chrono>
#include <cstdint>
#include <thread>

#include "common/mechanics/ranks/ranked_state.hpp"
#include "common/mechanics/ranks/sum.hpp"

namespace gabion {

namespace {

// Kinds of failure in an order of severity: a step that may be repeated is the mildest one.
enum Failure : int { none = 0, convergence, other, protocol, config };

int failure_of(const std::exception& error) {
  if (dynamic_cast<const ConvergenceError*>(&error)) return convergence;
  if (dynamic_cast<const ConfigError*>(&error)) return config;
  if (dynamic_cast<const ProtocolError*>(&error)) return protocol;
  return other;
}

[[noreturn]] void throw_failure(int failure, const std::string& text) {
  switch (failure) {
    case convergence:
      throw ConvergenceError(text);
    case config:
      throw ConfigError(text);
    case protocol:
      throw ProtocolError(text);
    default:
      throw Error(text);
  }
}

/// Broadcast from rank 0 while the receivers sleep: a core that waits is free for another program.
void broadcast_asleep(MPI_Comm comm, void* data, int bytes) {
  constexpr int eager_tests = 100;
  constexpr auto nap = std::chrono::microseconds(50);
  MPI_Request request;
  MPI_Ibcast(data, bytes, MPI_BYTE, 0, comm, &request);
  int done = 0;
  for (int tests = 0; MPI_Test(&request, &done, MPI_STATUS_IGNORE), !done; ++tests) {
    if (tests >= eager_tests) std::this_thread::sleep_for(nap);
  }
}

void broadcast_bytes(MPI_Comm comm, std::vector<std::uint8_t>& bytes) {
  int size = static_cast<int>(bytes.size());
  broadcast_asleep(comm, &size, static_cast<int>(sizeof size));
  bytes.resize(size);
  broadcast_asleep(comm, bytes.data(), size);
}

Json request_json(const StepRequest& r) {
  return {r.step, r.iteration, r.time, r.dt};
}

StepRequest request_from(const Json& j) {
  return {j.at(0).get<std::int64_t>(), j.at(1).get<int>(), j.at(2).get<double>(),
          j.at(3).get<double>()};
}

}  // namespace

RankedSolver::RankedSolver(MPI_Comm comm, Solver& inner)
    : comm_(comm), size_(num_ranks(comm)), inner_(inner) {}

void RankedSolver::announce(Call call, const Json& arguments) const {
  if (size_ == 1) return;
  // CBOR keeps every bit of a double.
  auto bytes = Json::to_cbor(Json{static_cast<int>(call), arguments});
  broadcast_bytes(comm_, bytes);
}

/// Do the work, then agree on whether it failed: the worst failure is thrown on all ranks.
void RankedSolver::together(const std::function<void()>& work) const {
  if (size_ == 1) {
    work();
    return;
  }
  int failure = none;
  std::string text;
  try {
    work();
  } catch (const std::exception& error) {
    failure = failure_of(error);
    text = error.what();
  }
  struct {
    int failure, rank;
  } worst{failure, rank_of(comm_)};  // among equals the lowest rank speaks
  MPI_Allreduce(MPI_IN_PLACE, &worst, 1, MPI_2INT, MPI_MAXLOC, comm_);
  if (worst.failure == none) return;
  const int speaker = worst.rank;
  int size = static_cast<int>(text.size());
  MPI_Bcast(&size, 1, MPI_INT, speaker, comm_);
  text.resize(size);
  MPI_Bcast(text.data(), size, MPI_CHAR, speaker, comm_);
  if (worst.failure != convergence) followers_left_ = true;
  throw_failure(worst.failure, text);
}

std::vector<InterfaceMesh> RankedSolver::interfaces() const {
  return inner_.interfaces();
}

std::vector<std::string> RankedSolver::probe_names() const {
  return inner_.probe_names();
}

StepReport RankedSolver::solve_step(const StepRequest& request, const InterfaceValues& received,
                                    InterfaceValues& sent) {
  announce(Call::solve_step, {request_json(request), Json(received)});
  StepReport report;
  together([&] { report = inner_.solve_step(request, received, sent); });
  return report;
}

AcceptReport RankedSolver::accept_step(const StepRequest& request, bool solved) {
  announce(Call::accept_step, {request_json(request), solved});
  AcceptReport report;
  together([&] { report = inner_.accept_step(request, solved); });
  return report;
}

void RankedSolver::reject_step() {
  announce(Call::reject_step, {});
  together([&] { inner_.reject_step(); });
}

void RankedSolver::write_output(double time) {
  announce(Call::write_output, time);
  together([&] { inner_.write_output(time); });
}

std::vector<double> RankedSolver::probes() const {
  announce(Call::probes, {});
  std::vector<double> result;
  together([&] { result = inner_.probes(); });
  return result;
}

Json RankedSolver::summary() const {
  announce(Call::summary, {});
  Json result;
  together([&] { result = inner_.summary(); });
  return result;
}

State RankedSolver::save_state() {
  announce(Call::save_state, {});
  State all;
  together([&] { all = gather_state(comm_, inner_.save_state()); });
  return all;
}

void RankedSolver::load_state(const State& state) {
  announce(Call::load_state, {});
  together([&] { inner_.load_state(scatter_state(comm_, state)); });
}

void RankedSolver::stop(const std::string& error) {
  if (!followers_left_) announce(Call::stop, error);
  followers_left_ = true;
}

void RankedSolver::follow_call(Call call, const Json& arguments) {
  switch (call) {
    case Call::solve_step: {
      InterfaceValues sent;
      const auto received = arguments.at(1).get<InterfaceValues>();
      inner_.solve_step(request_from(arguments.at(0)), received, sent);
      break;
    }
    case Call::accept_step:
      inner_.accept_step(request_from(arguments.at(0)), arguments.at(1).get<bool>());
      break;
    case Call::reject_step:
      inner_.reject_step();
      break;
    case Call::write_output:
      inner_.write_output(arguments.get<double>());
      break;
    case Call::probes:
      inner_.probes();
      break;
    case Call::summary:
      inner_.summary();
      break;
    case Call::save_state:
      gather_state(comm_, inner_.save_state());
      break;
    case Call::load_state:
      inner_.load_state(scatter_state(comm_, {}));
      break;
    case Call::stop:
      break;
  }
}

void RankedSolver::follow() {
  while (true) {
    std::vector<std::uint8_t> bytes;
    broadcast_bytes(comm_, bytes);
    const Json message = Json::from_cbor(bytes);
    const auto call = static_cast<Call>(message.at(0).get<int>());
    const Json& arguments = message.at(1);
    if (call == Call::stop) {
      const auto error = arguments.get<std::string>();
      if (!error.empty()) throw ProtocolError("rank 0 failed: " + error);
      return;
    }
    try {
      together([&] { follow_call(call, arguments); });
    } catch (const ConvergenceError&) {
      // Rank 0 reports it to its caller, who rejects the step.
    }
  }
}

void drive_ranks(MPI_Comm comm, Solver& solver, const std::function<void(Solver&)>& drive) {
  RankedSolver ranked(comm, solver);
  if (rank_of(comm) != 0) {
    ranked.follow();
    return;
  }
  try {
    drive(ranked);
  } catch (const std::exception& error) {
    ranked.stop(error.what());
    throw;
  }
  ranked.stop();
}

}  // namespace gabion
