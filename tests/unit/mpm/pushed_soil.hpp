// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "tests/unit/mpm/mpm_scene.hpp"

namespace gabion::test {

/// Soil on a base that a plate pushes from the left.
inline Json pushed() {
  Json material = elastic_soil("mohr_coulomb", 1e5, 0.3, 1000);
  material["friction_angle"] = 30;
  return {{"dimension", 2},
          {"grid", box({0, 0}, {2, 1}, {8, 4}, "tri3")},
          {"basis", "linear"},
          {"walls", {wall("bottom", "fixed")}},
          {"gravity", {0, -9.81}},
          {"bodies", {body("soil", box({0.5, 0}, {1.5, 0.5}, {8, 4}, "tri3"), 3, material)}},
          {"interfaces",
           {{{"name", "plate"},
             {"surface", {{"polyline", {{0.5, 0}, {0.5, 0.5}}}, {"spacing", 0.25}}}}}}};
}

/// The plate turned into the soil: its upper end moves by `push`, its lower end by half of it.
inline InterfaceValues plate_at(double push) {
  return {{"plate", {0.5 * push, 0, 0.75 * push, 0, push, 0}}};
}

}  // namespace gabion::test
