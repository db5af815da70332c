// SPDX-License-Identifier: BSD-3-Clause
#include "mpm_solver/step/seepage_borders.hpp"

#include <algorithm>
#include <cmath>
#include <map>

#include "mpm_solver/checks/seepage.hpp"
#include "mpm_solver/contact/start_check.hpp"
#include "mpm_solver/step/free_surface.hpp"

namespace gabion::mpm {

template <int dim>
SeepageBorders<dim>::SeepageBorders(const SoilModel<dim>& model) : model_(model) {
  const MpmSettings<dim>& settings = model.settings;
  for (std::size_t b = 0; b < settings.bodies.size(); ++b) {
    if (!drains(settings.bodies[b]) || !settings.bodies[b].water->seepage_face) continue;
    with_seepage_face_.push_back(static_cast<std::int32_t>(b));
  }
  if (with_seepage_face_.empty()) return;
  const auto surfaces = surfaces_at_start(settings.interfaces, settings.rigid_walls);
  if (surfaces.empty()) return;
  sights_.emplace(surfaces, model.grid);
  for (std::size_t k = 0; k < surfaces.size(); ++k) {
    if (surfaces[k].settings.drained) sights_->leave_out(k);
  }
}

template <int dim>
std::vector<OuterPoint<dim>> SeepageBorders<dim>::free_surface(const SoilState<dim>& state,
                                                               std::size_t phase) {
  const bool meets_surfaces = sights_ && sights_->follow(state.surfaces);
  const SurroundingsOfSoil<dim> surroundings{.comm = model_.comm,
                                             .grid = model_.grid,
                                             .points = state.points,
                                             .walls = model_.settings.phases[phase].walls,
                                             .surfaces = meets_surfaces ? &*sights_ : nullptr};
  return find_free_surface<dim>(surroundings, with_seepage_face_);
}

template <int dim>
DrainedNodes SeepageBorders<dim>::drained_nodes(const GridNodes<dim>& nodes,
                                                const Beyond& beyond) const {
  const auto& bodies = model_.settings.bodies;
  auto soil = std::ranges::find_if(
      bodies, [&](const Body<dim>& body) { return drains(body) && body.water->table; });
  if (soil == bodies.end()) soil = std::ranges::find_if(bodies, drains<dim>);
  const Phase& phase = model_.settings.phases[beyond.phase];
  const double share = phase.gravity_ramp.at(beyond.time);
  struct Given {
    double q, p;
  };
  std::map<std::int32_t, Given> given;
  const auto drain = [&](std::int32_t node) {
    const std::int32_t i = nodes.active[node];
    if (i < 0) return;
    const Vector<dim>& x = nodes.x[i];
    const double p = beyond.pools.empty() ? share * soil->water->hydrostatic(x[dim - 1])
                                          : beyond.pools.template pressure<dim>(x);
    given[i] = {p - soil->water->density * beyond.gravity.dot(x), p};
  };
  for (const WallSettings& wall : phase.walls) {
    if (!wall.drained) continue;
    for (const std::int32_t node :
         find_group_nodes(model_.grid.facet_groups, wall.group, wall.where)) {
      for (std::int32_t f = 0; f < nodes.num_fields; ++f) drain(node + f * nodes.num_places);
    }
  }
  DrainedNodes drained;
  for (const auto& [node, value] : given) {
    drained.nodes.push_back(node);
    drained.q.push_back(value.q);
    drained.p.push_back(value.p);
  }
  return drained;
}

template <int dim>
std::vector<FedSide> SeepageBorders<dim>::fed_sides(std::size_t phase) const {
  std::vector<FedSide> sides;
  for (const WallSettings& wall : model_.settings.phases[phase].walls) {
    if (wall.inflow == 0) continue;
    const BoxGrid<dim>& box = *model_.grid.box;
    const auto nodes = find_group_nodes(model_.grid.facet_groups, wall.group, wall.where);
    for (int d = 0; d < dim; ++d) {
      const auto at = [&](double end) {
        return std::ranges::all_of(nodes, [&](std::int32_t node) {
          return std::round(box.lattice_position(box.node_position(node))[d]) == end;
        });
      };
      for (const bool high : {false, true}) {
        if (!at(high ? box.num_cells[d] : 0)) continue;
        sides.push_back({.axis = d, .high = high, .rate = wall.inflow});
      }
    }
  }
  return sides;
}

template <int dim>
Vector<dim> SeepageBorders<dim>::rain_at(double time) const {
  const MpmSettings<dim>& settings = model_.settings;
  if (!settings.rain) return Vector<dim>::Zero();
  return settings.rain->at(time) * settings.gravity.normalized();
}

template class SeepageBorders<2>;
template class SeepageBorders<3>;

}  // namespace gabion::mpm
