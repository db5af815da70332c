// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include "tests/unit/materials/plastic_return.hpp"

namespace gabion::testing::test_mohr_coulomb_return {
namespace {

constexpr double lambda = 1.7, mu = 0.9;

double energy_distance(const Eigen::Vector3d& d) {
  const double nu = lambda / (2 * (lambda + mu)), E = 2 * mu * (1 + nu);
  return ((1 + nu) * d.squaredNorm() - nu * d.sum() * d.sum()) / E;
}

struct Case {
  double phi, psi, cohesion;
};

class MohrCoulombReturn : public ::testing::TestWithParam<Case> {
 protected:
  PrincipalMohrCoulomb law() const {
    return principal_law(MohrCoulomb<3>{lambda, mu, GetParam().phi * degree,
                                        GetParam().psi * degree, GetParam().cohesion});
  }
  struct Trial {
    Eigen::Vector3d eps, tau;
  };
  /// Sorted trial states outside the surface.
  std::vector<Trial> trials(int count) const {
    const auto constants = law();
    std::vector<Trial> list;
    for (const auto& eps : yielding_trials(count, [&](const Eigen::Vector3d& candidate) {
           return yields(constants, stress_of(constants, candidate));
         }))
      list.push_back({eps, stress_of(constants, eps)});
    return list;
  }
};

TEST_P(MohrCoulombReturn, equals_the_only_admissible_candidate) {
  const auto constants = law();
  const Eigen::Vector3d apex = Eigen::Vector3d::Constant(constants.strength / (constants.k - 1));
  int apex_count = 0;
  for (const auto& [eps, trial] : trials(8000)) {
    const auto returned = return_to_surface(constants, eps, trial);
    const Eigen::Vector3d tau = stress_of(constants, returned.eps_e);
    const double small = 1e-9 * (trial.norm() + constants.strength);
    const auto candidates = admissible_returns(constants, shear_planes(constants), trial);
    for (const auto& candidate : candidates) ASSERT_LT((tau - candidate).norm(), small);
    // with psi = 0 no flow direction changes the volume: the apex takes what nothing else can
    if (constants.m > 1) {
      ASSERT_FALSE(candidates.empty());
    }
    if (candidates.empty()) {
      ASSERT_LT((tau - apex).norm(), small);
    }
    apex_count += returned.face == YieldFace::apex;
  }
  EXPECT_GT(apex_count, 500);
}

TEST_P(MohrCoulombReturn, reaches_the_apex_only_when_both_edge_parameters_are_beyond_it) {
  const auto constants = law();
  for (const auto& [eps, trial] : trials(8000)) {
    bool both = true;
    for (const YieldFace face : {YieldFace::edge_12, YieldFace::edge_23}) {
      const ActiveFace edge = active_face(constants, face);
      const Eigen::Vector3d on_edge =
          averaged(eps, face) - edge.multiplier(constants, trial) * edge.c;
      both = both && !(on_edge[0] > on_edge[2]);
    }
    const auto face = return_to_surface(constants, eps, trial).face;
    ASSERT_EQ(face == YieldFace::apex, both);
  }
}

class AssociatedReturn : public MohrCoulombReturn {};

TEST_P(AssociatedReturn, is_the_closest_point) {
  const auto constants = law();
  const double p_apex = constants.strength / (constants.k - 1);
  Random random(23);
  for (const auto& [eps, trial] : trials(2000)) {
    const Eigen::Vector3d tau =
        stress_of(constants, return_to_surface(constants, eps, trial).eps_e);
    const double distance = energy_distance(trial - tau);
    for (int sample = 0; sample < 100; ++sample) {
      // admissible points about the result: pull a random one towards the axis until inside
      Eigen::Vector3d point = tau;
      point +=
          0.1 * trial.norm() * Eigen::Vector3d::NullaryExpr([&] { return random.uniform(-1, 1); });
      const double mean = std::min(point.mean(), p_apex);
      const Eigen::Vector3d axis = Eigen::Vector3d::Constant(mean);
      const double f_point = constants.k * point.maxCoeff() - point.minCoeff() - constants.strength;
      const double f_axis = (constants.k - 1) * mean - constants.strength;
      if (f_point > 0) point = axis + (f_axis / (f_axis - f_point)) * (point - axis);
      ASSERT_GE(energy_distance(trial - point), distance * (1 - 1e-12));
    }
  }
}

/// The tensor update agrees with the principal return, keeps axes, and is idempotent.
template <int dim>
void expect_tensor_update(const MohrCoulomb<dim>& law) {
  Random random(29);
  const auto constants = principal_law(law);
  for (int sample = 0; sample < 5000; ++sample) {
    MaterialState<dim> state_n;
    state_n.e = random.elastic_strain<dim>(0.05, random.uniform(-0.15, 0.05));
    const Matrix<dim> H = random.matrix<dim>(0.05);
    const auto out = stress<dim>(law, H, state_n);
    if (!out.plastic()) {
      ASSERT_EQ(face_of<dim>(law, H, state_n), -1);
      continue;
    }
    const Symmetric<dim> e = push_forward<dim>(H, state_n.e);
    const Eigen::Vector3d eps = trial_strain<dim>(H, state_n);
    const auto returned = return_to_surface(constants, eps, stress_of(constants, eps));
    ASSERT_LT((principal<dim>(out.tau) - stress_of(constants, returned.eps_e)).norm(), 1e-13);
    const Eigen::Matrix3d trial = full<dim>(e), tau = full<dim>(out.tau);
    ASSERT_LT((trial * tau - tau * trial).norm(), 1e-14);
    Eigen::Vector3d increment = returned.plastic;
    if (out.region == YieldRegion::apex) {
      ASSERT_NEAR(out.state.gap, increment.sum(), 1e-15);
      increment.array() -= increment.mean();
    }
    ASSERT_NEAR(out.state.plastic_strain, increment.norm(), 1e-14);

    const auto again = stress<dim>(law, Matrix<dim>::Zero(), out.state);
    ASSERT_LT((again.state.e - out.state.e).norm(), 1e-15);
    ASSERT_LT((again.tau - out.tau).norm(), 2e-15);
    // next to the apex the roundings of the trial state are above those of the small remaining
    // stress
    if (out.region == YieldRegion::apex) {
      ASSERT_NEAR(again.state.gap, out.state.gap, 1e-15);
    } else if (out.tau.norm() > 1e-3) {
      ASSERT_FALSE(again.plastic()) << "sample " << sample;
    }
  }
}

TEST_P(MohrCoulombReturn, tensor_update_agrees_and_is_idempotent) {
  const Case& c = GetParam();
  expect_tensor_update<2>({lambda, mu, c.phi * degree, c.psi * degree, c.cohesion});
  expect_tensor_update<3>({lambda, mu, c.phi * degree, c.psi * degree, c.cohesion});
}

INSTANTIATE_TEST_SUITE_P(Cases, MohrCoulombReturn,
                         ::testing::Values(Case{19.8, 0, 0}, Case{30, 10, 0}, Case{35, 35, 0},
                                           Case{19.8, 0, 0.02}, Case{30, 10, 0.02},
                                           Case{35, 35, 0.02}));
INSTANTIATE_TEST_SUITE_P(Cases, AssociatedReturn,
                         ::testing::Values(Case{35, 35, 0}, Case{35, 35, 0.02}));

TEST(MohrCoulomb, cohesionless_tension_forgets_the_elastic_strain) {
  MohrCoulombParameters sand{.lambda = lambda, .mu = mu, .friction_angle = 30 * degree};
  sand.apex_volume = ApexVolume::forget;
  MaterialState<2> state_n;
  state_n.e << -0.01, -0.02, -0.01, 0.003;
  const Matrix<2> H = 0.1 * Matrix<2>::Identity();
  const auto out = stress<2>(MohrCoulomb<2>(sand), H, state_n);
  EXPECT_EQ(out.region, YieldRegion::apex);
  EXPECT_EQ(out.state.e, Symmetric<2>(Symmetric<2>::Zero()));
  EXPECT_EQ(out.tau, Symmetric<2>(Symmetric<2>::Zero()));
  EXPECT_EQ(out.energy, 0);
  EXPECT_EQ(out.state.gap, 0);
  EXPECT_GT(out.state.plastic_strain, 0.1);
}

}  // namespace
}  // namespace gabion::testing::test_mohr_coulomb_return
