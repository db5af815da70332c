// SPDX-License-Identifier: BSD-3-Clause
#include "mpm_solver/contact/contact_config.hpp"

#include <map>

#include "mpm_solver/config_checks.hpp"
#include "mpm_solver/contact/surface_config.hpp"

namespace gabion::mpm {

namespace {

// The keys of the method boundary_points.
template <int dim>
BoundaryPointSettings read_boundary_points(ConfigReader& in, const ContactSurface<dim>& surface,
                                           ContactLaw& law) {
  law.tangential_share = in.number_or("tangential_share", law.friction < 0 ? 1 : 0.1);
  BoundaryPointSettings points;
  points.memory = in.choice("gap") == "step" ? GapMemory::step : GapMemory::accumulated;
  const CellType facet = surface.facet_type;
  points.points_per_facet = in.integer_or("points_per_facet", num_nodes(facet));
  if constexpr (dim == 3) {
    check_point_rule<2>(in, "points_per_facet", facet, points.points_per_facet);
  }
  check_point_count(in, surface, points.points_per_facet);
  return points;
}

// The keys of the method facets.
FacetSettings read_facets(ConfigReader& in, const ContactUnits& units, ContactLaw& law) {
  if (law.mode == ContactMode::fixed) {
    in.fail("mode",
            "found \"fixed\" with \"method\": \"facets\", allowed: contact, slip, or "
            "\"method\": \"boundary_points\"");
  }
  law.tangential_share = in.number_or("tangential_share", 0.5);
  law.onset = in.number("onset") * units.cell_size;
  return {};
}

// The keys that all methods have in common.
ContactLaw read_contact_law(ConfigReader& in, const ContactUnits& units) {
  static const std::map<std::string, ContactMode> modes = {{"fixed", ContactMode::fixed},
                                                           {"contact", ContactMode::contact},
                                                           {"slip", ContactMode::slip}};
  ContactLaw law;
  law.mode = modes.at(in.choice("mode"));
  if (in.has("penalty") && in.has("penalty_factor")) {
    in.fail("penalty_factor", "allowed: only one of \"penalty\" and \"penalty_factor\"");
  }
  if (in.has("penalty")) {
    law.penalty = in.number("penalty");
  } else {
    law.penalty = units.penalty * in.number("penalty_factor");
  }
  if (in.has("friction")) {
    if (law.mode != ContactMode::contact) {
      in.fail("friction", "allowed only with \"mode\": \"contact\"");
    }
    law.friction = in.number("friction");
  }
  return law;
}

// What interfaces and rigid walls have in common.
template <int dim>
ContactSettings<dim> read_boundary(const Scene& scene, ConfigReader& in,
                                   const ContactUnits& units) {
  ContactSettings<dim> boundary;
  boundary.name = in.name("name");
  boundary.where = in.where("surface");
  boundary.surface = read_surface<dim>(scene, in.object("surface"));
  boundary.law = read_contact_law(in, units);
  if (in.choice("method") == "facets") {
    boundary.method = read_facets(in, units, boundary.law);
  } else {
    boundary.method = read_boundary_points<dim>(in, boundary.surface, boundary.law);
  }
  return boundary;
}

template <int dim>
ContactSettings<dim> read_interface(const Scene& scene, ConfigReader& in,
                                    const ContactUnits& units) {
  auto boundary = read_boundary<dim>(scene, in, units);
  in.finish();
  return boundary;
}

template <int dim>
RigidWallSettings<dim> read_rigid_wall(const Scene& scene, ConfigReader& in,
                                       const ContactUnits& units) {
  RigidWallSettings<dim> wall;
  wall.boundary = read_boundary<dim>(scene, in, units);
  wall.name = wall.boundary.name;
  if (auto item = in.optional_object("motion")) wall.motion = read_rigid_motion<dim>(*item);
  in.finish();
  return wall;
}

}  // namespace

template <int dim>
std::vector<ContactSettings<dim>> read_interfaces(const Scene& scene, ConfigReader& in,
                                                  const ContactUnits& units) {
  std::vector<ContactSettings<dim>> interfaces;
  SeenFacets<dim> facets;
  for (auto& item : in.objects("interfaces")) {
    interfaces.push_back(read_interface<dim>(scene, item, units));
    require_own_name(item, interfaces);
    require_new_facets(item, interfaces.back().surface, facets);
  }
  return interfaces;
}

template <int dim>
std::vector<RigidWallSettings<dim>> read_rigid_walls(const Scene& scene, ConfigReader& in,
                                                     const ContactUnits& units) {
  std::vector<RigidWallSettings<dim>> walls;
  SeenFacets<dim> facets;
  for (auto& item : in.objects("rigid_walls")) {
    walls.push_back(read_rigid_wall<dim>(scene, item, units));
    require_own_name(item, walls);
    require_new_facets(item, walls.back().boundary.surface, facets);
  }
  return walls;
}

template std::vector<ContactSettings<2>> read_interfaces<2>(const Scene&, ConfigReader&,
                                                            const ContactUnits&);
template std::vector<ContactSettings<3>> read_interfaces<3>(const Scene&, ConfigReader&,
                                                            const ContactUnits&);
template std::vector<RigidWallSettings<2>> read_rigid_walls<2>(const Scene&, ConfigReader&,
                                                               const ContactUnits&);
template std::vector<RigidWallSettings<3>> read_rigid_walls<3>(const Scene&, ConfigReader&,
                                                               const ContactUnits&);

}  // namespace gabion::mpm
