// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "mpm_solver/stress/point_terms.hpp"

namespace gabion::mpm {

/// Sums over the points of a group under F-bar.
struct GroupSums {
  double before = 0;    ///< sum V, volumes at the start of the step [m^3]
  double change = 0;    ///< sum V (J - 1) [m^3]
  double pressure = 0;  ///< sum p [N m], tension positive
  double coupling = 0;  ///< its derivative by ln J_bar

  /// v_p of a point with V (J - 1).
  double share(double V, double V_change) const { return (V + V_change) / (before + change); }
};

/// Four points of groups whose material sees the mean volume change of the group (F-bar),
///
///     1 + H_bar_p = s_p (1 + H_p) ,  s_p = (J_bar / J_p)^(1/dim) ,  J_p = det(1 + H_p) ,
///     J_bar = sum_p V_p J_p / sum_p V_p ,   f = sum_p V0_p P_p(H_bar_p) : d(H_bar_p)/du
///
/// in plane strain with the in-plane part, dim = 2. The forces do the work of the material's stress
/// on H_bar (variational form): each point keeps its own deviator and takes the group's mean
/// pressure, a law with a symmetric tangent gives a symmetric matrix. With
/// Q_p = V0_p s_p P_p, p_p = Q_p : F_p / dim, G_p = F_p^-T and v_p = V_p J_p / sum V J:
///
///     f = sum_p [Q_p + (v_p sum_q p_q - p_p) G_p] grad N
///
/// Soil whose nodes are all held along one direction n deforms in a plane. There F-bar averages the
/// volume change in that plane alone, as in two dimensions: with M = 1 - n (x) n and d = tr M = 2,
///
///     1 + H_bar_p = (1 + (s_p - 1) M) (1 + H_p) ,  s_p = (J_bar / J_p)^(1/d) ,
///     Q_p = V0_p (1 + (s_p - 1) M) P_p ,  p_p = Q_p : M F_p / d .
///
/// Otherwise M = 1 and d = dim.
///
/// Evaluated in three passes over the points; tensors stand row by row.
/// @see de Souza Neto, Peric, Dutko, Owen (1996) for F-bar; Moran, Ortiz, Shih (1990) for the
///      variational form; Coombs, Charlton, Cortis, Augarde (2018) for material points
template <int dim>
class AveragedBatch {
 public:
  static constexpr int n = dim * dim;
  /// Fields at the nodes that a point adds to, see PointTerms.
  enum Field { force, volume, left, right, num_fields };
  using Terms = PointTerms<dim, num_fields>;

  /// First pass.
  /// @param V            volumes at the start of the step [m^3]
  /// @param held_normal  n, in three dimensions; null: none. It outlives the batch.
  void start(const Lanes* H, const Lanes& V, const Vector<dim>* held_normal = nullptr);
  Lanes J() const { return 1 + J_change_; }
  double V(int lane) const { return V_[lane]; }
  double V_change(int lane) const { return V_change_[lane]; }

  /// Second pass: H_bar, and the stress that follows from it.
  /// @param mean_change  J_bar - 1
  void average(const Lanes& mean_change, Lanes* H_bar);
  /// @param batch  with P(H_bar) and, if `with_A`, dP/dH_bar, which is overwritten
  void set_stress(const Lanes& V0, PointBatch<dim>& batch, bool with_A);
  double pressure(int lane) const { return p_[lane]; }
  double coupling(int lane) const { return q_[lane]; }

  /// Third pass: terms of the points in the forces, or in forces, products and stiffness.
  /// @param share          v_p
  /// @param mean_pressure  v_p sum p
  /// @param A              of the batch after set_stress; becomes that of the forces
  void share_forces(const Lanes& mean_pressure, PointTerms<dim, 1>* to) const;
  void share_all(const Lanes& share, const Lanes& mean_pressure, Lanes* A, Terms* to) const;

 private:
  bool is_slice() const { return dim == 3 && normal_ != nullptr; }
  void keep_in_plane(Lanes* x) const;
  void stretch_in_plane(Lanes* x) const;
  void stretch_in_plane(PointBatch<dim>& batch) const;
  void find_forces(const Lanes& mean_pressure, Lanes* P) const;
  void add_to_tangent(const Lanes& mean_pressure, Lanes* A) const;

  const Vector<dim>* normal_ = nullptr;
  Lanes F_[n];
  Lanes J_change_;  // J - 1
  Lanes V_, V_change_;
  Lanes stretch_;   // s - 1
  Lanes G_[n];      // F^-T
  Lanes Q_[n];      // V0 s P_bar
  Lanes p_;         // Q : M F / d
  Lanes q_;         // derivative of p by ln J_bar
  Lanes left_[n];   // of Q - p G by ln J_bar
  Lanes right_[n];  // of p by H
};

}  // namespace gabion::mpm
