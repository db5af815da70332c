// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include "tests/unit/materials/random_state.hpp"

namespace gabion::testing::test_spectral {
namespace {

template <int dim>
void expect_exact_eigenpairs(const Symmetric<dim>& s) {
  const auto pairs = eigenpairs<dim>(s);
  const double scale = s.cwiseAbs().maxCoeff();
  for (int i = 0; i < dim; ++i) {
    for (int j = 0; j < dim; ++j) {
      EXPECT_NEAR(dyad(pairs.n, i, j).trace(), i == j ? 1 : 0, 3e-15);
      EXPECT_LT((dyad(pairs.n, i, j) * dyad(pairs.n, j, i) - dyad(pairs.n, i, i)).norm(), 3e-15);
    }
  }
  EXPECT_LE((compose<dim>(pairs.value, pairs.n) - s).norm(), 5e-15 * scale);
}

TEST(Spectral, eigenpairs_reconstruct_nearly_equal_and_tiny_values) {
  Random random(53);
  for (const double size : {1.0, 1e-9, 1e-100}) {
    for (const double gap : {0.0, 1e-15, 1e-12, 1e-8, 1e-4, 1.0}) {
      for (int sample = 0; sample < 50; ++sample) {
        const std::array<double, 3> value = {size, size * (1 + gap), size * (1 - gap)};
        expect_exact_eigenpairs<2>(compose<2>(value, axes<2>(random.rotation<2>())));
        expect_exact_eigenpairs<3>(compose<3>(value, random.rotation<3>()));
      }
    }
  }
  expect_exact_eigenpairs<2>(Symmetric<2>::Zero());
  expect_exact_eigenpairs<3>(Symmetric<3>::Zero());
  expect_exact_eigenpairs<2>({1, 1, 3, -0.5});
  expect_exact_eigenpairs<2>({-2, 1, 3, -1e-20});
}

TEST(Spectral, hencky_strain_is_exact_for_every_size) {
  for (double e : {1e-300, 1e-17, 1e-9, 1e-4, 0.01, 0.1, 0.124, 0.1335, 0.3, 2.0, 1e6}) {
    for (const double x : {e, -e}) {
      if (x <= -1) continue;
      const double exact = 0.5 * std::log1p(x);
      EXPECT_NEAR(hencky_strain(x), exact, 4e-16 * std::abs(exact)) << x;
      if (std::abs(x) < 1) {
        EXPECT_NEAR(strain_from_hencky(exact), x, 6e-16 * std::abs(x)) << x;
      }
    }
  }
  for (const double eps : {0.0312, 0.0313, -0.0312, -0.0313, 0.02, 1e-5})
    EXPECT_NEAR(strain_from_hencky(eps), std::expm1(2 * eps), 4e-16 * std::abs(2 * eps)) << eps;
}

TEST(Spectral, hencky_slope_is_smooth_through_equal_values) {
  for (const double b : {0.2, 1.0, 3.0}) {
    EXPECT_DOUBLE_EQ(hencky_slope(b, b), 0.5 / b);
    for (const double ratio : {1.01, 1.13, 1.14, 1.5, 2.9, 3.1, 10.0}) {
      const double exact = 0.5 * std::log(ratio) / (b * ratio - b);
      EXPECT_NEAR(hencky_slope(b, b * ratio), exact, 1e-13 * exact);
    }
    const double gap = 1e-5;  // series of the logarithm
    EXPECT_NEAR(hencky_slope(b * (1 + gap), b), (0.5 - gap / 4 + gap * gap / 6) / b, 1e-15 / b);
  }
}

TEST(Spectral, determinant_minus_one_keeps_tiny_volume_change) {
  Matrix<3> H = 1e-12 * Matrix<3>::Identity();
  EXPECT_NEAR(determinant_minus_one<3>(H), 3e-12, 1e-23);
  Random random(59);
  H = random.matrix<3>(0.3);
  EXPECT_NEAR(determinant_minus_one<3>(H), (Matrix<3>::Identity() + H).determinant() - 1, 1e-15);
}

}  // namespace
}  // namespace gabion::testing::test_spectral
