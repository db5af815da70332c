// SPDX-License-Identifier: BSD-3-Clause
#include "fem_solver/fem_config.hpp"
#include "fem_solver/matrices/matrix_settings.hpp"
#include "solver_program/solver_program.hpp"

namespace gabion::fem {

namespace {

const std::vector<std::string> all_components = {component_names, component_names + 3};
constexpr const char* factor_sentence =
    "Rows [t, factor], linear between rows and held before and after; none: factor 1.";

Key group_key(const std::string& sentence) {
  return key::text("group", sentence);
}

KeyTable support_keys() {
  return {"support",
          "Nodes that do not move. A component of a group is fixed once.",
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
                        "Adds the columns moment_GROUP_z, in 3D moment_GROUP_x, ...: of the "
                        "reactions, at their present places, about the centre of the group's "
                        "facets, or points, before loading.")
               .or_else(SupportSettings{}.report_moment)}};
}

KeyTable prescribed_keys() {
  return {"prescribed",
          "One component of the displacement of a group as a function of time.",
          {group_key("Group of facets or points whose nodes are moved."),
           key::choice("component", all_components, "Component of the displacement."),
           key::number("rate", "m/s", "The displacement is this times t.").or_none(),
           time_table_key(
               "m", "Rows [t, displacement], linear between rows and held before and after.")},
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
                   "On nodes of beams, about fixed axes, the sum; in 2D one number, about z.")
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

KeyTable point_mass_keys() {
  KeyTable table{"point_mass",
                 "A mass at the node at a point, or in equal parts at the nodes of a group.",
                 place_keys("Group of facets or points whose nodes share the mass."),
                 {"point", "group"}};
  table.keys.push_back(
      key::number("mass", "kg", "The sum; in 2D per metre of thickness.").in(positive()));
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
                  "Along each axis, the sum; in 2D per metre of thickness; 0: none.")
          .in(non_negative()));
  return table;
}

KeyTable dashpot_keys() {
  KeyTable table{"dashpot",
                 "A linear dashpot from the node at a point to the ground, or in equal parts from "
                 "the nodes of a group; in a dynamic analysis, of coupled structures with the "
                 "scheme `newmark`.",
                 place_keys("Group of facets or points whose nodes share the damping."),
                 {"point", "group"}};
  table.keys.push_back(
      key::vector("damping", "N s/m",
                  "Along each axis, the sum; in 2D per metre of thickness; 0: none.")
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
          "Nodes that a node of beams takes with it as a rigid body: a beam that is clamped in "
          "cells, an end plate.",
          {key::text("beam", "Group of points: the one node of beams."),
           group_key("Group of facets or points whose nodes it takes along.")}};
}

KeyTable interface_keys() {
  return {
      "interface",
      "A wet surface that the coupler couples; no facet belongs to two, or twice to one.",
      {key::plain_name("As in coupler.json."),
       key::texts("groups", "Facet groups of the surface.").not_empty().or_none(),
       key::text("facets",
                 "File of the facets, rows of node numbers, normals outward as in Gmsh's order; "
                 "with `matrices`.")
           .or_none(),
       key::texts("beams",
                  "Groups of beams; the surface is the outline of their section along them, of "
                  "circles and pipes an octagon, in 2D the sides at half the height.")
           .not_empty()
           .or_none(),
       key::texts("behind",
                  "Groups of cells, or `all`: when such a cell is gone its facets leave the "
                  "surface, and faces behind it are wet. The soil's `surface` has the same.")
           .not_empty()
           .or_none()},
      {"groups", "facets", "beams"}};
}

KeyTable probe_keys() {
  return {"probe",
          "A point whose displacement is reported: that of the node there, or interpolated in the "
          "cell.",
          {key::plain_name("Its own; columns of the tables start with it."),
           key::vector("point", "m", "In the reference configuration.")}};
}

std::vector<Key> model_keys() {
  const std::vector<std::string> dynamic = {"dynamic"};
  return {
      key::integer("dimension", "Of space; 2 is plane strain.").in(between(2, 3)),
      key::object("mesh", mesh_keys(), "Mesh of the structure.").without("matrices"),
      key::object("material", cell_material_keys(), "Of all cells.")
          .without("matrices")
          .without("materials"),
      key::objects("materials", group_material_keys(),
                   "Each of a group of cells or lines, in place of `material`; each cell is in one "
                   "of the groups.")
          .or_none()
          .without("matrices"),
      key::object("matrices", matrix_keys(), "The structure as matrices, in place of a mesh.")
          .or_none(),
      key::choice("analysis", {"dynamic", "static"}, "`static`: without inertia.")
          .or_else("dynamic"),
      key::object("time_integration", newmark_keys("newmark"), "Scheme of the dynamic analysis.")
          .or_empty()
          .when("analysis", dynamic),
      key::choice("mass", {"consistent", "lumped"},
                  "`lumped`: row sums of the consistent mass matrix; of quadratic cells in "
                  "proportion to its diagonal.")
          .or_else("consistent")
          .when("analysis", dynamic)
          .without("matrices"),
      key::vector("gravity", "m/s^2", "Acceleration on all cells.").or_else(0).without("matrices"),
      key::vector("initial_velocity", "m/s",
                  "Of all free components; zero with `initial_equilibrium`.")
          .or_else(0)
          .when("analysis", dynamic),
      key::boolean("initial_equilibrium",
                   "Start at rest under gravity and the loads at time 0; needs `supports` or "
                   "`prescribed` in every direction.")
          .or_else(MotionSettings<2>{}.initial_equilibrium)};
}

std::vector<Key> condition_keys() {
  return {
      key::objects("supports", support_keys(),
                   "Held nodes; in statics and with `initial_equilibrium` in every direction, or "
                   "`prescribed`.")
          .or_empty()
          .without("matrices"),
      key::objects("prescribed", prescribed_keys(), "Moved nodes.").or_empty().without("matrices"),
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
      key::objects("rigid_links", rigid_link_keys(), "Nodes that beams take along.")
          .or_empty()
          .without("matrices"),
      key::objects("interfaces", interface_keys(), "Coupled surfaces.").or_empty(),
      key::objects("probes", probe_keys(), "Reported points.").or_empty(),
      key::objects("sections", section_keys(), "Planes whose force and moment are reported.")
          .or_empty()
          .without("matrices"),
      key::object("newton", newton_keys(newton_defaults), "Newton's method.")
          .or_empty()
          .without("matrices"),
      key::object("linear_solver", linear_solver_keys(), "Linear systems.")
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
