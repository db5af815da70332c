// SPDX-License-Identifier: BSD-3-Clause
#include "fem_solver/report/line_output.hpp"

#include <algorithm>
#include <functional>
#include <map>
#include <numeric>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "common/mechanics/output/numbered_rows.hpp"
#include "fem_solver/stress/bar_values.hpp"
#include "fem_solver/stress/cell_failure.hpp"

namespace gabion::fem {

namespace {

using Values = std::vector<double>;

template <int dim>
bool has_brakes(const FemSettings<dim>& settings) {
  return std::ranges::any_of(settings.line_materials, [](const LineMaterial& material) {
    return material.brake.has_value();
  });
}

template <int dim>
bool has_bars(const FemSettings<dim>& settings) {
  return std::ranges::any_of(settings.line_materials, [](const LineMaterial& material) {
    return material.hardening.has_value();
  });
}

/// Names of resultants of beams and their places among N, V_2, V_3, T, M_2, M_3.
template <int dim>
std::map<std::string, int> beam_fields() {
  if (dim == 2) return {{"shear_force", 1}, {"bending_moment", 5}};
  return {{"shear_force_2", 1},
          {"shear_force_3", 2},
          {"torsion", 3},
          {"bending_moment_2", 4},
          {"bending_moment_3", 5}};
}

/// One of the resultants of each line, 0 where it is no beam.
template <int dim>
Values beam_values(const CellIntegrals<dim>& cells, const StructureState& state,
                   std::span<const double> history, int place, std::int32_t num_lines) {
  Values values(static_cast<std::size_t>(num_lines), 0.0);
  for (std::size_t b = 0; b < cells.line_blocks().size(); ++b) {
    const LineBlock<dim>& block = cells.line_blocks()[b];
    if (!block.beams()) continue;
    const auto own = block.beams()->resultants(state.motion.u, cells.of_line_block(history, b));
    for (std::size_t k = 0; k < own.size(); ++k) {
      values[block.lines()[k]] = place < 3 ? own[k].force[place] : own[k].moment[place - 3];
    }
  }
  return values;
}

template <int dim>
bool has_beams(const FemSettings<dim>& settings) {
  return std::ranges::any_of(settings.line_materials, [](const LineMaterial& material) {
    return material.beam.has_value();
  });
}

template <int dim>
std::vector<OutputField> line_fields(const FemSettings<dim>& settings) {
  std::vector<OutputField> fields = {{.name = "axial_force", .on_cells = true}};
  if (has_beams(settings)) {
    for (const auto& [name, place] : beam_fields<dim>()) {
      fields.push_back({.name = name, .on_cells = true});
    }
  }
  if (has_brakes(settings)) fields.push_back({.name = "brake_run", .on_cells = true});
  if (has_bars(settings)) {
    fields.push_back({.name = "axial_stress", .on_cells = true});
    fields.push_back({.name = "plastic_strain", .on_cells = true});
  }
  if (std::ranges::any_of(settings.line_materials,
                          [](const LineMaterial& material) { return material.failure.any(); })) {
    fields.push_back({.name = "failed", .on_cells = true});
  }
  return fields;
}

}  // namespace

template <int dim>
std::int64_t LineOutput<dim>::frame_bytes(const FemSettings<dim>& settings) {
  const std::int64_t num_lines = settings.ranks.num_lines_of_all(settings.mesh);
  if (num_lines == 0) return 0;
  return XdmfSeries::frame_bytes(2 * num_lines, CellType::line2, num_lines,
                                 line_fields<dim>(settings));
}

template <int dim>
LineOutput<dim>::LineOutput(const FemSettings<dim>& settings, const std::string& folder)
    : settings_(settings), series_(folder, "lines", settings.ranks.comm()) {}

template <int dim>
void LineOutput<dim>::write(double time, const StructureState& state,
                            const Equilibrium<dim>& equilibrium) {
  const Mesh<dim>& mesh = settings_.mesh;
  const MeshRanks& ranks = settings_.ranks;
  const std::int32_t num_lines = ranks.num_lines_of_all(mesh);
  const NumberedRows rows(ranks.comm(), ranks.own_lines(mesh.num_lines()), num_lines);
  const std::span<const double> history =
      state.history ? std::span<const double>(*state.history) : std::span<const double>();
  Values x;
  for (const std::int32_t i : mesh.lines) {
    for (int k = 0; k < dim; ++k) {
      x.push_back(mesh.nodes[i][k] + state.motion.u[static_cast<std::size_t>(i) * dim + k]);
    }
  }
  x = rows.gather_rows(std::move(x), 2 * dim);
  std::vector<std::int32_t> ends;
  for (const std::int32_t l : ranks.own_lines(mesh.num_lines())) {
    ends.insert(ends.end(), {2 * l, 2 * l + 1});
  }
  ends = rows.gather_rows(std::move(ends), 2);
  const CellIntegrals<dim>& cells = equilibrium.cells();
  auto fields = line_fields<dim>(settings_);
  std::map<std::string, std::function<Values()>> values = {
      {"axial_force", [&] { return cells.line_forces(state.motion.u, history); }},
      {"brake_run", [&] { return cells.line_runs(history); }},
      {"axial_stress", [&] { return line_stresses<dim>(cells, state.motion.u, history); }},
      {"plastic_strain", [&] { return line_plastic_strains<dim>(cells, history); }},
      {"failed", [&] { return lost_shares_of_lines(cells, history, mesh.num_lines()); }}};
  for (const auto& [name, place] : beam_fields<dim>()) {
    values[name] = [&, place] {
      return beam_values<dim>(cells, state, history, place, mesh.num_lines());
    };
  }
  for (OutputField& field : fields) {
    field.make = [&rows, make = values.at(field.name)] { return rows.gather_rows(make(), 1); };
  }
  series_.write({.time = time,
                 .dim = dim,
                 .coordinates = x,
                 .cell_type = CellType::line2,
                 .connectivity = ends,
                 .fields = std::move(fields)});
}

template class LineOutput<2>;
template class LineOutput<3>;

}  // namespace gabion::fem
