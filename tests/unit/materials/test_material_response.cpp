// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include "tests/unit/materials/random_state.hpp"

namespace gabion::testing::test_material_response {
namespace {

constexpr double lambda = 1.7e6, mu = 0.9e6, M = lambda + 2 * mu;

template <int dim>
void expect_conjugate_energy(const auto& law) {
  Random random(41);
  for (int sample = 0; sample < 100; ++sample) {
    MaterialState<dim> state_n;
    state_n.e = random.elastic_strain<dim>(0.1, 0);
    const Matrix<dim> H = random.matrix<dim>(0.2), dH = random.matrix<dim>(1e-4);
    const double gained =
        stress<dim>(law, H + dH, state_n).energy - stress<dim>(law, H - dH, state_n).energy;
    const double work = 2 * stress<dim>(law, H, state_n).P.cwiseProduct(dH).sum();
    ASSERT_NEAR(gained, work, 1e-7 * M * 1e-4);
  }
}

template <int dim>
void expect_conjugate_energies() {
  expect_conjugate_energy<dim>(LinearElastic<dim>{lambda, mu});
  expect_conjugate_energy<dim>(NeoHookean<dim>{lambda, mu});
  expect_conjugate_energy<dim>(HenckyElastic<dim>{lambda, mu});
  expect_conjugate_energy<dim>(MohrCoulomb<dim>{lambda, mu, 0.5, 0.1, 1e9});  // stays elastic
}

TEST(MaterialResponse, energy_is_work_conjugate_2d) {
  expect_conjugate_energies<2>();
}
TEST(MaterialResponse, energy_is_work_conjugate_3d) {
  expect_conjugate_energies<3>();
}

/// Turn a stressed point once around in many steps.
template <int dim>
double drift_of_a_full_turn(const auto& law, const MaterialState<dim>& start) {
  constexpr int steps = 3600;
  const double angle = 2 * std::numbers::pi / steps;
  Matrix<dim> K = Matrix<dim>::Zero();  // axis x, |axis| = 1
  if constexpr (dim == 2) {
    K << 0, -1, 1, 0;
  } else {
    K << 0, -2. / 3, 1. / 3, 2. / 3, 0, -2. / 3, -1. / 3, 2. / 3, 0;
  }
  // Rodrigues; R - 1 without taking the difference, which would leave a strain of 1e-16
  const Matrix<dim> H = std::sin(angle) * K + 2 * std::pow(std::sin(angle / 2), 2) * K * K;
  MaterialState<dim> state = start;
  for (int step = 0; step < steps; ++step) state = stress<dim>(law, H, state).state;
  const Symmetric<dim> before = stress<dim>(law, Matrix<dim>::Zero(), start).tau;
  const Symmetric<dim> after = stress<dim>(law, Matrix<dim>::Zero(), state).tau;
  return (after - before).norm() / before.norm();
}

template <int dim>
void expect_no_drift(double size) {
  Random random(43);
  MaterialState<dim> state;
  state.e = random.elastic_strain<dim>(size, -size);
  const MohrCoulomb<dim> sand{lambda, mu, 30 * degree, 0, 0};
  EXPECT_LT(drift_of_a_full_turn<dim>(NeoHookean<dim>{lambda, mu}, state), 1e-10);
  EXPECT_LT(drift_of_a_full_turn<dim>(HenckyElastic<dim>{lambda, mu}, state), 1e-10);
  Matrix<dim> H = Matrix<dim>::Zero();
  H(0, 1) = 15 * size;
  const auto yielded = stress<dim>(sand, H, state);
  EXPECT_TRUE(yielded.plastic());
  EXPECT_LT(drift_of_a_full_turn<dim>(sand, yielded.state), 1e-10);
}

TEST(MaterialResponse, rigid_rotation_leaves_the_stress) {
  for (const double size : {0.1, 1e-4, 1e-6}) {
    expect_no_drift<2>(size);
    expect_no_drift<3>(size);
  }
}

/// Shear by gamma in `steps` equal steps of the current configuration.
template <int dim>
StressUpdate<dim> sheared(const auto& law, double gamma, int steps) {
  StressUpdate<dim> out;
  Matrix<dim> H = Matrix<dim>::Zero();
  H(0, 1) = gamma / steps;
  MaterialState<dim> state;
  for (int step = 0; step < steps; ++step) {
    out = stress<dim>(law, H, state);
    state = out.state;
  }
  return out;
}

template <int dim>
void expect_closed_form_shear() {
  const int xy = 3;
  for (const double gamma : {1e-9, 0.1, 1.0, 5.0}) {
    for (const int steps : {1, 50}) {
      const auto neo = sheared<dim>(NeoHookean<dim>{lambda, mu}, gamma, steps);
      EXPECT_NEAR(neo.tau[xy], mu * gamma, 1e-12 * mu * gamma);
      EXPECT_NEAR(neo.tau[0], mu * gamma * gamma, 1e-12 * mu * gamma * (1 + gamma));
      EXPECT_NEAR(neo.tau[1], 0, 1e-12 * mu * gamma * (1 + gamma));

      const auto hencky = sheared<dim>(HenckyElastic<dim>{lambda, mu}, gamma, steps);
      const double principal_stress = 2 * mu * std::asinh(gamma / 2);
      const double root = std::sqrt(gamma * gamma + 4), small = 1e-11 * principal_stress;
      EXPECT_NEAR(hencky.tau[xy], principal_stress * 2 / root, small);
      EXPECT_NEAR(hencky.tau[0], principal_stress * gamma / root, small);
      EXPECT_NEAR(hencky.tau[1], -principal_stress * gamma / root, small);
      EXPECT_NEAR(hencky.tau[2], 0, small);
    }
  }
}

TEST(MaterialResponse, large_simple_shear_2d) {
  expect_closed_form_shear<2>();
}
TEST(MaterialResponse, large_simple_shear_3d) {
  expect_closed_form_shear<3>();
}

TEST(MaterialResponse, uniaxial_stretch_has_the_confined_modulus) {
  const double stretch = 1.3;
  Matrix<2> H = Matrix<2>::Zero();
  H(0, 0) = stretch - 1;
  const auto linear = stress<2>(LinearElastic<2>{lambda, mu}, H, {});
  EXPECT_NEAR(linear.tau[0], M * 0.3, 1e-12 * M);
  EXPECT_NEAR(linear.tau[2], lambda * 0.3, 1e-12 * M);
  const auto hencky = stress<2>(HenckyElastic<2>{lambda, mu}, H, {});
  EXPECT_NEAR(hencky.tau[0], M * std::log(stretch), 1e-12 * M);
  EXPECT_NEAR(hencky.tau[2], lambda * std::log(stretch), 1e-12 * M);
  EXPECT_NEAR(hencky.P(0, 0), M * std::log(stretch) / stretch, 1e-12 * M);
  EXPECT_NEAR(hencky.J, stretch, 1e-15);
  const auto neo = stress<2>(NeoHookean<2>{lambda, mu}, H, {});
  EXPECT_NEAR(neo.tau[0], lambda * std::log(stretch) + mu * (stretch * stretch - 1), 1e-12 * M);
  EXPECT_NEAR(neo.tau[2], lambda * std::log(stretch), 1e-12 * M);
}

const MohrCoulombParameters sand{.lambda = lambda,
                                 .mu = mu,
                                 .friction_angle = 30 * degree,
                                 .dilation_angle = 10 * degree,
                                 .cohesion = 1e4};
const DruckerPragerParameters gravel{.lambda = lambda,
                                     .mu = mu,
                                     .friction_angle = 30 * degree,
                                     .dilation_angle = 10 * degree,
                                     .cohesion = 1e4};
const TrescaParameters clay{lambda, mu, 1e4};

template <int dim>
void expect_refusal_of_inversion() {
  Matrix<dim> H = Matrix<dim>::Zero();
  H(0, 0) = -1.5;
  const double nan = std::numeric_limits<double>::quiet_NaN();
  for (const Matrix<dim>& bad : {H, Matrix<dim>(Matrix<dim>::Constant(nan))}) {
    StressUpdate<dim> out;
    Tangent<dim> A;
    EXPECT_FALSE((LinearElastic<dim>{lambda, mu}).update(bad, {}, out, &A));
    EXPECT_FALSE((NeoHookean<dim>{lambda, mu}).update(bad, {}, out, &A));
    EXPECT_FALSE((HenckyElastic<dim>{lambda, mu}).update(bad, {}, out, &A));
    EXPECT_FALSE((MohrCoulomb<dim>{lambda, mu, 0.5, 0, 0}).update(bad, {}, out, &A));
  }
}

TEST(MaterialResponse, inverted_or_undefined_steps_are_refused) {
  expect_refusal_of_inversion<2>();
  expect_refusal_of_inversion<3>();
}

/// One plastic path in plane strain and in three dimensions; returns the plastic strain.
double expect_plane_strain_equals_3d(const auto& plane, const auto& solid) {
  Random random(47);
  MaterialState<2> state2;
  MaterialState<3> state3;
  for (int step = 0; step < 200; ++step) {
    const Matrix<2> H2 = random.matrix<2>(0.01) - 0.0005 * Matrix<2>::Identity();
    Matrix<3> H3 = Matrix<3>::Zero();
    H3.topLeftCorner<2, 2>() = H2;
    const StressUpdate<2> out2 = stress<2>(plane, H2, state2);
    const StressUpdate<3> out3 = stress<3>(solid, H3, state3);
    EXPECT_EQ(out2.region, out3.region);
    EXPECT_LT((out2.tau - out3.tau.head<4>()).norm(), 1e-11 * M) << "step " << step;
    EXPECT_LT((out2.P - out3.P.topLeftCorner<2, 2>()).norm(), 1e-11 * M);
    EXPECT_NEAR(out2.energy, out3.energy, 1e-11 * M);
    state2 = out2.state;
    state3 = out3.state;
  }
  return state2.plastic_strain;
}

TEST(MaterialResponse, plane_strain_equals_three_dimensions) {
  EXPECT_GT(expect_plane_strain_equals_3d(MohrCoulomb<2>(sand), MohrCoulomb<3>(sand)), 0.02);
  EXPECT_GT(expect_plane_strain_equals_3d(DruckerPrager<2>(gravel), DruckerPrager<3>(gravel)),
            0.02);
  EXPECT_GT(expect_plane_strain_equals_3d(Tresca<2>(clay), Tresca<3>(clay)), 0.02);
}

/// Turning the frame of the step turns the stress, and changes nothing else.
template <int dim>
void expect_isotropy(const auto& law) {
  Random random(61);
  for (int sample = 0; sample < 200; ++sample) {
    MaterialState<dim> state_n, turned_n;
    state_n.e = random.elastic_strain<dim>(0.05, random.uniform(-0.1, 0.05));
    const Matrix<dim> H = random.matrix<dim>(0.1), R = random.rotation<dim>();
    turned_n.e = symmetric<dim>(R * in_plane<dim>(state_n.e) * R.transpose());
    if constexpr (dim == 2) turned_n.e[2] = state_n.e[2];
    const auto out = stress<dim>(law, H, state_n);
    const auto turned = stress<dim>(law, R * H * R.transpose(), turned_n);
    ASSERT_EQ(turned.region, out.region);
    ASSERT_LT((turned.P - R * out.P * R.transpose()).norm(), 1e-13 * M);
    ASSERT_NEAR(turned.state.plastic_strain, out.state.plastic_strain, 1e-13);
  }
}

TEST(MaterialResponse, plastic_laws_are_isotropic) {
  expect_isotropy<2>(MohrCoulomb<2>(sand));
  expect_isotropy<3>(MohrCoulomb<3>(sand));
  expect_isotropy<2>(DruckerPrager<2>(gravel));
  expect_isotropy<3>(DruckerPrager<3>(gravel));
  expect_isotropy<2>(Tresca<2>(clay));
  expect_isotropy<3>(Tresca<3>(clay));
}

}  // namespace
}  // namespace gabion::testing::test_material_response
