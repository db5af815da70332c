// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "tests/support/gmsh_text.hpp"
#include "tests/unit/fem/fem_scene.hpp"

namespace gabion::test {

/// The tower of gmsh_text.hpp as two groups of cells, "lower" and "upper".
inline GmshText two_groups() {
  GmshText file = tower();
  file.groups = {{1, 1, "foot"}, {1, 2, "top"}, {2, 3, "lower"}, {2, 4, "upper"}};
  file.entities = {{1, 1, {1}}, {1, 2, {2}}, {2, 1, {3}}, {2, 2, {4}}};
  file.blocks = {{1, 1, 1, {{1, 2}}},
                 {1, 2, 1, {{5, 6}}},
                 {2, 1, 3, {{1, 2, 3, 4}}},
                 {2, 2, 3, {{4, 3, 5, 6}}}};
  return file;
}

/// Material that yields early.
inline Json yielding(double yield_stress = 1e3) {
  Json material = elastic("von_mises", 1e6, 0.3, 1000);
  material["yield_stress"] = yield_stress;
  material["hardening_modulus"] = 2e4;
  material["kinematic_modulus"] = 5e4;
  return material;
}

inline Json of_group(const std::string& group, Json material) {
  material["group"] = group;
  return material;
}

inline Json tower_scene(const std::string& file) {
  return {
      {"dimension", 2},
      {"mesh", {{"file", file}}},
      {"materials",
       {of_group("lower", yielding()), of_group("upper", elastic("neo_hookean", 2e6, 0.2, 500))}},
      {"supports", {{{"group", "foot"}}}},
      {"interfaces", {{{"name", "wall"}, {"groups", {"top"}}}}}};
}

}  // namespace gabion::test
