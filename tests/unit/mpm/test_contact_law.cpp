// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include <cmath>

#include "mpm_solver/contact/contact_law.hpp"

namespace gabion::test {
namespace {

using mpm::ContactLaw;
using mpm::NormalLaw;

TEST(ContactLaw, traction_is_the_derivative_of_what_is_stored) {
  for (const NormalLaw normal : {NormalLaw::linear, NormalLaw::quadratic}) {
    const ContactLaw law{.penalty = 2e5, .tangential_penalty = 1e5, .normal = normal};
    EXPECT_EQ(law.stored(0), 0);
    EXPECT_EQ(law.stored(-0.01), 0);
    for (const double d : {1e-3, 0.02}) {
      const double step = 1e-4 * d;
      const double t = law.traction<2>({-d, 0}, nullptr).t[0];
      EXPECT_NEAR(t, (law.stored(d + step) - law.stored(d - step)) / (2 * step), 1e-7 * t);
    }
    EXPECT_FALSE(law.traction<2>({1e-9, 0.1}, nullptr).closed);
  }
}

/// Beyond linear_from the traction follows its tangent; the stored energy is its work.
TEST(ContactLaw, a_quadratic_law_that_goes_on_along_its_tangent) {
  const double from = 0.004, penalty = 2e5;
  const ContactLaw law{.penalty = penalty, .normal = NormalLaw::quadratic, .linear_from = from};
  const auto square = [&](double d) { return d * law.reduced(d); };
  const auto stored = [&](double d) { return law.stored(std::cbrt(law.storing(d) * d * d)); };
  EXPECT_EQ(square(0.003), 0.003 * 0.003);
  EXPECT_EQ(law.storing(0.003), 0.003);
  for (const double d : {0.001, 0.004, 0.01, 0.1}) {
    const double step = 1e-6 * d, slope = d <= from ? 2 * d : 2 * from;
    if (d > from) EXPECT_NEAR(square(d), from * from + 2 * from * (d - from), 1e-15);
    EXPECT_NEAR((square(d + step) - square(d - step)) / (2 * step), slope, 1e-6 * slope);
    EXPECT_NEAR(law.reduced(d) + d * law.reduced_slope(d), slope, 1e-12 * slope);
    EXPECT_NEAR((stored(d + step) - stored(d - step)) / (2 * step), penalty * square(d),
                1e-7 * penalty * square(d));
    EXPECT_NEAR(law.depth_of(square(d)), d, 1e-12 * d);
  }
}

TEST(ContactLaw, slope_is_the_derivative_of_traction) {
  for (const NormalLaw normal : {NormalLaw::linear, NormalLaw::quadratic}) {
    for (const double friction : {-1.0, 0.3}) {
      const ContactLaw law{
          .friction = friction, .penalty = 2e5, .tangential_penalty = 1e5, .normal = normal};
      const Vector<3> gap(-0.01, 0.02, -0.03);
      Matrix<3> slope;
      const auto found = law.traction<3>(gap, &slope);
      EXPECT_EQ(found.sliding, friction > 0);
      for (int k = 0; k < 3; ++k) {
        const Vector<3> step = 1e-7 * Vector<3>::Unit(k);
        const Vector<3> change =
            (law.traction<3>(gap - step, nullptr).t - law.traction<3>(gap + step, nullptr).t) /
            2e-7;
        EXPECT_LT((change - slope.col(k)).norm(), 1e-7 * slope.norm()) << k;
      }
    }
  }
}

}  // namespace
}  // namespace gabion::test
