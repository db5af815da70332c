// SPDX-License-Identifier: BSD-3-Clause
#include "fem_solver/report/fem_output.hpp"

#include <algorithm>
#include <functional>
#include <span>
#include <utility>

#include "common/mechanics/output/numbered_rows.hpp"
#include "fem_solver/stress/cell_damage.hpp"
#include "fem_solver/stress/cell_failure.hpp"

namespace gabion::fem {

namespace {

using Values = std::vector<double>;
using Damages = std::vector<CellDamage>;

OutputField field(std::string name, int components, std::function<Values()> make) {
  return {.name = std::move(name), .components = components, .make = std::move(make)};
}

/// Fields of a frame at the nodes and cells of this rank. The fields refer to their arguments.
template <int dim>
std::vector<OutputField> frame_fields(const StructureState& state,
                                      const std::function<Values()>& stress,
                                      const std::function<Values()>& plastic_strain,
                                      const std::function<Damages()>& damages,
                                      const std::function<Values()>& failed) {
  const auto forces = [&state] {
    Values values = state.f_ext;
    for (std::size_t i = 0; i < values.size(); ++i) values[i] += state.f_step[i];
    return values;
  };
  std::vector<OutputField> fields = {
      field("displacement", dim, [&state] { return state.motion.u; }),
      field("velocity", dim, [&state] { return state.motion.v; }),
      field("external_force", dim, forces), field("stress", symmetric_size<dim>, stress)};
  if (plastic_strain) fields.push_back(field("plastic_strain", 1, plastic_strain));
  if (damages) {
    const auto part = [damages](double CellDamage::*member) {
      return [damages, member] {
        Values values;
        for (const CellDamage& cell : damages()) values.push_back(cell.*member);
        return values;
      };
    };
    fields.push_back(field("tensile_damage", 1, part(&CellDamage::tensile)));
    fields.push_back(field("compressive_damage", 1, part(&CellDamage::compressive)));
    fields.push_back(field("crack_width", 1, part(&CellDamage::crack_width)));
  }
  if (failed) fields.push_back(field("failed", 1, failed));
  for (std::size_t i = 3; i < fields.size(); ++i) fields[i].on_cells = true;
  return fields;
}

/// Number of nodes of all ranks without those of rotations.
template <int dim>
std::int32_t places_of_all(const FemSettings<dim>& settings) {
  return settings.ranks.alone() ? settings.num_places()
                                : settings.ranks.num_nodes_of_all(settings.mesh);
}

}  // namespace

template <int dim>
std::int64_t FemOutput<dim>::frame_bytes(const FemSettings<dim>& settings) {
  const Mesh<dim>& mesh = settings.mesh;
  const MeshRanks& ranks = settings.ranks;
  std::function<Values()> plastic_strain, failed;
  std::function<Damages()> damages;
  for (const CellMaterial<dim>& material : settings.materials) {
    if (std::holds_alternative<VonMises<dim>>(material.law))
      plastic_strain = [] { return Values(); };
    if (std::holds_alternative<Concrete<dim>>(material.law)) damages = [] { return Damages(); };
    if (material.failure.any()) failed = [] { return Values(); };
  }
  return XdmfSeries::frame_bytes(places_of_all(settings), mesh.cell_type,
                                 ranks.num_cells_of_all(mesh),
                                 frame_fields<dim>({}, {}, plastic_strain, damages, failed));
}

template <int dim>
FemOutput<dim>::FemOutput(const FemSettings<dim>& settings, const std::string& folder)
    : settings_(settings), series_(folder, "structure", settings.ranks.comm()) {}

template <int dim>
void FemOutput<dim>::write(double time, const StructureState& state,
                           const Equilibrium<dim>& equilibrium) {
  const Mesh<dim>& mesh = settings_.mesh;
  const MeshRanks& ranks = settings_.ranks;
  const std::int32_t num_places = settings_.num_places();
  const NumberedRows nodes(ranks.comm(), ranks.owned_nodes(num_places), places_of_all(settings_));
  const auto of_places = [&](Values values, int width) {
    values.resize(static_cast<std::size_t>(num_places) * width);
    return ranks.owned(std::move(values), width);
  };
  const NumberedRows cells(ranks.comm(), ranks.own_cells(mesh.num_cells()),
                           ranks.num_cells_of_all(mesh));
  const CellIntegrals<dim>& integrals = equilibrium.cells();
  const std::span<const double> history =
      state.history ? std::span<const double>(*state.history) : std::span<const double>();
  std::function<Values()> plastic_strain;
  if (integrals.yields()) {
    plastic_strain = [&] { return integrals.cell_plastic_strains(history); };
  }
  std::function<Damages()> damages;
  if (integrals.cracks()) damages = [&] { return cell_damage(integrals, history); };
  std::function<Values()> failed;
  if (std::ranges::any_of(integrals.blocks(), [](const auto& b) { return b.may_fail(); })) {
    failed = [&] { return lost_shares_of_cells(integrals, history); };
  }
  auto fields = frame_fields<dim>(
      state, [&] { return integrals.cell_stresses(state.motion.u, history); }, plastic_strain,
      damages, failed);
  for (OutputField& field : fields) {
    field.make = [&, own = std::move(field.make), width = field.components,
                  on_cells = field.on_cells] {
      return on_cells ? cells.gather_rows(own(), width)
                      : nodes.gather_rows(of_places(own(), width), width);
    };
  }
  Values x = state.motion.u;
  for (std::size_t i = 0; i < x.size(); ++i) x[i] += mesh.nodes[i / dim][i % dim];
  x = nodes.gather_rows(of_places(std::move(x), dim), dim);
  std::vector<std::int32_t> corners = mesh.cells;
  for (std::int32_t& i : corners) i = ranks.node_of_all(i);
  corners = cells.gather_rows(std::move(corners), mesh.nodes_per_cell());
  series_.write({.time = time,
                 .dim = dim,
                 .coordinates = x,
                 .cell_type = mesh.cell_type,
                 .connectivity = corners,
                 .fields = std::move(fields)});
}

template class FemOutput<2>;
template class FemOutput<3>;

}  // namespace gabion::fem
