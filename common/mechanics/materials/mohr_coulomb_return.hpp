// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Core>
#include <cmath>

namespace gabion {

/// Mohr-Coulomb in principal axes: elastic constants, k and m, strength 2 c sqrt(k). Tresca is
/// k = m = 1.
struct PrincipalMohrCoulomb {
  double lambda;    ///< [Pa]
  double mu;        ///< [Pa]
  double k;         ///< (1 + sin phi) / (1 - sin phi) >= 1
  double m;         ///< (1 + sin psi) / (1 - sin psi), 1 <= m <= k
  double strength;  ///< 2 c sqrt(k) [Pa]
};

enum class YieldFace {
  plane,
  edge_12,  ///< t1 = t2
  edge_23,  ///< t2 = t3
  apex,
  tension_1,  ///< with a cut-off T: t1 = T
  tension_12,
  tension_123,
  shear_tension,  ///< plane and t1 = T
  corner_12,      ///< edge_12 and t1 = t2 = T
  corner_23       ///< edge_23 and t1 = T
};

/// State after the return; principal values sorted like the trial strains.
struct PrincipalReturn {
  YieldFace face;
  Eigen::Vector3d eps_e;    ///< elastic Hencky strain
  Eigen::Vector3d plastic;  ///< plastic strain of this step, trial minus elastic
};

/// Plane or edge to which a stress returns: eps_e = average(eps) - S c with the multiplier S = (a .
/// tau_trial - strength) / (a . C c). An edge is the sum of its two planes; there, the two equal
/// stresses are averaged.
struct ActiveFace {
  YieldFace face;
  Eigen::Vector3d a;  ///< gradient of the (summed) yield function
  Eigen::Vector3d c;  ///< (averaged) flow direction
  double strength;    ///< [Pa]

  double multiplier(const PrincipalMohrCoulomb& law, const Eigen::Vector3d& tau_trial) const {
    return (a.dot(tau_trial) - strength) / stiffness(law);
  }
  double stiffness(const PrincipalMohrCoulomb& law) const {
    return law.lambda * a.sum() * c.sum() + 2 * law.mu * a.dot(c);
  }
};

inline ActiveFace active_face(const PrincipalMohrCoulomb& law, YieldFace face) {
  switch (face) {
    case YieldFace::edge_12:
      return {face, {law.k, law.k, -2}, {law.m / 2, law.m / 2, -1}, 2 * law.strength};
    case YieldFace::edge_23:
      return {face, {2 * law.k, -1, -1}, {law.m, -0.5, -0.5}, 2 * law.strength};
    default:
      return {YieldFace::plane, {law.k, 0, -1}, {law.m, 0, -1}, law.strength};
  }
}

/// Whether the return gives the sorted principal values i and j the same stress.
inline bool made_equal(YieldFace face, int i, int j) {
  switch (face) {
    case YieldFace::edge_12:
    case YieldFace::tension_12:
    case YieldFace::corner_12:
      return i + j == 1;
    case YieldFace::edge_23:
    case YieldFace::corner_23:
      return i + j == 3;
    case YieldFace::apex:
    case YieldFace::tension_123:
      return true;
    default:
      return false;
  }
}

/// Replace the two strains that an edge makes equal by their mean.
inline Eigen::Vector3d averaged(const Eigen::Vector3d& eps, YieldFace face) {
  if (face == YieldFace::edge_12) {
    const double mean = 0.5 * (eps[0] + eps[1]);
    return {mean, mean, eps[2]};
  }
  if (face == YieldFace::edge_23) {
    const double mean = 0.5 * (eps[1] + eps[2]);
    return {eps[0], mean, mean};
  }
  return eps;
}

/// Closed-form return of a trial state outside the yield surface.
///
/// The plane return stands if it keeps the order of the stresses. Otherwise the broken order names
/// the edge, whose two multipliers are then positive; it stands below the apex. The apex is left
/// for states that neither edge can take: with 0 < psi, one edge parameter beyond the apex is not
/// enough (de Souza Neto, Peric and Owen 2008, section 8.2; Clausen, Damkilde and Andersen 2007).
///
/// @param eps        trial Hencky strain, descending
/// @param tau_trial  trial Kirchhoff stress of eps [Pa]
/// @pre   k tau_1 - tau_3 > strength
inline PrincipalReturn return_to_surface(const PrincipalMohrCoulomb& law,
                                         const Eigen::Vector3d& eps,
                                         const Eigen::Vector3d& tau_trial) {
  const ActiveFace plane = active_face(law, YieldFace::plane);
  const Eigen::Vector3d plastic = plane.multiplier(law, tau_trial) * plane.c;
  const Eigen::Vector3d on_plane = eps - plastic;
  const bool breaks_12 = !(on_plane[0] > on_plane[1]);
  const bool breaks_23 = !(on_plane[1] > on_plane[2]);
  if (!breaks_12 && !breaks_23) return {YieldFace::plane, on_plane, plastic};

  for (const YieldFace face : {YieldFace::edge_12, YieldFace::edge_23}) {
    if (!(face == YieldFace::edge_12 ? breaks_12 : breaks_23)) continue;
    const ActiveFace edge = active_face(law, face);
    const Eigen::Vector3d eps_e = averaged(eps, face) - edge.multiplier(law, tau_trial) * edge.c;
    if (eps_e[0] > eps_e[2]) return {face, eps_e, eps - eps_e};
  }
  const double mean = law.strength / (law.k - 1) / (3 * law.lambda + 2 * law.mu);
  const Eigen::Vector3d eps_e = Eigen::Vector3d::Constant(mean);
  return {YieldFace::apex, eps_e, eps - eps_e};
}

/// return_to_surface() for k = m = 1 and strength > 0, which has no apex: the plane return breaks
/// at most one of the two orders, and the edge returns keep tau_1 - tau_3 = strength.
inline PrincipalReturn return_to_tresca(const PrincipalMohrCoulomb& law, const Eigen::Vector3d& eps,
                                        const Eigen::Vector3d& tau_trial) {
  const ActiveFace plane = active_face(law, YieldFace::plane);
  const Eigen::Vector3d plastic = plane.multiplier(law, tau_trial) * plane.c;
  const Eigen::Vector3d on_plane = eps - plastic;
  const bool breaks_12 = !(on_plane[0] > on_plane[1]);
  if (!breaks_12 && on_plane[1] > on_plane[2]) return {YieldFace::plane, on_plane, plastic};
  const YieldFace face = breaks_12 ? YieldFace::edge_12 : YieldFace::edge_23;
  const ActiveFace edge = active_face(law, face);
  const Eigen::Vector3d eps_e = averaged(eps, face) - edge.multiplier(law, tau_trial) * edge.c;
  return {face, eps_e, eps - eps_e};
}

/// d tau / d eps of the returned stress. At the apex, where the stress is constant, it is zero.
inline Eigen::Matrix3d return_moduli(const PrincipalMohrCoulomb& law, YieldFace face) {
  if (face == YieldFace::apex) return Eigen::Matrix3d::Zero();
  const ActiveFace active = active_face(law, face);
  const Eigen::Vector3d &a = active.a, &c = active.c;
  const Eigen::Vector3d Ca = (law.lambda * a.sum() + 2 * law.mu * a.array()).matrix();
  const Eigen::Vector3d Cc = (law.lambda * c.sum() + 2 * law.mu * c.array()).matrix();
  Eigen::Matrix3d D = -Cc / active.stiffness(law) * Ca.transpose();
  D.array() += law.lambda;
  for (int i = 0; i < 3; ++i) D.col(i) += 2 * law.mu * averaged(Eigen::Vector3d::Unit(i), face);
  return D;
}

}  // namespace gabion
