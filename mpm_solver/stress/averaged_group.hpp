// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <span>
#include <vector>

#include "mpm_solver/stress/cell_forces.hpp"

namespace gabion::mpm {

/// The points of one group under F-bar: the material sees the mean volume change of the group,
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
/// A group is evaluated in three passes over its points.
/// @see de Souza Neto, Peric, Dutko, Owen (1996) for F-bar; Moran, Ortiz, Shih (1990) for the
///      variational form; Coombs, Charlton, Cortis, Augarde (2018) for material points
template <int dim>
class AveragedGroup {
 public:
  /// Sums over the points: after the first pass, and after the second.
  struct Volumes {
    double before = 0;  ///< sum V [m^3]
    double change = 0;  ///< sum V (J - 1) [m^3]
  };
  Volumes volumes;
  double pressure = 0;  ///< sum p [N m], tension positive

  void start() {
    volumes = {};
    pressure = 0;
    coupling_ = 0;
    points_.clear();
  }
  /// First pass. @param V  volume at the start of the step [m^3]
  /// @returns J of the point
  double add_point(const Matrix<dim>& H, double V);

  /// Second pass: H_bar of the k-th point, and the stress that follows from it.
  /// @param P_bar, A  P(H_bar) and dP/dH_bar; A may be null
  Matrix<dim> averaged_gradient(std::size_t k);
  void set_stress(std::size_t k, double V0, const Matrix<dim>& P_bar, const Tangent<dim>* A);
  /// J_bar' / J_bar by the displacements of the group's nodes, num_nodes x dim [1/m].
  void add_volume_gradient(const PointWeights<dim>& weights, const CellGroup& group,
                           double* gradient) const;

  /// Third pass: add the forces and, unless `gradient` is null, set their derivative.
  /// @param gradient  that of add_volume_gradient
  void add_forces(const PointWeights<dim>& weights, const CellGroup& group, const double* gradient,
                  CellForces<dim>& sum) const;

 private:
  struct Point {
    Matrix<dim> H;
    double change;       // J - 1
    double V;            // at the start of the step
    double stretch = 0;  // s - 1
    Flat<dim> G;         // (1 + H)^-T
    Flat<dim> Q;         // V0 s P_bar
    double p;            // Q : F / dim
    Tangent<dim> A;      // V0 s^2 dP_bar/dH_bar
    double q;            // derivative of p by ln J_bar
    Flat<dim> left;      // of Q - p G by ln J_bar
    Flat<dim> right;     // of p by H
  };
  static Tangent<dim> tangent(const Point& point, double mean_pressure);
  void add_stiffness(const PointWeights<dim>& weights, const CellGroup& group,
                     const double* gradient, CellForces<dim>& sum) const;
  double share(const Point& point) const {
    return point.V * (1 + point.change) / (volumes.before + volumes.change);
  }

  std::vector<Point> points_;
  double coupling_ = 0;  // derivative of sum p by ln J_bar
};

}  // namespace gabion::mpm
