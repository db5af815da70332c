// SPDX-License-Identifier: BSD-3-Clause
#include "fem_solver/report/structure_report.hpp"

#include <algorithm>

namespace gabion::fem {

template <int dim>
StructureReport<dim>::StructureReport(const FemSettings<dim>& settings,
                                      const StructureStep<dim>& step,
                                      const std::string& output_folder)
    : settings_(settings), step_(step), probes_(settings), membranes_(settings, output_folder) {
  const SharedNodes& shared = settings.ranks.shared();
  const auto own = std::ranges::count_if(step.conditions().constrained_dofs(),
                                         [&](auto dof) { return shared.owns(dof / dim); });
  num_constrained_ = static_cast<std::int64_t>(shared.total(static_cast<double>(own)));
  names_ = probes_.names();
  const auto of_membranes = membranes_.probe_names();
  names_.insert(names_.end(), of_membranes.begin(), of_membranes.end());
  for (const auto& section : settings.sections) {
    sections_.emplace_back(settings, section, step.equilibrium().cells());
    const auto names = sections_.back().names();
    names_.insert(names_.end(), names.begin(), names.end());
  }
  if (output_folder.empty()) return;
  output_.emplace(settings, output_folder);
  if (!settings.line_materials.empty()) line_output_.emplace(settings, output_folder);
}

template <int dim>
std::vector<double> StructureReport<dim>::probes(const StructureState& state) const {
  std::vector<double> values = probes_.values(state, step_.equilibrium());
  const auto of_membranes = membranes_.probes(state, step_.equilibrium());
  values.insert(values.end(), of_membranes.begin(), of_membranes.end());
  for (const auto& section : sections_) {
    const auto own = section.values(state, step_.equilibrium().cells());
    values.insert(values.end(), own.begin(), own.end());
  }
  return values;
}

template <int dim>
void StructureReport<dim>::write_frame(double time, const StructureState& state) {
  if (output_) output_->write(time, state, step_.equilibrium());
  if (line_output_) line_output_->write(time, state, step_.equilibrium());
  membranes_.write(time, state, step_.equilibrium());
}

template <int dim>
Json StructureReport<dim>::summary() const {
  const Mesh<dim>& mesh = settings_.mesh;
  const MeshRanks& ranks = settings_.ranks;
  const std::int64_t num_nodes = ranks.num_nodes_of_all(mesh);
  Json result = step_.summary();
  result["nodes"] = ranks.alone() ? settings_.num_places() : num_nodes;
  result["unknowns"] = num_nodes * dim - num_constrained_;
  result["frame_bytes"] = FemOutput<dim>::frame_bytes(settings_) +
                          LineOutput<dim>::frame_bytes(settings_) +
                          MembraneOutput<dim>::frame_bytes(settings_);
  result["cells"] = ranks.num_cells_of_all(mesh);
  result["cell_type"] = name(mesh.cell_type);
  if (settings_.materials.size() == 1 && settings_.line_materials.empty() &&
      settings_.membranes.empty()) {
    result["material"] = settings_.materials.front().law_name;
  } else {
    for (const auto& material : settings_.materials) {
      result["materials"][material.group] = material.law_name;
    }
    for (const auto& material : settings_.line_materials) {
      result["materials"][material.group] = material.law_name;
    }
    for (const auto& material : settings_.membranes) {
      result["materials"][material.group] = "membrane";
    }
  }
  if (!settings_.line_materials.empty()) result["lines"] = ranks.num_lines_of_all(mesh);
  if (!settings_.membranes.empty()) result["membrane_cells"] = mesh.num_sheets();
  result["analysis"] = settings_.dynamic ? "dynamic" : "static";
  return result;
}

template class StructureReport<2>;
template class StructureReport<3>;

}  // namespace gabion::fem
