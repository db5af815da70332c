// SPDX-License-Identifier: BSD-3-Clause
#include "mpm_solver/run_mpm.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <utility>

#include "common/base/cores.hpp"
#include "common/settings/describe_keys.hpp"
#include "mpm_solver/checks/varying_values.hpp"
#include "mpm_solver/mpm_config.hpp"
#include "mpm_solver/mpm_solver.hpp"
#include "mpm_solver/placed_soil.hpp"
#include "mpm_solver/ranks/rank_advice.hpp"

namespace gabion {

namespace {

template <int dim>
std::unique_ptr<Solver> make_solver(const Scene& scene, ConfigReader& in, MPI_Comm comm,
                                    const std::string& output_folder, AloneSettings* alone) {
  return std::make_unique<mpm::MpmSolver<dim>>(comm, mpm::read_mpm_settings<dim>(scene, in, alone),
                                               output_folder);
}

// Make the solver; interfaces of a coupled soil may begin displaced.
template <int dim>
std::unique_ptr<Solver> make_placed(const Scene& scene, ConfigReader& in, MPI_Comm comm,
                                    const std::string& output_folder) {
  return std::make_unique<mpm::PlacedSoil<dim>>(
      comm, mpm::read_mpm_settings<dim>(scene, in, nullptr), output_folder);
}

std::unique_ptr<Solver> make_soil(const Scene& scene, ConfigReader& in, MPI_Comm comm,
                                  const std::string& output_folder, AloneSettings* alone) {
  if (alone != nullptr) return make_mpm_solver(scene, in, comm, output_folder, alone);
  return in.integer("dimension") == 2 ? make_placed<2>(scene, in, comm, output_folder)
                                      : make_placed<3>(scene, in, comm, output_folder);
}

template <int dim>
mpm::RankAdvice advice_of(const Scene& scene, ConfigReader& in, AloneSettings* alone, int cores) {
  return mpm::advise_ranks(mpm::read_mpm_settings<dim>(scene, in, alone), cores);
}

// Reduce the advice to idle cores: ranks wait for each other, and two ranks of which one shares its
// core with another process are slower than one.
mpm::RankAdvice on_idle_cores(mpm::RankAdvice advice) {
  constexpr double measured_seconds = 0.3, used_by_the_system = 0.25;
  if (advice.ranks == 1) return advice;
  const auto idle = idle_cores(measured_seconds);
  if (!idle) return {1, advice.reason + ", whose load the system does not tell"};
  if (*idle + used_by_the_system >= advice.ranks) return advice;
  advice.ranks = std::max(1, static_cast<int>(*idle + used_by_the_system));
  advice.reason += fmt::format(", {:.1f} of which are idle", *idle);
  return advice;
}

void print_rank_advice(const ProgramOptions& options) {
  const Scene scene(options.scene, options.overrides);
  ConfigReader in = scene.reader("mpm.json", mpm::mpm_keys());
  const bool is_alone = !scene.has("coupler.json") && options.coupler.empty();
  AloneSettings settings, *alone = is_alone ? &settings : nullptr;
  const bool is_here = options.advise_ranks == 0;
  const int cores = is_here ? usable_cores() : options.advise_ranks;
  mpm::RankAdvice advice = in.integer("dimension") == 2 ? advice_of<2>(scene, in, alone, cores)
                                                        : advice_of<3>(scene, in, alone, cores);
  if (is_here) advice = on_idle_cores(std::move(advice));
  fmt::print("{}{}{}{}", advice.ranks, '\0', advice.reason, '\0');
}

template <int dim>
void write_varying_of(const Scene& scene, ConfigReader& in, const ProgramOptions& options) {
  AloneSettings alone;
  const bool is_alone = !scene.has("coupler.json") && options.coupler.empty();
  const auto settings = mpm::read_mpm_settings<dim>(scene, in, is_alone ? &alone : nullptr);
  mpm::write_varying(options.write_varying, settings);
}

void write_varying_table(const ProgramOptions& options) {
  const Scene scene(options.scene, options.overrides);
  ConfigReader in = scene.reader("mpm.json", mpm::mpm_keys());
  in.integer("dimension") == 2 ? write_varying_of<2>(scene, in, options)
                               : write_varying_of<3>(scene, in, options);
}

}  // namespace

std::unique_ptr<Solver> make_mpm_solver(const Scene& scene, ConfigReader& in, MPI_Comm comm,
                                        const std::string& output_folder, AloneSettings* alone) {
  return in.integer("dimension") == 2 ? make_solver<2>(scene, in, comm, output_folder, alone)
                                      : make_solver<3>(scene, in, comm, output_folder, alone);
}

void describe_mpm_keys(const std::string& form) {
  describe_keys(mpm::mpm_keys(), "mpm.json", form);
}

void run_mpm(const ProgramOptions& options, const MpiSession& session) {
  if (options.advise_ranks >= 0) {
    if (session.is_root()) print_rank_advice(options);
    return;
  }
  if (!options.write_varying.empty()) {
    if (session.is_root()) write_varying_table(options);
    return;
  }
  run_solver_program({"mpm_solver", mpm::mpm_keys(), make_soil}, options, session);
}

}  // namespace gabion
