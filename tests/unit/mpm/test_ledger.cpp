// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include <cmath>

#include "tests/support/convergence_rate.hpp"
#include "tests/unit/mpm/pushed_soil.hpp"

namespace gabion::test::test_ledger {
namespace {

const Json tight_newton = {{"residual_tolerance", 1e-12}, {"increment_tolerance", 1e-12}};
const Json bossak = {{"scheme", "bossak"}, {"alpha", -0.3}};
const Json generalized = {{"scheme", "generalized_alpha"}, {"rho_inf", 0.6}};

/// A block that falls onto the floor of its box and slides there.
Json falling(int dim, const std::string& type, const Json& scheme, const std::string& transfer,
             double height = 0.02) {
  std::vector<double> low(dim, 0.0), high(dim, 2.0), from(dim, 0.5), to(dim, 1.0);
  std::vector<double> velocity(dim, 0.3), gravity(dim, 0.0);
  from[dim - 1] = height;
  to[dim - 1] = height + 0.5;
  velocity[dim - 1] = -1;
  gravity[dim - 1] = -9.81;
  const std::string body_type = dim == 2 ? "quad4" : "hex8";
  return {{"dimension", dim},
          {"grid", box(low, high, std::vector<int>(dim, dim == 2 ? 8 : 6), type)},
          {"basis", "linear"},
          {"walls", {wall("bottom", "slip")}},
          {"gravity", gravity},
          {"bodies",
           {body("block", box(from, to, std::vector<int>(dim, 4), body_type), dim == 2 ? 4 : 1,
                 elastic_soil("neo_hookean", 1e4, 0.3, 100), velocity)}},
          {"newton", tight_newton},
          {"transfer", {{"method", transfer}}},
          {"time_integration", scheme}};
}

double momentum_error(const Solver& solver, int dim) {
  double sum = 0;
  for (int d = 0; d < dim; ++d) {
    sum = std::max(sum, std::abs(probe(solver, std::string("momentum_error_") + "xyz"[d])));
  }
  return sum;
}

TEST(Ledger, momentum_is_the_impulse_of_gravity_and_walls) {
  for (const Json& scheme : {trapezoid, bossak, generalized}) {
    for (const char* transfer : {"flip", "tpic"}) {
      for (const auto& [dim, type] :
           {std::pair{2, "tri3"}, {2, "quad4"}, {3, "tet4"}, {3, "hex8"}}) {
        const auto solver = make_mpm(falling(dim, type, scheme, transfer));
        const double start = std::abs(probe(*solver, dim == 2 ? "momentum_y" : "momentum_z"));
        run_steps(*solver, 0.01, 12);
        EXPECT_LT(momentum_error(*solver, dim), 1e-12 * start) << type << scheme << transfer;
        EXPECT_GT(probe(*solver, dim == 2 ? "momentum_y" : "momentum_z"), 0);  // it bounced
        EXPECT_GT(probe(*solver, "wall_loss"), 0);
      }
    }
  }
}

/// Friction on a surface pulls at nodes that the floor holds, in other shares in each step.
TEST(Ledger, momentum_where_the_floor_holds_what_a_contact_pulls) {
  for (const Json& scheme : {trapezoid, bossak}) {
    Json json = falling(2, "quad4", scheme, "flip");
    json["rigid_walls"] = {
        {{"name", "face"},
         {"surface", {{"polyline", {{1.01, 2}, {1.01, -0.1}}}, {"spacing", 0.1}}},
         {"method", "facets"},
         {"friction", 0.5}}};
    const auto solver = make_mpm(json);
    const double start = std::abs(probe(*solver, "momentum_y"));
    run_steps(*solver, 0.01, 12);
    EXPECT_GT(probe(*solver, "contact_friction"), 0);
    EXPECT_GT(probe(*solver, "wall_loss"), 0);
    EXPECT_LT(momentum_error(*solver, 2), 1e-12 * start) << scheme;
  }
}

/// Two surfaces that meet are one contact: each has its part of the momentum.
TEST(Ledger, momentum_of_surfaces_that_meet) {
  for (const Json& scheme : {trapezoid, bossak}) {
    Json json = falling(2, "quad4", scheme, "flip");
    json["walls"] = Json::array();
    const auto add = [&](const char* name, double from, double to) {
      json["rigid_walls"].push_back(
          {{"name", name},
           {"surface", {{"polyline", {{from, 0.015}, {to, 0.015}}}, {"spacing", 0.1}}},
           {"friction", 0.3}});
    };
    add("right", 2, 0.75);
    add("left", 0.75, -1);
    const auto solver = make_mpm(json);
    const double start = std::abs(probe(*solver, "momentum_y"));
    run_steps(*solver, 0.01, 12);
    EXPECT_GT(probe(*solver, "left.fy") * probe(*solver, "right.fy"), 0);
    EXPECT_LT(momentum_error(*solver, 2), 1e-12 * start) << scheme;
  }
}

/// Without walls and gravity the plate's force is all there is: p' - p = dt (F + F') / 2.
TEST(Ledger, impulse_and_work_of_an_interface) {
  Json json = pushed();
  json["walls"] = Json::array();
  json.erase("gravity");
  json["newton"] = tight_newton;
  json["time_integration"] = trapezoid;
  json["interfaces"][0]["method"] = "boundary_points";
  json["interfaces"][0]["mode"] = "fixed";
  const auto solver = make_mpm(json);
  const double dt = 0.002;
  double force_n = 0, impulse = 0, size = 0;
  for (int n = 1; n <= 20; ++n) {
    const StepRequest request{n, 0, (n - 1) * dt, dt};
    InterfaceValues sent;
    solver->solve_step(request, plate_at(0.002 * n), sent);
    solver->accept_step(request, true);
    double force = 0;  // on the soil
    for (const std::size_t k : {0, 2, 4}) force -= sent.at("plate")[k];
    impulse += dt * (force_n + force) / 2;
    size += dt * std::abs(force);
    force_n = force;
    EXPECT_NEAR(probe(*solver, "momentum_x"), impulse, 1e-11 * size) << n;
  }
  EXPECT_LT(momentum_error(*solver, 2), 1e-11 * size);
  EXPECT_GT(size, 1);
  const double work = probe(*solver, "boundary_work");
  EXPECT_GT(work, probe(*solver, "kinetic_energy"));
  EXPECT_GT(probe(*solver, "plastic_dissipation"), 0.01 * work);
  EXPECT_LT(std::abs(probe(*solver, "energy_balance")), 0.05 * work);
}

/// Soil that takes up its weight slowly, in a tub.
TEST(Ledger, impulses_close_without_inertia) {
  Json tub = {{"name", "tub"},
              {"surface", {{"polyline", {{1, 1.1}, {1, 0}, {0, 0}, {0, 1.1}}}, {"spacing", 0.05}}},
              {"friction", 0}};
  const auto solver = make_mpm({{"dimension", 2},
                                {"grid", box({-0.2, -0.2}, {1.2, 1.2}, {14, 14}, "quad4")},
                                {"rigid_walls", Json::array({tub})},
                                {"analysis", "quasi_static"},
                                {"gravity", {0, -10}},
                                {"gravity_ramp", {{"duration", 0.4}}},
                                {"bodies",
                                 {body("block", box({0, 0}, {1, 1}, {10, 10}, "quad4"), 4,
                                       elastic_soil("linear_elastic", 1e7, 0.3, 1000))}}});
  run_steps(*solver, 0.1, 4);
  EXPECT_LT(momentum_error(*solver, 2), 1e-5 * 1000 * 10 * 0.4);
}

/// A bar that is fixed at one end and moves outwards.
Json bar(const std::string& law, const Json& scheme, double pic_share = 0) {
  Json material = elastic_soil(law, 100, 0, 1);
  if (law == "mohr_coulomb") {
    material["friction_angle"] = 30;
    material["cohesion"] = 2;
  }
  return {{"dimension", 2},
          {"grid", box({0, 0}, {12, 1}, {12, 1}, "quad4")},
          {"basis", "linear"},
          {"walls", {wall("left", "fixed"), wall("bottom", "slip"), wall("top", "slip")}},
          {"bodies", {body("bar", box({0, 0}, {8, 1}, {8, 1}, "quad4"), 4, material, {1, 0})}},
          {"time_integration", scheme},
          {"transfer", {{"pic_share", pic_share}}},
          {"newton", tight_newton}};
}

double mechanical_energy(const Solver& solver) {
  return probe(solver, "kinetic_energy") + probe(solver, "elastic_energy");
}

/// Points cross cells here; every loss has its column.
TEST(Ledger, energy_of_a_linear_bar_is_accounted_for_exactly) {
  for (const Json& scheme : {trapezoid, bossak, generalized}) {
    for (const double pic_share : {0.0, 0.1}) {
      const auto solver = make_mpm(bar("linear_elastic", scheme, pic_share));
      const double start = mechanical_energy(*solver);
      run_steps(*solver, 0.05, 60);
      const double lost = start - mechanical_energy(*solver);
      const double named = probe(*solver, "time_damping") + probe(*solver, "transfer_loss") +
                           probe(*solver, "wall_loss") + probe(*solver, "quadrature_loss");
      EXPECT_NEAR(lost, named, 1e-12 * start);
      EXPECT_NEAR(probe(*solver, "energy_balance"), 0, 1e-12 * start);
      EXPECT_GT(probe(*solver, "wall_loss"), 0.01 * start);  // the first step stops the end
      EXPECT_EQ(probe(*solver, "plastic_dissipation"), 0);
      EXPECT_EQ(probe(*solver, "gravity_work"), 0);
      EXPECT_EQ(probe(*solver, "boundary_work"), 0);
    }
  }
}

/// A remainder that is not zero: stresses between the ends of a step are not known.
double rest(const std::string& law, int steps) {
  const auto solver = make_mpm(bar(law, trapezoid));
  run_steps(*solver, 1.6 / steps, steps);
  return std::abs(probe(*solver, "energy_balance"));
}

TEST(Ledger, rest_of_finite_strain_is_of_second_order) {
  for (const char* law : {"neo_hookean", "hencky_elastic"}) {
    std::vector<double> sizes, errors;
    for (const int steps : {16, 32, 64}) {
      sizes.push_back(1.6 / steps);
      errors.push_back(rest(law, steps));
    }
    EXPECT_GT(last_rate(sizes, errors), 1.8) << law;
  }
}

/// The trapezoidal rule for the work of stresses holds for the plastic work too; kinks, where
/// points begin to yield inside a step, cost some of the order.
TEST(Ledger, rest_of_yielding_soil_falls_faster_than_the_step) {
  std::vector<double> sizes, errors;
  for (const int steps : {80, 160, 320}) {
    sizes.push_back(1.6 / steps);
    errors.push_back(rest("mohr_coulomb", steps));
  }
  EXPECT_GT(lowest_rate(sizes, errors), 1.8);
  const auto solver = make_mpm(bar("mohr_coulomb", trapezoid));
  const double start = mechanical_energy(*solver);
  run_steps(*solver, 0.01, 160);
  EXPECT_GT(probe(*solver, "plastic_dissipation"), 0.05 * start);
  EXPECT_LT(errors[1], 1e-4 * start);
}

/// A column that shows more of what it is for than without it, after 5 s.
void expect_in(const std::string& column, const Json& without, const Json& with, double dt) {
  const auto plain = make_mpm(without), damped = make_mpm(with);
  for (auto* solver : {plain.get(), damped.get()}) {
    run_steps(*solver, dt, static_cast<int>(std::lround(5 / dt)));
  }
  const double start = 4;
  EXPECT_GT(probe(*damped, column), probe(*plain, column) + 0.01 * start) << column;
}

TEST(Ledger, damping_shows_where_it_acts) {
  const Json plain = bar("linear_elastic", trapezoid);
  expect_in("time_damping", plain, bar("linear_elastic", bossak), 0.2);
  expect_in("transfer_loss", plain, bar("linear_elastic", trapezoid, 0.2), 0.05);
}

/// Falling soil gains kinetic energy, but gravity is its source.
TEST(Ledger, energy_that_gravity_gives_is_not_created) {
  const auto solver = make_mpm(falling(2, "quad4", trapezoid, "flip", 1.2));
  const double start = probe(*solver, "kinetic_energy");
  run_steps(*solver, 0.005, 20);
  EXPECT_GT(probe(*solver, "kinetic_energy"), 1.5 * start);
  EXPECT_NEAR(probe(*solver, "gravity_work"), probe(*solver, "kinetic_energy") - start,
              1e-12 * start);
  EXPECT_LT(probe(*solver, "created_energy"), 1e-12 * start);
}

/// Two blocks that meet: TPIC continues velocities across the contact and adds energy.
TEST(Ledger, created_energy_is_the_largest_rise) {
  for (const char* transfer : {"flip", "tpic"}) {
    const Json soft = elastic_soil("neo_hookean", 1e3, 0.2, 1);
    const Json json = {
        {"dimension", 2},
        {"grid", box({0, 0}, {4, 2}, {16, 8}, "quad4")},
        {"basis", "linear"},
        {"bodies",
         {body("left", box({0.5, 0.5}, {1.5, 1.5}, {8, 8}, "quad4"), 4, soft, {2, 0.1}),
          body("right", box({2.0, 0.6}, {3.0, 1.6}, {8, 8}, "quad4"), 4, soft, {-1, 0})}},
        {"transfer", {{"method", transfer}}},
        {"newton", exact_newton},
        {"time_integration", trapezoid}};
    const auto solver = make_mpm(json);
    double lowest = mechanical_energy(*solver), rise = 0;
    for (int n = 1; n <= 40; ++n) {
      run_steps(*solver, 0.01, 1, n);
      lowest = std::min(lowest, mechanical_energy(*solver));
      rise = std::max(rise, mechanical_energy(*solver) - lowest);
      EXPECT_NEAR(probe(*solver, "created_energy"), rise, 1e-12);
    }
    EXPECT_EQ(rise > 0.001 * lowest, transfer == std::string("tpic"));
  }
}

/// A body without walls that a surface holds: the mean acceleration of the old and the new end of a
/// step moves it. Velocities that take the new acceleration for the old one as well, because it was
/// overwritten first, change by dt a'.
TEST(Ledger, velocity_takes_the_mean_of_old_and_new_acceleration) {
  for (const char* transfer : {"flip", "tpic"}) {
    Json json = pushed();
    json["walls"] = Json::array();
    json.erase("gravity");
    json["newton"] = tight_newton;
    json["time_integration"] = trapezoid;
    json["transfer"] = {{"method", transfer}};
    json["interfaces"][0]["method"] = "boundary_points";
    const auto solver = mpm_solver<2>(json);
    const auto sum = [&](const std::vector<Vector<2>>& values) {
      Vector<2> total = Vector<2>::Zero();
      for (std::int32_t p = 0; p < solver->points().size(); ++p) {
        total += solver->points().m[p] * values[p];
      }
      return total;
    };
    const double dt = 0.002;
    for (int n = 1; n <= 5; ++n) {
      const Vector<2> p = sum(solver->points().v), f = sum(solver->points().a);
      const StepRequest request{n, 0, (n - 1) * dt, dt};
      InterfaceValues sent;
      solver->solve_step(request, plate_at(0.002 * n * n), sent);
      solver->accept_step(request, true);
      const Vector<2> f_new = sum(solver->points().a);
      EXPECT_LT((sum(solver->points().v) - p - 0.5 * dt * (f + f_new)).norm(),
                1e-12 * dt * f_new.norm());
      EXPECT_GT((f_new - f).norm(), 0.1 * f_new.norm());
    }
  }
}

}  // namespace
}  // namespace gabion::test::test_ledger
