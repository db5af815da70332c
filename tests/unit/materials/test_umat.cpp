// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include <cmath>
#include <filesystem>

#include "common/mechanics/materials/read_umat.hpp"
#include "common/mechanics/materials/umat_model.hpp"
#include "common/mechanics/materials/umat_state.hpp"
#include "tests/support/expect_error.hpp"
#include "tests/unit/materials/random_state.hpp"

namespace gabion::testing::test_umat {
namespace {

using test::expect_error;

constexpr double lambda = 2e6, mu = 1e6, M = lambda + 2 * mu;
const double phi = 0.6, psi = 0.1, c = 5e3;
const std::vector<double> soil = {lambda, mu, phi, psi, c};

UmatSettings settings(const std::string& library, std::vector<double> constants,
                      std::size_t num_variables = 0) {
  return {.where = "mpm.json: /bodies/0/material",
          .library = library,
          .name = "SOIL",
          .constants = std::move(constants),
          .initial_variables = std::vector<double>(num_variables, 0.0)};
}
template <int dim>
Umat<dim> umat(const std::string& library, std::vector<double> constants,
               std::size_t num_variables = 0) {
  return Umat<dim>(std::make_shared<const UmatModel>(
      settings(library, std::move(constants), num_variables), dim));
}
template <int dim>
Umat<dim> mohr_coulomb() {
  return umat<dim>(UMAT_MOHR_COULOMB, soil, 2);
}
template <int dim>
Umat<dim> von_mises(double hardening = 1e5) {
  return umat<dim>(UMAT_VON_MISES, {2.6e6, 0.3, 2e4, hardening}, 1);
}

/// State that a point keeps from call to call.
using Memory = std::array<double, umat_state_size>;

/// One accepted increment.
template <int dim>
StressUpdate<dim> advance(const Umat<dim>& law, const Matrix<dim>& H, Memory& memory) {
  StressUpdate<dim> out;
  Memory next;
  EXPECT_TRUE(
      law.update({.dt = 0.1, .variables = memory, .new_variables = next}, H, {}, out, nullptr));
  memory = next;
  return out;
}
template <int dim>
Memory start(const Umat<dim>& law) {
  Memory memory;
  law.set_start(memory);
  return memory;
}

template <int dim>
void expect_native_stresses() {
  const MohrCoulomb<dim> native(lambda, mu, phi, psi, c);
  const Umat<dim> law = mohr_coulomb<dim>();
  Random random(3);
  Memory memory = start(law);
  MaterialState<dim> state;
  double J = 1;
  int yields = 0;
  for (int n = 0; n < 40; ++n) {
    const Matrix<dim> F = (Matrix<dim>::Identity() + random.matrix<dim>(0.02)) *
                          (n % 3 ? Matrix<dim>(Matrix<dim>::Identity()) : random.rotation<dim>());
    const Matrix<dim> H = F - Matrix<dim>::Identity();
    StressUpdate<dim> expected;
    ASSERT_TRUE(native.update(H, state, expected, nullptr));
    const StressUpdate<dim> found = advance<dim>(law, H, memory);
    J *= expected.J;
    EXPECT_LT((found.tau - expected.tau).norm(), 1e-9 * (c + expected.tau.norm())) << n;
    EXPECT_LT((found.P - expected.P).norm(), 1e-9 * (c + expected.tau.norm())) << n;
    EXPECT_NEAR(found.J, expected.J, 1e-14);
    EXPECT_NEAR(memory[UmatState::first_variable], expected.state.plastic_strain, 1e-11) << n;
    yields += expected.plastic();
    state = expected.state;
  }
  EXPECT_GT(yields, 5);
  EXPECT_LT(yields, 40);
  const Eigen::Matrix3d F = Eigen::Matrix3d::Identity() + UmatState(memory).displacement_gradient();
  EXPECT_NEAR(F.determinant(), J, 1e-12);
  EXPECT_NEAR(UmatState(memory).time(), 4, 1e-12);
  EXPECT_EQ(UmatState(memory).count(), 40);
}
TEST(Umat, mohr_coulomb_has_the_stresses_of_the_native_law) {
  expect_native_stresses<2>();
  expect_native_stresses<3>();
}

template <int dim>
void expect_tangent(const Umat<dim>& law, double tolerance) {
  Random random(7);
  Memory memory = start(law);
  advance<dim>(law, random.matrix<dim>(1e-3), memory);  // elastic
  for (int sample = 0; sample < 20; ++sample) {
    const Matrix<dim> R = sample % 2 ? random.rotation<dim>() : Matrix<dim>::Identity();
    const Matrix<dim> H =
        (Matrix<dim>::Identity() + random.matrix<dim>(sample < 2 ? 1e-9 : 0.05)) * R -
        Matrix<dim>::Identity();
    const auto stress = [&](const Matrix<dim>& at) {
      StressUpdate<dim> out;
      EXPECT_TRUE(law.update({.dt = 0.1, .variables = memory}, at, {}, out, nullptr));
      return out.P;
    };
    StressUpdate<dim> out;
    Tangent<dim> A;
    ASSERT_TRUE(law.update({.dt = 0.1, .variables = memory}, H, {}, out, &A));
    constexpr double step = 1e-6;
    for (int column = 0; column < dim * dim; ++column) {
      Matrix<dim> up = H, down = H;
      up(column / dim, column % dim) += step;
      down(column / dim, column % dim) -= step;
      const Matrix<dim> slope = (stress(up) - stress(down)) / (2 * step);
      for (int row = 0; row < dim * dim; ++row) {
        EXPECT_NEAR(A(row, column), slope(row / dim, row % dim), tolerance * M) << sample;
      }
    }
  }
}
TEST(Umat, tangent_is_the_derivative_of_the_stress) {
  expect_tangent<2>(von_mises<2>(), 1e-7);
  expect_tangent<3>(von_mises<3>(), 1e-7);
  expect_tangent<3>(umat<3>(UMAT_FAULTY, {0}), 1e-7);
  expect_tangent<3>(umat<3>(UMAT_FAULTY, {4}), 1e-7);  // a tangent of J sigma
  expect_tangent<2>(umat<2>(UMAT_FAULTY, {4}), 1e-7);
}

TEST(Umat, finds_what_the_tangent_is_the_derivative_of) {
  EXPECT_EQ(UmatModel(settings(UMAT_FAULTY, {0}), 3).tangent(), UmatTangent::cauchy);
  EXPECT_EQ(UmatModel(settings(UMAT_FAULTY, {4}), 3).tangent(), UmatTangent::kirchhoff);
  EXPECT_EQ(UmatModel(settings(UMAT_FAULTY, {4}), 2).tangent(), UmatTangent::kirchhoff);
  EXPECT_EQ(UmatModel(settings(UMAT_VON_MISES, {2.6e6, 0.3, 2e4, 1e5}, 1), 3).tangent(),
            UmatTangent::cauchy);
}

TEST(Umat, moduli_are_those_of_virgin_soil) {
  EXPECT_NEAR(von_mises<3>().shear_modulus(), 1e6, 1e-6);
  EXPECT_NEAR(von_mises<2>().p_wave_modulus(), 1.5e6 + 2e6, 1e-6);
  EXPECT_NEAR(umat<3>(UMAT_FAULTY, {5}).p_wave_modulus(), 4e6, 1e-6);  // the stiffest axis
}

/// Simple shear by an angle gamma, as stress: elastic up to Y / sqrt 3, then by h mu / (3 mu + h).
TEST(Umat, von_mises_yields_and_hardens_in_shear) {
  const double Y = 2e4, h = 1e5, shear_modulus = 1e6;
  const UmatModel model(settings(UMAT_VON_MISES, {2.6e6, 0.3, Y, h}, 1), 2);
  for (const double gamma : {0.001, 0.05}) {
    UmatCall call{.variables = model.initial_variables(), .dt = 1};
    call.increment[3] = gamma / 2;
    const double elastic = shear_modulus * gamma, yield = Y / std::sqrt(3.0);
    const double expected =
        elastic < yield ? elastic : yield + (elastic - yield) * h / (3 * shear_modulus + h);
    EXPECT_NEAR(model.call(call).stress[3], expected, 1e-9 * Y);
  }
}

/// A rotation after a strain turns the stress, and changes nothing else.
TEST(Umat, a_rotation_turns_the_stress) {
  const Umat<3> law = von_mises<3>();
  Random random(11);
  Memory memory = start(law);
  const StressUpdate<3> before = advance<3>(law, random.matrix<3>(0.05), memory);
  const Matrix<3> R = random.rotation<3>();
  const StressUpdate<3> after = advance<3>(law, R - Matrix<3>::Identity(), memory);
  const Matrix<3> turned = R * in_plane<3>(before.tau) * R.transpose();
  EXPECT_LT((in_plane<3>(after.tau) - turned).norm(), 1e-12 * turned.norm());
  EXPECT_FALSE(after.plastic());
}

/// Work of the stresses less the stored energy is what the ledger takes for dissipated.
TEST(Umat, dissipated_work_closes_the_balance) {
  const Umat<2> law = von_mises<2>();
  Random random(5);
  Memory memory = start(law);
  Symmetric<2> tau = Symmetric<2>::Zero();
  double work = 0, dissipated = 0, energy = 0;
  for (int n = 0; n < 10; ++n) {
    const Matrix<2> H = random.matrix<2>(1e-4);
    const StressUpdate<2> out = advance<2>(law, H, memory);
    const Symmetric<2> mean = 0.5 * (tau + out.tau);
    const Matrix<2> d = 0.5 * (H + H.transpose());
    work += mean[0] * d(0, 0) + mean[1] * d(1, 1) + 2 * mean[3] * d(0, 1);
    dissipated += contract<2>(mean, out.plastic_increment);
    tau = out.tau;
    energy = out.energy;
  }
  EXPECT_NEAR(work, dissipated + energy, 1e-3 * std::abs(work));
}

/// A stress that the soil starts with stays where nothing moves.
TEST(Umat, starts_with_a_stress) {
  const Umat<2> law = von_mises<2>();
  Memory memory;
  const Symmetric<2> tau = {-1e3, -2e3, -1e3, 0}, strain = {-1e-4, -1e-3, -1e-4, 0};
  law.set_start(tau, strain, memory);
  const StressUpdate<2> out = advance<2>(law, Matrix<2>::Zero(), memory);
  EXPECT_LT((out.tau - tau).norm(), 1e-12 * tau.norm());
  EXPECT_NEAR(out.J, 1, 1e-15);
}

TEST(Umat, the_same_strain_in_all_directions) {
  const Umat<2> law = von_mises<2>();
  Memory memory = start(law), next;
  StressUpdate<2> out;
  ASSERT_TRUE(law.strain_evenly({.variables = memory, .new_variables = next}, 3e-5, out));
  const double bulk = 2.6e6 / (3 * 0.4);
  for (int i = 0; i < 3; ++i) EXPECT_NEAR(out.tau[i], bulk * 3e-5, 1e-4 * bulk * 3e-5);
  EXPECT_NEAR(out.J, std::exp(3e-5), 1e-15);
}

/// Subroutines that set STATEV in their first increment do so where the soil has a stress too.
TEST(Umat, the_increment_with_the_initial_stress_is_the_first) {
  const Umat<2> law = von_mises<2>();
  Memory memory;
  law.set_start(Symmetric<2>{-1e3, -2e3, -1e3, 0}, Symmetric<2>{-1e-4, -1e-3, -1e-4, 0}, memory);
  EXPECT_EQ(UmatState(memory).count(), 0);
  advance<2>(law, Matrix<2>::Zero(), memory);
  EXPECT_EQ(UmatState(memory).count(), 1);
}

TEST(Umat, too_few_constants_or_variables_are_named) {
  const auto refused = [](std::vector<double> constants, std::size_t variables,
                          std::string_view part) {
    for (const int dim : {2, 3}) {
      expect_error<ConfigError>(
          [&] { UmatModel(settings(UMAT_VON_MISES, constants, variables), dim); }, {part});
    }
  };
  refused({}, 1, "material/constants: found 0 numbers");
  refused({2.6e6, 0.3, 2e4}, 1, "material/constants: found 3 numbers");
  refused({2.6e6, 0.3, 2e4, 1e5}, 0, "material/initial_variables: found 0 numbers");
  EXPECT_NO_THROW(UmatModel(settings(UMAT_VON_MISES, {2.6e6, 0.3, 2e4, 1e5, 7}, 2), 3));
}

TEST(Umat, a_step_that_is_too_long_is_refused) {
  const Umat<2> law = umat<2>(UMAT_FAULTY, {6});
  StressUpdate<2> out;
  const Matrix<2> H = Eigen::Vector2d(0.1, 0).asDiagonal();
  EXPECT_FALSE(law.update({.dt = 1}, H, {}, out, nullptr));
  EXPECT_EQ(out.refusal, Refusal::unsolved);
  EXPECT_TRUE(law.update({.dt = 1}, 0.1 * H, {}, out, nullptr));
  EXPECT_FALSE(law.update({.dt = 1}, -20 * H, {}, out, nullptr));
  EXPECT_EQ(out.refusal, Refusal::squeezed);
}

TEST(Umat, libraries_with_faults_are_named) {
  const auto refused = [](const std::string& library, double fault, std::string_view part) {
    expect_error<ConfigError>([&] { UmatModel(settings(library, {fault}), 3); }, {part});
  };
  refused(UMAT_FAULTY, 1, "not finite");
  refused(UMAT_FAULTY, 2, "two answers of the UMAT");
  refused("/nowhere/lib.so", 0, "/bodies/0/material/library: found /nowhere/lib.so");
  refused(UMAT_WITHOUT, 0, "without any of umat_, umat, UMAT");
  refused(__FILE__, 0, "cannot be loaded");
}

#ifdef UMAT_LINEAR_ELASTIC
/// A routine in Fortran, with the hidden length of its name.
TEST(Umat, linear_elastic_in_fortran) {
  const UmatModel model(settings(UMAT_LINEAR_ELASTIC, {2.6e6, 0.3}), 3);
  UmatCall call{.dt = 1};
  call.increment << 1e-3, 0, 0, 2e-3, 3e-3, -1e-3;
  const UmatAnswer answer = model.call(call);
  UmatCall::Vector6 expected;
  expected << 3.5e3, 1.5e3, 1.5e3, 4e3, 6e3, -2e3;
  EXPECT_LT((answer.stress - expected).norm(), 1e-9);
  EXPECT_NEAR(answer.energy, 0.5 * (3.5 + 2 * (8 + 18 + 2)), 1e-9);
}
#endif

}  // namespace
}  // namespace gabion::testing::test_umat
