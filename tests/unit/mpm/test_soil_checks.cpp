// SPDX-License-Identifier: BSD-3-Clause
// Checks before the first step: meshes, bodies in each other, weight.
#include <gtest/gtest.h>

#include <cmath>

#include "common/mechanics/ranks/sum.hpp"
#include "mpm_solver/checks/soil_at_rest.hpp"
#include "tests/support/expect_error.hpp"
#include "tests/support/gmsh_text.hpp"
#include "tests/unit/mpm/mpm_scene.hpp"

namespace gabion::test::test_soil_checks {
namespace {

const Json soil = elastic_soil("hencky_elastic", 1e6, 0.3, 1000);

Json two_bodies(double shift) {
  return {{"dimension", 2},
          {"grid", box({0, 0}, {4, 2}, {8, 4}, "quad4")},
          {"bodies",
           {body("a", box({0.5, 0.5}, {1.5, 1.5}, {2, 2}, "quad4"), 4, soil),
            body("b", box({0.5 + shift, 0.5}, {1.5 + shift, 1.5}, {2, 2}, "quad4"), 4, soil)}}};
}

/// @returns what this process says of the scene, warnings and all
std::string said_of(const Json& json) {
  testing::internal::CaptureStderr();
  make_mpm(json);
  return testing::internal::GetCapturedStderr();
}

void expect_said(const Json& json, const std::vector<std::string_view>& parts) {
  const std::string text = said_of(json);
  if (rank_of(comm()) == 0) expect_parts(text, parts);
}

void expect_refused(const Json& json, const std::vector<std::string_view>& parts) {
  expect_error<ConfigError>([&] { make_mpm(json); }, parts);
}

TEST(Overlaps, bodies_in_one_place_are_refused) {
  expect_refused(two_bodies(0), {"/bodies", "\"a\" and \"b\" overlap", "1 m^3", "1000 kg of \"a\"",
                                 "1000 kg of \"b\""});
  expect_refused(two_bodies(0.5), {"0.5 m^3 at (1.", "500 kg of \"a\""});
}

TEST(Overlaps, bodies_that_touch_or_lie_apart_do_not) {
  for (const double shift : {1.0, 1.0 - 1e-12, 1.3}) {
    EXPECT_EQ(said_of(two_bodies(shift)).find("warning"), std::string::npos) << shift;
  }
}

/// A body that lies between the points of another, which has cells of its size times four.
TEST(Overlaps, a_small_body_in_a_large_cell) {
  Json json = two_bodies(0);
  json["bodies"][0] = body("a", box({0, 0}, {2, 2}, {1, 1}, "quad4"), 4, soil);
  json["bodies"][1] = body("b", box({0.9, 0.9}, {1.1, 1.1}, {1, 1}, "quad4"), 4, soil);
  json["basis"] = "linear";
  expect_refused(json, {"0.04 m^3", "0 kg of \"a\"", "40 kg of \"b\""});
}

TEST(Overlaps, a_hundredth_is_said_only) {
  Json json = two_bodies(0);
  json["bodies"][1] = body("b", box({1.495, 0.5}, {3.495, 1.5}, {400, 1}, "quad4"), 4, soil);
  json["basis"] = "linear";
  expect_said(json, {"warning", "\"a\" and \"b\" overlap"});
}

TEST(Overlaps, parts_of_one_body) {
  GmshText file = loose_tower();
  for (const int i : {4, 5, 6, 7}) file.nodes[i][1] -= 0.5;
  const TemporaryMesh mesh(file);
  Json json = two_bodies(1.5);
  json["bodies"][0]["mesh"] = {{"file", mesh.path()}};
  json["bodies"][0]["points_per_cell"] = 16;
  expect_refused(json, {"parts of \"a\" overlap", "its 2000 kg fill room for 1500 kg"});
}

/// The upper square lies on nodes of its own.
TEST(GridMesh, a_grid_in_two_parts_is_refused_where_nothing_holds_the_seam) {
  const TemporaryMesh mesh(loose_tower());
  Json json = {{"dimension", 2},
               {"grid", {{"file", mesh.path()}}},
               {"walls", {wall("foot", "fixed")}},
               {"bodies", {body("a", box({0, 0}, {1, 0.5}, {2, 1}, "quad4"), 4, soil)}}};
  expect_refused(json, {"at /grid: found 2 places with several nodes", "(1, 1)", "not feel"});
  const TemporaryMesh joined(tower(), 1);
  json["grid"]["file"] = joined.path();
  EXPECT_EQ(said_of(json).find("warning"), std::string::npos);
  GmshText slit = loose_tower();  // with a wall on both sides
  slit.blocks[0].elements.push_back({3, 4});
  slit.blocks[0].elements.push_back({7, 8});
  const TemporaryMesh walled(slit, 2);
  json["grid"]["file"] = walled.path();
  EXPECT_EQ(said_of(json).find("warning"), std::string::npos);
  GmshText apart = loose_tower();
  for (const int i : {4, 5, 6, 7}) apart.nodes[i][1] += 1;
  const TemporaryMesh basins(apart, 3);
  json["grid"]["file"] = basins.path();
  expect_said(json, {"warning", "2 parts that are not connected", "from (0, 2) to (1, 3)"});
}

TEST(SoilAtRest, units_that_do_not_fit_are_said) {
  Json json = two_bodies(1.5);
  json["gravity"] = {0, -9.81};
  json["bodies"][0]["material"]["young_modulus"] = 1;
  json["bodies"][1]["material"]["young_modulus"] = 30;
  json["rigid_walls"] = {{{"name", "bed"},
                          {"surface", {{"polyline", {{4, 0.5}, {0, 0.5}}}, {"spacing", 0.5}}},
                          {"friction", 30}}};
  expect_said(json,
              {"/bodies/0/material/young_modulus: found 1.0 Pa, softer than any soil",
               "in MPa it would be 1e+06 Pa", "/bodies/1/material/young_modulus: found 30.0 Pa",
               "/rigid_walls/0/friction: found 30.0, an angle", "wave speed 0.0367 m/s",
               "under its own weight, 3.64e+03 of its depth of 1 m"});
}

/// A layer of 1 m on a slope that falls by 300 m settles as one on level ground.
TEST(SoilAtRest, a_layer_counts_by_its_depth) {
  GmshText file;
  for (int i = 0; i <= 40; ++i) {
    file.nodes.push_back({20.0 * i, 300 - 7.5 * i, 0});
    file.nodes.push_back({20.0 * i, 301 - 7.5 * i, 0});
  }
  file.blocks = {{2, 1, 3, {}}};
  for (int i = 0; i < 40; ++i) {
    file.blocks[0].elements.push_back({2 * i + 1, 2 * i + 3, 2 * i + 4, 2 * i + 2});
  }
  const TemporaryMesh mesh(file);
  Json json = two_bodies(1.5);
  json["grid"] = box({0, 0}, {800, 302}, {40, 16}, "quad4");
  json["gravity"] = {0, -10};
  json["basis"] = "linear";
  json["bodies"] = {body("slide", {{"file", mesh.path()}}, 4, soil)};
  const std::string text = said_of(json);
  EXPECT_EQ(text.find("warning"), std::string::npos) << text;
  const auto column = mpm::column_of<2>(mpm_settings<2>(json), 0);
  EXPECT_NEAR(column.height, 1, 1e-9);
  EXPECT_NEAR(column.settlement(), 1000 * 10 / (2 * 1e6 * 0.7 / (1.3 * 0.4)), 1e-9);
}

TEST(SoilAtRest, free_of_stress_under_its_weight) {
  const auto text_of = [](const Json& json) {
    return mpm::free_of_stress_text<2>(mpm_settings<2>(json));
  };
  Json json = two_bodies(1);
  EXPECT_EQ(text_of(json), "");
  json["gravity"] = {5, -9.81};
  // 4 depth / wave speed, the depth of a square along its tilted gravity.
  const double depth = std::hypot(5, 9.81) / (5 + 9.81), period = 4 * depth / 36.69;
  expect_parts(text_of(json), {"once: a, b.", fmt::format("with a period of {:.2g} s", period),
                               "initial_stress", "quasi_static", "gravity_ramp"});
  EXPECT_EQ(said_of(json).find("warning"), std::string::npos);
  json["bodies"][0]["velocity"] = {1, 0};
  expect_parts(text_of(json), {"once: b."});
  json["gravity_ramp"] = {{"duration", 0.5}};
  EXPECT_EQ(text_of(json), "");
  json = two_bodies(1);
  json["gravity"] = {0, -10};
  json["analysis"] = "quasi_static";
  EXPECT_EQ(text_of(json), "");
}

/// The stiffer the soil, the more of its thrust an interface of the usual stiffness leaves out.
TEST(SoilAtRest, an_interface_that_gives_while_soil_takes_its_weight) {
  const auto text_of = [](double E, const Json& change) {
    Json json = {{"dimension", 2},
                 {"grid", box({0, 0}, {3, 2}, {24, 16}, "quad4")},
                 {"gravity", {0, -10}},
                 {"gravity_ramp", {{"duration", 0.5}}},
                 {"bodies",
                  {body("soil", box({0, 0}, {2, 1}, {16, 8}, "quad4"), 4,
                        elastic_soil("hencky_elastic", E, 0.3, 2000))}},
                 {"interfaces",
                  {{{"name", "gate"},
                    {"surface", {{"polyline", {{2, 1.5}, {2, 0}}}, {"spacing", 0.125}}}}}}};
    json.merge_patch(change);
    return mpm::soft_interfaces_text<2>(mpm_settings<2>(json), 0.125);
  };
  // 10 kPa, depth h sqrt(p / (10 M)) with M = 135 MPa: 0.34 mm; the soil gives 0.148 mm.
  expect_parts(text_of(1e8, Json::object()),
               {"at gate", "at 1e+04 Pa", "\"soil\"", "yields by 0.00034 m", "over 2 m", "some 86 %",
                "resting_factor", "initial_stress"});
  // Under inclined gravity the 2 m look 1.41 m long, the mean depth is 0.94 m.
  expect_parts(text_of(1e8, {{"gravity", {7.0710678118654755, -7.0710678118654755}}}),
               {"at 9.43e+03 Pa", "over 1.41 m", "some 92 %"});
  EXPECT_EQ(text_of(1e3, Json::object()), "");
  EXPECT_EQ(text_of(1e8, {{"gravity_ramp", nullptr}}), "");
  EXPECT_NE(text_of(1e8, {{"gravity_ramp", nullptr}, {"analysis", "quasi_static"}}), "");
  EXPECT_EQ(text_of(1e8, {{"gravity", {0, 0}}}), "");
  Json interface = {{"name", "gate"},
                    {"surface", {{"polyline", {{2, 1.5}, {2, 0}}}, {"spacing", 0.125}}},
                    {"resting_factor", 12}};
  EXPECT_EQ(text_of(1e8, {{"interfaces", {interface}}}), "");
}

/// Two layers between smooth walls, 1 m of 1500 kg/m^3 on 1 m of 2000 kg/m^3.
Json layers(double surface) {
  Json lower = body("lower", box({0, 0}, {1, 1}, {2, 2}, "quad4"), 4,
                    elastic_soil("hencky_elastic", 1e6, 0.3, 2000));
  Json upper = body("upper", box({0, 1}, {1, 2}, {2, 2}, "quad4"), 4,
                    elastic_soil("hencky_elastic", 1e6, 0.3, 1500));
  lower["initial_stress"] = {{"k0", "elastic"}, {"surface", surface}};
  upper["initial_stress"] = {{"k0", "elastic"}, {"surface", 2}};
  return {{"dimension", 2},
          {"grid", box({0, 0}, {1, 3}, {2, 6}, "quad4")},
          {"walls", {wall("bottom", "slip"), wall("left", "slip"), wall("right", "slip")}},
          {"gravity", {0, -10}},
          {"bodies", {lower, upper}}};
}

TEST(SoilAtRest, layers_of_unequal_density_say_how_they_balance) {
  const std::string text = error_of<ConfigError>([] { make_mpm(layers(2)); });
  expect_parts(text, {"not in balance", "\"upper\" (1500 kg/m^3) lies on \"lower\" (2000 kg/m^3)",
                      "With \"surface\": 1.7", "of \"lower\""});
  const std::string before = "With \"surface\": ";
  const double surface = std::stod(text.substr(text.find(before) + before.size()));
  EXPECT_NEAR(surface, 1.75, 0.01);
  const auto solver = make_mpm(layers(surface));
  EXPECT_LT(solver->summary()["initial_displacement"].get<double>(), 2e-4 * 0.5);
}

/// A layer of elastic soil at rest against a wall of facets at 1 m + `at` of a cell of 0.25 m, with
/// a mesh of its own that ends there.
Json against_wall(double at, const std::string& type = "quad4",
                  const std::string& basis = "linear") {
  const double W = 1 + 0.25 * at;
  Json json = {{"dimension", 2},
               {"grid", box({0, 0}, {1.75, 1.25}, {7, 5}, type)},
               {"basis", basis},
               {"gravity", {0, -10}},
               {"walls", {wall("left", "slip"), wall("bottom", "slip")}},
               {"bodies",
                {body("soil", box({0, 0}, {W, 1}, {4, 4}, type), type == "tri3" ? 3 : 4,
                      elastic_soil("hencky_elastic", 1e8, 0.3, 2000))}},
               {"rigid_walls",
                {{{"name", "wall"},
                  {"surface", {{"polyline", {{W, 1.2}, {W, -1}}}, {"spacing", 0.25}}},
                  {"mode", "slip"}}}}};
  json["bodies"][0]["initial_stress"] = {{"k0", 0.5}, {"surface", 1}, {"max_displacement", 0.1}};
  return json;
}

std::string quadrature_of(const Json& json) {
  return make_mpm(json)->summary().at("quadrature");
}

TEST(CutCells, the_start_warns_of_soil_at_rest_on_a_wall_that_cuts_cells) {
  for (const std::string type : {"quad4", "tri3"}) {
    for (const double at : {0.25, 1.0 / 3, 0.5}) {
      expect_said(against_wall(at, type),
                  {"/rigid_walls/0", "\"wall\" cuts cells of the grid", "\"basis\": \"linear\""});
    }
    EXPECT_EQ(said_of(against_wall(0, type)).find("cuts cells"), std::string::npos) << type;
  }
  EXPECT_EQ(said_of(against_wall(0.5, "quad4", "gimp")).find("cuts cells"), std::string::npos);
}

/// Soil that is not at rest meets surfaces wherever it goes.
TEST(CutCells, soil_that_moves_is_not_warned_of) {
  Json json = against_wall(0.5);
  json["bodies"][0].erase("initial_stress");
  EXPECT_EQ(said_of(json).find("cuts cells"), std::string::npos);
}

TEST(CutCells, quadrature_of_elastic_soil_at_rest_follows_how_it_fills_the_cells) {
  for (const std::string type : {"quad4", "tri3"}) {
    EXPECT_EQ(quadrature_of(against_wall(0, type)), "points") << type;
    EXPECT_EQ(quadrature_of(against_wall(0.5, type)), "cells") << type;
    Json moving = against_wall(0.5, type);
    moving["bodies"][0].erase("initial_stress");
    EXPECT_EQ(quadrature_of(moving), "points") << type;
    moving["analysis"] = "quasi_static";
    EXPECT_EQ(quadrature_of(moving), "cells") << type;
  }
  EXPECT_EQ(quadrature_of(against_wall(0.5, "quad4", "gimp")), "points");
  Json named = against_wall(0.5);
  named["quadrature"] = "points";
  EXPECT_EQ(quadrature_of(named), "points");
}

}  // namespace
}  // namespace gabion::test::test_soil_checks
