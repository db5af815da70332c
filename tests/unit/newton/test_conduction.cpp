// SPDX-License-Identifier: BSD-3-Clause
// Blocks need not be vectors of space: two or three scalar fields in the plane.
#include <gtest/gtest.h>

#include "tests/unit/newton/conduction.hpp"

namespace gabion::test_conduction {
namespace {

using test::Conduction;

template <int fields>
double largest_error(const Conduction<fields>& problem, const std::vector<double>& u) {
  double largest = 0;
  for (int i = 0; i < problem.num_nodes(); ++i)
    for (int k = 0; k < fields; ++k)
      largest = std::max(largest, std::abs(u[i * fields + k] - problem.exact(i, k)));
  return largest;
}

template <int fields>
void expect_linear_solution(const std::string& method, const std::string& preconditioner) {
  SCOPED_TRACE(method + " " + preconditioner + ", " + std::to_string(fields) + " fields");
  Conduction<fields> problem(0);
  BlockMatrix<fields> K;
  problem.set_pattern(K);
  std::vector<double> u = problem.guess(), r(u.size()), step(u.size());
  problem.evaluate(u, r, &K);
  LinearSolver<fields> solver(
      test::comm(), 2, {.method = method, .preconditioner = preconditioner, .tolerance = 1e-13});
  solver.set_regime({.symmetric = true, .courant = HUGE_VAL}, problem.num_nodes());
  solver.set_matrix(K);
  solver.solve(r, step);
  EXPECT_EQ(solver.fallbacks(), 0);
  for (std::size_t i = 0; i < u.size(); ++i) u[i] += step[i];
  EXPECT_LT(largest_error(problem, u), 1e-11);
}

TEST(Conduction, every_method_solves_the_poisson_equation) {
  for (const char* method : {"cg", "bicgstab", "gmres"}) {
    for (const char* preconditioner : {"jacobi", "ilu"}) {
      expect_linear_solution<2>(method, preconditioner);
      expect_linear_solution<3>(method, preconditioner);
    }
  }
  for (const char* method : {"auto", "lu", "mumps"}) {
    expect_linear_solution<2>(method, "auto");
    expect_linear_solution<3>(method, "auto");
  }
}

template <int fields>
void expect_newton_solution() {
  SCOPED_TRACE(fields);
  Conduction<fields> problem(1);
  BlockMatrix<fields> K;
  problem.set_pattern(K);
  LinearSolver<fields> linear(test::comm(), 2, {.method = "lu"});
  NewtonMatrix<fields> matrix{K, linear};
  PhaseTimes times;
  std::vector<double> u = problem.guess();
  const NewtonReport report =
      solve_newton<fields>(problem, matrix, {.residual_tolerance = 1e-12}, u, times);
  EXPECT_LT(largest_error(problem, u), 1e-11);
  EXPECT_GT(report.iterations, 2);
  // Quadratic: each |r| is at most that factor times the square of the one before.
  const auto& residuals = report.residuals;
  for (std::size_t k = 2; k < residuals.size(); ++k) {
    EXPECT_LT(residuals[k], 10 * residuals[k - 1] * residuals[k - 1] + 1e-14);
  }
}

TEST(Conduction, newton_solves_for_any_number_of_unknowns) {
  expect_newton_solution<2>();
  expect_newton_solution<3>();
}

}  // namespace
}  // namespace gabion::test_conduction
