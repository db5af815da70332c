// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

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
