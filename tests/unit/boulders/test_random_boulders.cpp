// SPDX-License-Identifier: BSD-3-Clause
// Boulders at random places, and soil that makes room for boulders.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "mpm_solver/boulders/random_sizes.hpp"
#include "solver_program/ranked_state.hpp"
#include "tests/support/expect_error.hpp"
#include "tests/unit/mpm/mpm_scene.hpp"

namespace gabion::test::test_random_boulders {
namespace {

Json random_rocks(int dim) {
  const std::vector<double> low(dim, 0.2);
  std::vector<double> high(dim, 3.8);
  return {{"name", "rock"},
          {"count", dim == 2 ? 6 : 20},
          {"region", {{"low", low}, {"high", high}}},
          {"sizes", {{"uniform", {0.42, 0.6}}}},
          {"minimum_distance", 0.05},
          {"density", 2650}};
}

/// Empty space but for a block of soil in a corner, and a plate across it.
Json field(int dim, const Json& rocks) {
  const bool plane = dim == 2;
  Json json = {{"dimension", dim},
               {"grid", plane ? box({0, 0}, {4, 4}, {40, 40}, "quad4")
                              : box({0, 0, 0}, {4, 4, 4}, {30, 30, 30}, "hex8")},
               {"bodies",
                {body("soil",
                      plane ? box({0, 0}, {0.2, 0.2}, {2, 2}, "quad4")
                            : box({0, 0, 0}, {0.2, 0.2, 0.2}, {2, 2, 2}, "hex8"),
                      plane ? 4 : 8, elastic_soil("neo_hookean", 1e6, 0.3, 1800))}},
               {"time_integration", {{"scheme", "explicit"}}},
               {"random_boulders", {rocks}}};
  if (plane) {
    json["rigid_walls"] = {
        {{"name", "plate"}, {"surface", {{"polyline", {{4, 2}, {1, 2}}}, {"spacing", 0.1}}}}};
  }
  return json;
}

template <int dim>
std::vector<mpm::BoulderSettings<dim>> boulders_of(const Json& json) {
  return mpm_settings<dim>(json).boulders;
}

template <int dim>
void expect_room(const std::vector<mpm::BoulderSettings<dim>>& boulders) {
  for (std::size_t a = 0; a < boulders.size(); ++a) {
    const Vector<3>& x = boulders[a].start.x;
    const double radius = boulders[a].shape.radius;
    for (int d = 0; d < dim; ++d) {
      EXPECT_GE(x[d], 0.2 + radius) << a;
      EXPECT_LE(x[d], 3.8 - radius) << a;
    }
    for (std::size_t b = 0; b < a; ++b) {
      EXPECT_GE((x - boulders[b].start.x).norm(), radius + boulders[b].shape.radius + 0.05)
          << a << b;
    }
  }
}

TEST(RandomBoulders, have_room_and_depend_on_the_seed_alone) {
  for (const std::string shape : {"sphere", "box", "ellipsoid"}) {
    Json rocks = random_rocks(3);
    rocks["shape"] = shape;
    rocks["count"] = shape == "sphere" ? 20 : 8;
    if (shape != "sphere") {
      rocks["sizes"] = {{"uniform", {0.7, 0.8}}};
      rocks["axis_ratios"] = {{0.8, 0.9}, {0.9, 1}};
    }
    const auto drawn = boulders_of<3>(field(3, rocks));
    ASSERT_EQ(drawn.size(), rocks["count"].get<std::size_t>());
    expect_room(drawn);
    EXPECT_EQ(drawn.front().name, "rock_1");
    const double low = rocks["sizes"]["uniform"][0], high = rocks["sizes"]["uniform"][1];
    double last = high;
    for (const auto& boulder : drawn) {
      const double size = std::cbrt(6 / M_PI * boulder.shape.mass.mass / 2650);
      EXPECT_GE(size, low);
      EXPECT_LE(size, last * (1 + 1e-12));
      last = size;
    }
    const auto again = boulders_of<3>(field(3, rocks));
    rocks["seed"] = 2;
    const auto other = boulders_of<3>(field(3, rocks));
    for (std::size_t k = 0; k < drawn.size(); ++k) {
      EXPECT_EQ(drawn[k].start.x, again[k].start.x);
      EXPECT_EQ(drawn[k].start.q.coeffs(), again[k].start.q.coeffs());
      EXPECT_NE(drawn[k].start.x, other[k].start.x);
    }
  }
}

/// The plate's front is above it.
TEST(RandomBoulders, keep_apart_from_surfaces_and_are_never_behind_them) {
  const auto drawn = boulders_of<2>(field(2, random_rocks(2)));
  ASSERT_EQ(drawn.size(), 6U);
  expect_room(drawn);
  for (const auto& boulder : drawn) {
    const Vector<3>& x = boulder.start.x;
    const double aside = std::max(0.0, 1 - x[0]);
    const double apart = boulder.shape.radius + 0.05;
    EXPECT_GE(std::hypot(aside, x[1] - 2), apart);
    EXPECT_TRUE(aside > 0 || x[1] >= 2 + apart) << x.transpose();
  }
}

TEST(RandomBoulders, fill_a_share_of_a_polygon) {
  Json rocks = random_rocks(2);
  rocks["region"] = {{"polygon", {{0.2, 0.2}, {3.8, 0.2}, {0.2, 3.8}}}};
  rocks.erase("count");
  rocks["volume_share"] = 0.2;
  Json json = field(2, rocks);
  json.erase("rigid_walls");
  const auto drawn = boulders_of<2>(json);
  double area = 0;
  for (const auto& boulder : drawn) {
    area += boulder.shape.mass.mass / 2650;
    const Vector<3>& x = boulder.start.x;
    EXPECT_LE((x[0] + x[1] - 4) / std::sqrt(2), -boulder.shape.radius);
  }
  EXPECT_NEAR(area, 0.2 * 0.5 * 3.6 * 3.6, 0.5 * M_PI / 4 * 0.6 * 0.6);
}

TEST(RandomBoulders, sizes_follow_their_distribution) {
  mpm::RandomNumbers random(7);
  const int count = 100000;
  const mpm::GradedSizes graded{{{0.1, 0}, {0.2, 0.3}, {0.8, 1}}};
  double mass = 0, finer = 0, in_middle = 0;
  for (int k = 0; k < count; ++k) {
    const double d = draw_size(graded, 3, random), m = d * d * d;
    ASSERT_TRUE(d >= 0.1 * (1 - 1e-12) && d <= 0.8 * (1 + 1e-12)) << d;
    mass += m;
    finer += d < 0.2 ? m : 0;
    in_middle += d < 0.4 ? m : 0;
  }
  EXPECT_NEAR(finer / mass, 0.3, 0.02);
  EXPECT_NEAR(in_middle / mass, 0.65, 0.02);  // half way in the logarithm
  const mpm::LognormalSizes lognormal{.median = 0.5, .deviation = 0.4, .min = 0.1, .max = 2.5};
  double sum = 0, squares = 0;
  for (int k = 0; k < count; ++k) {
    const double z = std::log(draw_size(lognormal, 3, random) / 0.5) / 0.4;
    sum += z / count;
    squares += z * z / count;
  }
  EXPECT_NEAR(sum, 0, 0.02);
  EXPECT_NEAR(squares, 1, 0.02);
}

void expect_refused(const Json& json, const std::vector<std::string_view>& parts) {
  expect_error<ConfigError>([&] { make_mpm(json); }, parts);
}

TEST(RandomBoulders, bad_input) {
  const auto with = [](const std::string& key, const Json& value) {
    Json rocks = random_rocks(2);
    rocks[key] = value;
    return field(2, rocks);
  };
  expect_refused(with("count", 60), {"/random_boulders/0/region", "of 60", "no room in 10000 draws",
                                     "between (0.2, 0.2) and (3.8, 3.8)", "other boulders"});
  expect_refused(with("count", 0), {"/random_boulders/0/count", "0"});
  expect_refused(with("volume_share", 0.1), {"/random_boulders/0/count", "either"});
  expect_refused(with("sizes", {{"uniform", {0.1, 0.2}}}),
                 {"/random_boulders/0/sizes", "thickness", "0.3 m"});
  expect_refused(with("sizes", {{"uniform", {0.6, 0.5}}}),
                 {"/random_boulders/0/sizes/uniform", "0.6 m above"});
  expect_refused(with("sizes", {{"grading", {{0.4, 0.1}, {0.6, 1}}}}),
                 {"/random_boulders/0/sizes/grading/0", "found [0.4, 0.1]", "from 0 to 1"});
  expect_refused(with("sizes", {{"grading", {{0.4, 0}, {0.6, 0.5}, {0.6, 1}}}}),
                 {"/sizes/grading/2", "found [0.6, 1] after [0.6, 0.5]"});
  expect_refused(with("sizes", {{"grading", {{0.6, 0}, {0.4, 1}}}}),
                 {"/sizes/grading/1", "found [0.4, 1] after [0.6, 0]"});
  expect_refused(with("sizes", {{"grading", {{0.4, 0}, {0.6, 0.9}}}}),
                 {"/sizes/grading/1", "found [0.6, 0.9]"});
  expect_refused(
      with("sizes",
           {{"lognormal", {{"median", 1e-3}, {"deviation", 0.1}, {"min", 0.5}, {"max", 0.6}}}}),
      {"/random_boulders/0/sizes", "no size from 0.5 to 0.6 m"});
  expect_refused(with("axis_ratios", {{0.5, 1}}), {"/random_boulders/0/axis_ratios", "ellipsoid"});
  expect_refused(with("shape", "cone"), {"/random_boulders/0/shape", "cone"});
  expect_refused(with("region", {{"low", {1, 1}}, {"high", {1, 2}}}),
                 {"/random_boulders/0/region/high", "without volume"});
  expect_refused(with("region", {{"polygon", {{1, 1}, {3, 3}, {3, 1}, {1, 3}}}}),
                 {"/random_boulders/0/region/polygon", "sides 0 and 2 that meet"});
  expect_refused(with("soil_inside", "drop"), {"/random_boulders/0/soil_inside", "drop", "remove"});
  Json twice = field(2, random_rocks(2));
  twice["boulders"] = {{{"name", "rock_3"},
                        {"shape", {{"radius", 0.25}}},
                        {"density", 2650},
                        {"centre", {0.6, 3.4}}}};
  expect_refused(twice, {"/random_boulders/0/name", "rock_3"});
}

Json stone_in_soil(int dim, const std::string& soil_inside) {
  const bool plane = dim == 2;
  Json json = field(dim, random_rocks(dim));
  json.erase("random_boulders");
  json.erase("rigid_walls");
  json["grid"] = plane ? box({0, 0}, {4, 4}, {40, 40}, "quad4")
                       : box({0, 0, 0}, {2, 2, 2}, {10, 10, 10}, "hex8");
  json["bodies"][0]["mesh"] = plane ? box({0, 0}, {4, 2}, {40, 20}, "quad4")
                                    : box({0, 0, 0}, {2, 2, 2}, {10, 10, 10}, "hex8");
  json["boulders"] = {{{"name", "stone"},
                       {"shape", {{"radius", 0.6}}},
                       {"density", 2650},
                       {"centre", std::vector<double>(dim, 1.03)},
                       {"soil_inside", soil_inside}}};
  return json;
}

TEST(SoilInside, is_left_out_or_refused) {
  for (const int dim : {2, 3}) {
    expect_refused(stone_in_soil(dim, "error"), {"/boulders/0/shape", "inside the structure"});
    const auto solver = make_mpm(stone_in_soil(dim, "remove"));
    const double all = 1800 * 8;
    const double stone = 1800 * (dim == 2 ? M_PI * 0.36 : 4 * M_PI / 3 * 0.216);
    const double left_out = all - probe(*solver, "mass");
    EXPECT_GT(left_out, stone) << dim;  // no contact sphere reaches into the stone
    EXPECT_LT(left_out, (dim == 2 ? 1.12 : 1.4) * stone) << dim;
    run_steps(*solver, 1e-4, 5);
    EXPECT_LT(std::abs(probe(*solver, "stone.vx")), 1e-3) << dim;
  }
}

TEST(SoilInside, a_run_without_it_goes_on_from_a_saved_state) {
  const Json json = stone_in_soil(2, "remove");
  const auto straight = mpm_solver<2>(json), first = mpm_solver<2>(json),
             second = mpm_solver<2>(json);
  run_steps(*straight, 1e-4, 5);
  run_steps(*first, 1e-4, 3);
  load_gathered(comm(), gather_state(comm(), first->save_state()), *second);
  run_steps(*second, 1e-4, 2, 4);
  EXPECT_TRUE(same_bits<2>(second->points(), straight->points()));
  EXPECT_EQ(second->probes(), straight->probes());
}

TEST(SoilInside, a_body_that_would_vanish_is_refused) {
  Json json = stone_in_soil(2, "remove");
  json["bodies"].push_back(json["bodies"][0]);
  json["bodies"][0]["mesh"] = box({0.9, 0.9}, {1.1, 1.1}, {2, 2}, "quad4");
  json["bodies"][1]["name"] = "rest";
  json["bodies"][1]["mesh"] = box({2, 0}, {4, 2}, {20, 20}, "quad4");
  expect_refused(json, {"/boulders/0/shape", "all material points of body 0"});
}

}  // namespace
}  // namespace gabion::test::test_random_boulders
