// SPDX-License-Identifier: BSD-3-Clause
#include "mpm_solver/contact/contact_config.hpp"

#include <fmt/format.h>

#include <map>
#include <utility>

#include "mpm_solver/config_checks.hpp"
#include "mpm_solver/contact/sticking.hpp"
#include "mpm_solver/contact/surface_config.hpp"

namespace gabion::mpm {

namespace {

// The keys of the method boundary_points.
template <int dim>
BoundaryPointSettings read_boundary_points(ConfigReader& in, const ContactSettings<dim>& shared,
                                           double penalty_unit) {
  BoundaryPointSettings points;
  if (in.has("penalty") && in.has("penalty_factor")) {
    in.fail("penalty_factor", "allowed: only one of \"penalty\" and \"penalty_factor\"");
  }
  points.penalty =
      in.has("penalty") ? in.number("penalty") : penalty_unit * in.number_or("penalty_factor", 0.5);
  points.tangential_share = in.number_or("tangential_share", shared.friction < 0 ? 1 : 0.1);
  points.memory = in.choice("gap") == "step" ? GapMemory::step : GapMemory::accumulated;
  const CellType facet = shared.surface.facet_type;
  points.points_per_facet = in.integer_or("points_per_facet", num_nodes(facet));
  if constexpr (dim == 3) {
    check_point_rule<2>(in, "points_per_facet", facet, points.points_per_facet);
  }
  check_point_count(in, shared.surface, points.points_per_facet);
  return points;
}

// Nothing is iterated with a rigid wall, so stiff contact costs nothing there.
constexpr double resting_factor_of_walls = 12;

// The keys of the method facets. @param resting_factor  the value where the key is missing
FacetSettings read_facets(ConfigReader& in, ContactMode mode, double resting_factor) {
  if (mode == ContactMode::fixed) {
    in.fail("mode",
            "found \"fixed\" with \"method\": \"facets\", allowed: contact, slip, or "
            "\"method\": \"boundary_points\"");
  }
  for (const char* key : {"penalty", "tangential_share", "gap", "points_per_facet"}) {
    if (in.has(key)) in.fail(key, "allowed only with \"method\": \"boundary_points\"");
  }
  FacetSettings facets;
  facets.penalty_factor = in.number_or("penalty_factor", facets.penalty_factor);
  facets.resting_factor = in.number_or("resting_factor", resting_factor);
  facets.tangential_factor = in.number("tangential_factor");
  return facets;
}

// The keys of friction that depends on the speed. @param friction  at rest
FrictionFall read_weakening(ConfigReader& in, double friction) {
  const bool falls = in.has("friction_at_speed");
  for (const char* key : {"friction_at_speed", "weakening_speed", "turbulent_drag"}) {
    if (in.has(key) && !(in.has("friction") && in.choice("method") == "facets")) {
      in.fail(key, "allowed only with \"friction\" and \"method\": \"facets\"");
    }
  }
  if (in.has("weakening_speed") && !falls) {
    in.fail("weakening_speed", "allowed only with \"friction_at_speed\"");
  }
  if (!falls) return {};
  const double least = in.number("friction_at_speed");
  if (least > friction) {
    in.fail(
        "friction_at_speed",
        fmt::format("found {}, allowed: at most the \"friction\" of rest, {}", least, friction));
  }
  return {.fall = friction - least, .speed = in.number("weakening_speed")};
}

// Settings that interfaces and rigid walls have in common.
// @param coupled  it is an interface
template <int dim>
ContactSettings<dim> read_boundary(const Scene& scene, ConfigReader& in, double penalty_unit,
                                   double resting_factor, bool coupled) {
  ContactSettings<dim> boundary;
  boundary.name = in.name("name");
  boundary.where = in.where("surface");
  ConfigReader surface = in.object("surface");
  const bool may_change = surface.has("behind");
  boundary.surface = read_surface<dim>(scene, std::move(surface));
  static const std::map<std::string, ContactMode> modes = {{"fixed", ContactMode::fixed},
                                                           {"contact", ContactMode::contact},
                                                           {"slip", ContactMode::slip}};
  boundary.mode = modes.at(in.choice("mode"));
  if (in.has("friction")) {
    if (boundary.mode != ContactMode::contact) {
      in.fail("friction", "allowed only with \"mode\": \"contact\"");
    }
    boundary.friction = in.number("friction");
  }
  boundary.weakening = read_weakening(in, boundary.friction);
  if (may_change && !(coupled && in.choice("method") == "facets")) {
    in.fail("surface/behind", "allowed of interfaces with \"method\": \"facets\"");
  }
  if (in.choice("method") == "facets") {
    boundary.drained = in.boolean("drained");
    boundary.method = read_facets(in, boundary.mode, resting_factor);
    if (boundary.friction >= 0) boundary.drag = in.number("turbulent_drag");
    if (boundary.mode == ContactMode::contact && boundary.friction < 0) {
      boundary.friction = sticking;
    }
  } else {
    boundary.method = read_boundary_points<dim>(in, boundary, penalty_unit);
  }
  return boundary;
}

template <int dim>
ContactSettings<dim> read_interface(const Scene& scene, ConfigReader& in, double penalty_unit) {
  auto boundary = read_boundary<dim>(scene, in, penalty_unit, 0, true);
  in.finish();
  return boundary;
}

template <int dim>
RigidWallSettings<dim> read_rigid_wall(const Scene& scene, ConfigReader& in, double penalty_unit) {
  RigidWallSettings<dim> wall;
  wall.boundary = read_boundary<dim>(scene, in, penalty_unit, resting_factor_of_walls, false);
  wall.name = wall.boundary.name;
  if (auto item = in.optional_object("motion")) wall.motion = read_rigid_motion<dim>(*item);
  const auto place = in.vector("moment_about", dim);
  wall.moment_about = Eigen::Map<const Vector<dim>>(place.data());
  in.finish();
  return wall;
}

}  // namespace

template <int dim>
std::vector<ContactSettings<dim>> read_interfaces(const Scene& scene, ConfigReader& in,
                                                  double penalty_unit) {
  std::vector<ContactSettings<dim>> interfaces;
  SeenFacets<dim> facets;
  for (auto& item : in.objects("interfaces")) {
    interfaces.push_back(read_interface<dim>(scene, item, penalty_unit));
    require_own_name(item, interfaces);
    require_new_facets(item, interfaces.back().surface, facets);
  }
  return interfaces;
}

template <int dim>
std::vector<RigidWallSettings<dim>> read_rigid_walls(const Scene& scene, ConfigReader& in,
                                                     double penalty_unit) {
  std::vector<RigidWallSettings<dim>> walls;
  SeenFacets<dim> facets;
  for (auto& item : in.objects("rigid_walls")) {
    walls.push_back(read_rigid_wall<dim>(scene, item, penalty_unit));
    require_own_name(item, walls);
    require_new_facets(item, walls.back().boundary.surface, facets);
  }
  return walls;
}

template std::vector<ContactSettings<2>> read_interfaces<2>(const Scene&, ConfigReader&, double);
template std::vector<ContactSettings<3>> read_interfaces<3>(const Scene&, ConfigReader&, double);
template std::vector<RigidWallSettings<2>> read_rigid_walls<2>(const Scene&, ConfigReader&, double);
template std::vector<RigidWallSettings<3>> read_rigid_walls<3>(const Scene&, ConfigReader&, double);

}  // namespace gabion::mpm
