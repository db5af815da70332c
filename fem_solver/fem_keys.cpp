// SPDX-License-Identifier: BSD-3-Clause
#include <fmt/format.h>

#include <algorithm>

#include "fem_solver/fem_config.hpp"
#include "fem_solver/matrices/matrix_settings.hpp"
#include "fem_solver/step/static_newton.hpp"
#include "solver_program/solver_program.hpp"

namespace gabion::fem {

namespace {

const std::vector<std::string> all_components = {component_names, component_names + 3};
constexpr const char* factor_sentence =
    "Rows [t, factor], linear between rows and constant before and after; none: factor 1.";

Key group_key(const std::string& sentence) {
  return key::text("group", sentence);
}

KeyTable support_keys() {
  return {"support",
          "Nodes that do not move. Each component of a group is fixed once at most.",
          {group_key("Group of facets or points whose nodes are held."),
           key::texts("components", "Components of the displacement that are zero.")
               .among(all_components)
               .not_empty()
               .or_computed("all"),
           key::texts("rotations", "Axes about which nodes of beams do not turn; in 2D z alone.")
               .among(all_components)
               .not_empty()
               .or_none(),
           key::boolean("report_reaction", "Adds the columns reaction_GROUP_x, ... to the probes.")
               .or_else(SupportSettings{}.report_reaction),
           key::boolean("report_moment",
                        "Adds the columns moment_GROUP_z, in 3D moment_GROUP_x, ...: moment of the "
                        "reactions at their present places, about the centre of the group's facets "
                        "or points before loading.")
               .or_else(SupportSettings{}.report_moment)}};
}

KeyTable prescribed_keys() {
  return {"prescribed",
          "One component of the displacement of a group as a function of time.",
          {group_key("Group of facets or points whose nodes are moved."),
           key::choice("component", all_components, "Component of the displacement."),
           key::number("rate", "m/s", "The displacement is this times t.").or_none(),
           time_table_key(
               "m", "Rows [t, displacement], linear between rows and constant before and after.")},
          {"rate", "table"}};
}

KeyTable load_keys() {
  return {
      "load",
      "A force on the node at a point, or in equal parts on the nodes of a group.",
      {key::vector("point", "m", "Coordinates of a node in the reference configuration.").or_none(),
       group_key("Group of facets or points whose nodes share the force.").or_none(),
       key::vector("force", "N", "The resultant; in 2D per metre of thickness."),
       key::vector("moment", "N m",
                   "Sum of the moments on nodes of beams, about fixed axes; in 2D one number, "
                   "about z.")
           .wide(1, 3)
           .or_none(),
       time_table_key("", factor_sentence)},
      {"point", "group"}};
}

std::vector<Key> place_keys(const std::string& group_sentence) {
  return {
      key::vector("point", "m", "Coordinates of a node in the reference configuration.").or_none(),
      group_key(group_sentence).or_none()};
}

KeyTable time_integration_keys() {
  KeyTable table = newmark_keys("newmark");
  table.keys.front() = table.keys.front().or_computed(
      "`newmark`; with cables, brakes, `tension_only` or concrete and without damping "
      "`generalized_alpha` with `rho_inf` 0");
  Key rho_inf = *std::ranges::find(table.keys, "rho_inf", &Key::name);
  rho_inf.conditions.clear();
  table.keys.push_back(
      rho_inf.or_computed("0 with cables, brakes, `tension_only` or concrete").without("scheme"));
  return table;
}

KeyTable structure_newton_keys() {
  KeyTable table = newton_keys(newton_defaults);
  const auto limit = std::ranges::find(table.keys, "max_iterations", &Key::name);
  limit->sentence += fmt::format(
      " Without inertia a structure with cables, brakes or `tension_only` takes {} times as many: "
      "slack lines find their shape slowly.",
      slack_iterations);
  return table;
}

KeyTable point_mass_keys() {
  KeyTable table{"point_mass",
                 "A mass at the node at a point, or in equal parts at the nodes of a group.",
                 place_keys("Group of facets or points whose nodes share the mass."),
                 {"point", "group"}};
  table.keys.push_back(
      key::number("mass", "kg", "Total mass; in 2D per metre of thickness.").in(positive()));
  return table;
}

KeyTable spring_keys() {
  KeyTable table{"spring",
                 "A linear spring from the node at a point to the ground, or in equal parts from "
                 "the nodes of a group; without force before loading.",
                 place_keys("Group of facets or points whose nodes share the stiffness."),
                 {"point", "group"}};
  table.keys.push_back(
      key::vector("stiffness", "N/m",
                  "Total along each axis, 0 for none; in 2D per metre of thickness.")
          .in(non_negative()));
  return table;
}

KeyTable dashpot_keys() {
  KeyTable table{"dashpot",
                 "A linear dashpot from the node at a point to the ground, or in equal parts from "
                 "the nodes of a group; in a dynamic analysis only, in coupled structures with the "
                 "scheme `newmark` only.",
                 place_keys("Group of facets or points whose nodes share the damping."),
                 {"point", "group"}};
  table.keys.push_back(
      key::vector("damping", "N s/m",
                  "Total along each axis, 0 for none; in 2D per metre of thickness.")
          .in(non_negative()));
  return table;
}

KeyTable traction_keys() {
  return {"traction",
          "A dead load on the facets of a group.",
          {group_key("Facet group that carries it."),
           key::vector("traction", "Pa", "Force per reference area."),
           time_table_key("", factor_sentence)}};
}

KeyTable rigid_link_keys() {
  return {"rigid_link",
          "Nodes that move with one node of a beam as a rigid body, such as those where it is "
          "clamped in cells, or of an end plate.",
          {key::text("beam", "Group of one point: the node of the beam."),
           group_key("Group of facets or points whose nodes move with it.")}};
}

KeyTable interface_keys() {
  return {
      "interface",
      "A wet surface that the coupler couples; each facet belongs to one surface only, and once.",
      {key::plain_name("As in coupler.json."),
       key::texts("groups", "Facet groups of the surface.").not_empty().or_none(),
       key::text("facets",
                 "File of the facets, rows of node numbers, normals outward as in Gmsh's order; "
                 "with `matrices`.")
           .or_none(),
       key::texts("beams",
                  "Groups of beams. The surface is the outline of their cross-section along them: "
                  "of circles and pipes an octagon, in 2D the two sides at half the height.")
           .not_empty()
           .or_none(),
       key::texts("behind",
                  "Groups of cells that may fail, or `all`. When such a cell is gone, its facets "
                  "leave the surface and faces behind it become wet. The soil's `surface` names "
                  "the same groups.")
           .not_empty()
           .or_none()},
      {"groups", "facets", "beams"}};
}

KeyTable probe_keys() {
  return {"probe",
          "A point whose displacement is reported: that of the node there, or interpolated in the "
          "cell.",
          {key::plain_name("Unique name; columns of the tables start with it."),
           key::vector("point", "m", "Place in the reference configuration.")}};
}

std::vector<Key> model_keys() {
  const std::vector<std::string> dynamic = {"dynamic"};
  return {
      key::integer("dimension", "Dimension of space; 2 is plane strain.").in(between(2, 3)),
      key::object("mesh", mesh_keys(), "Mesh of the structure.").without("matrices"),
      key::object("material", cell_material_keys(), "Material of all cells.")
          .without("matrices")
          .without("materials"),
      key::objects("materials", group_material_keys(),
                   "Materials by groups of cells or lines, in place of `material`; each cell is in "
                   "one of the groups.")
          .or_none()
          .without("matrices"),
      key::object("matrices", matrix_keys(), "The structure as matrices, in place of a mesh.")
          .or_none(),
      key::choice("analysis", {"dynamic", "static"}, "`static`: without inertia.")
          .or_else("dynamic"),
      key::object("time_integration", time_integration_keys(), "Scheme of the dynamic analysis.")
          .or_empty()
          .when("analysis", dynamic),
      key::choice("mass", {"consistent", "lumped"},
                  "`lumped`: row sums of the consistent mass matrix; of quadratic cells in "
                  "proportion to its diagonal. Cables and brakes are always lumped.")
          .or_else("consistent")
          .when("analysis", dynamic)
          .without("matrices"),
      key::vector("gravity", "m/s^2", "Acceleration on all cells.").or_else(0).without("matrices"),
      key::vector("initial_velocity", "m/s",
                  "Initial velocity of all free components; zero with `initial_equilibrium`.")
          .or_else(0)
          .when("analysis", dynamic),
      key::boolean("initial_equilibrium",
                   "Whether the run starts at rest, in equilibrium with gravity and the loads at "
                   "time 0; needs `supports` or `prescribed` in every direction.")
          .or_else(MotionSettings<2>{}.initial_equilibrium)};
}

std::vector<Key> condition_keys() {
  return {
      key::objects("supports", support_keys(),
                   "Nodes that do not move. In statics and with `initial_equilibrium`, `supports` "
                   "or `prescribed` are needed in every direction.")
          .or_empty()
          .without("matrices"),
      key::objects("prescribed", prescribed_keys(), "Nodes with a given displacement.")
          .or_empty()
          .without("matrices"),
      key::objects("loads", load_keys(), "Forces.").or_empty().without("matrices"),
      key::objects("point_masses", point_mass_keys(), "Masses at nodes.")
          .or_empty()
          .without("matrices"),
      key::objects("springs", spring_keys(), "Springs to the ground.")
          .or_empty()
          .without("matrices"),
      key::objects("dashpots", dashpot_keys(), "Dashpots to the ground.")
          .or_empty()
          .without("matrices"),
      key::objects("tractions", traction_keys(), "Forces per area.").or_empty().without("matrices"),
      key::objects("rigid_links", rigid_link_keys(), "Rigid links of nodes to beams.")
          .or_empty()
          .without("matrices"),
      key::objects("interfaces", interface_keys(), "Coupled surfaces.").or_empty(),
      key::objects("probes", probe_keys(), "Points whose displacement is reported.").or_empty(),
      key::objects("sections", section_keys(), "Planes whose force and moment are reported.")
          .or_empty()
          .without("matrices"),
      key::object("newton", structure_newton_keys(), "Newton's method.")
          .or_empty()
          .without("matrices"),
      key::object("linear_solver", linear_solver_keys(), "Solution of the linear systems.")
          .or_empty()
          .without("matrices")};
}

}  // namespace

KeyTable fem_keys() {
  KeyTable table{"fem", "Settings of the structure.", {key::schema()}};
  for (const auto& group : {model_keys(), condition_keys(), alone_keys()}) {
    table.keys.insert(table.keys.end(), group.begin(), group.end());
  }
  return table;
}

}  // namespace gabion::fem
