// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <cmath>

#include "tests/support/expect_error.hpp"
#include "tests/unit/fem/yielding_tower.hpp"

namespace gabion::test::test_yielding_structure {
namespace {

InterfaceValues on_top(const Solver& solver, double fx, double fy) {
  InterfaceValues values;
  for (int i = 0; i < solver.interfaces().at(0).num_vertices(); ++i) {
    values["wall"].insert(values["wall"].end(), {fx, fy});
  }
  return values;
}

InterfaceValues step(Solver& solver, int n, double force, bool accept = true) {
  const StepRequest request{n, 0, (n - 1) * 0.01, 0.01};
  InterfaceValues sent;
  solver.solve_step(request, on_top(solver, force, 0), sent);
  if (accept) {
    solver.accept_step(request, true);
  } else {
    solver.reject_step();
  }
  return sent;
}

double load_of(int n) {
  return 200 * std::sin(0.25 * n);
}

TEST(YieldingStructure, groups_of_cells_have_materials_of_their_own) {
  const TemporaryMesh mesh(two_groups());
  const auto solver = fem_solver<2>(tower_scene(mesh.path()));
  for (int n = 1; n <= 20; ++n) step(*solver, n, load_of(n));
  EXPECT_GT(probe(*solver, "plastic_strain_lower"), 5e-4);
  EXPECT_EQ(probe(*solver, "plastic_strain"), probe(*solver, "plastic_strain_lower"));
  EXPECT_GT(probe(*solver, "plastic_work"), 0);
  EXPECT_EQ(solver->summary().at("materials").at("upper"), "neo_hookean");
}

/// Both squares have an area of 1 m^2.
TEST(YieldingStructure, density_by_group) {
  const TemporaryMesh mesh(two_groups());
  const auto settings = fem_settings<2>(tower_scene(mesh.path()));
  const fem::CellIntegrals<2> cells(settings.mesh, settings.materials, false);
  std::vector<double> ones(12, 1.0), momentum(12, 0.0);
  cells.add_mass_times(ones, momentum);
  double sum = 0;
  for (std::size_t i = 0; i < momentum.size(); i += 2) sum += momentum[i];
  EXPECT_NEAR(sum, 1500, 1e-9);
}

void expect_refused(const GmshText& file, const std::function<void(Json&)>& change,
                    const std::vector<std::string_view>& parts) {
  const TemporaryMesh mesh(file);
  Json json = tower_scene(mesh.path());
  change(json);
  expect_error<ConfigError>([&] { fem_solver<2>(json); }, parts);
}

TEST(YieldingStructure, cells_without_material_or_with_two_are_refused) {
  expect_refused(
      two_groups(), [](Json& json) { json["materials"].erase(1); },
      {"/materials/0/group", "gabion_mesh", "cell 1 near (0.5, 1.5)", "no group", "1 such"});
  expect_refused(two_groups(), [](Json& json) { json["materials"][1]["group"] = "roof"; },
                 {"/materials/1/group", "roof", "gabion_mesh", "lower, upper"});
  expect_refused(two_groups(), [](Json& json) { json["materials"][1]["group"] = "lower"; },
                 {"/materials/1/group", "lower", "second time"});
  GmshText doubled = two_groups();
  doubled.entities[3].groups = {3, 4};
  expect_refused(doubled, [](Json&) {},
                 {"/materials/1/group", "cell 1 near (0.5, 1.5)", "\"lower\" and \"upper\""});
  GmshText empty = two_groups();
  empty.entities[3].groups = {3};
  expect_refused(empty, [](Json&) {}, {"/materials/1/group", "upper", "lower"});
  expect_refused(two_groups(), [](Json& json) { json["material"] = yielding(); },
                 {"/material", "both"});
  expect_refused(two_groups(), [](Json& json) { json.erase("materials"); },
                 {"/material", "neither"});
  expect_refused(two_groups(), [](Json& json) { json["materials"] = Json::array(); },
                 {"/materials", "[]"});
  expect_refused(two_groups(),
                 [](Json& json) {
                   json["mesh"] = box_2d({1, 2}, {1, 2});
                   json["supports"][0]["group"] = "bottom";
                 },
                 {"/materials/0/group", "lower", "a box has: none"});
}

void expect_material_refused(const Json& material, const std::vector<std::string_view>& parts) {
  const Json json = {{"dimension", 2}, {"mesh", box_2d({1, 2}, {1, 2})}, {"material", material}};
  expect_error<ConfigError>([&] { fem_solver<2>(json); }, parts);
}

TEST(YieldingStructure, wrong_hardening_is_refused) {
  expect_material_refused(yielding(0), {"/material/yield_stress", "0", "> 0"});
  expect_material_refused(yielding(-1e3), {"/material/yield_stress", "-1000"});
  Json material = yielding();
  material["yield_table"] = {{0, 1e3}, {0.1, 2e3}};
  expect_material_refused(material, {"/material/yield_stress", "both"});
  material.erase("yield_stress");
  expect_material_refused(material, {"/material/hardening_modulus"});
  material.erase("hardening_modulus");
  const auto with_rows = [&](const Json& rows) {
    material["yield_table"] = rows;
    return material;
  };
  expect_material_refused(with_rows({{0, 1e3}, {0.1, 2e3}, {0.1, 3e3}}),
                          {"/material/yield_table/2", "rising strains"});
  expect_material_refused(with_rows(Json::array()), {"/material/yield_table", "at least one row"});
  expect_material_refused(with_rows({{0.1, 1e3}}), {"/material/yield_table/0", "0.1", "0 in the"});
  expect_material_refused(with_rows({{0, 2e3}, {0.1, 1e3}}),
                          {"/material/yield_table/1", "1000", "2000", "no fall"});
  expect_material_refused(with_rows({{0, 0}}), {"/material/yield_table/0", "> 0"});
  material.erase("yield_table");
  expect_material_refused(material, {"/material/yield_stress", "neither"});
  Json elastic_one = elastic("neo_hookean", 1e6, 0.3, 1000);
  elastic_one["yield_stress"] = 1e3;
  expect_material_refused(elastic_one, {"/material/yield_stress"});
}

TEST(YieldingStructure, implausible_units_are_warned_of) {
  const auto warnings = [](double yield_stress, double kinematic) {
    Json material = elastic("von_mises", 210e9, 0.3, 7850);
    material["yield_stress"] = yield_stress;
    material["kinematic_modulus"] = kinematic;
    testing::internal::CaptureStderr();
    fem_settings<2>({{"dimension", 2}, {"mesh", box_2d({1, 2}, {1, 2})}, {"material", material}});
    return testing::internal::GetCapturedStderr();
  };
  expect_parts(warnings(355, 0), {"/material/yield_stress", "355", "in MPa?"});
  expect_parts(warnings(355e9, 0), {"/material/yield_stress", "more than a tenth"});
  expect_parts(warnings(355e6, 1e12), {"hardens by up to"});
  EXPECT_EQ(warnings(355e6, 1e9).find("yield"), std::string::npos);
}

TEST(YieldingStructure, implausible_units_of_a_group_are_warned_of) {
  const TemporaryMesh mesh(two_groups());
  Json json = tower_scene(mesh.path());
  json["materials"][1]["density"] = 7.85;
  testing::internal::CaptureStderr();
  fem_settings<2>(json);
  expect_parts(testing::internal::GetCapturedStderr(),
               {"/materials/1/density", "7.85", "in t/m^3 it would be 7.85e+03"});
}

/// A rejected step, and a solution that is asked for twice, change no bit of a plastic run.
TEST(YieldingStructure, rejected_and_repeated_steps_change_no_bit) {
  const TemporaryMesh mesh(two_groups());
  const Json json = tower_scene(mesh.path());
  const auto straight = fem_solver<2>(json), other = fem_solver<2>(json);
  for (int n = 1; n <= 20; ++n) {
    step(*straight, n, load_of(n));
    step(*other, n, 3 * load_of(n), /*accept=*/false);
    step(*other, n, load_of(n), /*accept=*/false);
    InterfaceValues first, again;
    const StepRequest request{n, 0, (n - 1) * 0.01, 0.01};
    other->solve_step(request, on_top(*other, load_of(n), 0), first);
    other->solve_step(request, on_top(*other, load_of(n), 0), again);
    EXPECT_EQ(first, again);
    other->accept_step(request, true);
    ASSERT_EQ(straight->state().motion.u, other->state().motion.u) << "step " << n;
    ASSERT_EQ(*straight->state().history, *other->state().history) << "step " << n;
  }
  EXPECT_GT(probe(*straight, "plastic_strain"), 5e-4);
}

/// A run that saved its state goes on as the one that starts from it, and as one that never saved,
/// to the bit.
TEST(YieldingStructure, restart_gives_the_same_bits) {
  for (const std::string formulation : {"full", "enhanced"}) {
    const TemporaryMesh mesh(two_groups());
    Json json = tower_scene(mesh.path());
    json["materials"][0]["formulation"] = formulation;
    const auto run = fem_solver<2>(json), restarted = fem_solver<2>(json);
    const auto straight = fem_solver<2>(json);
    for (int n = 1; n <= 8; ++n) {
      EXPECT_EQ(step(*run, n, load_of(n)), step(*straight, n, load_of(n)));
    }
    restarted->load_state(run->save_state());
    EXPECT_EQ(restarted->probes(), run->probes());
    for (int n = 9; n <= 20; ++n) {
      const auto sent = step(*straight, n, load_of(n));
      EXPECT_EQ(step(*run, n, load_of(n)), sent);
      EXPECT_EQ(step(*restarted, n, load_of(n)), sent);
    }
    EXPECT_EQ(restarted->save_state().reals, run->save_state().reals);
    EXPECT_GT(probe(*run, "plastic_strain"), 5e-4);
  }
}

TEST(YieldingStructure, a_state_without_history_is_refused) {
  Json json = {{"dimension", 2},
               {"mesh", box_2d({1, 2}, {1, 2})},
               {"material", elastic("hencky_elastic", 1e6, 0.3, 1000)}};
  const State elastic_state = fem_solver<2>(json)->save_state();
  json["material"] = yielding();
  const auto solver = fem_solver<2>(json);
  expect_error<Error>([&] { solver->load_state(elastic_state); }, {"plastic_work"});
}

/// A bar in tension and compression, free across: the law in one dimension, the reaction included.
Json bar(const std::string& formulation) {
  Json material = elastic("von_mises", 200e9, 0.3, 7850);
  material["yield_stress"] = 250e6;
  material["hardening_modulus"] = 1e9;
  material["kinematic_modulus"] = 5e9;
  material["formulation"] = formulation;
  const double end = std::expm1(0.005), back = std::expm1(-0.005);
  Json json = {{"dimension", 3},
               {"mesh", box_3d({1, 0.1, 0.1}, {3, 1, 1})},
               {"material", material},
               {"analysis", "static"}};
  json["supports"] = {{{"group", "left"}, {"components", {"x"}}, {"report_reaction", true}},
                      {{"group", "front"}, {"components", {"y"}}},
                      {{"group", "bottom"}, {"components", {"z"}}}};
  json["prescribed"] = {
      {{"group", "right"}, {"component", "x"}, {"table", {{0, 0}, {1, end}, {3, back}, {5, end}}}}};
  return json;
}

TEST(YieldingStructure, cyclic_bar) {
  for (const std::string formulation : {"full", "enhanced"}) {
    const auto solver = fem_solver<3>(bar(formulation));
    const auto reaction = [&] { return -probe(*solver, "reaction_left_x") / 0.01; };
    // Nominal stress of a bar that yields without change of volume, but for its elastic strain.
    const auto nominal = [](double stress, double strain) { return stress * std::exp(-strain); };
    run_steps(*solver, 0.1, 10);
    EXPECT_NEAR(reaction(), nominal(271.845e6, 0.005), 1e3);
    run_steps(*solver, 0.1, 20, 11);
    EXPECT_NEAR(reaction(), nominal(-278.914e6, -0.005), 1e3);
    run_steps(*solver, 0.1, 20, 31);
    EXPECT_NEAR(reaction(), nominal(285.915e6, 0.005), 1e3);
    EXPECT_NEAR(probe(*solver, "plastic_strain"), 0.0180628, 1e-7);
    // The work of the supports is the elastic energy and the plastic work, but for the trapezia of
    // the steps in which yielding begins.
    const double kept = probe(*solver, "elastic_energy") + probe(*solver, "plastic_work");
    EXPECT_NEAR(probe(*solver, "external_work"), kept, 1e-2 * kept);
  }
}

/// Reactions of a support and their moment about the centre of its facets: those of the loads.
TEST(YieldingStructure, moment_of_reactions) {
  Json json = {
      {"dimension", 3},
      {"mesh", box_3d({0.2, 0.4, 1}, {2, 3, 5})},
      {"material", elastic("linear_elastic", 1e9, 0.3, 1000)},
      {"analysis", "static"},
      {"supports", {{{"group", "bottom"}, {"report_reaction", true}, {"report_moment", true}}}},
      {"loads", {{{"point", {0.2, 0.0, 1.0}}, {"force", {3.0, 5.0, -7.0}}}}}};
  const auto solver = fem_solver<3>(json);
  run_steps(*solver, 1, 1);
  const Vector<3> arm(0.1, -0.2, 1), force(3, 5, -7);
  const Vector<3> moment = -arm.cross(force);
  for (int c = 0; c < 3; ++c) {
    const std::string axis = fem::component_names[c];
    EXPECT_NEAR(probe(*solver, "reaction_bottom_" + axis), -force[c], 1e-6);
    EXPECT_NEAR(probe(*solver, "moment_bottom_" + axis), moment[c], 1e-5);
  }
  json = {{"dimension", 2},
          {"mesh", box_2d({0.2, 1}, {2, 5})},
          {"material", elastic("linear_elastic", 1e9, 0.3, 1000)},
          {"analysis", "static"},
          {"supports", {{{"group", "bottom"}, {"report_moment", true}}}},
          {"loads", {{{"point", {0.2, 1.0}}, {"force", {3.0, -7.0}}}}}};
  const auto flat = fem_solver<2>(json);
  run_steps(*flat, 1, 1);
  EXPECT_NEAR(probe(*flat, "moment_bottom_z"), -(0.1 * -7 - 1 * 3), 1e-5);
}

/// The balance of a plate that is thrown into yielding closes with the step: the error is of second
/// order but for the step in which a point begins to yield.
TEST(YieldingStructure, energy_balance_in_dynamics) {
  const auto imbalance = [](double dt) {
    const TemporaryMesh mesh(two_groups());
    const auto solver = fem_solver<2>(tower_scene(mesh.path()));
    const int steps = static_cast<int>(std::lround(0.2 / dt));
    for (int n = 1; n <= steps; ++n) {
      const StepRequest request{n, 0, (n - 1) * dt, dt};
      InterfaceValues sent;
      solver->solve_step(request, on_top(*solver, 200 * std::sin(25 * n * dt), 0), sent);
      solver->accept_step(request, true);
    }
    EXPECT_GT(probe(*solver, "plastic_work"), 0.2 * probe(*solver, "external_work"));
    return std::abs(probe(*solver, "kinetic_energy") + probe(*solver, "elastic_energy") +
                    probe(*solver, "plastic_work") - probe(*solver, "external_work")) /
           probe(*solver, "external_work");
  };
  const double coarse = imbalance(4e-3), fine = imbalance(1e-3);
  EXPECT_LT(coarse, 0.02);
  EXPECT_LT(fine, 0.2 * coarse);
}

}  // namespace
}  // namespace gabion::test::test_yielding_structure
