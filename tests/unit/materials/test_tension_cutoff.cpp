// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include "tests/unit/materials/plastic_return.hpp"
#include "tests/unit/materials/plastic_tangent.hpp"

namespace gabion::testing::test_tension_cutoff {
namespace {

constexpr double lambda = 1.7, mu = 0.9, M = lambda + 2 * mu, cohesion = 0.05;

struct Case {
  double phi, psi;  // [deg]; phi = 0 is Tresca
  double cutoff;    // [Pa]
};

class TensionCutoff : public ::testing::TestWithParam<Case> {
 protected:
  MohrCoulombParameters sand() const {
    return {.lambda = lambda,
            .mu = mu,
            .friction_angle = GetParam().phi * degree,
            .dilation_angle = GetParam().psi * degree,
            .cohesion = cohesion,
            .tension_cutoff = GetParam().cutoff};
  }
  TrescaParameters clay() const {
    return {.lambda = lambda, .mu = mu, .cohesion = cohesion, .tension_cutoff = GetParam().cutoff};
  }
  bool is_tresca() const { return GetParam().phi == 0; }
};

bool exceeds(const PrincipalMohrCoulomb& law, double T, const Eigen::Vector3d& tau) {
  return yields(law, tau) || tau[0] > T;
}

/// -1 elastic, otherwise the YieldFace of a step.
template <int dim>
int face_with_cutoff(const auto& law, const Matrix<dim>& H, const MaterialState<dim>& state_n) {
  const auto constants = principal_law(law);
  const double T = law.parameters().tension_cutoff;
  const Eigen::Vector3d eps = trial_strain<dim>(H, state_n), tau = stress_of(constants, eps);
  if (!exceeds(constants, T, tau)) return -1;
  const auto shear = [&](const PrincipalMohrCoulomb&, const Eigen::Vector3d& e,
                         const Eigen::Vector3d& t) { return principal_return(law, e, t); };
  return static_cast<int>(return_to_cut_off(constants, T, eps, tau, shear).face);
}

/// Compare with every state that satisfies the Kuhn-Tucker conditions of the nine planes; returns
/// samples per face.
template <auto ShearReturn>
std::map<int, int> expect_only_admissible(const PrincipalMohrCoulomb& law, double T) {
  auto planes = shear_planes(law);
  for (int i = 0; i < 3; ++i)
    planes.push_back({Eigen::Vector3d::Unit(i), Eigen::Vector3d::Unit(i), T});
  std::map<int, int> count;
  for (const auto& eps : yielding_trials(4000, [&](const Eigen::Vector3d& candidate) {
         return exceeds(law, T, stress_of(law, candidate));
       })) {
    const Eigen::Vector3d trial = stress_of(law, eps);
    const auto returned = return_to_cut_off(law, T, eps, trial, ShearReturn);
    const Eigen::Vector3d tau = stress_of(law, returned.eps_e);
    const auto candidates = admissible_returns(law, planes, trial);
    EXPECT_FALSE(candidates.empty());
    for (const auto& candidate : candidates) {
      EXPECT_LT((tau - candidate).norm(), 1e-9 * (trial.norm() + law.strength))
          << "face " << static_cast<int>(returned.face);
    }
    if (::testing::Test::HasFailure()) break;
    ++count[static_cast<int>(returned.face)];
  }
  return count;
}

void expect_every_face(std::map<int, int> count, int least, bool elastic) {
  for (int face = elastic ? -1 : 0; face <= static_cast<int>(YieldFace::corner_23); ++face) {
    if (face == static_cast<int>(YieldFace::apex)) {
      EXPECT_EQ(count[face], 0);
    } else {
      EXPECT_GE(count[face], least) << "face " << face;
    }
  }
}

TEST_P(TensionCutoff, return_equals_the_only_admissible_candidate) {
  const double T = GetParam().cutoff;
  expect_every_face(
      is_tresca()
          ? expect_only_admissible<return_to_tresca>(principal_law(Tresca<3>(clay())), T)
          : expect_only_admissible<return_to_surface>(principal_law(MohrCoulomb<3>(sand())), T),
      10, false);
}

template <int dim>
std::map<int, int> compare(const auto& law, double largest_gap, int samples) {
  const auto face = [&](const Matrix<dim>& H, const MaterialState<dim>& state_n) {
    return face_with_cutoff<dim>(law, H, state_n);
  };
  return compare_plastic_tangent<dim>(law, face, 0.1, samples, largest_gap);
}

template <int dim>
void expect_exact_tangents(const auto& law) {
  expect_every_face(compare<dim>(law, 0, 6000), 3, true);
  compare<dim>(law, 0.1, 1000);
}

TEST_P(TensionCutoff, tangent_matches_differences_2d) {
  if (is_tresca()) {
    expect_exact_tangents<2>(Tresca<2>(clay()));
  } else {
    expect_exact_tangents<2>(MohrCoulomb<2>(sand()));
  }
}

TEST_P(TensionCutoff, tangent_matches_differences_3d) {
  if (is_tresca()) {
    expect_exact_tangents<3>(Tresca<3>(clay()));
  } else {
    expect_exact_tangents<3>(MohrCoulomb<3>(sand()));
  }
}

INSTANTIATE_TEST_SUITE_P(Cases, TensionCutoff,
                         ::testing::Values(Case{30, 0, 0}, Case{30, 10, 0.02}, Case{15, 15, 0.03},
                                           Case{0, 0, 0}, Case{0, 0, 0.03}));

/// Equal trial stresses that the cut-off does not change keep their elastic shear factor.
TEST(TensionCutoffTangent, matches_differences_at_an_equal_pair) {
  const MohrCoulomb<3> law({.lambda = lambda,
                            .mu = mu,
                            .friction_angle = 30 * degree,
                            .cohesion = cohesion,
                            .tension_cutoff = 0.02});
  MaterialState<3> state;
  state.e << 0.04, -0.015, -0.015, 0, 0, 0;
  const Matrix<3> H = Matrix<3>::Zero();
  ASSERT_EQ(face_with_cutoff<3>(law, H, state), static_cast<int>(YieldFace::tension_1));
  const Tangent<3> A_num = difference_tangent<3>(law, H, state, 1e-6);
  EXPECT_LT((tangent<3>(law, H, state) - A_num).cwiseAbs().maxCoeff(), 1e-7 * M);
}

/// A bar pulled apart with free sides carries the cut-off.
TEST(TensionCutoffPath, a_bar_carries_the_cut_off) {
  const double T = 0.02;
  const Tresca<2> law({.lambda = lambda, .mu = mu, .cohesion = cohesion, .tension_cutoff = T});
  MaterialState<2> state;
  StressUpdate<2> out;
  for (int step = 0; step < 50; ++step) {
    Matrix<2> H = Matrix<2>::Zero();
    H(0, 0) = 1e-3;
    out = stress<2>(law, H, state);
    state = out.state;
    EXPECT_LE(principal<2>(out.tau)[0], T * (1 + 1e-14));
  }
  EXPECT_NEAR(out.tau[0], T, 1e-15);
  EXPECT_EQ(region_name(out.region), "tension");
}

}  // namespace
}  // namespace gabion::testing::test_tension_cutoff
