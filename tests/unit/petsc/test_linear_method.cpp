// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include <limits>
#include <set>

#include "common/mechanics/petsc/linear_method.hpp"
#include "tests/support/expect_error.hpp"

namespace gabion::test_linear_method {
namespace {

constexpr double infinity = std::numeric_limits<double>::infinity();

LinearMethod automatic(double courant, bool symmetric, int dim, std::int64_t num_dofs,
                       int num_ranks = 1) {
  return choose_linear_method({}, {symmetric, courant}, dim, num_dofs, num_ranks);
}

TEST(LinearMethod, automatic_follows_the_regime) {
  using M = SolutionMethod;
  using P = Preconditioner;
  EXPECT_EQ(automatic(0.8, false, 2, 3000), (LinearMethod{M::bicgstab, P::jacobi}));
  EXPECT_EQ(automatic(0.8, true, 2, 3000), (LinearMethod{M::cg, P::jacobi}));
  EXPECT_EQ(automatic(5, true, 2, 3000), (LinearMethod{M::cg, P::ilu}));
  EXPECT_EQ(automatic(20, false, 2, 3000), (LinearMethod{M::lu, P::none}));
  EXPECT_EQ(automatic(20, true, 2, 8000), (LinearMethod{M::cg, P::ilu}));
  EXPECT_EQ(automatic(infinity, false, 3, 600), (LinearMethod{M::lu, P::none}));
  EXPECT_EQ(automatic(infinity, false, 2, 3000), (LinearMethod{M::lu, P::none}));
  EXPECT_EQ(automatic(infinity, false, 2, 100000), (LinearMethod{M::mumps, P::none}));
  EXPECT_EQ(automatic(infinity, false, 2, 3000, 2), (LinearMethod{M::mumps, P::none}));
  EXPECT_EQ(automatic(infinity, false, 3, 200000), (LinearMethod{M::bicgstab, P::jacobi}));
  EXPECT_EQ(automatic(20, true, 3, 200000), (LinearMethod{M::cg, P::ilu}));
  EXPECT_EQ(automatic(infinity, true, 3, 90000), (LinearMethod{M::cg, P::ilu}));
  EXPECT_EQ(automatic(infinity, true, 3, 200000), (LinearMethod{M::cg, P::ilu}));
}

TEST(LinearMethod, wide_rows_are_not_factorised_before_they_have_to_be) {
  const auto chosen = [](double courant, bool wide) {
    const LinearRegime regime{.symmetric = true, .courant = courant, .wide = wide};
    return choose_linear_method({}, regime, 3, 200000, 1);
  };
  const LinearMethod jacobi{SolutionMethod::cg, Preconditioner::jacobi};
  const LinearMethod ilu{SolutionMethod::cg, Preconditioner::ilu};
  EXPECT_EQ(chosen(13, true), jacobi);
  EXPECT_EQ(chosen(13, false), ilu);
  EXPECT_EQ(chosen(40, true), ilu);
  EXPECT_EQ(chosen(infinity, true), ilu);
}

TEST(LinearMethod, unsymmetric_matrices_are_not_factorised_incompletely) {
  const LinearMethod jacobi{SolutionMethod::bicgstab, Preconditioner::jacobi};
  for (const double courant : {1.0, 5.0, 40.0, infinity}) {
    EXPECT_EQ(automatic(courant, false, 3, 200000), jacobi) << courant;
  }
  EXPECT_EQ(automatic(10, false, 2, 8000), jacobi);
}

TEST(LinearMethod, multigrid_is_for_large_slender_bodies_at_rest) {
  using M = SolutionMethod;
  using P = Preconditioner;
  const auto chosen = [](LinearRegime regime, std::int64_t num_dofs) {
    return choose_linear_method({}, regime, 3, num_dofs, 1);
  };
  const LinearMethod multigrid{M::cg, P::multigrid};
  EXPECT_EQ(chosen({.symmetric = true, .courant = infinity, .slender = true}, 50000), multigrid);
  EXPECT_EQ(chosen({.symmetric = true, .courant = 100, .slender = true}, 50000), multigrid);
  EXPECT_EQ(chosen({.symmetric = true, .courant = 40, .slender = true}, 50000),
            (LinearMethod{M::cg, P::ilu}));
  EXPECT_EQ(chosen({.symmetric = true, .courant = infinity, .slender = true}, 10000),
            (LinearMethod{M::cg, P::ilu}));
  EXPECT_EQ(chosen({.symmetric = false, .courant = infinity, .slender = true}, 50000),
            (LinearMethod{M::bicgstab, P::jacobi}));
}

TEST(LinearMethod, settings_override_the_regime) {
  LinearSolverSettings settings;
  settings.method = "gmres";
  settings.preconditioner = "ilu";
  EXPECT_EQ(choose_linear_method(settings, {false, 0.1}, 2, 100, 1),
            (LinearMethod{SolutionMethod::gmres, Preconditioner::ilu}));
  settings.preconditioner = "multigrid";
  EXPECT_EQ(choose_linear_method(settings, {false, 0.1}, 2, 100, 1),
            (LinearMethod{SolutionMethod::gmres, Preconditioner::multigrid}));
  settings.method = "mumps";
  settings.preconditioner = "auto";
  EXPECT_TRUE(choose_linear_method(settings, {false, 0.1}, 2, 100, 1).direct());
}

LinearSolverSettings read(const Json& json) {
  return read_linear_solver_settings(ConfigReader(json, "f.json", linear_solver_keys()));
}

TEST(LinearMethod, numbers_differ) {
  std::set<std::int64_t> numbers;
  for (const auto m : {SolutionMethod::bicgstab, SolutionMethod::gmres, SolutionMethod::cg})
    for (const auto p : {Preconditioner::jacobi, Preconditioner::ilu, Preconditioner::multigrid})
      numbers.insert(LinearMethod{m, p}.number());
  EXPECT_EQ(numbers.size(), 9u);
}

TEST(LinearMethod, reads_settings) {
  const Json json = {
      {"method", "gmres"}, {"preconditioner", "ilu"}, {"tolerance", 1e-6}, {"max_iterations", 80}};
  const auto settings = read(json);
  EXPECT_EQ(settings.method, "gmres");
  EXPECT_EQ(settings.preconditioner, "ilu");
  EXPECT_EQ(settings.tolerance, 1e-6);
  EXPECT_EQ(settings.max_iterations, 80);
}

TEST(LinearMethod, refuses_wrong_settings) {
  const auto refuses = [](const Json& json, const std::vector<std::string_view>& parts) {
    test::expect_error<ConfigError>([&] { read(json); }, parts);
  };
  refuses({{"method", "qr"}}, {"/method: found \"qr\"", "bicgstab"});
  refuses({{"tolerance", 0.0}}, {"/tolerance: found 0"});
  refuses({{"tolerance", 2e-16}}, {"/tolerance: found 2e-16", "rounding"});
  EXPECT_EQ(read({{"tolerance", 2.3e-16}}).tolerance, 2.3e-16);
  refuses({{"max_iterations", 0}}, {"/max_iterations: found 0"});
  refuses({{"tolerence", 1e-6}}, {"/tolerence", "unknown", "tolerance"});
  refuses({{"method", "lu"}, {"preconditioner", "ilu"}},
          {"/preconditioner: found \"ilu\"", "direct method \"lu\""});
}

}  // namespace
}  // namespace gabion::test_linear_method
