// SPDX-License-Identifier: BSD-3-Clause
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "tests/support/verification_row.hpp"
#include "tests/unit/fem/concrete_bar.hpp"

namespace gabion::test {
namespace {

void step_to(Solver& solver, double dt, int n) {
  const StepRequest request{n, 0, (n - 1) * dt, dt};
  InterfaceValues sent;
  solver.solve_step(request, {}, sent);
  solver.accept_step(request, true);
}

/// A bar of any number of cells, short enough not to snap back (L < E G_f / f_t^2 + h / 2), one of
/// them weaker by a tenth, is torn: the fracture energy times its section, and its strength.
/// Between the elastic cells the crack follows sigma = f_t exp[2 H (1 - E e / f_t)], e the strain
/// of its cell, H of (T28).
TEST(concrete_Bar, fracture_energy_on_any_mesh) {
  constexpr double L = 0.25, height = 0.1, E = 30e9, f_t = 2.7e6, G_f = 100;
  for (const int cells : {5, 10, 20}) {
    const TemporaryMesh mesh(strip(L, height, cells));
    Json json = pulled_strip(mesh.path(), cells, 6e-4);
    const double h = L / cells, H = h / (2 * E * G_f / (f_t * f_t) - h);
    const auto solver = fem_solver<2>(json);
    constexpr int steps = 480;
    double peak = 0;
    for (int n = 1; n <= steps; ++n) {
      step_to(*solver, 1.0 / steps, n);
      const double force = -probe(*solver, "reaction_left_x");
      peak = std::max(peak, force);
      if (n != steps / 6) continue;
      // Elongation 1e-4 m: strain e of the weak cell from e h + sigma(e) / E (L - h).
      double low = f_t / E, high = 1e-4 / h;
      const auto stress = [&](double e) { return f_t * std::exp(2 * H * (1 - E * e / f_t)); };
      for (int k = 0; k < 100; ++k) {
        const double e = 0.5 * (low + high);
        (e * h + stress(e) / E * (L - h) < 1e-4 ? low : high) = e;
      }
      verify({.id = "concrete",
              .what = fmt::format("bar of {} cells: force while it is torn", cells),
              .exact = stress(low) * height,
              .computed = force,
              .bound = 2e-3,  // stress and strain are logarithmic, the force is one of the mesh
              .unit = "N"});
    }
    verify({.id = "concrete",
            .what = fmt::format("bar of {} cells: energy taken", cells),
            .exact = G_f * height,
            .computed = probe(*solver, "damage_work"),
            .bound = 1e-5,
            .unit = "J"});
    EXPECT_NEAR(peak, f_t * height, 0.02 * f_t * height);
  }
}

/// @returns whether the step from `time` on was solved; else it is to be cut
bool advance(Solver& solver, int n, double time, double dt) {
  const StepRequest request{n, 0, time, dt};
  InterfaceValues sent;
  try {
    solver.solve_step(request, {}, sent);
  } catch (const ConvergenceError&) {
    if (dt < 1e-6) throw;
    solver.reject_step();
    return false;
  }
  solver.accept_step(request, true);
  return true;
}

// A wall of concrete with bars near both faces, clamped at its foot, pushed at its crest.
constexpr double height = 2.5, thickness = 0.5, cover = 0.0625, steel = 1.571e-3;
constexpr double E_c = 32.8e9, E_s = 200e9, f_t = 2.9e6, f_c = 38e6, f_y = 500e6;

GmshText wall() {
  constexpr int across = 8, up = 40;
  GmshText file;
  file.groups = {{1, 1, "foot"}, {1, 2, "crest"}, {1, 3, "bars"}, {2, 4, "concrete"}};
  file.entities = {{1, 1, {1}}, {1, 2, {2}}, {1, 3, {3}}, {2, 1, {4}}};
  file.blocks = {{1, 1, 1, {}}, {1, 2, 1, {}}, {1, 3, 1, {}}, {2, 1, 3, {}}};
  const auto node = [](int i, int j) { return j * (across + 1) + i + 1; };
  for (int j = 0; j <= up; ++j) {
    for (int i = 0; i <= across; ++i) {
      file.nodes.push_back({thickness * i / across, height * j / up, 0});
      if (i == across) continue;
      if (j == 0) file.blocks[0].elements.push_back({node(i, 0), node(i + 1, 0)});
      if (j == up) file.blocks[1].elements.push_back({node(i, up), node(i + 1, up)});
      if (j == up) continue;
      file.blocks[3].elements.push_back(
          {node(i, j), node(i + 1, j), node(i + 1, j + 1), node(i, j + 1)});
    }
    if (j == up) break;
    for (const int i : {1, across - 1}) {
      file.blocks[2].elements.push_back({node(i, j), node(i, j + 1)});
    }
  }
  return file;
}

/// Stress of concrete under compression e > 0: linear to 0.4 f_c, then a parabola to f_c at 2.2e-3.
double compression(double e) {
  const double first = 0.4 * f_c / E_c, left = (2.2e-3 - e) / (2.2e-3 - first);
  if (e <= 0) return 0;
  return e <= first ? E_c * e : f_c - 0.6 * f_c * left * left;
}

/// Moment at which the steel on the tension side yields: plane sections, no tension, no weight.
/// @see docs of any design code for reinforced concrete, such as EN 1992-1-1, 6.1
double yield_moment() {
  const double depth = thickness - cover, e_y = f_y / E_s;
  const auto sums = [&](double x) {  // force and moment about the middle, x the compressed depth
    const double curvature = e_y / (depth - x);
    double force = steel * f_y, moment = steel * f_y * (depth - thickness / 2);
    const double other = E_s * curvature * (x - cover);  // compression of the other layer
    force -= steel * other;
    moment += steel * other * (thickness / 2 - cover);
    constexpr int fibres = 4000;
    for (int k = 0; k < fibres; ++k) {
      const double y = x * (k + 0.5) / fibres;  // from the compressed face
      const double stress = compression(curvature * (x - y)) * x / fibres;
      force -= stress;
      moment += stress * (thickness / 2 - y);
    }
    return std::pair{force, moment};
  };
  double low = 0.01, high = depth - 0.01;
  for (int k = 0; k < 60; ++k) {
    const double x = 0.5 * (low + high);
    (sums(x).first > 0 ? low : high) = x;
  }
  return sums(low).second;
}

TEST(concrete_Wall, moments_of_cracking_and_of_yield) {
  const TemporaryMesh mesh(wall());
  Json material = concrete("concrete", f_t);
  material["young_modulus"] = E_c;
  material["compressive_strength"] = f_c;
  material["fracture_energy"] = 140;
  Json json = {{"dimension", 2}, {"mesh", {{"file", mesh.path()}}}, {"analysis", "dynamic"}};
  json["time_integration"] = {{"scheme", "bossak"}};
  json["materials"] = {material,
                       {{"group", "bars"},
                        {"law", "bar"},
                        {"density", 5450},
                        {"young_modulus", E_s},
                        {"area", steel},
                        {"yield_stress", f_y},
                        {"hardening_modulus", 0.8e9}}};
  json["supports"] = {{{"group", "foot"}, {"report_reaction", true}}};
  json["prescribed"] = {{{"group", "crest"}, {"component", "x"}, {"table", {{0, 0}, {1, 0.025}}}}};
  const auto solver = fem_solver<2>(json);
  double at_crack = 0, at_yield = 0;
  constexpr int steps = 1500;  // slow beside the first period, short beside what a crack sets free
  double time = 0, dt = 1.0 / steps;
  for (int n = 1; time < 1 && at_yield == 0; ++n) {
    dt = std::min(1.0 / steps, 2 * dt);
    while (!advance(*solver, n, time, dt)) dt /= 2;
    time += dt;
    const double moment = -probe(*solver, "reaction_foot_x") * height;
    if (probe(*solver, "crack_width") < 2e-5) at_crack = std::max(at_crack, moment);
    if (probe(*solver, "plastic_strain") > 0) at_yield = moment;
  }
  // Uncracked section with its steel, under bending.
  const double ratio = E_s / E_c - 1, arm = thickness / 2 - cover;
  const double inertia = std::pow(thickness, 3) / 12 + 2 * ratio * steel * arm * arm;
  verify({.id = "concrete",
          .what = "wall: moment at the foot as a crack opens 0.02 mm",
          .exact = f_t * inertia / (thickness / 2),
          .computed = at_crack,
          .bound = 0.2,
          .unit = "N m"});
  verify({.id = "concrete",
          .what = "wall: moment at the foot as the steel yields",
          .exact = yield_moment(),
          .computed = at_yield,
          .bound = 0.03,
          .unit = "N m"});
}

}  // namespace
}  // namespace gabion::test
