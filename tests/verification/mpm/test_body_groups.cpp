// SPDX-License-Identifier: BSD-3-Clause
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "tests/support/verification_row.hpp"
#include "tests/unit/mpm/mpm_scene.hpp"

namespace gabion::test {
namespace {

constexpr double h = 0.1;

Json groups_of(const std::string& first, const std::string& second, const Json& contact) {
  Json pair = contact;
  pair["groups"] = {"first", "second"};
  return {{"groups",
           {{{"name", "first"}, {"bodies", {first}}}, {{"name", "second"}, {"bodies", {second}}}}},
          {"pairs", {pair}}};
}

/// Mass-weighted mean of the velocity of a body.
Vector<2> velocity_of(const mpm::MaterialPoints<2>& points, int body) {
  Vector<2> momentum = Vector<2>::Zero();
  double mass = 0;
  for (std::int32_t p = points.body_starts[body]; p < points.body_starts[body + 1]; ++p) {
    momentum += points.m[p] * points.v[p];
    mass += points.m[p];
  }
  return momentum / mass;
}

/// VB1: a block of soil on a bed of soil at 30 degrees; gravity is turned instead. The top of the
/// bed is at `height` cells.
struct Slope {
  std::string basis = "gimp", scheme = "implicit";
  double friction = 0.3, height = 1;
};

Json block_on_bed(const Slope& slope) {
  const double angle = M_PI / 6, g = 9.81, top = slope.height * h;
  const double cell = (top + 0.3) / 4;  // of the bed, a square
  const int columns = static_cast<int>(std::lround(1.8 / cell));
  Json scene = {{"dimension", 2},
                {"grid", box({0, -0.3}, {2, 0.8}, {20, 11}, "quad4")},
                {"basis", slope.basis},
                {"gravity", {g * std::sin(angle), -g * std::cos(angle)}},
                {"walls", {wall("bottom", "fixed")}},
                {"bodies",
                 {body("bed", box({0.1, -0.3}, {0.1 + columns * cell, top}, {columns, 4}, "quad4"),
                       4, elastic_soil("neo_hookean", 1e8, 0.2, 2000)),
                  body("block", box({0.43, top}, {0.93, top + 0.3}, {5, 3}, "quad4"), 4,
                       elastic_soil("neo_hookean", 1e7, 0.2, 1000))}},
                {"contact_groups", groups_of("bed", "block", {{"friction", slope.friction}})}};
  scene["time_integration"] = slope.scheme == "explicit"
                                  ? Json{{"scheme", "explicit"}}
                                  : Json{{"scheme", "bossak"}, {"alpha", -0.3}};
  return scene;
}

struct Slide {
  double acceleration = 0;  // of the block along the bed: slope of its speed over time [m/s^2]
  double friction = 0;      // over normal impulse
};
Slide slide(const Slope& slope) {
  Json scene = block_on_bed(slope);
  scene["gravity_ramp"] = {{"duration", 0.15}, {"shape", "smooth"}};
  const double dt = slope.scheme == "explicit" ? 5e-4 : 1e-3;
  const int ramp = static_cast<int>(std::lround(0.15 / dt)), steps = 2 * ramp;
  const auto solver = mpm_solver<2>(scene);
  run_steps(*solver, dt, ramp);
  double pull = 0, push = 0, sum = 0, squares = 0;
  for (int n = 1; n <= steps; ++n) {
    run_steps(*solver, dt, 1, ramp + n);
    pull -= dt * probe(*solver, "contact.first.second.fx");
    push += dt * probe(*solver, "contact.first.second.fy");
    const double t = (n - 0.5 * (steps + 1)) * dt;
    sum += t * velocity_of(solver->points(), 1)[0];
    squares += t * t;
  }
  return {.acceleration = sum / squares, .friction = pull / push};
}

TEST(BodyGroups, block_of_soil_on_a_bed_of_soil) {
  const double g = 9.81, angle = M_PI / 6;
  for (const char* scheme : {"implicit", "explicit"}) {
    for (const double height : {1.0, 1.25, 1.5}) {
      for (const char* basis : {"gimp", "linear"}) {
        const Slide found = slide({.basis = basis, .scheme = scheme, .height = height});
        const std::string what =
            fmt::format("block on a bed, both soil, friction 0.3, {}, {}, bed of {} cells", scheme,
                        basis, height + 3);
        verify({.id = "VB1",
                .what = what + ": acceleration",
                .exact = g * (std::sin(angle) - 0.3 * std::cos(angle)),
                .computed = found.acceleration,
                .bound = 0.01,
                .unit = "m/s^2"});
        verify({.id = "VB1",
                .what = what + ": friction over normal impulse",
                .exact = 0.3,
                .computed = found.friction,
                .measure = Measure::absolute_error,
                .bound = 1e-3});
      }
    }
  }
}

/// The block starts from a state of rest under its weight.
TEST(BodyGroups, block_that_friction_holds) {
  for (const double height : {1.0, 1.25}) {
    Json scene = block_on_bed({.friction = 0.7, .height = height});
    scene.erase("time_integration");
    scene["phases"] = {
        {{"until", 0.1}, {"analysis", "quasi_static"}, {"gravity_ramp", {{"duration", 0.1}}}},
        {{"analysis", "dynamic"}, {"time_integration", {{"scheme", "bossak"}, {"alpha", -0.3}}}}};
    const auto solver = mpm_solver<2>(scene);
    const std::int32_t first = solver->points().body_starts[1];
    run_steps(*solver, 0.005, 20);
    const double start = solver->points().x[first][0];
    run_steps(*solver, 0.005, 60, 21);
    verify({.id = "VB1",
            .what = fmt::format("block on a bed, both soil, friction 0.7, bed of {} cells: drift "
                                "in 0.3 s",
                                height + 3),
            .exact = 0,
            .computed = solver->points().x[first][0] - start,
            .measure = Measure::absolute_error,
            .bound = 1e-5,
            .unit = "m"});
  }
}

/// VB2: two bodies, one upon the other in a slot, under a lid that goes down.
struct Press {
  double force = 0, opposite = 0;  // between the bodies, and on the ground [N/m]
  double stress = 0;               // vertical, mean within a cell of the contact [Pa]
};
constexpr double press_width = 0.4;
Press press(const std::string& basis, double offset) {
  const double floor = offset * h, middle = floor + 0.3, top = floor + 0.6;
  const Json soil = elastic_soil("linear_elastic", 1e6, 0, 1000);
  const Json facets = {{"method", "facets"}, {"mode", "slip"}, {"penalty_factor", 1e4}};
  Json ground = facets, lid = facets;
  ground["name"] = "ground";
  ground["surface"] = {{"polyline", {{0.5, floor}, {-0.1, floor}}}, {"spacing", h}};
  lid["name"] = "lid";
  lid["surface"] = {{"polyline", {{-0.1, top}, {0.5, top}}}, {"spacing", h}};
  lid["motion"] = {{"table", {{0, 0, 0}, {1, 0, -1e-2}}}};
  const Json scene = {{"dimension", 2},
                      {"grid", box({0, -0.1}, {0.4, 0.9}, {4, 10}, "quad4")},
                      {"basis", basis},
                      {"analysis", "quasi_static"},
                      {"walls", {wall("left", "slip"), wall("right", "slip")}},
                      {"rigid_walls", {ground, lid}},
                      {"bodies",
                       {body("lower", box({0, floor}, {0.4, middle}, {4, 3}, "quad4"), 4, soil),
                        body("upper", box({0, middle}, {0.4, top}, {4, 3}, "quad4"), 4, soil)}},
                      {"contact_groups", groups_of("lower", "upper", {{"friction", 0.3}})}};
  const auto solver = mpm_solver<2>(scene);
  run_steps(*solver, 0.02, 10, 1);
  Press found;
  found.force = probe(*solver, "contact.first.second.fy");
  found.opposite = -probe(*solver, "ground.fy");
  const auto& points = solver->points();
  double volume = 0;
  for (std::int32_t p = 0; p < points.size(); ++p) {
    const Vector<2>& x = points.x[p];
    if (std::abs(x[0] - press_width / 2) > h || std::abs(x[1] - middle) > h) continue;
    volume += points.V0[p];
    found.stress -= points.V0[p] * points.tau[p](1, 1);
  }
  found.stress /= volume;
  return found;
}

TEST(BodyGroups, a_press_of_two_bodies) {
  for (const double offset : {0.0, 0.1, 0.25, 0.4, 0.5, 0.75, 0.9}) {
    const Press found = press("gimp", offset);
    const std::string what = fmt::format("two bodies in a press, offset {} of a cell", offset);
    verify({.id = "VB2",
            .what = what + ": force between them over that on the ground",
            .exact = found.opposite,
            .computed = found.force,
            .bound = 1e-5,
            .unit = "N/m"});
    verify({.id = "VB2",
            .what = what + ": stress within a cell of the contact over force per width",
            .exact = found.force / press_width,
            .computed = found.stress,
            .bound = 0.04,
            .unit = "Pa",
            .limitation = "where points end just beyond a line of the grid the nodes behind them "
                          "are light, and join others"});
  }
}

/// VB3: two bars (E, density, nu = 0; smooth walls on their sides) that meet.
constexpr double E = 1e7, density = 1800, v0 = 0.1;

struct Bars {
  double stress = 0;                          // plateau [Pa]
  double first = 0, second = 0;               // velocities after they have parted [m/s]
  double loss = 0, gained = 0, momentum = 0;  // by the kinetic energy and the momentum at the start
  double time = 0;                            // impulse by the exact stress [s]
};
Bars collide(const std::string& scheme, double length, double other, double offset) {
  const double c = std::sqrt(E / density), step = 2 / c / 400, size = 0.025;
  const double left = 0.3, meet = left + length + offset * size, clear = 0.1 * size;
  const auto cells = [&](double x) { return static_cast<int>(std::lround(x / size)); };
  const bool rests = other > length;
  const Json soil = elastic_soil("linear_elastic", E, 0, density);
  Json scene = {
      {"dimension", 2},
      {"grid", box({0, 0}, {left + length + other + 0.3, size},
                   {cells(left + length + other + 0.3), 1}, "quad4")},
      {"basis", "linear"},
      {"walls", {wall("bottom", "slip"), wall("top", "slip")}},
      {"bodies",
       {body("first", box({meet - length, 0}, {meet, size}, {cells(length), 1}, "quad4"), 4, soil,
             {v0, 0}),
        body("second",
             box({meet + clear, 0}, {meet + clear + other, size}, {cells(other), 1}, "quad4"), 4,
             soil, {rests ? 0 : -v0, 0})}},
      {"contact_groups",
       groups_of("first", "second", {{"mode", "slip"}, {"penalty_factor", 200}})}};
  if (scheme == "explicit") {
    scene["time_integration"] = {{"scheme", "explicit"}};
  } else {
    scene["time_integration"] = trapezoid;
    scene["newton"] = exact_newton;
  }
  const auto solver = mpm_solver<2>(scene);
  const auto energy = [&] {
    return probe(*solver, "kinetic_energy") + probe(*solver, "elastic_energy") +
           probe(*solver, "contact_energy");
  };
  const double start = energy(), momentum = probe(*solver, "momentum_x");
  const double closing = rests ? v0 : 2 * v0, contact = 2 * std::min(length, other) / c;
  const double stress = 0.5 * density * c * closing, arrival = clear / closing;
  Bars found;
  double highest = start, impulse = 0, plateau = 0, on_plateau = 0;
  for (int n = 1; n * step < arrival + 1.6 * contact; ++n) {
    run_steps(*solver, step, 1, n);
    highest = std::max(highest, energy());
    const double force = probe(*solver, "contact.first.second.fx") / size;
    impulse += step * force;
    const double t = (n * step - arrival) / contact;
    if (t > 0.2 && t < 0.8) {
      plateau += step * force;
      on_plateau += step;
    }
  }
  found.stress = plateau / on_plateau;
  found.time = impulse / stress;
  found.first = velocity_of(solver->points(), 0)[0];
  found.second = velocity_of(solver->points(), 1)[0];
  found.loss = probe(*solver, "contact_loss") / start;
  found.gained = highest / start - 1;
  found.momentum = std::abs(probe(*solver, "momentum_x") - momentum) / (density * size * v0);
  return found;
}

TEST(BodyGroups, two_bars_exchange_their_velocities) {
  const double c = std::sqrt(E / density);
  for (const char* scheme : {"implicit", "explicit"}) {
    for (const double offset : {0.0, 0.3}) {
      const Bars found = collide(scheme, 1, 1, offset);
      const std::string what = fmt::format("two equal bars, {}, offset {}", scheme, offset);
      const auto row = [&](const std::string& of, double exact, double computed, double bound,
                           const std::string& unit) {
        verify({.id = "VB3",
                .what = what + ": " + of,
                .exact = exact,
                .computed = computed,
                .bound = bound,
                .unit = unit});
      };
      row("stress", density * c * v0, found.stress, 0.02, "Pa");
      row("impulse over the stress", 2 / c, found.time, 0.03, "s");
      row("velocity after it", v0, found.second, 0.03, "m/s");
      EXPECT_LT(found.loss, 0.02) << what;
      EXPECT_LT(found.gained, 1e-6) << what;
      EXPECT_LT(found.momentum, 1e-9) << what;
    }
  }
}

TEST(BodyGroups, a_short_bar_stops_at_a_long_one) {
  const Bars found = collide("implicit", 1, 2, 0.3);
  verify({.id = "VB3",
          .what = "bar of 1 m hits one of 2 m at rest: its velocity after it",
          .exact = 0,
          .computed = found.first / v0,
          .measure = Measure::absolute_error,
          .bound = 0.05});
  verify({.id = "VB3",
          .what = "bar of 1 m hits one of 2 m at rest: velocity of the other over that before",
          .exact = 0.5,
          .computed = found.second / v0,
          .bound = 0.03});
}

}  // namespace
}  // namespace gabion::test
