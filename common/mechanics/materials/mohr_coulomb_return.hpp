// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Core>
#include <cmath>

namespace gabion {

/// Mohr-Coulomb in principal axes: elastic constants, k and m, apex strength 2 c sqrt(k).
struct PrincipalMohrCoulomb {
  double lambda;    ///< [Pa]
  double mu;        ///< [Pa]
  double k;         ///< (1 + sin phi) / (1 - sin phi) > 1
  double m;         ///< the same of psi, 1 <= m <= k
  double strength;  ///< 2 c sqrt(k) [Pa]
};

enum class YieldRegion { plane, edge_12, edge_23, apex };

/// State after the return; principal values sorted like the trial strains.
struct PrincipalReturn {
  YieldRegion region;
  Eigen::Vector3d eps_e;    ///< elastic Hencky strain
  Eigen::Vector3d plastic;  ///< plastic strain of this step, trial minus elastic
};

/// What the plane and the edges have in common: eps_e = average(eps) - S c with the multiplier
/// S = (a . tau_trial - strength) / (a . C c). An edge is the sum of its two planes; there, the two
/// equal stresses are averaged.
struct ActiveFace {
  YieldRegion region;
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

inline ActiveFace active_face(const PrincipalMohrCoulomb& law, YieldRegion region) {
  switch (region) {
    case YieldRegion::edge_12:
      return {region, {law.k, law.k, -2}, {law.m / 2, law.m / 2, -1}, 2 * law.strength};
    case YieldRegion::edge_23:
      return {region, {2 * law.k, -1, -1}, {law.m, -0.5, -0.5}, 2 * law.strength};
    default:
      return {YieldRegion::plane, {law.k, 0, -1}, {law.m, 0, -1}, law.strength};
  }
}

/// Whether the return gives the sorted principal values i and j the same stress.
inline bool made_equal(YieldRegion region, int i, int j) {
  switch (region) {
    case YieldRegion::plane:
      return false;
    case YieldRegion::edge_12:
      return i + j == 1;
    case YieldRegion::edge_23:
      return i + j == 3;
    default:
      return true;
  }
}

/// Replace the two strains that an edge makes equal by their mean.
inline Eigen::Vector3d averaged(const Eigen::Vector3d& eps, YieldRegion region) {
  if (region == YieldRegion::edge_12) {
    const double mean = 0.5 * (eps[0] + eps[1]);
    return {mean, mean, eps[2]};
  }
  if (region == YieldRegion::edge_23) {
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
  const ActiveFace plane = active_face(law, YieldRegion::plane);
  const Eigen::Vector3d plastic = plane.multiplier(law, tau_trial) * plane.c;
  const Eigen::Vector3d on_plane = eps - plastic;
  const bool breaks_12 = !(on_plane[0] > on_plane[1]);
  const bool breaks_23 = !(on_plane[1] > on_plane[2]);
  if (!breaks_12 && !breaks_23) return {YieldRegion::plane, on_plane, plastic};

  for (const YieldRegion region : {YieldRegion::edge_12, YieldRegion::edge_23}) {
    if (!(region == YieldRegion::edge_12 ? breaks_12 : breaks_23)) continue;
    const ActiveFace edge = active_face(law, region);
    const Eigen::Vector3d eps_e = averaged(eps, region) - edge.multiplier(law, tau_trial) * edge.c;
    if (eps_e[0] > eps_e[2]) return {region, eps_e, eps - eps_e};
  }
  const double mean = law.strength / (law.k - 1) / (3 * law.lambda + 2 * law.mu);
  const Eigen::Vector3d eps_e = Eigen::Vector3d::Constant(mean);
  return {YieldRegion::apex, eps_e, eps - eps_e};
}

/// d tau / d eps of the returned stress. At the apex, where the stress is constant, it is zero.
inline Eigen::Matrix3d return_moduli(const PrincipalMohrCoulomb& law, YieldRegion region) {
  if (region == YieldRegion::apex) return Eigen::Matrix3d::Zero();
  const ActiveFace face = active_face(law, region);
  const Eigen::Vector3d Ca = (law.lambda * face.a.sum() + 2 * law.mu * face.a.array()).matrix();
  const Eigen::Vector3d Cc = (law.lambda * face.c.sum() + 2 * law.mu * face.c.array()).matrix();
  Eigen::Matrix3d D = -Cc / face.stiffness(law) * Ca.transpose();
  D.array() += law.lambda;
  for (int i = 0; i < 3; ++i) D.col(i) += 2 * law.mu * averaged(Eigen::Vector3d::Unit(i), region);
  return D;
}

}  // namespace gabion
