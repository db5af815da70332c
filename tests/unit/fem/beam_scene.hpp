// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>

#include "tests/unit/fem/line_scene.hpp"

namespace gabion::test {

/// Shear areas [2], second moments [2] and torsion constant of a section of area 1.
inline Json general_section(double shear, double I, double torsion) {
  return {{"shape", "general"},
          {"area", 1},
          {"shear_areas", {shear, shear}},
          {"second_moments", {I, I}},
          {"torsion_constant", torsion}};
}

inline Json rectangle(double height, double width) {
  return {{"shape", "rectangle"}, {"height", height}, {"width", width}};
}

/// Material of the group "rope" of a chain.
inline Json beam_material(double E, double nu, const Json& section, double density = 1) {
  return {{"law", "beam"},       {"group", "rope"},    {"young_modulus", E},
          {"poisson_ratio", nu}, {"density", density}, {"cross_section", section}};
}

/// A support that holds all of a group.
inline Json clamp(int dimension, const std::string& group = "low") {
  const Json axes = dimension == 2 ? Json{"z"} : Json{"x", "y", "z"};
  return {
      {"group", group}, {"rotations", axes}, {"report_reaction", true}, {"report_moment", true}};
}

/// A cantilever along x, clamped at its low end, with a probe "tip".
inline Json cantilever_of_beams(int dimension, const std::string& file, const Json& material,
                                double length, const std::string& analysis = "static") {
  Json json = line_scene(dimension, file, material);
  json["analysis"] = analysis;
  json["supports"] = {clamp(dimension)};
  json["probes"] = {
      {{"name", "tip"}, {"point", dimension == 2 ? Json{length, 0.0} : Json{length, 0.0, 0.0}}}};
  return json;
}

/// A load on the high end that rises from 0 at 0 s to all of it at 1 s.
inline Json rising_load(const Json& force) {
  return {{"group", "high"}, {"force", force}, {"table", {{0, 0}, {1, 1}}}};
}

}  // namespace gabion::test
