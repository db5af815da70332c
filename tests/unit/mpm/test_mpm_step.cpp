// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include <cmath>
#include <set>

#include "common/base/unbalanced.hpp"
#include "tests/support/expect_error.hpp"
#include "tests/unit/mpm/pushed_soil.hpp"

namespace gabion::test::test_mpm_step {
namespace {

/// A block of 1 m that flies freely through a grid of 4 m.
Json flight(int dim, const std::string& grid_type, const std::string& scheme) {
  const std::string body_type = dim == 2 ? "quad4" : "hex8";
  std::vector<double> low(dim, 0.0), high(dim, 4.0), from(dim, 1.0), to(dim, 2.0);
  std::vector<double> velocity(dim, 0.7), gravity(dim, 0.0);
  gravity[dim - 1] = -2;
  velocity[dim - 1] = 1.1;
  const int n = dim == 2 ? 8 : 5;
  Json json = {{"dimension", dim},
               {"grid", box(low, high, std::vector<int>(dim, n), grid_type)},
               {"basis", "linear"},
               {"gravity", gravity},
               {"bodies",
                {body("block", box(from, to, std::vector<int>(dim, 3), body_type), dim == 2 ? 4 : 1,
                      elastic_soil("neo_hookean", 1e4, 0.3, 3), velocity)}},
               {"newton", exact_newton},
               {"time_integration", {{"scheme", scheme}}}};
  return json;
}

/// x = x_0 + v t + g t^2 / 2 and p = m (v + g t), in one rigid piece over many cells.
template <int dim>
void check_flight(const std::string& grid_type, const std::string& scheme,
                  const std::string& transfer) {
  Json json = flight(dim, grid_type, scheme);
  json["transfer"] = {{"method", transfer}};
  const auto solver = mpm_solver<dim>(json);
  const auto start = solver->points();
  run_steps(*solver, 0.05, 20);
  Vector<dim> move = Vector<dim>::Constant(0.7), v = move;
  move[dim - 1] = 1.1 - 1;
  v[dim - 1] = 1.1 - 2;
  const auto& points = solver->points();
  double stress = 0, x_error = 0, v_error = 0;
  for (std::int32_t p = 0; p < points.size(); ++p) {
    x_error = std::max(x_error, (points.x[p] - start.x[p] - move).norm());
    v_error = std::max(v_error, (points.v[p] - v).norm());
    stress = std::max(stress, points.tau[p].norm());
  }
  EXPECT_LT(x_error, 1e-11) << grid_type << " " << scheme;
  EXPECT_LT(v_error, 1e-11) << grid_type << " " << scheme;
  EXPECT_LT(stress, 1e-7);  // modulus 1e4
  EXPECT_NEAR(probe(*solver, "mass"), 3, 1e-12);
  EXPECT_NEAR(probe(*solver, dim == 2 ? "momentum_y" : "momentum_z"), 3 * (1.1 - 2), 1e-10);
  EXPECT_NEAR(probe(*solver, "momentum_x"), 3 * 0.7, 1e-10);
}

TEST(MpmStep, free_flight_is_exact) {
  for (const char* scheme : {"newmark", "bossak", "generalized_alpha"}) {
    for (const char* transfer : {"flip", "tpic"}) {
      check_flight<2>("tri3", scheme, transfer);
      check_flight<2>("quad4", scheme, transfer);
      check_flight<3>("tet4", scheme, transfer);
      check_flight<3>("hex8", scheme, transfer);
    }
  }
}

/// Two elastic blocks that meet in the middle of the grid.
Json collision(const std::string& grid_type = "quad4", const std::string& transfer = "flip") {
  const Json soft = elastic_soil("neo_hookean", 1e3, 0.2, 1);
  const Json heavy = elastic_soil("hencky_elastic", 3e3, 0.1, 2);
  return {{"dimension", 2},
          {"grid", box({0, 0}, {4, 2}, {16, 8}, grid_type)},
          {"basis", "linear"},
          {"bodies",
           {body("left", box({0.5, 0.5}, {1.5, 1.5}, {8, 8}, "quad4"), 4, soft, {2, 0.1}),
            body("right", box({2.0, 0.6}, {3.0, 1.6}, {8, 8}, "quad4"), 4, heavy, {-1, 0})}},
          {"newton", exact_newton},
          {"transfer", {{"method", transfer}}},
          {"time_integration", trapezoid}};
}

/// Corners of all cells that hold a point.
template <int dim>
std::size_t nodes_in_use(const Mesh<dim>& grid, const mpm::MaterialPoints<dim>& points) {
  std::set<std::int32_t> nodes;
  for (const std::int32_t cell : points.cell) {
    const auto corners = grid.cell(cell);
    nodes.insert(corners.begin(), corners.end());
  }
  return nodes.size();
}

TEST(MpmStep, details_of_an_accepted_step_are_those_of_the_points) {
  const auto solver = mpm_solver<2>(collision());
  const auto grid = box_mesh<2>({0, 0}, {4, 2}, {16, 8}, CellType::quad4);
  double squeezed = 1;
  int changed = 0;
  for (int n = 1; n <= 20; ++n) {
    const StepRequest request{n, 0, (n - 1) * 0.02, 0.02};
    const auto before = solver->points();
    InterfaceValues sent;
    solver->solve_step(request, {}, sent);
    const Json details = solver->accept_step(request, true).details;
    const auto& after = solver->points();
    double smallest = 2;
    int moved = 0;
    for (std::int32_t p = 0; p < after.size(); ++p) {
      smallest = std::min(smallest, after.J[p] / before.J[p]);
      moved += after.cell[p] != before.cell[p];
    }
    EXPECT_NEAR(details.at("min_J_ratio").get<double>(), smallest, 1e-14);
    EXPECT_EQ(details.at("points_changed_cell"), moved);
    EXPECT_EQ(details.at("active_nodes"), nodes_in_use(grid, before));
    squeezed = std::min(squeezed, smallest);
    changed += moved;
  }
  EXPECT_LT(squeezed, 0.999);
  EXPECT_GT(changed, 100);
}

TEST(MpmStep, collision_conserves_momentum) {
  for (const auto& [type, transfer] :
       {std::pair{"quad4", "flip"}, {"tri3", "flip"}, {"quad4", "tpic"}, {"tri3", "tpic"}}) {
    const auto solver = mpm_solver<2>(collision(type, transfer));
    const double kinetic = probe(*solver, "kinetic_energy");
    // TPIC continues velocities linearly across the contact, which may add energy: by 1 % here.
    const double growth = transfer == std::string("flip") ? 0.001 : 0.02;
    double elastic = 0;
    for (int n = 1; n <= 40; ++n) {
      run_steps(*solver, 0.01, 1, n);
      elastic = std::max(elastic, probe(*solver, "elastic_energy"));
      EXPECT_LT(probe(*solver, "kinetic_energy") + probe(*solver, "elastic_energy"),
                (1 + growth) * kinetic);
    }
    EXPECT_GT(elastic, 0.1 * kinetic);  // they did meet
    EXPECT_NEAR(probe(*solver, "momentum_x"), 2 - 2, 1e-12 * 4);
    EXPECT_NEAR(probe(*solver, "momentum_y"), 0.1, 1e-12 * 4);
    const double left =
        kinetic - probe(*solver, "kinetic_energy") - probe(*solver, "elastic_energy");
    EXPECT_GT(left, 0);
    EXPECT_LT(left, 0.3 * kinetic);  // the nodes that both bodies share meet inelastically
  }
}

/// Parts that a solution leaves out must not look like a change of the interface.
TEST(MpmStep, further_coupling_iterations_are_solved_a_hundred_times_closer) {
  Json json = collision();
  json["newton"] = {{"residual_tolerance", 0.01}, {"increment_tolerance", 1}};
  const auto solver = mpm_solver<2>(json);
  int second = 0, third = 0;
  for (int n = 1; n <= 20; ++n) {
    StepRequest request{n, 0, (n - 1) * 0.02, 0.02};
    InterfaceValues sent;
    solver->solve_step(request, {}, sent);
    request.iteration = 1;
    second += solver->solve_step(request, {}, sent).newton_iterations;
    request.iteration = 2;
    third += solver->solve_step(request, {}, sent).newton_iterations;
    solver->accept_step(request, true);
  }
  EXPECT_GE(second, 5);
  EXPECT_EQ(third, 0);
}

TEST(MpmStep, two_runs_give_the_same_bits) {
  for (const char* transfer : {"flip", "tpic"}) {
    const Json json = collision("quad4", transfer);
    const auto first = mpm_solver<2>(json), second = mpm_solver<2>(json);
    run_steps(*first, 0.01, 30);
    run_steps(*second, 0.01, 30);
    EXPECT_TRUE(same_bits(first->points(), second->points()));
  }
}

TEST(MpmStep, repeated_requests_give_the_same_bits) {
  const auto solver = mpm_solver<2>(pushed());
  ASSERT_EQ(solver->interfaces().at(0).num_vertices(), 3);
  for (int n = 1; n <= 5; ++n) {
    const StepRequest first{n, 0, (n - 1) * 0.002, 0.002}, next{n, 1, first.time, first.dt};
    InterfaceValues sent[2][2];
    for (auto& answer : sent) {
      EXPECT_TRUE(solver->solve_step(first, plate_at(0.002 * n), answer[0]).interface_active);
      solver->solve_step(next, plate_at(0.003 * n), answer[1]);
    }
    EXPECT_EQ(sent[0][0], sent[1][0]);
    EXPECT_EQ(sent[0][1], sent[1][1]);
    EXPECT_NE(sent[0][0], sent[0][1]);
    EXPECT_LT(sent[0][0]["plate"][0], 0);  // the soil pushes the plate back
    solver->accept_step(next, true);
  }
}

TEST(MpmStep, rejected_steps_leave_no_trace) {
  const auto straight = mpm_solver<2>(pushed()), cut = mpm_solver<2>(pushed());
  InterfaceValues sent;
  for (int n = 1; n <= 5; ++n) {
    const auto before = cut->points();
    cut->solve_step({n, 0, (n - 1) * 0.002, 0.004}, plate_at(0.01 * n), sent);
    EXPECT_TRUE(same_bits(cut->points(), before));
    cut->reject_step();
    EXPECT_TRUE(same_bits(cut->points(), before));
    const StepRequest request{n, 0, (n - 1) * 0.002, 0.002};
    for (auto* solver : {straight.get(), cut.get()}) {
      solver->solve_step(request, plate_at(0.002 * n), sent);
      solver->accept_step(request, true);
    }
    EXPECT_TRUE(same_bits(straight->points(), cut->points())) << "step " << n;
  }
}

/// A step that fails, then the same time in two halves.
TEST(MpmStep, a_step_that_fails_may_be_repeated_with_a_smaller_one) {
  Json json = pushed();
  json["newton"] = {{"max_iterations", 5}, {"residual_tolerance", 1e-10}};
  const auto solver = mpm_solver<2>(json), careful = mpm_solver<2>(json);
  const auto before = solver->points();
  InterfaceValues sent;
  expect_error<UnbalancedError>(
      [&] {
        solver->solve_step({1, 0, 0, 0.5}, plate_at(0.3), sent);
      },
      {"iteration limit reached"});
  solver->reject_step();
  EXPECT_TRUE(same_bits(solver->points(), before));
  for (int n = 1; n <= 2; ++n) {
    const StepRequest request{n, 0, (n - 1) * 0.001, 0.001};
    for (auto* each : {solver.get(), careful.get()}) {
      each->solve_step(request, plate_at(0.0005 * n), sent);
      each->accept_step(request, true);
    }
  }
  EXPECT_TRUE(same_bits(solver->points(), careful->points()));
}

TEST(MpmStep, only_a_solved_step_is_accepted) {
  const auto solver = mpm_solver<2>(pushed());
  const auto accept = [&](double dt, bool solved) {
    expect_error<Error>(
        [&] {
          solver->accept_step({1, 0, 0, dt}, solved);
        },
        {"a step was accepted that was not solved"});
  };
  accept(0.001, true);  // none was solved
  InterfaceValues sent;
  solver->solve_step({1, 0, 0, 0.001}, plate_at(0.001), sent);
  accept(0.001, false);
  accept(0.002, true);  // another one was
  solver->accept_step({1, 0, 0, 0.001}, true);
  accept(0.001, true);  // twice
}

TEST(MpmStep, a_surface_far_from_the_soil_is_inactive) {
  Json json = pushed();
  json["interfaces"][0]["surface"] = {{"polyline", {{0.1, 0.0}, {0.1, 0.5}}}, {"spacing", 0.25}};
  const auto solver = mpm_solver<2>(json);
  InterfaceValues sent;
  EXPECT_FALSE(solver->solve_step({1, 0, 0, 0.001}, plate_at(0.1), sent).interface_active);
  EXPECT_EQ(sent.at("plate"), std::vector<double>(6, 0.0));
}

/// Soil that starts to slide down along a plate that stands still: the gap is on the verge of
/// closing.
TEST(MpmStep, grazing_contact_with_friction_converges) {
  for (const double friction : {0.0, 0.3, 1.0}) {
    Json json = pushed();
    json["interfaces"][0]["friction"] = friction;
    const auto solver = mpm_solver<2>(json);
    EXPECT_NO_THROW(run_steps(*solver, 1e-3, 20)) << friction;
  }
}

/// A free square of 1 m that spins, cut into bodies that start with the velocity of their centre.
Json spinning(double spin, int grid_cells) {
  Json bodies = Json::array();
  const int n = 2 * grid_cells / 3;
  const double half = 0.5 / n;
  for (int i = 0; i < n; ++i) {
    for (int j = 0; j < n; ++j) {
      const double x = 1 + 2 * half * i, y = 1 + 2 * half * j;
      bodies.push_back(body(std::to_string(i) + "_" + std::to_string(j),
                            box({x, y}, {x + 2 * half, y + 2 * half}, {1, 1}, "quad4"), 1,
                            elastic_soil("neo_hookean", 1e4, 0.3, 1),
                            {-spin * (y + half - 1.5), spin * (x + half - 1.5)}));
    }
  }
  return {{"dimension", 2},
          {"grid", box({0, 0}, {3, 3}, {grid_cells, grid_cells}, "quad4")},
          {"basis", "linear"},
          {"bodies", bodies},
          {"newton", {{"residual_tolerance", 1e-12}}},
          {"time_integration", trapezoid}};
}

double angular_momentum(const mpm::MaterialPoints<2>& points) {
  double sum = 0;
  for (std::int32_t p = 0; p < points.size(); ++p) {
    const Vector<2> arm = points.x[p] - Vector<2>(1.5, 1.5);
    sum += points.m[p] * (arm[0] * points.v[p][1] - arm[1] * points.v[p][0]);
  }
  return sum;
}

/// Shares of angular momentum and kinetic energy that are lost in the last of some turns, in which
/// stress must stay small and the energy must not grow.
std::pair<double, double> lost_in_a_turn(const Json& transfer, int grid_cells, int turns) {
  const double spin = 2;
  Json json = spinning(spin, grid_cells);
  json["transfer"] = transfer;
  const auto solver = mpm_solver<2>(json);
  const int steps = 100, first = (turns - 1) * steps;
  const double dt = 2 * M_PI / spin / steps;
  run_steps(*solver, dt, first);
  const double kinetic = probe(*solver, "kinetic_energy");
  const double before = angular_momentum(solver->points());
  double elastic = 0, total = 0;
  for (int k = first + 1; k <= first + steps; ++k) {
    run_steps(*solver, dt, 1, k);
    elastic = std::max(elastic, probe(*solver, "elastic_energy"));
    total = std::max(total, probe(*solver, "kinetic_energy") + probe(*solver, "elastic_energy"));
  }
  double J_error = 0;
  for (const double J : solver->points().J) J_error = std::max(J_error, std::abs(J - 1));
  EXPECT_LT(total, 1.002 * kinetic);
  EXPECT_LT(elastic, 0.01 * kinetic);
  EXPECT_LT(J_error, 1e-3);
  EXPECT_NEAR(probe(*solver, "momentum_x"), 0, 1e-12);
  EXPECT_NEAR(probe(*solver, "momentum_y"), 0, 1e-12);
  return {1 - angular_momentum(solver->points()) / before,
          1 - probe(*solver, "kinetic_energy") / kinetic};
}

/// FLIP with lumped mass loses spin, by about h^2.
TEST(MpmStep, spinning_block_stays_whole) {
  const double coarse = lost_in_a_turn({{"method", "flip"}}, 12, 1).first;
  const double fine = lost_in_a_turn({{"method", "flip"}}, 24, 1).first;
  EXPECT_GT(coarse, 0.3);
  EXPECT_LT(coarse, 0.5);
  EXPECT_LT(fine, 0.3 * coarse);
}

/// TPIC keeps it, on 2 to 8 cells a side. The first turn is not counted: bodies start with uniform
/// velocity, so that the points have to learn their gradients.
TEST(MpmStep, spinning_block_keeps_its_spin_with_tpic) {
  for (const int grid_cells : {6, 12, 24}) {
    const auto [spin, energy] = lost_in_a_turn({{"method", "tpic"}}, grid_cells, 2);
    EXPECT_LT(std::abs(spin), 3e-3) << grid_cells;
    EXPECT_LT(std::abs(energy), 6e-3) << grid_cells;
  }
}

}  // namespace
}  // namespace gabion::test::test_mpm_step
