// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include "tests/support/expect_error.hpp"
#include "tests/unit/fem/fem_scene.hpp"

namespace gabion::test::test_fem_config {
namespace {

Json valid() {
  return {{"dimension", 2},
          {"mesh", box_2d({1, 2}, {2, 4})},
          {"material", elastic("linear_elastic", 1e6, 0.3, 1000)},
          {"supports", {{{"group", "bottom"}}}},
          {"interfaces", {{{"name", "wall"}, {"groups", {"left", "top"}}}}}};
}

void expect_refused(const Json& json, const std::vector<std::string_view>& parts) {
  expect_error<ConfigError>([&] { fem_solver<2>(json); }, parts);
}

TEST(FemConfig, averaged_forces_at_an_interface) {
  Json json = valid();
  json["time_integration"] = {{"scheme", "generalized_alpha"}, {"rho_inf", 0.8}};
  expect_refused(json, {"/time_integration", "interfaces", "bossak", "rho_inf 0"});
  json["time_integration"]["rho_inf"] = 0;
  EXPECT_NO_THROW(fem_solver<2>(json));
  json["time_integration"]["rho_inf"] = 0.8;
  json.erase("interfaces");
  EXPECT_NO_THROW(fem_solver<2>(json));
}

TEST(FemConfig, defaults) {
  const auto settings = fem_settings<2>(valid());
  EXPECT_TRUE(settings.dynamic);
  EXPECT_FALSE(settings.lumped_mass);
  EXPECT_FALSE(settings.initial_equilibrium);
  EXPECT_TRUE(settings.newton.reuse_matrix);
  EXPECT_EQ(settings.supports.at(0).components, (std::vector<int>{0, 1}));
  EXPECT_EQ(settings.gravity, Vector<2>::Zero());
}

TEST(FemConfig, missing_group_names_those_that_exist) {
  Json json = valid();
  json["supports"][0]["group"] = "base";
  expect_refused(json, {"fem.json", "/supports/0/group", "base", "bottom", "left", "right", "top"});
  json = valid();
  json["interfaces"][0]["groups"] = {"left", "roof"};
  expect_refused(json, {"/interfaces/0/groups", "roof", "bottom", "left", "right", "top"});
}

TEST(FemConfig, unknown_key_with_a_suggestion) {
  Json json = valid();
  json["gravitation"] = {0, -9.81};
  expect_refused(json, {"/gravitation", "unknown", "gravity"});
  json = valid();
  json["supports"][0]["component"] = {"x"};
  expect_refused(json, {"/supports/0/component", "unknown", "components"});
}

TEST(FemConfig, values_out_of_range) {
  Json json = valid();
  json["material"]["density"] = -1;
  expect_refused(json, {"/material/density", "-1", "> 0"});
  json = valid();
  json["dimension"] = 4;
  expect_refused(json, {"/dimension: found 4"});
  json = valid();
  json["supports"][0]["components"] = {"z"};
  expect_refused(json, {"/supports/0/components/0", "\"z\"", "x, y"});
  json = valid();
  json["gravity"] = {0, 0, -9.81};
  expect_refused(json, {"/gravity", "2 numbers"});
}

TEST(FemConfig, law_of_soil_is_refused) {
  Json json = valid();
  json["material"] = {{"law", "mohr_coulomb"}, {"young_modulus", 1e6},   {"poisson_ratio", 0.3},
                      {"density", 1000},       {"friction_angle", 30.0}, {"dilation_angle", 0.0},
                      {"cohesion", 100.0}};
  expect_refused(json, {"/material/law", "mohr_coulomb", "neo_hookean"});
  json["material"]["law"] = "hookean";
  expect_refused(json, {"/material/law: found \"hookean\", allowed: linear_elastic, neo_hookean, "
                        "hencky_elastic, von_mises, concrete;"});
}

TEST(FemConfig, names_that_no_table_can_hold) {
  for (const std::string name : {"", "a,b", "a\nb", "a/b"}) {
    Json json = valid();
    json["interfaces"][0]["name"] = name;
    expect_refused(json, {"fem.json: at /interfaces/0/name:", "letters, digits, _ and -"});
    json = valid();
    json["probes"] = {{{"name", name}, {"point", {0.5, 1.0}}}};
    expect_refused(json, {"fem.json: at /probes/0/name:", "letters, digits, _ and -"});
  }
}

TEST(FemConfig, what_is_given_twice) {
  Json json = valid();
  json["supports"] = {{{"group", "bottom"}, {"components", {"x"}}}, {{"group", "bottom"}}};
  expect_refused(json, {"/supports/1/group", "bottom", "component x a second time"});
  json["supports"][1]["components"] = {"y"};
  EXPECT_NO_THROW(fem_solver<2>(json));
  json["supports"][1]["components"] = {"y", "y"};
  expect_refused(json, {"/supports/1/components/1", "\"y\" a second time"});
  json = valid();
  json["interfaces"][0]["groups"] = {"left", "left"};
  expect_refused(json, {"/interfaces/0/groups/1", "left", "second time"});
  json["interfaces"] = {{{"name", "a"}, {"groups", {"left"}}},
                        {{"name", "b"}, {"groups", {"top", "left"}}}};
  expect_refused(json, {"/interfaces/1/groups/1", "left", "second time"});
  json["interfaces"][1]["groups"] = {"top", "right"};
  EXPECT_NO_THROW(fem_solver<2>(json));
}

TEST(FemConfig, equilibrium_at_the_start_needs_supports_in_every_direction) {
  Json json = valid();
  json["initial_equilibrium"] = true;
  EXPECT_NO_THROW(fem_solver<2>(json));
  json["supports"][0]["components"] = {"x"};
  expect_refused(json, {"fem.json: at /supports:", "in y", "initial_equilibrium"});
  json["prescribed"] = {{{"group", "bottom"}, {"component", "y"}, {"rate", 0.0}}};
  EXPECT_NO_THROW(fem_solver<2>(json));
  json.erase("prescribed");
  json.erase("supports");
  expect_refused(json, {"fem.json: at /supports:", "in x"});
  json.erase("initial_equilibrium");
  EXPECT_NO_THROW(fem_solver<2>(json));
  json["analysis"] = "static";
  expect_refused(json, {"fem.json: at /supports:", "in x", "static"});
}

TEST(FemConfig, contradictions) {
  Json json = valid();
  json["prescribed"] = {{{"group", "left"}, {"component", "x"}, {"rate", 1.0}}};
  expect_refused(json, {"/prescribed/0/group", "component x", "already fixed"});
  json = valid();
  json["prescribed"] = {{{"group", "top"}, {"component", "x"}}};
  expect_refused(json, {"/prescribed/0", "rate", "table"});
  json = valid();
  json["prescribed"] = {
      {{"group", "top"}, {"component", "x"}, {"table", {{0, 0}, {1, 1}, {1, 2}}}}};
  expect_refused(json, {"/prescribed/0/table/2", "increasing"});
  json = valid();
  json["analysis"] = "static";
  json["mass"] = "lumped";
  expect_refused(json, {"/mass", "static"});
  json = valid();
  json["initial_equilibrium"] = true;
  json["initial_velocity"] = {1, 0};
  expect_refused(json, {"/initial_velocity", "initial_equilibrium"});
  json = valid();
  json["interfaces"].push_back(json["interfaces"][0]);
  expect_refused(json, {"/interfaces/1/name", "wall", "distinct"});
}

TEST(FemConfig, points_away_from_the_mesh) {
  Json json = valid();
  json["probes"] = {{{"name", "A"}, {"point", {1.5, 1.0}}}};
  expect_refused(json, {"/probes/0/point", "1.5", "inside the cells"});
  json = valid();
  json["loads"] = {{{"point", {0.6, 2.0}}, {"force", {1, 0}}}};
  expect_refused(json, {"/loads/0/point", "no node", "[0.5, 2]"});
}

TEST(FemConfig, time_is_only_read_without_a_coupler) {
  Json json = valid();
  json["time"] = {{"end", 1.0}, {"dt", 0.1}, {"dt_min", 0.01}};
  expect_refused(json, {"/time", "only in a scene without coupler.json"});
}

TEST(TimeFunction, table_is_linear_inside_and_held_outside) {
  const auto f = TimeFunction::table({1, 2, 4}, {10, 20, 0});
  EXPECT_EQ(f.at(0), 10);
  EXPECT_EQ(f.at(1.5), 15);
  EXPECT_EQ(f.at(3), 10);
  EXPECT_EQ(f.at(9), 0);
  EXPECT_FALSE(f.constant_after(0));
  EXPECT_FALSE(f.constant_after(3.9));
  EXPECT_TRUE(f.constant_after(4));
  EXPECT_TRUE(TimeFunction::constant(3).constant_after(0));
  EXPECT_FALSE(TimeFunction::ramp(3).constant_after(100));
  EXPECT_EQ(TimeFunction::ramp(3).at(2), 6);
}

std::string warnings_of(const Json& json) {
  testing::internal::CaptureStderr();
  fem_settings<2>(json);
  return testing::internal::GetCapturedStderr();
}

/// Cells that are long against the thickness of a strip lock in bending, whether one or several lie
/// across it; not shorter or enhanced ones.
TEST(FemConfig, flat_cells_with_full_integration_are_named) {
  const auto said = [](std::vector<int> cells, const std::string& formulation) {
    Json json = valid();
    json["mesh"] = box_2d({4, 0.5}, cells);
    json["material"]["formulation"] = formulation;
    return warnings_of(json);
  };
  expect_parts(said({4, 1}, "full"), {"at /material/law: found 4 cells", "up to 2 times as long",
                                      "2.4 times too little"});
  expect_parts(said({2, 3}, "full"), {"found 6 cells", "up to 4 times as long"});
  for (const std::string& text :
       {said({5, 1}, "full"), said({5, 10}, "full"), said({4, 1}, "enhanced")}) {
    EXPECT_EQ(text.find("lock"), std::string::npos) << text;
  }
}

/// Allowed, but the units look like others; steel and rubber do not.
TEST(FemConfig, values_in_other_units_are_said) {
  Json json = valid();
  json["gravity"] = {0, -9.81};
  json["material"] = elastic("linear_elastic", 30, 0.2, 2.4);
  expect_parts(warnings_of(json), {"at /material/density: found 2.4 kg/m^3, lighter than",
                                   "in t/m^3 it would be 2.4e+03 kg/m^3",
                                   "at /material/young_modulus: found 30.0 Pa, softer than",
                                   "in GPa it would be 3e+10 Pa"});
  json["material"] = elastic("linear_elastic", 3e4, 0.2, 2400);  // of concrete, in MPa
  expect_parts(warnings_of(json), {"wave speed 3.73 m/s", "under its own weight"});
  json["gravity"] = {0, -9810};
  expect_parts(warnings_of(json), {"at /gravity: found [0,-9810] m/s^2", "in mm/s^2"});
  json["gravity"] = {0, -9.81};
  for (const auto& [E, density] : {std::pair{2.1e11, 7850.0}, {1e6, 1100.0}, {1e7, 20.0}}) {
    json["material"] = elastic("neo_hookean", E, 0.3, density);
    EXPECT_EQ(warnings_of(json).find("warning"), std::string::npos) << E;
  }
}

}  // namespace
}  // namespace gabion::test::test_fem_config
