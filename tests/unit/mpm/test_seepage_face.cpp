// SPDX-License-Identifier: BSD-3-Clause
// Soil whose pore water drains through its own surface, in whole scenes.
#include <gtest/gtest.h>

#include <cmath>

#include "solver_program/ranked_state.hpp"
#include "tests/support/expect_error.hpp"
#include "tests/unit/mpm/saturated_soil.hpp"

namespace gabion::test::test_seepage_face {
namespace {

constexpr double pi = 3.14159265358979324;

/// Saturated soil that is laid at once between smooth walls on an impervious base, its surface
/// free: it settles under its own weight as its water comes out on top.
struct Layer {
  int dim = 2, axis = 1;  ///< against which gravity acts
  int cells = 10;
  double height = 1;  ///< by `cells` cells of 0.1 m: 1 + offset / cells
  std::string basis = "gimp", locking = "fbar";
};
constexpr double E = 10e6, nu = 0.2, k = 9.81e-7, g = 9.81;
constexpr double M = 11.1111111e6, c_v = M * 1e-10;

Json layer_scene(const Layer& layer) {
  const double h = 1.0 / layer.cells;
  const int dim = layer.dim;
  std::vector<double> low(dim, 0.0), high(dim, h), top(dim, h), gravity(dim, 0.0);
  std::vector<int> count(dim, 1), grid_count(dim, 1);
  high[layer.axis] = layer.height;
  top[layer.axis] = 1 + 2 * h;
  count[layer.axis] = layer.cells + (layer.height > 1 ? 1 : 0);
  grid_count[layer.axis] = layer.cells + 2;
  gravity[layer.axis] = -g;
  const std::string type = dim == 2 ? "quad4" : "hex8";
  Json json = {{"dimension", dim},
               {"grid", box(low, top, grid_count, type)},
               {"basis", layer.basis},
               {"analysis", "quasi_static"},
               {"gravity", gravity},
               {"walls", Json::array()},
               {"bodies",
                {body("soil", box(low, high, count, type), 1 << dim,
                      elastic_soil("hencky_elastic", E, nu, saturated_density))}},
               {"locking", {{"method", layer.locking}}}};
  const std::vector<std::string> sides =
      dim == 2 ? std::vector<std::string>{"left", "right", "bottom", "top"}
               : std::vector<std::string>{"left", "right", "front", "back", "bottom", "top"};
  for (int side = 0; side < 2 * dim; ++side) {
    if (side != 2 * layer.axis + 1) json["walls"].push_back(wall(sides[side], "slip"));
  }
  json["bodies"][0]["water"] = pore_water;
  json["bodies"][0]["water"]["permeability"] = k;
  json["bodies"][0]["water"]["bulk_modulus"] = 2.2e11;
  return json;
}

mpm::PoreWater water_of(double K_w) {
  mpm::PoreWater water;
  water.porosity = porosity;
  water.bulk_modulus = K_w;
  water.cavitation = 1e9;
  return water;
}

/// Excess pressure by that under the layer at the start, z from the surface by the height.
double excess(double z, double T) {
  double sum = 0;
  for (int i = 0; i < 200; ++i) {
    const double l = (2 * i + 1) * pi / 2;
    sum += (i % 2 == 0 ? 2 : -2) / (l * l) * std::sin(l * z) * std::exp(-l * l * T);
  }
  return sum;
}
double degree(double T) {
  double sum = 1;
  for (int i = 0; i < 200; ++i) {
    const double l = (2 * i + 1) * pi / 2;
    sum -= (i % 2 == 0 ? 4 : -4) / (l * l * l) * std::exp(-l * l * T);
  }
  return sum;
}

struct Settled {
  double excess = 0;  ///< largest difference of the excess pressure, by that under the layer
  double degree = 0;  ///< settlement by its final value
  double lost = 0;    ///< water of the points and out of them, by what went out
};

template <int dim>
Settled settle(const Layer& layer, double T, int steps) {
  const auto solver = mpm_solver<dim>(layer_scene(layer));
  const auto content = [&] {
    const auto& points = solver->points();
    double sum = 0;
    for (std::int32_t p = 0; p < points.size(); ++p) sum += points.V0[p] * points.water[p];
    return sum;
  };
  const double before = content();
  const double H = layer.height, G = (saturated_density - water_density) * g;
  run_steps(*solver, T * H * H / c_v / steps, steps);
  const mpm::PoreWater water = water_of(2.2e11);
  const auto& points = solver->points();
  Settled result;
  double strain = 0, volume = 0;
  for (std::int32_t p = 0; p < points.size(); ++p) {
    const double z = H - points.x[p][layer.axis];
    const double p_e = water.at(points.water[p], points.J[p]).p - water_density * g * z;
    result.excess = std::max(result.excess, std::abs(p_e / (G * H) - excess(z / H, T)));
    strain += points.V0[p] * (1 - points.J[p]);
    volume += points.V0[p];
  }
  result.degree = strain / volume * 2 * M / (G * H);
  const double out = probe(*solver, "water_out") / water_density;
  result.lost = (before - content() - out) / out;
  return result;
}

template <int dim>
void expect_settled(const Layer& layer) {
  SCOPED_TRACE(layer.basis + " " + layer.locking + " " + std::to_string(layer.axis) + " " +
               std::to_string(layer.height));
  const Settled at = settle<dim>(layer, 0.2, 40);
  EXPECT_LT(at.excess, layer.basis == "gimp" ? 0.005 : 0.012);
  EXPECT_NEAR(at.degree, degree(0.2), 0.01);
  EXPECT_NEAR(at.lost, 0, 1e-9);
}

TEST(SeepageFace, layer_settles_under_its_own_weight) {
  for (const char* basis : {"gimp", "bspline"}) {
    for (const char* locking : {"fbar", "none"}) {
      for (const double height : {1.0, 1 + 0.1 / 3, 1.05, 1.09}) {
        expect_settled<2>({.height = height, .basis = basis, .locking = locking});
      }
    }
  }
}

TEST(SeepageFace, layer_settles_along_any_axis) {
  expect_settled<2>({.axis = 0, .height = 1 + 0.1 / 3});
  for (const int axis : {0, 1, 2}) expect_settled<3>({.dim = 3, .axis = axis, .height = 1.05});
}

/// Water that rises through the soil from below has no pressure at the surface, wherever that is in
/// its cell. The pressure of the points goes to zero there to a part of a cell.
TEST(SeepageFace, pressure_ends_at_the_surface) {
  for (const char* basis : {"gimp", "bspline"}) {
    for (const double offset : {0.0, 1.0 / 3, 0.5, 0.9}) {
      SCOPED_TRACE(std::string(basis) + " " + std::to_string(offset));
      Json json = layer_scene({.height = 1 + 0.1 * offset, .basis = basis});
      const double table = 1.5;
      json["bodies"][0]["initial_stress"] = {
          {"k0", 0.5}, {"surface", table}, {"water_table", table}, {"max_displacement", 0.1}};
      for (Json& each : json["walls"]) {
        if (each["group"] == "bottom") each["drained"] = true;
      }
      const auto solver = mpm_solver<2>(json);
      run_steps(*solver, 1e7, 1);
      const auto& points = solver->points();
      const mpm::PoreWater water = water_of(2.2e11);
      const double gradient = table / (1 + 0.1 * offset);
      double worst = 0;
      for (std::int32_t p = 0; p < points.size(); ++p) {
        const double head =
            water.at(points.water[p], points.J[p]).p / (water_density * g * gradient);
        worst = std::max(worst, std::abs(head - (1 + 0.1 * offset - points.x[p][1])));
      }
      EXPECT_LT(worst, 0.05 * 0.1) << worst / 0.1;
    }
  }
}

/// No water gets in from air: soil that hangs on its base, which sucks, keeps its water.
TEST(SeepageFace, lets_no_water_in) {
  Json json = layer_scene({});
  for (Json& each : json["walls"]) {
    if (each["group"] == "bottom") each["drained"] = true;
  }
  const auto solver = mpm_solver<2>(json);
  run_steps(*solver, 1 / c_v, 10);
  const auto& points = solver->points();
  const mpm::PoreWater water = water_of(2.2e11);
  double most = 0;
  for (std::int32_t p = 0; p < points.size(); ++p) {
    const double suction = -water.at(points.water[p], points.J[p]).p;
    most = std::max(most, suction / (water_density * g));
  }
  EXPECT_NEAR(most, 0.95, 0.1);
}

/// Largest difference of the excess pressure of a layer on rigid walls, by that under it.
double error_on_facets(double offset, bool with_side) {
  const double h = 0.1, low = h * (1 + offset), side = 2 * h, T = 0.2;
  Json json = layer_scene({});
  const double width = with_side ? side + 3 * h : side;
  json["grid"] = box({0, 0}, {width, 1 + 4 * h}, {with_side ? 5 : 2, 14}, "quad4");
  json["bodies"][0]["mesh"] = box({0, low}, {side, low + 1}, {2, 10}, "quad4");
  json["walls"] = {wall("left", "slip")};
  if (!with_side) json["walls"].push_back(wall("right", "slip"));
  Json line = {{side, low + 1.2}, {side, low}, {-h, low}};
  if (!with_side) line = {{side + h, low}, {-h, low}};
  json["rigid_walls"] = {
      {{"name", "wall"}, {"surface", {{"polyline", line}, {"spacing", 0.05}}}, {"friction", 0}}};
  const auto solver = mpm_solver<2>(json);
  run_steps(*solver, T / c_v / 40, 40);
  const auto& points = solver->points();
  double top = 0, worst = 0;
  for (const auto& x : points.x) top = std::max(top, x[1] + 0.25 * h);
  for (std::int32_t p = 0; p < points.size(); ++p) {
    const double z = top - points.x[p][1];
    const double p_e = water_of(2.2e11).at(points.water[p], points.J[p]).p - water_density * g * z;
    const double scaled = p_e / ((saturated_density - water_density) * g);
    worst = std::max(worst, std::abs(scaled - excess(z, T)));
  }
  return worst;
}

/// A floor and a side of facets close the soil as walls of the grid do, wherever the lines of the
/// grid lie. Contact at the side yields, so the soil is strained there; a side that drains would
/// leave no excess at all.
TEST(SeepageFace, ends_at_rigid_walls) {
  for (const double offset : {0.0, 1.0 / 3, 0.5}) {
    EXPECT_LT(error_on_facets(offset, false), 0.02) << offset;
    EXPECT_LT(error_on_facets(offset, true), 0.1) << offset;
  }
}

double outflow_of(const Json& json, int dim) {
  const double dt = 0.05 / c_v;
  if (dim == 2) {
    const auto solver = mpm_solver<2>(json);
    run_steps(*solver, dt, 4);
    return probe(*solver, "water_out");
  }
  const auto solver = mpm_solver<3>(json);
  run_steps(*solver, dt, 4);
  return probe(*solver, "water_out");
}

/// The outflow does not depend on how points are laid: by triangles, or by cells that are taller
/// than those of the grid are wide.
TEST(SeepageFace, is_on_top_only_however_points_are_laid) {
  const double regular = outflow_of(layer_scene({}), 2);
  for (const int points : {6, 12}) {
    Json json = layer_scene({});
    json["bodies"][0]["mesh"] = box({0, 0}, {0.1, 1}, {1, 10}, "tri3");
    json["bodies"][0]["points_per_cell"] = points;
    EXPECT_NEAR(outflow_of(json, 2), regular, 0.03 * regular) << points;
  }
  for (const int across : {2, 3, 4}) {
    Json json = layer_scene({});
    json["bodies"][0]["mesh"] = box({0, 0}, {0.1, 1}, {across, 10}, "quad4");
    EXPECT_NEAR(outflow_of(json, 2), regular, 0.01 * regular) << across;
  }
  const Layer space{.dim = 3, .axis = 2};
  Json json = layer_scene(space);
  json["bodies"][0]["mesh"] = box({0, 0, 0}, {0.1, 0.1, 1}, {2, 2, 10}, "hex8");
  const double regular_in_space = outflow_of(layer_scene(space), 3);
  EXPECT_NEAR(outflow_of(json, 3), regular_in_space, 0.01 * regular_in_space);
}

/// The surface of still slimmer cells would not be found.
TEST(SeepageFace, slim_cells_are_refused) {
  Json json = layer_scene({});
  json["bodies"][0]["mesh"] = box({0, 0}, {0.1, 1}, {5, 10}, "quad4");
  expect_error<ConfigError>([&] { mpm_settings<2>(json); },
                            {"/bodies/0/mesh", "1 to 5", "1 to 4", "seepage_face"});
  json["bodies"][0]["water"]["free_surface"] = "impervious";
  EXPECT_NO_THROW(mpm_settings<2>(json));
  json = layer_scene({.dim = 3, .axis = 2});
  json["bodies"][0]["mesh"] = box({0, 0, 0}, {0.1, 0.1, 1}, {3, 3, 10}, "hex8");
  EXPECT_NO_THROW(mpm_settings<3>(json));
  json["bodies"][0]["mesh"] = box({0, 0, 0}, {0.1, 0.1, 1}, {4, 3, 10}, "hex8");
  expect_error<ConfigError>([&] { mpm_settings<3>(json); }, {"/bodies/0/mesh", "1 to 4", "1 to 3"});
}

/// Soil with coarser points on top closes the surface.
TEST(SeepageFace, coarser_soil_is_no_air) {
  for (const int points : {4, 9, 16}) {
    Json json = layer_scene({});
    json["bodies"][0]["points_per_cell"] = points;
    json["bodies"].push_back(body("top", box({0, 1}, {0.1, 1.2}, {1, 2}, "quad4"), 1,
                                  elastic_soil("hencky_elastic", E, nu, saturated_density)));
    EXPECT_EQ(outflow_of(json, 2), 0) << points;
  }
}

/// The surface is found from the places of the points, so a run that goes on has the same one.
TEST(SeepageFace, run_that_goes_on_is_the_same) {
  const Json json = layer_scene({.cells = 4});
  const auto straight = mpm_solver<2>(json), first = mpm_solver<2>(json),
             second = mpm_solver<2>(json);
  const double dt = 0.02 / c_v;
  run_steps(*straight, dt, 8);
  run_steps(*first, dt, 3);
  load_gathered(comm(), gather_state(comm(), first->save_state()), *second);
  run_steps(*second, dt, 5, 4);
  EXPECT_TRUE(same_bits<2>(second->points(), straight->points()));
  EXPECT_EQ(second->probes(), straight->probes());
}

TEST(SeepageFace, impervious_surface_keeps_the_water) {
  Json json = layer_scene({});
  json["bodies"][0]["water"]["free_surface"] = "impervious";
  const auto solver = mpm_solver<2>(json);
  run_steps(*solver, 0.1 / c_v, 2);
  EXPECT_EQ(probe(*solver, "water_out"), 0);
}

TEST(SeepageFace, settings_that_are_refused) {
  for (const char* key : {"free_surface", "permeability_law"}) {
    Json json = layer_scene({});
    json["bodies"][0]["water"].erase("permeability");
    json["bodies"][0]["water"][key] =
        std::string(key) == "free_surface" ? "impervious" : "kozeny_carman";
    expect_error<ConfigError>([&] { mpm_settings<2>(json); },
                              {"/bodies/0/water/" + std::string(key), "permeability"});
    json["bodies"][0]["water"]["permeability"] = k;
    json["bodies"][0]["water"][key] = "open";
    expect_error<ConfigError>([&] { mpm_settings<2>(json); },
                              {"/bodies/0/water/" + std::string(key), "open"});
  }
}

}  // namespace
}  // namespace gabion::test::test_seepage_face
