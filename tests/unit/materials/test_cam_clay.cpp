// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include <cmath>
#include <map>

#include "tests/unit/materials/cam_clay_element.hpp"
#include "tests/unit/materials/plastic_tangent.hpp"

namespace gabion::testing::test_cam_clay {
namespace {

template <int dim>
using AtPoint = LawInStep<CamClay<dim>, dim>;

using Element = CamClayElement;

/// P_f = p_0 (R / 2)^(1 - kappa / lambda): 53.589, 100 and 186.607 kPa; q = M P.
TEST(CamClay, undrained_shear_ends_at_the_critical_state) {
  for (const auto& [ocr, P_f] : {std::pair{1., 53.588673e3}, {2., 100e3}, {4., 186.606598e3}}) {
    Element soil(ocr);
    const double step = 1e-3;
    for (int n = 0; n < 600; ++n) soil.strain({step / 2, step / 2, -step});
    EXPECT_NEAR(soil.P(), P_f, 1e-6 * P_f) << ocr;
    EXPECT_NEAR(soil.q(), 1.2 * P_f, 1e-6 * P_f) << ocr;
    EXPECT_NEAR(soil.J, 1, 1e-12);
  }
}

/// P = p_0 (M^2 / (M^2 + eta^2))^(1 - kappa / lambda), eta = q / P, of any step size: the volume
/// does not change, so that kappa and lambda share it as they stand.
TEST(CamClay, undrained_path_is_the_closed_one) {
  Element soil(1);
  for (int n = 0; n < 200; ++n) {
    soil.strain({1e-4, 1e-4, -2e-4});
    const double eta = soil.q() / soil.P();
    const double expected = p_0 * std::pow(1.44 / (1.44 + eta * eta), 0.9);
    EXPECT_NEAR(soil.P(), expected, 1e-9 * p_0) << n;
  }
  EXPECT_LT(soil.P(), 70e3);
}

/// Isotropic virgin compression and unloading: d ln J = -lambda d ln P and -kappa d ln P.
TEST(CamClay, isotropic_compression_follows_its_lines) {
  for (const double ocr : {1., 3.}) {
    Element soil(ocr);
    for (int n = 0; n < 50; ++n) soil.strain(Eigen::Vector3d::Constant(-2e-3));
    const double P_c = soil.P(), strain = std::log(soil.J);
    EXPECT_NEAR(soil.internal[0], P_c, 1e-9 * P_c);
    EXPECT_NEAR(-strain, 0.009 * std::log(ocr) + 0.09 * std::log(P_c / (ocr * p_0)), 1e-12);
    for (int n = 0; n < 20; ++n) soil.strain(Eigen::Vector3d::Constant(1e-4));
    EXPECT_FALSE(soil.out.plastic());
    EXPECT_NEAR(soil.P(), P_c * std::exp(-6e-3 / 0.009), 1e-9 * P_c);
  }
}

/// Constant Cauchy stress at the side: q = 3 M p_0 / (3 - M) = 200 kPa at p' = 166.667 kPa, and
/// ln J (1 + lambda) = -kappa ln(p_f / p_0) - (lambda - kappa) ln(2 p_f / (R p_0)).
TEST(CamClay, drained_compression_ends_at_the_critical_state) {
  for (const auto& [ocr, ln_J] : {std::pair{1., -0.0936874}, {1.5, -0.0635565}, {4., 0.0093308}}) {
    Element soil(ocr);
    double most = 0;
    for (int n = 0; n < 1500; ++n) {
      soil.compress_drained(1e-3, p_0);
      most = std::max(most, soil.q() / soil.J);
    }
    EXPECT_NEAR(soil.q() / soil.J, 200e3, 200) << ocr;
    EXPECT_NEAR(std::log(soil.J), ln_J, 2e-4) << ocr;
    if (ocr == 4) {
      EXPECT_NEAR(most, 239.932e3, 400);  // it yields there, and softens
    }
  }
}

/// Cauchy stress q of normally consolidated soil at some axial Hencky strains, by integration of
/// the rate equations in 50000 explicit steps.
TEST(CamClay, drained_compression_has_its_curve) {
  Element soil(1);
  int n = 0;
  for (const auto& [strain, q] :
       {std::pair{0.01, 34.2226e3}, {0.02, 53.2754e3}, {0.05, 91.1421e3}, {0.1, 130.8562e3}}) {
    for (; n < std::lround(strain / 2e-5); ++n) soil.compress_drained(2e-5, p_0);
    EXPECT_NEAR(soil.q() / soil.J, q, 1e-3 * q) << strain;
  }
}

/// No energy is gained or lost on a closed path of elastic strains, in shear and in pressure.
TEST(CamClay, elasticity_conserves_energy) {
  Element soil(50);
  const auto work_along = [&](const Eigen::Vector3d& eps, int steps) {
    double work = 0;
    soil.strain(Eigen::Vector3d::Zero());
    for (int n = 0; n < steps; ++n) {
      const Eigen::Vector3d before = soil.out.tau.head<3>();
      soil.strain(eps / steps);
      work += 0.5 * (before + soil.out.tau.head<3>()).dot(eps / steps);
      EXPECT_FALSE(soil.out.plastic());
    }
    return work;
  };
  const Eigen::Vector3d shear(5e-3, -5e-3, 0), squeeze(-0.01, -0.01, -0.01);
  soil.strain(Eigen::Vector3d::Zero());
  const double energy = soil.out.energy;
  double work = 0;
  for (const auto& path : {squeeze, shear, Eigen::Vector3d(-squeeze), Eigen::Vector3d(-shear)}) {
    const double before = soil.out.energy, done = work_along(path, 400);
    EXPECT_NEAR(soil.out.energy - before, done, 1e-4 * std::abs(done) + 1e-3);
    work += done;
  }
  EXPECT_NEAR(soil.out.energy, energy, 1e-9 * energy);
  EXPECT_NEAR(work, 0, 1e-5 * energy);
}

/// Pulled apart it keeps no pressure; pushed together it takes up load where it left it.
TEST(CamClay, volume_that_opens_closes_before_pressure_builds) {
  Element soil(1, clay(1000));
  soil.strain(Eigen::Vector3d::Zero());
  EXPECT_NEAR(soil.P(), p_0 - 1000, 1e-6);
  const double P = soil.P();
  for (int n = 0; n < 10; ++n) soil.strain(Eigen::Vector3d::Constant(0.02));
  EXPECT_EQ(soil.out.region, YieldRegion::apex);
  EXPECT_NEAR(soil.P(), 0, 1e-6);
  EXPECT_NEAR(soil.out.energy, 0, 1e-6);
  EXPECT_GT(soil.state.gap, 0.1);
  for (int n = 0; n < 10; ++n) soil.strain(Eigen::Vector3d::Constant(-0.02));
  EXPECT_EQ(soil.state.gap, 0);
  EXPECT_NEAR(soil.P(), P, 1e-6 * P);
}

/// One step to any strain is solved: on the ellipse, or open.
TEST(CamClay, large_steps_are_solved) {
  Random random(5);
  for (int sample = 0; sample < 4000; ++sample) {
    const double ocr = std::exp(random.uniform(0, 5)), mu = std::exp(random.uniform(11, 17));
    const double size = std::exp(random.uniform(-12, -1.5));
    const CamClayParameters law = clay(std::exp(random.uniform(3, 9)));
    const double P_c = law.attraction + ocr * p_0;
    const StrainInvariants trial{random.uniform(-1, 1) * size + random.uniform(-0.02, 0.06),
                                 random.uniform(0, 1) * size};
    CamClayState end;
    ASSERT_TRUE(cam_clay_step(law, {P_c, mu}, trial, end)) << sample;
    if (end.region != YieldRegion::shear) continue;
    const double q = 3 * mu * end.share * trial.distortion, y = q / law.critical_ratio;
    const double P = end.P, scale = y * y + P * (P + end.preconsolidation);
    EXPECT_LT(std::abs(y * y + P * (P - end.preconsolidation)), 1e-10 * scale) << sample;
    EXPECT_GT(end.share, 0);
    EXPECT_LE(end.share, 1);
    EXPECT_NEAR(std::log(end.preconsolidation / P_c),
                (end.volumetric - trial.volumetric) / (law.compression - law.swelling), 1e-10);
    // the flow is along the gradient: volume by distortion
    const double L = (1 / end.share - 1) * law.critical_ratio * law.critical_ratio / (6 * mu);
    EXPECT_NEAR(end.volumetric - trial.volumetric, L * (2 * P - end.preconsolidation),
                1e-8 * (std::abs(trial.volumetric) + trial.distortion))
        << sample;
  }
}

template <int dim>
void expect_tangent(double ocr, double size) {
  Random random(7);
  const CamClay<dim> law(clay(1000));
  const AtPoint<dim> soil{law, {.internal = {ocr * p_0, 5e6}}};
  std::map<YieldRegion, int> count;
  const double step = 3e-5 * size;
  for (int sample = 0; sample < 300; ++sample) {
    MaterialState<dim> state_n;
    state_n.e = random.elastic_strain<dim>(size / 2, random.uniform(-0.004, 0.004));
    if (sample % 3 == 0) state_n.gap = random.uniform(0, size);
    const Matrix<dim> H = random.matrix<dim>(random.uniform(0.1, 1) * size);
    const auto region = [&](const Matrix<dim>& at, const MaterialState<dim>& from) {
      return static_cast<int>(stress<dim>(soil, at, from).region);
    };
    if (!smooth_about<dim>(region, H, state_n, step)) continue;
    const auto found = stress<dim>(soil, H, state_n);
    ++count[found.region];
    if (found.region == YieldRegion::apex) continue;  // see the next test
    const Tangent<dim> A = tangent<dim>(soil, H, state_n);
    const Tangent<dim> A_num = difference_tangent<dim>(soil, H, state_n, step);
    const double M = A.cwiseAbs().maxCoeff();
    ASSERT_LT((A - A_num).cwiseAbs().maxCoeff(), 1e-7 * M) << sample << " ocr " << ocr;
  }
  EXPECT_GE(count[YieldRegion::shear] + count[YieldRegion::elastic], 40);
  if (size > 0.01) {
    EXPECT_GE(count[YieldRegion::shear], 40);
  }
}

TEST(CamClay, tangent_matches_differences) {
  for (const double ocr : {1., 2., 6.}) {
    for (const double size : {0.003, 0.03}) {
      expect_tangent<2>(ocr, size);
      expect_tangent<3>(ocr, size);
    }
  }
}

/// Equal strains, and the critical state in one step: the limits of the formulas.
TEST(CamClay, moduli_of_invariants_match_differences) {
  const CamClayParameters law = clay(1000);
  const CamClayMemory start{2 * p_0, 5e6};
  for (const auto& trial : {StrainInvariants{-0.02, 0},
                            {-0.02, 1e-9},
                            {0, 0.02},
                            {1e-7, 0.02},
                            {-0.02, 0.02},
                            {0.005, 0.02},
                            {-0.3, 0.1},
                            {0.08, 0.001},
                            {0.08, 0.0001}}) {
    CamClayState end;
    ASSERT_TRUE(cam_clay_step(law, start, trial, end));
    const auto stresses = [&](const StrainInvariants& at) {
      CamClayState moved;
      EXPECT_TRUE(cam_clay_step(law, start, at, moved));
      return Eigen::Vector2d(-moved.P, 3 * start.shear_modulus * moved.share * at.distortion);
    };
    const double h = 1e-7;
    Eigen::Matrix2d differences;
    differences.col(0) = (stresses({trial.volumetric + h, trial.distortion}) -
                          stresses({trial.volumetric - h, trial.distortion})) /
                         (2 * h);
    differences.col(1) = (stresses({trial.volumetric, trial.distortion + h}) -
                          stresses({trial.volumetric, trial.distortion - h})) /
                         (2 * h);
    const double allowed = end.region == YieldRegion::apex ? 1e-4 : 2e-7;
    EXPECT_LT((end.moduli - differences).cwiseAbs().maxCoeff(), allowed * 3 * 5e6)
        << trial.volumetric << " " << trial.distortion << "\n"
        << end.moduli << "\n"
        << differences;
  }
}

}  // namespace
}  // namespace gabion::testing::test_cam_clay
