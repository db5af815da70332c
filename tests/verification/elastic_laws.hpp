// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Eigenvalues>
#include <Eigen/LU>
#include <cmath>
#include <string>

#include "common/mechanics/materials/material.hpp"
#include "common/mechanics/tensor_functions.hpp"

namespace gabion::test {

/// Lame's parameters of Young's modulus [Pa] and Poisson's ratio.
struct Lame {
  double lambda, mu;
  Lame(double E, double nu) : lambda(E * nu / ((1 + nu) * (1 - 2 * nu))), mu(E / (2 * (1 + nu))) {}
};

template <int dim>
MaterialLaw<dim> elastic_law(const std::string& name, const Lame& m) {
  if (name == "neo_hookean") return NeoHookean<dim>{m.lambda, m.mu};
  return HenckyElastic<dim>{m.lambda, m.mu};
}

/// Kirchhoff stress at the deformation gradient F from the definitions of the two laws in three
/// dimensions (plane strain: F_zz = 1), independent of the code under test,
///
///     neo_hookean      tau = lambda ln(J) 1 + mu (b - 1)
///     hencky_elastic   tau = lambda ln(J) 1 + mu ln(b)
template <int dim>
Matrix<3> exact_stress(const std::string& law, const Lame& m, const Matrix<dim>& F) {
  Matrix<3> F3 = Matrix<3>::Identity();
  F3.topLeftCorner<dim, dim>() = F;
  const Matrix<3> b = F3 * F3.transpose(), one = Matrix<3>::Identity();
  const Matrix<3> pressure = m.lambda * std::log(F3.determinant()) * one;
  if (law == "neo_hookean") return pressure + m.mu * (b - one);
  const Eigen::SelfAdjointEigenSolver<Matrix<3>> eigen(b);
  const Vector<3> logarithms = eigen.eigenvalues().array().log();
  return pressure +
         m.mu * (eigen.eigenvectors() * logarithms.asDiagonal() * eigen.eigenvectors().transpose());
}

/// Elastic energy per unit of stress-free volume [J/m^3] that belongs to exact_stress,
///
///     neo_hookean      lambda ln(J)^2 / 2 + mu (tr b - 3) / 2 - mu ln(J)
///     hencky_elastic   lambda ln(J)^2 / 2 + mu |ln(b)|^2 / 4
template <int dim>
double exact_energy(const std::string& law, const Lame& m, const Matrix<dim>& F) {
  Matrix<3> F3 = Matrix<3>::Identity();
  F3.topLeftCorner<dim, dim>() = F;
  const Matrix<3> b = F3 * F3.transpose();
  const double ln_J = std::log(F3.determinant());
  if (law == "neo_hookean") {
    return 0.5 * m.lambda * ln_J * ln_J + 0.5 * m.mu * (b.trace() - 3) - m.mu * ln_J;
  }
  const Eigen::SelfAdjointEigenSolver<Matrix<3>> eigen(b);
  const Vector<3> logarithms = eigen.eigenvalues().array().log();
  return 0.5 * m.lambda * ln_J * ln_J + 0.25 * m.mu * logarithms.squaredNorm();
}

/// All components of a stored symmetric tensor; in plane strain zz too.
template <int dim>
Matrix<3> full(const Symmetric<dim>& s) {
  Matrix<3> m = Matrix<3>::Zero();
  m.topLeftCorner<dim, dim>() = in_plane<dim>(s);
  m(2, 2) = s[2];
  return m;
}

}  // namespace gabion::test
