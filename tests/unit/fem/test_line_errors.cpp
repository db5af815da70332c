// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include <functional>

#include "tests/support/expect_error.hpp"
#include "tests/unit/fem/line_scene.hpp"
#include "tests/unit/fem/yielding_tower.hpp"

namespace gabion::test::test_line_errors {
namespace {

using Parts = std::vector<std::string_view>;

/// The two squares with a rope from the top to a node beside them.
GmshText guyed_tower() {
  GmshText file = two_groups();
  file.nodes.push_back({3, 0, 0});
  LineText rope{.nodes = {}, .lines = {{"rope", {{5, 7}}}}, .points = {{"anchor", {7}}}};
  rope.add_to(file, 5);
  return file;
}

Json guyed_scene(const std::string& file) {
  Json json = tower_scene(file);
  Json rope = of_group("rope", line_material("cable", 1e9, 1e-4, 7000));
  json["materials"].push_back(rope);
  json["supports"].push_back({{"group", "anchor"}, {"report_reaction", true}});
  return json;
}

void expect_refused(const GmshText& file, const std::function<void(Json&)>& change,
                    const Parts& parts) {
  const TemporaryMesh mesh(file);
  Json json = guyed_scene(mesh.path());
  change(json);
  expect_error<ConfigError>([&] { fem_solver<2>(json); }, parts);
}

void expect_rope_refused(const std::function<void(Json&)>& change, const Parts& parts) {
  expect_refused(
      guyed_tower(), [&](Json& json) { change(json["materials"][2]); }, parts);
}

TEST(LineErrors, rope_beside_cells_is_taken) {
  const TemporaryMesh mesh(guyed_tower());
  const auto solver = fem_solver<2>(guyed_scene(mesh.path()));
  EXPECT_EQ(solver->summary().at("lines"), 1);
  EXPECT_EQ(solver->summary().at("materials").at("rope"), "cable");
}

TEST(LineErrors, sections_and_laws) {
  expect_rope_refused([](Json& rope) { rope.erase("area"); }, {"/materials/2", "area"});
  expect_rope_refused([](Json& rope) { rope["area"] = 0; }, {"/materials/2/area", "0"});
  expect_rope_refused([](Json& rope) { rope["poisson_ratio"] = 0.3; },
                      {"/materials/2/poisson_ratio"});
  expect_rope_refused([](Json& rope) { rope["formulation"] = "full"; },
                      {"/materials/2/formulation"});
  expect_rope_refused([](Json& rope) { rope["pretension"] = -1; }, {"/materials/2/pretension"});
  expect_rope_refused(
      [](Json& rope) {
        rope["pretension"] = 1;
        rope["length_ratio"] = 1;
      },
      {"/materials/2/length_ratio", "pretension"});
  expect_rope_refused(
      [](Json& rope) {
        rope["brake_table"] = {{0, 1}};
      },
      {"/materials/2/brake_table"});
  expect_refused(guyed_tower(), [](Json& json) { json["materials"][0]["area"] = 1; },
                 {"/materials/0/area"});
}

TEST(LineErrors, brakes) {
  const auto with = [](const Json& rows) {
    return [rows](Json& rope) {
      rope["law"] = "brake";
      rope["brake_table"] = rows;
    };
  };
  expect_rope_refused([](Json& rope) { rope["law"] = "brake"; }, {"/materials/2", "brake_table"});
  expect_rope_refused(with({{0.1, 1}}), {"/materials/2/brake_table/0", "0.1", "0 in the first"});
  expect_rope_refused(with(Json::array()), {"/materials/2/brake_table", "at least one row"});
  expect_rope_refused(with({{0, 0}}), {"/materials/2/brake_table/0", "> 0"});
  expect_rope_refused(with({{0, 1}, {0.2, 1}, {0.2, 2}}), {"brake_table/2", "rising runs"});
  expect_rope_refused(with({{0, 1e5}, {1, 1e3}}), {"/materials/2/group", "99000", "tear"});
  expect_rope_refused(
      [&](Json& rope) {
        with({{0, 100}})(rope);
        rope["pretension"] = 200;
      },
      {"/materials/2/pretension", "200", "100"});
}

TEST(LineErrors, groups_of_lines) {
  expect_rope_refused([](Json& rope) { rope["group"] = "string"; },
                      {"belongs to no cell", "\"rope\""});
  expect_rope_refused([](Json& rope) { rope["group"] = "lower"; },
                      {"/materials/2/group", "lower", "second time"});
  expect_refused(guyed_tower(), [](Json& json) { json["materials"].erase(2); },
                 {"belongs to no cell", "\"rope\""});
  expect_refused(two_groups(), [](Json& json) { json["supports"].erase(1); },
                 {"/materials/2/group", "\"rope\"", "curves", "foot, top"});
  expect_refused(guyed_tower(),
                 [](Json& json) {
                   const Json rope = json["materials"][2];
                   json["materials"] = Json::array({rope});
                 },
                 {"/materials", "lines or membranes only", "quad4"});
  GmshText doubled = guyed_tower();
  doubled.groups.push_back({1, 20, "second"});
  doubled.entities.back().groups.push_back(20);
  expect_refused(doubled,
                 [](Json& json) {
                   json["materials"].push_back(of_group("second", line_material("cable", 1e9, 1)));
                 },
                 {"/materials/3/group", "line 0 near (2, 1)", "\"rope\" and \"second\""});
}

TEST(LineErrors, lines_of_the_file) {
  GmshText twice = guyed_tower();
  twice.blocks.back().elements.push_back({7, 5});
  expect_refused(twice, [](Json&) {}, {"/mesh/file", "line twice", "(1, 2)", "(3, 0)"});
  GmshText point = guyed_tower();
  point.blocks.back().elements.push_back({7, 7});
  expect_refused(point, [](Json&) {}, {"/mesh/file", "\"rope\"", "length 0", "> 0"});
}

/// In space curves may be labels, but not on nodes of their own.
TEST(LineErrors, curves_in_space_without_material) {
  LineText text = chain(2, 2);
  text.lines.push_back({"loose", {{4, 5}}});
  text.nodes.insert(text.nodes.end(), {{0, 1, 0}, {1, 1, 0}});
  const TemporaryMesh mesh(text.file());
  expect_error<ConfigError>(
      [&] { fem_solver<3>(line_scene(3, mesh.path(), line_material("truss", 1e9, 1e-4))); },
      {"/mesh/file", "\"loose\"", "no cell", "material"});
}

/// Conversion from other formats may write a line once for each of its groups: it is one line.
TEST(LineErrors, copies_of_a_line_are_labels) {
  GmshText file = guyed_tower();
  file.groups.push_back({1, 20, "other"});
  file.entities.back().groups.push_back(20);
  file.blocks.push_back(file.blocks.back());
  const TemporaryMesh mesh(file);
  const auto solver = fem_solver<2>(guyed_scene(mesh.path()));
  EXPECT_EQ(solver->summary().at("lines"), 1);
}

}  // namespace
}  // namespace gabion::test::test_line_errors
