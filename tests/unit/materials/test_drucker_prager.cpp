// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include <limits>

#include "tests/unit/materials/plastic_return.hpp"

namespace gabion::testing::test_drucker_prager {
namespace {

constexpr double lambda = 1.7, mu = 0.9;

struct Case {
  double phi, psi, cohesion;
  ConeMatch match;
};

class DruckerPragerReturn : public ::testing::TestWithParam<Case> {
 protected:
  DruckerPragerParameters parameters() const {
    return {.lambda = lambda,
            .mu = mu,
            .friction_angle = GetParam().phi * degree,
            .dilation_angle = GetParam().psi * degree,
            .cohesion = GetParam().cohesion,
            .match = GetParam().match};
  }
  static double f(const PrincipalDruckerPrager& cone, const Eigen::Vector3d& tau) {
    const double p = tau.mean();
    return shear_size((tau.array() - p).matrix()) + cone.eta * p - cone.strength;
  }
  std::vector<Eigen::Vector3d> trials(const PrincipalDruckerPrager& cone, int count) const {
    return yielding_trials(
        count, [&](const Eigen::Vector3d& eps) { return f(cone, stress_of(cone, eps)) > 0; });
  }
};

/// On the cone the plastic strain is a positive multiple of the flow direction there; at the apex
/// no multiplier brings the trial state to the cone.
TEST_P(DruckerPragerReturn, satisfies_the_kuhn_tucker_conditions) {
  const auto cone = cone_constants(parameters());
  const double p_apex = cone.strength / cone.eta;
  std::array<int, 2> count = {0, 0};
  for (const auto& eps : trials(cone, 20000)) {
    const Eigen::Vector3d trial = stress_of(cone, eps);
    const auto returned = return_to_cone(cone, eps, trial);
    const Eigen::Vector3d tau = stress_of(cone, returned.eps_e);
    const double size = trial.norm() + cone.strength;
    ASSERT_NEAR(f(cone, tau), 0, 1e-14 * size);
    const double p_trial = trial.mean();
    const Eigen::Vector3d s_trial = (trial.array() - p_trial).matrix();
    // f along the return, sqrt(J2) allowed to pass zero: its root is the cone, if sqrt(J2) > 0
    // there
    const double multiplier = f(cone, trial) / (cone.mu + cone.bulk() * cone.eta * cone.eta_bar);
    const bool reaches_cone = shear_size(s_trial) - cone.mu * multiplier > 0;
    ASSERT_EQ(returned.region == YieldRegion::shear, reaches_cone);
    ++count[reaches_cone];
    if (!reaches_cone) {
      ASSERT_LT((tau.array() - p_apex).matrix().norm(), 1e-14 * size);
      continue;
    }
    const Eigen::Vector3d s = (tau.array() - tau.mean()).matrix();
    const Eigen::Vector3d flow = (s.array() / (2 * shear_size(s)) + cone.eta_bar / 3).matrix();
    ASSERT_LT((eps - returned.eps_e - multiplier * flow).norm(), 1e-10);
    ASSERT_GT(multiplier, 0);
    ASSERT_NEAR(returned.plastic.sum(), cone.eta_bar * multiplier, 1e-15);
  }
  EXPECT_GT(count[0], 500);
  EXPECT_GT(count[1], 500);
}

double energy_distance(const Eigen::Vector3d& d) {
  const double nu = lambda / (2 * (lambda + mu)), E = 2 * mu * (1 + nu);
  return ((1 + nu) * d.squaredNorm() - nu * d.sum() * d.sum()) / E;
}

class AssociatedCone : public DruckerPragerReturn {};

TEST_P(AssociatedCone, returns_to_the_closest_point) {
  const auto cone = cone_constants(parameters());
  const double p_apex = cone.strength / cone.eta;
  Random random(23);
  for (const auto& eps : trials(cone, 2000)) {
    const Eigen::Vector3d trial = stress_of(cone, eps);
    const Eigen::Vector3d tau = stress_of(cone, return_to_cone(cone, eps, trial).eps_e);
    const double distance = energy_distance(trial - tau);
    for (int sample = 0; sample < 50; ++sample) {
      Eigen::Vector3d point = tau;
      point +=
          0.1 * trial.norm() * Eigen::Vector3d::NullaryExpr([&] { return random.uniform(-1, 1); });
      const double p = std::min(point.mean(), p_apex);
      const Eigen::Vector3d s = (point.array() - point.mean()).matrix();
      const double root = shear_size(s), allowed = cone.strength - cone.eta * p;
      point = ((root > allowed ? allowed / root : 1) * s.array() + p).matrix();
      ASSERT_GE(energy_distance(trial - point), distance * (1 - 1e-12) - 1e-16);
    }
  }
}

/// The tensor update agrees with the principal return, keeps axes, and is idempotent.
template <int dim>
void expect_tensor_update(const DruckerPrager<dim>& law) {
  Random random(29);
  for (int sample = 0; sample < 2000; ++sample) {
    MaterialState<dim> state_n;
    state_n.e = random.elastic_strain<dim>(0.05, random.uniform(-0.15, 0.05));
    const Matrix<dim> H = random.matrix<dim>(0.05);
    const auto out = stress<dim>(law, H, state_n);
    ASSERT_EQ(out.plastic(), face_of<dim>(law, H, state_n) != -1);
    if (!out.plastic()) continue;
    const Eigen::Vector3d eps = trial_strain<dim>(H, state_n);
    const auto returned = return_to_cone(law.cone(), eps, stress_of(law.cone(), eps));
    ASSERT_EQ(out.region, returned.region);
    ASSERT_LT((principal<dim>(out.tau) - stress_of(law.cone(), returned.eps_e)).norm(), 1e-13);
    const Eigen::Matrix3d trial = full<dim>(push_forward<dim>(H, state_n.e));
    const Eigen::Matrix3d tau = full<dim>(out.tau);
    ASSERT_LT((trial * tau - tau * trial).norm(), 1e-14);
    const auto again = stress<dim>(law, Matrix<dim>::Zero(), out.state);
    ASSERT_LT((again.state.e - out.state.e).norm(), 1e-15);
    // Strains are kept to a few units of the round-off of 1; the moduli make stresses of them.
    ASSERT_LT((again.tau - out.tau).norm(),
              4 * std::numeric_limits<double>::epsilon() * (3 * lambda + 2 * mu));
  }
}

TEST_P(DruckerPragerReturn, tensor_update_agrees_and_is_idempotent) {
  expect_tensor_update<2>(DruckerPrager<2>(parameters()));
  expect_tensor_update<3>(DruckerPrager<3>(parameters()));
}

INSTANTIATE_TEST_SUITE_P(Cases, DruckerPragerReturn,
                         ::testing::Values(Case{19.8, 0, 0, ConeMatch::plane_strain},
                                           Case{30, 10, 0.02, ConeMatch::plane_strain},
                                           Case{35, 35, 0, ConeMatch::compression},
                                           Case{30, 10, 0, ConeMatch::extension},
                                           Case{35, 35, 0.02, ConeMatch::plane_strain}));
INSTANTIATE_TEST_SUITE_P(Cases, AssociatedCone,
                         ::testing::Values(Case{35, 35, 0, ConeMatch::plane_strain},
                                           Case{35, 35, 0.02, ConeMatch::compression}));

/// The outer and inner cones touch the edges of the Mohr-Coulomb pyramid.
TEST(DruckerPrager, triaxial_cones_meet_the_edges_of_mohr_coulomb) {
  const double phi = 30 * degree, c = 0.02, k = 3;
  for (const double lateral : {-0.1, -1.0}) {
    const double axial_compression = k * lateral - 2 * c * std::sqrt(k);
    const double axial_extension = (lateral + 2 * c * std::sqrt(k)) / k;
    const auto f = [&](ConeMatch match, double axial) {
      const auto cone = cone_constants({.lambda = lambda,
                                        .mu = mu,
                                        .friction_angle = phi,
                                        .dilation_angle = 0,
                                        .cohesion = c,
                                        .match = match});
      return std::abs(axial - lateral) / std::sqrt(3.0) + cone.eta * (axial + 2 * lateral) / 3 -
             cone.strength;
    };
    EXPECT_NEAR(f(ConeMatch::compression, axial_compression), 0, 1e-15);
    EXPECT_NEAR(f(ConeMatch::extension, axial_extension), 0, 1e-15);
  }
}

/// For psi = phi the plane strain match is 3 tan phi / sqrt(9 + 12 tan^2 phi) (Drucker and Prager).
TEST(DruckerPrager, associated_plane_strain_match_is_the_classical_one) {
  const double phi = 30 * degree, tan_phi = std::tan(phi), c = 0.02;
  const auto cone = cone_constants(
      {.lambda = lambda, .mu = mu, .friction_angle = phi, .dilation_angle = phi, .cohesion = c});
  const double root = std::sqrt(9 + 12 * tan_phi * tan_phi);
  EXPECT_NEAR(cone.eta, 3 * tan_phi / root, 1e-15);
  EXPECT_NEAR(cone.eta_bar, 3 * tan_phi / root, 1e-15);
  EXPECT_NEAR(cone.strength, 3 * c / root, 1e-15);
}

}  // namespace
}  // namespace gabion::testing::test_drucker_prager
