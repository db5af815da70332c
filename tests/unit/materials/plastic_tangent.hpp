// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <gtest/gtest.h>

#include <map>

#include "tests/unit/materials/random_state.hpp"

namespace gabion::testing {

template <int dim>
double asymmetry(const Tangent<dim>& A) {
  return (A - A.transpose()).cwiseAbs().maxCoeff();
}

/// The term that the law adds to the exact tangent at the apex: 1e-4 of the elastic moduli, the
/// Hencky tangent plus P_iL F^-1_Jk, symmetrised.
template <int dim>
Tangent<dim> apex_regularisation(double lambda, double mu, const Matrix<dim>& H,
                                 const MaterialState<dim>& state_n) {
  const HenckyElastic<dim> elastic{lambda, mu};
  const Matrix<dim> P = stress<dim>(elastic, H, state_n).P;
  const Matrix<dim> F_inverse = (Matrix<dim>::Identity() + H).inverse();
  Tangent<dim> moduli = tangent<dim>(elastic, H, state_n);
  for (int i = 0; i < dim; ++i)
    for (int J = 0; J < dim; ++J)
      for (int k = 0; k < dim; ++k)
        for (int L = 0; L < dim; ++L) moduli(i * dim + J, k * dim + L) += P(i, L) * F_inverse(J, k);
  return 0.5e-4 * (moduli + moduli.transpose());
}

/// Every difference step must stay on the face of its centre, where the law is smooth.
/// @param face  (H, state_n) -> number of the face, -1 elastic
template <int dim>
bool smooth_about(const auto& face, const Matrix<dim>& H, const MaterialState<dim>& state_n,
                  double step) {
  const int centre = face(H, state_n);
  for (int i = 0; i < dim * dim; ++i) {
    for (const double sign : {-1.0, 1.0}) {
      Matrix<dim> moved = H;
      moved(i / dim, i % dim) += sign * step;
      if (face(moved, state_n) != centre) return false;
    }
  }
  return true;
}

/// Compare the tangent with central differences at random states and steps with stresses of `size`
/// M about the surface, to 1e-7 M; returns samples per face. Off the apex the tangent is compared
/// as it is, at the apex without its known regularisation.
/// @param largest_gap  every third state has a gap, up to this volumetric strain
template <int dim>
std::map<int, int> compare_plastic_tangent(const auto& law, const auto& face, double size,
                                           int samples, double largest_gap) {
  Random random(11);
  std::map<int, int> count;
  const double step = 1e-5 * size, M = law.p_wave_modulus();
  const auto& p = law.parameters();
  for (int sample = 0; sample < samples; ++sample) {
    MaterialState<dim> state_n;
    state_n.e = random.elastic_strain<dim>(size / 2, random.uniform(-1.5, 0.2) * size);
    if (sample % 3 == 0) state_n.gap = random.uniform(0, largest_gap);
    const Matrix<dim> H = random.matrix<dim>(random.uniform(0.3, 2.0) * size);
    if (!smooth_about<dim>(face, H, state_n, step)) continue;
    const int centre = face(H, state_n);
    ++count[centre];
    Tangent<dim> A = tangent<dim>(law, H, state_n);
    if (stress<dim>(law, H, state_n).region == YieldRegion::apex)
      A -= apex_regularisation<dim>(p.lambda, p.mu, H, state_n);
    const Tangent<dim> A_num = difference_tangent<dim>(law, H, state_n, step);
    EXPECT_LT((A - A_num).cwiseAbs().maxCoeff(), 1e-7 * M)
        << "sample " << sample << ", face " << centre << ", size " << size;
    if (law.symmetric_tangent()) {
      EXPECT_LT(asymmetry<dim>(A), 1e-11 * M) << "face " << centre;
    }
    if (::testing::Test::HasFailure()) break;
  }
  return count;
}

}  // namespace gabion::testing
