// SPDX-License-Identifier: BSD-3-Clause
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <cmath>
#include <numeric>

#include "tests/support/verification_row.hpp"
#include "tests/unit/mpm/mpm_scene.hpp"
#include "tests/verification/mpm/coupled_run.hpp"

namespace gabion::test {
namespace {

/// Bars of length L with smooth sides, so that they are one-dimensional: impedance Z = sqrt(E rho),
/// c = sqrt(E / rho). Strains v0 / c = 0.3 % are small.
constexpr double L = 1, E = 1e6, rho = 1e3, v0 = 0.1;
const double c = std::sqrt(E / rho), Z = rho * c, contact_time = 2 * L / c;
constexpr int cells = 50;
constexpr double h = L / cells;

/// Contact lies in the middle of a cell, because a boundary point on a facet between two cells
/// belongs to one of them only.
Json grid(double from, int count) {
  return box({from - 0.5 * h, 0}, {from - 0.5 * h + count * h, h}, {count, 1}, "quad4");
}

Json bar(const std::string& name, double from, double modulus, double velocity) {
  return body(name, box({from, 0}, {from + L, h}, {cells, 1}, "quad4"), 4,
              elastic_soil("linear_elastic", modulus, 0, rho), {velocity, 0});
}

const Json smooth_sides = {wall("bottom", "slip"), wall("top", "slip")};
const Json damped = {{"scheme", "bossak"}, {"alpha", -0.1}};

/// Contact at x = 0 with a surface whose normal points to the bar on its right.
Json contact_surface(double x, bool bar_is_right, double penalty_factor) {
  const Json low = {x, 0.0}, high = {x, h};
  Json line = Json::array();
  line.push_back(bar_is_right ? low : high);
  line.push_back(bar_is_right ? high : low);
  return {{"name", "face"},
          {"surface", {{"polyline", line}, {"spacing", h}}},
          {"method", "boundary_points"},
          {"mode", "slip"},
          {"penalty_factor", penalty_factor}};
}

struct Contact {
  std::vector<double> time, pressure;  ///< [s], [Pa]

  /// Mean over the middle part of the contact.
  double plateau() const {
    double sum = 0;
    int count = 0;
    for (std::size_t n = 0; n < time.size(); ++n) {
      if (time[n] < 0.2 * contact_time || time[n] > 0.8 * contact_time) continue;
      sum += pressure[n];
      ++count;
    }
    return sum / count;
  }
  /// Last time at which the pressure is above half of `level`.
  double duration(double level) const {
    double last = 0;
    for (std::size_t n = 0; n < time.size(); ++n) {
      if (pressure[n] > 0.5 * level) last = time[n];
    }
    return last;
  }
};

void row(const std::string& what, double exact, double computed, double bound,
         const std::string& unit, const std::string& limitation = "") {
  verify({.id = "V8",
          .what = what,
          .exact = exact,
          .computed = computed,
          .bound = bound,
          .unit = unit,
          .limitation = limitation});
}

void draw(const std::string& figure, const std::string& label, const Contact& contact) {
  draw_curve({.id = "V8",
              .figure = figure,
              .x_label = "t [s]",
              .y_label = "pressure [Pa]",
              .label = label,
              .logarithmic = false},
             contact.time, contact.pressure);
}

/// A bar flies against a rigid surface: pressure rho c v0 for 2 L / c, then it leaves with -v0.
TEST(V8_Impact, bar_on_a_rigid_surface) {
  for (const double penalty_factor : {0.5, 20.0}) {
    const auto solver = mpm_solver<2>({{"dimension", 2},
                                       {"grid", grid(0, cells + 2)},
                                       {"basis", "linear"},
                                       {"walls", smooth_sides},
                                       {"bodies", {bar("bar", 0, E, -v0)}},
                                       {"time_integration", damped},
                                       {"newton", exact_newton},
                                       {"interfaces", {contact_surface(0, true, penalty_factor)}}});
    const double dt = 0.25 * h / c, end = 1.5 * contact_time;
    const double energy = probe(*solver, "kinetic_energy");
    const int steps = static_cast<int>(std::lround(end / dt));
    Contact contact;
    for (int n = 1; n <= steps; ++n) {
      const StepRequest request{n, 0, (n - 1) * dt, dt};
      InterfaceValues sent;
      solver->solve_step(request, {}, sent);
      solver->accept_step(request, true);
      const auto& f = sent.at("face");
      contact.time.push_back(n * dt);
      contact.pressure.push_back(-(f[0] + f[2]) / h);
    }
    const std::string what =
        fmt::format("bar on rigid surface, penalty {} M / h, MPM quad4", penalty_factor);
    draw("bar on a rigid surface", fmt::format("penalty {} M / h", penalty_factor), contact);
    row(what + ": pressure", Z * v0, contact.plateau(), 0.01, "Pa");
    row(what + ": contact time", contact_time, contact.duration(Z * v0), 0.03, "s");
    row(what + ": rebound", v0, probe(*solver, "momentum_x") / (rho * L * h), 0.05, "m/s");
    row(what + ": energy after", energy,
        probe(*solver, "kinetic_energy") + probe(*solver, "elastic_energy"), 0.06, "J/m");
  }
}

/// A bar of material points that comes with v0 / 2 and one of finite elements with -v0 / 2, through
/// the coupling loop: pressure v0 Z1 Z2 / (Z1 + Z2); with Z1 = Z2 they swap velocities.
struct CoupledImpact {
  Contact contact;
  double v_mpm, v_fem;  ///< mean velocities at the end [m/s]
};

/// Properties of the soil's bar.
struct Striking {
  double E_fem = E;
  double courant = 0.25;  // c dt / h
  bool explicit_soil = false;
};

CoupledImpact strike(const Striking& given) {
  const double dt = given.courant * h / c, end = 1.25 * contact_time;
  Json soil_settings = {{"dimension", 2},
                        {"grid", grid(-h, cells + 2)},
                        {"basis", "linear"},
                        {"walls", smooth_sides},
                        {"bodies", {bar("bar", 0, E, 0.5 * v0)}},
                        {"time_integration", damped},
                        {"newton", exact_newton},
                        {"interfaces", {contact_surface(L, false, 20)}}};
  if (given.explicit_soil) {
    soil_settings.erase("newton");
    soil_settings["time_integration"] = {{"scheme", "explicit"}};
    soil_settings["interfaces"][0]["method"] = "facets";
  }
  const auto soil = make_mpm(soil_settings);
  const auto structure = make_fem(
      {{"dimension", 2},
       {"mesh", box({L, 0}, {2 * L, h}, {cells, 1}, "quad4")},
       {"material", elastic_soil("linear_elastic", given.E_fem, 0, rho)},
       {"time_integration", damped},
       {"newton", exact_newton},
       {"initial_velocity", {-0.5 * v0, 0.0}},
       {"supports",
        {{{"group", "bottom"}, {"components", {"y"}}}, {{"group", "top"}, {"components", {"y"}}}}},
       {"interfaces", {{{"name", "face"}, {"groups", {"left"}}}}}});
  Witness soil_side(*soil), structure_side(*structure);
  CouplerSettings settings;
  settings.time = {end, dt, dt};
  settings.output_interval = 10 * end;
  settings.participants = {{"soil", true}, {"structure", false}};
  settings.interfaces = {{"face", "soil", "structure"}};
  settings.coupling.acceleration.method = "iqn_ils";
  settings.coupling.max_iterations = 50;
  settings.coupling.convergence.displacement = {v0 * dt, 1e-6, 1e-6 * v0 * dt, {}};
  settings.coupling.convergence.force = {1, 1e-6, 1e-6 * Z * v0 * h, {}};
  settings.coupling.mapping.tolerance = 1e-9;
  run_coupled(settings, soil_side, structure_side);
  CoupledImpact result;
  result.contact.time = soil_side.time;
  for (const auto& answer : soil_side.answers) {
    const auto& f = answer.at("face");
    result.contact.pressure.push_back((f[0] + f[2]) / h);
  }
  result.v_mpm = probe(*soil, "momentum_x") / (rho * L * h);
  result.v_fem = probe(*structure, "momentum_x") / (rho * L * h);
  return result;
}

TEST(V8_Impact, coupled_bars_of_equal_impedance) {
  const auto found = strike({});
  const std::string what = "MPM bar struck by FEM bar, Z1 = Z2, coupled";
  draw("coupled bars", "Z1 = Z2", found.contact);
  row(what + ": pressure", Z * v0 / 2, found.contact.plateau(), 0.01, "Pa");
  row(what + ": contact time", contact_time, found.contact.duration(Z * v0 / 2), 0.03, "s");
  row(what + ": velocity of the MPM bar after", -v0 / 2, found.v_mpm, 0.05, "m/s");
  row(what + ": velocity of the FEM bar after", v0 / 2, found.v_fem, 0.05, "m/s");
  verify({.id = "V8",
          .what = what + ": momentum of both afterwards over m v0",
          .exact = 0,
          .computed = (found.v_mpm + found.v_fem) / v0,
          .measure = Measure::absolute_error,
          .bound = 1e-6});
}

/// Substeps inside the coupling's steps: what one bar loses the other one gets.
TEST(V8_Impact, coupled_bars_with_explicit_soil) {
  for (const double courant : {0.5, 2.0, 5.0}) {
    const auto found = strike({.courant = courant, .explicit_soil = true});
    const std::string what =
        fmt::format("explicit MPM bar struck by FEM bar, steps of {} h / c, coupled", courant);
    draw("coupled bars", fmt::format("explicit, steps of {} h / c", courant), found.contact);
    row(what + ": pressure", Z * v0 / 2, found.contact.plateau(), 0.015, "Pa");
    row(what + ": velocity of the MPM bar after", -v0 / 2, found.v_mpm, 0.06, "m/s");
    row(what + ": velocity of the FEM bar after", v0 / 2, found.v_fem, 0.06, "m/s");
    verify({.id = "V8",
            .what = what + ": momentum of both afterwards over m v0",
            .exact = 0,
            .computed = (found.v_mpm + found.v_fem) / v0,
            .measure = Measure::absolute_error,
            .bound = 1e-11});
  }
}

TEST(V8_Impact, coupled_bars_of_unequal_impedance) {
  const auto found = strike({.E_fem = 4 * E});  // Z2 = 2 Z1
  draw("coupled bars", "Z2 = 2 Z1", found.contact);
  // The FEM bar's own wave is back after L / c: only the first half of the contact time counts.
  Contact first = found.contact;
  const double half = 0.5 * contact_time;
  double sum = 0;
  int count = 0;
  for (std::size_t n = 0; n < first.time.size(); ++n) {
    if (first.time[n] < 0.2 * half || first.time[n] > 0.8 * half) continue;
    sum += first.pressure[n];
    ++count;
  }
  row("MPM bar struck by FEM bar, Z2 = 2 Z1, coupled: pressure", Z * v0 * 2 / 3, sum / count, 0.01,
      "Pa");
}

const std::string shared_grid =
    "bodies of one grid share the velocity of its nodes: they meet, but do not part again";

/// Two bars of material points in one grid.
TEST(V8_Impact, bars_of_one_grid) {
  for (const double ratio : {1.0, 2.0}) {
    const auto solver =
        mpm_solver<2>({{"dimension", 2},
                       {"grid", grid(-h, 2 * cells + 3)},
                       {"basis", "linear"},
                       {"walls", smooth_sides},
                       {"bodies", {bar("left", 0, E, v0), bar("right", L, E * ratio * ratio, 0)}},
                       {"time_integration", damped},
                       {"newton", exact_newton}});
    const double dt = 0.25 * h / (ratio * c);
    const auto mean_of_right = [&](auto value) {
      const auto& points = solver->points();
      double sum = 0;
      int count = 0;
      for (std::int32_t p = points.body_starts[1]; p < points.body_starts[2]; ++p) {
        const double x = points.x[p][0] - points.u[p][0];
        if (x > L + 0.25 * L) continue;  // the quarter at the contact
        sum += value(p);
        ++count;
      }
      return sum / count;
    };
    const auto stress = [&] {
      return -mean_of_right([&](std::int32_t p) { return solver->points().tau[p][0]; });
    };
    const int steps = static_cast<int>(std::lround(0.6 * L / c / dt));
    run_steps(*solver, dt, steps);
    const std::string what = fmt::format("MPM bars of one grid, Z2 = {} Z1", ratio);
    row(what + ": pressure", Z * v0 * ratio / (1 + ratio), stress(), 0.03, "Pa");
    row(what + ": velocity of the contact", v0 / (1 + ratio),
        mean_of_right([&](std::int32_t p) { return solver->points().v[p][0]; }), 0.02, "m/s");
    if (ratio != 1) continue;
    const int all = static_cast<int>(std::lround(1.5 * contact_time / dt));
    run_steps(*solver, dt, all - steps, steps + 1);
    double momentum = 0, mass = 0;
    const auto& points = solver->points();
    for (std::int32_t p = points.body_starts[1]; p < points.body_starts[2]; ++p) {
      momentum += points.m[p] * points.v[p][0];
      mass += points.m[p];
    }
    row(what + ": velocity of the struck bar after 3 L / c", v0, momentum / mass, 1, "m/s",
        shared_grid);
  }
}

}  // namespace
}  // namespace gabion::test
