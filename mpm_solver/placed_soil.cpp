// SPDX-License-Identifier: BSD-3-Clause
#include "mpm_solver/placed_soil.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <utility>

#include "common/base/log.hpp"
#include "common/base/require.hpp"

namespace gabion::mpm {

namespace {

bool is_zero(const InterfaceValues& values) {
  return std::ranges::all_of(values, [](const auto& entry) {
    return std::ranges::all_of(entry.second, [](double value) { return value == 0; });
  });
}

}  // namespace

template <int dim>
PlacedSoil<dim>::PlacedSoil(MPI_Comm comm, MpmSettings<dim> settings, std::string output_folder)
    : comm_(comm), settings_(std::move(settings)), output_folder_(std::move(output_folder)) {
  for (const auto& own : settings_->interfaces) meshes_.push_back(interface_mesh(own));
  begin_at_reference();
}

template <int dim>
void PlacedSoil<dim>::begin_at_reference() {
  problem_.clear();
  try {
    soil_ = std::make_unique<MpmSolver<dim>>(comm_, *settings_, output_folder_);
    return;
  } catch (const ConfigError& problem) {
    if (meshes_.empty()) throw;
    problem_ = problem.what();
  }
  // Without interfaces and stress the soil has equal probes; where it cannot begin so either, the
  // interfaces are not the cause.
  MpmSettings<dim> bare = *settings_;
  bare.interfaces.clear();
  for (auto& stress : bare.initial_stress) stress.reset();
  soil_ = std::make_unique<MpmSolver<dim>>(comm_, std::move(bare), "");
}

template <int dim>
MpmSolver<dim>& PlacedSoil<dim>::begun() const {
  if (!problem_.empty()) throw ConfigError(problem_);
  return *soil_;
}

template <int dim>
std::string PlacedSoil<dim>::text_of(const InterfaceValues& start) const {
  std::string text;
  for (const auto& [name, u] : start) {
    double largest = 0;
    for (std::size_t k = 0; k < u.size(); k += dim) {
      largest = std::max(largest, Eigen::Map<const Vector<dim>>(u.data() + k).norm());
    }
    text += fmt::format("{}\"{}\" by up to {:.3g} m", text.empty() ? "" : ", ", name, largest);
  }
  return text;
}

template <int dim>
void PlacedSoil<dim>::place(InterfaceValues start) {
  if (is_zero(start)) start.clear();
  if (start == start_) {
    begun();
    return;
  }
  require(settings_.has_value(),
          "mpm_solver: found interfaces that start elsewhere ({}) than those of the steps before, "
          "allowed: before the first step",
          start.empty() ? "at their reference places" : text_of(start));
  MpmSettings<dim> placed = *settings_;
  for (ContactSettings<dim>& interface : placed.interfaces) {
    if (start.empty()) break;  // at X
    const auto found = start.find(interface.name);
    auto& vertices = interface.surface.vertices;
    require(found != start.end() && found->second.size() == vertices.size() * dim,
            "mpm_solver: found {} displacements of the start of \"{}\", allowed: {} vertices x {}",
            found == start.end() ? 0 : found->second.size(), interface.name, vertices.size(), dim);
    const double* u = found->second.data();
    for (std::size_t v = 0; v < vertices.size(); ++v) {
      vertices[v] += Eigen::Map<const Vector<dim>>(u + v * dim);
    }
  }
  start_ = std::move(start);
  soil_.reset();
  if (start_.empty()) {
    begin_at_reference();
    begun();
    return;
  }
  log::info("set up again with interfaces displaced: {}", text_of(start_));
  problem_.clear();
  try {
    soil_ = std::make_unique<MpmSolver<dim>>(comm_, std::move(placed), output_folder_);
  } catch (const ConfigError& problem) {
    throw ConfigError(fmt::format(
        "{}; interfaces are where the structure starts, which is displaced from their place in "
        "mpm.json: {}",
        problem.what(), text_of(start_)));
  }
}

template <int dim>
void PlacedSoil<dim>::set_start(const InterfaceValues& displacements) {
  place(displacements);
}

template <int dim>
StepReport PlacedSoil<dim>::solve_step(const StepRequest& request, const InterfaceValues& received,
                                       InterfaceValues& sent) {
  begun();
  settings_.reset();
  if (start_.empty() || received.empty()) return soil_->solve_step(request, received, sent);
  InterfaceValues moved = received;
  for (auto& [name, u] : moved) {
    const std::vector<double>& start = start_.at(name);
    for (std::size_t k = 0; k < start.size(); ++k) u[k] -= start[k];
  }
  return soil_->solve_step(request, moved, sent);
}

template <int dim>
State PlacedSoil<dim>::save_state() {
  State state = begun().save_state();
  for (const auto& [name, u] : start_) state.reals["start." + name] = u;
  return state;
}

template <int dim>
void PlacedSoil<dim>::place_as(const State& state) {
  InterfaceValues start;
  for (const InterfaceMesh& mesh : meshes_) {
    const auto found = state.reals.find("start." + mesh.name);
    if (found != state.reals.end()) start[mesh.name] = found->second;
  }
  place(std::move(start));
}

template <int dim>
void PlacedSoil<dim>::load_state(const State& state) {
  place_as(state);
  soil_->load_state(state);
}

template <int dim>
void PlacedSoil<dim>::join_states(const State& first, std::span<const State> own) {
  place_as(first);
  soil_->join_states(first, own);
}

template class PlacedSoil<2>;
template class PlacedSoil<3>;

}  // namespace gabion::mpm
