// SPDX-License-Identifier: BSD-3-Clause
// Keys of the initial stress, and what they ask of the body.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <utility>
#include <variant>
#include <vector>

#include "common/base/log.hpp"
#include "common/mechanics/mesh/mesh_box.hpp"
#include "mpm_solver/points/initial_stress.hpp"

namespace gabion::mpm {

namespace {

template <int dim>
double normally_consolidated(ConfigReader& in, const Body<dim>& body, double elastic) {
  const Material<dim>& material = body.material;
  if (!in.is_text("k0")) return in.number("k0");
  if (in.choice("k0") == "elastic") return elastic;
  const double angle = std::visit(
      [](const auto& model) {
        if constexpr (requires { model.friction_angle(); }) {
          return model.friction_angle();
        } else if constexpr (requires { model.parameters().friction_angle; }) {
          return model.parameters().friction_angle;
        } else {
          return 0.0;
        }
      },
      material.law);
  if (std::ranges::find(body.varying, "friction_angle") != body.varying.end()) {
    in.fail("k0",
            "found \"jaky\" with a friction_angle that varies, allowed: a number, or \"elastic\"");
  }
  if (angle <= 0) {
    in.fail("k0",
            fmt::format("found \"jaky\" with the law {}, allowed: a law with a friction angle",
                        material.law_name));
  }
  return 1 - std::sin(angle);
}

// Keys of a body with pore water.
std::vector<Key> water_keys() {
  return {
      key::number("water_table", "m",
                  "Height of the level water table; at most `surface`, or the level of the "
                  "`pools` over it. Below it the soil is saturated, with hydrostatic pressure and "
                  "K0 of the effective stress; above it it is dry.")
          .or_none()
          .only("where the body has `water`, and then required if `pore_pressure` is `at_rest`"),
      key::choice(
          "pore_pressure", {"at_rest", "steady_seepage"},
          "`at_rest`: that of water at rest below `water_table`. `steady_seepage`: that of "
          "the steady flow that pools, `drained` walls, `inflow`, rain and the free surface "
          "of the start keep up; `water_table`, at any height, is then the level beyond "
          "`drained` walls, where there are no `pools`, and none means no pressure there. "
          "All pores are full but for a `suction_limit`, and all bodies that drain have it.")
          .or_else("at_rest")
          .only("where the `water` of the body has a `permeability`"),
      key::number("saturation_above", "",
                  "Share of the pores above the water table that hold water; it has weight but no "
                  "pressure.")
          .in({.low = 0, .high = 1, .high_open = true, .allowed = "a number in [0, 1)"})
          .or_else(0)
          .only("where the body has `water`")};
}

}  // namespace

KeyTable initial_stress_keys() {
  KeyTable table = {
      "initial_stress",
      "Geostatic stress below a level surface. Needs gravity against the last axis, present from "
      "the start, and a law other than neo_hookean. It must be in balance: the soil does not yield "
      "under it.",
      {key::number("k0", "", "Horizontal over vertical stress of normally consolidated soil.")
           .in(non_negative()),
       key::choice("k0", {"elastic", "jaky"},
                   "`elastic`: nu / (1 - nu); `jaky`: 1 - sin(phi), with a law that has phi."),
       key::number(
           "surface", "m",
           "Height of the surface; no point lies above it. For a body under layers of other "
           "densities: the height up to which soil of its own density would weigh as much as they "
           "do."),
       key::number("ocr", "",
                   "Over-consolidation ratio; unloading is elastic: K0 = ocr k0 - (ocr - 1) nu / "
                   "(1 - nu).")
           .in(at_least(1))
           .or_else(1)}};
  for (Key& key : water_keys()) table.keys.push_back(std::move(key));
  table.keys.push_back(
      key::number("max_displacement", "",
                  "Largest initial displacement that is accepted, over the mean cell size. It is "
                  "the one that would balance the initial stress.")
          .in(positive())
          .or_else(InitialStress{}.max_displacement));
  return table;
}

namespace {

// Read the settings that only a body with pore water has.
template <int dim>
void read_water_table(ConfigReader& in, const Body<dim>& body, InitialStress& stress) {
  const bool has_water = body.water.has_value();
  for (const char* key : {"water_table", "saturation_above", "pore_pressure"}) {
    if (!has_water && in.has(key)) {
      in.fail(key, "found without pore water, allowed: only where the body has \"water\"");
    }
  }
  if (!has_water) return;
  stress.water_table = in.optional_number("water_table");
  stress.steady_seepage = in.choice("pore_pressure") == "steady_seepage";
  if (stress.steady_seepage) {
    stress.where_pressure = in.where("pore_pressure");
    if (!body.water->drains()) {
      in.fail("pore_pressure",
              "found \"steady_seepage\" with \"water\" without \"permeability\", which does not "
              "flow, allowed: \"at_rest\"");
    }
    if (in.has("saturation_above")) {
      in.fail("saturation_above",
              "found with \"steady_seepage\", allowed: none; pores are full, or as full as "
              "\"suction_limit\" of the \"water\" has them");
    }
    return;
  }
  if (!stress.water_table) {
    in.fail("water_table",
            "found none, but the body has \"water\", allowed: the height of its water table");
  }
  stress.saturation_above = in.number("saturation_above");
}

}  // namespace

template <int dim>
InitialStress read_initial_stress(ConfigReader in, const Body<dim>& body) {
  const Material<dim>& material = body.material;
  if (std::holds_alternative<NeoHookean<dim>>(material.law)) {
    in.fail("k0", fmt::format("found with the law {}, allowed: linear_elastic or a law with "
                              "Hencky's elasticity",
                              material.law_name));
  }
  InitialStress stress;
  const double lambda = first_lame_constant(material.law), mu = shear_modulus(material.law);
  const double elastic = lambda / (lambda + 2 * mu);
  stress.where = in.where("k0");
  stress.where_surface = in.where("surface");
  stress.k0 = normally_consolidated(in, body, elastic);
  stress.k0_consolidated = stress.k0;
  stress.ocr = in.number("ocr");
  stress.k0 = stress.ocr * stress.k0 - (stress.ocr - 1) * elastic;
  stress.surface = in.number("surface");
  stress.max_displacement = in.number("max_displacement");
  read_water_table(in, body, stress);
  in.finish();
  return stress;
}

// Refuse a body whose own surface lies under water without a pool that presses on it. The surface
// of a layer under layers of other densities is not its own.
template <int dim>
void take_water_table(const ConfigReader& in, const Mesh<dim>& mesh, const InitialStress& stress,
                      const PoolLevels& pools, Body<dim>& body) {
  if (!stress.water_table) return;
  const double table = *stress.water_table;
  if (stress.steady_seepage) {  // the level beyond drained walls alone
    body.water->table = table;
    return;
  }
  const auto box = box_around(mesh);
  const double top = box.max()[dim - 1], bottom = box.min()[dim - 1];
  const double rounding = 1e-9 * (top - bottom);
  if (table > stress.surface && stress.surface <= top + rounding) {
    if (pools.empty()) {
      in.fail("water_table",
              fmt::format("found {:g}, a pool over the surface of the body, {:g}; allowed: at most "
                          "\"surface\", or with \"pools\"",
                          table, stress.surface));
    }
    for (const double x : {box.min()[0], box.max()[0]}) {
      if (std::abs(pools.level(x) - table) <= rounding) continue;
      in.fail("water_table",
              fmt::format("found {:g}, above the surface of the body, where the pool at x = {:g} "
                          "begins with the level {:g}, allowed: that level",
                          table, x, pools.level(x)));
    }
  }
  if (table <= bottom) {
    log::warn(
        "{}: found {:g}, below the whole body, whose lowest point is at {:g}: the body is dry",
        in.where("water_table"), table, bottom);
  }
  body.water->table = table;
}

template InitialStress read_initial_stress<2>(ConfigReader, const Body<2>&);
template InitialStress read_initial_stress<3>(ConfigReader, const Body<3>&);
template void take_water_table<2>(const ConfigReader&, const Mesh<2>&, const InitialStress&,
                                  const PoolLevels&, Body<2>&);
template void take_water_table<3>(const ConfigReader&, const Mesh<3>&, const InitialStress&,
                                  const PoolLevels&, Body<3>&);

}  // namespace gabion::mpm
