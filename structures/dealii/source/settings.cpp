// SPDX-License-Identifier: BSD-3-Clause
#include "settings.hpp"

#include <common/settings/config_reader.hpp>
#include <common/settings/json_text.hpp>

#include <filesystem>
#include <fstream>
#include <sstream>

namespace dealii_structure {

namespace {

using gabion::ConfigReader;
using gabion::Key;
using gabion::KeyTable;
namespace key = gabion::key;

Key groups_key() {
  return key::texts("groups",
                    "Sides of the box (left, right, front, back, bottom, top), or numbers of "
                    "physical groups of the mesh file.")
      .not_empty();
}

KeyTable box_keys() {
  return {"box",
          "Cells along the axes.",
          {key::vector("low", "m", "Lowest corner."), key::vector("high", "m", "Highest corner."),
           key::integers("cells", "Number along each axis.").in(gabion::at_least(1))}};
}

KeyTable mesh_keys() {
  return {"mesh",
          "Quadrilaterals or hexahedra.",
          {key::object("box", box_keys(), "A box.").or_none(),
           key::text("file", "Mesh of Gmsh, from structure.json.").or_none()},
          {"box", "file"}};
}

KeyTable refinement_keys() {
  return {
      "refinement",
      "Cells near a point are halved in each direction, before the first step.",
      {key::vector("near", "m", "The point."),
       key::number("radius", "m", "Radius within which a vertex or the centre of such a cell lies.")
           .in(gabion::positive()),
       key::integer("times", "Number of times.").in(gabion::between(1, 8)).or_else(1)}};
}

KeyTable material_keys() {
  return {"material",
          "Neo-Hookean law: tau = mu (b - 1) + lambda ln J 1.",
          {key::number("density", "kg/m^3", "Value in the reference configuration.")
               .in(gabion::positive()),
           key::number("young_modulus", "Pa", "Value at small strain.").in(gabion::positive()),
           key::number("poisson_ratio", "", "Value at small strain.")
               .in(gabion::inside(-1, 0.5))
               .or_else(0)}};
}

KeyTable support_keys() {
  return {"support",
          "Nodes that do not move.",
          {groups_key(), key::texts("components", "Components of the displacement that are zero.")
                             .among({"x", "y", "z"})
                             .not_empty()
                             .or_computed("all")}};
}

KeyTable interface_keys() {
  return {"interface",
          "A coupled surface.",
          {key::plain_name("Name, as in coupler.json."), groups_key()}};
}

KeyTable probe_keys() {
  return {"probe",
          "A point whose displacement is reported.",
          {key::plain_name("Name of the probe, unique."),
           key::vector("point", "m", "Place in the reference configuration.")}};
}

KeyTable newton_keys() {
  return {"newton",
          "Newton's method.",
          {key::number("tolerance", "",
                       "Largest residual over the largest of load, internal and inertia forces.")
               .in(gabion::inside(0, 1))
               .or_else(NewtonSettings{}.tolerance),
           key::integer("max_iterations", "Number of iterations after which a step has failed.")
               .in(gabion::at_least(1))
               .or_else(NewtonSettings{}.max_iterations)}};
}

KeyTable table() {
  return {
      "structure",
      "Settings of the structure.",
      {key::schema(),
       key::integer("dimension", "Dimension of space; 2 is plane strain.")
           .in(gabion::between(2, 3)),
       key::object("mesh", mesh_keys(), "Mesh."),
       key::integer("degree", "Degree of the shape functions.")
           .in(gabion::between(1, 4))
           .or_else(2),
       key::objects("refine", refinement_keys(), "Local refinement.").or_empty(),
       key::object("material", material_keys(), "Material of all cells."),
       key::vector("gravity", "m/s^2", "Acceleration of all cells.").or_else(0),
       key::number("alpha", "", "Alpha of Bossak's scheme; 0 is the trapezoidal rule.")
           .in(gabion::between(-1.0 / 3, 0))
           .or_else(0),
       key::boolean("initial_equilibrium",
                    "Whether the run starts in equilibrium with gravity, at rest.")
           .or_else(false),
       key::objects("supports", support_keys(), "Nodes that do not move.").or_empty(),
       key::objects("interfaces", interface_keys(), "Coupled surfaces.").not_empty(),
       key::objects("probes", probe_keys(), "Points whose displacement is reported.").or_empty(),
       key::object("newton", newton_keys(), "Newton's method.").or_empty()}};
}

void read_mesh(ConfigReader in, const std::string& path, Settings& out) {
  if (auto box = in.optional_object("box")) {
    out.box = {box->vector("low", out.dimension), box->vector("high", out.dimension),
               box->integers("cells", out.dimension)};
    for (int i = 0; i < out.dimension; ++i) {
      if (!(out.box.low[i] < out.box.high[i])) box->fail("high", "has to be above low");
    }
    box->finish();
  }
  if (in.has("file")) {
    out.mesh_file = (std::filesystem::path(path).parent_path() / in.text("file")).string();
  }
  in.finish();
}

void read_refinements(ConfigReader& in, Settings& out) {
  for (auto& each : in.objects("refine")) {
    out.refinements.push_back(
        {each.vector("near", out.dimension), each.number("radius"), each.integer("times")});
    each.finish();
  }
}

void read_solid(ConfigReader& in, Settings& out) {
  auto material = in.object("material");
  out.material = {material.number("density"), material.number("young_modulus"),
                  material.number("poisson_ratio")};
  material.finish();
  out.gravity = in.vector("gravity", out.dimension);
  out.alpha = in.number("alpha");
  out.initial_equilibrium = in.boolean("initial_equilibrium");
  for (auto& each : in.objects("supports")) {
    const std::vector<std::string> all = {"x", "y", "z"};
    SupportSettings support{
        each.texts("groups"),
        each.texts_or("components", {all.begin(), all.begin() + out.dimension})};
    for (const auto& component : support.components) {
      if (component == "z" && out.dimension == 2) {
        each.fail("components", "found \"z\", allowed in 2D: \"x\", \"y\"");
      }
    }
    each.finish();
    out.supports.push_back(support);
  }
  if (out.initial_equilibrium && out.supports.empty()) {
    in.fail("initial_equilibrium", "found true without supports, allowed: with supports");
  }
}

void read_surfaces(ConfigReader& in, Settings& out) {
  for (auto& each : in.objects("interfaces")) {
    out.interfaces.push_back({each.name("name"), each.texts("groups")});
    each.finish();
  }
  for (auto& each : in.objects("probes")) {
    out.probes.push_back({each.name("name"), each.vector("point", out.dimension)});
    each.finish();
  }
}

std::string text_of(const std::string& path) {
  const std::ifstream file(path);
  if (!file) throw gabion::ConfigError(path + ": cannot be read");
  std::ostringstream text;
  text << file.rdbuf();
  return text.str();
}

}  // namespace

Settings read_settings(const std::string& path) {
  Settings out;
  const KeyTable keys = table();
  ConfigReader in(gabion::parse_settings(text_of(path), path), path, keys);
  (void)in.has("$schema");
  out.dimension = in.integer("dimension");
  read_mesh(in.object("mesh"), path, out);
  out.degree = in.integer("degree");
  read_refinements(in, out);
  read_solid(in, out);
  read_surfaces(in, out);
  auto newton = in.object("newton");
  out.newton = {newton.number("tolerance"), newton.integer("max_iterations")};
  newton.finish();
  in.finish();
  out.model = in.resolved();
  out.model.erase("probes");
  return out;
}

}  // namespace dealii_structure
