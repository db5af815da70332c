// SPDX-License-Identifier: BSD-3-Clause
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <cmath>
#include <utility>

#include "tests/support/verification_row.hpp"
#include "tests/unit/mpm/mpm_scene.hpp"

namespace gabion::test {
namespace {

/// V8: a bar that flies against a rigid wall (E, density, L; nu = 0, smooth walls on its sides):
///
///     sigma = rho c v0 ,  time of contact 2 L / c ,  rebound with -v0
///
/// The penalty acts like a further piece of bar of the length E / eps.
constexpr double E = 1e6, density = 1e3, L = 1, v0 = 0.1;
constexpr int cells = 40;

Json flying_bar() {
  const double h = L / cells;
  return {{"dimension", 2},
          {"grid", box({-2 * h, 0}, {L + 4 * h, h}, {cells + 6, 1}, "quad4")},
          {"basis", "linear"},
          {"walls", {wall("bottom", "slip"), wall("top", "slip")}},
          {"bodies",
           {body("bar", box({0, 0}, {L, h}, {cells, 1}, "quad4"), 4,
                 elastic_soil("linear_elastic", E, 0, density), {-v0, 0})}},
          {"time_integration", trapezoid},
          {"newton", {{"residual_tolerance", 1e-12}, {"increment_tolerance", 1e-12}}},
          {"rigid_walls",
           {{{"name", "wall"},
             {"surface", {{"polyline", {{0, 0}, {0, h}}}, {"spacing", h}}},
             {"method", "boundary_points"},
             {"mode", "slip"},
             {"penalty_factor", 5}}}}};
}

TEST(RigidWalls, bar_that_hits_a_wall) {
  const auto solver = make_mpm(flying_bar());
  const double c = std::sqrt(E / density), contact = 2 * L / c, h = L / cells;
  const int steps = 400;
  const double dt = contact / steps;
  const double before = probe(*solver, "momentum_x");
  double impulse = 0, force = 0, last = 0, mean = 0;
  for (int n = 1; n <= 1.25 * steps; ++n) {
    run_steps(*solver, dt, 1, n);
    force = probe(*solver, "wall.fx");
    impulse += 0.5 * dt * (force + last);
    if (n > 0.2 * steps && n <= 0.8 * steps) mean += force / (0.6 * steps);
    last = force;
  }
  EXPECT_EQ(force, 0);  // it left
  const double after = probe(*solver, "momentum_x"), mass = probe(*solver, "mass");
  verify({.id = "V8",
          .what = "bar on a rigid wall, contact stress, 2D, 40 cells",
          .exact = density * c * v0,
          .computed = -mean / h,
          .bound = 0.01,
          .unit = "Pa"});
  verify({.id = "V8",
          .what = "bar on a rigid wall, time of contact (impulse over force), 2D, 40 cells",
          .exact = contact,
          .computed = -impulse / h / (density * c * v0),
          .bound = 0.02,
          .unit = "s"});
  verify({.id = "V8",
          .what = "bar on a rigid wall, velocity after the rebound, 2D, 40 cells",
          .exact = v0,
          .computed = after / mass,
          .bound = 0.05,
          .unit = "m/s",
          .limitation =
              "linear cells disperse the wave front: part of the energy stays in vibration"});
  verify({.id = "V8",
          .what = "momentum gained by the bar against the impulse of the wall force",
          .exact = -impulse,
          .computed = after - before,
          .bound = 1e-10,
          .unit = "N s"});
}

/// V9: a block on an incline of 30 degrees, a = g (sin - mu cos). Gravity is turned instead.
double speed_on_incline(double mu) {
  const double angle = M_PI / 6, g = 9.81;
  Json rigid = {{"name", "incline"},
                {"surface", {{"polyline", {{2, 0.1}, {0, 0.1}}}, {"spacing", 0.1}}},
                {"method", "boundary_points"},
                {"mode", "slip"},
                {"penalty_factor", 10}};
  if (mu > 0) {
    rigid["mode"] = "contact";
    rigid["friction"] = mu;
  }
  const auto solver = make_mpm({{"dimension", 2},
                                {"grid", box({0, 0}, {2, 1}, {20, 10}, "quad4")},
                                {"basis", "linear"},
                                {"gravity", {g * std::sin(angle), -g * std::cos(angle)}},
                                {"bodies",
                                 {body("block", box({0.53, 0.1}, {1.03, 0.4}, {10, 6}, "quad4"), 4,
                                       elastic_soil("neo_hookean", 1e7, 0.2, 1000))}},
                                {"time_integration", {{"scheme", "bossak"}, {"alpha", -0.3}}},
                                {"rigid_walls", {rigid}}});
  run_steps(*solver, 5e-4, 200);
  return probe(*solver, "momentum_x") / probe(*solver, "mass");
}

TEST(RigidWalls, block_on_an_incline) {
  for (const double mu : {0.0, 0.1}) {
    verify({.id = "V9",
            .what = mu > 0 ? "block on an incline of 30 degrees, mu = 0.1, speed after 0.1 s"
                           : "block on an incline of 30 degrees, mu = 0, speed after 0.1 s",
            .exact = 9.81 * (0.5 - mu * std::sqrt(0.75)) * 0.1,
            .computed = speed_on_incline(mu),
            .bound = 5e-3,
            .unit = "m/s"});
  }
}

/// VA14: the same with facets and Voellmy's drag rho g / xi, of a block of the height h:
///
///     v = v_t tanh(t / T) ,  v_t^2 = h xi (sin - mu cos) ,  T = v_t / (g (sin - mu cos))
double speed_with_drag(const std::string& scheme) {
  constexpr double angle = M_PI / 9, g = 9.81, xi = 500, h = 0.5;
  const Json incline = {{"name", "incline"},
                        {"surface", {{"polyline", {{26, h}, {0, h}}}, {"spacing", h}}},
                        {"friction", 0.15},
                        {"turbulent_drag", density * g / xi}};
  const auto solver = make_mpm({{"dimension", 2},
                                {"grid", box({0, 0}, {26, 2.5}, {52, 5}, "quad4")},
                                {"gravity", {g * std::sin(angle), -g * std::cos(angle)}},
                                {"bodies",
                                 {body("block", box({0.5, h}, {2.5, h + 1}, {4, 2}, "quad4"), 4,
                                       elastic_soil("neo_hookean", 1e6, 0.2, density))}},
                                {"time_integration", {{"scheme", scheme}}},
                                {"rigid_walls", {incline}}});
  run_steps(*solver, 0.02, 250);
  return probe(*solver, "momentum_x") / probe(*solver, "mass");
}

TEST(RigidWalls, block_on_an_incline_with_turbulent_drag) {
  for (const std::string scheme : {"bossak", "explicit"}) {
    verify({.id = "VA14",
            .what = fmt::format("block of 1 m on an incline of 20 degrees, mu 0.15, xi 500 m/s^2: "
                                "speed after 5 s, {}",
                                scheme),
            .exact = 10.026621 * std::tanh(5 / 5.083308),
            .computed = speed_with_drag(scheme),
            .bound = 5e-3,
            .unit = "m/s"});
  }
}

/// A block on a slope with friction mu_r + (mu_s - mu_r) exp(-v / v_c), v_0 at the start:
///
///     exp(v / v_c) = (exp(v_0 / v_c) + b / a) exp(-a t / v_c) - b / a ,
///     a = g (mu_r cos - sin) ,  b = g (mu_s - mu_r) cos
///
/// as long as v > 0. On a slope between the two angles of friction the block stops from speeds
/// below v_c log(-b / a), and is lost from above.
struct Weakening {
  double angle, speed, v_c;
  static constexpr double at_rest = 0.5, least = 0.15, g = 9.81;
  double a() const { return g * (least * std::cos(angle) - std::sin(angle)); }
  double b() const { return g * (at_rest - least) * std::cos(angle); }
  double after(double t) const {
    const double share = b() / a();
    const double y = (std::exp(speed / v_c) + share) * std::exp(-a() * t / v_c) - share;
    return y > 1 ? v_c * std::log(y) : 0;
  }
};

std::unique_ptr<Solver> weakening_block(const Weakening& w, const std::string& scheme) {
  constexpr double h = 0.5;
  const Json incline = {{"name", "incline"},
                        {"surface", {{"polyline", {{14, h}, {0, h}}}, {"spacing", h}}},
                        {"friction", Weakening::at_rest},
                        {"friction_at_speed", Weakening::least},
                        {"weakening_speed", w.v_c}};
  Json block = body("block", box({0.5, h}, {2.5, h + 1}, {4, 2}, "quad4"), 4,
                    elastic_soil("neo_hookean", 1e8, 0.2, density), {w.speed, 0});
  return make_mpm({{"dimension", 2},
                   {"grid", box({0, 0}, {14, 2.5}, {28, 5}, "quad4")},
                   {"gravity", {w.g * std::sin(w.angle), -w.g * std::cos(w.angle)}},
                   {"bodies", {block}},
                   {"time_integration", {{"scheme", scheme}}},
                   {"rigid_walls", {incline}}});
}

TEST(RigidWalls, block_whose_friction_falls_with_its_speed) {
  const Weakening level{0, 2, 0.6}, slow{M_PI / 9, 0.35, 1}, fast{M_PI / 9, 0.7, 1};
  const std::pair<const Weakening*, double> cases[] = {{&level, 0.6}, {&slow, 0.4}, {&fast, 1.5}};
  for (const std::string scheme : {"bossak", "explicit"}) {
    for (const auto& [w, time] : cases) {
      const auto solver = weakening_block(*w, scheme);
      const int steps = static_cast<int>(std::lround(time / 0.01));
      run_steps(*solver, 0.01, steps);
      verify(
          {.id = "VA14",
           .what = fmt::format("block of {} m/s on an incline of {:.0f} degrees, friction 0.5 to "
                               "0.15, v_c {} m/s: speed after {} s, {}",
                               w->speed, w->angle * 180 / M_PI, w->v_c, time, scheme),
           .exact = w->after(time),
           .computed = probe(*solver, "momentum_x") / probe(*solver, "mass"),
           .bound = w == &slow ? 0.02 : 0.005,
           .unit = "m/s"});
      // Less than the landing makes of Coulomb's friction, too.
      EXPECT_LT(probe(*solver, "created_energy"), 1e-4 * 1000 * w->speed * w->speed);
    }
  }
}

/// Where the block stops: its path is the integral of the speed above, here by Simpson's rule.
TEST(RigidWalls, block_that_stops_as_its_friction_grows) {
  const Weakening level{0, 2, 0.6};
  double exact = 0;
  for (int k = 0; k <= 2000; ++k) {
    exact += (k % 2 ? 4 : k % 2000 ? 2 : 1) * level.after(k * 5e-4) * 5e-4 / 3;
  }
  const auto solver = weakening_block(level, "bossak");
  double way = 0, before = level.speed;
  for (int n = 1; n <= 150; ++n) {
    run_steps(*solver, 0.01, 1, n);
    const double speed = probe(*solver, "momentum_x") / probe(*solver, "mass");
    way += 0.005 * (speed + before);
    before = speed;
  }
  verify({.id = "VA14",
          .what = "block of 2 m/s on level ground, friction 0.5 to 0.15, v_c 0.6 m/s: way until it "
                  "stops, bossak",
          .exact = exact,
          .computed = way,
          .bound = 2e-3,
          .unit = "m"});
  EXPECT_LT(std::abs(before), 1e-3 * level.speed);
}

/// A plate presses a column: F = D / (L / (M A) + 1 / (eps A)), penetration F / (eps A); steps so
/// long and soil so light that inertia vanishes. Then the plate goes back, and the force is gone
/// within the step that opens the gap.
struct Pressed {
  double force, penetration, after;
};
Pressed press(const std::string& method, double penalty, double D) {
  // Facets measure a penetration of 1e-6 m in coordinates that round at 1e-16 m.
  const double tolerance = method == "facets" ? 1e-10 : 1e-12;
  const auto solver =
      make_mpm({{"dimension", 2},
                {"grid", box({0, 0}, {1.25, 0.5}, {5, 2}, "quad4")},
                {"basis", "linear"},
                {"walls", {wall("left", "fixed"), wall("bottom", "slip"), wall("top", "slip")}},
                {"bodies",
                 {body("soil", box({0, 0}, {1, 0.5}, {4, 2}, "quad4"), 4,
                       elastic_soil("linear_elastic", E, 0.25, 1e-8))}},
                {"newton", {{"residual_tolerance", tolerance}, {"increment_tolerance", tolerance}}},
                {"rigid_walls",
                 {{{"name", "plate"},
                   {"surface", {{"polyline", {{1, 0.5}, {1, 0}}}, {"spacing", 0.25}}},
                   {"method", method},
                   {method == "facets" ? "penalty_factor" : "penalty", penalty},
                   {"motion", {{"table", {{0, 0, 0}, {1, -D, 0}, {200, -D, 0}, {201, D, 0}}}}}}}}});
  InterfaceValues sent;
  double penetration = 0, force = 0;
  for (int n = 1; n <= 200; ++n) {
    const StepRequest request{n, 0, n - 1.0, 1};
    penetration = solver->solve_step(request, {}, sent).details.at("plate.max_penetration");
    solver->accept_step(request, true);
    force = probe(*solver, "plate.fx");
  }
  run_steps(*solver, 1, 1, 201);
  return {force, penetration, probe(*solver, "plate.fx")};
}

TEST(RigidWalls, plate_pressed_on_a_column_and_pulled_off) {
  const double M = E * 0.75 / (1.25 * 0.5), A = 0.5, D = 1e-6;
  for (const double kappa : {1.0, 10.0, 100.0}) {
    const double eps = kappa * M / 0.25, F = D / (L / (M * A) + 1 / (eps * A));
    const Pressed pressed = press("boundary_points", eps, D);
    verify({.id = "V20",
            .what = fmt::format("force of a plate that presses a column, penalty {} M / h", kappa),
            .exact = F,
            .computed = pressed.force,
            .bound = 1e-5,
            .unit = "N/m"});
    EXPECT_NEAR(pressed.penetration, F / (eps * A), 1e-5 * F / (eps * A)) << kappa;
    EXPECT_EQ(pressed.after, 0) << kappa;
  }
}

/// The force by facets is F = A c M (d / h)^2 with the depth d, and D = L F / (M A) + d. The mean
/// force of a step comes to this within some steps.
TEST(RigidWalls, plate_pressed_on_a_column_by_facets) {
  const double M = E * 0.75 / (1.25 * 0.5), A = 0.5, h = 0.25;
  for (const double factor : {10.0, 1e5}) {
    for (const double D : {1e-6, 1e-5}) {
      const double over = 0.25 / (0.5 - 0.5 / std::sqrt(3.0));  // A' / A
      const double c = over * factor * L / (h * h), d = (std::sqrt(1 + 4 * c * D) - 1) / (2 * c);
      const Pressed pressed = press("facets", factor, D);
      verify({.id = "V20",
              .what = fmt::format("force of a plate, by facets, that presses a column by {} m, "
                                  "penalty_factor {}",
                                  D, factor),
              .exact = over * factor * M * d * d / (h * h) * A,
              .computed = pressed.force,
              .bound = 1e-5,
              .unit = "N/m"});
      EXPECT_NEAR(pressed.penetration, d, 1e-5 * d) << factor << " " << D;
      EXPECT_EQ(pressed.after, 0) << factor << " " << D;
    }
  }
}

/// Sand without cohesion on a rough rigid floor of some degrees, between smooth upright rigid
/// walls, in columns of cells sheared along the floor. It takes its weight without inertia, in ten
/// steps from the unstressed state: all points start at the apex of their cone.
Json sand_on_a_floor(double slope) {
  constexpr double h = 0.1;
  Json sand = elastic_soil("mohr_coulomb", 1e7, 0.3, 2000);
  sand["friction_angle"] = 30;
  const auto smooth = [&](const std::string& name, const Json& line) {
    return Json{
        {"name", name}, {"surface", {{"polyline", line}, {"spacing", h}}}, {"mode", "slip"}};
  };
  return {
      {"dimension", 2},
      {"analysis", "quasi_static"},
      {"grid", box({-0.2, -0.2}, {2.2, 1.8}, {24, 20}, "quad4")},
      {"gravity", {0, -10}},
      {"gravity_ramp", {{"duration", 1}}},
      {"bodies", {body("sand", box({0, 0}, {2, 0.4}, {20, 4}, "quad4"), 4, sand)}},
      {"rigid_walls",
       {{{"name", "floor"},
         {"surface", {{"polyline", {{2.2, 2.2 * slope}, {-0.2, -0.2 * slope}}}, {"spacing", h}}},
         {"friction", 0.5}},
        smooth("left", {{0, -0.2}, {0, 1.8}}),
        smooth("right", {{2, 1.8}, {2, -0.2}})}}};
}

void take_weight(const std::string& basis, double degrees) {
  const double slope = std::tan(degrees * M_PI / 180);
  Json scene = sand_on_a_floor(slope);
  scene["basis"] = basis;
  auto settings = mpm_settings<2>(scene);
  for (auto& X : settings.layouts[0].mesh.nodes) X[1] += slope * X[0];
  mpm::MpmSolver<2> solver(comm(), std::move(settings), "");
  run_steps(solver, 0.1, 10);
  verify({.id = "V12",
          .what = fmt::format("weight of sand without cohesion on a rough rigid floor of {} "
                              "degrees, from the unstressed state in ten quasi-static steps, {}",
                              degrees, basis),
          .exact = -2 * 0.4 * 2000 * 10,
          .computed = probe(solver, "floor.fy"),
          .bound = 1e-6,
          .unit = "N/m"});
}

TEST(RigidWalls, sand_takes_its_weight_on_an_inclined_floor) {
  for (const double degrees : {5.0, 20.0}) take_weight("linear", degrees);
  for (const double degrees : {1.0, 5.0, 10.0, 20.0}) take_weight("gimp", degrees);
}

}  // namespace
}  // namespace gabion::test
