// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include "fem_solver/step/equilibrium.hpp"
#include "fem_solver/step/kept_factor.hpp"
#include "tests/unit/fem/fem_scene.hpp"

namespace gabion::test::test_multigrid {
namespace {

using fem::FemSettings;

Json box(std::vector<double> high, std::vector<int> cells) {
  return {{"dimension", 3},
          {"mesh", box_3d(std::move(high), std::move(cells))},
          {"material", elastic("neo_hookean", 30e9, 0.2, 2400)},
          {"supports", {{{"group", "bottom"}}}}};
}

/// A cantilever 1 x 1 x 4 m with n cells across, held at its foot.
FemSettings<3> cantilever(int n) {
  return fem_settings<3>(box({1, 1, 4}, {n, n, 4 * n}), comm());
}

/// The static tangent of a structure at rest and a solver for it.
struct Beam {
  explicit Beam(const FemSettings<3>& given, const LinearSolverSettings& linear)
      : settings(given),
        conditions(settings),
        equilibrium(settings, conditions, comm()),
        solver(comm(), 3, linear) {
    equilibrium.set_pattern(K);
    for (const auto& node : settings.mesh.nodes) x.insert(x.end(), node.begin(), node.end());
    assemble(0);
  }
  /// Assemble with all nodes sheared sideways by that much a metre of height; with dt [s] the
  /// inertia of such a step too.
  void assemble(double shear, double dt = 0) {
    std::vector<double> at(x.size(), 0.0);
    for (std::size_t i = 0; i < at.size(); i += 3) at[i] = shear * x[i + 2];
    equilibrium.assemble_tangent(at, dt, dt > 0, K);
    solver.set_matrix(K, equilibrium.shared());
  }
  /// Bend it by the same force on every free node. @returns iterations
  int bend() {
    std::vector<double> b(x.size(), 0.0);
    for (std::size_t i = 0; i < b.size(); i += 3) b[i] = x[i + 2] > 0 ? 1.0 : 0.0;
    u.assign(b.size(), 0.0);
    return solver.solve(b, u);
  }

  std::vector<double> own_x() const { return settings.ranks.owned(x, 3); }

  FemSettings<3> settings;
  fem::BoundaryConditions<3> conditions;
  fem::Equilibrium<3> equilibrium;
  LinearSolver<3> solver;
  BlockMatrix<3> K;
  std::vector<double> x, u;
};

LinearSolverSettings multigrid(double tolerance = 1e-10) {
  return {.method = "cg", .preconditioner = "multigrid", .tolerance = tolerance};
}

TEST(Multigrid, solves_a_beam_in_iterations_that_do_not_grow_with_its_size) {
  std::vector<int> iterations;
  for (const int n : {4, 8}) {
    Beam beam(cantilever(n), multigrid());
    beam.solver.set_coordinates(beam.own_x());
    iterations.push_back(beam.bend());
    Beam direct(cantilever(n), {.method = "mumps"});
    direct.bend();
    double error = 0, size = 0;
    for (std::size_t i = 0; i < beam.u.size(); ++i) {
      error = std::max(error, std::abs(beam.u[i] - direct.u[i]));
      size = std::max(size, std::abs(direct.u[i]));
    }
    EXPECT_LT(error, 1e-7 * size);
    EXPECT_EQ(beam.solver.fallbacks(), 0);
  }
  EXPECT_LT(iterations[0], 30);
  EXPECT_LT(iterations[1], 1.5 * iterations[0]);
}

TEST(Multigrid, needs_the_rigid_motions) {
  Beam with(cantilever(6), multigrid()), without(cantilever(6), multigrid());
  with.solver.set_coordinates(with.own_x());
  EXPECT_GT(without.bend(), 1.5 * with.bend());
}

TEST(Multigrid, same_bits_again) {
  Beam first(cantilever(5), multigrid()), second(cantilever(5), multigrid());
  for (Beam* beam : {&first, &second}) {
    beam->solver.set_coordinates(beam->own_x());
    beam->bend();
  }
  EXPECT_EQ(first.u, second.u);
}

TEST(Multigrid, stays_for_neighbouring_matrices_of_a_step) {
  Beam beam(cantilever(6), multigrid());
  beam.solver.set_coordinates(beam.own_x());
  const int fresh = beam.bend();
  beam.assemble(1e-3);
  EXPECT_LE(beam.bend(), fresh + 2);
  EXPECT_EQ(beam.solver.factorisations(), 1);
  beam.solver.begin_step({});
  EXPECT_LE(beam.bend(), fresh + 2);
  EXPECT_EQ(beam.solver.factorisations(), 2);
  beam.bend();
  EXPECT_EQ(beam.solver.factorisations(), 2);
}

TEST(Multigrid, goes_when_iterations_grow) {
  Beam beam(cantilever(6), multigrid());
  beam.solver.set_coordinates(beam.own_x());
  beam.bend();
  const double dt = 6.0 / 6 / beam.equilibrium.wave_speed();  // of a wave through 6 cells
  beam.assemble(0, dt);
  const int old = beam.bend();
  EXPECT_EQ(beam.solver.factorisations(), 1);
  beam.assemble(0, dt);
  EXPECT_LT(beam.bend(), old);
  EXPECT_EQ(beam.solver.factorisations(), 2);
  beam.assemble(0, dt);
  beam.bend();
  EXPECT_EQ(beam.solver.factorisations(), 2);
  EXPECT_EQ(beam.solver.fallbacks(), 0);
}

TEST(Multigrid, has_other_levels_for_other_values) {
  Beam beam(cantilever(8), multigrid());
  beam.solver.set_coordinates(beam.own_x());
  beam.bend();
  for (const double cells : {0.1, 3.0, 100.0}) {
    beam.solver.begin_step({});
    beam.assemble(0, cells / 8 / beam.equilibrium.wave_speed());
    EXPECT_LT(beam.bend(), 40) << cells;
  }
  EXPECT_EQ(beam.solver.factorisations(), 4);
}

TEST(KeptFactor, front_is_as_wide_as_known) {
  // Bricks reach neighbours over corners: from the corner of a cube of n^3 nodes the last front is
  // three faces; in a bar it is a cross section, the first front all else of the first brick.
  EXPECT_EQ(fem::front_width(fem_settings<3>(box({1, 1, 4}, {1, 1, 4})).mesh), 7);
  EXPECT_EQ(fem::front_width(fem_settings<3>(box({5, 5, 5}, {5, 5, 5})).mesh), 3 * 36 - 3 * 6 + 1);
  EXPECT_EQ(fem::front_width(fem_settings<3>(box({9, 1, 9}, {9, 1, 9})).mesh), 2 * 19);
}

TEST(KeptFactor, thin_walls_are_direct_and_large_blocks_are_not) {
  const auto method = [](std::vector<int> cells, bool dynamic) {
    const std::vector<double> size{1.0 * cells[0], 1.0 * cells[1], 1.0 * cells[2]};
    return fem::with_kept_factor<3>({}, fem_settings<3>(box(size, cells)).mesh, {}, dynamic).method;
  };
  for (const bool dynamic : {false, true}) {
    EXPECT_EQ(method({120, 2, 120}, dynamic), "mumps");  // 131,769 unknowns
    EXPECT_EQ(method({16, 16, 16}, dynamic), "mumps");   // 14,739
    EXPECT_EQ(method({32, 32, 32}, dynamic), "auto");    // 107,811
    EXPECT_EQ(method({5, 5, 5}, dynamic), "lu");
  }
  EXPECT_EQ(method({22, 22, 22}, true), "mumps");  // 36,501
  EXPECT_EQ(method({22, 22, 22}, false), "auto");
}

TEST(KeptFactor, walls_and_bars_are_slender) {
  const auto slender = [](std::vector<int> cells) {
    const std::vector<double> size{1.0 * cells[0], 1.0 * cells[1], 1.0 * cells[2]};
    return fem::is_slender(fem_settings<3>(box(size, cells)).mesh);
  };
  EXPECT_TRUE(slender({40, 4, 40}));
  EXPECT_TRUE(slender({4, 4, 20}));
  EXPECT_FALSE(slender({12, 12, 12}));
  EXPECT_FALSE(slender({20, 10, 20}));
}

TEST(KeptFactor, asked_for_is_kept) {
  const auto mesh = fem_settings<3>(box({1, 1, 4}, {1, 1, 4})).mesh;
  EXPECT_EQ(fem::with_kept_factor<3>({.method = "cg"}, mesh, {}, true).method, "cg");
  EXPECT_EQ(fem::with_kept_factor<3>({.preconditioner = "multigrid"}, mesh, {}, true).method,
            "auto");
}

}  // namespace
}  // namespace gabion::test::test_multigrid
