// SPDX-License-Identifier: BSD-3-Clause
#include "mpm_solver/step/soil_model.hpp"

#include <algorithm>
#include <cmath>
#include <set>

#include "common/mechanics/ranks/sum.hpp"
#include "mpm_solver/checks/seepage.hpp"
#include "mpm_solver/checks/soil_at_rest.hpp"
#include "mpm_solver/contact/group_config.hpp"

namespace gabion::mpm {

namespace {

template <int dim>
std::vector<std::string> find_exit_sides(const MpmSettings<dim>& settings,
                                         const FacetGroups& groups) {
  std::set<std::string> sides;
  for (const Phase& phase : settings.phases) {
    for (const OutflowSide& side : phase.outflows) {
      find_facets(groups, side.group, side.where);  // is there
      sides.insert(side.group);
    }
  }
  if (settings.outside == Outside::remove) {
    for (const auto& group : groups) sides.insert(group.first);
  }
  return {sides.begin(), sides.end()};
}

}  // namespace

template <int dim>
SoilModel<dim>::SoilModel(MPI_Comm comm_, MpmSettings<dim> settings_)
    : comm(comm_),
      settings(std::move(settings_)),
      grid(std::move(settings.grid)),
      exits(grid),
      cell_size(mean_cell_size(grid)) {
  // Volumes are averaged over cells; triangles and tetrahedra are too small for that.
  if (settings.locking.average_volumes && grid.is_simplex()) {
    grid.patches = join_cells(grid.stored->mesh, grid.stored->locator);
  }
  grid.splits_border = settings.locking.average_volumes && grid.basis == Basis::bspline;
  for (std::size_t b = 0; b < settings.bodies.size(); ++b) {
    const auto& material = settings.bodies[b].material;
    const WeightedColumn column = column_of(settings, b);
    weights.push_back(column.density * column.gravity * column.height);
    elastic.push_back(is_elastic<dim>(material.law) ? 1 : 0);
    remembers_internal |= gabion::remembers_internal<dim>(material.law);
    remembers_variables |= std::holds_alternative<Umat<dim>>(material.law);
    varies |= !settings.bodies[b].varying.empty();
    const double modulus =
        std::visit([](const auto& law) { return law.p_wave_modulus(); }, material.law);
    moduli.push_back(modulus);
    drains |= mpm::drains(settings.bodies[b]);
    wave_speeds.push_back(std::sqrt(undrained_modulus(settings.bodies[b]) / material.density));
    wave_speed = std::max(wave_speed, wave_speeds.back());
    symmetric_laws &=
        std::visit([](const auto& law) { return law.symmetric_tangent(); }, material.law);
    if (b < settings.varying.size() && settings.varying[b]) {
      symmetric_laws &= settings.varying[b]->symmetric();
    }
  }
  stressed = std::any_of(settings.initial_stress.begin(), settings.initial_stress.end(),
                         [](const auto& stress) { return stress.has_value(); });
  exit_sides = find_exit_sides(settings, grid.facet_groups);
  lets_out = settings.outside == Outside::remove || !exit_sides.empty();
  for (const Phase& phase : settings.phases) {
    for (const auto& wall : phase.walls) {
      const auto known = std::find(wall_groups.begin(), wall_groups.end(), wall.group);
      if (known == wall_groups.end()) wall_groups.push_back(wall.group);
    }
  }
}

template struct SoilModel<2>;
template struct SoilModel<3>;

}  // namespace gabion::mpm
