// SPDX-License-Identifier: BSD-3-Clause
#include <fmt/format.h>

#include <algorithm>
#include <utility>

#include "common/base/log.hpp"
#include "fem_solver/materials/cell_material.hpp"
#include "fem_solver/materials/line_material.hpp"
#include "fem_solver/materials/read_concrete.hpp"

namespace gabion::fem {

namespace {

const std::vector<std::string> laws_of_cells = {"linear_elastic", "neo_hookean", "hencky_elastic",
                                                "von_mises", "concrete"};
const std::vector<std::string> yielding = {"von_mises"};

std::vector<Key> yield_keys() {
  return {key::number("yield_stress", "Pa",
                      "Yield stress of uniaxial tension; either this or `yield_table`.")
              .in(positive())
              .or_none()
              .when("law", yielding),
          key::number("hardening_modulus", "Pa",
                      "Isotropic hardening: slope of the yield stress over the plastic strain; "
                      "with `yield_stress`.")
              .in(non_negative())
              .or_else(0)
              .when("law", yielding)
              .without("yield_table"),
          key::rows("yield_table", "-, Pa",
                    "Isotropic hardening: rows [plastic strain, yield stress], true stress over "
                    "logarithmic strain, the first at strain 0; linear between rows, held after.")
              .wide(2, 2)
              .not_empty()
              .or_none()
              .when("law", yielding),
          key::number("kinematic_modulus", "Pa",
                      "Kinematic hardening (Prager): slope of the stress over the plastic strain "
                      "in uniaxial tension.")
              .in(non_negative())
              .or_else(0)
              .when("law", yielding)};
}

KeyTable material_table(const std::string& name, const std::string& sentence) {
  KeyTable table = material_keys(elastic_laws);
  table.name = name;
  table.sentence = sentence;
  table.keys.front() = key::choice("law", laws_of_cells, "Law of the stress.");
  const auto yield = yield_keys();
  table.keys.insert(table.keys.end(), yield.begin(), yield.end());
  const auto concrete = concrete_keys();
  table.keys.insert(table.keys.end(), concrete.begin(), concrete.end());
  table.keys.push_back(key::object("rayleigh", rayleigh_keys(),
                                   "Damping of its cells, K elastic, before loading; in a dynamic "
                                   "analysis, of coupled structures with the scheme `newmark`.")
                           .or_none());
  table.keys.push_back(
      key::choice(
          "formulation", {"full", "enhanced", "reduced"},
          "`enhanced`: enhanced assumed strains, of quad4 and hex8: slender members bend "
          "as they should with one cell across, and nothing locks. `reduced`: 2 quadrature "
          "points along each axis, of quad8 and hex20: faster, and does not lock in plastic "
          "flow.")
          .or_else("full"));
  return table;
}

Hardening read_yield_table(ConfigReader& in) {
  std::vector<double> strains, stresses;
  const auto rows = in.rows("yield_table", 2);
  for (std::size_t i = 0; i < rows.size(); ++i) {
    const double strain = rows[i][0], stress = rows[i][1];
    const std::string row = fmt::format("yield_table/{}", i);
    if (!(stress > 0)) in.fail(row, fmt::format("found yield stress {}, allowed: > 0", stress));
    if (i == 0 && strain != 0) {
      in.fail(row, fmt::format("found plastic strain {}, allowed: 0 in the first row", strain));
    }
    if (i > 0 && !(strain > strains.back())) {
      in.fail(row, fmt::format("found plastic strain {} after {}, allowed: rising strains", strain,
                               strains.back()));
    }
    if (i > 0 && stress < stresses.back()) {
      in.fail(row,
              fmt::format("found yield stress {} after {}, allowed: no fall (softening depends "
                          "on the mesh)",
                          stress, stresses.back()));
    }
    strains.push_back(strain);
    stresses.push_back(stress);
  }
  return Hardening::table(std::move(strains), std::move(stresses));
}

Hardening read_hardening(ConfigReader& in) {
  if (in.has("yield_stress") == in.has("yield_table")) {
    in.fail("yield_stress", fmt::format("found {}, allowed: either \"yield_stress\" or "
                                        "\"yield_table\"",
                                        in.has("yield_table") ? "both" : "neither"));
  }
  if (!in.has("yield_table")) {
    return Hardening::linear(in.number("yield_stress"), in.number("hardening_modulus"));
  }
  if (in.has("hardening_modulus")) {
    in.fail("hardening_modulus", "has no meaning with \"yield_table\"");
  }
  return read_yield_table(in);
}

/// Warn of values that look like another unit.
void check_yield(const ConfigReader& in, const Hardening& hardening, double E, double H_k) {
  const std::string key = in.has("yield_table") ? "yield_table" : "yield_stress";
  const double first = hardening.yield_stress(0);
  if (first > 0.1 * E) {
    log::warn(
        "{}: found {} Pa, more than a tenth of young_modulus = {} Pa: metals yield at some "
        "thousandth; units?",
        in.where(key), first, E);
  } else if (first < 1e-6 * E) {
    log::warn(
        "{}: found {} Pa, less than a millionth of young_modulus = {} Pa: metals yield at "
        "some thousandth; in MPa?",
        in.where(key), first, E);
  }
  const double slope = hardening.flow(2 * first, 0, E).slope;
  if (std::max(slope, H_k) > E) {
    log::warn("{}: hardens by up to {} Pa, more than young_modulus = {} Pa; units?", in.where(key),
              std::max(slope, H_k), E);
  }
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
  return material_table("material", "Law of the stress and its constants.");
}

KeyTable group_material_keys() {
  KeyTable table =
      material_table("material_of_group", "Material of the cells or lines of a group.");
  std::vector<std::string> laws = laws_of_cells;
  laws.insert(laws.end(), line_laws.begin(), line_laws.end());
  table.keys.front() =
      key::choice("law", laws,
                  "Law of the stress; of lines `truss`, `cable` (slack where "
                  "shorter than without stress) or `brake` (a cable with a brake).");
  for (Key& key : table.keys) {
    if (key.name == "poisson_ratio" || key.name == "formulation" || key.name == "rayleigh") {
      key = key.when("law", laws_of_cells);
    }
  }
  const auto lines = line_keys();
  table.keys.insert(table.keys.end(), lines.begin(), lines.end());
  table.keys.insert(table.keys.begin(),
                    key::text("group",
                              "Group of cells, or of curves whose lines are cells: a "
                              "physical group of the mesh's file."));
  return table;
}

namespace {

Formulation formulation_of(const std::string& word) {
  if (word == "enhanced") return Formulation::enhanced;
  return word == "reduced" ? Formulation::reduced : Formulation::full;
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
  material.rayleigh = read_rayleigh(in);
  in.finish();
  return material;
}

template CellMaterial<2> read_cell_material<2>(ConfigReader, bool);
template CellMaterial<3> read_cell_material<3>(ConfigReader, bool);

}  // namespace gabion::fem
