// SPDX-License-Identifier: BSD-3-Clause
#include "fem_solver/report/membrane_output.hpp"

#include <algorithm>
#include <limits>
#include <utility>

namespace gabion::fem {

namespace {

using Values = std::vector<double>;

template <int dim>
std::vector<std::int32_t> nodes_of_sheets(const Mesh<dim>& mesh) {
  std::vector<std::int32_t> nodes = mesh.sheets;
  std::ranges::sort(nodes);
  nodes.erase(std::unique(nodes.begin(), nodes.end()), nodes.end());
  return nodes;
}

template <int dim>
std::vector<OutputField> fields_of(const FemSettings<dim>& settings) {
  std::vector<OutputField> fields = {
      {.name = "displacement", .components = dim},
      {.name = "velocity", .components = dim},
      {.name = "membrane_force", .components = symmetric_size<dim>, .on_cells = true},
      {.name = "tension_1", .on_cells = true},
      {.name = "tension_2", .on_cells = true},
      {.name = "strain", .on_cells = true}};
  if (std::ranges::any_of(settings.membranes, &MembraneMaterial::tension_only)) {
    fields.push_back({.name = "wrinkled", .on_cells = true});
  }
  return fields;
}

/// Values of the cells in the order of the fields behind the first two.
std::vector<Values> cell_values(std::span<const MembraneBlock> blocks, std::span<const double> u) {
  std::vector<Values> all(5);
  for (const MembraneBlock& block : blocks) {
    for (const auto& own : block.values(u)) {
      all[0].insert(all[0].end(), own.force.begin(), own.force.end());
      all[1].push_back(own.principal[0]);
      all[2].push_back(own.principal[1]);
      all[3].push_back(own.strain);
      all[4].push_back(static_cast<double>(own.state));
    }
  }
  return all;
}

}  // namespace

template <int dim>
MembraneOutput<dim>::MembraneOutput(const FemSettings<dim>& settings, const std::string& folder)
    : settings_(settings),
      nodes_(nodes_of_sheets(settings.mesh)),
      writes_(!folder.empty() && !settings.membranes.empty()),
      series_(folder, "membranes") {}

template <int dim>
std::vector<std::string> MembraneOutput<dim>::probe_names() const {
  std::vector<std::string> names;
  for (const MembraneMaterial& material : settings_.membranes) {
    for (const char* what : {"tension_max_", "tension_min_", "strain_max_"}) {
      names.push_back(what + material.group);
    }
  }
  return names;
}

template <int dim>
Values MembraneOutput<dim>::probes(const StructureState& state,
                                   const Equilibrium<dim>& equilibrium) {
  constexpr double none = std::numeric_limits<double>::infinity();
  Values probes;
  for (const MembraneBlock& block : equilibrium.cells().membranes().blocks()) {
    double largest = -none, least = none, strain = -none;
    for (const auto& own : block.values(state.motion.u)) {
      largest = std::max(largest, own.principal[0]);
      least = std::min(least, own.principal[1]);
      strain = std::max(strain, own.strain);
    }
    probes.insert(probes.end(), {largest, least, strain});
  }
  return probes;
}

template <int dim>
std::int64_t MembraneOutput<dim>::frame_bytes(const FemSettings<dim>& settings) {
  const Mesh<dim>& mesh = settings.mesh;
  if (settings.membranes.empty()) return 0;
  const auto num_nodes = static_cast<std::int64_t>(nodes_of_sheets(mesh).size());
  return XdmfSeries::frame_bytes(num_nodes, facet_type(mesh.cell_type), mesh.num_sheets(),
                                 fields_of(settings));
}

template <int dim>
void MembraneOutput<dim>::write(double time, const StructureState& state,
                                const Equilibrium<dim>& equilibrium) {
  if (!writes_) return;
  const Mesh<dim>& mesh = settings_.mesh;
  Values x, u, v;
  for (const std::int32_t i : nodes_) {
    for (int c = 0; c < dim; ++c) {
      const std::size_t dof = static_cast<std::size_t>(i) * dim + static_cast<std::size_t>(c);
      x.push_back(mesh.nodes[static_cast<std::size_t>(i)][c] + state.motion.u[dof]);
      u.push_back(state.motion.u[dof]);
      v.push_back(state.motion.v[dof]);
    }
  }
  std::vector<std::int32_t> corners;
  for (const std::int32_t i : mesh.sheets) {
    corners.push_back(
        static_cast<std::int32_t>(std::ranges::lower_bound(nodes_, i) - nodes_.begin()));
  }
  const auto values = cell_values(equilibrium.cells().membranes().blocks(), state.motion.u);
  auto fields = fields_of(settings_);
  fields[0].values = u;
  fields[1].values = v;
  for (std::size_t k = 2; k < fields.size(); ++k) fields[k].values = values[k - 2];
  series_.write({.time = time,
                 .dim = dim,
                 .coordinates = x,
                 .cell_type = facet_type(mesh.cell_type),
                 .connectivity = corners,
                 .fields = std::move(fields)});
}

template class MembraneOutput<2>;
template class MembraneOutput<3>;

}  // namespace gabion::fem
