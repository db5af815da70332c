// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include <cmath>
#include <filesystem>
#include <functional>

#include "common/base/unbalanced.hpp"
#include "common/hdf5/hdf5_reader.hpp"
#include "solver_program/ranked_state.hpp"
#include "solver_program/ranked_state_file.hpp"
#include "tests/support/expect_error.hpp"
#include "tests/unit/fem/plate.hpp"

namespace gabion::test::test_fem_ranks {
namespace {

void expect_equal_on_ranks(ForceKind kind) {
  const auto shared = fem_solver<2>(plate());
  const auto alone = fem_solver<2>(plate(), MPI_COMM_SELF);
  shared->set_force_kinds({{"wall", kind}});
  alone->set_force_kinds({{"wall", kind}});
  const auto load = push(*shared, 5);
  InterfaceValues shared_sent, alone_sent;
  for (int n = 1; n <= 5; ++n) {
    const StepRequest request{n, 0, (n - 1) * 0.02, 0.02};
    shared->solve_step(request, load, shared_sent);
    alone->solve_step(request, load, alone_sent);
    const auto shared_probes = shared->accept_step(request, true).probes;
    const auto alone_probes = alone->accept_step(request, true).probes;
    for (std::size_t i = 0; i < alone_probes.size(); ++i) {
      EXPECT_NEAR(shared_probes[i], alone_probes[i], 1e-10 * (1 + std::abs(alone_probes[i])));
    }
  }
  double largest = 0;
  for (const double u : alone_sent.at("wall")) largest = std::max(largest, std::abs(u));
  ASSERT_GT(largest, 1e-3);
  for (std::size_t i = 0; i < alone_sent.at("wall").size(); ++i) {
    EXPECT_NEAR(shared_sent.at("wall")[i], alone_sent.at("wall")[i], 1e-10 * largest);
  }
}

TEST(FemRanks, ranks_agree_with_one_rank) {
  expect_equal_on_ranks(ForceKind::end_of_step);
  expect_equal_on_ranks(ForceKind::step_mean);
}

/// A wall in space with loads of each kind, which moves: probes, surfaces and frames.
Json wall() {
  Json json = {
      {"dimension", 3},
      {"mesh", box_3d({0.4, 0.1, 1}, {4, 2, 6})},
      {"material", elastic("neo_hookean", 1e5, 0.3, density)},
      {"gravity", {0, 0, -g}},
      {"initial_equilibrium", true},
      {"supports", {{{"group", "bottom"}, {"components", {"x", "z"}}, {"report_reaction", true}}}},
      {"prescribed", {{{"group", "right"}, {"component", "y"}, {"rate", 0.05}}}},
      {"tractions", {{{"group", "front"}, {"traction", {0.0, 20.0, 0.0}}}}},
      {"interfaces", {{{"name", "wall"}, {"groups", {"front", "top"}}}}}};
  json["loads"] = {{{"point", {0.0, 0.0, 1.0}}, {"force", {1.0, 2.0, 0.0}}},
                   {{"group", "left"}, {"force", {3.0, 0.0, 0.0}}}};
  json["probes"] = {{{"name", "A"}, {"point", {0.1, 0.05, 1.0}}},
                    {{"name", "B"}, {"point", {0.23, 0.02, 0.61}}}};
  return json;
}

InterfaceValues load_on(const Solver& solver, int n) {
  InterfaceValues values;
  for (const InterfaceMesh& mesh : solver.interfaces()) {
    auto& of_mesh = values[mesh.name];
    for (std::size_t k = 0; k < mesh.coordinates.size(); ++k) {
      of_mesh.push_back(0.3 * std::sin(0.7 * static_cast<double>(k) + n));
    }
  }
  return values;
}

/// Steps first .. last, each with two solutions. @returns the last displacements of the surfaces
InterfaceValues run_loaded(Solver& solver, int first, int last) {
  InterfaceValues sent;
  for (int n = first; n <= last; ++n) {
    for (int k = 0; k < 2; ++k) {
      solver.solve_step({n, k, (n - 1) * 0.01, 0.01}, load_on(solver, n + k), sent);
    }
    solver.accept_step({n, 1, (n - 1) * 0.01, 0.01}, true);
  }
  return sent;
}

void expect_near(const std::vector<double>& found, const std::vector<double>& expected,
                 double tolerance) {
  ASSERT_EQ(found.size(), expected.size());
  for (std::size_t i = 0; i < found.size(); ++i) {
    EXPECT_NEAR(found[i], expected[i], tolerance * (1 + std::abs(expected[i]))) << i;
  }
}

TEST(FemRanks, a_loaded_wall_moves_as_on_one_rank) {
  for (const std::string method : {"mumps", "cg"}) {
    Json json = wall();
    json["linear_solver"] = {{"method", method}, {"tolerance", 1e-13}};
    const auto shared = fem_solver<3>(json), alone = fem_solver<3>(json, MPI_COMM_SELF);
    const auto a = shared->interfaces().at(0), b = alone->interfaces().at(0);
    EXPECT_EQ(a.coordinates, b.coordinates);
    EXPECT_EQ(a.facets, b.facets);
    for (auto* solver : {shared.get(), alone.get()}) {
      solver->set_force_kinds({{"wall", ForceKind::step_mean}});
    }
    const auto found = run_loaded(*shared, 1, 4), expected = run_loaded(*alone, 1, 4);
    expect_near(found.at("wall"), expected.at("wall"), 1e-9);
    expect_near(shared->probes(), alone->probes(), 1e-7);
    EXPECT_GT(std::abs(probe(*shared, "B.uy")), 1e-5);
    for (const char* key : {"nodes", "unknowns", "cells", "frame_bytes", "solves"}) {
      EXPECT_EQ(shared->summary().at(key), alone->summary().at(key)) << key;
    }
  }
}

TEST(FemRanks, multigrid_takes_as_many_iterations_as_on_one_rank) {
  Json json = wall();
  json["mesh"] = box_3d({0.8, 0.8, 1.6}, {8, 8, 16});
  json["probes"] = Json::array();
  json["loads"] = Json::array();
  json["linear_solver"] = {{"method", "cg"}, {"preconditioner", "multigrid"}};
  InterfaceValues sent;
  std::vector<std::int64_t> iterations;
  for (MPI_Comm on : {comm(), MPI_COMM_SELF}) {
    const auto solver = fem_solver<3>(json, on);
    const auto report = solver->solve_step({1, 0, 0, 0.01}, load_on(*solver, 1), sent);
    iterations.push_back(report.linear_iterations);
  }
  EXPECT_NEAR(static_cast<double>(iterations[0]), static_cast<double>(iterations[1]),
              0.3 * static_cast<double>(iterations[1]));
}

/// Fewer cells than ranks: some have nothing.
TEST(FemRanks, ranks_without_cells_take_part) {
  for (const std::string method : {"mumps", "cg"}) {
    Json json = wall();
    json["mesh"] = box_3d({0.4, 0.1, 1}, {1, 1, 2});
    json["linear_solver"] = {{"method", method}, {"tolerance", 1e-13}};
    json["probes"] = Json::array({{{"name", "A"}, {"point", {0.1, 0.05, 0.9}}}});
    const auto shared = fem_solver<3>(json), alone = fem_solver<3>(json, MPI_COMM_SELF);
    const auto found = run_loaded(*shared, 1, 3), expected = run_loaded(*alone, 1, 3);
    expect_near(found.at("wall"), expected.at("wall"), 1e-9);
    expect_near(shared->probes(), alone->probes(), 1e-7);
  }
}

TEST(FemRanks, frames_are_those_of_one_rank) {
  const std::filesystem::path folder = testing::TempDir() + "gabion_frames_of_fem_ranks";
  if (rank() == 0) std::filesystem::remove_all(folder);
  MPI_Barrier(comm());
  const auto shared = fem_solver<3>(wall(), comm(), folder / "shared");
  run_loaded(*shared, 1, 2);
  shared->write_output(0.02);
  if (rank() != 0) return;
  const auto alone = fem_solver<3>(wall(), MPI_COMM_SELF, folder / "alone");
  run_loaded(*alone, 1, 2);
  alone->write_output(0.02);
  const Hdf5Reader a(folder / "alone" / "structure_000000.h5"),
      b(folder / "shared" / "structure_000000.h5");
  EXPECT_EQ(b.integers("connectivity"), a.integers("connectivity"));
  EXPECT_EQ(b.names("point"), a.names("point"));
  EXPECT_EQ(b.names("cell"), a.names("cell"));
  for (const char* name : {"coordinates", "point/displacement", "point/velocity",
                           "point/external_force", "cell/stress"}) {
    SCOPED_TRACE(name);
    expect_near(b.reals(name), a.reals(name), 1e-5);
  }
  std::filesystem::remove_all(folder);
}

/// Half a run on some ranks, a file, and the rest on others.
void expect_same_run(const Json& json, Solver& straight, int before, int after) {
  SCOPED_TRACE(std::to_string(before) + " -> " + std::to_string(after));
  const std::string path = testing::TempDir() + "gabion_fem_restart_on_ranks.h5";
  const auto on_first = [](int number, const std::function<void(MPI_Comm)>& work) {
    MPI_Comm some = MPI_COMM_NULL;
    MPI_Comm_split(comm(), rank() < number ? 0 : MPI_UNDEFINED, rank(), &some);
    if (some != MPI_COMM_NULL) {
      work(some);
      MPI_Comm_free(&some);
    }
    MPI_Barrier(comm());
  };
  on_first(before, [&](MPI_Comm some) {
    const auto solver = fem_solver<3>(json, some);
    run_loaded(*solver, 1, 3);
    write_ranked_state(some, path, solver->save_state());
  });
  on_first(after, [&](MPI_Comm some) {
    const auto solver = fem_solver<3>(json, some);
    load_ranked_state(some, path, *solver);
    run_loaded(*solver, 4, 6);
    expect_near(solver->probes(), straight.probes(), 1e-7);
  });
}

TEST(FemRanks, restart_on_another_number_of_ranks) {
  const Json json = wall();
  const auto straight = fem_solver<3>(json, MPI_COMM_SELF);
  run_loaded(*straight, 1, 6);
  for (const auto& [before, after] :
       {std::pair(1, size()), {size(), 1}, {size(), size()}, {std::max(1, size() - 1), size()}}) {
    expect_same_run(json, *straight, before, after);
  }
}

/// On several ranks MUMPS adds in the order of messages, so the steps are solved by iterations.
TEST(FemRanks, restart_gives_the_same_bits) {
  Json json = wall();
  json["linear_solver"] = {{"method", "cg"}, {"preconditioner", "jacobi"}};
  const auto straight = fem_solver<3>(json), first = fem_solver<3>(json),
             second = fem_solver<3>(json);
  const auto expected = run_loaded(*straight, 1, 6);
  run_loaded(*first, 1, 3);
  load_gathered(comm(), gather_state(comm(), first->save_state()), *second);
  EXPECT_EQ(second->save_state().reals, first->save_state().reals);
  EXPECT_EQ(run_loaded(*second, 4, 6), expected);
}

/// The wall of a material that yields under its loads, with enhanced cells.
Json yielding_wall() {
  Json json = wall();
  json["material"] = elastic("von_mises", 1e5, 0.3, density);
  json["material"]["yield_stress"] = 300;
  json["material"]["hardening_modulus"] = 1e4;
  json["gravity"] = {0, 0, 0};
  json["initial_equilibrium"] = false;
  json["material"]["formulation"] = "enhanced";
  json["linear_solver"] = {{"method", "cg"}, {"preconditioner", "jacobi"}, {"tolerance", 1e-12}};
  return json;
}

TEST(FemRanks, a_wall_that_yields_goes_on_on_another_number_of_ranks) {
  const Json json = yielding_wall();
  const auto straight = fem_solver<3>(json, MPI_COMM_SELF);
  run_loaded(*straight, 1, 6);
  EXPECT_GT(probe(*straight, "plastic_strain"), 1e-4);
  for (const auto& [before, after] : {std::pair(1, size()), {size(), 1}, {size(), size()}}) {
    expect_same_run(json, *straight, before, after);
  }
}

TEST(FemRanks, restart_of_a_wall_that_yields_gives_the_same_bits) {
  const Json json = yielding_wall();
  const auto first = fem_solver<3>(json), second = fem_solver<3>(json);
  run_loaded(*first, 1, 3);
  load_gathered(comm(), gather_state(comm(), first->save_state()), *second);
  EXPECT_EQ(second->save_state().reals, first->save_state().reals);
  EXPECT_EQ(run_loaded(*second, 4, 6), run_loaded(*first, 4, 6));
}

TEST(FemRanks, a_state_of_another_mesh_is_refused) {
  Json other = wall();
  other["mesh"] = box_3d({0.4, 0.1, 1}, {4, 2, 7});
  const auto saved = fem_solver<3>(wall())->save_state();
  const auto solver = fem_solver<3>(other);
  expect_error<Error>([&] { solver->load_state(saved); },
                      {"saved state: nodes: found a number 0 times"});
}

TEST(FemRanks, failure_leaves_the_accepted_state) {
  const auto solver = fem_solver<2>(plate());
  const State before = solver->save_state();
  InterfaceValues sent;
  auto broken = push(*solver, 1);
  broken["wall"][3] = std::nan("");
  expect_error<UnbalancedError>(
      [&] {
        solver->solve_step({1, 0, 0, 0.01}, broken, sent);
      },
      {"guess is inadmissible", "force not finite at node"});
  const State after = solver->save_state();
  EXPECT_EQ(after.reals, before.reals);
  EXPECT_EQ(after.integers, before.integers);
  EXPECT_EQ(after.facts, before.facts);
  expect_error<Error>(
      [&] {
        solver->accept_step({1, 0, 0, 0.01}, true);
      },
      {"step 1: accepted without a solution"});
}

}  // namespace
}  // namespace gabion::test::test_fem_ranks
