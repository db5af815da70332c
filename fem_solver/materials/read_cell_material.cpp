// SPDX-License-Identifier: BSD-3-Clause
#include <fmt/format.h>

#include <string>
#include <variant>
#include <vector>

#include "fem_solver/materials/cell_material.hpp"
#include "fem_solver/materials/line_material.hpp"
#include "fem_solver/materials/membrane_material.hpp"
#include "fem_solver/materials/read_concrete.hpp"
#include "fem_solver/materials/read_hardening.hpp"

namespace gabion::fem {

namespace {

const std::vector<std::string> laws_of_cells = {"linear_elastic", "neo_hookean", "hencky_elastic",
                                                "von_mises", "concrete"};

/// @param yielding  laws with a yield stress
KeyTable material_table(const std::string& name, const std::string& sentence,
                        const std::vector<std::string>& yielding) {
  KeyTable table = material_keys(elastic_laws);
  table.name = name;
  table.sentence = sentence;
  table.keys.front() = key::choice("law", laws_of_cells, "Law of the stress.");
  const auto yield = yield_keys(yielding);
  table.keys.insert(table.keys.end(), yield.begin(), yield.end());
  const auto concrete = concrete_keys();
  table.keys.insert(table.keys.end(), concrete.begin(), concrete.end());
  table.keys.push_back(key::object("rayleigh", rayleigh_keys(),
                                   "Damping of its cells, with the elastic K before loading. In a "
                                   "dynamic analysis only; in coupled structures with the scheme "
                                   "`newmark` only.")
                           .or_none());
  table.keys.push_back(
      key::choice(
          "formulation", {"full", "enhanced", "reduced", "solid_shell"},
          "`enhanced` (quad4, hex8): enhanced assumed strains; slender members bend correctly with "
          "one cell across, and nothing locks. `reduced` (quad8, hex20): 2 quadrature points along "
          "each axis; faster, and free of locking in plastic flow. `solid_shell` (hex8): plates "
          "and shells, curved and twisted too, bend correctly with one cell across; laws that "
          "yield have 6 points across, others 2.")
          .or_else("full"));
  table.keys.push_back(
      key::choice("thickness", {"shortest", "numbering", "side"},
                  "Direction of the thickness of a cell. `shortest`: along its shortest axis, of "
                  "at most half the others. `numbering`: from its first four nodes to the last "
                  "four, as layers that Gmsh extrudes are numbered. `side`: across the facets of "
                  "`thickness_side`.")
          .or_else("shortest")
          .when("formulation", {"solid_shell"}));
  table.keys.push_back(key::text("thickness_side",
                                 "Group of facets on one side of the shell or on both, one or two "
                                 "facets a cell.")
                           .when("formulation", {"solid_shell"})
                           .when("thickness", {"side"}));
  return table;
}

template <int dim>
VonMises<dim> read_von_mises(ConfigReader& in, double lambda, double mu) {
  VonMises<dim> law{.lambda = lambda,
                    .mu = mu,
                    .kinematic_modulus = in.number("kinematic_modulus"),
                    .hardening = read_hardening(in)};
  const double E = mu * (3 * lambda + 2 * mu) / (lambda + mu);
  check_yield(in, law.hardening, E, law.kinematic_modulus);
  return law;
}

}  // namespace

KeyTable cell_material_keys() {
  KeyTable table =
      material_table("material", "Law of the stress and its constants.", {"von_mises"});
  const auto failure = failure_keys(/*lines=*/false);
  table.keys.insert(table.keys.end(), failure.begin(), failure.end());
  return table;
}

KeyTable group_material_keys() {
  KeyTable table = material_table("material_of_group", "Material of the cells or lines of a group.",
                                  {"von_mises", "bar", "beam"});
  std::vector<std::string> laws = laws_of_cells;
  laws.insert(laws.end(), line_laws.begin(), line_laws.end());
  table.keys.front() =
      key::choice("law", laws,
                  "Law of the stress. Laws of lines: `truss`, `cable` (slack when shorter than "
                  "without stress), `brake` (a cable with a brake), `bar` (a truss that yields: "
                  "reinforcement) or `beam` (it bends, shears and twists).");
  std::vector<std::string> with_ratio = laws_of_cells;
  with_ratio.push_back("beam");
  for (Key& key : table.keys) {
    if (key.name == "poisson_ratio") key = key.when("law", with_ratio);
    if (key.name == "formulation" || key.name == "rayleigh" || key.name.starts_with("thickness")) {
      key = key.when("law", laws_of_cells);
    }
    if (key.name == "formulation") {
      key.words.push_back("membrane");
      key.sentence +=
          " `membrane`: surface cells in space (tri3, quad4), a group of facets or of surfaces of "
          "no cell, with stress in their plane alone; law `linear_elastic`, linear in the Green "
          "strain.";
    }
  }
  for (const auto& keys :
       {membrane_keys(), line_keys(), beam_keys(), failure_keys(/*lines=*/true)}) {
    table.keys.insert(table.keys.end(), keys.begin(), keys.end());
  }
  table.keys.insert(
      table.keys.begin(),
      key::text("group",
                "Group of cells, of curves whose lines are cells, or of surfaces of a "
                "membrane: a "
                "physical group of the mesh's file."));
  return table;
}

namespace {

Formulation formulation_of(const std::string& word) {
  if (word == "enhanced") return Formulation::enhanced;
  if (word == "solid_shell") return Formulation::solid_shell;
  return word == "reduced" ? Formulation::reduced : Formulation::full;
}

template <int dim>
void read_thickness(ConfigReader& in, CellMaterial<dim>& material) {
  if (material.formulation != Formulation::solid_shell) return;
  const std::string word = in.choice("thickness");
  material.thickness_where = in.where("thickness");
  if (word == "numbering") material.thickness = Thickness::numbering;
  if (word != "side") return;
  material.thickness = Thickness::side;
  material.thickness_side = in.text("thickness_side");
  material.thickness_where = in.where("thickness_side");
}

/// Refuse a limit at which the concrete would fail before its strength.
template <int dim>
void check_crushing_limit(const ConfigReader& in, const Concrete<dim>& law,
                          const FailureLimits& limits) {
  const double at_strength = law.crushing.strain_at_strength;
  if (!limits.crushing_strain || *limits.crushing_strain > at_strength) return;
  in.fail("failure_crushing_strain",
          fmt::format("found {:.6g}, allowed: above \"strain_at_strength\" = {:.6g}, where the "
                      "concrete has its strength",
                      *limits.crushing_strain, at_strength));
}

}  // namespace

template <int dim>
CellMaterial<dim> read_cell_material(ConfigReader in, bool of_group) {
  CellMaterial<dim> material;
  material.where = in.where(of_group ? "group" : "law");
  if (of_group) material.group = in.text("group");
  material.law_name = in.choice("law");
  material.density = in.number("density");
  const double E = in.number("young_modulus"), nu = in.number("poisson_ratio");
  const double lambda = E * nu / ((1 + nu) * (1 - 2 * nu)), mu = E / (2 * (1 + nu));
  if (material.law_name == "linear_elastic") {
    material.law = LinearElastic<dim>{lambda, mu};
  } else if (material.law_name == "neo_hookean") {
    material.law = NeoHookean<dim>{lambda, mu};
  } else if (material.law_name == "hencky_elastic") {
    material.law = HenckyElastic<dim>{lambda, mu};
  } else if (material.law_name == "concrete") {
    material.law = read_concrete<dim>(in, lambda, mu);
  } else {
    material.law = read_von_mises<dim>(in, lambda, mu);
  }
  material.formulation = formulation_of(in.choice("formulation"));
  read_thickness(in, material);
  material.rayleigh = read_rayleigh(in);
  material.failure = read_failure(in, material.law_name);
  if (const auto* law = std::get_if<Concrete<dim>>(&material.law)) {
    check_crushing_limit(in, *law, material.failure);
  }
  if (material.failure.any() && material.rayleigh.stiffness > 0) {
    in.fail("rayleigh",
            "found damping by stiffness of cells that may fail: it would still hold the parts "
            "around a failed cell; allowed: damping by mass alone, or no limits of failure");
  }
  in.finish();
  return material;
}

template CellMaterial<2> read_cell_material<2>(ConfigReader, bool);
template CellMaterial<3> read_cell_material<3>(ConfigReader, bool);

}  // namespace gabion::fem
