// SPDX-License-Identifier: BSD-3-Clause
// Cells and lines that fail and leave the structure, against closed forms and balances of energy.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "tests/support/expect_error.hpp"
#include "tests/unit/fem/beam_scene.hpp"
#include "tests/unit/fem/energy_balance.hpp"
#include "tests/unit/fem/line_scene.hpp"
#include "tests/unit/fem/yielding_tower.hpp"

namespace gabion::test::test_failing_cells {
namespace {

/// Two bars in a row of 1 m in all are pulled by 1 mm in a step.
Json pulled_bars(const std::string& file, int fade_steps) {
  Json material = line_material("bar", 200e9, 1e-4);
  material["yield_stress"] = 200e6;
  material["hardening_modulus"] = 1e9;
  material["failure_plastic_strain"] = 0.0095;
  material["fade_steps"] = fade_steps;
  Json json = line_scene(2, file, material);
  json["analysis"] = "static";
  json["supports"] = {{{"group", "low"}}, {{"group", "high"}, {"components", {"y"}}}};
  json["prescribed"] = {{{"group", "high"}, {"component", "x"}, {"rate", 1e-3}}};
  json["newton"] = {{"residual_tolerance", 1e-11}};
  return json;
}

/// At e = 0.011 the plastic strain p = (E e - s_0) / (E + H) = 2e9 / 201e9 exceeds its limit; the
/// bars keep s p + H p^2 / 2 of plastic and s^2 / 2 E of elastic work a volume. The node between
/// them, which nothing holds then, stays.
TEST(FailingCells, pulled_bar_breaks_with_the_energy_under_its_curve) {
  const TemporaryMesh mesh(chain(1, 2).file());
  const auto solver = fem_solver<2>(pulled_bars(mesh.path(), 1));
  for (int n = 1; n <= 10; ++n) advance(*solver, n, 1);
  EXPECT_EQ(probe(*solver, "failed_cells"), 0);
  advance(*solver, 11, 1);
  const double E = 200e9, H = 1e9, s_0 = 200e6, volume = 1e-4;
  const double p = (E * 0.011 - s_0) / (E + H), s = s_0 + H * p;
  EXPECT_EQ(probe(*solver, "failed_cells"), 2);
  EXPECT_NEAR(probe(*solver, "failed_energy"), volume * s * s / (2 * E), 1e-9);
  EXPECT_NEAR(probe(*solver, "plastic_work"), volume * (s_0 * p + H * p * p / 2), 1e-7);
  // The step in which they break has the force that broke them.
  EXPECT_NEAR(probe(*solver, "axial_max_rope"), 1e-4 * s, 1e-6);
  EXPECT_NEAR(probe(*solver, "stress_max_rope"), s, 1e-2);
  for (int n = 12; n <= 14; ++n) advance(*solver, n, 1);
  EXPECT_NEAR(probe(*solver, "axial_max_rope"), 0, 1e-6);
  EXPECT_NEAR(probe(*solver, "external_work"), volume * (s_0 * p + H * p * p / 2 + s * s / (2 * E)),
              1e-7);
  EXPECT_NEAR(imbalance(*solver), 0, 1e-7);
}

/// While the stress fades, work goes on by the share that is left.
TEST(FailingCells, fading_bar_keeps_the_balance) {
  const TemporaryMesh mesh(chain(1, 2).file());
  const auto solver = fem_solver<2>(pulled_bars(mesh.path(), 4));
  std::vector<double> forces;
  for (int n = 1; n <= 15; ++n) {
    advance(*solver, n, 1);
    if (n >= 10) forces.push_back(probe(*solver, "axial_max_rope"));
    EXPECT_NEAR(imbalance(*solver), 0, 1e-9 * std::max(1.0, probe(*solver, "external_work")));
  }
  // The stress is 209.45 MPa at n = 10, hardens on and breaks the bar; then 1/2, 1/4 of it, at last
  // none.
  const double slope = 1e9 * 200.0 / 201 * 1e-3;
  for (int k = 1; k <= 4; ++k) {
    const double stress = forces[0] / 1e-4 + k * slope;
    const double share = k == 1 ? 1 : 1 - 0.25 * k;
    EXPECT_NEAR(forces[k], share * stress * 1e-4, 1e-5) << k;
  }
  EXPECT_EQ(forces[5], 0);
}

/// A mass of 100 kg on two ropes of 1 m: the lower one breaks at 1.5 times the weight, while its
/// force rises to twice the weight. Then the mass falls freely, and the upper rope swings with its
/// own energy.
TEST(FailingCells, weaker_of_two_ropes_breaks) {
  LineText text = chain(2, 2);
  text.lines = {{"upper", {{1, 2}}}, {"lower", {{2, 3}}}};
  const TemporaryMesh mesh(text.file());
  Json upper = line_material("truss", 1e9, 1e-4, 2e3), lower = upper;
  upper["group"] = "upper";
  lower["group"] = "lower";
  upper["failure_force"] = 2000;
  lower["failure_force"] = 1500;
  lower["fade_steps"] = 2;
  Json json = {{"dimension", 2}, {"mesh", {{"file", mesh.path()}}}, {"gravity", {10, 0}}};
  json["materials"] = {upper, lower};
  json["mass"] = "lumped";
  json["supports"] = {{{"group", "low"}}};
  json["point_masses"] = {{{"point", {2, 0}}, {"mass", 100}}};
  json["probes"] = {{{"name", "mass"}, {"point", {2, 0}}}};
  json["newton"] = {{"residual_tolerance", 1e-11}};
  const auto solver = fem_solver<2>(json);
  const double dt = 1e-3;
  int n = 0;
  double before = 0;
  while (probe(*solver, "failed_cells") == 0 && n < 200) {
    before = probe(*solver, "axial_max_lower");
    advance(*solver, ++n, dt);
    EXPECT_NEAR(imbalance(*solver), 0, 1e-9);
  }
  ASSERT_LT(n, 200);
  // The largest force that is reported is the one that broke the rope, in a loaded state too.
  EXPECT_LT(before, 1500);
  const double breaking = probe(*solver, "axial_max_lower");
  EXPECT_GT(breaking, 1500);
  EXPECT_LT(breaking, 2000);
  const auto loaded = fem_solver<2>(json);
  loaded->load_state(solver->save_state());
  EXPECT_EQ(loaded->probes(), solver->probes());
  EXPECT_GT(probe(*solver, "failed_energy"), 0);
  // Half of it is lost at once, the other half in the next step.
  std::vector<double> x = {probe(*solver, "mass.ux")};
  for (int k = 0; k < 40; ++k) {
    advance(*solver, ++n, dt);
    x.push_back(probe(*solver, "mass.ux"));
    EXPECT_NEAR(imbalance(*solver), 0, 1e-9) << n;
  }
  EXPECT_EQ(probe(*solver, "failed_cells"), 1);
  EXPECT_EQ(probe(*solver, "axial_max_lower"), 0);
  const double force = 1500, energy = force * force / (2 * 1e9 * 1e-4);
  // The node between springs back and stretches what is left of the lower rope.
  EXPECT_GT(probe(*solver, "failed_energy"), energy);
  EXPECT_LT(probe(*solver, "failed_energy"), 1.25 * energy);
  for (std::size_t k = 3; k + 1 < x.size(); ++k) {
    EXPECT_NEAR((x[k + 1] - 2 * x[k] + x[k - 1]) / (dt * dt), 10, 1e-5) << k;
  }
}

/// The lower square yields and fails; nothing holds the upper one any more.
Json tower_that_loses_its_root(const std::string& file) {
  Json root = of_group("lower", yielding(2e4));
  root["failure_plastic_strain"] = 0.02;
  return {{"dimension", 2},
          {"mesh", {{"file", file}}},
          {"materials", {root, of_group("upper", elastic("neo_hookean", 2e6, 0.2, 500))}},
          {"mass", "lumped"},
          {"gravity", {0, 40}},
          {"newton", {{"residual_tolerance", 1e-11}}},
          {"supports", {{{"group", "foot"}, {"report_reaction", true}}}},
          {"interfaces", {{{"name", "wall"}, {"groups", {"top"}}}}}};
}

TEST(FailingCells, structure_that_loses_its_root_falls_freely) {
  const TemporaryMesh mesh(two_groups());
  const auto solver = fem_solver<2>(tower_that_loses_its_root(mesh.path()));
  const double dt = 2e-3;
  int n = 0;
  double largest = 0;
  const auto step = [&] {
    advance(*solver, ++n, dt);
    largest = std::max(largest, probe(*solver, "external_work"));
    EXPECT_LT(imbalance(*solver), 1e-3 * largest) << n;
  };
  while (probe(*solver, "failed_cells") == 0 && n < 400) step();
  ASSERT_LT(n, 400);
  for (int k = 0; k < 60; ++k) step();
  EXPECT_NEAR(imbalance(*solver), 0, 2e-3 * largest);
  EXPECT_GT(probe(*solver, "failed_energy"), 0);
  // Half of the mass of the lower square moves on with the upper one.
  for (int k = 0; k < 20; ++k) {
    const double before = probe(*solver, "momentum_y");
    step();
    EXPECT_NEAR((probe(*solver, "momentum_y") - before) / dt, 40 * (500 + 500), 1e-3);
  }
  EXPECT_EQ(solver->summary().at("failed_cells"), 1);
}

/// The first cell of a cantilever of beams fails under its own weight: the rest falls and turns.
template <int dim>
void expect_beams_to_fall() {
  const TemporaryMesh mesh(chain(4, 4).file());
  Json material = beam_material(2e9, 0.3, rectangle(0.1, 0.1), 2000);
  material["yield_stress"] = 4e6;
  material["failure_plastic_strain"] = 1e-3;
  Json json = cantilever_of_beams(dim, mesh.path(), material, 4, "dynamic");
  json["mass"] = "lumped";
  json["gravity"] = dim == 2 ? Json{0, -10} : Json{0, 0, -10};
  const auto solver = fem_solver<dim>(json);
  const std::string momentum = dim == 2 ? "momentum_y" : "momentum_z";
  int n = 0;
  double largest = 0;
  const auto step = [&] {
    advance(*solver, ++n, 1e-3);
    largest = std::max(largest, probe(*solver, "external_work"));
    EXPECT_NEAR(imbalance(*solver), 0, 2e-3 * largest + 1e-3) << n;
  };
  while (probe(*solver, "failed_cells") == 0 && n < 1000) step();
  ASSERT_LT(n, 1000);
  for (int k = 0; k < 20; ++k) step();
  const double before = probe(*solver, momentum);
  step();
  // The half of the first beam at the clamp does not fall.
  EXPECT_NEAR((probe(*solver, momentum) - before) / 1e-3, -10 * 2000 * 0.01 * 3.5, 1e-4);
}

TEST(FailingCells, beams_fail_by_the_strain_of_their_fibres) {
  expect_beams_to_fall<2>();
  expect_beams_to_fall<3>();
}

TEST(FailingCells, saved_state_and_repeats_give_the_same_bits) {
  const TemporaryMesh mesh(two_groups());
  const Json json = tower_that_loses_its_root(mesh.path());
  const auto run = fem_solver<2>(json), restarted = fem_solver<2>(json);
  const double dt = 2e-3;
  int n = 0;
  while (probe(*run, "failed_cells") == 0 && n < 400) advance(*run, ++n, dt);
  restarted->load_state(run->save_state());
  for (int k = 0; k < 6; ++k) {
    ++n;
    InterfaceValues sent;
    const StepRequest request{n, 0, (n - 1) * dt, dt};
    restarted->solve_step({n, 0, (n - 1) * dt, dt / 2}, {}, sent);
    restarted->reject_step();
    for (auto* solver : {run.get(), restarted.get()}) {
      solver->solve_step(request, {}, sent);
      solver->solve_step(request, {}, sent);
      solver->accept_step(request, true);
    }
    EXPECT_EQ(run->probes(), restarted->probes()) << n;
  }
  EXPECT_EQ(run->save_state().reals, restarted->save_state().reals);
}

TEST(FailingCells, step_counts_them) {
  const TemporaryMesh mesh(chain(1, 2).file());
  const auto solver = fem_solver<2>(pulled_bars(mesh.path(), 1));
  for (int n = 1; n <= 11; ++n) {
    const StepRequest request{n, 0, n - 1.0, 1};
    InterfaceValues sent;
    solver->solve_step(request, {}, sent);
    const AcceptReport report = solver->accept_step(request, true);
    EXPECT_EQ(report.details.at("failed_cells"), n == 11 ? 2 : 0);
  }
}

/// Statics find no equilibrium for what hangs on nothing.
TEST(FailingCells, statics_with_a_load_on_a_loose_part_are_refused) {
  const TemporaryMesh mesh(chain(1, 2).file());
  Json json = pulled_bars(mesh.path(), 1);
  json["loads"] = {{{"point", {0.5, 0}}, {"force", {10, 0}}}};
  const auto solver = fem_solver<2>(json);
  for (int n = 1; n <= 11; ++n) advance(*solver, n, 1);
  expect_error<ConvergenceError>([&] { advance(*solver, 12, 1); }, {"2 cells or lines failed"});
}

void expect_refused(const Json& change, const std::vector<std::string_view>& parts) {
  const TemporaryMesh mesh(two_groups());
  Json json = tower_that_loses_its_root(mesh.path());
  json.merge_patch(change);
  expect_error<ConfigError>([&] { fem_solver<2>(json); }, parts);
}

TEST(FailingCells, wrong_input) {
  Json root = of_group("lower", yielding());
  const Json upper = of_group("upper", elastic("neo_hookean", 2e6, 0.2, 500));
  const auto with = [&](const std::string& key, const Json& value) {
    Json changed = root;
    changed[key] = value;
    return Json{{"materials", {changed, upper}}};
  };
  expect_refused(with("failure_plastic_strain", 0), {"/materials/0/failure_plastic_strain", "0"});
  expect_refused(with("failure_damage", 0.5), {"/materials/0/failure_damage"});
  expect_refused(with("failure_force", 1e3), {"/materials/0/failure_force"});
  expect_refused(with("fade_steps", 2), {"/materials/0/fade_steps", "without a limit"});
  root["failure_plastic_strain"] = 0.1;
  expect_refused(with("fade_steps", 0), {"/materials/0/fade_steps", "0"});
  expect_refused(with("rayleigh", {{"stiffness", 1e-3}}),
                 {"/materials/0/rayleigh", "damping by stiffness"});
}

}  // namespace
}  // namespace gabion::test::test_failing_cells
