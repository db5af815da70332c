// SPDX-License-Identifier: BSD-3-Clause
#include "fem_solver/matrices/matrix_report.hpp"

#include <fmt/format.h>

#include <cmath>
#include <numbers>

#include "fem_solver/supports/boundary_conditions.hpp"

namespace gabion::fem {

namespace {

std::vector<OutputField> frame_fields(int dim, std::span<const double> u, std::span<const double> v,
                                      std::span<const double> f) {
  return {{.name = "displacement", .components = dim, .values = u},
          {.name = "velocity", .components = dim, .values = v},
          {.name = "external_force", .components = dim, .values = f}};
}

}  // namespace

template <int dim>
MatrixReport<dim>::MatrixReport(const MatrixSettings<dim>& settings,
                                const MatrixStructure<dim>& structure,
                                const Coordinates& coordinates, std::string folder)
    : structure_(structure),
      coordinates_(coordinates),
      dynamic_(settings.dynamic),
      folder_(std::move(folder)) {
  for (const auto& probe : settings.probes) {
    probe_nodes_.push_back(node_at(structure.mesh, {}, probe.point, probe.where));
    for (int c = 0; c < dim; ++c) {
      names_.push_back(fmt::format("{}.u{}", probe.name, component_names[c]));
    }
  }
  names_.insert(names_.end(), {"kinetic_energy", "elastic_energy", "external_work"});
  if (coordinates.model().damped()) names_.push_back("damping_work");

  const Mesh<dim>& mesh = structure.mesh;
  cells_ = mesh.cells;
  cell_type_ = mesh.cell_type;
  if (!cells_.empty()) return;
  cell_type_ = mesh.facet_groups.empty() ? CellType::point1 : facet_type(mesh.cell_type);
  for (const auto& [file, facets] : mesh.facet_groups) {
    cells_.insert(cells_.end(), facets.begin(), facets.end());
  }
}

template <int dim>
std::vector<double> MatrixReport<dim>::probes(const LinearState& state,
                                              const LinearStep& step) const {
  std::vector<double> values;
  for (const auto node : probe_nodes_) {
    for (int c = 0; c < dim; ++c) {
      const int unknown = structure_.unknown_of[static_cast<std::size_t>(node) * dim + c];
      values.push_back(unknown < 0 ? 0.0 : coordinates_.unknown(state.u, unknown));
    }
  }
  values.insert(values.end(),
                {step.kinetic_energy(state), step.elastic_energy(state), state.external_work});
  if (coordinates_.model().damped()) values.push_back(state.damping_work);
  return values;
}

template <int dim>
std::vector<double> MatrixReport<dim>::on_nodes(const Eigen::VectorXd& q) const {
  const Eigen::VectorXd all = coordinates_.unknowns(q);
  std::vector<double> values(structure_.unknown_of.size(), 0.0);
  for (std::size_t i = 0; i < values.size(); ++i) {
    if (structure_.unknown_of[i] >= 0) values[i] = all[structure_.unknown_of[i]];
  }
  return values;
}

template <int dim>
void MatrixReport<dim>::write_frame(const LinearState& state, const std::vector<double>& f) {
  if (folder_.empty()) return;
  if (!series_) series_.emplace(folder_, "structure");
  const std::vector<double> u = on_nodes(state.u), v = on_nodes(state.v);
  std::vector<double> x = u;
  for (std::size_t i = 0; i < x.size(); ++i) x[i] += structure_.mesh.nodes[i / dim][i % dim];
  series_->write({.time = state.time,
                  .dim = dim,
                  .coordinates = x,
                  .cell_type = cell_type_,
                  .connectivity = cells_,
                  .fields = frame_fields(dim, u, v, f)});
}

template <int dim>
Json MatrixReport<dim>::summary(const LinearStep& step) const {
  const Mesh<dim>& mesh = structure_.mesh;
  Json wall = Json::object();
  for (const auto& [phase, seconds] : step.times().seconds()) wall[phase] = seconds;
  Json result = {{"linear_solver", "ldlt"},
                 {"solves", step.solves()},
                 {"skipped_solves", step.skipped()},
                 {"factorisations", step.factorisations()},
                 {"nodes", mesh.nodes.size()},
                 {"unknowns", coordinates_.full().size()},
                 {"coordinates", coordinates_.model().size()},
                 {"modes", coordinates_.omega2().size()},
                 {"material", "matrices"},
                 {"analysis", dynamic_ ? "dynamic" : "static"},
                 {"wall_seconds", wall}};
  const auto num_cells = static_cast<std::int64_t>(
      cell_type_ == CellType::point1 ? mesh.nodes.size() : cells_.size() / num_nodes(cell_type_));
  result["frame_bytes"] = XdmfSeries::frame_bytes(mesh.num_nodes_total(), cell_type_, num_cells,
                                                  frame_fields(dim, {}, {}, {}));
  if (const Eigen::VectorXd omega2 = coordinates_.omega2(); omega2.size() > 0) {
    const double highest = omega2[omega2.size() - 1];
    result["highest_mode_hertz"] = std::sqrt(highest) / (2 * std::numbers::pi);
  }
  return result;
}

template class MatrixReport<2>;
template class MatrixReport<3>;

}  // namespace gabion::fem
