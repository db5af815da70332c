// SPDX-License-Identifier: BSD-3-Clause
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <cmath>

#include "tests/support/expect_error.hpp"
#include "tests/unit/mpm/pushed_soil.hpp"

namespace gabion::test::test_explicit_step {
namespace {

const Json explicit_steps = {{"scheme", "explicit"}};

/// A block that falls onto the floor and slides along a face, in cells that its points cross.
Json falling(int dim, const std::string& type, const std::string& basis = "linear") {
  std::vector<double> low(dim, 0.0), high(dim, 2.0), from(dim, 0.5), to(dim, 1.0);
  std::vector<double> velocity(dim, 0.3), gravity(dim, 0.0);
  from[dim - 1] = 0.02;
  to[dim - 1] = 0.52;
  velocity[dim - 1] = -1;
  gravity[dim - 1] = -9.81;
  const std::string body_type = dim == 2 ? "quad4" : "hex8";
  return {{"dimension", dim},
          {"grid", box(low, high, std::vector<int>(dim, dim == 2 ? 8 : 6), type)},
          {"basis", basis},
          {"walls", {wall("bottom", "slip")}},
          {"gravity", gravity},
          {"bodies",
           {body("block", box(from, to, std::vector<int>(dim, 4), body_type), dim == 2 ? 4 : 1,
                 elastic_soil("neo_hookean", 1e4, 0.3, 100), velocity)}},
          {"time_integration", explicit_steps}};
}

double momentum_error(const Solver& solver, int dim) {
  double largest = 0;
  for (int d = 0; d < dim; ++d) {
    const std::string name = std::string("momentum_error_") + "xyz"[d];
    largest = std::max(largest, std::abs(probe(solver, name)));
  }
  return largest;
}

TEST(ExplicitStep, momentum_is_the_impulse_of_gravity_and_walls) {
  for (const auto& [dim, type] : {std::pair{2, "tri3"}, {2, "quad4"}, {3, "tet4"}, {3, "hex8"}}) {
    for (const double pic_share : {0.0, 0.1}) {
      Json json = falling(dim, type);
      json["transfer"] = {{"pic_share", pic_share}};
      const auto solver = make_mpm(json);
      const double start = std::abs(probe(*solver, dim == 2 ? "momentum_y" : "momentum_z"));
      run_steps(*solver, 0.01, 12);
      EXPECT_LT(momentum_error(*solver, dim), 1e-12 * start) << type;
      EXPECT_GT(probe(*solver, dim == 2 ? "momentum_y" : "momentum_z"), 0);  // it bounced
      EXPECT_GT(probe(*solver, "wall_loss"), 0);
      EXPECT_GE(solver->summary()["explicit"]["substeps"], 12);
    }
  }
}

/// Each substep integrates the law from the one before, so many in a step lose no plastic work.
TEST(ExplicitStep, energy_of_yielding_soil_in_many_substeps) {
  Json json = falling(2, "quad4");
  Json& sand = json["bodies"][0]["material"];
  sand = elastic_soil("mohr_coulomb", 2e6, 0.3, 1000);
  sand["friction_angle"] = 30;
  json["walls"] = {wall("bottom", "fixed")};
  const auto solver = make_mpm(json);
  run_steps(*solver, 0.02, 20);
  EXPECT_GT(solver->summary()["explicit"]["substeps"], 80);
  const double fallen = probe(*solver, "gravity_work");
  EXPECT_GT(probe(*solver, "plastic_dissipation"), 0.5 * fallen);
  EXPECT_LT(std::abs(probe(*solver, "energy_balance")), 5e-3 * fallen);
}

/// A point on the face between two cells has no weight at nodes that feel its stress.
TEST(ExplicitStep, momentum_with_nodes_without_weight) {
  Json json = falling(2, "quad4");
  json["bodies"][0]["mesh"] = box({0.4375, 0.1875}, {0.9375, 0.6875}, {4, 4}, "quad4");
  json["bodies"][0]["points_per_cell"] = 1;
  json["bodies"][0]["velocity"] = {0, -1};
  const auto solver = mpm_solver<2>(json);
  std::vector<Vector<2>> v;
  for (const auto& x : solver->points().x) v.push_back({std::sin(9 * x[0]), std::cos(7 * x[1])});
  solver->set_motion(v, std::vector<Vector<2>>(v.size(), Vector<2>::Zero()));
  run_steps(*solver, 0.002, 20);
  EXPECT_LT(momentum_error(*solver, 2), 1e-12 * probe(*solver, "mass"));
  EXPECT_GT(probe(*solver, "elastic_energy"), 1);
}

TEST(ExplicitStep, momentum_where_the_floor_holds_what_a_contact_pulls) {
  for (const std::string basis : {"linear", "gimp", "bspline"}) {
    Json json = falling(2, "quad4", basis);
    json["rigid_walls"] = {
        {{"name", "face"},
         {"surface", {{"polyline", {{1.01, 2}, {1.01, -0.1}}}, {"spacing", 0.1}}},
         {"friction", 0.5}}};
    const auto solver = make_mpm(json);
    const double start = std::abs(probe(*solver, "momentum_y"));
    run_steps(*solver, 0.01, 12);
    EXPECT_GT(probe(*solver, "contact_friction"), 0);
    EXPECT_GT(probe(*solver, "wall_loss"), 0);
    EXPECT_LT(momentum_error(*solver, 2), 1e-12 * start) << basis;
  }
}

Json pushed_by_facets(double courant) {
  Json json = pushed();
  json.erase("newton");
  json.erase("linear_solver");
  json["interfaces"][0]["method"] = "facets";
  json["interfaces"][0]["friction"] = 0.4;
  json["time_integration"] = {{"scheme", "explicit"}, {"courant", courant}};
  return json;
}

/// The force that the structure receives is that on the soil: p' - p = dt F, whatever the substeps.
TEST(ExplicitStep, impulse_of_an_interface) {
  for (const double courant : {0.9, 0.03}) {
    Json json = pushed_by_facets(courant);
    json["walls"] = Json::array();
    json.erase("gravity");
    const auto solver = make_mpm(json);
    const double dt = 0.002;
    Vector<2> impulse = Vector<2>::Zero();
    double size = 0;
    for (int n = 1; n <= 20; ++n) {
      const StepRequest request{n, 0, (n - 1) * dt, dt};
      InterfaceValues sent;
      solver->solve_step(request, plate_at(0.002 * n), sent);
      solver->accept_step(request, true);
      const auto& f = sent.at("plate");
      for (std::size_t k = 0; k < f.size(); ++k) {
        impulse[static_cast<Eigen::Index>(k % 2)] -= dt * f[k];
        size += dt * std::abs(f[k]);
      }
      EXPECT_NEAR(probe(*solver, "momentum_x"), impulse[0], 1e-12 * size) << n;
      EXPECT_NEAR(probe(*solver, "momentum_y"), impulse[1], 1e-12 * size) << n;
    }
    EXPECT_GT(size, 1e-3);
    EXPECT_LT(momentum_error(*solver, 2), 1e-12 * size);
    const double work = probe(*solver, "boundary_work");
    EXPECT_GT(work, 0);
    EXPECT_LT(std::abs(probe(*solver, "energy_balance")), 0.05 * work);
    EXPECT_GT(solver->summary()["explicit"]["most_in_a_step"], courant == 0.9 ? 0 : 4);
  }
}

/// Soil that comes and goes within one step was in contact all the same.
TEST(ExplicitStep, a_touch_between_the_ends_of_a_step) {
  Json json = pushed_by_facets(0.5);
  json["walls"] = {wall("bottom", "slip")};
  json.erase("gravity");
  json["bodies"][0]["mesh"] = box({0.52, 0}, {1.52, 0.5}, {8, 4}, "tri3");
  json["bodies"][0]["velocity"] = {-1, 0};
  json["bodies"][0]["material"] = elastic_soil("neo_hookean", 1e5, 0.3, 1000);
  const auto solver = make_mpm(json);
  InterfaceValues sent;
  const StepRequest request{1, 0, 0, 0.3};
  const StepReport report = solver->solve_step(request, {}, sent);
  EXPECT_LT(sent.at("plate")[0], -1);
  EXPECT_TRUE(report.interface_active);
  EXPECT_GT(report.details.at("closed_points"), 0);
  solver->accept_step(request, true);
  EXPECT_GT(probe(*solver, "momentum_x"), 0);
}

/// Iterations, a rejected step and a cut leave nothing behind.
TEST(ExplicitStep, a_repeated_step_gives_the_same_bits) {
  const double dt = 0.002;
  const auto once = mpm_solver<2>(pushed_by_facets(0.2));
  const auto often = mpm_solver<2>(pushed_by_facets(0.2));
  InterfaceValues a, b;
  for (int n = 1; n <= 10; ++n) {
    const StepRequest request{n, 0, (n - 1) * dt, dt};
    once->solve_step(request, plate_at(0.002 * n), a);
    often->solve_step(request, plate_at(0.0021 * n), b);
    often->solve_step({n, 1, (n - 1) * dt, dt}, plate_at(0.0022 * n), b);
    often->reject_step();
    often->solve_step({n, 0, (n - 1) * dt, dt / 2}, plate_at(0.002 * n), b);
    often->reject_step();
    often->solve_step(request, plate_at(0.002 * n + 0.02), b);  // stiffer contact
    often->solve_step(request, plate_at(0.002 * n), b);
    EXPECT_EQ(a, b) << n;
    once->accept_step(request, true);
    often->accept_step(request, true);
    EXPECT_TRUE(same_bits(once->points(), often->points())) << n;
  }
  EXPECT_EQ(once->probes(), often->probes());
}

TEST(ExplicitStep, a_loaded_state_goes_on_with_the_same_bits) {
  const double dt = 0.002;
  const auto through = mpm_solver<2>(pushed_by_facets(0.2));
  const auto loaded = mpm_solver<2>(pushed_by_facets(0.2));
  const auto step = [&](mpm::MpmSolver<2>& solver, int n) {
    InterfaceValues sent;
    const StepRequest request{n, 0, (n - 1) * dt, dt};
    solver.solve_step(request, plate_at(0.002 * n), sent);
    solver.accept_step(request, true);
  };
  for (int n = 1; n <= 6; ++n) step(*through, n);
  loaded->load_state(through->save_state());
  for (int n = 7; n <= 12; ++n) {
    step(*through, n);
    step(*loaded, n);
  }
  EXPECT_TRUE(same_bits(through->points(), loaded->points()));
  EXPECT_EQ(through->probes(), loaded->probes());
}

/// The velocity of an explicit phase is that of its end: the implicit one after it goes on.
TEST(ExplicitStep, phases_of_both_kinds) {
  Json json = falling(2, "quad4");
  json["walls"] = Json::array();
  json["bodies"][0]["velocity"] = {0.3, 0.5};
  json["time_integration"] = trapezoid;
  json["newton"] = exact_newton;
  json["phases"] = {{{"until", 0.02}},
                    {{"until", 0.04}, {"time_integration", explicit_steps}},
                    {{"time_integration", trapezoid}}};
  const auto solver = mpm_solver<2>(json);
  run_steps(*solver, 0.005, 12);
  const double t = 0.06, y = 0.5 * t - 9.81 / 2 * t * t;
  for (const auto& u : solver->points().u) {
    EXPECT_NEAR(u[0], 0.3 * t, 1e-12);
    EXPECT_NEAR(u[1], y, 1e-12);
  }
}

TEST(ExplicitStep, a_point_that_would_be_squeezed_fails_the_step) {
  Json json = falling(2, "quad4");
  json["bodies"][0]["velocity"] = {0, -1000};
  json["outside"] = "remove";
  const auto solver = make_mpm(json);
  InterfaceValues sent;
  expect_error<ConvergenceError>(
      [&] {
        solver->solve_step({1, 0, 0, 0.001}, {}, sent);
      },
      {"explicit", "squeezed"});
}

TEST(ExplicitStep, what_it_does_not_do_is_refused) {
  const auto expect_refused = [](const Json& json, const std::vector<std::string_view>& parts) {
    expect_error<ConfigError>([&] { make_mpm(json); }, parts);
  };
  const Json good = pushed_by_facets(0.9);
  make_mpm(good);
  Json json = good;
  json["interfaces"][0]["method"] = "boundary_points";
  expect_refused(json, {"/interfaces/0/method", "boundary_points", "explicit", "facets"});
  json = good;
  json["transfer"] = {{"method", "tpic"}};
  expect_refused(json, {"/transfer", "tpic", "explicit", "flip"});
  json = good;
  json["basis"] = "linear";
  json["small_cuts"] = {{"method", "ghost"}};
  expect_refused(json, {"/small_cuts", "ghost", "explicit"});
  json = good;
  json["newton"] = Json::object();
  expect_refused(json, {"/newton", "explicit"});
  json = good;
  json["linear_solver"] = Json::object();
  expect_refused(json, {"/linear_solver", "explicit"});
  for (const char* key : {"time_error", "newton_target"}) {
    json = good;
    json["step_control"] = {{key, 0.5}};
    if (key == std::string("newton_target")) json["step_control"][key] = 5;
    expect_refused(json, {std::string_view("/step_control/"), key, "explicit"});
  }
  json = good;
  json["time_integration"]["courant"] = 2.1;
  expect_refused(json, {"/time_integration/courant", "2.1", "(0, 2]"});
  json = good;
  json["time_integration"]["alpha"] = -0.1;
  expect_refused(json, {"/time_integration/alpha"});
}

}  // namespace
}  // namespace gabion::test::test_explicit_step
