// SPDX-License-Identifier: BSD-3-Clause
#include "mpm_solver/checks/group_needs.hpp"

#include <fmt/format.h>

#include <limits>

#include "mpm_solver/checks/seepage.hpp"
#include "mpm_solver/points/laid_sides.hpp"

namespace gabion::mpm {

template <int dim>
void check_group_needs(const ConfigReader& in, const MpmSettings<dim>& settings) {
  const std::size_t num_groups = settings.body_groups.names.size();
  if (num_groups == 0) return;
  const char* key = "contact_groups";
  if (!settings.grid.box) {
    in.fail(key, fmt::format("found on a grid that is not a \"box\" of {}, allowed: such a box",
                             dim == 2 ? "quad4" : "hex8"));
  }
  const double most = std::numeric_limits<std::int32_t>::max();
  if (static_cast<double>(num_groups) * settings.grid.num_nodes_total() > most) {
    in.fail(key, fmt::format("found {} groups on {} nodes of the grid, allowed: groups times nodes "
                             "up to {}",
                             num_groups, settings.grid.num_nodes_total(), most));
  }
  for (const Body<dim>& body : settings.bodies) {
    if (!drains(body)) continue;
    in.fail(key, fmt::format("found with the pore water of \"{}\" that drains, allowed: bodies "
                             "that are dry or have no \"permeability\"",
                             body.name));
  }
  for (std::size_t b = 0; b < settings.layouts.size(); ++b) {
    const double deepest = deepest_uneven_row(settings.layouts[b]);
    if (deepest == 0) continue;
    in.fail(fmt::format("bodies/{}/mesh", b),
            fmt::format("found cells with points {:.3g} m below a side and nearer to another one, "
                        "allowed with \"contact_groups\": {}, so that contact begins at each side",
                        deepest, dim == 2 ? "squares" : "cubes"));
  }
  const auto require_facets = [&](const ContactSettings<dim>& surface) {
    if (std::holds_alternative<FacetSettings>(surface.method)) return;
    in.fail(key, fmt::format("found with the boundary points of \"{}\", allowed: \"method\": "
                             "\"facets\"",
                             surface.name));
  };
  for (const auto& interface : settings.interfaces) require_facets(interface);
  for (const auto& wall : settings.rigid_walls) require_facets(wall.boundary);
}

template void check_group_needs<2>(const ConfigReader&, const MpmSettings<2>&);
template void check_group_needs<3>(const ConfigReader&, const MpmSettings<3>&);

}  // namespace gabion::mpm
