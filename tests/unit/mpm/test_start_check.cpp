// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "mpm_solver/contact/start_check.hpp"
#include "mpm_solver/contact/thin_walls.hpp"
#include "tests/support/expect_error.hpp"
#include "tests/unit/mpm/mpm_scene.hpp"

namespace gabion::test::test_start_check {
namespace {

/// Soil in [0.5, 1] x [0, 0.5] on a grid of cells of 0.25 m; a wall with the soil to its left.
Json walled(double x, const std::string& method = "facets") {
  return {{"dimension", 2},
          {"grid", box({0, 0}, {2, 1}, {8, 4}, "quad4")},
          {"basis", "linear"},
          {"bodies",
           {body("soil", box({0.5, 0}, {1, 0.5}, {4, 4}, "quad4"), 4,
                 elastic_soil("neo_hookean", 1e5, 0.3, 1000))}},
          {"rigid_walls",
           {{{"name", "ram"},
             {"method", method},
             {"surface", {{"polyline", {{x, 0.6}, {x, -0.1}}}, {"spacing", 0.25}}}}}}};
}

/// Soil in space, below the bottom of a block or beside one of its other sides.
Json below_block(double z, const std::string& group = "bottom") {
  return {
      {"dimension", 3},
      {"grid", box({0, 0, 0}, {1, 1, 2}, {4, 4, 8}, "hex8")},
      {"bodies",
       {body("soil", box({0, 0, 0}, {1, 1, 0.5}, {4, 4, 2}, "hex8"), 8,
             elastic_soil("neo_hookean", 1e5, 0.3, 1000))}},
      {"interfaces",
       {{{"name", "block"},
         {"surface",
          {{"mesh", box({0, 0, z}, {1, 1, z + 1}, {4, 4, 4}, "tet4")}, {"groups", {group}}}}}}}};
}

void expect_refused(const Json& json, const std::vector<std::string_view>& parts) {
  expect_error<ConfigError>([&] { make_mpm(json); }, parts);
}

template <int dim>
std::vector<mpm::StartSurface<dim>> surfaces_of(const mpm::MpmSettings<dim>& settings) {
  std::vector<mpm::StartSurface<dim>> all;
  for (const auto& of : settings.interfaces) all.push_back({of, of.surface.vertices, false});
  for (const auto& of : settings.rigid_walls) {
    all.push_back({of.boundary, of.boundary.surface.vertices, true});
  }
  return all;
}

/// Warnings of thin walls at the start.
template <int dim>
std::vector<std::string> thin_walls(const Json& json) {
  const auto solver = mpm_solver<dim>(json);
  const auto settings = mpm_settings<dim>(json);
  const auto surfaces = surfaces_of(settings);
  mpm::ThinWalls<dim> walls(surfaces, 0.25);
  return walls.at_start(comm(), surfaces, solver->points(), settings.body_groups);
}

TEST(StartCheck, touching_soil_is_fine) {
  for (const char* method : {"facets", "boundary_points"}) EXPECT_TRUE(make_mpm(walled(1, method)));
  EXPECT_TRUE(make_mpm(below_block(0.5)));
}

TEST(StartCheck, smallest_gap) {
  const auto check = []<int dim>(const Json& json, double cell, double expected) {
    const auto solver = mpm_solver<dim>(json);
    const auto settings = mpm_settings<dim>(json);
    const auto surface = surfaces_of(settings).front();
    const double gap = mpm::smallest_gap<dim>(comm(), surface, solver->points(), cell, 3);
    if (std::isfinite(expected)) {
      EXPECT_NEAR(gap, expected, 1e-12);
    } else {
      EXPECT_EQ(gap, expected);
    }
  };
  for (const double gap : {0.0, 0.1, 0.7}) check.operator()<2>(walled(1 + gap), 0.25, gap);
  for (const double gap : {0.0, 0.2, 1.0}) check.operator()<3>(below_block(0.5 + gap), 0.25, gap);
  Json behind = walled(1);
  behind["rigid_walls"][0]["surface"]["polyline"] = {{1.7, -0.1}, {1.7, 0.6}};
  check.operator()<2>(behind, 0.25, std::numeric_limits<double>::infinity());
}

TEST(StartCheck, a_reversed_surface_is_refused) {
  for (const char* method : {"facets", "boundary_points"}) {
    Json json = walled(1, method);
    auto& surface = json["rigid_walls"][0]["surface"];
    surface["polyline"] = {{1, -0.1}, {1, 0.6}};
    expect_refused(json,
                   {"/rigid_walls/0/surface", "64 of them", "\"ram\"", "behind it", "reverse"});
    surface["polyline"] = {{1.3, -0.1}, {1.3, 0.6}};
    expect_refused(json, {"/rigid_walls/0/surface", "\"ram\"", "reverse"});
    surface["polyline"] = {{1.6, -0.1}, {1.6, 0.6}};  // too far to be sure
    EXPECT_TRUE(make_mpm(json));
  }
  // The upper side of a plate above the soil.
  Json thin = below_block(0.6, "top");
  thin["interfaces"][0]["surface"]["mesh"] = box({0, 0, 0.6}, {1, 1, 0.7}, {4, 4, 1}, "tet4");
  expect_refused(thin, {"/interfaces/0/surface", "\"block\"", "behind it", "reverse"});
}

TEST(StartCheck, soil_inside_is_refused) {
  // Points at 0.9014 and 0.9736, R = 0.0264, in 4 cells of 0.125 m with two rows each.
  expect_refused(walled(0.92), {"/rigid_walls/0/surface", "found 16 material points", "\"ram\"",
                                "the deepest by 0.08 m at (0.973584"});
  expect_refused(walled(0.92, "boundary_points"), {"found 8 material points", "(0.973584"});
  // Overlap without a centre behind it; boundary points do not measure it.
  expect_refused(walled(0.99), {"found 8 material points", "the deepest by 0.01 m"});
  EXPECT_TRUE(make_mpm(walled(0.99, "boundary_points")));
  EXPECT_TRUE(make_mpm(walled(1 - 0.001)));  // 4 % of R
  expect_refused(below_block(0.45),
                 {"/interfaces/0/surface", "\"block\"", "material points inside"});
}

/// Soil that fills the place of a structure exactly is in contact with both of its sides.
TEST(StartCheck, soil_that_fills_the_structure_is_refused) {
  Json json = walled(1);
  json["rigid_walls"][0]["surface"]["polyline"] = {
      {0.875, 0.001}, {0.875, 0.25}, {0.75, 0.25}, {0.75, 0.001}};
  expect_refused(json, {"/rigid_walls/0/surface", "found 8 material points", "inside"});
}

/// Soil on both sides of a sheet, each with a surface of its own; and soil that lies lower than the
/// end of a plate, but not behind it.
TEST(StartCheck, soil_on_the_other_side_is_fine) {
  Json json = walled(0.75);
  json["rigid_walls"].push_back(json["rigid_walls"][0]);
  json["rigid_walls"][1]["name"] = "back";
  json["rigid_walls"][1]["surface"]["polyline"] = {{0.75, -0.1}, {0.75, 0.6}};
  EXPECT_TRUE(make_mpm(json));
  json = walled(1);
  json["rigid_walls"][0]["surface"]["polyline"] = {{0.4, 0.4}, {0, 0.4}};
  EXPECT_TRUE(make_mpm(json));
}

TEST(StartCheck, coarse_surfaces) {
  const auto warning = [](const Json& json) {
    const auto settings = mpm_settings<2>(json);
    return mpm::coarse_surface<2>(surfaces_of(settings).front(), 0.25);
  };
  const auto interface = [](const Json& polyline, double spacing) {
    Json json = walled(1);
    json["interfaces"] = json["rigid_walls"];
    json.erase("rigid_walls");
    json["interfaces"][0]["surface"] = {{"polyline", polyline}, {"spacing", spacing}};
    return json;
  };
  const Json line = {{1, 0.7}, {1, 0}};
  EXPECT_FALSE(warning(interface(line, 0.25)));
  const auto text = warning(interface(line, 0.4));
  ASSERT_TRUE(text);
  EXPECT_NE(text->find("2 of 2 facets of \"ram\""), std::string::npos) << *text;
  EXPECT_NE(text->find("0.35 m, 1.4 cells"), std::string::npos) << *text;
  Json arc = Json::array();  // chords of 0.196 m
  for (int k = 0; k <= 8; ++k) {
    const double angle = k * std::numbers::pi / 16;
    arc.push_back({1.1 + std::sin(angle), std::cos(angle)});
  }
  EXPECT_TRUE(warning(interface(arc, 0.25)));
  EXPECT_FALSE(warning(interface(arc, 0.1)));
  Json rigid = walled(1);
  rigid["rigid_walls"][0]["surface"]["spacing"] = 10;
  EXPECT_FALSE(warning(rigid));
  rigid["rigid_walls"][0]["method"] = "boundary_points";
  EXPECT_TRUE(warning(rigid));
}

TEST(StartCheck, coarse_surface_in_space) {
  Json json = below_block(0.5);
  const auto warning = [&] {
    const auto settings = mpm_settings<3>(json);
    return mpm::coarse_surface<3>(surfaces_of(settings).front(), 0.25);
  };
  auto& mesh = json["interfaces"][0]["surface"]["mesh"];
  mesh = box({0, 0, 0.5}, {1, 1, 1.5}, {4, 4, 4}, "hex8");
  EXPECT_FALSE(warning());
  mesh = box({0, 0, 0.5}, {1, 1, 1.5}, {2, 4, 4}, "hex8");
  EXPECT_TRUE(warning());
}

/// Cells of 0.25 m up to x = 2: farther than a cell no soil can meet a surface.
TEST(StartCheck, a_surface_outside_the_grid_is_refused) {
  EXPECT_TRUE(make_mpm(walled(2.2)));
  Json json = walled(2.3);
  expect_refused(json, {"/rigid_walls/0/surface", "\"ram\" from (2.3, -0.1) to (2.3, 0.6)",
                        "outside the background grid", "(0, 0) to (2, 1)", "metres"});
  json["interfaces"] = json["rigid_walls"];
  json.erase("rigid_walls");
  expect_refused(json, {"/interfaces/0/surface", "\"ram\"", "outside the background grid"});
  expect_refused(below_block(2.5), {"/interfaces/0/surface", "(0, 0, 2.5) to (1, 1, 2.5)"});
}

TEST(StartCheck, a_surface_that_reaches_beyond_the_grid_or_comes_into_it) {
  Json json = walled(1);
  json["rigid_walls"][0]["surface"] = {{"polyline", {{40, -0.1}, {-40, -0.1}}}, {"spacing", 80}};
  const auto outside = [&] {
    const auto settings = mpm_settings<2>(json);
    auto surface = surfaces_of(settings).front();
    surface.moves = settings.rigid_walls[0].motion.moves();
    return mpm::outside_grid<2>(surface, mpm::bounding_box(settings.grid), 0.25);
  };
  EXPECT_FALSE(outside());
  json = walled(3);
  json["rigid_walls"][0]["motion"] = {{"velocity", {-1, 0}}};
  const auto warning = outside();
  ASSERT_TRUE(warning);
  EXPECT_NE(warning->find("unless its motion brings it in"), std::string::npos) << *warning;
  EXPECT_TRUE(make_mpm(json));
}

/// A plate from x = 1.05 on, with soil to its left and, from `right` on, to its right.
Json plate_between(double thickness, double right) {
  Json json = walled(1);
  json["rigid_walls"][0]["surface"] = {
      {"polyline", {{1.05 + thickness, -0.1}, {1.05 + thickness, 0.6}, {1.05, 0.6}, {1.05, -0.1}}},
      {"spacing", 0.25}};
  Json other = json["bodies"][0];
  other["name"] = "other";
  other["mesh"] = box({right, 0}, {right + 0.25, 0.5}, {2, 4}, "quad4");
  json["bodies"].push_back(other);
  return json;
}

TEST(StartCheck, thin_walls_with_soil_on_both_sides) {
  const auto found = thin_walls<2>(plate_between(0.1, 1.2));
  ASSERT_EQ(found.size(), 1u);
  expect_parts(found[0], {"/rigid_walls/0/surface", "both sides of \"ram\"", "0.1 m thick",
                          "0.4 cells of 0.25 m", "advised: cells of at most half the thickness"});
  EXPECT_EQ(thin_walls<2>(plate_between(0.25, 1.35)).size(), 1u);
  EXPECT_EQ(thin_walls<2>(plate_between(0.49, 1.55)).size(), 1u);
  EXPECT_TRUE(thin_walls<2>(plate_between(0.5, 1.6)).empty());  // as thick as two cells
  Json one_side = plate_between(0.1, 1.2);
  one_side["bodies"].erase(1);
  EXPECT_TRUE(thin_walls<2>(one_side).empty());
}

/// Bodies of two groups, one left and one right of the plate.
Json parted(Json json) {
  json["contact_groups"] = {
      {"groups", {{{"name", "a"}, {"bodies", {"soil"}}}, {{"name", "b"}, {"bodies", {"other"}}}}},
      {"pairs", {{{"groups", {"a", "b"}}, {"friction", 0.3}}}}};
  return json;
}

/// Soil of two groups has nodes for each side: nothing acts on itself, unless a group has soil on
/// both sides.
TEST(StartCheck, thin_walls_between_groups) {
  Json json = parted(plate_between(0.1, 1.2));
  EXPECT_TRUE(thin_walls<2>(json).empty());
  json["bodies"].push_back(json["bodies"][1]);
  json["bodies"][2]["name"] = "more";
  json["bodies"][2]["mesh"] = box({0.5, 0.5}, {1, 1}, {4, 4}, "quad4");
  json["contact_groups"]["groups"][1]["bodies"].push_back("more");
  EXPECT_EQ(thin_walls<2>(json).size(), 1u);
}

/// Each face may be a surface of its own.
TEST(StartCheck, thin_walls_of_two_surfaces) {
  Json json = plate_between(0.1, 1.2);
  json["rigid_walls"].push_back(json["rigid_walls"][0]);
  json["rigid_walls"][1]["name"] = "back";
  json["rigid_walls"][0]["surface"]["polyline"] = {{1.05, 0.6}, {1.05, -0.1}};
  json["rigid_walls"][1]["surface"]["polyline"] = {{1.15, -0.1}, {1.15, 0.6}};
  const auto found = thin_walls<2>(json);
  ASSERT_EQ(found.size(), 1u);
  expect_parts(found[0], {"the wall between \"ram\" and \"back\"", "0.1 m thick"});
}

TEST(StartCheck, thin_walls_in_space) {
  Json json = below_block(0.5);
  auto& surface = json["interfaces"][0]["surface"];
  surface["mesh"] = box({0, 0, 0.5}, {1, 1, 0.6}, {4, 4, 1}, "hex8");
  surface["groups"] = {"bottom", "top"};
  EXPECT_EQ(thin_walls<3>(json).size(), 0u);
  json["bodies"].push_back(json["bodies"][0]);
  json["bodies"][1]["name"] = "above";
  json["bodies"][1]["mesh"] = box({0, 0, 0.75}, {1, 1, 1.25}, {4, 4, 2}, "hex8");
  EXPECT_EQ(thin_walls<3>(json).size(), 1u);
}

/// Soil that comes to the other side while the run goes on is told once, unless groups part it.
TEST(StartCheck, thin_walls_that_soil_comes_round) {
  for (const std::string method : {"facets", "boundary_points", "groups"}) {
    Json json = plate_between(0.4, 1.5);
    if (method == "groups") {
      json = parted(json);
    } else {
      json["rigid_walls"][0]["method"] = method;
    }
    json["bodies"][1]["mesh"] = box({1.6, 0}, {1.85, 0.5}, {2, 4}, "quad4");
    json["bodies"][0]["velocity"] = {10, 0};
    json["bodies"][1]["velocity"] = {-10, 0};
    const auto settings = mpm_settings<2>(json);
    const auto surfaces = surfaces_of(settings);
    const auto solver = mpm_solver<2>(json);
    mpm::ThinWalls<2> walls(surfaces, 0.25);
    std::vector<std::string> told;
    for (int n = 1; n <= 20; ++n) {
      const StepRequest request{n, 0, (n - 1) * 0.002, 0.002};
      InterfaceValues sent;
      solver->solve_step(request, {}, sent);
      solver->accept_step(request, true);
      for (auto& text : walls.after_step(comm(), solver->surfaces(), 0.002 * n, solver->points(),
                                         settings.body_groups)) {
        told.push_back(std::move(text));
      }
    }
    ASSERT_EQ(told.size(), method == "groups" ? 0u : 1u) << method;
    if (told.empty()) continue;
    expect_parts(told[0], {"both sides of \"ram\" at 0.0", "0.4 m thick", "1.6 cells"});
  }
}

TEST(StartCheck, a_wall_and_an_interface_of_one_name) {
  Json json = walled(1);
  json["interfaces"] = json["rigid_walls"];
  expect_refused(json, {"/rigid_walls/0/name", "ram", "interface"});
}

}  // namespace
}  // namespace gabion::test::test_start_check
