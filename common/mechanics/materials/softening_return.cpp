// SPDX-License-Identifier: BSD-3-Clause
#include "common/mechanics/materials/softening_return.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

namespace gabion {
namespace {

using Eigen::Vector3d;

constexpr double root_two_thirds = 0.81649658092772603;

Vector3d deviator(const Vector3d& x) {
  return (x.array() - x.sum() / 3).matrix();
}

// (1 + s) / (1 - s) and its derivative.
double ratio(double s) {
  return (1 + s) / (1 - s);
}
double ratio_slope(double s) {
  return 2 / ((1 - s) * (1 - s));
}

// a . C b.
double product(const PrincipalMohrCoulomb& law, const Vector3d& a, const Vector3d& b) {
  return law.lambda * a.sum() * b.sum() + 2 * law.mu * a.dot(b);
}

PrincipalReturn closed_form(const SofteningSurface& surface, const SoftenedConstants& now,
                            const Vector3d& eps, const Vector3d& tau_trial) {
  const auto shear = surface.frictional ? return_to_surface : return_to_tresca;
  if (now.tension_cutoff == no_cutoff) return shear(now.law, eps, tau_trial);
  return return_to_cut_off(now.law, now.tension_cutoff, eps, tau_trial, shear);
}

// d eps_e / d kappa on the plane or an edge, at constant trial strain.
Vector3d shear_slope(const SoftenedConstants& now, YieldFace face, const Vector3d& tau_trial) {
  const ActiveFace active = active_face(now.law, face);
  Vector3d a_slope, c_slope;
  double twice = 2;
  if (face == YieldFace::edge_12) {
    a_slope = {now.k_slope, now.k_slope, 0};
    c_slope = {now.m_slope / 2, now.m_slope / 2, 0};
  } else {
    if (face == YieldFace::plane) twice = 1;
    a_slope = {twice * now.k_slope, 0, 0};
    c_slope = {now.m_slope, 0, 0};
  }
  const double stiffness = active.stiffness(now.law), S = active.multiplier(now.law, tau_trial);
  const double stiffness_slope =
      product(now.law, a_slope, active.c) + product(now.law, active.a, c_slope);
  const double S_slope =
      (a_slope.dot(tau_trial) - twice * now.strength_slope - S * stiffness_slope) / stiffness;
  return -S_slope * active.c - S * c_slope;
}

// d eps_e / d kappa on any face, at constant trial strain.
Vector3d strain_slope(const SoftenedConstants& now, YieldFace face, const Vector3d& tau_trial) {
  const PrincipalMohrCoulomb& law = now.law;
  const double bulk = 3 * law.lambda + 2 * law.mu, T = now.cutoff_slope;
  switch (face) {
    case YieldFace::apex: {
      const double below = law.k - 1;
      const double apex = (now.strength_slope - law.strength / below * now.k_slope) / below;
      return Vector3d::Constant(apex / bulk);
    }
    case YieldFace::tension_123:
      return Vector3d::Constant(T / bulk);
    case YieldFace::tension_12: {
      const double each = T / (2 * (law.lambda + law.mu));
      return {each, each, 0};
    }
    case YieldFace::tension_1:
      return {T / (law.lambda + 2 * law.mu), 0, 0};
    case YieldFace::shear_tension:
    case YieldFace::corner_12:
    case YieldFace::corner_23: {
      const double t_3 = now.k_slope * now.tension_cutoff + law.k * T - now.strength_slope;
      const double nu = 0.5 * law.lambda / (law.lambda + law.mu);
      const double t_2 = face == YieldFace::corner_12   ? T
                         : face == YieldFace::corner_23 ? t_3
                                                        : nu * (T + t_3);
      return strain_of_stress(law, {T, t_2, t_3});
    }
    default:
      return shear_slope(now, face, tau_trial);
  }
}

struct Residual {
  double r = 0, slope = 0;
};

// r and dr/dkappa at `returned.kappa`; fills the rest of `returned`.
Residual residual_at(const SofteningSurface& surface, const ShearSoFar& before, const Vector3d& eps,
                     const Vector3d& tau_trial, SofteningReturn& returned) {
  returned.constants = surface.in_step(before, returned.kappa);
  returned.state = closed_form(surface, returned.constants, eps, tau_trial);
  const Vector3d flow = deviator(returned.state.plastic);
  const double size = flow.norm();
  returned.direction = size > 0 ? Vector3d(root_two_thirds / size * flow) : Vector3d::Zero();
  returned.eps_e_slope = strain_slope(returned.constants, returned.state.face, tau_trial);
  returned.slope = 1 + returned.direction.dot(returned.eps_e_slope);
  return {returned.kappa - root_two_thirds * size, returned.slope};
}

}  // namespace

SoftenedConstants SofteningSurface::at(double x, double rate) const {
  if (x < 0) x = rate = 0;
  const auto [value, slope] = curve.at(x);
  SoftenedConstants now;
  const double k = ratio(value.sin_friction);
  now.law = {.lambda = lambda,
             .mu = mu,
             .k = k,
             .m = ratio(value.sin_dilation),
             .strength = 2 * value.cohesion * std::sqrt(k)};
  now.k_slope = rate * ratio_slope(value.sin_friction) * slope.sin_friction;
  now.m_slope = rate * ratio_slope(value.sin_dilation) * slope.sin_dilation;
  now.strength_slope =
      2 * rate * slope.cohesion * std::sqrt(k) + value.cohesion * now.k_slope / std::sqrt(k);
  if (cutoff_share != no_cutoff) {
    now.tension_cutoff = cutoff_share * value.cohesion;
    now.cutoff_slope = cutoff_share * rate * slope.cohesion;
  }
  return now;
}

SoftenedConstants SofteningSurface::in_step(const ShearSoFar& before, double kappa) const {
  SoftenedConstants now = at(before.x + before.rate * kappa, before.rate);
  if (rate_gain.gain == 0) return now;
  // The shear rate is sqrt(3) kappa / dt.
  const double width = 2 * rate_gain.reference * before.dt / std::numbers::sqrt3;
  const double share = rate_gain.gain / std::numbers::ln10;
  const double factor = 1 + share * std::asinh(kappa / width);
  const double slope = share / std::hypot(kappa, width);
  now.strength_slope = factor * now.strength_slope + slope * now.law.strength;
  now.law.strength *= factor;
  if (now.tension_cutoff != no_cutoff) {
    now.cutoff_slope = factor * now.cutoff_slope + slope * now.tension_cutoff;
    now.tension_cutoff *= factor;
  }
  return now;
}

bool solve_softening_return(const SofteningSurface& surface, const ShearSoFar& before,
                            const Vector3d& eps, const Vector3d& tau_trial,
                            SofteningReturn& returned) {
  constexpr int most_passes = 60;
  const double rounding = 4 * std::numeric_limits<double>::epsilon() * eps.cwiseAbs().maxCoeff();
  double low = 0, high = std::numeric_limits<double>::infinity();
  returned.kappa = 0;
  Residual now = residual_at(surface, before, eps, tau_trial, returned);
  if (!(now.slope > 0)) return false;
  for (int pass = 0; pass < most_passes; ++pass) {
    if (std::abs(now.r) <= rounding + 1e-15 * returned.kappa) return now.slope > 0;
    (now.r < 0 ? low : high) = returned.kappa;
    double next = returned.kappa - now.r / now.slope;
    if (!(now.slope > 0) || !(next > low && next < high)) {
      next = std::isinf(high) ? 2 * low + root_two_thirds * eps.norm() : 0.5 * (low + high);
    }
    if (next == low || next == high) return now.slope > 0;  // neighbouring numbers
    returned.kappa = next;
    now = residual_at(surface, before, eps, tau_trial, returned);
  }
  return false;
}

Eigen::Matrix3d softening_moduli(const SofteningReturn& returned) {
  const PrincipalMohrCoulomb& law = returned.constants.law;
  const YieldFace face = returned.state.face;
  const Eigen::Matrix3d D =
      region_of(face) == YieldRegion::shear ? return_moduli(law, face) : cut_off_moduli(law, face);
  Vector3d along = returned.direction;  // (1 - C^-1 D)^T direction
  for (int j = 0; j < 3; ++j) along[j] -= returned.direction.dot(strain_of_stress(law, D.col(j)));
  const Vector3d& v = returned.eps_e_slope;
  const Vector3d Cv = (law.lambda * v.sum() + 2 * law.mu * v.array()).matrix();
  return D + Cv / returned.slope * along.transpose();
}

double snap_back(const SofteningSurface& surface, double rate, double pressure) {
  double largest = 0;
  std::vector<YieldFace> faces = {YieldFace::plane, YieldFace::edge_12, YieldFace::edge_23};
  for (const double x : surface.curve.samples()) {
    const SoftenedConstants now = surface.at(x, rate);
    const double loss = std::max(0.0, -now.k_slope) * pressure - now.strength_slope;
    for (const YieldFace face : faces) {
      const ActiveFace active = active_face(now.law, face);
      const double twice = face == YieldFace::plane ? 1 : 2;
      largest = std::max(largest, twice * loss / active.stiffness(now.law) * root_two_thirds *
                                      deviator(active.c).norm());
    }
  }
  return largest;
}

}  // namespace gabion
