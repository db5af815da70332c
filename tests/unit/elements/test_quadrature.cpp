// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include <cmath>

#include "common/base/error.hpp"
#include "tests/support/expect_error.hpp"
#include "tests/unit/elements/reference_cells.hpp"

namespace gabion::test_quadrature {
namespace {

using test::inside_reference;

double factorial(int n) {
  return std::tgamma(n + 1.0);
}

/// Integral of prod xi_i^power_i over the reference cell. Simplex: Dirichlet's formula.
template <int dim>
double monomial_integral(CellType type, const int* power) {
  double result = 1;
  int sum = 0;
  for (int i = 0; i < dim; ++i) {
    sum += power[i];
    result *=
        is_simplex(type) ? factorial(power[i]) : (power[i] % 2 == 0 ? 2.0 / (power[i] + 1) : 0.0);
  }
  return is_simplex(type) ? result / factorial(sum + dim) : result;
}

/// Largest error over all monomials that a rule of this degree must integrate.
template <int dim>
double largest_error(CellType type, const std::vector<QuadraturePoint<dim>>& rule, int degree) {
  double largest = 0;
  int power[3] = {0, 0, 0};
  for (power[0] = 0; power[0] <= degree; ++power[0]) {
    for (power[1] = 0; power[1] <= (dim > 1 ? degree : 0); ++power[1]) {
      for (power[2] = 0; power[2] <= (dim > 2 ? degree : 0); ++power[2]) {
        if (is_simplex(type) && power[0] + power[1] + power[2] > degree) continue;
        double sum = 0;
        for (const auto& point : rule) {
          double value = point.weight;
          for (int i = 0; i < dim; ++i) value *= std::pow(point.xi[i], power[i]);
          sum += value;
        }
        largest = std::max(largest, std::abs(sum - monomial_integral<dim>(type, power)));
      }
    }
  }
  return largest;
}

template <int dim>
void check_gauss_rules(CellType type, int max_degree) {
  for (int degree = 0; degree <= max_degree; ++degree) {
    const auto rule = gauss_rule<dim>(type, degree);
    EXPECT_LT(largest_error<dim>(type, rule, degree), 4e-15) << name(type) << " " << degree;
    for (const auto& point : rule) {
      EXPECT_GT(point.weight, 0.0);
      EXPECT_TRUE(inside_reference<dim>(type, point.xi)) << name(type) << " " << degree;
    }
  }
  for (const int wrong : {max_degree + 1, -1}) {
    test::expect_error<Error>(
        [&] { gauss_rule<dim>(type, wrong); },
        {"Gauss rule of " + std::string(name(type)) + ": found degree " + std::to_string(wrong)});
  }
}

TEST(GaussRule, is_exact_to_its_degree_with_positive_weights_inside) {
  check_gauss_rules<1>(CellType::line2, 7);
  check_gauss_rules<2>(CellType::tri3, 6);
  check_gauss_rules<2>(CellType::quad4, 7);
  check_gauss_rules<3>(CellType::tet4, 5);
  check_gauss_rules<3>(CellType::hex8, 7);
}

TEST(GaussRule, is_not_exact_beyond_its_degree) {
  EXPECT_GT(largest_error<2>(CellType::tri3, gauss_rule<2>(CellType::tri3, 2), 3), 1e-4);
  EXPECT_GT(largest_error<3>(CellType::tet4, gauss_rule<3>(CellType::tet4, 2), 3), 1e-4);
  EXPECT_GT(largest_error<2>(CellType::quad4, gauss_rule<2>(CellType::quad4, 3), 4), 1e-2);
}

template <int dim>
void check_point_rule(CellType type, int count, int degree) {
  const auto rule = point_rule<dim>(type, count);
  ASSERT_EQ(static_cast<int>(rule.size()), count);
  EXPECT_LT(largest_error<dim>(type, rule, degree), 4e-15) << name(type) << " " << count;
  for (const auto& point : rule) {
    EXPECT_GT(point.weight, 0.0);
    EXPECT_TRUE(inside_reference<dim>(type, point.xi)) << name(type) << " " << count;
  }
}

TEST(PointRule, has_positive_weights_inside_and_keeps_volume_and_centroid) {
  check_point_rule<2>(CellType::tri3, 1, 1);
  check_point_rule<2>(CellType::tri3, 3, 2);
  check_point_rule<2>(CellType::tri3, 4, 1);
  check_point_rule<2>(CellType::tri3, 6, 4);
  check_point_rule<2>(CellType::tri3, 12, 6);
  check_point_rule<2>(CellType::tri3, 16, 1);
  check_point_rule<2>(CellType::quad4, 1, 1);
  check_point_rule<2>(CellType::quad4, 4, 3);
  check_point_rule<2>(CellType::quad4, 9, 5);
  check_point_rule<2>(CellType::quad4, 16, 7);
  check_point_rule<3>(CellType::tet4, 1, 1);
  check_point_rule<3>(CellType::tet4, 4, 2);
  check_point_rule<3>(CellType::hex8, 1, 1);
  check_point_rule<3>(CellType::hex8, 8, 3);
  check_point_rule<3>(CellType::hex8, 27, 5);
}

TEST(PointRule, of_three_points_has_equal_weights) {
  const auto rule = point_rule<2>(CellType::tri3, 3);
  for (const auto& point : rule) {
    EXPECT_DOUBLE_EQ(point.weight, 1.0 / 6.0);
  }
  EXPECT_LT((rule[0].xi - Vector<2>(1.0 / 6.0, 1.0 / 6.0)).norm(), 1e-16);
  EXPECT_LT((rule[1].xi - Vector<2>(2.0 / 3.0, 1.0 / 6.0)).norm(), 2e-16);
  EXPECT_LT((rule[2].xi - Vector<2>(1.0 / 6.0, 2.0 / 3.0)).norm(), 2e-16);
}

TEST(PointRule, of_another_count_is_refused_with_the_allowed_ones) {
  test::expect_error<ConfigError>(
      [] { point_rule<2>(CellType::tri3, 5); },
      {"points per cell of tri3: found 5, allowed: 1, 3, 4, 6, 12, 16"});
  test::expect_error<ConfigError>([] { point_rule<2>(CellType::quad4, 3); },
                                  {"points per cell of quad4: found 3, allowed: 1, 4, 9, 16"});
  test::expect_error<ConfigError>([] { point_rule<3>(CellType::tet4, 8); },
                                  {"points per cell of tet4: found 8, allowed: 1, 4"});
  test::expect_error<ConfigError>([] { point_rule<3>(CellType::hex8, 0); },
                                  {"points per cell of hex8: found 0, allowed: 1, 8, 27"});
}

}  // namespace
}  // namespace gabion::test_quadrature
