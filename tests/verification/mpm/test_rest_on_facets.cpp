// SPDX-License-Identifier: BSD-3-Clause
// Soil under initial stress between surfaces of facets.
#include <fmt/format.h>
#include <gtest/gtest.h>
#include <unistd.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <fstream>

#include "tests/support/cut_steps.hpp"
#include "tests/support/verification_row.hpp"
#include "tests/unit/mpm/mpm_scene.hpp"

namespace gabion::test {
namespace {

constexpr double density = 2000, g = 10, k0 = 0.5, H = 1;
constexpr int cells = 10;
constexpr double h = H / cells;

struct Scene {
  std::string basis;  // "tri3": linear, on triangles
  double E = 0;
  double at = 0;       // place of the wall in its cell, that of the floor as well
  bool floor = false;  // of facets; else a wall of the grid
  double max_displacement = 1e-3;
};

Json facets(const std::string& name, const Json& polyline) {
  return {{"name", name}, {"surface", {{"polyline", polyline}, {"spacing", h}}}, {"mode", "slip"}};
}

/// V12: soil of the height H between a smooth wall of the grid at x = 0 and one of facets.
Json at_rest(const Scene& scene) {
  Json sand = elastic_soil("mohr_coulomb", scene.E, 0.3, density);
  sand["friction_angle"] = 35;
  const std::string type = scene.basis == "tri3" ? "tri3" : "quad4";
  const double W = 1 + h * scene.at, low = scene.floor ? -h * scene.at : 0;
  const int below = scene.floor ? 2 : 0;
  Json json = {{"dimension", 2},
               {"grid", box({0, -below * h}, {1 + 3 * h, H + h}, {13, cells + 1 + below}, type)},
               {"basis", type == "tri3" ? "linear" : scene.basis},
               {"locking", {{"method", "none"}}},
               {"gravity", {0, -g}},
               {"walls", {wall("left", "slip")}},
               {"bodies",
                {body("soil", box({0, low}, {W, low + H}, {cells, cells}, type),
                      type == "tri3" ? 3 : 4, sand)}},
               {"rigid_walls", {facets("wall", {{W, H + h}, {W, scene.floor ? low : -H}})}}};
  if (scene.floor) {
    json["rigid_walls"].push_back(facets("floor", {{W, low}, {-1, low}}));
  } else {
    json["walls"].push_back(wall("bottom", "slip"));
  }
  json["bodies"][0]["initial_stress"] = {
      {"k0", k0}, {"surface", low + H}, {"max_displacement", scene.max_displacement}};
  return json;
}

/// K0 int sigma_v dd of compressed soil, by Simpson's rule over s: dd = (1 + s / C) ds / (rho g),
/// sigma_v = s exp(s / C).
double thrust(double E) {
  const double lambda = E * 0.3 / (1.3 * 0.4), mu = E / 2.6,
               C = (3 * lambda + 2 * mu) / (1 + 2 * k0);
  const double load = density * g * H, end = 2 * load / (1 + std::sqrt(1 + 2 * load / C));
  const auto value = [&](double s) {
    return k0 * s * std::exp(s / C) * (1 + s / C) / (density * g);
  };
  double sum = 0;
  constexpr int parts = 100;
  for (int k = 0; k < parts; ++k) {
    const double a = k * end / parts, b = (k + 1) * end / parts;
    sum += (b - a) / 6 * (value(a) + 4 * value(0.5 * (a + b)) + value(b));
  }
  return sum;
}

struct Bounds {
  double at_once = 0, later = 0;
  std::string limitation = {};
};

void verify_force(const Scene& scene, const std::string& when, double force, double bound,
                  const std::string& limitation) {
  verify({.id = "V12",
          .what = fmt::format(
              "K0 box, force on a wall by facets, {} at {} of a cell{}, E {:g} MPa, "
              "{}",
              scene.basis, scene.at, scene.floor ? ", floor by facets" : "", scene.E / 1e6, when),
          .exact = thrust(scene.E),
          .computed = force,
          .bound = bound,
          .unit = "N",
          .limitation = limitation});
}

void check_at_rest(const Scene& scene, const Bounds& bounds) {
  const auto solver = make_mpm(at_rest(scene));
  verify_force(scene, "at once", probe(*solver, "wall.fx"), bounds.at_once, "");
  const double stored = probe(*solver, "contact_energy"), weight = g * probe(*solver, "mass");
  EXPECT_GT(stored, 0);
  if (scene.floor) {
    EXPECT_NEAR(probe(*solver, "floor.fy"), -weight, 1e-6 * weight);
  }
  run_with_cuts(*solver, {.end = 0.5, .dt = 0.01, .dt_min = 1e-4});
  verify_force(scene, "after 0.5 s", probe(*solver, "wall.fx"), bounds.later, bounds.limitation);
  EXPECT_EQ(probe(*solver, "contact_friction"), 0);
  EXPECT_LT(probe(*solver, "contact_created"), 1e-9 * stored);
  if (!scene.floor) return;
  verify(
      {.id = "V12",
       .what = fmt::format("K0 box, weight on a floor by facets, {} at {} of a cell, E {:g} MPa, "
                           "after 0.5 s",
                           scene.basis, scene.at, scene.E / 1e6),
       .exact = -weight,
       .computed = probe(*solver, "floor.fy"),
       .bound = 1e-3,
       .unit = "N"});
}

constexpr int ramp_cells = 16;

/// Elastic soil of 1 m by 1 m takes its weight between smooth walls, one of them by facets; in
/// space a slice of one cell.
Json under_a_ramp(int dim, const std::string& basis, double E, double nu) {
  constexpr double size = 1.0 / ramp_cells;
  const auto along = [&](double x, double y) {
    return dim == 2 ? std::vector<double>{x, y} : std::vector<double>{x, 0, y};
  };
  const auto at = [&](double x, double y) {
    return dim == 2 ? std::vector<double>{x, y} : std::vector<double>{x, size, y};
  };
  const auto count = [&](int x, int y) {
    return dim == 2 ? std::vector<int>{x, y} : std::vector<int>{x, 1, y};
  };
  const std::string type = dim == 2 ? "quad4" : "hex8";
  Json json = {{"dimension", dim},
               {"analysis", "quasi_static"},
               {"grid", box(along(0, 0), at(1 + 3 * size, 1 + size),
                            count(ramp_cells + 3, ramp_cells + 1), type)},
               {"basis", basis},
               {"gravity", along(0, -g)},
               {"gravity_ramp", {{"duration", 0.5}}},
               {"walls", {wall("left", "slip"), wall("bottom", "slip")}},
               {"bodies",
                {body("soil", box(along(0, 0), at(1, 1), count(ramp_cells, ramp_cells), type),
                      dim == 2 ? 4 : 8, elastic_soil("linear_elastic", E, nu, density))}}};
  Json surface = {{"polyline", {{1, 1 + size}, {1, -size}}}, {"spacing", size}};
  if (dim == 3) {
    json["walls"].push_back(wall("front", "slip"));
    json["walls"].push_back(wall("back", "slip"));
    surface = {{"mesh", box({1, -1, -size}, {1.2, 1, 1 + size}, {1, 2, 4}, "hex8")},
               {"groups", {"left"}}};
  }
  json["rigid_walls"] = {{{"name", "wall"}, {"surface", surface}, {"mode", "slip"}}};
  return json;
}

void check_ramp(int dim, const std::string& basis, double E, double nu) {
  const auto solver = make_mpm(under_a_ramp(dim, basis, E, nu));
  run_with_cuts(*solver, {.end = 0.6, .dt = 0.1, .dt_min = 1e-3});
  verify({.id = "V12",
          .what = fmt::format(
              "thrust on a wall by facets, 16 cells from the other, of soil that took its "
              "weight in a ramp, {} in {}D, E {:g} MPa, nu {}",
              basis, dim, E / 1e6, nu),
          .exact = nu / (1 - nu) * density * g / 2 * (dim == 2 ? 1 : 1.0 / ramp_cells),
          .computed = probe(*solver, "wall.fx"),
          .bound = 0.03,
          .unit = "N"});
}

TEST(V12_RestOnFacets, soil_that_takes_its_weight) {
  for (const double E : {1e6, 1e7, 1e8}) {
    for (const std::string basis : {"linear", "gimp", "bspline"}) check_ramp(2, basis, E, 0.3);
    check_ramp(2, "linear", E, 0.49);
    check_ramp(3, "linear", E, 0.3);
  }
}

TEST(V12_RestOnFacets, gimp) {
  for (const double at : {0.0, 0.5, 0.25}) {
    check_at_rest({.basis = "gimp", .E = 1e5, .at = at}, {1e-4, 6e-5});
    check_at_rest({.basis = "gimp", .E = 2e7, .at = at}, {5e-7, 7e-7});
    check_at_rest({.basis = "gimp", .E = 1e8, .at = at}, {1e-7, 1e-7});
    check_at_rest({.basis = "gimp", .E = 1e5, .at = at, .floor = true}, {1e-4, 2e-3});
    check_at_rest({.basis = "gimp", .E = 1e8, .at = at, .floor = true}, {1e-7, 4e-4});
  }
}

TEST(V12_RestOnFacets, bspline) {
  for (const double at : {0.0, 0.5, 0.25}) {
    const double most = 0.05;
    check_at_rest({.basis = "bspline", .E = 1e5, .at = at, .max_displacement = most},
                  {1e-4, 0.012});
    check_at_rest({.basis = "bspline", .E = 2e7, .at = at}, {1e-6, 6e-3});
    check_at_rest({.basis = "bspline", .E = 1e8, .at = at, .floor = true}, {1e-6, 4e-3});
  }
}

TEST(V12_RestOnFacets, linear) {
  check_at_rest({.basis = "linear", .E = 1e5}, {1e-4, 1e-7});
  check_at_rest({.basis = "linear", .E = 1e5, .floor = true}, {1e-4, 3e-6});
  for (const double at : {0.0, 0.5, 0.25}) {
    const bool cut = at > 0;
    const std::string limit =
        cut ? "points of cut cells do not have the volume that lies in the cell" : "";
    check_at_rest({.basis = "linear", .E = 2e7, .at = at}, {1e-7, cut ? 0.06 : 1e-7, limit});
    check_at_rest({.basis = "linear", .E = 1e8, .at = at, .floor = true},
                  {1e-7, cut ? 0.05 : 1e-7, limit});
    check_at_rest({.basis = "tri3", .E = 2e7, .at = at}, {1e-6, cut ? 0.03 : 5e-3, limit});
  }
}

/// Explicit steps meet the contact where soil is at rest: they bear no other thrust, at once and on
/// the mean of what follows.
TEST(V12_RestOnFacets, explicit_steps) {
  constexpr double end = 0.1;
  for (const double dt : {1e-4, 1e-3}) {
    Scene scene{.basis = "gimp", .E = 2e7};
    Json json = at_rest(scene);
    json["time_integration"] = {{"scheme", "explicit"}};
    const auto solver = make_mpm(json);
    run_steps(*solver, dt, 1);
    const std::string steps = fmt::format("explicit steps of {} ms", dt * 1e3);
    verify_force(scene, "after one of the " + steps, probe(*solver, "wall.fx"), 1e-6, "");
    const int count = static_cast<int>(std::lround(end / dt));
    double sum = 0;
    for (int n = 2; n <= count; ++n) {
      run_steps(*solver, dt, 1, n);
      sum += probe(*solver, "wall.fx");
    }
    verify_force(scene, fmt::format("mean of {} s in {}", end, steps), sum / (count - 1), 1e-5, "");
  }
}

/// Columns of soil of the height H whose right side leans outwards by `lean`, as a Gmsh file.
std::string leaning_block(double lean) {
  const auto path =
      std::filesystem::temp_directory_path() / fmt::format("gabion_leaning_block_{}.msh", getpid());
  std::ofstream out(path);
  out.precision(17);
  const int n = cells + 1;
  out << fmt::format("$MeshFormat\n4.1 0 8\n$EndMeshFormat\n$Nodes\n1 {0} 1 {0}\n2 1 0 {0}\n",
                     n * n);
  for (int k = 1; k <= n * n; ++k) out << k << "\n";
  for (int j = 0; j < n; ++j) {
    for (int i = 0; i < n; ++i) out << i * h * (1 + lean * j * h) << " " << j * h << " 0\n";
  }
  out << fmt::format("$EndNodes\n$Elements\n1 {0} 1 {0}\n2 1 3 {0}\n", cells * cells);
  for (int k = 0; k < cells * cells; ++k) {
    const int a = 1 + k % cells + n * (k / cells);
    out << fmt::format("{} {} {} {} {}\n", k + 1, a, a + 1, a + n + 1, a + n);
  }
  out << "$EndElements\n";
  return path.string();
}

/// Soil on a rough wall that leans outwards: horizontal thrust and the weight of the soil above it.
TEST(V12_RestOnFacets, leaning_wall) {
  constexpr double lean = 0.3, E = 2e7;
  const std::string mesh = leaning_block(lean);
  Json json = at_rest({.basis = "linear", .E = E, .max_displacement = 1});
  json["grid"] = box({0, 0}, {1.5, 1.1}, {15, 11}, "quad4");
  json["bodies"][0]["mesh"] = {{"file", mesh}};
  json["rigid_walls"][0] = facets("wall", {{1 + 1.1 * lean, 1.1}, {1 - 0.1 * lean, -0.1}});
  json["rigid_walls"][0]["mode"] = "contact";
  json["rigid_walls"][0]["friction"] = 0.4;
  const auto solver = make_mpm(json);
  for (const bool later : {false, true}) {
    if (later) run_steps(*solver, 0.01, 50);
    for (const std::string part : {"fx", "fy"}) {
      verify({.id = "V12",
              .what = fmt::format(
                  "K0 box, {} on a rough wall by facets that leans outwards, linear, "
                  "E 20 MPa, {}",
                  part == "fx" ? "thrust" : "weight", later ? "after 0.5 s" : "at once"),
              .exact = part == "fx" ? thrust(E) : -lean / k0 * thrust(E),
              .computed = probe(*solver, "wall." + part),
              .bound = later ? 0.05 : 1e-6,
              .unit = "N"});
    }
  }
  std::filesystem::remove(mesh);
}

/// Soil in 3D rests between a wall of the grid and one of facets, on a floor of facets.
TEST(V12_RestOnFacets, in_3d) {
  constexpr int n = 4;
  constexpr double a = 0.25, W = 0.5625;
  Json sand = elastic_soil("mohr_coulomb", 1e7, 0.3, density);
  sand["friction_angle"] = 35;
  const auto plane = [&](const std::string& name, const Json& low, const Json& high,
                         const std::string& group) -> Json {
    return {{"name", name},
            {"mode", "slip"},
            {"surface",
             {{"mesh",
               {{"box", {{"low", low}, {"high", high}, {"cells", {2, 2, 4}}, {"type", "hex8"}}}}},
              {"groups", {group}}}}};
  };
  Json json = {
      {"dimension", 3},
      {"grid", box({0, 0, -0.5}, {1, 0.5, 1.25}, {4, 2, 7}, "hex8")},
      {"basis", "gimp"},
      {"locking", {{"method", "none"}}},
      {"gravity", {0, 0, -g}},
      {"walls", {wall("left", "slip"), wall("front", "slip"), wall("back", "slip")}},
      {"bodies",
       {body("soil", box({0, 0, -a / 2}, {W, 0.5, H - a / 2}, {2, 2, n}, "hex8"), 8, sand)}},
      {"rigid_walls",
       {plane("wall", {W, -0.5, -a / 2}, {0.9, 1, 1.5}, "left"),
        plane("floor", {-1, -0.5, -0.4}, {W, 1, -a / 2}, "top")}}};
  json["bodies"][0]["initial_stress"] = {{"k0", k0}, {"surface", H - a / 2}};
  const auto solver = make_mpm(json);
  const double weight = g * probe(*solver, "mass");
  for (const bool later : {false, true}) {
    if (later) run_steps(*solver, 0.01, 20);
    const std::string when = later ? "after 0.2 s" : "at once";
    verify({.id = "V12",
            .what = "K0 box in 3D, force on a wall by facets, gimp, " + when,
            .exact = 0.5 * thrust(1e7),
            .computed = probe(*solver, "wall.fx"),
            .bound = 2e-5,
            .unit = "N"});
    verify({.id = "V12",
            .what = "K0 box in 3D, weight on a floor by facets, gimp, " + when,
            .exact = -weight,
            .computed = probe(*solver, "floor.fz"),
            .bound = 2e-5,
            .unit = "N"});
  }
}

}  // namespace
}  // namespace gabion::test
