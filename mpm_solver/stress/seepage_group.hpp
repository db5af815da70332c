// SPDX-License-Identifier: BSD-3-Clause
// Of SeepageForces alone: what it finds of a group of points.
#pragma once

#include <array>
#include <vector>

#include "mpm_solver/stress/seepage_forces.hpp"

namespace gabion::mpm {

/// One point of a group in the step.
template <int dim>
struct SeepageForces<dim>::Work {
  std::int32_t entry = 0;
  double V = 0, V0 = 0, j = 1, m = 0;  // at the start, free of stress; volume ratio; pores over V0
  double p = 0, p_n = 0;
  double borne = 0, borne_n = 0, borne_slope = 1;  // pressure that acts on the grains at p, at p_n;
                                                   // derivative by p
  double grown = 1, change = 0;              // water that pores hold by that at the start; - 1
  double held_slope = 0;                     // of the volume of its water by p [m^3/Pa]
  double density = 1;                        // of the water under p_n, by that free of pressure
  Vector<dim> grad_p = Vector<dim>::Zero();  // at the end of the step
  double kappa = 0, kappa_slope = 0;         // mobility, d ln kappa / d ln J
  double kappa_by_p = 0;                     // d ln kappa / dp [1/Pa]
  Vector<dim> w = Vector<dim>::Zero();       // flux of Darcy [m/s]
  double p_pool = 0;                         // of pools, at the start
  Vector<dim> p_pool_slope = Vector<dim>::Zero();
  std::array<Vector<dim>, max_group_nodes<dim>> g;  // of each of its nodes
};

/// The points of a group and their sums.
template <int dim>
struct SeepageForces<dim>::Group {
  std::array<double, max_group_nodes<dim> * dim> du;
  std::array<double, max_group_nodes<dim>> q, change_of_q;
  std::vector<Work> points;
  double V = 0, Vj = 0, pV = 0, p_nV = 0, p_poolV = 0, borneV = 0, borne_nV = 0;
  double density = 0;                                    // mean
  std::array<double, max_group_nodes<dim>> N;            // mean of each node
  std::array<double, max_group_nodes<dim>> borne_N;      // of its share in the pressure borne
  std::array<Vector<dim>, max_group_nodes<dim>> change;  // d(sum V j) / du of each node
  std::array<double, max_group_nodes<dim>> compressed;   // V (grown - 1) at each node
  std::array<std::int32_t, max_group_nodes<dim>> active;
  std::vector<double> K;  // row by row

  /// Pressure of the pools at a point, and of its water beyond that, which the skeleton carries.
  double pool_pressure(const Work& point, bool averages) const {
    return averages ? p_poolV / V : point.p_pool;
  }
  double excess(const Work& point, bool averages) const {
    return averages ? (borneV - p_poolV) / V : point.borne - point.p_pool;
  }
};

}  // namespace gabion::mpm
