// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include <limits>

#include "common/mechanics/petsc/eigenvalue_signs.hpp"
#include "common/mechanics/petsc/linear_solver.hpp"
#include "common/mechanics/petsc/petsc_session.hpp"
#include "tests/support/expect_error.hpp"
#include "tests/support/mpi_main.hpp"
#include "tests/unit/petsc/random_system.hpp"

namespace gabion::test_linear_solver {
namespace {

using test::expect_error;
using test::random_system;
using test::RandomSystem;

LinearSolverSettings settings_of(const std::string& method, const std::string& preconditioner,
                                 double tolerance = 1e-11) {
  return {.method = method, .preconditioner = preconditioner, .tolerance = tolerance};
}

/// Each rank assembles its share of the cells.
template <int block_size>
BlockMatrix<block_size> assembled_share(const RandomSystem<block_size>& system) {
  return test::assembled(system, test::rank(), test::size());
}

template <int block_size>
Eigen::VectorXd solve(LinearSolver<block_size>& solver, const Eigen::VectorXd& b) {
  Eigen::VectorXd x(b.size());
  solver.solve({b.data(), static_cast<std::size_t>(b.size())},
               {x.data(), static_cast<std::size_t>(x.size())});
  return x;
}

Eigen::VectorXd load(Eigen::Index size) {
  return Eigen::VectorXd::NullaryExpr(size, [](Eigen::Index i) { return std::sin(1.0 + 3.0 * i); });
}

template <int block_size>
void expect_dense_solution(const LinearSolverSettings& settings, double skew) {
  SCOPED_TRACE(settings.method + " " + settings.preconditioner + " block size " +
               std::to_string(block_size));
  const auto system = random_system<block_size>(61, 80, 4, skew, 11);
  const auto K = assembled_share(system);
  LinearSolver<block_size> solver(test::comm(), block_size, settings);
  solver.set_regime({skew == 0, 1}, system.num_nodes);
  solver.set_matrix(K);
  const Eigen::VectorXd b = load(system.dense.rows());
  const Eigen::VectorXd expected = system.dense.partialPivLu().solve(b);
  // Dense matrices here have condition numbers below 1e2.
  EXPECT_LT((solve(solver, b) - expected).norm(), 1e-9 * expected.norm());
  EXPECT_EQ(solver.fallbacks(), 0);
  EXPECT_EQ(solver.factorisations(), 1);
}

void for_each_block_size(const LinearSolverSettings& settings, double skew) {
  expect_dense_solution<2>(settings, skew);
  expect_dense_solution<3>(settings, skew);
}

TEST(LinearSolver, every_method_solves_unsymmetric_systems) {
  for (const char* method : {"bicgstab", "gmres"})
    for (const char* preconditioner : {"jacobi", "ilu"}) {
      for_each_block_size(settings_of(method, preconditioner), 0.3);
    }
  for (const char* method : {"lu", "mumps"}) {
    for_each_block_size(settings_of(method, "auto"), 0.3);
  }
}

TEST(LinearSolver, every_method_solves_symmetric_systems) {
  for (const char* method : {"cg", "bicgstab", "gmres"})
    for (const char* preconditioner : {"jacobi", "ilu"}) {
      for_each_block_size(settings_of(method, preconditioner), 0);
    }
  expect_dense_solution<2>(settings_of("auto", "auto"), 0);
}

TEST(LinearSolver, number_of_ranks_does_not_matter) {
  const auto system = random_system<2>(61, 80, 3, 0.3, 5);
  BlockMatrix<2> K_all;
  K_all.set_pattern(system.num_nodes, system.offsets, system.cell_nodes);
  system.assemble(K_all);
  const auto K_share = assembled_share(system);
  const Eigen::VectorXd b = load(system.dense.rows());
  for (const char* method : {"bicgstab", "mumps"}) {
    LinearSolver<2> alone(MPI_COMM_SELF, 2, settings_of(method, "auto", 1e-12));
    LinearSolver<2> together(test::comm(), 2, settings_of(method, "auto", 1e-12));
    alone.set_matrix(K_all);
    together.set_matrix(K_share);
    const Eigen::VectorXd x = solve(alone, b);
    EXPECT_LT((solve(together, b) - x).norm(), 1e-10 * x.norm()) << method;
  }
}

/// Each rank holds the nodes of its cells and no others.
void expect_solution_on_held_nodes(const LinearSolverSettings& settings, double skew) {
  SCOPED_TRACE(settings.method + " " + settings.preconditioner);
  const auto system = random_system<2>(61, 80, 3, skew, 5);
  const auto is_own = [](int c) { return c % test::size() == test::rank(); };
  std::vector<std::int32_t> ids;
  for (int c = 0; c < system.num_cells(); ++c) {
    if (!is_own(c)) continue;
    ids.insert(ids.end(), system.cell_nodes.begin() + system.offsets[c],
               system.cell_nodes.begin() + system.offsets[c + 1]);
  }
  std::sort(ids.begin(), ids.end());
  ids.erase(std::unique(ids.begin(), ids.end()), ids.end());
  const SharedNodes shared(test::comm(), ids, system.num_nodes);
  std::vector<std::int32_t> offsets{0}, nodes;
  for (int c = 0; c < system.num_cells(); ++c) {
    if (!is_own(c)) continue;
    for (std::int32_t k = system.offsets[c]; k < system.offsets[c + 1]; ++k) {
      const auto found = std::lower_bound(ids.begin(), ids.end(), system.cell_nodes[k]);
      nodes.push_back(static_cast<std::int32_t>(found - ids.begin()));
    }
    offsets.push_back(static_cast<std::int32_t>(nodes.size()));
  }
  BlockMatrix<2> K;
  K.set_pattern(static_cast<std::int32_t>(ids.size()), offsets, nodes);
  const Eigen::VectorXd b = load(system.dense.rows());
  const Eigen::VectorXd expected = system.dense.partialPivLu().solve(b);
  std::vector<double> own_b, x(2 * ids.size());
  for (const std::int32_t id : ids) own_b.insert(own_b.end(), {b[2 * id], b[2 * id + 1]});
  LinearSolver<2> solver(test::comm(), 2, settings);
  for (const double factor : {1.0, 2.0}) {  // the second time in the pattern of the first
    K.set_zero();
    std::int32_t own = 0;
    for (int c = 0; c < system.num_cells(); ++c) {
      if (!is_own(c)) continue;
      auto cell = system.cells[c];
      for (double& value : cell) value *= factor;
      K.add_cell(own++, cell.data());
    }
    solver.set_matrix(K, shared);
    solver.solve(own_b, x);
    for (std::size_t i = 0; i < ids.size(); ++i) {
      for (int d = 0; d < 2; ++d) {
        EXPECT_NEAR(factor * x[2 * i + d], expected[2 * ids[i] + d], 1e-9 * expected.norm());
      }
    }
  }
  EXPECT_EQ(solver.fallbacks(), 0);
}

TEST(LinearSolver, ranks_may_hold_the_nodes_of_their_cells_only) {
  for (const char* preconditioner : {"jacobi", "ilu"}) {
    expect_solution_on_held_nodes(settings_of("bicgstab", preconditioner, 1e-12), 0.3);
    expect_solution_on_held_nodes(settings_of("gmres", preconditioner, 1e-12), 0.3);
    expect_solution_on_held_nodes(settings_of("cg", preconditioner, 1e-12), 0);
  }
  expect_solution_on_held_nodes(settings_of("cg", "multigrid", 1e-12), 0);
  expect_solution_on_held_nodes(settings_of("mumps", "auto", 1e-12), 0.3);
}

TEST(LinearSolver, ranks_may_hold_different_patterns) {
  const auto system = random_system<2>(31, 40, 3, 0.2, 6);
  std::vector<std::int32_t> offsets{0}, nodes;
  BlockMatrix<2> K;
  std::vector<int> own;
  for (int c = test::rank(); c < system.num_cells(); c += test::size()) {
    own.push_back(c);
    nodes.insert(nodes.end(), system.cell_nodes.begin() + system.offsets[c],
                 system.cell_nodes.begin() + system.offsets[c + 1]);
    offsets.push_back(static_cast<std::int32_t>(nodes.size()));
  }
  K.set_pattern(system.num_nodes, offsets, nodes);
  for (std::size_t k = 0; k < own.size(); ++k)
    K.add_cell(static_cast<std::int32_t>(k), system.cells[own[k]].data());
  LinearSolver<2> solver(test::comm(), 2, settings_of("gmres", "jacobi"));
  solver.set_matrix(K);
  const Eigen::VectorXd b = load(system.dense.rows());
  const Eigen::VectorXd expected = system.dense.partialPivLu().solve(b);
  EXPECT_LT((solve(solver, b) - expected).norm(), 1e-9 * expected.norm());
}

/// Values in the solver's own matrix, where it has room.
BlockMatrix<2> matrix_in(LinearSolver<2>& solver) {
  return BlockMatrix<2>([&solver](const BlockMatrix<2>& K) { return solver.make_room(K); });
}

void expect_news_are_seen(bool in_solver) {
  for (const char* method : {"bicgstab", "gmres", "lu", "mumps"})
    for (const char* preconditioner : {"jacobi", "ilu"}) {
      SCOPED_TRACE(std::string(method) + " " + preconditioner);
      LinearSolver<2> solver(test::comm(), 2, settings_of(method, preconditioner));
      BlockMatrix<2> K = in_solver ? matrix_in(solver) : BlockMatrix<2>();
      for (const unsigned seed : {1u, 2u, 3u}) {
        const auto system = random_system<2>(30 + 7 * seed, 60, 3, 0.2, seed);
        K.set_pattern(system.num_nodes, system.offsets, system.cell_nodes);
        const Eigen::VectorXd b = load(system.dense.rows());
        for (const double factor : {1.0, 1e-6, 1e6}) {
          K.set_zero();
          system.assemble(K, test::rank(), test::size());
          for (double& value : K.values()) value *= factor;
          // One node stiffer: an old preconditioner or factor would not do.
          if (test::rank() == 0) K.add_diagonal(3, 100 * factor);
          Eigen::MatrixXd dense = factor * system.dense;
          dense.block<2, 2>(6, 6) += 100 * factor * NodeBlock<2>::Identity();
          solver.set_matrix(K);
          const Eigen::VectorXd expected = dense.partialPivLu().solve(b);
          EXPECT_LT((solve(solver, b) - expected).norm(), 1e-9 * expected.norm());
        }
      }
      EXPECT_EQ(solver.factorisations(), 9);
      EXPECT_EQ(solver.fallbacks(), 0);
    }
}

TEST(LinearSolver, new_values_and_new_patterns_are_seen) {
  expect_news_are_seen(false);
}
TEST(LinearSolver, values_may_lie_in_the_solvers_matrix) {
  expect_news_are_seen(true);
}

/// The other ranks are not asked for room then.
TEST(LinearSolver, one_rank_alone_may_have_a_new_pattern) {
  const auto system = random_system<2>(31, 40, 3, 0.2, 6);
  LinearSolver<2> solver(test::comm(), 2, settings_of("mumps", "auto"));
  BlockMatrix<2> K = matrix_in(solver);
  const Eigen::VectorXd b = load(system.dense.rows());
  const Eigen::VectorXd expected = system.dense.partialPivLu().solve(b);
  for (const bool again : {false, true}) {
    std::vector<std::int32_t> offsets = system.offsets, nodes = system.cell_nodes;
    if (again && test::rank() == test::size() - 1) {  // a cell of all nodes, without values
      for (std::int32_t i = 0; i < system.num_nodes; ++i) nodes.push_back(i);
      offsets.push_back(static_cast<std::int32_t>(nodes.size()));
    }
    K.set_pattern(system.num_nodes, offsets, nodes);
    system.assemble(K, test::rank(), test::size());
    solver.set_matrix(K);
    EXPECT_LT((solve(solver, b) - expected).norm(), 1e-9 * expected.norm());
  }
}

TEST(LinearSolver, factor_serves_many_right_hand_sides) {
  const auto system = random_system<2>(40, 60, 3, 0.2, 8);
  const auto K = assembled_share(system);
  for (const char* method : {"lu", "mumps"}) {
    LinearSolver<2> solver(test::comm(), 2, settings_of(method, "auto"));
    solver.set_matrix(K);
    for (int k = 1; k <= 4; ++k) {
      const Eigen::VectorXd b = k * load(system.dense.rows()).array().pow(k);
      EXPECT_LT((system.dense * solve(solver, b) - b).norm(), 1e-10 * b.norm());
    }
    EXPECT_EQ(solver.factorisations(), 1) << method;
  }
}

TEST(LinearSolver, krylov_that_fails_is_replaced_by_direct) {
  const auto system = random_system<2>(61, 80, 3, 0.3, 11);
  const auto K = assembled_share(system);
  auto settings = settings_of("bicgstab", "jacobi");
  settings.max_iterations = 2;
  LinearSolver<2> solver(test::comm(), 2, settings);
  solver.set_matrix(K);
  const Eigen::VectorXd b = load(system.dense.rows());
  for (int k = 0; k < 3; ++k)
    EXPECT_LT((system.dense * solve(solver, b) - b).norm(), 1e-8 * b.norm());
  EXPECT_EQ(solver.fallbacks(), 1);
}

LinearSolverSettings hopeless() {
  auto settings = settings_of("bicgstab", "jacobi");
  settings.max_iterations = 2;
  return settings;
}

/// Iterations that a step's only solution took.
int solve_step(LinearSolver<2>& solver, const BlockMatrix<2>& K, KrylovPause& pause) {
  const Eigen::VectorXd b = load(2 * K.num_nodes());
  std::vector<double> x(b.size());
  solver.begin_step(pause);
  solver.set_regime({false, 1}, K.num_nodes());
  solver.set_matrix(K);
  const int iterations = solver.solve({b.data(), x.size()}, x);
  pause = solver.pause();
  return iterations;
}

TEST(LinearSolver, failure_is_remembered_for_4_steps_then_for_8) {
  const auto system = random_system<2>(61, 80, 3, 0.3, 11);
  const auto K = assembled_share(system);
  LinearSolver<2> solver(test::comm(), 2, hopeless());
  KrylovPause pause;
  std::vector<int> steps_that_tried;
  for (int step = 0; step < 31; ++step)
    if (solve_step(solver, K, pause) > 0) steps_that_tried.push_back(step);
  EXPECT_EQ(steps_that_tried, (std::vector<int>{0, 5, 14}));
  EXPECT_EQ(solver.fallbacks(), 3);
  EXPECT_EQ(pause.last, 16);
}

TEST(LinearSolver, failure_is_remembered_within_a_step) {
  const auto system = random_system<2>(61, 80, 3, 0.3, 11);
  const auto K = assembled_share(system);
  LinearSolver<2> solver(test::comm(), 2, hopeless());
  const Eigen::VectorXd b = load(system.dense.rows());
  for (int k = 0; k < 3; ++k) {
    solver.set_matrix(K);
    EXPECT_LT((system.dense * solve(solver, b) - b).norm(), 1e-8 * b.norm());
  }
  EXPECT_EQ(solver.fallbacks(), 1);
}

TEST(LinearSolver, success_ends_the_memory_and_other_methods_are_not_concerned) {
  const auto system = random_system<2>(61, 80, 3, 0.3, 11);
  const auto K = assembled_share(system);
  LinearSolver<2> solver(test::comm(), 2, settings_of("bicgstab", "jacobi"));
  const std::int64_t number =
      LinearMethod{SolutionMethod::bicgstab, Preconditioner::jacobi}.number();
  KrylovPause due{.steps = 0, .last = 8, .method = number};
  EXPECT_GT(solve_step(solver, K, due), 0);
  EXPECT_EQ(due, KrylovPause{});
  KrylovPause resting{.steps = 3, .last = 8, .method = number};
  EXPECT_EQ(solve_step(solver, K, resting), 0);
  EXPECT_EQ(resting.steps, 2);
  KrylovPause of_another{.steps = 3, .last = 8, .method = number + 1};
  EXPECT_GT(solve_step(solver, K, of_another), 0);
}

/// Two nodes whose diagonal blocks vanish: block Jacobi, block ILU and LU without pivots all fail.
BlockMatrix<2> saddle() {
  BlockMatrix<2> K;
  const std::vector<std::int32_t> offsets{0, 2}, nodes{0, 1};
  K.set_pattern(2, offsets, nodes);
  if (test::rank() == 0) {
    K.add_block(0, 1, 2 * NodeBlock<2>::Identity());
    K.add_block(1, 0, 3 * NodeBlock<2>::Identity());
  }
  return K;
}

TEST(LinearSolver, zero_diagonal_blocks_end_in_the_pivoting_solver) {
  const auto K = saddle();
  const Eigen::Vector4d b(1, 2, 3, 4), expected(1, 4.0 / 3, 0.5, 1);
  for (const char* preconditioner : {"jacobi", "ilu"}) {
    LinearSolver<2> solver(test::comm(), 2, settings_of("gmres", preconditioner));
    solver.set_matrix(K);
    EXPECT_LT((solve(solver, b) - expected).norm(), 1e-12) << preconditioner;
    EXPECT_EQ(solver.fallbacks(), 1);
  }
  LinearSolver<2> lu(test::comm(), 2, settings_of("lu", "auto"));
  lu.set_matrix(K);
  EXPECT_LT((solve(lu, b) - expected).norm(), 1e-12);
}

TEST(LinearSolver, singular_matrix_throws) {
  // One spring between two nodes that nothing holds, and a load that is not in equilibrium.
  BlockMatrix<2> K;
  const std::vector<std::int32_t> offsets{0, 2}, nodes{0, 1};
  K.set_pattern(2, offsets, nodes);
  for (int i = 0; i < 2; ++i)
    for (int j = 0; j < 2; ++j)
      if (test::rank() == 0) K.add_block(i, j, (i == j ? 3 : -3) * NodeBlock<2>::Identity());
  const Eigen::Vector4d b(1, 0, 1, 0);
  for (const char* method : {"bicgstab", "gmres", "cg", "lu", "mumps"}) {
    LinearSolver<2> solver(test::comm(), 2, settings_of(method, "auto"));
    solver.set_matrix(K);
    SCOPED_TRACE(method);
    for (int k = 0; k < 2; ++k) {
      expect_error<ConvergenceError>([&] { solve(solver, b); },
                                     {"failed with 4 unknowns", "the matrix is singular"});
    }
    const auto good = random_system<2>(20, 30, 3, 0, 1);
    const auto good_K = assembled_share(good);
    solver.set_matrix(good_K);
    const Eigen::VectorXd c = load(40);
    EXPECT_LT((good.dense * solve(solver, c) - c).norm(), 1e-8 * c.norm()) << method;
  }
}

/// A weight on a soft spring and a stiff one: what it moves by makes forces in the stiff one whose
/// round-off is 1e-7 of the weight.
TEST(LinearSolver, round_off_of_stiff_springs_is_accepted_where_it_is_allowed) {
  BlockMatrix<2> K;
  const std::vector<std::int32_t> offsets{0, 3}, nodes{0, 1, 2};
  K.set_pattern(3, offsets, nodes);
  const NodeBlock<2> stiff = 0.7e9 * NodeBlock<2>{{2.1, 0.7}, {0.7, 1.3}};
  if (test::rank() == 0) {
    K.add_block(0, 0, NodeBlock<2>::Identity() / 3);
    for (int k = 0; k < 2; ++k) {
      K.add_block(k, k, stiff);
      K.add_block(k + 1, k + 1, stiff);
      K.add_block(k, k + 1, -stiff);
      K.add_block(k + 1, k, -stiff);
    }
  }
  Eigen::VectorXd b(6);
  b << 0, 0, 0.1, 0.2, 0.3, 0.7;
  const Eigen::Vector2d rigid(3 * 0.4, 3 * 0.9);
  for (const char* method : {"lu", "mumps"}) {
    SCOPED_TRACE(method);
    LinearSolver<2> solver(test::comm(), 2, settings_of(method, "auto"));
    solver.set_matrix(K);
    expect_error<ConvergenceError>([&] { solve(solver, b); }, {"the matrix is singular"});
    LinearSolver<2> other(test::comm(), 2, settings_of(method, "auto"));
    other.accept_round_off();
    other.set_matrix(K);
    const Eigen::VectorXd x = solve(other, b);
    for (int k = 0; k < 3; ++k) {
      EXPECT_LT((x.segment<2>(2 * k) - rigid).norm(), 1e-5 * rigid.norm()) << k;
    }
  }
}

TEST(LinearSolver, values_that_are_not_finite_throw) {
  const auto system = random_system<2>(20, 30, 3, 0, 1);
  const double nan = std::numeric_limits<double>::quiet_NaN();
  for (const char* method : {"bicgstab", "gmres", "cg", "lu", "mumps"}) {
    auto K = assembled_share(system);
    LinearSolver<2> solver(test::comm(), 2, settings_of(method, "auto"));
    solver.set_matrix(K);
    Eigen::VectorXd b = load(40);
    b[17] = nan;
    SCOPED_TRACE(method);
    expect_error<ConvergenceError>([&] { solve(solver, b); },
                                   {"linear solver: right-hand side is not finite"});
    K.values()[5] = nan;
    solver.set_matrix(K);
    expect_error<ConvergenceError>([&] { solve(solver, load(40)); },
                                   {"failed with 40 unknowns", "or not finite"});
  }
}

TEST(LinearSolver, no_load_no_displacement) {
  const auto system = random_system<2>(20, 30, 3, 0, 1);
  const auto K = assembled_share(system);
  LinearSolver<2> solver(test::comm(), 2, {});
  solver.set_matrix(K);
  EXPECT_EQ(solve(solver, Eigen::VectorXd::Zero(40)).norm(), 0);
}

TEST(LinearSolver, looser_tolerance_saves_iterations) {
  const auto system = random_system<2>(200, 260, 3, 0.1, 1);
  const auto K = assembled_share(system);
  LinearSolver<2> solver(test::comm(), 2, settings_of("bicgstab", "jacobi", 1e-10));
  solver.set_matrix(K);
  const Eigen::VectorXd b = load(400);
  std::vector<double> x(400);
  const std::span<const double> load_span(b.data(), 400);
  const int tight = solver.solve(load_span, x);
  EXPECT_EQ(solver.solve(load_span, x, 1e-14), tight);
  EXPECT_LT(solver.solve(load_span, x, 1e-3), tight);
}

TEST(PetscSession, errors_carry_petscs_text) {
  expect_error<Error>([] { check_petsc(63, "KSPSolve"); },
                      {"PETSc: KSPSolve failed with code 63: Argument out of range"});
}

/// Against all eigenvalues, of matrices with negative ones and of one that is not symmetric.
template <int block_size>
void expect_counted(double skew, int negative_cells) {
  auto system = random_system<block_size>(12, 15, 4, skew, 5);
  for (int c = 0; c < negative_cells; ++c) {
    for (double& value : system.cells[c]) value = -value;
  }
  const auto K = assembled(system);
  const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> modes(
      Eigen::MatrixXd(test::to_dense(K).template selfadjointView<Eigen::Upper>()));
  const auto negative = (modes.eigenvalues().array() < 0).count();
  if (negative_cells == 15) {
    EXPECT_EQ(negative, K.num_nodes() * block_size);
  }
  EXPECT_EQ(count_negative_eigenvalues(K), negative) << negative_cells << " cells";
}

TEST(EigenvalueSigns, equal_those_of_all_eigenvalues) {
  for (const int cells : {0, 1, 6, 15}) {
    expect_counted<2>(0, cells);
    expect_counted<3>(0, cells);
    expect_counted<3>(0.1, cells);
  }
}

}  // namespace
}  // namespace gabion::test_linear_solver
