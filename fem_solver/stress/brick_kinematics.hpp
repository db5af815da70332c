// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <span>

#include "fem_solver/materials/log_strain.hpp"
#include "fem_solver/stress/enhanced_strain.hpp"

namespace gabion::fem {

/// Strain of the displacements of a quad4 or hex8, and its enhancing modes; see EnhancedCell.
/// @tparam small  the strain is the symmetric part of H, else that of Green
template <int dim_, bool small>
class BrickKinematics {
 public:
  static constexpr int dim = dim_, num_nodes = 1 << dim, num_dofs = num_nodes * dim;
  static constexpr int num_modes = fem::num_modes<dim>, max_points = 1 << dim;
  static constexpr bool small_strain = small;

  /// Geometry of a cell: points x nodes, points, points.
  struct Geometry {
    const Vector<dim>* gradients;
    const double* weights;
    const ModeStrains<dim>* modes;
  };

  explicit BrickKinematics(const Geometry& geometry) : geometry_(geometry) {}

  static constexpr int num_points() { return max_points; }
  double weight(int q) const { return geometry_.weights[q]; }
  const ModeStrains<dim>& modes(int q) const { return geometry_.modes[q]; }

  /// @returns false when det F <= 0
  bool move(std::span<const Vector<dim>> u) {
    for (int q = 0; q < max_points; ++q) {
      Matrix<dim> H = Matrix<dim>::Zero();
      for (int a = 0; a < num_nodes; ++a) H.noalias() += u[a] * gradient(q, a).transpose();
      F_[q].setIdentity();
      if constexpr (small) {
        strain_[q] = H;
      } else {
        F_[q] += H;
        if (!(determinant_minus_one<dim>(H) > -1)) return false;
        strain_[q] = twice_green_strain<dim>(H);
      }
    }
    return true;
  }
  /// After move(): C - 1; with small strain H.
  const Matrix<dim>& strain(int q) const { return strain_[q]; }
  /// R of F = R U.
  Matrix<dim> rotation(int q, const LogStrain<dim>& strain) const {
    return F_[q] * stretch<dim>(strain, -1);
  }

  /// f += w B^T S
  void add_forces(int q, const StrainVector<dim>& S, Eigen::Matrix<double, num_dofs, 1>& f) const {
    const Matrix<dim> P = F_[q] * strain_tensor<dim>(S);
    for (int a = 0; a < num_nodes; ++a) {
      f.template segment<dim>(a * dim) += geometry_.weights[q] * (P * gradient(q, a));
    }
  }

  StrainByNodes<dim, num_dofs> strain_by_nodes(int q) const {
    StrainByNodes<dim, num_dofs> B = StrainByNodes<dim, num_dofs>::Zero();
    for (int a = 0; a < num_nodes; ++a) {
      for (int J = 0; J < dim; ++J) {
        for (int M = 0; M < dim; ++M) {
          const int row = strain_index<dim>(M, J);
          const double slope = gradient(q, a)[J] / strain_factor(M, J);
          for (int i = 0; i < dim; ++i) B(row, a * dim + i) += F_[q](i, M) * slope;
        }
      }
    }
    return B;
  }

  /// K_ab += w (dN_a . S dN_b) 1
  template <class Stiffness>
  void add_geometric(int q, const StrainVector<dim>& stress, Stiffness& K) const {
    const Matrix<dim> S = geometry_.weights[q] * strain_tensor<dim>(stress);
    for (int a = 0; a < num_nodes; ++a) {
      const Vector<dim> S_dN = S * gradient(q, a);
      for (int b = 0; b < num_nodes; ++b) {
        const double k = S_dN.dot(gradient(q, b));
        for (int i = 0; i < dim; ++i) K(a * dim + i, b * dim + i) += k;
      }
    }
  }

 private:
  const Vector<dim>& gradient(int q, int a) const { return geometry_.gradients[q * num_nodes + a]; }

  Geometry geometry_;
  std::array<Matrix<dim>, max_points> F_, strain_;
};

}  // namespace gabion::fem
