// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "tests/support/expect_error.hpp"
#include "tests/unit/fem/plate.hpp"

namespace gabion::test::test_fem_solver {
namespace {

TEST(FemSolver, interface_faces_outward) {
  const auto solver = fem_solver<2>(plate());
  const auto meshes = solver->interfaces();
  ASSERT_EQ(meshes.size(), 1u);
  const InterfaceMesh& mesh = meshes[0];
  EXPECT_EQ(mesh.name, "wall");
  EXPECT_EQ(mesh.vertices_per_facet, 2);
  EXPECT_EQ(mesh.num_vertices(), 13);
  ASSERT_EQ(mesh.facets.size(), 24u);
  for (std::size_t f = 0; f < mesh.facets.size(); f += 2) {
    const auto* a = mesh.coordinates.data() + 2 * mesh.facets[f];
    const auto* b = mesh.coordinates.data() + 2 * mesh.facets[f + 1];
    const double nx = b[1] - a[1], ny = a[0] - b[0];
    // Left facets look to -x, top facets to +y.
    const bool is_left = a[0] == 0 && b[0] == 0;
    EXPECT_EQ(nx < 0, is_left);
    EXPECT_EQ(ny > 0, !is_left);
  }
}

TEST(FemSolver, starts_in_equilibrium_and_stays_at_rest) {
  const auto solver = fem_solver<2>(plate());
  const auto before = solver->state();
  EXPECT_TRUE(before.motion.is_still());
  EXPECT_LT(probe(*solver, "A.uy"), -1e-4);
  const double weight = width * height * density * g;
  EXPECT_NEAR(probe(*solver, "reaction_bottom_y"), weight, 1e-8 * weight);  // Newton's tolerance
  const StepRequest request{1, 0, 0, 0.01};
  InterfaceValues sent;
  const StepReport report = solver->solve_step(request, push(*solver, 0), sent);
  EXPECT_EQ(report.newton_iterations, 0);
  EXPECT_EQ(report.details.at("skipped"), 1);
  const AcceptReport accepted = solver->accept_step(request, true);
  EXPECT_TRUE(accepted.at_rest);
  EXPECT_EQ(solver->state().motion.u, before.motion.u);
  EXPECT_EQ(solver->summary().at("skipped_solves"), 1);
  EXPECT_EQ(sent.at("wall").size(), 26u);
}

TEST(FemSolver, says_where_its_interfaces_start) {
  const auto solver = fem_solver<2>(plate());
  const InterfaceValues start = start_displacements(*solver);
  InterfaceValues sent;
  solver->solve_step({1, 0, 0, 0.01}, push(*solver, 0), sent);
  ASSERT_EQ(start.size(), 1u);
  EXPECT_EQ(start, sent);  // at rest it stays there, to the bit
  EXPECT_NE(std::ranges::find(start.at("wall"), probe(*solver, "A.uy")), start.at("wall").end());
  Json json = plate();
  json["initial_equilibrium"] = false;
  EXPECT_TRUE(start_displacements(*fem_solver<2>(json)).empty());
}

TEST(FemSolver, a_push_ends_the_rest) {
  const auto solver = fem_solver<2>(plate());
  const double before = probe(*solver, "A.ux");
  const StepRequest request{1, 0, 0, 0.01};
  InterfaceValues sent;
  const StepReport report = solver->solve_step(request, push(*solver, 0.1), sent);
  EXPECT_GT(report.newton_iterations, 0);
  EXPECT_EQ(report.details.at("skipped"), 0);
  EXPECT_FALSE(solver->accept_step(request, true).at_rest);
  EXPECT_GT(probe(*solver, "A.ux"), before);
}

TEST(FemSolver, a_load_that_is_still_to_change_is_no_rest) {
  Json json = plate();
  json["tractions"] = {
      {{"group", "right"}, {"traction", {1.0, 0.0}}, {"table", {{0, 0}, {1, 0}, {2, 1}}}}};
  const auto solver = fem_solver<2>(json);
  const StepRequest request{1, 0, 0, 0.5};
  InterfaceValues sent;
  EXPECT_EQ(solver->solve_step(request, {}, sent).details.at("skipped"), 1);
  EXPECT_FALSE(solver->accept_step(request, true).at_rest);
}

TEST(FemSolver, unsolved_step_passes_time_only) {
  const auto solver = fem_solver<2>(plate());
  const auto u = solver->state().motion.u;
  EXPECT_TRUE(solver->accept_step({1, 0, 0, 0.01}, false).at_rest);
  EXPECT_EQ(solver->state().time, 0.01);
  EXPECT_EQ(solver->state().motion.u, u);
  expect_error<Error>(
      [&] {
        solver->accept_step({2, 0, 0.01, 0.01}, true);
      },
      {"step 2: accepted without a solution"});
}

/// Strong pushes, so that modified Newton renews its matrix within the steps.
TEST(FemSolver, repeated_requests_give_the_same_bits) {
  const auto solver = fem_solver<2>(plate());
  const auto strong = push(*solver, 8), stronger = push(*solver, 30);
  for (int n = 1; n <= 4; ++n) {
    const StepRequest request{n, 0, (n - 1) * 0.02, 0.02};
    InterfaceValues first, other, again, after_reject;
    solver->solve_step(request, strong, first);
    solver->solve_step(request, strong, again);
    EXPECT_EQ(first, again);
    solver->solve_step({n, 1, request.time, request.dt}, stronger, other);
    EXPECT_NE(first, other);
    const auto accepted = solver->state().motion.u;
    solver->reject_step();
    EXPECT_EQ(solver->state().motion.u, accepted);
    solver->solve_step(request, strong, after_reject);
    EXPECT_EQ(first, after_reject) << "step " << n;
    solver->accept_step(request, true);
  }
  EXPECT_GT(solver->summary().at("restored_matrices").get<int>(), 0);
}

TEST(FemSolver, rejected_steps_leave_no_trace) {
  const auto straight = fem_solver<2>(plate()), cut = fem_solver<2>(plate());
  const auto load = push(*straight, 10);
  InterfaceValues sent;
  for (int n = 1; n <= 5; ++n) {
    const StepRequest request{n, 0, (n - 1) * 0.02, 0.02};
    cut->solve_step({n, 0, request.time, 0.08}, push(*cut, 25), sent);
    cut->reject_step();
    for (auto* solver : {straight.get(), cut.get()}) {
      solver->solve_step(request, load, sent);
      solver->accept_step(request, true);
    }
    EXPECT_EQ(straight->save_state().reals, cut->save_state().reals) << "step " << n;
  }
}

/// Mean forces are part of the accepted state: rejected steps and a restart change no bit.
TEST(FemSolver, mean_forces_are_kept_over_cuts_and_restarts) {
  Json json = plate();
  json["time_integration"] = {{"scheme", "bossak"}, {"alpha", -0.1}};
  const auto straight = fem_solver<2>(json), other = fem_solver<2>(json);
  for (auto* solver : {straight.get(), other.get()}) {
    solver->set_force_kinds({{"wall", ForceKind::step_mean}});
  }
  InterfaceValues sent, sent_after;
  for (int n = 1; n <= 6; ++n) {
    const StepRequest request{n, 0, (n - 1) * 0.02, 0.02};
    const auto load = push(*straight, n < 5 ? 3.0 * n : 0);
    straight->solve_step(request, load, sent);
    straight->accept_step(request, true);
    const auto restarted = fem_solver<2>(json);
    restarted->set_force_kinds({{"wall", ForceKind::step_mean}});
    restarted->load_state(other->save_state());
    restarted->solve_step(request, load, sent_after);
    restarted->accept_step(request, true);
    other->solve_step({n, 0, request.time, 0.08}, push(*other, 25), sent_after);
    other->reject_step();
    other->solve_step(request, load, sent_after);
    EXPECT_EQ(sent, sent_after);
    other->accept_step(request, true);
    EXPECT_EQ(straight->save_state().reals, other->save_state().reals) << "step " << n;
    EXPECT_EQ(straight->save_state().reals, restarted->save_state().reals) << "step " << n;
  }
}

TEST(FemSolver, kinds_of_forces_on_unknown_interfaces_are_refused) {
  const auto solver = fem_solver<2>(plate());
  EXPECT_TRUE(solver->takes_force_kinds());
  expect_error<Error>(
      [&] {
        solver->set_force_kinds({{"roof", ForceKind::step_mean}});
      },
      {"found interface \"roof\""});
}

/// The factor of a linear structure serves all steps of one size.
TEST(FemSolver, linear_structure_factors_once) {
  const auto solver = fem_solver<2>(plate("linear_elastic"));
  const auto start = solver->summary().at("factorisations").get<int>();
  InterfaceValues sent;
  for (int n = 1; n <= 10; ++n) {
    const StepRequest request{n, 0, (n - 1) * 0.01, 0.01};
    for (int k = 0; k < 3; ++k) {
      solver->solve_step({n, k, request.time, request.dt}, push(*solver, n + 0.1 * k), sent);
    }
    solver->accept_step(request, true);
  }
  EXPECT_EQ(solver->summary().at("factorisations").get<int>() - start, 1);
  EXPECT_EQ(solver->summary().at("solves"), 30);
}

TEST(FemSolver, wrong_interface_values_and_steps_are_refused) {
  const auto solver = fem_solver<2>(plate());
  InterfaceValues sent;
  const auto refuses = [&](const StepRequest& request, const InterfaceValues& values,
                           const std::vector<std::string_view>& parts) {
    expect_error<Error>([&] { solver->solve_step(request, values, sent); }, parts);
  };
  const StepRequest first{1, 0, 0, 0.01};
  const std::vector<double> whole(26), part(24);
  refuses(first, {{"roof", whole}}, {"received no forces of interface \"wall\""});
  refuses(first, {{"wall", whole}, {"roof", whole}}, {"forces of 2 interfaces, expected 1"});
  refuses(first, {{"wall", part}},
          {"\"wall\": received 24 force values, expected 13 vertices x 2"});
  refuses({1, 0, 7, 0.01}, {}, {"step 1: asked to start at 7 s", "that of 0 s"});
  refuses({1, 0, 0, 0}, {}, {"step 1: found dt 0"});
}

/// A point inside a cell sees the interpolated displacement: exact for uniform stretching.
TEST(FemSolver, probe_inside_a_cell) {
  Json json = {{"dimension", 2},
               {"mesh", box_2d({width, height}, {2, 10})},
               {"material", elastic("linear_elastic", 1e5, 0, density)},
               {"analysis", "static"},
               {"supports",
                {{{"group", "bottom"}, {"report_reaction", true}},
                 {{"group", "left"}, {"components", {"x"}}}}},
               {"prescribed", {{{"group", "top"}, {"component", "y"}, {"rate", 0.01}}}},
               {"probes", {{{"name", "B"}, {"point", {0.033, 0.21}}}}}};
  const auto solver = fem_solver<2>(json);
  run_steps(*solver, 0.5, 2);
  EXPECT_NEAR(probe(*solver, "B.uy"), 0.01 * 0.21 / height, 1e-14);
  EXPECT_NEAR(probe(*solver, "reaction_bottom_y"), -1e5 * 0.01 / height * width, 1e-8);
  // Work of the moved side, W = k u^2 / 2 = stored energy.
  EXPECT_NEAR(probe(*solver, "external_work"), probe(*solver, "elastic_energy"), 1e-10);
  EXPECT_NEAR(probe(*solver, "elastic_energy"), 0.5 * 1e5 * width / height * 1e-4, 1e-10);
}

/// A load that acts at once is the same at any dt; one that grows is not.
TEST(FemSolver, statics_that_fail_at_any_dt_say_so) {
  Json json = {{"dimension", 2},
               {"mesh", box_2d({4, 1}, {16, 4})},
               {"material", elastic("neo_hookean", 1e5, 0.3, 1000)},
               {"analysis", "static"},
               {"supports", {{{"group", "left"}}}},
               {"loads", {{{"group", "right"}, {"force", {-60000, 500}}}}},
               {"newton", {{"max_iterations", 8}}}};
  const auto cause_of = [](Solver& solver, double dt) -> std::string {
    InterfaceValues sent;
    try {
      solver.solve_step({1, 0, 0, dt}, {}, sent);
    } catch (const ConvergenceError& error) {
      solver.reject_step();
      return error.cause();
    }
    return "";
  };
  const auto at_once = fem_solver<2>(json);
  const std::string first = cause_of(*at_once, 0.5);
  EXPECT_NE(first, "");
  EXPECT_NE(first, fails_at_any_dt);
  EXPECT_EQ(cause_of(*at_once, 0.25), fails_at_any_dt);
  json["loads"][0]["table"] = {{0, 0}, {1, 2}};
  const auto growing = fem_solver<2>(json);
  EXPECT_NE(cause_of(*growing, 0.5), "");
  EXPECT_NE(cause_of(*growing, 0.25), fails_at_any_dt);
  EXPECT_EQ(cause_of(*growing, 1e-5), "");
}

}  // namespace
}  // namespace gabion::test::test_fem_solver
