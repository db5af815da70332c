// SPDX-License-Identifier: BSD-3-Clause
#include "common/mechanics/materials/cam_clay_return.hpp"

#include <Eigen/LU>
#include <algorithm>
#include <limits>

#include "common/mechanics/materials/principal_update.hpp"
#include "common/mechanics/materials/yield_tolerance.hpp"

namespace gabion {
namespace {

/// Values that a return needs besides the law.
struct Problem {
  const CamClayParameters& law;
  const CamClayMemory& start;
  const StrainInvariants& trial;

  double hardening() const { return law.compression - law.swelling; }
  double stiffness() const {  // of the deviator, 1 / share = 1 + stiffness L
    return 6 * start.shear_modulus / (law.critical_ratio * law.critical_ratio);
  }
  double trial_shear() const {  // q / M [Pa]
    return 3 * start.shear_modulus * trial.distortion / law.critical_ratio;
  }
  /// Elastic volumetric strain at which P = ratio P_c.
  double strain_at_ratio(double ratio) const {
    const double rate = 1 / law.swelling + 1 / hardening();
    return (std::log(law.reference_pressure / (ratio * start.preconsolidation)) +
            trial.volumetric / hardening()) /
           rate;
  }
};

/// Pressure, deviator and yield function at one elastic volumetric strain, where the flow rule of
/// the volume gives the multiplier L.
struct Place {
  double P = 0, P_c = 0;    // [Pa]
  double L = 0;             // [1/Pa]
  double share = 1;         // of the deviator
  double f = 0, slope = 0;  // [Pa^2], by the strain
};

Place place_at(const Problem& problem, double volumetric) {
  Place at;
  const double change = problem.trial.volumetric - volumetric;
  at.P = problem.law.pressure_at(volumetric);
  at.P_c = problem.start.preconsolidation * std::exp(-change / problem.hardening());
  const double P_slope = -at.P / problem.law.swelling, P_c_slope = at.P_c / problem.hardening();
  const double flow = at.P_c - 2 * at.P;
  at.L = change / flow;
  const double L_slope = -(1 + at.L * (P_c_slope - 2 * P_slope)) / flow;
  at.share = 1 / (1 + problem.stiffness() * at.L);
  const double shear = at.share * problem.trial_shear();
  at.f = shear * shear + at.P * (at.P - at.P_c);
  at.slope = -2 * shear * shear * at.share * problem.stiffness() * L_slope - P_slope * flow -
             at.P * P_c_slope;
  return at;
}

/// f falls from the near end of the bracket, where it is positive, to the critical state, where L
/// is infinite and f = -P^2.
bool solve(const Problem& problem, Place& found) {
  const double critical = problem.strain_at_ratio(0.5);
  const bool wet = critical > problem.trial.volumetric;
  double above = problem.trial.volumetric, below = critical;  // f > 0, f < 0
  if (wet) above = std::max(above, problem.strain_at_ratio(1));
  const double rounding = std::numeric_limits<double>::epsilon() *
                          std::max(std::abs(problem.trial.volumetric), problem.law.swelling);
  double now = above;
  bool solved = std::abs(below - above) <= 8 * rounding;  // at the critical state
  for (int pass = 0; pass < 100 && !solved; ++pass) {
    const Place at = place_at(problem, now);
    (at.f > 0 ? above : below) = now;
    double next = now - at.f / at.slope;
    const bool inside = (next - above) * (next - below) < 0;
    if (!inside) next = std::abs(next - now) <= rounding ? now : 0.5 * (above + below);
    solved = std::abs(next - now) <= rounding || std::abs(below - above) <= rounding;
    now = next;
  }
  if (!solved) return false;
  found = place_at(problem, now);
  if (!(std::abs(found.P_c - 2 * found.P) > 0.2 * found.P_c)) {
    // Near the critical state L = 0 / 0 in the volume, but not in the deviator.
    found.share = std::min(1.0, std::sqrt(found.P * (found.P_c - found.P)) / problem.trial_shear());
    found.L = (1 / found.share - 1) / problem.stiffness();
  }
  return std::isfinite(found.P) && std::isfinite(found.L);
}

/// Derivatives of the three equations of the return: volume, deviator, f. In stresses by P_c,n.
Eigen::Matrix2d consistent_moduli(const Problem& problem, const Place& at) {
  const double unit = problem.start.preconsolidation;
  const double mu = problem.start.shear_modulus / unit;
  const double M_2 = problem.law.critical_ratio * problem.law.critical_ratio;
  const double P = at.P / unit, P_c = at.P_c / unit, L = at.L * unit;
  const double q = 3 * mu * at.share * problem.trial.distortion;
  const double K = P / problem.law.swelling, H = P_c / problem.hardening();
  const double f_p = P_c - 2 * P, f_q = 2 * q / M_2;
  Eigen::Matrix3d equations;
  equations << 1 + L * (2 * K + H), 0, f_p,  //
      0, 1 + 6 * L * mu / M_2, f_q,          //
      f_p * K - P * H, f_q * 3 * mu, 0;
  Eigen::Matrix<double, 3, 2> by_trial;
  by_trial << 1 + L * H, 0,  //
      0, 1,                  //
      -P * H, 0;
  const Eigen::Matrix<double, 3, 2> strains = equations.inverse() * by_trial;
  Eigen::Matrix2d moduli;
  moduli.row(0) = unit * K * strains.row(0);
  moduli.row(1) = unit * 3 * mu * strains.row(1);
  return moduli;
}

/// All pressure is gone but a; the deviator keeps what the ellipse bears there.
void open_volume(const Problem& problem, CamClayState& state) {
  const double a = problem.law.attraction, mu = problem.start.shear_modulus;
  const double most = std::sqrt(a * (problem.start.preconsolidation - a));
  const bool flows = problem.trial_shear() > most;
  state.region = YieldRegion::apex;
  state.volumetric = problem.law.strain_at(a);
  state.P = a;
  state.preconsolidation = problem.start.preconsolidation;
  state.share = flows ? most / problem.trial_shear() : 1;
  state.moduli << apex_stiffness * a / problem.law.swelling, 0,  //
      0, flows ? apex_stiffness * 3 * mu : 3 * mu;
}

}  // namespace

bool cam_clay_step(const CamClayParameters& law, const CamClayMemory& start,
                   const StrainInvariants& trial, CamClayState& state) {
  const Problem problem{law, start, trial};
  const double P = law.pressure_at(trial.volumetric), P_c = start.preconsolidation;
  const double shear = problem.trial_shear() / P_c, ratio = P / P_c;
  const double size = shear * shear + ratio * (ratio + 1);
  const double opens = law.attraction * (1 - yield_tolerance / law.swelling);
  const bool yields = ratio > 2 || shear * shear + ratio * (ratio - 1) > yield_tolerance * size;
  if (!yields) {
    state = {.volumetric = trial.volumetric, .preconsolidation = P_c, .P = P};
    state.moduli << P / law.swelling, 0, 0, 3 * start.shear_modulus;
    if (P < opens) open_volume(problem, state);
    return true;
  }
  Place found;
  if (!solve(problem, found)) return false;
  state = {.region = YieldRegion::shear,
           .volumetric = law.strain_at(found.P),
           .share = found.share,
           .preconsolidation = found.P_c,
           .P = found.P};
  if (found.P < opens) {
    open_volume(problem, state);
  } else {
    state.moduli = consistent_moduli(problem, found);
  }
  return true;
}

}  // namespace gabion
