// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include <cmath>

#include "mpm_solver/contact/contact_law.hpp"

namespace gabion::test::test_contact_law {
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
    EXPECT_NEAR(square(d), d > from ? from * from + 2 * from * (d - from) : d * d, 1e-15);
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

/// Slip in the step supplies the displacement that the springs do not take: t = friction t_n + drag
/// v^2.
TEST(ContactLaw, drag_grows_with_the_square_of_the_speed) {
  const Vector<3> gap(-0.01, 0.02, -0.03);
  for (const double drag : {1e-6, 40., 1e5}) {
    for (const double time : {1e-6, 1e-3, 10.}) {
      const ContactLaw law{
          .friction = 0.3, .penalty = 2e5, .tangential_penalty = 1e5, .drag = drag, .time = time};
      const auto found = law.traction<3>(gap, nullptr);
      ASSERT_TRUE(found.sliding);
      const double trial = 1e5 * gap.tail<2>().norm(), t = found.t.tail<2>().norm();
      const double speed = (trial - t) / 1e5 / time;
      EXPECT_NEAR(t, 0.3 * found.t[0] + drag * speed * speed, 1e-6 * trial) << drag << " " << time;
      EXPECT_LT((found.t.tail<2>() / t + gap.tail<2>() / gap.tail<2>().norm()).norm(), 1e-14);
      EXPECT_GE(t, 0.3 * found.t[0] * (1 - 1e-12));
      EXPECT_LE(t, trial);
    }
  }
}

TEST(ContactLaw, slope_with_drag_is_the_derivative_of_traction) {
  for (const double friction : {0.0, 0.3}) {
    for (const double time : {1e-5, 1e-3, 0.1}) {
      const ContactLaw law{.friction = friction,
                           .penalty = 2e5,
                           .tangential_penalty = 1e5,
                           .normal = NormalLaw::quadratic,
                           .drag = 40,
                           .time = time};
      const Vector<3> gap(-0.01, 0.02, -0.03);
      Matrix<3> slope;
      EXPECT_TRUE(law.traction<3>(gap, &slope).sliding);
      for (int k = 0; k < 3; ++k) {
        const Vector<3> step = 1e-7 * Vector<3>::Unit(k);
        const Vector<3> change =
            (law.traction<3>(gap - step, nullptr).t - law.traction<3>(gap + step, nullptr).t) /
            2e-7;
        EXPECT_LT((change - slope.col(k)).norm(), 1e-7 * slope.norm()) << k << " " << time;
      }
    }
  }
}

/// mu(v) = 0.1 + 0.2 exp(-v / 0.5) of a speed that is given.
ContactLaw weakening_law(double speed, double drag) {
  return {.friction = 0.3,
          .penalty = 2e5,
          .tangential_penalty = 1e5,
          .normal = NormalLaw::quadratic,
          .drag = drag,
          .time = 1e-3,
          .weakening = {.fall = 0.2, .speed = 0.5},
          .speed = speed,
          .pore_pressure = 3,
          .drained = 0.4,
          .grain_share = 0.85};
}

TEST(ContactLaw, friction_falls_with_the_speed) {
  const Vector<3> gap(-0.01, 0.02, -0.03);
  const double pressed = 0.6 * 0.85 * 20 + 0.4 * (20 - 3);  // what the grains bear
  for (const double speed : {0.0, 0.1, 0.5, 4.0, 1e9}) {
    const auto found = weakening_law(speed, 0).traction<3>(gap, nullptr);
    const double mu = 0.1 + 0.2 * std::exp(-speed / 0.5);
    EXPECT_TRUE(found.sliding);
    EXPECT_NEAR(found.t.tail<2>().norm(), mu * pressed, 1e-13 * pressed) << speed;
  }
  ContactLaw coulomb = weakening_law(4, 0);
  coulomb.weakening = {};
  ContactLaw at_rest = coulomb;
  at_rest.speed = 0;
  EXPECT_EQ(coulomb.traction<3>(gap, nullptr).t, at_rest.traction<3>(gap, nullptr).t);
  EXPECT_EQ(coulomb.traction<3>(gap, nullptr).by_speed, 0);
}

/// The slope is zero while the contact sticks, and where water bears all of the pressure.
TEST(ContactLaw, slope_over_the_speed_is_the_derivative_of_traction) {
  const Vector<3> gap(-0.01, 0.02, -0.03);
  for (const double drag : {0.0, 0.04}) {
    for (const double speed : {0.1, 0.8}) {
      const auto size = [&](double v) {
        return weakening_law(v, drag).traction<3>(gap, nullptr).t.tail<2>().norm();
      };
      const double found = weakening_law(speed, drag).traction<3>(gap, nullptr).by_speed;
      EXPECT_LT(found, 0);
      EXPECT_NEAR(found, (size(speed + 1e-5) - size(speed - 1e-5)) / 2e-5, 1e-6 * -found);
    }
  }
  EXPECT_EQ(weakening_law(1, 0).traction<3>({-0.01, 1e-6, 0}, nullptr).by_speed, 0);
  ContactLaw on_water = weakening_law(1, 0);
  on_water.grain_share = 0;
  EXPECT_EQ(on_water.traction<3>({-1e-4, 1e-6, 0}, nullptr).by_speed, 0);
}

TEST(ContactLaw, nothing_slides_with_drag_in_no_time) {
  ContactLaw law{.friction = 0.3, .penalty = 2e5, .tangential_penalty = 1e5, .drag = 40};
  const Vector<2> gap(-0.01, 0.02);
  Matrix<2> slope;
  EXPECT_DOUBLE_EQ(law.traction<2>(gap, &slope).t[1], -1e5 * 0.02);
  EXPECT_DOUBLE_EQ(slope(1, 1), 1e5);
}

}  // namespace
}  // namespace gabion::test::test_contact_law
