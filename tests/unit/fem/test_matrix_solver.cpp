// SPDX-License-Identifier: BSD-3-Clause
#include "fem_solver/matrices/matrix_solver.hpp"

#include <gtest/gtest.h>

#include <Eigen/LU>
#include <cmath>

#include "fem_solver/matrices/matrix_files.hpp"
#include "tests/support/expect_error.hpp"
#include "tests/unit/fem/matrix_scene.hpp"

namespace gabion::test::test_matrix_solver {
namespace {

using Solver2 = fem::MatrixSolver<2>;

/// A clamped wall with a mesh: linear, under gravity, loaded on its left side.
Json wall(const Json& scheme) {
  return {{"dimension", 2},
          {"mesh", box_2d({0.1, 1}, {2, 8})},
          {"material", elastic("linear_elastic", 1e6, 0.3, 1000)},
          {"time_integration", scheme},
          {"gravity", {0.5, -9.81}},
          {"newton", {{"residual_tolerance", 1e-12}}},
          {"supports", {{{"group", "bottom"}}}},
          {"interfaces", {{{"name", "wall"}, {"groups", {"left"}}}}},
          {"probes", {{{"name", "A"}, {"point", {0.1, 1}}}}}};
}

const Json trapezoid = {{"scheme", "newmark"}};
const Json bossak = {{"scheme", "bossak"}, {"alpha", -0.2}};

/// Forces on `count` vertices that change from step to step.
InterfaceValues push(int count, int step) {
  std::vector<double> f(2 * count);
  for (int i = 0; i < count; ++i) f[2 * i] = std::sin(0.7 * step + i), f[2 * i + 1] = 0.1 * i;
  return {{"wall", f}};
}

/// Surface after each of some steps under such forces, with one larger dt among them.
std::vector<double> answers(Solver& solver, ForceKind kind) {
  solver.set_force_kinds({{"wall", kind}});
  const int count = static_cast<int>(solver.interfaces()[0].num_vertices());
  std::vector<double> result;
  double time = 0;
  for (int n = 1; n <= 12; ++n) {
    const StepRequest request{n, 0, time, n == 5 ? 4e-3 : 2e-3};
    InterfaceValues sent;
    solver.solve_step(request, push(count, n), sent);
    const auto probes = solver.accept_step(request, true).probes;
    result.insert(result.end(), sent.at("wall").begin(), sent.at("wall").end());
    result.insert(result.end(), probes.begin(), probes.begin() + 5);
    time += request.dt;
  }
  return result;
}

double largest_difference(const std::vector<double>& x, const std::vector<double>& y) {
  EXPECT_EQ(x.size(), y.size());
  double difference = 0, largest = 0;
  for (std::size_t i = 0; i < x.size(); ++i) {
    difference = std::max(difference, std::abs(x[i] - y[i]));
    largest = std::max(largest, std::abs(x[i]));
  }
  return difference / largest;
}

TEST(MatrixSolver, moves_as_the_mesh_that_the_matrices_are_from) {
  for (const Json& scheme : {trapezoid, bossak}) {
    for (const bool equilibrium : {false, true}) {
      for (const ForceKind kind : {ForceKind::end_of_step, ForceKind::step_mean}) {
        Json json = wall(scheme);
        json["initial_equilibrium"] = equilibrium;
        const MatrixScene scene = MatrixScene::of<2>(json);
        EXPECT_LT(largest_difference(answers(*fem_solver<2>(json), kind),
                                     answers(*scene.solver<2>(), kind)),
                  1e-10)
            << scheme << equilibrium;
      }
    }
  }
}

TEST(MatrixSolver, static_answer_is_that_of_the_mesh) {
  Json json = wall(trapezoid);
  json.erase("time_integration");
  json["analysis"] = "static";
  MatrixScene scene = MatrixScene::of<2>(json);
  EXPECT_LT(largest_difference(answers(*fem_solver<2>(json), ForceKind::end_of_step),
                               answers(*scene.solver<2>(), ForceKind::end_of_step)),
            1e-10);
  const auto with_mass = answers(*scene.solver<2>(), ForceKind::end_of_step);
  scene.json["matrices"].erase("mass");
  EXPECT_EQ(answers(*scene.solver<2>(), ForceKind::end_of_step), with_mass);
}

TEST(MatrixSolver, a_repeated_request_gives_the_same_bits) {
  MatrixScene scene = MatrixScene::of<2>(wall(bossak));
  for (const bool reduced : {false, true}) {
    if (reduced) scene.json["matrices"]["modes"] = 5;
    const auto solver = scene.solver<2>();
    const int count = static_cast<int>(solver->interfaces()[0].num_vertices());
    run_steps(*solver, 1e-3, 2);
    const auto solve = [&](double dt, int load) {
      InterfaceValues sent;
      solver->solve_step({3, 0, 2e-3, dt}, push(count, load), sent);
      return sent;
    };
    const auto first = solve(1e-3, 1);
    EXPECT_EQ(solve(1e-3, 1), first);
    EXPECT_NE(solve(1e-3, 2), first);
    for (int cut = 1; cut <= 8; ++cut) solve(1e-3 / (1 << cut), 1);  // more than factors are kept
    solver->reject_step();
    EXPECT_EQ(solve(1e-3, 1), first);
  }
}

TEST(MatrixSolver, few_sizes_of_the_step_cost_a_factor_each) {
  const auto solver = two_masses().solver<2>();
  double time = 0;
  for (int n = 1; n <= 30; ++n) {
    const StepRequest request{n, 0, time, n % 3 == 0 ? 0.1 : 0.05};
    for (int iteration = 0; iteration < 3; ++iteration) {
      InterfaceValues sent;
      solver->solve_step(request, {{"wall", {1.0 + iteration, 0, 0, 0}}}, sent);
    }
    solver->accept_step(request, true);
    time += request.dt;
  }
  EXPECT_EQ(solver->summary()["factorisations"], 2);
  EXPECT_EQ(solver->summary()["solves"], 90);
}

TEST(MatrixSolver, goes_on_from_a_saved_state_with_the_same_bits) {
  MatrixScene scene = MatrixScene::of<2>(wall(bossak));
  for (const bool reduced : {false, true}) {
    if (reduced) scene.json["matrices"]["modes"] = 5;
    const auto first = scene.solver<2>(), second = scene.solver<2>();
    answers(*first, ForceKind::step_mean);
    second->set_force_kinds({{"wall", ForceKind::step_mean}});
    second->load_state(first->save_state());
    InterfaceValues one, other;
    const StepRequest request{13, 0, 26e-3, 2e-3};
    const auto forces = push(static_cast<int>(first->interfaces()[0].num_vertices()), 13);
    first->solve_step(request, forces, one);
    second->solve_step(request, forces, other);
    EXPECT_EQ(one, other);
    EXPECT_EQ(first->accept_step(request, true).probes, second->accept_step(request, true).probes);
  }
  const State saved = scene.solver<2>()->save_state();
  scene.json["matrices"]["rayleigh"] = {{"mass", 1}};
  expect_error<ConfigError>([&] { scene.solver<2>()->load_state(saved); },
                            {"/matrices", "other matrices"});
}

TEST(MatrixSolver, is_at_rest_until_something_acts) {
  const auto solver = two_masses().solver<2>();
  InterfaceValues sent;
  const InterfaceValues none = {{"wall", {0, 0, 0, 0}}};
  EXPECT_EQ(solver->solve_step({1, 0, 0, 0.1}, none, sent).details["skipped"], 1);
  EXPECT_TRUE(solver->accept_step({1, 0, 0, 0.1}, true).at_rest);
  EXPECT_EQ(solver->solve_step({2, 0, 0.1, 0.1}, {{"wall", {0, 0, 1, 0}}}, sent).details["skipped"],
            0);
  EXPECT_FALSE(solver->accept_step({2, 0, 0.1, 0.1}, true).at_rest);
}

/// Springs in series: 30 = 20 + 10, node 2 hangs on the second one.
TEST(MatrixSolver, held_unknowns_and_loads) {
  MatrixScene scene = two_masses();
  scene.json["analysis"] = "static";
  scene.json["matrices"].erase("mass");
  InterfaceValues sent;
  const InterfaceValues none = {{"wall", {0, 0, 0, 0}}};
  // vertices in the order of nodes.csv: node 1, node 2; what acts across x finds no unknown
  scene.solver<2>()->solve_step({1, 0, 0, 1}, {{"wall", {0, 0, 3, 7}}}, sent);
  EXPECT_NEAR(sent.at("wall")[0], 3.0 / 20, 1e-15);
  EXPECT_NEAR(sent.at("wall")[2], 3.0 / 20 + 3.0 / 10, 1e-15);
  EXPECT_EQ(sent.at("wall")[3], 0);

  scene.write("held.csv", "1\n3\n2,2\n");
  scene.write("load.mtx", "%%MatrixMarket matrix array real general\n2 1\n5\n1\n");
  scene.json["matrices"]["load"] = "load.mtx";
  scene.solver<2>()->solve_step({1, 0, 0, 1}, none, sent);
  EXPECT_EQ(sent.at("wall")[0], 0);
  EXPECT_NEAR(sent.at("wall")[2], 0.1, 1e-15);
}

/// Kinetic and elastic energy change by what forces work and damping takes.
TEST(MatrixSolver, energy_with_damping_and_both_kinds_of_forces) {
  MatrixScene scene = MatrixScene::of<2>(wall(trapezoid));
  scene.json["matrices"]["rayleigh"] = {{"mass", 20}, {"stiffness", 1e-4}};
  for (const bool reduced : {false, true}) {
    if (reduced) scene.json["matrices"]["modes"] = 3;
    for (const ForceKind kind : {ForceKind::end_of_step, ForceKind::step_mean}) {
      const auto solver = scene.solver<2>();
      answers(*solver, kind);
      const double work = probe(*solver, "external_work"), lost = probe(*solver, "damping_work");
      EXPECT_GT(lost, 0.01 * work);
      EXPECT_NEAR(probe(*solver, "kinetic_energy") + probe(*solver, "elastic_energy"), work - lost,
                  1e-10 * work);
    }
  }
}

/// (T8), (T13) of docs/theory/structure.md: the mean force F is part of the acceleration from the
/// start of the step on, its change as far as N^-1 lets it, and all others balance with the
/// velocity at the end that the displacements have.
TEST(MatrixSolver, balance_with_damping_and_mean_forces) {
  MatrixScene scene = two_masses();
  scene.json["time_integration"] = {{"scheme", "bossak"}, {"alpha", -0.3}};
  scene.json["matrices"]["rayleigh"] = {{"mass", 0.3}, {"stiffness", 0.02}};
  const auto solver = scene.solver<2>();
  solver->set_force_kinds({{"wall", ForceKind::step_mean}});
  const fem::LinearModel& model = solver->structure().model;
  const double dt = 0.2, gamma = 0.8, beta = 0.25 * 1.3 * 1.3, share = 0.3 * (gamma + 0.045);
  const Eigen::Matrix2d N = model.M + share * (dt * dt * model.K + gamma / beta * dt * model.C);
  Eigen::Vector2d F_o = Eigen::Vector2d::Zero();
  for (int n = 1; n <= 10; ++n) {
    const Eigen::VectorXd a = solver->state().a;
    const Eigen::Vector2d F(std::sin(n), 3.0 / n);
    const StepRequest request{n, 0, (n - 1) * dt, dt};
    InterfaceValues sent;
    solver->solve_step(request, {{"wall", {F[0], 0, F[1], 0}}}, sent);
    solver->accept_step(request, true);
    const fem::LinearState& end = solver->state();
    const Eigen::Vector2d y = N.inverse() * (F - F_o);
    const Eigen::VectorXd residual = model.M * (1.3 * end.a - 0.3 * a) - F - 0.3 * model.M * y +
                                     model.C * end.v_u + model.K * end.u;
    EXPECT_LT(residual.norm(), 1e-12 * F.norm());
    F_o = F;
  }
}

TEST(MatrixSolver, ignores_no_mistake) {
  const auto refused = [](const std::function<void(MatrixScene&)>& spoil,
                          const std::vector<std::string_view>& parts) {
    MatrixScene scene = two_masses();
    spoil(scene);
    expect_error<ConfigError>([&] { scene.solver<2>(); }, parts);
  };
  const auto set = [](const char* key, const Json& value) {
    return [=](MatrixScene& s) { s.json["matrices"][key] = value; };
  };
  const auto file = [](const char* name, const char* text) {
    return [=](MatrixScene& s) { s.write(name, text); };
  };
  const std::string head = "%%MatrixMarket matrix coordinate real symmetric\n";
  const std::string negative = head + "2 2 2\n1 1 2\n2 2 -1\n", large = head + "3 3 1\n1 1 2\n";
  refused(file("M.mtx", negative.c_str()),
          {"/matrices", "mass", "not positive", "node 2, direction 1"});
  refused(file("M.mtx", large.c_str()), {"M.mtx", "3 rows, allowed: 2", "unknowns.csv"});
  refused(file("wall.csv", "2 4\n"), {"wall.csv:1", "found node 4", "coordinates"});
  refused(file("wall.csv", "2 1 3 1\n"), {"wall.csv:1", "4 nodes, allowed: 2 or 3"});
  refused(file("wall.csv", "2 1\n2 1\n"), {"/interfaces/0/facets", "facet 2 a second time"});
  refused(file("nodes.csv", "1,0,0\n1,1,0\n"), {"nodes.csv:2", "node 1 a second time"});
  refused(file("nodes.csv", "1,0\n"), {"nodes.csv:1", "2 numbers", "3 (node, x, y)"});
  refused(
      [](MatrixScene& s) {
        s.write("unknowns.csv", "7,1\n8,1\n");
        s.write("held.csv", "1\n2\n3\n");
      },
      {"/interfaces/0/facets", "no node that has an unknown"});
  refused(set("mesh", "a"), {"/matrices/mesh", "unknown"});
  refused(set("modes", 1), {"/matrices/modes", "1 modes, allowed: at most 0"});
  refused(
      [](MatrixScene& s) {
        s.json["gravity"] = {0, -9.81};
      },
      {"/gravity", "beside \"matrices\""});
  refused([](MatrixScene& s) { s.json["matrices"].erase("mass"); }, {"/matrices/mass", "dynamic"});
  refused(
      [](MatrixScene& s) {
        s.json["interfaces"][0] = {{"name", "wall"}, {"groups", {"left"}}};
      },
      {"/interfaces/0/facets", "missing"});
  refused(
      [](MatrixScene& s) {
        s.json["probes"][0]["point"] = {2, 1};
      },
      {"/probes/0/point", "no node"});
  refused(
      [](MatrixScene& s) {
        s.json["matrices"]["rayleigh"] = Json::object();
        s.json["matrices"]["damping"] = "K.mtx";
      },
      {"/matrices/rayleigh", "either"});
  refused(
      [&](MatrixScene& s) {
        s.json["analysis"] = "static";
        s.write("K.mtx", head + "2 2 3\n1 1 10\n2 1 -10\n2 2 10\n");
      },
      {"/matrices", "stiffness", "not positive definite"});
  refused(file("held.csv", "1,2\n2,2\n3\n4\n"), {"held.csv", "found node 4", "coordinates"});
  refused(file("held.csv", "1,2\n3\n"), {"/matrices", "node 2, direction 2", "no row", "\"held\""});
  refused(file("held.csv", "1,2,3\n"), {"held.csv:1", "3 numbers, allowed: 1 or 2"});
  refused(file("held.csv", "1\n2\n3\n"), {"unknowns.csv", "no free unknown"});
}

/// An Euler-Bernoulli beam clamped at node 1: deflection F L^3 / (3 E I) at node 2, whose rotation
/// (direction 6) is an unknown that no surface reaches.
TEST(MatrixSolver, rotations_are_unknowns_too) {
  const double EI = 7, L = 2;
  MatrixScene scene = two_masses();
  const Eigen::Matrix2d K{{12 * EI / (L * L * L), -6 * EI / (L * L)},
                          {-6 * EI / (L * L), 4 * EI / L}};
  fem::write_symmetric_matrix(scene.path("K.mtx"), fem::SparseMatrix(K.sparseView()));
  scene.write("unknowns.csv", "2,2\n2,6\n");
  scene.write("held.csv", "1\n3\n2,1\n");
  scene.json["analysis"] = "static";
  scene.json["matrices"]["modes"] = 0;
  for (const bool reduced : {true, false}) {
    if (!reduced) scene.json["matrices"].erase("modes");
    InterfaceValues sent;
    scene.solver<2>()->solve_step({1, 0, 0, 1}, {{"wall", {0, 0, 0, 3}}}, sent);
    EXPECT_NEAR(sent.at("wall")[3], 3 * L * L * L / (3 * EI), 1e-14);
  }
}

TEST(MatrixSolver, what_moves_by_itself_is_not_written_as_matrices) {
  Json json = wall(trapezoid);
  json["prescribed"] = {{{"group", "top"}, {"component", "x"}, {"rate", 1}}};
  expect_error<ConfigError>([&] { MatrixScene::of<2>(json); }, {"--write-matrices", "prescribed"});
}

}  // namespace
}  // namespace gabion::test::test_matrix_solver
