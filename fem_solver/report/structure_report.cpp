// SPDX-License-Identifier: BSD-3-Clause
#include "fem_solver/report/structure_report.hpp"

namespace gabion::fem {

template <int dim>
StructureReport<dim>::StructureReport(const FemSettings<dim>& settings,
                                      const StructureStep<dim>& step,
                                      const std::string& output_folder)
    : settings_(settings), step_(step), probes_(settings) {
  if (output_folder.empty()) return;
  output_.emplace(settings.mesh, output_folder, step.equilibrium().comm());
}

template <int dim>
std::vector<double> StructureReport<dim>::probes(const StructureState& state) const {
  return probes_.values(state, step_.equilibrium());
}

template <int dim>
void StructureReport<dim>::write_frame(double time, const StructureState& state) {
  if (output_) output_->write(time, state, step_.equilibrium());
}

template <int dim>
Json StructureReport<dim>::summary() const {
  const Mesh<dim>& mesh = settings_.mesh;
  Json result = step_.summary();
  result["nodes"] = mesh.nodes.size();
  result["unknowns"] = mesh.nodes.size() * dim - step_.conditions().constrained_dofs().size();
  result["frame_bytes"] = FemOutput<dim>::frame_bytes(mesh);
  result["cells"] = mesh.num_cells();
  result["cell_type"] = name(mesh.cell_type);
  result["material"] = settings_.material.law_name;
  result["analysis"] = settings_.dynamic ? "dynamic" : "static";
  return result;
}

template class StructureReport<2>;
template class StructureReport<3>;

}  // namespace gabion::fem
