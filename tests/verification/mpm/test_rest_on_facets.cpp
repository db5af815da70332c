// SPDX-License-Identifier: BSD-3-Clause
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <cstdlib>

#include "tests/support/cut_steps.hpp"
#include "tests/support/verification_row.hpp"
#include "tests/unit/mpm/mpm_scene.hpp"

namespace gabion::test {
namespace {

constexpr double density = 2000, g = 10, k0 = 0.5;
constexpr int cells = 10;
constexpr double h = 1.0 / cells;

struct Way {
  std::string basis = "gimp";
  std::string type = "quad4";
  std::string locking = "none";
  double E = 2e7;
  double at = 0;            // of the wall in its cell
  bool floor = false;       // of facets too
  double max = 1;
};

Json resting(const Way& way) {
  Json sand = elastic_soil("mohr_coulomb", way.E, 0.3, density);
  sand["friction_angle"] = 35;
  const double W = 1 + h * way.at, low = way.floor ? -2 * h : 0;
  const double y = way.floor ? -h * way.at : 0;
  Json json = {{"dimension", 2},
               {"grid", box({0, low}, {1 + 3 * h, 1 + h}, {cells + 3, cells + (way.floor ? 3 : 1)}, way.type)},
               {"basis", way.basis},
               {"locking", {{"method", way.locking}}},
               {"gravity", {0, -g}},
               {"walls", {wall("left", "slip")}},
               {"newton", exact_newton},
               {"bodies",
                {body("soil", box({0, y}, {W, 1 + y}, {cells, cells}, way.type), way.type == "tri3" ? 3 : 4, sand)}},
               {"rigid_walls",
                {{{"name", "wall"},
                  {"surface", {{"polyline", {{W, 1 + h}, {W, y - (way.floor ? 0 : 1)}}}, {"spacing", h}}},
                  {"mode", "slip"}}}}};
  if (way.floor) {
    json["rigid_walls"].push_back({{"name", "floor"},
                  {"surface", {{"polyline", {{W, y}, {-1, y}}}, {"spacing", h}}},
                  {"mode", "slip"}});
  } else {
    json["walls"].push_back(wall("bottom", "slip"));
  }
  json["bodies"][0]["initial_stress"] = {{"k0", k0}, {"surface", 1 + y}, {"max_displacement", way.max}};
  return json;
}

TEST(V12, measure_explicit) {
  for (const std::string basis : {"gimp", "linear"})
  for (const double dt : {1e-5, 1e-4, 2e-4, 1e-3})
  for (const double E : {2e7}) {
    Json json = resting({.basis = basis, .E = E});
    json["time_integration"] = {{"scheme", "explicit"}};
    const auto solver = mpm_solver<2>(json);
    const double f0 = probe(*solver, "wall.fx");
    run_steps(*solver, dt, 1);
    const double f1 = probe(*solver, "wall.fx");
    double most = 0;
    for (int n = 2; n < 200; ++n) { run_steps(*solver, dt, 1, n); most = std::max(most, std::abs(probe(*solver, "wall.fx") / f0 - 1)); }
    fmt::print("explicit {} dt {} E {:.0e}: {:.5f} first, {:.5f} most, created {} balance {} stress {} loss {}\n", basis, dt, E, f1 / f0 - 1, most, probe(*solver, "contact_created"), probe(*solver, "energy_balance"), probe(*solver, "contact_energy"), probe(*solver, "contact_loss"));
  }
}

TEST(V12, measure_receding) {
  for (const std::string basis : {"gimp"})
  for (const double E : {1e6, 1e8}) {
    Json json = resting({.basis = basis, .E = E});
    json["analysis"] = "quasi_static";
    json["newton"] = Json::object();
    json["rigid_walls"][0]["motion"] = {{"velocity", {0.001, 0}}};
    const auto solver = mpm_solver<2>(json);
    fmt::print("recede E {:.0e}:", E);
    for (int n = 1; n <= 20; ++n) { run_steps(*solver, 0.1, 1, n);
      fmt::print(" {:.4f}", probe(*solver, "wall.fx") / 5000); }
    fmt::print("\n");
  }
}

TEST(V12, measure) {
  for (const std::string basis : {"gimp", "linear", "tri3", "bspline"})
  for (const std::string locking : {"none", "fbar"})
  for (const bool floor : {false, true})
  for (const double E : {1e5, 2e7, 1e8})
  for (const double at : {0.0, 0.5, 0.25}) {
    Way way{.basis = basis, .locking = locking, .E = E, .at = at, .floor = floor};
    if (basis == "tri3") way.basis = "linear", way.type = "tri3";
    if (floor && E == 2e7) continue;
    try {
    const auto solver = mpm_solver<2>(resting(way));
    const double lam = E * .3 / 1.3 / .4, mu = E / 2.6, C = (3 * lam + 2 * mu) / (1 + 2 * k0);
    // F = int K0 s exp(s / C) dd ,  dd = (1 + s / C) ds / (rho g)
    double F = 0, s1 = 2 * density * g / (1 + std::sqrt(1 + 2 * density * g / C));
    const int N = 2000;
    for (int k = 0; k < N; ++k) { double s = (k + .5) / N * s1; F += k0 * s * std::exp(s / C) * (1 + s / C) / (density * g) * s1 / N; }
    const double d0 = static_cast<double>(solver->summary().at("initial_displacement")) / h;
    const double f0 = probe(*solver, "wall.fx") / F;
    const double w = probe(*solver, "mass") * g;
    const double w0 = floor ? probe(*solver, "floor.fy") / w : 0;
    std::string rest;
    try { run_with_cuts(*solver, {.end = 0.5, .dt = 0.01, .dt_min = 1e-5}); 
    double most = 0;
    for (const auto& u : solver->points().u) most = std::max(most, u.norm());
    rest = fmt::format("{:9.5f} floor {:9.5f} moved {:.2e} h, balance {:.1e} created {:.1e} loss {:.1e} Ec {:.3e} KE {:.1e}", probe(*solver, "wall.fx") / F - 1, floor ? probe(*solver, "floor.fy") / w +1 : 0, most / h,
      probe(*solver, "energy_balance"), probe(*solver, "contact_created"), probe(*solver, "contact_loss"), probe(*solver, "contact_energy"), probe(*solver, "kinetic_energy"));
    } catch (const std::exception& e) { rest = e.what(); }
    fmt::print("{:8} {} floor {:d} E {:.0e} at {:4}: lacks {:.2e} h, force {:9.5f} floor {:9.5f} later {}\n", basis, locking, floor, E, at, d0, f0 - 1, floor ? w0 + 1 : 0, rest);
    } catch (const std::exception& e) { fmt::print("{:8} {} floor {:d} E {:.0e} at {:4}: {}\n", basis, locking, floor, E, at, e.what()); }
    std::fflush(stdout);
  }
}

}  // namespace
}  // namespace gabion::test
