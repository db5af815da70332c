// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include <cmath>

#include "common/run/time_steps.hpp"
#include "mpm_solver/step_sizes/newton_counts.hpp"
#include "mpm_solver/step_sizes/step_control.hpp"
#include "tests/unit/mpm/mpm_scene.hpp"

namespace gabion::test::test_step_control {
namespace {

using mpm::DtLimit;
using mpm::DtProposal;
using mpm::StepControl;

StepControl defaults() {
  return StepControl(mpm::read_step_control(
      ConfigReader(Json::object(), "f.json", mpm::step_control_keys()), true));
}

TEST(StepControl, without_settings_only_the_phase_bounds) {
  StepControl control({});
  const auto free = control.accept({.dt = 1, .travel = 9, .strain = 9, .newton_iterations = 99}, 0);
  EXPECT_EQ(free.dt, 0);
  EXPECT_EQ(free.limit, DtLimit::none);
  EXPECT_EQ(control.accept({.dt = 1}, 0.7).limit, DtLimit::phase);
}

TEST(StepControl, limits_scale_the_last_step) {
  auto proposal = defaults().accept({.dt = 2, .travel = 0.6, .strain = 0.01}, 0);
  EXPECT_EQ(proposal.limit, DtLimit::advective);
  EXPECT_NEAR(proposal.dt, 1, 1e-15);
  proposal = defaults().accept({.dt = 2, .travel = 0.1, .strain = 0.08}, 0);
  EXPECT_EQ(proposal.limit, DtLimit::strain);
  EXPECT_NEAR(proposal.dt, 0.5, 1e-15);
  proposal = defaults().accept({.dt = 2, .travel = 0.1, .strain = 0.01, .approach_dt = 0.3}, 0);
  EXPECT_EQ(proposal.limit, DtLimit::approach);
  EXPECT_EQ(proposal.dt, 0.3);
}

TEST(StepControl, the_error_is_measured_by_the_fastest_step_so_far) {
  mpm::StepControlSettings settings;
  settings.time_error = 0.01;
  StepControl control(settings);
  auto proposal = control.accept({.dt = 2, .error = 0.16, .speed = 4}, 0);
  EXPECT_EQ(proposal.limit, DtLimit::time_error);
  EXPECT_NEAR(proposal.dt, 2 * 0.01 * 2 * 4 / 0.16, 1e-15);
  proposal = control.accept({.dt = 1, .error = 0.08, .speed = 1}, 0);
  EXPECT_NEAR(proposal.dt, 0.01 * 4 / 0.08, 1e-15);
  for (int n = 1; n <= 4; ++n) {
    EXPECT_LT(proposal.dt, 1);
    proposal = control.accept({.dt = 0.5, .error = 1e-9}, 0);
  }
  EXPECT_EQ(proposal.dt, 1);
  EXPECT_EQ(proposal.limit, DtLimit::none);
}

TEST(StepControl, many_iterations_shrink_and_four_easy_steps_allow_to_double) {
  StepControl control = defaults();
  EXPECT_EQ(control.accept({.dt = 1, .newton_iterations = 16}, 0).dt, 0.5);
  EXPECT_EQ(control.accept({.dt = 0.5, .newton_iterations = 6}, 0).dt, 0.5);
  DtProposal proposal;
  for (int n = 1; n <= 4; ++n) {
    EXPECT_LT(proposal.dt, 1);
    proposal = control.accept({.dt = 0.5, .newton_iterations = 4}, 0);
    EXPECT_EQ(proposal.limit, n < 4 ? DtLimit::newton : DtLimit::none);
  }
  EXPECT_EQ(proposal.dt, 1);
}

TEST(StepControl, a_failure_is_remembered_until_dt_is_back) {
  StepControl control = defaults();
  control.fail(1);
  for (int n = 0; n < 3; ++n) {
    const auto proposal = control.accept({.dt = 0.5, .newton_iterations = 2}, 0);
    EXPECT_EQ(proposal.limit, DtLimit::failure) << n;
    EXPECT_LT(proposal.dt, 1);
  }
  EXPECT_EQ(control.accept({.dt = 0.5, .newton_iterations = 2}, 0).limit, DtLimit::none);
}

TEST(NewtonCounts, histogram_mean_and_causes) {
  mpm::NewtonCounts counts;
  EXPECT_TRUE(counts.json()["mean"].is_null());
  for (const int iterations : {2, 3, 3, 8}) counts.add_solution(iterations);
  counts.add_failure("line_search");
  counts.add_failure("line_search");
  const Json json = counts.json();
  EXPECT_EQ(json["mean"], 4.0);
  EXPECT_EQ(json["max"], 8);
  EXPECT_EQ(json["histogram"], Json({{"2", 1}, {"3", 2}, {"8", 1}}));
  EXPECT_EQ(json["failures"], Json({{"line_search", 2}}));
  EXPECT_EQ(counts.text(),
            "Newton: 4 solutions, 4 iterations on average, 8 at most, 2 x line_search");
}

/// A block in flight at v, cells of h: dt settles at the largest step of the raster with
/// v dt <= 0.3 h, whatever dt_max allows.
TEST(StepControl, flight_moves_by_a_share_of_a_cell) {
  Json json = {{"dimension", 2},
               {"grid", box({0, 0}, {8, 2}, {32, 8}, "quad4")},
               {"bodies",
                {body("block", box({0.5, 0.5}, {1.5, 1.5}, {4, 4}, "quad4"), 4,
                      elastic_soil("hencky_elastic", 1e4, 0.3, 1000), {2, 0})}},
               {"newton", exact_newton},
               {"step_control", Json::object()}};
  const auto solver = make_mpm(json);
  TimeSteps steps({.end = 2, .dt = 1.0 / 256, .dt_min = 1e-4, .dt_max = 1});
  InterfaceValues sent;
  double largest = 0;
  AcceptReport report;
  while (!steps.finished()) {
    const StepRequest request{steps.step(), 0, steps.time(), steps.dt()};
    solver->solve_step(request, {}, sent);
    report = solver->accept_step(request, true);
    largest = std::max(largest, steps.dt());
    steps.accept(report.proposed_dt);
  }
  EXPECT_EQ(largest, 1.0 / 32);  // 0.3 h / v = 0.0375
  EXPECT_EQ(report.details["dt_limit"], static_cast<int>(DtLimit::advective));
  EXPECT_NEAR(probe(*solver, "momentum_x"), 2000, 1e-6);
}

/// Free flight while gravity grows by g dt a step: Newmark's displacement is exact but for
/// (beta - 1/6) dt^3 g, and the next dt is the one that estimate allows.
TEST(StepControl, error_of_a_step_is_that_of_newmarks_method) {
  const double dt = 1.0 / 64, g = 8, limit = 1e-4;
  const auto solver = make_mpm({{"dimension", 2},
                                {"grid", box({0, 0}, {2, 2}, {8, 8}, "quad4")},
                                {"gravity", {0, -g}},
                                {"gravity_ramp", {{"duration", 1}}},
                                {"time_integration", trapezoid},
                                {"bodies",
                                 {body("block", box({0.5, 0.5}, {1.5, 1.5}, {4, 4}, "quad4"), 4,
                                       elastic_soil("hencky_elastic", 1e4, 0.3, 1000))}},
                                {"newton", exact_newton},
                                {"probes", {{{"name", "P"}, {"point", {1, 1}}}}},
                                {"step_control",
                                 {{"time_error", limit},
                                  {"advective", nullptr},
                                  {"strain", nullptr},
                                  {"newton_target", nullptr}}}});
  const double start = probe(*solver, "P.uy");
  InterfaceValues sent;
  solver->solve_step({1, 0, 0, dt}, {}, sent);
  const AcceptReport report = solver->accept_step({1, 0, 0, dt}, true);
  const double error = std::abs(probe(*solver, "P.uy") - start + g * dt * dt * dt / 6);
  const double speed = std::sqrt(g * 0.25);  // of a fall through a cell
  EXPECT_NEAR(error, g * dt * dt * dt / 12, 1e-12);
  EXPECT_NEAR(report.proposed_dt, dt * limit * dt * speed / error, 1e-9);
  EXPECT_EQ(report.details["dt_limit"], static_cast<int>(DtLimit::time_error));
}

/// The obstacle that a few stray points run into.
enum class Obstacle { wall, facets, boundary_points };

/// The next dt after a step in which a block of one cell runs into an obstacle at 1 m/s while a
/// large one rests. Gravity does not act yet, but its sqrt(|g| h) is the speed by which errors are
/// measured. Only the error of the step limits dt.
/// @param density  of the block and, in steps of 1000 kg/m^3, its stiffness: which does not change
///                 its motion; the large one has 250 kg at 1000 kg/m^3
DtProposal proposal_of_stray_points(Obstacle obstacle, double density, MPI_Comm on = comm()) {
  const auto soil = [](double rho) { return elastic_soil("hencky_elastic", 100 * rho, 0.3, rho); };
  Json json = {
      {"dimension", 2},
      {"grid", box({1, 0}, {8, 1}, {28, 4}, "quad4")},
      {"gravity", {0, -1000}},
      {"gravity_ramp", {{"duration", 1e12}}},
      {"bodies",
       {body("rest", box({4, 0.25}, {6, 0.75}, {8, 2}, "quad4"), 4, soil(1000)),
        body("stray", box({1.25, 0.25}, {1.5, 0.5}, {1, 1}, "quad4"), 4, soil(density), {-1, 0})}},
      {"newton", exact_newton},
      {"step_control",
       {{"time_error", 1e-8},
        {"advective", nullptr},
        {"strain", nullptr},
        {"newton_target", nullptr},
        {"approach", nullptr}}}};
  if (obstacle == Obstacle::wall) {
    json["grid"] = box({1.25, 0}, {8, 1}, {27, 4}, "quad4");
    json["walls"] = {wall("left", "slip")};
  } else {
    json["interfaces"] = {{{"name", "plate"},
                           {"surface", {{"polyline", {{1.25, 0}, {1.25, 1}}}, {"spacing", 0.25}}}}};
  }
  if (obstacle == Obstacle::boundary_points) {
    json["interfaces"][0].update({{"method", "boundary_points"}, {"penalty", 1e5 * density}});
  }
  const auto solver = make_mpm(json, on);
  InterfaceValues sent;
  const StepRequest request{1, 0, 0, 1.0 / 256};
  solver->solve_step(request, {}, sent);
  const AcceptReport report = solver->accept_step(request, true);
  return {report.proposed_dt, static_cast<DtLimit>(report.details["dt_limit"].get<int>())};
}

double stray_mass(double density) {
  return 0.0625 * density;
}

/// Points that alone press on an interface count in full, however few they are.
TEST(StepControl, stray_points_that_touch_an_interface_count_in_full) {
  const auto share = [](double rho) { return stray_mass(rho) / (1000 + stray_mass(rho)); };
  for (const Obstacle obstacle : {Obstacle::facets, Obstacle::boundary_points}) {
    SCOPED_TRACE(static_cast<int>(obstacle));
    const DtProposal heavy = proposal_of_stray_points(obstacle, 1000);
    const DtProposal light = proposal_of_stray_points(obstacle, 10);
    EXPECT_EQ(light.limit, DtLimit::time_error);
    const double ratio = std::sqrt(share(1000) / share(10));
    EXPECT_NEAR(light.dt / heavy.dt, ratio, 1e-6 * ratio);
    EXPECT_NEAR(proposal_of_stray_points(obstacle, 10, MPI_COMM_SELF).dt, light.dt,
                1e-8 * light.dt);
  }
}

/// Up to a hundredth of the mass that runs into a wall does not shorten the next step.
TEST(StepControl, stray_points_that_run_into_a_wall_do_not_decide) {
  const DtProposal heavy = proposal_of_stray_points(Obstacle::wall, 1000);
  EXPECT_EQ(heavy.limit, DtLimit::time_error);
  EXPECT_LT(heavy.dt, 1e-3 / 256);
  EXPECT_NEAR(proposal_of_stray_points(Obstacle::wall, 1000, MPI_COMM_SELF).dt, heavy.dt,
              1e-8 * heavy.dt);
  ASSERT_LT(stray_mass(100), 0.01 * 1000);
  EXPECT_GT(proposal_of_stray_points(Obstacle::wall, 100).dt, 1.2 / 256);
}

/// A block in flight that hits a wall: long steps in flight, short ones while it bounces.
TEST(StepControl, steps_are_short_in_an_impact) {
  const auto solver = make_mpm({{"dimension", 2},
                                {"grid", box({0, 0}, {4, 1}, {16, 4}, "quad4")},
                                {"walls", {{{"group", "left"}, {"condition", "slip"}}}},
                                {"bodies",
                                 {body("block", box({0.5, 0.25}, {1.5, 0.75}, {4, 2}, "quad4"), 4,
                                       elastic_soil("hencky_elastic", 1e6, 0.3, 1000), {-1, 0})}},
                                {"newton", exact_newton},
                                {"step_control", {{"strain", nullptr}}}});
  TimeSteps steps({.end = 1.25, .dt = 1.0 / 32, .dt_min = 1e-5});
  InterfaceValues sent;
  double before = 0, shortest = 1;
  while (!steps.finished()) {
    const StepRequest request{steps.step(), 0, steps.time(), steps.dt()};
    solver->solve_step(request, {}, sent);
    const AcceptReport report = solver->accept_step(request, true);
    const bool flies = probe(*solver, "wall.left.fx") == 0;
    if (flies && steps.time() < 0.25) before = std::max(before, steps.dt());
    if (!flies) shortest = std::min(shortest, steps.dt());
    steps.accept(report.proposed_dt);
  }
  EXPECT_EQ(before, 1.0 / 32);
  EXPECT_LE(shortest, 1.0 / 512);
}

}  // namespace
}  // namespace gabion::test::test_step_control
