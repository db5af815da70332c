// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include <Eigen/LU>
#include <vector>

#include "tests/unit/materials/random_state.hpp"

namespace gabion::testing::test_element_newton {
namespace {

constexpr double lambda = 1.7e6, mu = 0.9e6, M = lambda + 2 * mu;

/// Squeeze one point along the last axis to a given strain, all other components of P but those of
/// the spin prescribed; returns the norms of the residual of Newton's method.
template <int dim>
std::vector<double> element_residuals(const auto& law, const MaterialState<dim>& state_n,
                                      double axial, const Matrix<dim>& P_given,
                                      StressUpdate<dim>& out) {
  std::vector<int> unknown;  // upper triangle of H without the axial component
  for (int i = 0; i < dim; ++i)
    for (int J = i; J < dim; ++J)
      if (i != dim - 1) unknown.push_back(i * dim + J);
  const auto n = static_cast<Eigen::Index>(unknown.size());
  Matrix<dim> H = Matrix<dim>::Zero();
  H(dim - 1, dim - 1) = axial;
  std::vector<double> norms;
  for (int iteration = 0; iteration < 25; ++iteration) {
    Tangent<dim> A;
    if (!law.update(H, state_n, out, &A)) throw Error("inverted");
    Eigen::VectorXd r(n);
    Eigen::MatrixXd K(n, n);
    for (Eigen::Index a = 0; a < n; ++a) {
      const int i = unknown[a] / dim, J = unknown[a] % dim;
      r[a] = out.P(i, J) - P_given(i, J);
      for (Eigen::Index b = 0; b < n; ++b) K(a, b) = A(unknown[a], unknown[b]);
    }
    norms.push_back(r.norm() / M);
    if (norms.back() < 1e-15) break;
    const Eigen::VectorXd dH = K.partialPivLu().solve(-r);
    for (Eigen::Index a = 0; a < n; ++a) H(unknown[a] / dim, unknown[a] % dim) += dH[a];
  }
  return norms;
}

/// The residual falls to rounding; the last three norms above it show order 2.
void expect_quadratic(const std::vector<double>& norms) {
  ASSERT_LT(norms.back(), 1e-14);
  std::size_t k = norms.size() - 1;
  while (k > 2 && norms[k] < 1e-15) --k;
  ASSERT_GE(k, 2u);
  const double order = std::log(norms[k] / norms[k - 1]) / std::log(norms[k - 1] / norms[k - 2]);
  EXPECT_GT(order, 1.8) << norms[k - 2] << ", " << norms[k - 1] << ", " << norms[k];
}

template <int dim>
void expect_quadratic_element(const auto& law) {
  MaterialState<dim> state_n;
  state_n.e.template head<3>().setConstant(std::expm1(-2 * 0.005));
  Matrix<dim> P = -0.015 * M * Matrix<dim>::Identity();
  P(0, dim - 1) = 0.002 * M;
  StressUpdate<dim> out;
  const auto norms = element_residuals<dim>(law, state_n, -0.12, P, out);
  EXPECT_EQ(out.region, YieldRegion::shear);
  expect_quadratic(norms);
}

template <template <int> class Law>
void expect_quadratic_elements(const auto& parameters) {
  expect_quadratic_element<2>(Law<2>(parameters));
  expect_quadratic_element<3>(Law<3>(parameters));
}

TEST(ElementNewton, converges_quadratically_on_plastic_elements) {
  for (const double psi : {0., 10., 30.})
    expect_quadratic_elements<MohrCoulomb>(MohrCoulombParameters{.lambda = lambda,
                                                                 .mu = mu,
                                                                 .friction_angle = 30 * degree,
                                                                 .dilation_angle = psi * degree,
                                                                 .cohesion = 1e4});
  for (const double psi : {0., 10., 30.})
    expect_quadratic_elements<DruckerPrager>(DruckerPragerParameters{.lambda = lambda,
                                                                     .mu = mu,
                                                                     .friction_angle = 30 * degree,
                                                                     .dilation_angle = psi * degree,
                                                                     .cohesion = 1e4});
  expect_quadratic_elements<Tresca>(TrescaParameters{lambda, mu, 0.01 * M});
}

}  // namespace
}  // namespace gabion::testing::test_element_newton
