// SPDX-License-Identifier: BSD-3-Clause
#include "common/mechanics/materials/lane_return.hpp"

#include "common/mechanics/materials/principal_update.hpp"
#include "common/mechanics/materials/yield_tolerance.hpp"

namespace gabion {

namespace {

// Where an argument is below this, the series is used for all lanes; otherwise each lane is
// computed by itself.
constexpr double small = 1.0 / 16;

Lanes artanh_series(const Lanes& s) {
  const Lanes q = s * s;
  return 1 + q * (1.0 / 3 +
                  q * (1.0 / 5 + q * (1.0 / 7 + q * (1.0 / 9 + q * (1.0 / 11 + q * (1.0 / 13))))));
}

}  // namespace

Lanes hencky_strain(const Lanes& e) {
  const Lanes s = e / (2 + e);
  if (any(abs(s) > small)) return each([](double x) { return gabion::hencky_strain(x); }, e);
  return s * artanh_series(s);
}

Lanes strain_from_hencky(const Lanes& eps) {
  const Lanes x = 2 * eps;
  if (any(abs(x) > small)) {
    return each([](double y) { return gabion::strain_from_hencky(y); }, eps);
  }
  constexpr double c[] = {1.0 / 2,   1.0 / 6,    1.0 / 24,    1.0 / 120,
                          1.0 / 720, 1.0 / 5040, 1.0 / 40320, 1.0 / 362880};
  Lanes sum = lanes(c[7]);
  for (int i = 6; i >= 0; --i) sum = c[i] + x * sum;
  return x * (1 + x * sum);
}

Lanes hencky_slope(const Lanes& b_0, const Lanes& b_1) {
  const Lanes sum = b_0 + b_1;
  const Lanes s = (b_0 - b_1) / sum;
  if (!any(abs(s) > small)) return artanh_series(s) / sum;
  Lanes slope;
  for (int l = 0; l < num_lanes; ++l) slope[l] = gabion::hencky_slope(b_0[l], b_1[l]);
  return slope;
}

LaneReturn::LaneReturn(const PrincipalMohrCoulomb& law) : law_(law) {
  apex_strain_ = law.strength / (law.k - 1) / (3 * law.lambda + 2 * law.mu);
  plane_stiffness_ = active_face(law, YieldFace::plane).stiffness(law);
  edge_stiffness_[0] = active_face(law, YieldFace::edge_12).stiffness(law);
  edge_stiffness_[1] = active_face(law, YieldFace::edge_23).stiffness(law);
}

Eigen::Matrix3d LaneReturn::moduli(Face face) const {
  switch (face) {
    case plane:
      return return_moduli(law_, YieldFace::plane);
    case edge_12:
      return return_moduli(law_, YieldFace::edge_12);
    case edge_23:
      return return_moduli(law_, YieldFace::edge_23);
    default:
      break;
  }
  Eigen::Matrix3d D = Eigen::Matrix3d::Constant(law_.lambda);
  D.diagonal().array() += 2 * law_.mu;
  return face == apex ? Eigen::Matrix3d(apex_stiffness * D) : D;
}

// See return_to_surface() and return_to_tresca() of one point.
void LaneReturn::return_to_surface(const PrincipalLanes& eps, const PrincipalLanes& tau,
                                   State& r) const {
  const double k = law_.k, m = law_.m;
  const Lanes on_plane = (k * tau[0] - tau[2] - law_.strength) / plane_stiffness_;
  const PrincipalLanes plastic = {m * on_plane, lanes(0), -on_plane};
  const PrincipalLanes flat = {eps[0] - plastic[0], eps[1], eps[2] - plastic[2]};
  const LaneMask yields = ~r.on[elastic];
  const LaneMask breaks_12 = yields & ~(flat[0] > flat[1]);
  const LaneMask breaks_23 = yields & ~(flat[1] > flat[2]);
  r.on[plane] = yields & ~breaks_12 & ~breaks_23;
  r.eps_e = choose(r.on[plane], flat, eps);
  r.plastic = choose(r.on[plane], plastic, {});
  if (!any(breaks_12 | breaks_23)) return;

  const Lanes mean_12 = 0.5 * (eps[0] + eps[1]), mean_23 = 0.5 * (eps[1] + eps[2]);
  const Lanes on_12 = (k * (tau[0] + tau[1]) - 2 * tau[2] - 2 * law_.strength) / edge_stiffness_[0];
  const Lanes on_23 = (2 * k * tau[0] - tau[1] - tau[2] - 2 * law_.strength) / edge_stiffness_[1];
  const Lanes pair_12 = mean_12 - m / 2 * on_12, pair_23 = mean_23 + 0.5 * on_23;
  const PrincipalLanes at_12 = {pair_12, pair_12, eps[2] + on_12};
  const PrincipalLanes at_23 = {eps[0] - m * on_23, pair_23, pair_23};
  const Lanes at_apex = lanes(apex_strain_);
  r.on[edge_12] = breaks_12 & (at_12[0] > at_12[2]);
  r.on[edge_23] = breaks_23 & ~r.on[edge_12] & (at_23[0] > at_23[2]);
  r.on[apex] = (breaks_12 | breaks_23) & ~r.on[edge_12] & ~r.on[edge_23];
  r.eps_e = choose(r.on[edge_12], at_12, r.eps_e);
  r.eps_e = choose(r.on[edge_23], at_23, r.eps_e);
  r.eps_e = choose(r.on[apex], {at_apex, at_apex, at_apex}, r.eps_e);
  for (int s = 0; s < 3; ++s) {
    r.plastic[s] = select(breaks_12 | breaks_23, eps[s] - r.eps_e[s], r.plastic[s]);
  }
}

LaneMask LaneReturn::yields(const PrincipalLanes& eps, const LaneStrength& surface) const {
  const PrincipalLanes tau = stress(eps);
  const Lanes first = abs(eps[0]), last = abs(eps[2]);
  const Lanes size = yield_tolerance * (law_.lambda + 2 * law_.mu) * (surface.k + 1);
  return surface.k * tau[0] - tau[2] - surface.strength > size * select(first > last, first, last);
}

LaneReturn::State LaneReturn::apply(const PrincipalLanes& eps) const {
  State r;
  const PrincipalLanes tau = stress(eps);
  const Lanes first = abs(eps[0]), last = abs(eps[2]);
  const double size = yield_tolerance * (law_.k + 1) * (law_.lambda + 2 * law_.mu);
  const LaneMask yields =
      law_.k * tau[0] - tau[2] - law_.strength > size * select(first > last, first, last);
  r.on[elastic] = ~yields;
  r.eps_e = eps;
  if (any(yields)) return_to_surface(eps, tau, r);
  return r;
}

}  // namespace gabion
