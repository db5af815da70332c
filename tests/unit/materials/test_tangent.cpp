// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include "tests/unit/materials/plastic_return.hpp"
#include "tests/unit/materials/plastic_tangent.hpp"

namespace gabion::testing::test_tangent {
namespace {

constexpr double lambda = 1.7e6, mu = 0.9e6, M = lambda + 2 * mu;
constexpr double tolerance = 1e-7 * M;

template <int dim>
void expect_elastic_tangent(const auto& law, unsigned seed) {
  Random random(seed);
  for (int sample = 0; sample < 200; ++sample) {
    MaterialState<dim> state_n;
    if (sample % 2) state_n.e = random.elastic_strain<dim>(0.15, 0.05);
    const Matrix<dim> H = random.matrix<dim>(random.uniform(0.05, 0.3));
    const Tangent<dim> A = tangent<dim>(law, H, state_n);
    const Tangent<dim> A_num = difference_tangent<dim>(law, H, state_n, 1e-5);
    ASSERT_LT((A - A_num).cwiseAbs().maxCoeff(), tolerance) << "sample " << sample;
    ASSERT_LT(asymmetry<dim>(A), 1e-12 * M) << "sample " << sample;
  }
}

/// States whose principal values are equal, nearly equal, or tiny.
template <int dim>
void expect_tangent_at_repeated_values(const auto& law) {
  Random random(5);
  for (const double gap : {0.0, 1e-15, 1e-12, 1e-9, 1e-6}) {
    for (const double mean : {0.0, 1e-9, -0.1, 0.2}) {
      MaterialState<dim> state_n;
      state_n.e = compose<dim>({mean, mean + gap, mean - gap}, axes<dim>(random.rotation<dim>()));
      const Matrix<dim> R = random.rotation<dim>() - Matrix<dim>::Identity();
      for (const Matrix<dim>& H : {Matrix<dim>(Matrix<dim>::Zero()), R}) {
        const Tangent<dim> A_num = difference_tangent<dim>(law, H, state_n, 1e-5);
        const double error = (tangent<dim>(law, H, state_n) - A_num).cwiseAbs().maxCoeff();
        EXPECT_LT(error, tolerance) << "gap " << gap << ", mean " << mean;
      }
    }
  }
}

template <int dim>
void expect_tangent_at_tiny_strain(const auto& law) {
  Random random(6);
  for (int sample = 0; sample < 20; ++sample) {
    MaterialState<dim> state_n;
    state_n.e = random.elastic_strain<dim>(1e-9, 0);
    const Matrix<dim> H = random.matrix<dim>(1e-9);
    const Tangent<dim> A_num = difference_tangent<dim>(law, H, state_n, 1e-6);
    ASSERT_LT((tangent<dim>(law, H, state_n) - A_num).cwiseAbs().maxCoeff(), tolerance);
  }
}

template <template <int> class Law>
void expect_elastic_law() {
  expect_elastic_tangent<2>(Law<2>{lambda, mu}, 1);
  expect_elastic_tangent<3>(Law<3>{lambda, mu}, 2);
  expect_tangent_at_repeated_values<2>(Law<2>{lambda, mu});
  expect_tangent_at_repeated_values<3>(Law<3>{lambda, mu});
  expect_tangent_at_tiny_strain<2>(Law<2>{lambda, mu});
  expect_tangent_at_tiny_strain<3>(Law<3>{lambda, mu});
}

TEST(Tangent, linear_elastic_matches_differences) {
  expect_elastic_law<LinearElastic>();
}
TEST(Tangent, neo_hookean_matches_differences) {
  expect_elastic_law<NeoHookean>();
}
TEST(Tangent, hencky_elastic_matches_differences) {
  expect_elastic_law<HenckyElastic>();
}

struct Angles {
  double phi, psi;
};

template <int dim>
std::map<int, int> compare(const auto& law, double size, int samples, double largest_gap = 0) {
  const auto face = [&](const Matrix<dim>& H, const MaterialState<dim>& state_n) {
    return face_of<dim>(law, H, state_n);
  };
  return compare_plastic_tangent<dim>(law, face, size, samples, largest_gap);
}

class MohrCoulombTangent : public ::testing::TestWithParam<Angles> {
 protected:
  template <int dim>
  MohrCoulomb<dim> law(double cohesion) const {
    return {lambda, mu, GetParam().phi * degree, GetParam().psi * degree, cohesion};
  }
  /// Elastic, plane, both edges and the apex must all have been met.
  static void expect_all_faces(std::map<int, int> count) {
    for (int face = -1; face <= 3; ++face) EXPECT_GE(count[face], 5) << face;
  }
};

TEST_P(MohrCoulombTangent, matches_differences_2d) {
  for (const double size : {0.15, 0.01})
    expect_all_faces(compare<2>(law<2>(0.1 * size * M), size, 2000));
  expect_all_faces(compare<2>(law<2>(0), 0.05, 2000));
}

TEST_P(MohrCoulombTangent, matches_differences_3d) {
  expect_all_faces(compare<3>(law<3>(0.1 * 0.15 * M), 0.15, 3000));
  expect_all_faces(compare<3>(law<3>(0), 0.05, 3000));
}

TEST_P(MohrCoulombTangent, matches_differences_with_a_gap) {
  for (const double cohesion : {0.0, 0.01 * M}) {
    expect_all_faces(compare<2>(law<2>(cohesion), 0.1, 3000, 0.1));
    expect_all_faces(compare<3>(law<3>(cohesion), 0.1, 3000, 0.1));
  }
}

TEST_P(MohrCoulombTangent, matches_differences_at_tiny_strain) {
  compare<2>(law<2>(0), 1e-9, 500);
  compare<3>(law<3>(0), 1e-9, 200);
}

/// Axisymmetric trial states: the equal pair must land on an edge with zero shear factor.
TEST_P(MohrCoulombTangent, matches_differences_at_equal_trial_values) {
  Random random(3);
  for (const double side : {-1.0, 1.0}) {
    const double pair = side > 0 ? -0.05 : 0.02, odd = side > 0 ? 0.05 : -0.1;
    MaterialState<3> state_n;
    state_n.e = compose<3>({odd, pair, pair}, random.rotation<3>());
    const MohrCoulomb<3> solid = law<3>(0);
    const Matrix<3> H = Matrix<3>::Zero();
    const int edge = static_cast<int>(side > 0 ? YieldFace::edge_23 : YieldFace::edge_12);
    ASSERT_EQ(face_of<3>(solid, H, state_n), edge);
    const Tangent<3> A_num = difference_tangent<3>(solid, H, state_n, 1e-6);
    EXPECT_LT((tangent<3>(solid, H, state_n) - A_num).cwiseAbs().maxCoeff(), tolerance);

    MaterialState<2> plane_state;  // the pair in the plane, the odd one out of it
    plane_state.e << pair, pair, odd, 0;
    const MohrCoulomb<2> plane_law = law<2>(0);
    ASSERT_EQ(face_of<2>(plane_law, Matrix<2>::Zero(), plane_state), edge);
    const Tangent<2> A2_num =
        difference_tangent<2>(plane_law, Matrix<2>::Zero(), plane_state, 1e-6);
    EXPECT_LT(
        (tangent<2>(plane_law, Matrix<2>::Zero(), plane_state) - A2_num).cwiseAbs().maxCoeff(),
        tolerance);
  }
}

/// Elastic, plane and both edges must all have been met.
void expect_tresca_faces(std::map<int, int> count) {
  for (int face = -1; face <= 2; ++face) EXPECT_GE(count[face], 5) << face;
  EXPECT_EQ(count[static_cast<int>(YieldFace::apex)], 0);
}

TEST(TrescaTangent, matches_differences_and_is_symmetric) {
  for (const double size : {0.15, 1e-3}) {
    const TrescaParameters clay{lambda, mu, 0.1 * size * M};
    expect_tresca_faces(compare<2>(Tresca<2>(clay), size, 2000));
    expect_tresca_faces(compare<3>(Tresca<3>(clay), size, 2000));
  }
  compare<2>(Tresca<2>({lambda, mu, 1e-10 * M}), 1e-9, 200);
  compare<3>(Tresca<3>({lambda, mu, 1e-10 * M}), 1e-9, 200);
}

class DruckerPragerTangent : public ::testing::TestWithParam<Angles> {
 protected:
  DruckerPragerParameters parameters(double cohesion, ConeMatch match) const {
    return {.lambda = lambda,
            .mu = mu,
            .friction_angle = GetParam().phi * degree,
            .dilation_angle = GetParam().psi * degree,
            .cohesion = cohesion,
            .match = match};
  }
  /// Elastic, cone and apex must all have been met.
  static void expect_all_regions(std::map<int, int> count) {
    for (const int region :
         {-1, static_cast<int>(YieldRegion::shear), static_cast<int>(YieldRegion::apex)})
      EXPECT_GE(count[region], 5) << region;
  }
};

TEST_P(DruckerPragerTangent, matches_differences) {
  for (const ConeMatch match :
       {ConeMatch::plane_strain, ConeMatch::compression, ConeMatch::extension}) {
    for (const double cohesion : {0.0, 0.01 * M}) {
      const auto p = parameters(cohesion, match);
      expect_all_regions(compare<2>(DruckerPrager<2>(p), 0.1, 500));
      expect_all_regions(compare<3>(DruckerPrager<3>(p), 0.1, 500));
      expect_all_regions(compare<2>(DruckerPrager<2>(p), 0.1, 500, 0.1));
      expect_all_regions(compare<3>(DruckerPrager<3>(p), 0.1, 500, 0.1));
    }
  }
  compare<2>(DruckerPrager<2>(parameters(0, ConeMatch::plane_strain)), 1e-9, 200);
  compare<3>(DruckerPrager<3>(parameters(0, ConeMatch::plane_strain)), 1e-9, 200);
}

/// Two or three equal trial values on the cone, where the shear factors are limits.
TEST_P(DruckerPragerTangent, matches_differences_at_equal_trial_values) {
  const DruckerPrager<3> solid(parameters(0, ConeMatch::plane_strain));
  const DruckerPrager<2> plane(parameters(0, ConeMatch::plane_strain));
  Random random(3);
  for (const double side : {-1.0, 1.0}) {
    const double pair = side > 0 ? -0.05 : 0.02, odd = side > 0 ? 0.05 : -0.1;
    MaterialState<3> state;
    state.e = compose<3>({odd, pair, pair}, random.rotation<3>());
    const Matrix<3> H3 = Matrix<3>::Zero();
    ASSERT_EQ(stress<3>(solid, H3, state).region, YieldRegion::shear);
    const Tangent<3> A3 = difference_tangent<3>(solid, H3, state, 1e-6);
    EXPECT_LT((tangent<3>(solid, H3, state) - A3).cwiseAbs().maxCoeff(), tolerance);
    MaterialState<2> plane_state;
    plane_state.e << pair, pair, odd, 0;
    const Matrix<2> H2 = Matrix<2>::Zero();
    ASSERT_EQ(stress<2>(plane, H2, plane_state).region, YieldRegion::shear);
    const Tangent<2> A2 = difference_tangent<2>(plane, H2, plane_state, 1e-6);
    EXPECT_LT((tangent<2>(plane, H2, plane_state) - A2).cwiseAbs().maxCoeff(), tolerance);
  }
}

INSTANTIATE_TEST_SUITE_P(Angles, DruckerPragerTangent,
                         ::testing::Values(Angles{19.8, 0}, Angles{30, 10}, Angles{35, 35}));
INSTANTIATE_TEST_SUITE_P(Angles, MohrCoulombTangent,
                         ::testing::Values(Angles{19.8, 0}, Angles{30, 10}, Angles{35, 35}));

}  // namespace
}  // namespace gabion::testing::test_tangent
