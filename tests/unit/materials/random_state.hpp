// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Eigenvalues>
#include <Eigen/Geometry>
#include <algorithm>
#include <numbers>
#include <random>

#include "common/mechanics/materials/material.hpp"
#include "common/mechanics/materials/mohr_coulomb_return.hpp"
#include "common/mechanics/materials/spectral.hpp"

namespace gabion::testing {

inline constexpr double degree = std::numbers::pi / 180;

/// The axes in the columns of a rotation.
template <int dim>
Axes<dim> axes(const Matrix<dim>& R) {
  if constexpr (dim == 2) {
    return {R(0, 0) * R(0, 0) - R(1, 0) * R(1, 0), 2 * R(0, 0) * R(1, 0)};
  } else {
    return R;
  }
}

/// Reproducible random tensors.
class Random {
 public:
  explicit Random(unsigned seed) : generator_(seed) {}

  double uniform(double low, double high) {
    return std::uniform_real_distribution<double>(low, high)(generator_);
  }
  /// Full tensor of Frobenius norm `size`.
  template <int dim>
  Matrix<dim> matrix(double size) {
    const Matrix<dim> m = Matrix<dim>::NullaryExpr([&] { return uniform(-1, 1); });
    return size / m.norm() * m;
  }
  /// e = b - 1 of principal Hencky strains within `size` about `mean`, on random axes.
  template <int dim>
  Symmetric<dim> elastic_strain(double size, double mean) {
    std::array<double, 3> e;
    for (double& value : e) value = std::expm1(2 * (mean + uniform(-size, size)));
    return compose<dim>(e, axes<dim>(rotation<dim>()));
  }
  template <int dim>
  Matrix<dim> rotation() {
    if constexpr (dim == 2) {
      return Eigen::Rotation2Dd(uniform(-std::numbers::pi, std::numbers::pi)).toRotationMatrix();
    } else {
      const Eigen::Vector4d q = Eigen::Vector4d::NullaryExpr([&] { return uniform(-1, 1); });
      return Eigen::Quaterniond(q.normalized()).toRotationMatrix();
    }
  }

 private:
  std::mt19937 generator_;
};

/// The symmetric tensor as 3 x 3 matrix.
template <int dim>
Eigen::Matrix3d full(const Symmetric<dim>& s) {
  Eigen::Matrix3d m = Eigen::Matrix3d::Zero();
  m.topLeftCorner<dim, dim>() = in_plane<dim>(s);
  m(2, 2) = s[2];
  return m;
}

/// Principal values, descending, by a library routine.
template <int dim>
Eigen::Vector3d principal(const Symmetric<dim>& s) {
  const Eigen::Vector3d ascending =
      Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d>(full<dim>(s)).eigenvalues();
  return ascending.reverse();
}

template <int dim, class Law>
StressUpdate<dim> stress(const Law& law, const Matrix<dim>& H, const MaterialState<dim>& state_n) {
  StressUpdate<dim> out;
  if (!law.update(H, state_n, out, nullptr)) throw Error("the step turned the material inside out");
  return out;
}

template <int dim>
Tangent<dim> tangent(const auto& law, const Matrix<dim>& H, const MaterialState<dim>& state_n) {
  StressUpdate<dim> out;
  Tangent<dim> A;
  if (!law.update(H, state_n, out, &A)) throw Error("the step turned the material inside out");
  return A;
}

/// dP/dH by central differences.
template <int dim>
Tangent<dim> difference_tangent(const auto& law, const Matrix<dim>& H,
                                const MaterialState<dim>& state_n, double step) {
  Tangent<dim> A;
  for (int k = 0; k < dim; ++k) {
    for (int L = 0; L < dim; ++L) {
      Matrix<dim> forward = H, backward = H;
      forward(k, L) += step;
      backward(k, L) -= step;
      const Matrix<dim> dP =
          (stress<dim>(law, forward, state_n).P - stress<dim>(law, backward, state_n).P) /
          (forward(k, L) - backward(k, L));
      for (int i = 0; i < dim; ++i)
        for (int J = 0; J < dim; ++J) A(i * dim + J, k * dim + L) = dP(i, J);
    }
  }
  return A;
}

}  // namespace gabion::testing
