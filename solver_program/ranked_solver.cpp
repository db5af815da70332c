// SPDX-License-Identifier: BSD-3-Clause
#include "solver_program/ranked_solver.hpp"

#include <sys/resource.h>

#include <ctime>
#include <filesystem>
#include <system_error>

#include "common/base/log.hpp"
#include "common/mechanics/ranks/sum.hpp"
#include "common/mechanics/ranks/text.hpp"
#include "solver_program/ranked_state.hpp"
#include "solver_program/ranked_state_file.hpp"

namespace gabion {

namespace {

// Kinds of failure in an order of severity: a step that may be repeated is the mildest one.
enum Failure : int { none = 0, convergence, other, protocol, config };

Failure failure_of(const std::exception& error) {
  if (dynamic_cast<const ConvergenceError*>(&error)) return convergence;
  if (dynamic_cast<const ConfigError*>(&error)) return config;
  if (dynamic_cast<const ProtocolError*>(&error)) return protocol;
  return other;
}

[[noreturn]] void throw_failure(Failure failure, const std::string& text,
                                const std::string& cause) {
  switch (failure) {
    case convergence:
      throw ConvergenceError(text, cause);
    case config:
      throw ConfigError(text);
    case protocol:
      throw ProtocolError(text);
    default:
      throw Error(text);
  }
}

/// The most memory that this process has had [bytes].
std::int64_t peak_memory() {
  rusage usage{};
  getrusage(RUSAGE_SELF, &usage);
  return std::int64_t{1024} * usage.ru_maxrss;
}

/// CPU time of this process so far [s].
double cpu_seconds() {
  return static_cast<double>(std::clock()) / CLOCKS_PER_SEC;
}

}  // namespace

RankedSolver::RankedSolver(MPI_Comm comm, Solver& inner)
    : comm_(comm), size_(num_ranks(comm)), inner_(inner) {}

/// Do the work, then agree on whether it failed: the worst failure is thrown on all ranks, among
/// equals that of the lowest one.
void RankedSolver::together(const std::function<void()>& work) const {
  if (size_ == 1) {
    work();
    return;
  }
  Failure failure = none;
  std::string text, cause;
  try {
    work();
  } catch (const std::exception& error) {
    failure = failure_of(error);
    text = error.what();
    if (failure == convergence) cause = dynamic_cast<const ConvergenceError&>(error).cause();
  }
  const auto worst = static_cast<Failure>(max_over_ranks(comm_, failure));
  if (worst == none) return;
  if (failure != worst) text = cause = "";
  throw_failure(worst, first_text(comm_, text), first_text(comm_, cause));
}

void RankedSolver::step_together(const std::function<void()>& work) {
  const auto before = mpi_traffic();
  together(work);
  if (before) traffic_ += *mpi_traffic() - *before;
}

void RankedSolver::output_together(const std::function<void()>& work) {
  const double before = cpu_seconds();
  together(work);
  output_seconds_ += cpu_seconds() - before;
}

/// Largest and sum of a number of each rank.
template <class Number>
Json RankedSolver::over_ranks(Number own) const {
  auto sum = static_cast<double>(own);
  const double largest = max_over_ranks(comm_, sum);
  sum_over_ranks(comm_, std::span<double>(&sum, 1));
  return {{"largest_rank", static_cast<Number>(largest)}, {"all_ranks", static_cast<Number>(sum)}};
}

void RankedSolver::set_force_kinds(const ForceKinds& kinds) {
  together([&] { inner_.set_force_kinds(kinds); });
}

InterfaceValues RankedSolver::start_displacements() const {
  InterfaceValues start;
  together([&] { start = gabion::start_displacements(inner_); });
  return start;
}

void RankedSolver::set_start(const InterfaceValues& displacements) {
  together([&] { gabion::set_start(inner_, displacements); });
}

void RankedSolver::set_facets(const InterfaceFacets& facets) {
  together([&] { gabion::set_facets(inner_, facets); });
}

StepReport RankedSolver::solve_step(const StepRequest& request, const InterfaceValues& received,
                                    InterfaceValues& sent) {
  StepReport report;
  step_together([&] { report = inner_.solve_step(request, received, sent); });
  return report;
}

AcceptReport RankedSolver::accept_step(const StepRequest& request, bool solved) {
  AcceptReport report;
  step_together([&] { report = inner_.accept_step(request, solved); });
  return report;
}

void RankedSolver::reject_step() {
  together([&] { inner_.reject_step(); });
}

void RankedSolver::write_output(double time) {
  output_together([&] { inner_.write_output(time); });
}

std::vector<double> RankedSolver::probes() const {
  std::vector<double> result;
  together([&] { result = inner_.probes(); });
  return result;
}

Json RankedSolver::summary() const {
  Json result;
  together([&] { result = inner_.summary(); });
  result["peak_memory"] = over_ranks(peak_memory());
  result["cpu_seconds"] = over_ranks(cpu_seconds());
  result["output_cpu_seconds"] = over_ranks(output_seconds_);
  if (size_ > 1 && mpi_traffic()) {
    result["mpi"] = {{"messages", over_ranks(traffic_.messages)},
                     {"message_bytes", over_ranks(traffic_.message_bytes)},
                     {"collectives", over_ranks(traffic_.collectives)},
                     {"collective_bytes", over_ranks(traffic_.collective_bytes)},
                     {"waiting_seconds", over_ranks(traffic_.waiting_seconds)}};
  }
  return result;
}

State RankedSolver::save_state() {
  State all;
  output_together([&] { all = gather_state(comm_, inner_.save_state()); });
  return all;
}

State RankedSolver::save_state_to(const std::string& path) {
  const std::filesystem::path folder = std::filesystem::path(path).parent_path();
  if (size_ > 1) MPI_Barrier(comm_);  // the first rank may have just made it
  std::error_code unseen;
  const bool seen = std::filesystem::is_directory(folder, unseen);
  const bool seen_by_all = max_over_ranks(comm_, seen ? 0.0 : 1.0) == 0;
  if (!seen_by_all) {
    log::warn("checkpoint: {} is not seen by all ranks; its first rank sends the state of all",
              folder.string());
    return save_state();
  }
  State all;
  output_together([&] { write_ranked_state(comm_, path, inner_.save_state()); });
  all.file = path;
  return all;
}

void RankedSolver::load_state(const State& state) {
  together([&] {
    if (state.file.empty()) {
      load_gathered(comm_, state, inner_);
    } else {
      load_ranked_state(comm_, state.file, inner_);
    }
  });
}

}  // namespace gabion
