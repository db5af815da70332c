// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Cholesky>
#include <array>
#include <concepts>
#include <span>

#include "fem_solver/materials/cell_material.hpp"
#include "fem_solver/materials/elastic_log_stress.hpp"
#include "fem_solver/stress/enhanced_strain.hpp"

namespace gabion::fem {

/// Cell whose logarithmic strain is enhanced, E = E(u) + M alpha (docs/theory/structure.md, (T16)
/// to (T18)); with small strain the symmetric part of H is. The modes are found from the accepted
/// ones, so that forces are a function of accepted state and displacement alone.
/// @tparam Kinematics  how E(u) depends on the nodes, and the modes: BrickKinematics, ...
template <class Law, class Kinematics>
class EnhancedCell {
 public:
  static constexpr int dim = Kinematics::dim, num_nodes = Kinematics::num_nodes,
                       num_modes = Kinematics::num_modes, num_dofs = num_nodes * dim;
  static constexpr bool small_strain = Kinematics::small_strain;
  using Modes = Eigen::Matrix<double, num_modes, 1>;
  using Forces = Eigen::Matrix<double, num_dofs, 1>;
  using Stiffness = Eigen::Matrix<double, num_dofs, num_dofs, Eigen::RowMajor>;

  /// @param of_kinematics  that the kinematics are made from
  template <class... Args>
  explicit EnhancedCell(const Law& law, const Args&... of_kinematics)
      : law_(law), kinematics_(of_kinematics...) {}

  /// Find the modes that balance, from those of the history.
  /// @param u          of the nodes [m]
  /// @param history_n  accepted: points x history_size of the law, then the modes
  /// @param history    at the end of the step
  /// @returns          null, or what is wrong with the cell
  const char* balance(std::span<const Vector<dim>> u, std::span<const double> history_n,
                      std::span<double> history) {
    if (!kinematics_.move(u)) return "det F <= 0";
    for (int q = 0; q < num_points(); ++q) {
      if (!find_strain(q)) return "det F <= 0";
    }
    alpha_ = Eigen::Map<const Modes>(history_n.data() + history_n.size() - num_modes);
    // Quadratic convergence takes 2 to 4; the floor is what rounding of the modes leaves.
    constexpr int max_iterations = 30;
    constexpr double tolerance = 1e-12, floor = 1e-15;
    for (int iteration = 0; iteration < max_iterations; ++iteration) {
      Modes h = Modes::Zero();
      ModeStiffness K_aa = ModeStiffness::Zero();
      double size = 0;
      for (int q = 0; q < num_points(); ++q) {
        find_stress(q, history_n, history);
        const auto& M = kinematics_.modes(q);
        const double w = kinematics_.weight(q);
        const Modes h_q = w * (M.transpose() * strain_vector<dim>(in_plane<dim>(stress_[q].T)));
        h += h_q;
        size += h_q.norm();
        K_aa.noalias() += w * (M.transpose() * (stress_[q].D * M).eval());
      }
      // A cell that flows in shear without hardening has no stiffness against modes along the flow,
      // and no force either: the term added there changes neither.
      K_aa.diagonal().array() += 1e-10 * K_aa.diagonal().maxCoeff();
      factor_.compute(K_aa);
      if (factor_.info() != Eigen::Success) return "enhanced strain without stiffness";
      if (h.norm() <= tolerance * size + floor * K_aa.norm()) {
        Eigen::Map<Modes>(history.data() + history.size() - num_modes) = alpha_;
        return nullptr;
      }
      alpha_ -= factor_.solve(h);
    }
    return "enhanced strain without balance";
  }

  // The members below hold after balance():
  double energy() const {
    double sum = 0;
    for (int q = 0; q < num_points(); ++q) sum += kinematics_.weight(q) * stress_[q].energy;
    return sum;
  }
  /// int B^T S
  Forces forces() const {
    Forces f = Forces::Zero();
    for (int q = 0; q < num_points(); ++q) {
      kinematics_.add_forces(q, green_at(q, /*with_tangent=*/false).S, f);
    }
    return f;
  }
  /// K_uu - K_ua K_aa^-1 K_au
  void find_stiffness(Stiffness& K) const {
    K.setZero();
    Eigen::Matrix<double, num_modes, num_dofs> K_au;
    K_au.setZero();
    for (int q = 0; q < num_points(); ++q) {
      const GreenStress<dim> green = green_at(q, /*with_tangent=*/true);
      const auto B = kinematics_.strain_by_nodes(q);
      const StrainByNodes<dim, num_dofs> DB = kinematics_.weight(q) * (green.D * B);
      K.noalias() += B.transpose() * DB;
      const StrainMatrix<dim> D_slopes = kinematics_.weight(q) * (stress_[q].D * slopes_[q]);
      K_au.noalias() += (kinematics_.modes(q).transpose() * D_slopes).eval() * B;
      if (!small_strain) kinematics_.add_geometric(q, green.S, K);
    }
    K.noalias() -= K_au.transpose() * factor_.solve(K_au);
  }
  /// Kirchhoff stress, R T~ R^T turned as U of the enhanced strain asks [Pa].
  Symmetric<dim> kirchhoff_stress(int q) const {
    if constexpr (small_strain) return stress_[q].T;
    const LogStrain<dim> enhanced = log_strain_of<dim>(enhanced_strain(q));
    const StrainMatrix<dim> slopes = log_by_green<dim>(enhanced);
    const GreenStress<dim> green = turned_to_green<dim>(enhanced, slopes, stress_[q], false);
    const Matrix<dim> F = kinematics_.rotation(q, strain_[q]) * stretch<dim>(enhanced, 1);
    Symmetric<dim> tau = symmetric<dim>(F * strain_tensor<dim>(green.S) * F.transpose());
    if constexpr (dim == 2) tau[2] = stress_[q].T[2];
    return tau;
  }
  /// Ratio of volumes, with enhancement; 1 with small strain.
  double volume_ratio(int q) const {
    return small_strain ? 1 : std::exp(trace<dim>(enhanced_strain(q)));
  }

 private:
  using ModeStiffness = Eigen::Matrix<double, num_modes, num_modes>;

  int num_points() const { return kinematics_.num_points(); }

  /// Strain of the displacements. @returns false when it is none
  bool find_strain(int q) {
    if constexpr (small_strain) {
      strain_[q].E = symmetric<dim>(kinematics_.strain(q));
      slopes_[q].setIdentity();
      return true;
    }
    if (!find_log_strain<dim>(kinematics_.strain(q), strain_[q])) return false;
    slopes_[q] = log_by_green<dim>(strain_[q]);
    return true;
  }

  Symmetric<dim> enhanced_strain(int q) const {
    return strain_[q].E +
           symmetric<dim>(strain_tensor<dim>(StrainVector<dim>(kinematics_.modes(q) * alpha_)));
  }

  void find_stress(int q, std::span<const double> history_n, std::span<double> history) {
    const Symmetric<dim> E = enhanced_strain(q);
    if constexpr (LawWithHistory<Law>) {
      constexpr std::size_t size = Law::history_size;
      law_.log_stress(E, history_n.subspan(q * size, size), history.subspan(q * size, size),
                      stress_[q]);
    } else {
      log_stress<dim>(law_, E, stress_[q]);
    }
  }

  GreenStress<dim> green_at(int q, bool with_tangent) const {
    if constexpr (small_strain) {
      return {.S = strain_vector<dim>(in_plane<dim>(stress_[q].T)), .D = stress_[q].D};
    } else {
      return turned_to_green<dim>(strain_[q], slopes_[q], stress_[q], with_tangent);
    }
  }

  const Law& law_;
  Kinematics kinematics_;
  Modes alpha_;
  std::array<LogStrain<dim>, Kinematics::max_points> strain_;     // of the displacements
  std::array<StrainMatrix<dim>, Kinematics::max_points> slopes_;  // log_by_green() of these
  std::array<LogStress<dim>, Kinematics::max_points> stress_;     // of the enhanced strains
  Eigen::LLT<ModeStiffness> factor_;
};

}  // namespace gabion::fem
