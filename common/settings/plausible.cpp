// SPDX-License-Identifier: BSD-3-Clause
#include "common/settings/plausible.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <optional>

#include "common/base/log.hpp"

namespace gabion {

namespace {

struct OtherUnit {
  const char* name;
  double factor;  // factor from it to the unit of the key
};

/// Plausible values of a key: from `low` to `high`, of a vector its length.
struct PlausibleRange {
  const char* key;  // end of its pointer, without the numbers of lists
  double low, high;
  const char* unit;
  const char* below;  // what a smaller value is
  const char* above;  // what a larger value is
  std::vector<OtherUnit> others;
};

const std::vector<OtherUnit> pressures = {{"kPa", 1e3}, {"MPa", 1e6}, {"GPa", 1e9}};
const std::vector<OtherUnit> viscosities = {{"mPa s^n", 1e-3}, {"kPa s^n", 1e3}};
const std::vector<OtherUnit> plain_viscosities = {{"mPa s", 1e-3}, {"kPa s", 1e3}};
const std::vector<OtherUnit> densities = {
    {"t/m^3", 1e3}, {"kN/m^3", 1e3 / 9.81}, {"t/mm^3", 1e12}, {"kg/mm^3", 1e9}};
const std::vector<OtherUnit> accelerations = {{"cm/s^2", 1e-2}, {"mm/s^2", 1e-3}};
const std::vector<OtherUnit> lengths = {{"mm", 1e-3}};
const std::vector<OtherUnit> speeds = {{"mm/s", 1e-3}};
const std::vector<OtherUnit> angles = {{"radians", 180 / std::numbers::pi}};

const std::vector<PlausibleRange> of_both = {
    {"gravity", 0.5, 500, "m/s^2", "weaker than on the moon", "stronger than in most centrifuges",
     accelerations},
    {"friction", 0, 2, "", "", "an angle? The coefficient is its tangent", {}},
    {"velocity", 0, 500, "m/s", "", "faster than any slide", speeds},
};

const std::vector<PlausibleRange> of_soil = {
    {"material/density", 100, 5000, "kg/m^3", "lighter than any soil", "heavier than any soil",
     densities},
    {"material/young_modulus", 1e4, 1e12, "Pa", "softer than any soil", "stiffer than any rock",
     pressures},
    {"material/friction_angle", 2, 60, "degrees", "less than any soil has",
     "more than any soil has", angles},
    {"material/cohesion", 20, 1e9, "Pa", "next to none", "more than any rock has", pressures},
    {"softening/residual_friction_angle", 2, 60, "degrees", "less than any soil has",
     "more than any soil has", angles},
    {"softening/slip", 1e-4, 10, "m", "less than a grain", "more than soil softens over", lengths},
    {"softening/remoulding_slip", 1e-3, 1e3, "m", "less than remoulds any clay",
     "more than remoulds any clay", lengths},
    {"softening/residual_cohesion", 20, 1e9, "Pa", "next to none", "more than any rock has",
     pressures},
    {"softening/remoulded_cohesion", 5, 1e6, "Pa", "next to none", "more than any clay has",
     pressures},
    {"material/yield_stress", 0.1, 1e5, "Pa", "next to none", "more than any mud has", pressures},
    {"material/consistency", 1e-4, 1e6, "Pa s^n", "thinner than water", "thicker than any mud",
     viscosities},
    {"material/sound_speed", 1, 3000, "m/s", "slower than most flows", "faster than in water",
     speeds},
    {"material/viscosity", 1e-4, 1e6, "Pa s", "thinner than water", "thicker than any mud",
     plain_viscosities},
    {"material/compression_index",
     0.003,
     0.6,
     "",
     "stiffer than most soil",
     "softer than peat",
     {}},
    {"material/swelling_index", 0.0003, 0.2, "", "stiffer than most soil", "softer than peat", {}},
    {"material/critical_state_ratio",
     0.3,
     2,
     "",
     "less than any soil has",
     "more than any soil has",
     {}},
    {"material/reference_pressure", 1e3, 1e8, "Pa", "less than a decimetre of soil weighs",
     "more than any slide weighs", pressures},
    {"turbulent_drag",
     0.1,
     400,
     "Pa s^2/m^2",
     "next to none",
     "rougher than any bed: it is rho g / xi of Voellmy, not xi",
     {}},
    {"weakening_speed",
     1e-3,
     30,
     "m/s",
     "below the speed of any slide: friction is that of speed almost at once",
     "faster than a slide: friction stays that of rest",
     {}},
    {"material/static_friction",
     0.05,
     1.5,
     "",
     "less than any grains have",
     "more than any grains have",
     {}},
    {"material/limit_friction",
     0.05,
     2,
     "",
     "less than any grains have",
     "more than any grains have",
     {}},
    {"material/inertial_number",
     0.01,
     10,
     "",
     "less than any grains have",
     "more than any grains have",
     {}},
    {"material/grain_size", 1e-6, 5, "m", "finer than silt", "larger than boulders", lengths},
    {"material/grain_density", 900, 8000, "kg/m^3", "lighter than ice", "heavier than steel",
     densities},
    {"boulders/density", 500, 8000, "kg/m^3", "lighter than any rock", "heavier than steel",
     densities},
    {"water/porosity", 0.2, 0.7, "", "less than most soil has", "more than most soil has", {}},
    {"water/bulk_modulus", 1e6, 5e9, "Pa", "softer than water with much air", "stiffer than water",
     pressures},
    {"water/density", 900, 1300, "kg/m^3", "lighter than water", "heavier than brine", densities},
    {"water/grain_density", 2200, 3300, "kg/m^3", "lighter than most grains",
     "heavier than most grains", densities},
    {"water/permeability",
     1e-11,
     1,
     "m/s",
     "less than clay has",
     "more than gravel has",
     {{"m^2", 1e7}}},
    {"rain/rate",
     1e-9,
     1e-4,
     "m/s",
     "less than any rain",
     "more than any rain of an hour",
     {{"mm/h", 1 / 3.6e6}}},
    {"water/cavitation_pressure", 100, 1e6, "Pa", "next to none", "more than pore water bears",
     pressures},
};

const PlausibleRange structure_density = {"material/density",
                                          10,
                                          25000,
                                          "kg/m^3",
                                          "lighter than any building material",
                                          "heavier than any building material",
                                          densities};
const PlausibleRange structure_stiffness = {"material/young_modulus",
                                            1e4,
                                            2e12,
                                            "Pa",
                                            "softer than rubber or any building material",
                                            "stiffer than any building material",
                                            pressures};

/// The range of one key, for another key.
PlausibleRange also_of(PlausibleRange range, const char* key) {
  range.key = key;
  return range;
}

const std::vector<PlausibleRange> of_structure = {
    structure_density, structure_stiffness, also_of(structure_density, "materials/density"),
    also_of(structure_stiffness, "materials/young_modulus")};

/// Length of a vector, size of a number; none of anything else.
std::optional<double> size_of(const Json& value) {
  if (value.is_number()) return std::abs(value.get<double>());
  if (!value.is_array() || value.empty()) return std::nullopt;
  double squares = 0;
  for (const Json& component : value) {
    if (!component.is_number()) return std::nullopt;
    squares += component.get<double>() * component.get<double>();
  }
  return std::sqrt(squares);
}

/// The value in units in which it would be plausible.
std::string other_units(const PlausibleRange& range, double size) {
  std::vector<std::string> words;
  for (const OtherUnit& other : range.others) {
    const double value = size * other.factor;
    if (value < range.low || value > range.high) continue;
    words.push_back(fmt::format("in {} it would be {:.3g} {}", other.name, value, range.unit));
  }
  return words.empty() ? "" : fmt::format("; {}", fmt::join(words, ", "));
}

class Search {
 public:
  Search(const ConfigReader& in, Described described) : in_(in) {
    const auto& own = described == Described::soil ? of_soil : of_structure;
    for (const auto* table : {&of_both, &own}) {
      for (const PlausibleRange& range : *table) ranges_.push_back(&range);
    }
    visit(in.resolved(), "", "");
  }
  std::vector<std::string> texts;

 private:
  /// @param pointer  of the value, such as "bodies/0/material"
  /// @param keys     the pointer without numbers, with "/" in front
  void visit(const Json& value, const std::string& pointer, const std::string& keys) {
    for (const PlausibleRange* range : ranges_) {
      if (keys.ends_with(std::string("/") + range->key)) compare(*range, value, pointer);
    }
    const std::string below = pointer.empty() ? "" : pointer + "/";
    if (value.is_object()) {
      for (const auto& [key, member] : value.items()) visit(member, below + key, keys + "/" + key);
    } else if (value.is_array()) {
      for (std::size_t k = 0; k < value.size(); ++k) {
        if (value[k].is_object()) visit(value[k], below + std::to_string(k), keys);
      }
    }
  }

  void compare(const PlausibleRange& range, const Json& value, const std::string& pointer) {
    const auto size = size_of(value);
    if (!size || *size == 0 || (*size >= range.low && *size <= range.high)) return;
    texts.push_back(fmt::format(
        "{}: found {}{}{}, {}{}", in_.where(pointer), value.dump(), *range.unit == '\0' ? "" : " ",
        range.unit, *size < range.low ? range.below : range.above, other_units(range, *size)));
  }

  const ConfigReader& in_;
  std::vector<const PlausibleRange*> ranges_;
};

}  // namespace

std::vector<std::string> implausible_settings(const ConfigReader& in, Described described) {
  return Search(in, described).texts;
}

void warn_of_implausible_settings(const ConfigReader& in, Described described) {
  for (const std::string& text : implausible_settings(in, described)) log::warn("{}", text);
}

}  // namespace gabion
