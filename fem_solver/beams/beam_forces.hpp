// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <cmath>

#include "fem_solver/beams/turn.hpp"

namespace gabion::fem {

/// Stiffness of a beam's section, on its axes 1 (from the first node to the second), 2 and 3.
struct BeamStiffness {
  Triple<double> force;   ///< E A, G A_2, G A_3 [N]
  Triple<double> moment;  ///< G J, E I_2, E I_3 [N m^2]
};

/// A beam in space without stress.
struct StraightBeam {
  Turn<double> frame;  ///< from the axes of space to its own
  double length = 0;   ///< [m]
};

/// A beam in the plane without stress.
struct StraightFrame {
  std::array<double, 2> direction;  ///< length 1
  double length = 0;                ///< [m]
};

/// Resultants of the section in the middle of a beam, on its own axes: action of the part of the
/// second node on that of the first.
template <class S>
struct SectionResultants {
  Triple<S> force;   ///< N, V_2, V_3 [N]
  Triple<S> moment;  ///< T, M_2, M_3 [N m]
};

/// Resultants and energy of a section for the strain and curvatures of its axis.
template <class S>
struct SectionAnswer {
  SectionResultants<S> forces;
  S energy;  ///< per length [J/m]
};

/// Forces and moments of a beam in space on its nodes, with its section resultants and energy.
template <class S>
struct BeamForces {
  Triple<S> n;         ///< on node 2; on node 1 the opposite [N]
  Triple<S> m_1, m_2;  ///< on spins of the nodes [N m]
  SectionResultants<S> section;
  S energy;    ///< [J]
  S relative;  ///< angle between the nodes [rad]
};

template <class S>
Triple<S> scaled(const Triple<double>& a, const Triple<S>& b) {
  return {S(a[0]) * b[0], S(a[1]) * b[1], S(a[2]) * b[2]};
}

/// Section with forces in proportion to the strains.
struct ElasticSection {
  BeamStiffness stiffness;

  template <class S>
  SectionAnswer<S> operator()(const Triple<S>& gamma, const Triple<S>& kappa) const {
    const SectionResultants<S> f = {scaled(stiffness.force, gamma),
                                    scaled(stiffness.moment, kappa)};
    return {f, S(0.5) * (dot(f.force, gamma) + dot(f.moment, kappa))};
  }
};

/// Geometrically exact beam between two nodes, with one point and a constant curvature
/// (docs/theory/structure.md).
/// @param chord     from node 1 to node 2 [m]
/// @param q_1, q_2  rotations of the nodes
/// @param section   gives a SectionAnswer for shear and stretch, twist and curvatures
template <class S, class Section>
BeamForces<S> beam_forces(const StraightBeam& beam, const Triple<S>& chord, const Turn<S>& q_1,
                          const Turn<S>& q_2, const Section& section) {
  const auto& [frame, length] = beam;
  using std::sqrt;
  const Turn<S> L_0{frame.w, {frame.v[0], frame.v[1], frame.v[2]}};
  const Triple<S> psi = vector_of(inverse(q_1) * q_2);
  const Triple<S> half = S(0.5) * psi;
  const Turn<S> middle = q_1 * turn_by(half) * L_0;
  const Triple<S> slope = S(1 / length) * chord;
  Triple<S> gamma = rotate(inverse(middle), slope);
  gamma[0] = gamma[0] - S(1.0);
  const Triple<S> kappa = S(1 / length) * rotate(inverse(L_0), psi);

  BeamForces<S> result;
  const SectionAnswer<S> answer = section(gamma, kappa);
  result.section = answer.forces;
  result.energy = S(length) * answer.energy;
  result.n = rotate(middle, result.section.force);
  const Triple<S> m = rotate(L_0, result.section.moment);
  const Triple<S> c = S(length) * cross(result.n, slope);
  // B^T c with B = 1/2 R_1 T(psi / 2) T(psi)^-1 R_1^T
  const Triple<S> c_1 = rotate(inverse(q_1), c);
  const Triple<S> share = m + S(0.5) * transposed_spin(half, c_1);
  result.m_2 = rotate(q_1, transposed_inverse_spin(psi, share));
  result.m_1 = c - result.m_2;
  result.relative = value_of(dot(psi, psi)) > 0 ? sqrt(dot(psi, psi)) : S(0.0);
  return result;
}

/// Forces and moments of a beam in the plane, where moments and rotations are about the third axis.
template <class S>
struct FrameForces {
  std::array<S, 2> n;  ///< on node 2 [N]
  S m_1, m_2;          ///< [N m]
  S N, V, M;           ///< of the section in the middle
  S energy;            ///< [J]
};

/// @param chord     from node 1 to node 2 [m]
/// @param t_1, t_2  angles of the nodes
template <class S, class Section>
FrameForces<S> frame_forces(const StraightFrame& beam, const std::array<S, 2>& chord, const S& t_1,
                            const S& t_2, const Section& section) {
  const auto& [direction, length] = beam;
  using std::cos, std::sin;
  const S angle = S(0.5) * (t_1 + t_2), c = cos(angle), s = sin(angle);
  const S e_x = c * S(direction[0]) - s * S(direction[1]);
  const S e_y = s * S(direction[0]) + c * S(direction[1]);
  const S x = S(1 / length) * chord[0], y = S(1 / length) * chord[1];
  const S gamma_1 = e_x * x + e_y * y - S(1.0), gamma_2 = e_x * y - e_y * x;
  const S kappa = S(1 / length) * (t_2 - t_1);
  FrameForces<S> result;
  const S none = 0.0;
  const SectionAnswer<S> answer =
      section(Triple<S>{gamma_1, gamma_2, none}, Triple<S>{none, none, kappa});
  result.N = answer.forces.force[0];
  result.V = answer.forces.force[1];
  result.M = answer.forces.moment[2];
  result.energy = S(length) * answer.energy;
  result.n = {result.N * e_x - result.V * e_y, result.N * e_y + result.V * e_x};
  const S arm = S(0.5 * length) * (result.n[0] * y - result.n[1] * x);
  result.m_1 = arm - result.M;
  result.m_2 = arm + result.M;
  return result;
}

}  // namespace gabion::fem
