// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include <Eigen/LU>
#include <limits>
#include <vector>

#include "tests/unit/materials/random_state.hpp"

namespace gabion::testing {
namespace {

constexpr double lambda = 1.7, mu = 0.9;

/// The six planes k t_i - t_j = strength of unsorted principal stresses and their flow directions.
struct Planes {
  std::vector<Eigen::Vector3d> a, b;
};

Planes all_planes(const PrincipalMohrCoulomb& law) {
  Planes planes;
  for (int i = 0; i < 3; ++i) {
    for (int j = 0; j < 3; ++j) {
      if (i == j) continue;
      planes.a.push_back(law.k * Eigen::Vector3d::Unit(i) - Eigen::Vector3d::Unit(j));
      planes.b.push_back(law.m * Eigen::Vector3d::Unit(i) - Eigen::Vector3d::Unit(j));
    }
  }
  return planes;
}

/// Every stress on one or two planes with non-negative multipliers and no plane exceeded.
std::vector<Eigen::Vector3d> admissible_returns(const PrincipalMohrCoulomb& law,
                                                const Eigen::Vector3d& trial) {
  const Planes planes = all_planes(law);
  Eigen::Matrix3d C = Eigen::Matrix3d::Constant(law.lambda);
  C.diagonal().array() += 2 * law.mu;
  const double small = 1e-10 * (trial.norm() + law.strength);
  std::vector<Eigen::Vector3d> found;
  const auto keep_if_admissible = [&](const Eigen::Vector3d& tau, double least_multiplier) {
    if (least_multiplier < -small) return;
    for (const auto& a : planes.a)
      if (a.dot(tau) - law.strength > small) return;
    found.push_back(tau);
  };
  for (std::size_t p = 0; p < 6; ++p) {
    const Eigen::Vector3d Cb_p = C * planes.b[p];
    const double f_p = planes.a[p].dot(trial) - law.strength;
    const double multiplier = f_p / planes.a[p].dot(Cb_p);
    keep_if_admissible(trial - multiplier * Cb_p, multiplier);
    for (std::size_t q = p + 1; q < 6; ++q) {
      const Eigen::Vector3d Cb_q = C * planes.b[q];
      Eigen::Matrix2d system;
      system << planes.a[p].dot(Cb_p), planes.a[p].dot(Cb_q), planes.a[q].dot(Cb_p),
          planes.a[q].dot(Cb_q);
      if (std::abs(system.determinant()) < 1e-9) continue;
      const Eigen::Vector2d f{f_p, planes.a[q].dot(trial) - law.strength};
      const Eigen::Vector2d multipliers = system.inverse() * f;
      keep_if_admissible(trial - multipliers[0] * Cb_p - multipliers[1] * Cb_q,
                         multipliers.minCoeff());
    }
  }
  return found;
}

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
    Random random(17);
    std::vector<Trial> list;
    while (static_cast<int>(list.size()) < count) {
      Eigen::Vector3d eps = Eigen::Vector3d::NullaryExpr([&] { return random.uniform(-0.1, 0.1); });
      eps.array() += random.uniform(-0.1, 0.1);
      std::sort(eps.data(), eps.data() + 3, std::greater<>());
      const Eigen::Vector3d tau = (lambda * eps.sum() + 2 * mu * eps.array()).matrix();
      if (law().k * tau[0] - tau[2] > law().strength) list.push_back({eps, tau});
    }
    return list;
  }
};

Eigen::Vector3d stress_of(const Eigen::Vector3d& eps) {
  return (lambda * eps.sum() + 2 * mu * eps.array()).matrix();
}

TEST_P(MohrCoulombReturn, EqualsTheOnlyAdmissibleCandidate) {
  const auto constants = law();
  const Eigen::Vector3d apex = Eigen::Vector3d::Constant(constants.strength / (constants.k - 1));
  int apex_count = 0;
  for (const auto& [eps, trial] : trials(20000)) {
    const auto returned = return_to_surface(constants, eps, trial);
    const Eigen::Vector3d tau = stress_of(returned.eps_e);
    const double small = 1e-9 * (trial.norm() + constants.strength);
    const auto candidates = admissible_returns(constants, trial);
    for (const auto& candidate : candidates) ASSERT_LT((tau - candidate).norm(), small);
    if (candidates.empty()) {
      ASSERT_LT((tau - apex).norm(), small);
      ++apex_count;
    }
  }
  EXPECT_GT(apex_count, 500);
}

TEST_P(MohrCoulombReturn, ReachesTheApexOnlyWhenBothEdgeParametersAreBeyondIt) {
  const auto constants = law();
  for (const auto& [eps, trial] : trials(20000)) {
    bool both = true;
    for (const YieldRegion region : {YieldRegion::edge_12, YieldRegion::edge_23}) {
      const ActiveFace edge = active_face(constants, region);
      const Eigen::Vector3d on_edge =
          averaged(eps, region) - edge.multiplier(constants, trial) * edge.c;
      both = both && !(on_edge[0] > on_edge[2]);
    }
    const auto region = return_to_surface(constants, eps, trial).region;
    ASSERT_EQ(region == YieldRegion::apex, both);
  }
}

class AssociatedReturn : public MohrCoulombReturn {};

TEST_P(AssociatedReturn, IsTheClosestPoint) {
  const auto constants = law();
  const double p_apex = constants.strength / (constants.k - 1);
  Random random(23);
  for (const auto& [eps, trial] : trials(2000)) {
    const Eigen::Vector3d tau = stress_of(return_to_surface(constants, eps, trial).eps_e);
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
    if (!out.plastic) {
      ASSERT_EQ(region_of<dim>(law, H, state_n), -1);
      continue;
    }
    const Symmetric<dim> e = push_forward<dim>(H, state_n.e);
    const Eigen::Vector3d eps =
        principal<dim>(e).unaryExpr([](double x) { return 0.5 * std::log1p(x); });
    const auto returned = return_to_surface(constants, eps, stress_of(eps));
    ASSERT_LT((principal<dim>(out.tau) - stress_of(returned.eps_e)).norm(), 1e-13);
    const Eigen::Matrix3d trial = full<dim>(e), tau = full<dim>(out.tau);
    ASSERT_LT((trial * tau - tau * trial).norm(), 1e-14);
    ASSERT_NEAR(out.state.plastic_strain, returned.plastic.norm(), 1e-14);

    const auto again = stress<dim>(law, Matrix<dim>::Zero(), out.state);
    ASSERT_LT((again.state.e - out.state.e).norm(), 1e-15);
    ASSERT_LT((again.tau - out.tau).norm(), 2e-15);
    // next to the apex the roundings of the trial state are above those of the small remaining
    // stress
    if (out.tau.norm() > 1e-3) {
      ASSERT_FALSE(again.plastic) << "sample " << sample;
    }
  }
}

TEST_P(MohrCoulombReturn, TensorUpdateAgreesAndIsIdempotent) {
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

TEST(MohrCoulomb, CohesionlessTensionForgetsTheElasticStrain) {
  const MohrCoulomb<2> sand{lambda, mu, 30 * degree, 0, 0};
  MaterialState<2> state_n;
  state_n.e << -0.01, -0.02, -0.01, 0.003;
  const Matrix<2> H = 0.1 * Matrix<2>::Identity();
  const auto out = stress<2>(sand, H, state_n);
  EXPECT_TRUE(out.plastic);
  EXPECT_EQ(out.state.e, Symmetric<2>(Symmetric<2>::Zero()));
  EXPECT_EQ(out.tau, Symmetric<2>(Symmetric<2>::Zero()));
  EXPECT_EQ(out.energy, 0);
  EXPECT_GT(out.state.plastic_strain, 0.1);
}

}  // namespace
}  // namespace gabion::testing
