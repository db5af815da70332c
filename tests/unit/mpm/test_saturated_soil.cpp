// SPDX-License-Identifier: BSD-3-Clause
// Saturated soil without drainage in whole scenes, against closed forms.
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "common/mechanics/ranks/sum.hpp"
#include "mpm_solver/report/water_output.hpp"
#include "solver_program/ranked_state.hpp"
#include "tests/unit/mpm/saturated_soil.hpp"

namespace gabion::test::test_saturated_soil {
namespace {

constexpr double g = 9.81, degree = std::numbers::pi / 180;

void step_explicitly(Json& json) {
  json.erase("newton");
  json["time_integration"] = {{"scheme", "explicit"}};
}

double largest_displacement(std::span<const Vector<2>> u) {
  double largest = 0;
  for (const auto& move : u) largest = std::max(largest, move.norm());
  return max_over_ranks(comm(), largest);
}

struct Rest {
  std::string type = "quad4", basis = "linear";
  double table = 1;
  bool is_explicit = false;
  double moves = 1e-6;    ///< at most, by the cell size
  double changes = 1e-3;  ///< of the pore pressure at most, by that of water as deep as a cell
};

/// Soil at rest with a water table stays at rest.
void check_rest(const Rest& rest) {
  SCOPED_TRACE(rest.type + " " + rest.basis + (rest.is_explicit ? " explicit " : " implicit ") +
               std::to_string(rest.table));
  constexpr int cells = 4;
  Json json = saturated_box(2, rest.type, cells, saturated_elastic());
  json["basis"] = rest.basis;
  json["bodies"][0]["initial_stress"] = at_rest(rest.table);
  json["probes"] = {{{"name", "A"}, {"point", {0.4, 0.1}}}};
  if (rest.is_explicit) step_explicitly(json);
  const auto solver = mpm_solver<2>(json);
  const double start = probe(*solver, "A.pore_pressure");
  run_steps(*solver, 0.01, rest.is_explicit ? 5 : 50);
  EXPECT_LT(largest_displacement(solver->points().u), rest.moves / cells);
  const double change = rest.changes * water_density * g / cells;
  EXPECT_NEAR(probe(*solver, "A.pore_pressure"), start, change);
  EXPECT_NEAR(probe(*solver, "A.excess_pore_pressure"), 0, change);
}

TEST(SaturatedSoil, rests_under_a_water_table) {
  for (const char* basis : {"linear", "gimp"}) {
    for (const double table : {1.0, 0.75}) check_rest({.basis = basis, .table = table});
    // The table crosses a cell, half of whose points are dry.
    check_rest({.basis = basis, .table = 0.6, .changes = 0.05});
  }
  check_rest({.basis = "gimp", .table = 0.75, .is_explicit = true});
  check_rest({.basis = "bspline", .changes = 0.3});
  check_rest({.type = "tri3", .table = 0.75, .moves = 1e-4, .changes = 0.01});
}

/// The thrust on a wall at rest: of the water and of the skeleton by K0.
template <int dim>
void check_thrust(const std::string& type, double table, double saturation) {
  Json json = saturated_box(dim, type, 4, saturated_elastic());
  json["bodies"][0]["initial_stress"] = at_rest(table);
  json["bodies"][0]["initial_stress"]["saturation_above"] = saturation;
  const auto solver = mpm_solver<dim>(json);
  const double dry = saturated_density - porosity * water_density;
  const double above = dry + saturation * porosity * water_density;
  const double d = 1 - table, submerged = saturated_density - water_density;
  const double effective =
      g * (above * d * d / 2 + above * d * table + submerged * table * table / 2);
  const double exact = 0.5 * effective + water_density * g * table * table / 2;
  EXPECT_NEAR(probe(*solver, "wall.right.fx"), exact, 2e-3 * exact) << type << " " << table;
  const double mass = above * d + saturated_density * table;
  EXPECT_NEAR(probe(*solver, "mass"), mass, 1e-3 * mass);
}

TEST(SaturatedSoil, thrust_of_skeleton_and_water) {
  check_thrust<2>("quad4", 1, 0);
  check_thrust<2>("quad4", 0.5, 0);
  check_thrust<2>("quad4", 0.5, 0.6);
  check_thrust<2>("tri3", 0.75, 0);
  check_thrust<3>("hex8", 0.5, 0);
}

/// A surface of facets bears the total stress from the start, and soil at rest stays so.
TEST(SaturatedSoil, thrust_on_facets) {
  constexpr double table = 0.75, d = 1 - table;
  Json json = saturated_box(2, "quad4", 8, saturated_elastic());
  json["grid"] = box({0, 0}, {1.25, 1.25}, {10, 10}, "quad4");
  json["bodies"][0]["initial_stress"] = at_rest(table);
  std::erase_if(json["walls"].get_ref<Json::array_t&>(),
                [](const Json& wall) { return wall["group"] == "right"; });
  json["rigid_walls"] = {{{"name", "wall"},
                          {"surface", {{"polyline", {{1, 1.2}, {1, 0}}}, {"spacing", 0.0625}}},
                          {"mode", "slip"}}};
  const auto solver = mpm_solver<2>(json);
  const double dry = saturated_density - porosity * water_density;
  const double submerged = saturated_density - water_density;
  const double effective = g * (dry * d * d / 2 + dry * d * table + submerged * table * table / 2);
  const double exact = 0.5 * effective + water_density * g * table * table / 2;
  EXPECT_NEAR(probe(*solver, "wall.fx"), exact, 0.01 * exact);
  run_steps(*solver, 0.005, 20);
  EXPECT_NEAR(probe(*solver, "wall.fx"), exact, 0.01 * exact);
}

/// Pore pressure of a box that its walls squeeze, over what they bear (Skempton 1954).
template <int dim>
Json squeezed(const std::string& type, const std::vector<std::string>& moving, double strain) {
  Json json = saturated_box(dim, type, 2, saturated_elastic());
  json["grid"] = json["bodies"][0]["mesh"];
  json["basis"] = "linear";
  json["gravity"] = std::vector<double>(dim, 0.0);
  json["analysis"] = "quasi_static";
  json["probes"] = {{{"name", "A"}, {"point", std::vector<double>(dim, 0.4)}}};
  const std::vector<std::string> far = dim == 2 ? std::vector<std::string>{"right", "top"}
                                                : std::vector<std::string>{"right", "back", "top"};
  for (int d = 0; d < dim; ++d) {
    if (std::find(moving.begin(), moving.end(), far[d]) == moving.end()) continue;
    std::vector<double> velocity(dim, 0.0);
    velocity[d] = -strain;
    Json& walls = json["walls"];
    std::erase_if(walls.get_ref<Json::array_t&>(),
                  [&](const Json& wall) { return wall["group"] == far[d]; });
    walls.push_back(wall(far[d], "slip"));
    walls.back()["motion"] = {{"velocity", velocity}};
  }
  return json;
}

TEST(SaturatedSoil, share_of_the_water_in_a_load) {
  constexpr double strain = 1e-7;
  const double Q = 2.2e9 / porosity, K = 20e6 / (3 * 0.4), G = 20e6 / 2.6, M = K + 4 * G / 3;
  const auto confined = mpm_solver<2>(squeezed<2>("quad4", {"top"}, strain));
  run_steps(*confined, 1, 1);
  const double p = probe(*confined, "A.pore_pressure");
  EXPECT_NEAR(p, Q * strain, 1e-5 * p);
  EXPECT_NEAR(-p / probe(*confined, "A.stress_yy"), Q / (M + Q), 1e-6);
  EXPECT_NEAR(-p / probe(*confined, "A.stress_yy"), 0.995129, 1e-6);

  const auto even = mpm_solver<3>(squeezed<3>("hex8", {"right", "back", "top"}, strain));
  run_steps(*even, 1, 1);
  const double B = -probe(*even, "A.pore_pressure") / probe(*even, "A.stress_xx");
  EXPECT_NEAR(B, Q / (K + Q), 1e-6);
  EXPECT_NEAR(B, 0.996979, 1e-6);

  // A strip between smooth plates whose sides are free: B (1 + nu_u) / 3.
  Json json = squeezed<2>("quad4", {"top"}, strain);
  json["grid"] = box({0, 0}, {2, 1}, {4, 2}, "quad4");
  std::erase_if(json["walls"].get_ref<Json::array_t&>(),
                [](const Json& wall) { return wall["group"] == "right"; });
  const auto strip = mpm_solver<2>(json);
  run_steps(*strip, 1, 1);
  EXPECT_NEAR(-probe(*strip, "A.pore_pressure") / probe(*strip, "A.stress_yy"), 0.498258, 1e-5);
}

/// A column between smooth plates whose sides are free: B / 3, so Skempton's A is 1/3.
TEST(SaturatedSoil, share_of_the_water_in_a_column) {
  Json json = squeezed<3>("hex8", {"top"}, 1e-7);
  json["grid"] = box({0, 0, 0}, {2, 2, 1}, {4, 4, 2}, "hex8");
  std::erase_if(json["walls"].get_ref<Json::array_t&>(), [](const Json& wall) {
    return wall["group"] == "right" || wall["group"] == "back";
  });
  const auto column = mpm_solver<3>(json);
  run_steps(*column, 1, 1);
  EXPECT_NEAR(-probe(*column, "A.pore_pressure") / probe(*column, "A.stress_zz"), 0.996979 / 3,
              1e-5);
}

/// Undrained shear strength in plane strain, and pore pressure, of a box that is sheared at
/// constant volume from an even stress.
struct UndrainedShear {
  double strength = 0, p = 0, p_start = 0, p_effective = 0;
};

UndrainedShear shear_undrained(double dilation, double cavitation) {
  constexpr double far = 1e4, weak = 1e-3;
  constexpr int steps = 16;
  constexpr double a = 2.5e-4, e = steps * a;  // a step keeps the volume, (1 - a) (1 + a / (1 - a))
  Json json = saturated_box(2, "quad4", 1, saturated_sand(dilation));
  json["basis"] = "linear";
  json["gravity"] = {0, -weak};
  json["analysis"] = "quasi_static";
  json["bodies"][0]["mesh"] = box({0, 0}, {1, 1}, {1, 1}, "quad4");
  json["bodies"][0]["water"]["cavitation_pressure"] = cavitation;
  json["bodies"][0]["initial_stress"] = {
      {"k0", 1}, {"surface", far}, {"water_table", far}, {"max_displacement", 1}};
  json["walls"] = {wall("bottom", "slip"), wall("left", "slip"), wall("right", "slip"),
                   wall("top", "slip")};
  json["grid"] = json["bodies"][0]["mesh"];
  json["walls"][3]["motion"] = {{"table", {{0, 0, 0}, {1, 0, -e}}}};
  json["walls"][2]["motion"] = {{"table", {{0, 0, 0}, {1, e / (1 - a), 0}}}};
  json["probes"] = {{{"name", "A"}, {"point", {0.4, 0.4}}}};
  const auto solver = mpm_solver<2>(json);
  UndrainedShear result;
  result.p_start = probe(*solver, "A.pore_pressure");
  result.p_effective =
      -(probe(*solver, "A.effective_stress_xx") + probe(*solver, "A.effective_stress_yy")) / 2;
  run_steps(*solver, 1.0 / steps, steps);
  result.p = probe(*solver, "A.pore_pressure");
  result.strength = (probe(*solver, "A.stress_xx") - probe(*solver, "A.stress_yy")) / 2;
  return result;
}

TEST(SaturatedSoil, undrained_shear_strength) {
  const double sin_phi = std::sin(32 * degree);
  const auto loose = shear_undrained(0, 0);
  EXPECT_NEAR(loose.p_start, 1e4, 10);
  EXPECT_NEAR(loose.p_effective, 9.9e3, 10);
  EXPECT_NEAR(loose.p, loose.p_start, 0.002 * loose.p_start);  // J stays 1
  EXPECT_NEAR(loose.strength, loose.p_effective * sin_phi, 1e-3 * loose.strength);
  // At constant volume dilation presses the grains together, the water does not see it.
  const auto dense = shear_undrained(5, 1e6);
  EXPECT_NEAR(dense.p, loose.p, 0.002 * loose.p);
  EXPECT_GT(dense.strength, 1.5 * loose.strength);
}

/// A bar that runs against a wall: the part that the wave has reached is at rest.
double undrained_speed(double bulk_modulus) {
  constexpr int cells = 100;
  constexpr double v = 1e-3, time = 2.5e-4;
  const double soft = std::sqrt(2.2e9 / bulk_modulus);
  Json json = saturated_box(2, "quad4", 1, saturated_elastic());
  json["grid"] = box({0, 0}, {1.1, 0.01}, {cells + 10, 1}, "quad4");
  json["bodies"][0]["mesh"] = box({0, 0}, {1, 0.01}, {cells, 1}, "quad4");
  json["bodies"][0]["velocity"] = {-v, 0};
  json["bodies"][0]["water"]["bulk_modulus"] = bulk_modulus;
  json["gravity"] = {0, 0};
  json["walls"] = {wall("left", "slip"), wall("bottom", "slip"), wall("top", "slip")};
  step_explicitly(json);
  json["transfer"] = {{"noise_damping", 0}};
  const auto solver = mpm_solver<2>(json);
  const double before = probe(*solver, "momentum_x");
  run_steps(*solver, time * soft, 1);
  const double meanwhile = probe(*solver, "momentum_x");
  run_steps(*solver, time * soft, 1, 2);
  const double Q = bulk_modulus / porosity, M = 26.9231e6;
  const double c = std::sqrt((M + Q) / saturated_density);
  const double h = solver->summary()["explicit"]["smallest_substep"].template get<double>() * c;
  EXPECT_LE(h, 0.01);  // the stable step knows the water
  EXPECT_GE(h, 0.004);
  return (meanwhile - probe(*solver, "momentum_x")) / before / (time * soft);
}

TEST(SaturatedSoil, speed_of_undrained_waves) {
  EXPECT_NEAR(undrained_speed(2.2e9), 1666.54, 0.005 * 1666.54);
  EXPECT_NEAR(undrained_speed(0.22e9), 538.434, 0.005 * 538.434);
}

/// Saturated sand that falls apart: it crosses cells, yields, and opens.
Json falling_sand(double dilation) {
  Json json = saturated_box(2, "quad4", 4, saturated_sand(dilation));
  json["grid"] = box({0, 0}, {3, 1.5}, {12, 6}, "quad4");
  json["walls"] = {wall("bottom", "fixed"), wall("left", "slip")};
  json["bodies"][0]["initial_stress"] = at_rest(0.75, 1);
  json["bodies"][0]["initial_stress"]["max_displacement"] = 10;
  json["bodies"][0]["water"]["bulk_modulus"] = 2.2e8;
  step_explicitly(json);
  json["probes"] = {{{"name", "A"}, {"point", {0.4, 0.4}}}};
  return json;
}

TEST(SaturatedSoil, energy_of_a_collapse) {
  for (const double dilation : {0.0, 5.0}) {
    const auto solver = mpm_solver<2>(falling_sand(dilation));
    const double start = probe(*solver, "elastic_energy");
    run_steps(*solver, 0.01, 40);
    const double fallen = probe(*solver, "gravity_work");
    EXPECT_GT(fallen, 10 * start);
    EXPECT_LT(std::abs(probe(*solver, "energy_balance")), 0.01 * fallen) << dilation;
  }
}

/// A run that stops in the middle and goes on has the same bits.
TEST(SaturatedSoil, restart) {
  const auto straight = mpm_solver<2>(falling_sand(0)), first = mpm_solver<2>(falling_sand(0)),
             second = mpm_solver<2>(falling_sand(0));
  run_steps(*straight, 0.01, 12);
  run_steps(*first, 0.01, 6);
  load_gathered(comm(), gather_state(comm(), first->save_state()), *second);
  EXPECT_TRUE(same_bits<2>(second->points(), first->points()));
  EXPECT_FALSE(straight->points().water.empty());
  run_steps(*second, 0.01, 6, 7);
  EXPECT_TRUE(same_bits<2>(second->points(), straight->points()));
  EXPECT_EQ(second->probes(), straight->probes());
}

/// The result on all ranks is that on one.
TEST(SaturatedSoil, ranks) {
  const auto alone = mpm_solver<2>(falling_sand(0), MPI_COMM_SELF),
             shared = mpm_solver<2>(falling_sand(0));
  run_steps(*alone, 0.01, 20);
  run_steps(*shared, 0.01, 20);
  const auto names = alone->probe_names();
  for (const char* column : {"momentum_x", "A.ux", "A.pore_pressure", "A.effective_stress_yy",
                             "elastic_energy", "wall.left.fx"}) {
    const double value = probe(*alone, column);
    EXPECT_NEAR(probe(*shared, column), value, 1e-6 * std::abs(value) + 1e-9) << column;
  }
  const auto& points = shared->points();
  EXPECT_EQ(points.water.size(), points.x.size());
}

TEST(SaturatedSoil, frames_have_effective_stress_and_pore_pressure) {
  Json json = saturated_box(2, "quad4", 2, saturated_elastic());
  json["bodies"][0]["initial_stress"] = at_rest(0.8);
  const auto settings = mpm_settings<2>(json);
  const auto solver = mpm_solver<2>(json);
  const auto& points = solver->points();
  const auto fields = mpm::water_fields<2>(settings.bodies, points);
  ASSERT_EQ(fields.size(), 3U);
  EXPECT_EQ(fields[0].name, "effective_stress");
  EXPECT_EQ(fields[1].name, "pore_pressure");
  EXPECT_EQ(fields[2].name, "excess_pore_pressure");
  const auto effective = fields[0].make(), pore = fields[1].make(), excess = fields[2].make();
  ASSERT_EQ(effective.size(), points.x.size() * symmetric_size<2>);
  for (std::int32_t p = 0; p < points.size(); ++p) {
    const double hydrostatic = water_density * g * std::max(0.0, 0.8 - points.x[p][1]);
    EXPECT_NEAR(pore[p], hydrostatic, 1e-4);
    EXPECT_NEAR(excess[p], 0, 1e-4);
    EXPECT_NEAR(effective[symmetric_size<2> * p], points.tau[p][0] / points.J[p] + pore[p], 1e-6);
  }
  json["bodies"][0].erase("water");
  json["bodies"][0]["initial_stress"].erase("water_table");
  const auto dry = mpm_settings<2>(json);
  EXPECT_TRUE(mpm::water_fields<2>(dry.bodies, points).empty());
  EXPECT_TRUE(mpm::water_probe_names<2>(dry).empty());
  EXPECT_TRUE(mpm_solver<2>(json)->points().water.empty());
}

}  // namespace
}  // namespace gabion::test::test_saturated_soil
