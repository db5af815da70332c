// SPDX-License-Identifier: BSD-3-Clause
// Constants that vary in space: their sources, and what is wrong with settings.
#include <gtest/gtest.h>

#include <cmath>
#include <filesystem>
#include <fstream>

#include "common/hdf5/hdf5_file.hpp"
#include "mpm_solver/parameters/box_field.hpp"
#include "mpm_solver/parameters/raster.hpp"
#include "tests/support/expect_error.hpp"
#include "tests/unit/mpm/mpm_scene.hpp"

namespace gabion::test::test_varying_values {
namespace {

/// A file of the tests with this content.
std::string file(const std::string& name, const std::string& content) {
  const std::string path = testing::TempDir() + "gabion_varying_" + name;
  std::ofstream(path) << content;
  return path;
}

Json clay() {
  Json material = elastic_soil("tresca", 1e7, 0.3, 2000);
  material["cohesion"] = 1e4;
  return material;
}

Json by_depth(const Json& rows, const Json& below) {
  return {{"by_depth", rows}, {"below", below}};
}

template <int dim>
Json scene_of(const Json& material) {
  std::vector<double> low(dim, 0.0), high(dim, 2.0);
  const std::vector<int> cells(dim, 4);
  const char* type = dim == 2 ? "quad4" : "hex8";
  return {{"dimension", dim},
          {"grid", box(low, high, cells, type)},
          {"bodies", {body("soil", box(low, high, cells, type), dim == 2 ? 4 : 8, material)}}};
}

/// Values of the points of a scene, and what they should be.
template <int dim, class Expected>
void expect_values(const Json& material, int column, const Expected& expected, double tolerance) {
  const auto solver = mpm_solver<dim>(scene_of<dim>(material));
  const auto& points = solver->points();
  ASSERT_EQ(points.parameters.size(), points.x.size());
  for (std::int32_t p = 0; p < points.size(); ++p) {
    EXPECT_NEAR(points.parameters[p][column], expected(points.x[p]), tolerance);
    for (int k = column + 1; k < 4; ++k) EXPECT_EQ(points.parameters[p][k], 0);
  }
}

template <int dim = 2>
void expect_refused(const Json& material, const std::vector<std::string_view>& parts) {
  expect_error<ConfigError>([&] { make_mpm(scene_of<dim>(material)); }, parts);
}

TEST(VaryingValues, by_depth_below_level_and_line) {
  Json material = clay();
  material["cohesion"] = by_depth({{0, 1e4}, {1, 2e4}, {5, 2e4}}, 2);
  expect_values<2>(
      material, 0, [](const Vector<2>& x) { return 1e4 * (1 + std::min(1.0, 2 - x[1])); }, 1e-9);
  material["cohesion"] = by_depth({{0, 1e4}, {5, 6e4}}, {{"line", {{-1, 2}, {1, 2}, {3, 4}}}});
  expect_values<2>(
      material, 0,
      [](const Vector<2>& x) { return 1e4 * (1 + 2 + std::max(0.0, x[0] - 1) - x[1]); }, 1e-9);
}

TEST(VaryingValues, raster_is_bilinear_in_world_coordinates) {
  // 100 + 10 (x - 500) + 20 (y - 300), at the centres of cells of 2 m.
  const std::string path = file("raster.asc",
                                "ncols 3\nnrows 3\nxllcorner 498\nyllcorner 298\ncellsize 2\n"
                                "NODATA_value -9999\n150 170 190\n110 130 150\n70 90 -9999\n");
  const mpm::Raster raster = mpm::read_raster(path, {500, 300});
  EXPECT_NEAR(raster.at({-0.3, 1.2}), 100 - 3 + 24 - 0, 1e-12);
  EXPECT_NEAR(raster.at({1, 1}), 130, 1e-12);
  EXPECT_NEAR(raster.at({-1, -1}), 70, 1e-12);
  expect_error<ConfigError>(
      [&] {
        raster.at({1.5, 0.2});
      },
      {path, "no data in row 3, column 3", "(1.5, 0.2)"});
  expect_error<ConfigError>(
      [&] {
        raster.at({0.5, 3.2});
      },
      {path, "reaches from (-1, -1) to (3, 3)", "(0.5, 3.2)"});
}

TEST(VaryingValues, raster_as_value_and_as_surface) {
  const std::string path = file("plan.asc",
                                "ncols 2\nnrows 2\nxllcenter 9\nyllcenter 19\ncellsize 4\n"
                                "14000 18000\n10000 14000\n");
  Json material = clay();
  material["cohesion"] = {{"raster", path}};
  Json scene = scene_of<3>(material);
  scene["origin"] = {10, 20, 5};
  const auto solver = mpm_solver<3>(scene);
  for (std::int32_t p = 0; p < solver->points().size(); ++p) {
    const Vector<3>& x = solver->points().x[p];
    EXPECT_NEAR(solver->points().parameters[p][0], 1e4 + 1e3 * (x[0] + 1) + 1e3 * (x[1] + 1), 1e-8);
  }
  scene["origin"] = {20, 20, 5};
  expect_error<ConfigError>([&] { make_mpm(scene); }, {"plan.asc", "it reaches from (-11, -1)",
                                                       "material point 0 of \"soil\""});
  expect_refused<2>(material, {"/bodies/0/material/cohesion/raster", "section", "field"});

  const std::string ground = file("ground.asc",
                                  "ncols 2\nnrows 2\nxllcenter -1\nyllcenter -1\n"
                                  "cellsize 4\n2 4\n2 4\n");
  material["cohesion"] = by_depth({{0, 1e4}, {9, 10e4}}, {{"raster", ground}});
  expect_values<3>(
      material, 0, [](const Vector<3>& x) { return 1e4 * (1 + 2 + (x[0] + 1) / 2 - x[2]); }, 1e-8);
}

TEST(VaryingValues, rasters_that_are_refused) {
  const auto refused = [](const std::string& name, const std::string& text,
                          const std::vector<std::string_view>& parts) {
    const std::string path = file(name, text);
    expect_error<ConfigError>([&] { mpm::read_raster(path, {0, 0}); }, parts);
  };
  const std::string head = "ncols 2\nnrows 2\nxllcorner 0\nyllcorner 0\ncellsize 1\n";
  refused("a.asc", head + "1 2\n3\n", {"fewer values than 2 rows of 2"});
  refused("a.asc", head + "1 2\n3 4\n5", {"line 8", "more values than 2 rows of 2"});
  refused("a.asc", head + "1 2\n3 four\n", {"line 7", "four", "allowed: a number"});
  refused("a.asc", "ncols 2\nnrows 1\n1 2\n", {"nrows", "found 1", "at least 2"});
  refused("a.asc", "ncols 2\nnrows 2\nyllcorner 0\ncellsize 1\n1 2\n3 4\n",
          {"exactly one of xllcorner and xllcenter"});
  refused("a.asc", "ncols 2\nnrows 2\ndx 1\n", {"line 3", "dx", "allowed: ncols"});
  refused("a.asc", "ncols 2\nnrows 2\nxllcorner 0\nyllcorner 0\ncellsize 0\n1 2\n3 4\n",
          {"cellsize", "found 0"});
  refused("a.tif", "II", {"a.tif", ".asc", "gdal_translate"});
  expect_error<ConfigError>([] { mpm::read_raster("/no/such.asc", {0, 0}); }, {"/no/such.asc"});
}

/// An HDF5 file with f = 1 + 2 x + 3 y + x y at the nodes.
std::string field_file(bool with_hole) {
  const std::string path = testing::TempDir() + "gabion_varying_field.h5";
  const std::vector<double> x = {-1, 0.5, 3}, y = {0, 2};
  std::vector<double> values;
  for (const double a : x) {
    for (const double b : y) values.push_back(1 + 2 * a + 3 * b + a * b);
  }
  if (with_hole) values.back() = std::nan("");
  Hdf5File out(path);
  out.write("x", 1, x);
  out.write("y", 1, y);
  out.write("values", 2, values);
  out.finish();
  return path;
}

TEST(VaryingValues, box_field_is_multilinear) {
  const auto field = mpm::read_box_field<2>(field_file(false));
  for (const Vector<2>& x : {Vector<2>(-1, 0), Vector<2>(0.1, 1.3), Vector<2>(3, 2)}) {
    EXPECT_NEAR(field.at(x), 1 + 2 * x[0] + 3 * x[1] + x[0] * x[1], 1e-12);
  }
  expect_error<ConfigError>([&] { field.at({3.1, 0}); }, {"x = -1 to 3", "3.1"});
  const auto holed = mpm::read_box_field<2>(field_file(true));
  EXPECT_NEAR(holed.at({0, 1}), 4, 1e-12);
  expect_error<ConfigError>([&] { holed.at({1, 1}); }, {"nan", "(1, 1)", "allowed: a number"});
  mpm::BoxField<3> cube{.path = "cube", .axes = {{{0, 1}, {0, 2}, {0, 4}}}};
  for (const double a : cube.axes[0]) {
    for (const double b : cube.axes[1]) {
      for (const double c : cube.axes[2]) cube.values.push_back(1 + a + 2 * b * c + a * b * c);
    }
  }
  EXPECT_NEAR(cube.at({0.3, 1.2, 3}), 1 + 0.3 + 2 * 3.6 + 0.3 * 3.6, 1e-12);
}

TEST(VaryingValues, box_field_of_a_scene) {
  Json material = clay();
  material["young_modulus"] = {{"field", field_file(false)}};
  expect_values<2>(
      material, 0, [](const Vector<2>& x) { return 1 + 2 * x[0] + 3 * x[1] + x[0] * x[1]; }, 1e-12);
  const std::string path = testing::TempDir() + "gabion_varying_wrong.h5";
  const auto write = [&](int columns, const std::vector<double>& x) {
    Hdf5File out(path);
    out.write("x", 1, x);
    out.write("y", 1, std::vector<double>{0, 2});
    out.write("values", columns, std::vector<double>(6, 1.0));
    out.finish();
  };
  material["young_modulus"] = {{"field", path}};
  write(3, {0, 1, 2});
  expect_refused(material, {"wrong.h5", "values", "[2, 3]", "allowed: [3, 2]"});
  write(2, {0, 2, 2});
  expect_refused(material, {"wrong.h5", "dataset x", "2 after 2", "ascending"});
  material["young_modulus"] = {{"field", "none.h5"}};
  expect_refused(material, {"none.h5"});
}

TEST(VaryingValues, box_field_of_integers) {
  const std::string path = testing::TempDir() + "gabion_varying_integers.h5";
  Hdf5File out(path);
  out.write("x", 1, std::vector<std::int32_t>{-1, 3});
  out.write("y", 1, std::vector<std::int64_t>{0, 2});
  out.write("values", 2, std::vector<std::int64_t>{10, 20, 30, 60});
  out.finish();
  const auto field = mpm::read_box_field<2>(path);
  EXPECT_NEAR(field.at({0, 0.5}), 18.75, 1e-12);  // 0.75 (10 + 0.25 10) + 0.25 (30 + 0.25 30)
  Hdf5File wrong(path);
  wrong.write("x", 1, std::vector<double>{-1, 3});
  wrong.write("y", 1, std::vector<double>{0, 2});
  wrong.write_text("values", "10 20 30 60");
  wrong.finish();
  expect_error<ConfigError>([&] { mpm::read_box_field<2>(path); },
                            {path, "dataset values: found the shape [], allowed: [2, 2]"});
}

Json random(double mean, double cov) {
  return {
      {"random", {{"mean", mean}, {"cov", cov}, {"correlation_lengths", {2, 0.5}}, {"seed", 1}}}};
}

TEST(VaryingValues, random_values_are_correlated_as_wanted) {
  Json material = elastic_soil("mohr_coulomb", 1e7, 0.3, 2000);
  material["cohesion"] = random(1e4, 0.3);
  material["friction_angle"] = random(30, 0.1);
  material["friction_angle"]["random"]["correlated_with"] = {{"key", "cohesion"},
                                                             {"coefficient", -0.5}};
  for (const char* key : {"cohesion", "friction_angle"}) {
    material[key]["random"]["correlation_lengths"] = {0.05, 0.05};
  }
  Json scene = scene_of<2>(material);
  scene["bodies"][0]["mesh"] = box({0, 0}, {2, 2}, {40, 40}, "quad4");
  scene["grid"] = box({0, 0}, {2, 2}, {40, 40}, "quad4");
  const auto solver = mpm_solver<2>(scene);
  const auto& values = solver->points().parameters;
  double sums[3] = {};
  for (const auto& value : values) {
    const double a = (std::log(value[0]) - std::log(1e4)) / std::sqrt(std::log1p(0.09));
    const double b = (std::log(value[1]) - std::log(30)) / std::sqrt(std::log1p(0.01));
    sums[0] += a;
    sums[1] += b;
    sums[2] += a * b;
  }
  const auto n = static_cast<double>(values.size());
  const double half[] = {0.5 * std::sqrt(std::log1p(0.09)), 0.5 * std::sqrt(std::log1p(0.01))};
  EXPECT_NEAR(sums[0] / n, -half[0], 0.06);
  EXPECT_NEAR(sums[1] / n, -half[1], 0.06);
  EXPECT_NEAR(sums[2] / n, -0.5 + half[0] * half[1], 0.06);
}

TEST(VaryingValues, random_factor_of_a_trend) {
  Json material = clay();
  material["cohesion"] = random(1, 0.3);
  const auto alone = mpm_solver<2>(scene_of<2>(material));
  material["cohesion"]["by_depth"] = {{0, 1e4}, {2, 3e4}};
  material["cohesion"]["below"] = 2;
  expect_refused(material, {"/cohesion/random/mean", "one of them"});
  material["cohesion"]["random"].erase("mean");
  const auto both = mpm_solver<2>(scene_of<2>(material));
  for (std::int32_t p = 0; p < alone->points().size(); ++p) {
    const double trend = 1e4 * (3 - both->points().x[p][1]);
    EXPECT_NEAR(both->points().parameters[p][0], trend * alone->points().parameters[p][0],
                1e-12 * trend);
  }
}

TEST(VaryingValues, layers_below_surfaces) {
  Json material = clay();
  material["layers"] = {{{"below", 1.5}, {"cohesion", 2e4}},
                        {{"below", {{"line", {{0, 0.5}, {2, 1.5}}}}},
                         {"cohesion", by_depth({{0, 5e4}, {2, 7e4}}, 2)},
                         {"young_modulus", 5e7}}};
  const auto solver = mpm_solver<2>(scene_of<2>(material));
  const auto& points = solver->points();
  for (std::int32_t p = 0; p < points.size(); ++p) {
    const Vector<2>& x = points.x[p];
    const bool lowest = x[1] < 0.5 + 0.5 * x[0];
    const double c = lowest ? 5e4 + 1e4 * (2 - x[1]) : x[1] < 1.5 ? 2e4 : 1e4;
    EXPECT_NEAR(points.parameters[p][0], c, 1e-9);
    EXPECT_EQ(points.parameters[p][1], lowest ? 5e7 : 1e7);
  }
  material["layers"][0]["dilation_angle"] = 3;
  expect_refused(material, {"/material/layers/0/dilation_angle", "none in the material itself"});
  material["layers"][0].erase("dilation_angle");
  material["layers"][0]["density"] = 3;
  expect_refused(material, {"/material/layers/0/density", "unknown key"});
}

TEST(VaryingValues, settings_that_are_refused) {
  Json material = clay();
  const auto cohesion = [&](const Json& value) {
    Json with = material;
    with["cohesion"] = value;
    return with;
  };
  const Json rows = {{0, 1e4}, {1, 1e4}, {2, -1e4}};
  expect_refused(cohesion(by_depth(rows, 2)), {"/bodies/0/material/cohesion: found -", "> 0",
                                               "material point 0 of \"soil\" at ("});
  expect_refused(cohesion(by_depth({{0, 1e4}, {1, 2e4}}, 2)),
                 {"/material/cohesion/by_depth", "depths from 0 to 1", "in the depth 1.8"});
  expect_refused(cohesion(by_depth({{0, 1e4}, {0, 2e4}}, 2)),
                 {"/cohesion/by_depth/1", "depth 0 after 0", "ascends"});
  expect_refused(cohesion(by_depth({{0, 1e4}}, 2)), {"/cohesion/by_depth", "at least 2"});
  expect_refused(cohesion({{"by_depth", {{0, 1}, {2, 1}}}}), {"/cohesion/below", "missing"});
  expect_refused(cohesion(Json::object()), {"/cohesion", "exactly one of by_depth"});
  expect_refused(cohesion({{"by_depht", {{0, 1}, {2, 1}}}}), {"/cohesion"});
  Json extra = by_depth({{0, 1e4}, {5, 2e4}}, 2);
  extra["depht"] = 1;
  expect_refused(cohesion(extra), {"/cohesion/depht", "unknown key"});
  extra.erase("depht");
  extra["raster"] = "x.asc";
  expect_refused(cohesion(extra), {"/cohesion/raster", "by_depth, raster"});
  expect_refused(cohesion(by_depth({{0, 1e4}, {5, 2e4}}, {{"line", {{0.5, 2}, {3, 2}}}})),
                 {"/below/line", "does not reach", "x = 0.1"});
  expect_refused(cohesion("strong"), {"/material/cohesion", "\"strong\""});
  material["density"] = random(2000, 0.1);
  expect_refused(material, {"/material/density", "does not vary", "cohesion"});
  material = clay();
  material["friction_angle"] = random(30, 0.1);
  expect_refused(material, {"/material/friction_angle", "unknown key"});
  material = clay();
  material["poisson_ratio"] = random(0.3, 0.1);
  expect_refused(material, {"/material/poisson_ratio", "does not vary"});
}

TEST(VaryingValues, random_settings_that_are_refused) {
  const auto cohesion = [](const std::string& key, const Json& value) {
    Json material = clay();
    material["cohesion"] = random(1e4, 0.3);
    material["cohesion"]["random"][key] = value;
    return material;
  };
  expect_refused(cohesion("cov", 0), {"/cohesion/random/cov"});
  expect_refused(cohesion("mean", -1), {"/cohesion/random/mean"});
  expect_refused(cohesion("seed", -1), {"/cohesion/random/seed"});
  expect_refused(cohesion("seed", 1.5), {"/cohesion/random/seed"});
  expect_refused(cohesion("step", {0.6, 0.1}), {"/cohesion/random/step", "0.6", "0.25"});
  expect_refused(cohesion("step", {0.5, 0.1, 0.1}), {"/cohesion/random/step", "3 numbers"});
  expect_refused(cohesion("correlation_lengths", {1e-6, 1e-6}), {"/correlation_lengths", "cells"});
  expect_refused(cohesion("correlated_with", {{"key", "young_modulus"}, {"coefficient", 0.5}}),
                 {"/correlated_with/key", "there is none"});
  Json material = clay();
  material["cohesion"] = random(1e4, 0.3);
  material["young_modulus"] = random(1e7, 0.3);
  material["young_modulus"]["random"]["correlated_with"] = {{"key", "cohesion"},
                                                            {"coefficient", 1}};
  expect_refused(material, {"/correlated_with/coefficient"});
  material["young_modulus"]["random"]["correlated_with"]["coefficient"] = 0.5;
  material["young_modulus"]["random"]["correlation_lengths"] = {4, 1};
  expect_refused(material, {"/correlated_with/key", "other correlation lengths"});
  material["young_modulus"]["random"].erase("mean");
  expect_refused(material, {"/young_modulus/random/mean", "missing"});
}

/// A strength in kPa is as suspicious as where it is one number.
TEST(VaryingValues, other_units_are_named) {
  Json material = clay();
  const auto warnings = [&](const Json& cohesion) {
    material["cohesion"] = cohesion;
    testing::internal::CaptureStderr();
    make_mpm(scene_of<2>(material));
    return testing::internal::GetCapturedStderr();
  };
  const std::string kilo = warnings(by_depth({{0, 10}, {2, 25}}, 2));
  EXPECT_NE(kilo.find("/bodies/0/material/cohesion: found 10.9375 Pa, next to none; in kPa"),
            std::string::npos)
      << kilo;
  EXPECT_EQ(warnings(by_depth({{0, 1e4}, {2, 2.5e4}}, 2)).find("cohesion: found"),
            std::string::npos);
}

/// Layers in the wrong order: the second one hides the first.
TEST(VaryingValues, a_layer_without_points_is_warned_of) {
  Json material = elastic_soil("mohr_coulomb", 1e7, 0.3, 2000);
  material["friction_angle"] = 30;
  material["cohesion"] = 1e4;
  const auto warnings = [&](const Json& layers) {
    material["layers"] = layers;
    testing::internal::CaptureStderr();
    make_mpm(scene_of<2>(material));
    return testing::internal::GetCapturedStderr();
  };
  const Json low = {{"below", 0.5}, {"cohesion", 2e4}}, high = {{"below", 1.0}, {"cohesion", 3e4}};
  const std::string part = "no material point of";
  EXPECT_EQ(warnings({high, low}).find(part), std::string::npos);
  const std::string said = warnings({low, high});
  EXPECT_NE(said.find("/bodies/0/material/layers/0/below: " + part), std::string::npos) << said;
  EXPECT_EQ(said.find("layers/1/below"), std::string::npos) << said;
}

TEST(VaryingValues, most_keys) {
  Json material = elastic_soil("mohr_coulomb", 1e7, 0.3, 2000);
  material["friction_angle"] = 30;
  material["cohesion"] = 1e4;
  material["dilation_angle"] = 2;
  material["tension_cutoff"] = 1e3;
  for (const char* key : {"friction_angle", "cohesion", "dilation_angle", "tension_cutoff"}) {
    material[key] = by_depth({{0, material[key]}, {2, material[key]}}, 2);
  }
  EXPECT_EQ(mpm_solver<2>(scene_of<2>(material))->points().parameters[0][3], 1e3);
  material["young_modulus"] = random(1e7, 0.3);
  expect_refused(material, {"found 5 constants that vary", "allowed: 4"});
}

}  // namespace
}  // namespace gabion::test::test_varying_values
