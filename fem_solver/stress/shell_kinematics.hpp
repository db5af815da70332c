// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/LU>
#include <array>
#include <span>

#include "fem_solver/materials/log_strain.hpp"
#include "fem_solver/stress/enhanced_strain.hpp"
#include "fem_solver/stress/shell_strain.hpp"

namespace gabion::fem {

/// Strain of the displacements of a hex8 that is a solid shell, and its enhancing modes; see
/// EnhancedCell and docs/theory/structure.md, (T38).
/// @tparam small  the strain is linear in the displacements, else that of Green
template <bool small>
class ShellKinematics {
 public:
  static constexpr int dim = 3, num_nodes = 8, num_dofs = 24, num_modes = num_shell_modes;
  static constexpr int max_points = ShellRule::max_points;
  static constexpr bool small_strain = small;

  /// @param gradients  dN/dx, points x nodes
  /// @param weights    of the points [m^3]
  ShellKinematics(const ShellRule& rule, const ShellShape& shape, const Vector<3>* gradients,
                  const double* weights)
      : rule_(rule), shape_(shape), gradients_(gradients), weights_(weights) {}

  int num_points() const { return static_cast<int>(rule_.points.size()); }
  double weight(int q) const { return weights_[q]; }
  const ShellModes& modes(int q) const { return shape_.modes[q]; }

  /// @returns false when det F <= 0
  bool move(std::span<const Vector<3>> u) {
    find_place_values(u);
    for (int q = 0; q < num_points(); ++q) {
      Matrix<3> H = Matrix<3>::Zero();
      for (int a = 0; a < num_nodes; ++a) {
        H.noalias() += u[a] * gradients_[q * num_nodes + a].transpose();
      }
      if (!small && !(determinant_minus_one<3>(H) > -1)) return false;
      F_[q] = Matrix<3>::Identity() + H;
      StrainVector<3> e = StrainVector<3>::Zero();
      for (const auto& term : rule_.terms[q]) {
        e[strain_index<3>(term.i, term.j)] +=
            strain_factor(term.i, term.j) * term.share * component(term);
      }
      strain_[q] = strain_tensor<3>(StrainVector<3>((small ? 1 : 2) * (shape_.axes[q] * e)));
    }
    return true;
  }
  /// After move(): twice Green's strain; the strain itself with small strain.
  const Matrix<3>& strain(int q) const { return strain_[q]; }
  /// R of F = R U, F that of the displacements.
  Matrix<3> rotation(int q, const LogStrain<3>& /*strain*/) const {
    LogStrain<3> own;
    find_log_strain<3>(F_[q].transpose() * F_[q] - Matrix<3>::Identity(), own);
    return F_[q] * stretch<3>(own, -1);
  }

  /// f += w B^T S
  void add_forces(int q, const StrainVector<3>& S, Eigen::Matrix<double, num_dofs, 1>& f) const {
    const StrainVector<3> s = weights_[q] * (shape_.axes[q].transpose() * S);
    for (const auto& term : rule_.terms[q]) {
      const double share =
          term.share * strain_factor(term.i, term.j) * s[strain_index<3>(term.i, term.j)];
      for (int a = 0; a < num_nodes; ++a) {
        f.template segment<3>(a * 3) += share * slope_of(term, a);
      }
    }
  }

  StrainByNodes<3, num_dofs> strain_by_nodes(int q) const {
    StrainByNodes<3, num_dofs> B = StrainByNodes<3, num_dofs>::Zero();
    for (const auto& term : rule_.terms[q]) {
      const int row = strain_index<3>(term.i, term.j);
      const double share = term.share * strain_factor(term.i, term.j);
      for (int a = 0; a < num_nodes; ++a) {
        B.template block<1, 3>(row, a * 3) += share * slope_of(term, a).transpose();
      }
    }
    return shape_.axes[q] * B;
  }

  /// K_ab += w S : d2E / du_a du_b
  template <class Stiffness>
  void add_geometric(int q, const StrainVector<3>& stress, Stiffness& K) const {
    const StrainVector<3> s = weights_[q] * (shape_.axes[q].transpose() * stress);
    Eigen::Matrix<double, num_nodes, num_nodes> k = Eigen::Matrix<double, 8, 8>::Zero();
    for (const auto& term : rule_.terms[q]) {
      const double share =
          0.5 * term.share * strain_factor(term.i, term.j) * s[strain_index<3>(term.i, term.j)];
      const auto& dN = rule_.slopes[term.place];
      for (int a = 0; a < num_nodes; ++a) {
        for (int b = 0; b < num_nodes; ++b) {
          k(a, b) += share * (dN[a][term.i] * dN[b][term.j] + dN[a][term.j] * dN[b][term.i]);
        }
      }
    }
    for (int a = 0; a < num_nodes; ++a) {
      for (int b = 0; b < num_nodes; ++b) {
        for (int i = 0; i < 3; ++i) K(a * 3 + i, b * 3 + i) += k(a, b);
      }
    }
  }

 private:
  /// Columns i are dX/dxi_i and du/dxi_i at each place.
  void find_place_values(std::span<const Vector<3>> u) {
    for (std::size_t p = 0; p < rule_.slopes.size(); ++p) {
      G_[p].setZero();
      d_[p].setZero();
      for (int a = 0; a < num_nodes; ++a) {
        G_[p].noalias() += shape_.x[a] * rule_.slopes[p][a].transpose();
        d_[p].noalias() += u[a] * rule_.slopes[p][a].transpose();
      }
      g_[p] = G_[p];
      if (!small) g_[p] += d_[p];
    }
  }

  /// e_ij at the place of the term, from the displacement's slopes, so that nothing cancels.
  double component(const ShellRule::Term& term) const {
    const Matrix<3>&G = G_[term.place], &d = d_[term.place];
    const double linear =
        0.5 * (G.col(term.i).dot(d.col(term.j)) + d.col(term.i).dot(G.col(term.j)));
    return small ? linear : linear + 0.5 * d.col(term.i).dot(d.col(term.j));
  }

  /// de_ij / du_a
  Vector<3> slope_of(const ShellRule::Term& term, int a) const {
    const Vector<3>& dN = rule_.slopes[term.place][a];
    const Matrix<3>& g = g_[term.place];
    return 0.5 * (dN[term.i] * g.col(term.j) + dN[term.j] * g.col(term.i));
  }

  const ShellRule& rule_;
  const ShellShape& shape_;
  const Vector<3>* gradients_;
  const double* weights_;
  std::array<Matrix<3>, ShellRule::max_places> G_, d_, g_;
  std::array<Matrix<3>, max_points> F_, strain_;
};

}  // namespace gabion::fem
