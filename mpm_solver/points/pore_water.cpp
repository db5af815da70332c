// SPDX-License-Identifier: BSD-3-Clause
#include "mpm_solver/points/pore_water.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "common/base/log.hpp"
#include "mpm_solver/points/retention.hpp"

namespace gabion::mpm {

namespace {

// Grains of soil weigh about 2650 kg/m^3; outside this range the density is probably not that of
// saturated soil.
constexpr double lightest_grains = 2200, heaviest_grains = 3300;
// Density that follows from the grains and the one that is given may differ by this share.
constexpr double same_density = 1e-3;

// Warn where the water is not stiff beside the skeleton.
void warn_of_soft_water(const ConfigReader& in, const PoreWater& water, double skeleton_modulus) {
  const double ratio = water.modulus() / skeleton_modulus;
  if (ratio >= least_water_stiffness) return;
  log::warn(
      "{}: found {:g}; over the porosity it is {:.3g} times the P-wave modulus of the soil: the "
      "water carries only {:.3g} % of a confined load; from {:.3g} Pa on 95 %",
      in.where("bulk_modulus"), water.bulk_modulus, ratio, 100 * ratio / (1 + ratio),
      least_water_stiffness * skeleton_modulus * water.porosity);
}

// Check the density of the grains that follows from that of the saturated soil.
void check_grains(ConfigReader& in, const PoreWater& water, double saturated_density) {
  const double n = water.porosity;
  const double grains = water.dry_density(saturated_density) / (1 - n);
  if (!(grains > water.density)) {
    in.fail("porosity",
            fmt::format("found {:g} with the material's density {:g}, so grains of {:.4g} kg/m^3, "
                        "allowed: grains heavier than the water, {:g}; the density of a material "
                        "with \"water\" is that of the saturated soil",
                        n, saturated_density, grains, water.density));
  }
  if (const auto given = in.optional_number("grain_density")) {
    const double expected = (1 - n) * *given + n * water.density;
    if (std::abs(expected - saturated_density) > same_density * expected) {
      in.fail("grain_density",
              fmt::format("found {:g}, with which saturated soil of porosity {:g} has the density "
                          "{:.6g}, allowed: that of the material, {:g}",
                          *given, n, expected, saturated_density));
    }
  } else if (grains < lightest_grains || grains > heaviest_grains) {
    log::warn(
        "{}: found {:g} with the material's density {:g}, so grains of {:.4g} kg/m^3, where most "
        "soil has 2600 to 2800; the density of a material with \"water\" is that of the saturated "
        "soil",
        in.where("porosity"), n, saturated_density, grains);
  }
}

}  // namespace

double PoreWater::content_at(double p, double J) const {
  return pores(J) * retention_at(*this, p).filled;
}

PorePressure PoreWater::at(double content, double J) const {
  const double m = pores(J);
  if (content < m && gives_way(*this)) {
    return {retention_at(*this, water_pressure(*this, content, J)).borne, 0, 0};
  }
  const double opened = (m - content) / content;
  const double p = -bulk_modulus * std::log1p(opened);
  const auto energy_of = [&](double x) {
    return bulk_modulus * content * ((1 + x) * std::log1p(x) - x);
  };
  if (p >= -cavitation) return {p, bulk_modulus * J / m, energy_of(opened)};
  const double at_limit = std::expm1(cavitation / bulk_modulus);
  return {-cavitation, 0, energy_of(at_limit) + cavitation * content * (opened - at_limit)};
}

// (n / n0)^3 ((1 - n0) / (1 - n))^2 with n = 1 - (1 - n0) / J.
double PoreWater::mobility_ratio(double J) const {
  if (!kozeny_carman) return 1;
  const double m = pores(J) / porosity;
  return m * m * m / J;
}

double PoreWater::hydrostatic(double height) const {
  return table ? specific_weight * std::max(0.0, *table - height) : 0;
}

KeyTable pore_water_keys() {
  return {
      "water",
      "Pore water that has no time to drain: the material's `density` is then that of the "
      "saturated soil, and its law gives the effective stress. Needs `locking` `fbar`.",
      {key::number("porosity", "", "Volume of the pores over that of the soil, free of stress.")
           .in(inside(0, 1)),
       key::number("bulk_modulus", "Pa",
                   "Bulk modulus of the water, 2.2e9 without air. A smaller one allows longer "
                   "explicit steps; at least 20 times `porosity` times the P-wave modulus of the "
                   "soil.")
           .in(positive())
           .or_else(2.2e9),
       key::number("density", "kg/m^3", "Density of the water.").in(positive()).or_else(1000),
       key::number("cavitation_pressure", "Pa",
                   "Suction beyond which the water cavitates; 0: pores that open fill with air.")
           .in(non_negative())
           .or_else(0),
       key::number("grain_density", "kg/m^3",
                   "Density of the grains, to check that of the saturated soil, (1 - porosity) "
                   "grain_density + porosity density.")
           .in(positive())
           .or_none()}};
}

KeyTable body_water_keys() {
  KeyTable table = pore_water_keys();
  table.sentence =
      "Pore water: the material's `density` is then that of the saturated soil, and its law gives "
      "the effective stress. Water without `permeability` has no time to drain and needs `locking` "
      "`fbar`.";
  for (Key& each : table.keys) {
    if (each.name == "cavitation_pressure") each = each.without("permeability");
  }
  table.keys.push_back(
      key::number("permeability", "m/s",
                  "Hydraulic conductivity k, with which the water drains; none: it has no time to "
                  "drain. k is the intrinsic permeability [m^2] times 1e7 1/(m s). The grid must "
                  "be a `box` with `gimp` or `bspline`; explicit steps solve for the pressure by a "
                  "fractional step. Water leaves through the `free_surface` and walls that are "
                  "`drained`.")
          .in({.low = 0, .high = 1, .low_open = true, .allowed = "a number in (0, 1]"})
          .or_none());
  table.keys.push_back(
      key::choice("permeability_law", {"constant", "kozeny_carman"},
                  "`kozeny_carman`: `permeability` holds at `porosity` and changes with the "
                  "present porosity n as n^3 / (1 - n)^2.")
          .or_else("constant")
          .with("permeability"));
  table.keys.push_back(
      key::choice("free_surface", {"seepage_face", "impervious"},
                  "Surface of the soil in air. `seepage_face`: water under pressure leaves there, "
                  "none gets in. Soil has no such surface under another body, at walls and at "
                  "contact surfaces.")
          .or_else("seepage_face")
          .with("permeability"));
  table.keys.push_back(
      key::number(
          "suction_limit", "Pa",
          "Largest suction p_cav that the grains feel: rho_w g times the height of the capillary "
          "rise, at least times that of a cell. Air enters under a suction s: a share (1 + (s / "
          "p_cav)^2)^(-1/2) of the pores stays full, and the permeability falls with the cube of "
          "that share. None: pores stay full under any suction.")
          .in(positive())
          .or_none()
          .with("permeability"));
  return table;
}

namespace {

// Read pore water; water that drains bears any suction unless a limit is given.
PoreWater read_water(ConfigReader in, double saturated_density, double skeleton_modulus,
                     std::optional<double> permeability, PoreWater water = {}) {
  water.porosity = in.number("porosity");
  water.bulk_modulus = in.number("bulk_modulus");
  water.density = in.number("density");
  water.permeability = permeability.value_or(0);
  if (!permeability) water.cavitation = in.number("cavitation_pressure");
  check_grains(in, water, saturated_density);
  warn_of_soft_water(in, water, skeleton_modulus);
  in.finish();
  return water;
}

}  // namespace

PoreWater read_body_water(ConfigReader in, double saturated_density, double skeleton_modulus) {
  const std::optional<double> permeability = in.optional_number("permeability");
  PoreWater water;
  constexpr double inf = std::numeric_limits<double>::infinity();
  if (permeability && in.has("cavitation_pressure")) {
    in.fail("cavitation_pressure",
            "allowed only without \"permeability\": water that drains bears any suction, or less "
            "than \"suction_limit\"");
  }
  for (const char* key : {"permeability_law", "free_surface", "suction_limit"}) {
    if (!permeability && in.has(key)) {
      in.fail(key, "allowed only with \"permeability\": other water does not drain");
    }
  }
  if (permeability) {
    water.cavitation = in.optional_number("suction_limit").value_or(inf);
    water.kozeny_carman = in.choice("permeability_law") == "kozeny_carman";
    water.seepage_face = in.choice("free_surface") == "seepage_face";
  }
  return read_water(std::move(in), saturated_density, skeleton_modulus, permeability, water);
}

PoreWater read_pore_water(ConfigReader in, double saturated_density, double skeleton_modulus) {
  return read_water(std::move(in), saturated_density, skeleton_modulus, std::nullopt);
}

}  // namespace gabion::mpm
