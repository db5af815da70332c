// SPDX-License-Identifier: BSD-3-Clause
// Soil whose interfaces begin displaced.
#include <gtest/gtest.h>

#include <cmath>

#include "mpm_solver/placed_soil.hpp"
#include "tests/support/expect_error.hpp"
#include "tests/unit/mpm/mpm_scene.hpp"

namespace gabion::test::test_placed_soil {
namespace {

constexpr double dt = 1.0 / 1024;

template <int dim>
using Placed = mpm::PlacedSoil<dim>;

/// A block that falls on a floor below it, its bottom at 0.5. All numbers are sums of few powers of
/// two, so that X + u0 and u - u0 are exact.
Json above_floor_2d(double y, const std::string& method) {
  return {{"dimension", 2},
          {"grid", box({0, 0}, {1, 1}, {8, 8}, "quad4")},
          {"basis", "linear"},
          {"bodies",
           {body("soil", box({0.25, 0.5}, {0.75, 0.75}, {4, 2}, "quad4"), 4,
                 elastic_soil("neo_hookean", 1e5, 0.3, 1000), {0, -4})}},
          {"interfaces",
           {{{"name", "floor"},
             {"method", method},
             {"surface", {{"polyline", {{1, y}, {0, y}}}, {"spacing", 0.125}}}}}}};
}

Json above_floor_3d(double z, const std::string& method) {
  return {
      {"dimension", 3},
      {"grid", box({0, 0, 0}, {1, 1, 1}, {4, 4, 4}, "hex8")},
      {"basis", "linear"},
      {"bodies",
       {body("soil", box({0.25, 0.25, 0.5}, {0.75, 0.75, 0.75}, {2, 2, 1}, "hex8"), 8,
             elastic_soil("neo_hookean", 1e5, 0.3, 1000), {0, 0, -4})}},
      {"interfaces",
       {{{"name", "floor"},
         {"method", method},
         {"surface",
          {{"mesh", box({0, 0, z - 0.25}, {1, 1, z}, {4, 4, 1}, "hex8")}, {"groups", {"top"}}}}}}}};
}

template <int dim>
Json above_floor(double height, const std::string& method) {
  if constexpr (dim == 2) return above_floor_2d(height, method);
  return above_floor_3d(height, method);
}

template <int dim>
Placed<dim> placed_soil(const Json& json) {
  return Placed<dim>(comm(), mpm_settings<dim>(json), "");
}

/// Every vertex of the floor displaced along the last axis.
InterfaceValues raised(const Solver& soil, double u) {
  const auto meshes = soil.interfaces();
  const InterfaceMesh& mesh = meshes.at(0);
  InterfaceValues values;
  auto& list = values[mesh.name];
  for (std::int64_t v = 0; v < mesh.num_vertices(); ++v) {
    for (int c = 0; c < mesh.dim; ++c) list.push_back(c == mesh.dim - 1 ? u : 0);
  }
  return values;
}

/// Steps from `first` on, in each of which the floor rises by 1/1024 m. @returns  their forces
std::vector<InterfaceValues> steps(Solver& soil, double u, int first, int count) {
  std::vector<InterfaceValues> forces;
  for (int n = first; n < first + count; ++n) {
    InterfaceValues sent;
    const StepRequest request{n, 0, (n - 1) * dt, dt};
    soil.solve_step(request, raised(soil, u + n / 1024.0), sent);
    soil.accept_step(request, true);
    forces.push_back(sent);
  }
  return forces;
}

double largest(const std::vector<InterfaceValues>& forces) {
  double value = 0;
  for (const auto& sent : forces) {
    for (const double f : sent.at("floor")) value = std::max(value, std::abs(f));
  }
  return value;
}

/// A floor at X that begins at X + u0 and a floor that is there from the outset.
template <int dim>
void expect_as_from_the_outset(const std::string& method) {
  SCOPED_TRACE(method + (dim == 2 ? " 2D" : " 3D"));
  constexpr double u0 = -0.125;
  const auto there = mpm_solver<dim>(above_floor<dim>(0.5 + u0, method));
  Placed<dim> placed = placed_soil<dim>(above_floor<dim>(0.5, method));
  placed.set_start(raised(placed, u0));
  EXPECT_EQ(placed.interfaces().at(0).coordinates.back(), 0.5);
  const int count = method == "facets" ? 36 : 20;
  const auto expected = steps(*there, 0, 1, count);
  EXPECT_EQ(largest({expected.front()}), 0);  // the block is still above it
  EXPECT_GT(largest(expected), 10);
  EXPECT_EQ(steps(placed, u0, 1, count), expected);
  EXPECT_TRUE(same_bits(placed.soil().points(), there->points()));
}

TEST(PlacedSoil, meets_its_interfaces_where_they_begin) {
  expect_as_from_the_outset<2>("facets");
  expect_as_from_the_outset<3>("facets");
  expect_as_from_the_outset<2>("boundary_points");
  expect_as_from_the_outset<3>("boundary_points");
}

TEST(PlacedSoil, is_the_soil_itself_where_nothing_begins_displaced) {
  const auto there = mpm_solver<2>(above_floor_2d(0.5, "facets"));
  Placed<2> placed = placed_soil<2>(above_floor_2d(0.5, "facets"));
  const auto* before = &placed.soil();
  placed.set_start(raised(placed, 0));
  EXPECT_EQ(&placed.soil(), before);
  const auto forces = steps(placed, 0, 1, 4);
  EXPECT_GT(largest(forces), 10);
  EXPECT_EQ(forces, steps(*there, 0, 1, 4));
  EXPECT_TRUE(placed.save_state().reals == there->save_state().reals);
}

TEST(PlacedSoil, soil_inside_a_structure_that_begins_there_is_refused) {
  Placed<2> placed = placed_soil<2>(above_floor_2d(0.5, "facets"));
  expect_error<ConfigError>([&] { placed.set_start(raised(placed, 0.03125)); },
                            {"floor", "inside", "by 0.0312 m", "displaced from their place",
                             "\"floor\" by up to 0.0312 m"});
}

// Soil that was laid on a floor which begins below lies inside of it at X.
TEST(PlacedSoil, may_begin_where_it_could_not_at_the_reference) {
  constexpr double u0 = -0.125;
  Placed<2> placed = placed_soil<2>(above_floor_2d(0.625, "facets"));
  const std::vector<std::string_view> refused = {"mpm.json: at /interfaces/0/surface", "inside",
                                                 "floor"};
  InterfaceValues sent;
  expect_error<ConfigError>([&] { placed.write_output(0); }, refused);
  expect_error<ConfigError>([&] { placed.summary(); }, refused);
  expect_error<ConfigError>([&] { placed.set_start(raised(placed, 0)); }, refused);
  expect_error<ConfigError>(
      [&] {
        placed.solve_step({1, 0, 0, dt}, raised(placed, 0), sent);
      },
      refused);
  placed.set_start(raised(placed, u0));
  const auto there = mpm_solver<2>(above_floor_2d(0.5, "facets"));
  EXPECT_EQ(placed.probe_names(), there->probe_names());
  EXPECT_EQ(steps(placed, u0, 1, 8), steps(*there, 0, 1, 8));
  Placed<2> other = placed_soil<2>(above_floor_2d(0.625, "facets"));
  other.load_state(placed.save_state());
  EXPECT_EQ(steps(other, u0, 9, 8), steps(*there, 0, 9, 8));
}

TEST(PlacedSoil, a_body_that_cannot_be_is_refused_at_once) {
  Json json = above_floor_2d(0.625, "facets");
  json["bodies"][0]["mesh"] = box({0.75, 0.5}, {1.25, 0.75}, {4, 2}, "quad4");
  expect_error<ConfigError>([&] { placed_soil<2>(json); }, {"outside the background grid"});
}

TEST(PlacedSoil, is_told_before_its_first_step) {
  Placed<2> placed = placed_soil<2>(above_floor_2d(0.5, "facets"));
  placed.set_start(raised(placed, -0.125));
  placed.set_start(raised(placed, -0.25));  // the last one holds
  steps(placed, -0.25, 1, 1);
  placed.set_start(raised(placed, -0.25));  // nothing new
  expect_error<Error>([&] { placed.set_start(raised(placed, -0.125)); },
                      {"\"floor\" by up to 0.125 m", "before the first step"});
  InterfaceValues wrong = raised(placed, -0.125);
  wrong["floor"].pop_back();
  Placed<2> other = placed_soil<2>(above_floor_2d(0.5, "facets"));
  expect_error<Error>([&] { other.set_start(wrong); }, {"found 17", "9 vertices x 2"});
}

// The state knows where the interfaces began: the solver that goes on from it is not told.
TEST(PlacedSoil, a_restart_gives_the_same_bits) {
  for (const std::string method : {"facets", "boundary_points"}) {
    constexpr double u0 = -0.1;  // no sum of powers of two
    Placed<2> placed = placed_soil<2>(above_floor_2d(0.5, method));
    placed.set_start(raised(placed, u0));
    steps(placed, u0, 1, 16);
    const State saved = placed.save_state();
    const auto expected = steps(placed, u0, 17, 16);
    EXPECT_GT(largest(expected), 10);
    Placed<2> other = placed_soil<2>(above_floor_2d(0.5, method));
    other.load_state(saved);
    EXPECT_EQ(steps(other, u0, 17, 16), expected);
    EXPECT_TRUE(same_bits(other.soil().points(), placed.soil().points()));
    Placed<2> late = placed_soil<2>(above_floor_2d(0.5, method));
    steps(late, 0, 1, 1);
    expect_error<Error>([&] { late.load_state(saved); }, {"before the first step"});
  }
}

/// The block at rest under its weight on the floor, between two sides that do not bear.
Json resting(double y) {
  Json json = above_floor_2d(y, "facets");
  json["grid"] = box({0.25, 0}, {0.75, 1}, {4, 8}, "quad4");
  json["walls"] = {wall("left", "slip"), wall("right", "slip")};
  json["gravity"] = {0, -10};
  json["bodies"][0].erase("velocity");
  json["bodies"][0]["initial_stress"] = {{"k0", 0.5}, {"surface", 0.75}};
  json["bodies"][0]["material"]["law"] = "hencky_elastic";
  json["newton"] = exact_newton;
  return json;
}

double lift(const InterfaceValues& sent) {
  double sum = 0;
  for (std::size_t k = 1; k < sent.at("floor").size(); k += 2) sum += sent.at("floor")[k];
  return sum;
}

// The stress that the floor gets is that of its place, whose depth changes by u0.
TEST(PlacedSoil, soil_at_rest_presses_on_a_floor_that_begins_a_little_displaced) {
  constexpr double weight = 1000 * 10 * 0.5 * 0.25, depth = 0.25, fall = 10 * dt;  // [N, m, m/s]
  const auto there = mpm_solver<2>(resting(0.5));
  InterfaceValues expected;
  there->solve_step({1, 0, 0, dt}, raised(*there, 0), expected);
  EXPECT_NEAR(lift(expected), -weight, 0.02 * weight);
  for (const double u0 : {-1e-4, 1e-5}) {  // below a hundredth of a cell
    Placed<2> placed = placed_soil<2>(resting(0.5));
    placed.set_start(raised(placed, u0));
    InterfaceValues sent;
    placed.solve_step({1, 0, 0, dt}, raised(placed, u0), sent);
    EXPECT_NEAR(lift(sent), lift(expected), 2 * std::abs(u0) / depth * weight);
    placed.accept_step({1, 0, 0, dt}, true);
    for (const auto& v : placed.soil().points().v) EXPECT_LT(v.norm(), 0.01 * fall);
  }
}

// Nothing bears soil that was laid on a floor which begins below it.
TEST(PlacedSoil, soil_at_rest_on_a_floor_that_begins_elsewhere_is_refused) {
  Placed<2> placed = placed_soil<2>(resting(0.5));
  expect_error<ConfigError>(
      [&] { placed.set_start(raised(placed, -0.0625)); },
      {"no equilibrium of the soil", "displaced from their place", "\"floor\" by up to 0.0625 m"});
}

}  // namespace
}  // namespace gabion::test::test_placed_soil
