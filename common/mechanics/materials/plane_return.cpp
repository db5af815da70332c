// SPDX-License-Identifier: BSD-3-Clause
#include "common/mechanics/materials/plane_return.hpp"

#include "common/mechanics/materials/principal_update.hpp"

namespace gabion {

/// Trial state: in the plane v[0] >= v[1]; v[2] belongs to the axis out of it.
struct PlaneReturn::Trial {
  Lanes F_inverse[4];  // 00, 01, 10, 11
  Lanes J;
  LaneBlock e;
  PrincipalLanes v;
  Lanes cos_2t, sin_2t;
  LaneMask above_0, above_1;  // v[2] > v[0], v[2] > v[1]
  PrincipalLanes eps;         // in descending order, with the gap
  Lanes gap, plastic_strain;

  bool admissible() const { return !any(J <= 0) && !any(v[1] <= -1) && !any(v[2] <= -1); }
  PrincipalLanes sorted(const PrincipalLanes& x) const {
    return {select(above_0, x[2], x[0]), select(above_0, x[0], select(above_1, x[2], x[1])),
            select(above_1, x[1], x[2])};
  }
  PrincipalLanes on_axes(const PrincipalLanes& x) const {
    return {select(above_0, x[1], x[0]), select(above_1, x[2], x[1]),
            select(above_0, x[0], select(above_1, x[1], x[2]))};
  }
  /// The tensor that has these values on the axes.
  LaneBlock compose(const PrincipalLanes& on_axes) const {
    const Lanes mean = 0.5 * (on_axes[0] + on_axes[1]), radius = 0.5 * (on_axes[0] - on_axes[1]);
    return {mean + radius * cos_2t, mean - radius * cos_2t, on_axes[2], radius * sin_2t};
  }
};

/// State after the return, and its stress on the axes.
struct PlaneReturn::Returned : LaneReturn::State {
  PrincipalLanes tau;
};

PlaneReturn::PlaneReturn(const PrincipalMohrCoulomb& law, bool keeps_gap)
    : return_(law), law_(law), keeps_gap_(keeps_gap) {
  for (int face = 0; face < LaneReturn::num_faces; ++face) {
    const Eigen::Matrix3d D = return_.moduli(static_cast<LaneReturn::Face>(face));
    for (int out = 0; out < 3; ++out) {
      const int first = out == 0 ? 1 : 0, second = out == 2 ? 1 : 2;
      moduli_[face][out][0] = D(first, first);
      moduli_[face][out][1] = D(first, second);
      moduli_[face][out][2] = D(second, first);
      moduli_[face][out][3] = D(second, second);
    }
  }
}

[[gnu::always_inline]] inline PlaneReturn::Trial PlaneReturn::trial_of(const PointBatch<2>& batch) {
  Trial t;
  LaneBlock e;
  e.load(batch.state_n[0]->e.data(), batch.state_n[1]->e.data(), batch.state_n[2]->e.data(),
         batch.state_n[3]->e.data());
  for (int l = 0; l < num_lanes; ++l) {
    t.gap[l] = batch.state_n[l]->gap;
    t.plastic_strain[l] = batch.state_n[l]->plastic_strain;
  }
  const Lanes &H00 = batch.H[0], &H01 = batch.H[1], &H10 = batch.H[2], &H11 = batch.H[3];
  const Lanes F00 = 1 + H00, F11 = 1 + H11;
  t.J = 1 + (H00 + H11 + (H00 * H11 - H01 * H10));
  const Lanes over_J = 1 / t.J;
  t.F_inverse[0] = F11 * over_J;
  t.F_inverse[1] = -H01 * over_J;
  t.F_inverse[2] = -H10 * over_J;
  t.F_inverse[3] = F00 * over_J;

  const Lanes Fe00 = F00 * e[0] + H01 * e[3], Fe01 = F00 * e[3] + H01 * e[1];
  const Lanes Fe10 = H10 * e[0] + F11 * e[3], Fe11 = H10 * e[3] + F11 * e[1];
  t.e[0] = Fe00 * F00 + Fe01 * H01 + (2 * H00 + (H00 * H00 + H01 * H01));
  t.e[1] = Fe10 * H10 + Fe11 * F11 + (2 * H11 + (H10 * H10 + H11 * H11));
  t.e[2] = e[2];
  t.e[3] = Fe00 * H10 + Fe01 * F11 + (H01 + H10 + (H00 * H10 + H01 * H11));

  const Lanes mean = 0.5 * (t.e[0] + t.e[1]), half = 0.5 * (t.e[0] - t.e[1]);
  const Lanes radius = sqrt(half * half + t.e[3] * t.e[3]);
  t.v = {mean + radius, mean - radius, t.e[2]};
  t.cos_2t = select(radius > 0, half / radius, lanes(1));
  t.sin_2t = select(radius > 0, t.e[3] / radius, Lanes{});
  t.above_0 = t.v[2] > t.v[0];
  t.above_1 = t.v[2] > t.v[1];
  return t;
}

[[gnu::always_inline]] inline void PlaneReturn::store(const Trial& t, const Returned& r,
                                                      PointBatch<2>& batch) const {
  const BatchResults<2>& out = batch.out;
  const Lanes volumetric = r.eps_e.sum();
  const LaneBlock tau = t.compose(r.tau);
  const Lanes* G = t.F_inverse;
  batch.P[0] = tau[0] * G[0] + tau[3] * G[1];
  batch.P[1] = tau[0] * G[2] + tau[3] * G[3];
  batch.P[2] = tau[3] * G[0] + tau[1] * G[1];
  batch.P[3] = tau[3] * G[2] + tau[1] * G[3];
  const Lanes energy = 0.5 * law_.lambda * volumetric * volumetric + law_.mu * r.eps_e.squares();
  const LaneMask changed = ~r.on[LaneReturn::elastic] | (t.gap != 0);
  LaneBlock e = t.e, increment{};
  Lanes gap{}, plastic{};
  if (any(changed)) {
    const PrincipalLanes strain = {strain_from_hencky(r.eps_e[0]), strain_from_hencky(r.eps_e[1]),
                                   strain_from_hencky(r.eps_e[2])};
    const LaneBlock returned = t.compose(t.on_axes(strain));
    const Lanes third = t.gap / 3;
    PrincipalLanes not_elastic, kept = r.plastic;
    for (int s = 0; s < 3; ++s) not_elastic[s] = t.eps[s] - third - r.eps_e[s];
    increment = t.compose(t.on_axes(not_elastic));
    for (int c = 0; c < 4; ++c) {
      e[c] = select(changed, returned[c], t.e[c]);
      increment[c] = select(changed, increment[c], Lanes{});
    }
    if (keeps_gap_) gap = select(r.on[LaneReturn::apex], kept.sum(), Lanes{});
    for (int s = 0; s < 3; ++s) kept[s] -= gap / 3;
    plastic = sqrt(kept.squares());
  }
  const auto store_four = [](const LaneBlock& x, Symmetric<2>* to) {
    x.store(to[0].data(), to[1].data(), to[2].data(), to[3].data());
  };
  store_four(tau, out.tau);
  store_four(increment, out.plastic_increment);
  e.store(out.state[0].e.data(), out.state[1].e.data(), out.state[2].e.data(),
          out.state[3].e.data());
  plastic += t.plastic_strain;
  for (int l = 0; l < num_lanes; ++l) {
    out.state[l].plastic_strain = plastic[l];
    out.state[l].gap = gap[l];
  }
  store_lanes(t.J, out.J);
  store_lanes(energy, out.energy);
  constexpr int shear = static_cast<int>(YieldRegion::shear);
  constexpr int apex = static_cast<int>(YieldRegion::apex);
  const LaneMask region = ~r.on[LaneReturn::elastic] &
                          ((r.on[LaneReturn::apex] & apex) | (~r.on[LaneReturn::apex] & shear));
  for (int l = 0; l < num_lanes; ++l) out.region[l] = static_cast<YieldRegion>(region[l]);
}

// See spectral_tangent<2>() of one point.
[[gnu::always_inline]] inline void PlaneReturn::store_tangent(const Trial& t, const Returned& r,
                                                              PointBatch<2>& batch) const {
  LaneBlock D;  // 00, 01, 10, 11
  const LaneMask yields = ~r.on[LaneReturn::elastic];
  if (any(yields)) {
    const auto number = [](int face) { return 3 * face; };
    const LaneMask place = (r.on[LaneReturn::plane] & number(LaneReturn::plane)) |
                           (r.on[LaneReturn::edge_12] & number(LaneReturn::edge_12)) |
                           (r.on[LaneReturn::edge_23] & number(LaneReturn::edge_23)) |
                           (r.on[LaneReturn::apex] & number(LaneReturn::apex));
    const LaneMask out = ~t.above_0 & ((t.above_1 & 1) | (~t.above_1 & 2));
    const PlaneModuli* const all = moduli_[0];
    D.load(all[place[0] + out[0]], all[place[1] + out[1]], all[place[2] + out[2]],
           all[place[3] + out[3]]);
  } else {
    for (int k = 0; k < 4; ++k) D[k] = lanes(moduli_[LaneReturn::elastic][0][k]);
  }
  const PrincipalLanes plastic = t.on_axes(r.plastic);
  const Lanes &tau_0 = r.tau[0], &tau_1 = r.tau[1];
  const Lanes b_0 = 1 + t.v[0], b_1 = 1 + t.v[1];
  const Lanes elastic_G = 2 * law_.mu * hencky_slope(b_0, b_1);
  const Lanes change = plastic[0] - plastic[1];
  Lanes G = elastic_G - select(change != 0, 2 * law_.mu * change / (t.v[0] - t.v[1]), Lanes{});
  const LaneMask equal =
      (r.on[LaneReturn::edge_12] & ~t.above_1) | (r.on[LaneReturn::edge_23] & t.above_0);
  G = select(equal, Lanes{}, select(r.on[LaneReturn::apex], apex_stiffness * elastic_G, G));

  const Lanes D00 = D[0] - tau_0, D11 = D[3] - tau_1;
  const Lanes sum_b = G * (b_0 + b_1), difference_b = G * (b_1 - b_0);
  const Lanes twice_mixed = sum_b - (tau_0 + tau_1);
  const Lanes u_1 = D00 + D[1] + D[2] + D11, u_d = D00 - D[1] + D[2] - D11;
  const Lanes v_1 = D00 + D[1] - D[2] - D11, v_d = D00 - D[1] - D[2] + D11;
  const Lanes y_q = sum_b + twice_mixed, z_w = sum_b - twice_mixed;
  const Lanes f[4] = {0.5 * t.F_inverse[0], 0.5 * t.F_inverse[2], 0.5 * t.F_inverse[1],
                      0.5 * t.F_inverse[3]};  // f_0, f_1 of one point
  Lanes d[4];
  for (int J = 0; J < 2; ++J) {
    d[J] = t.cos_2t * f[J] + t.sin_2t * f[2 + J];
    d[2 + J] = t.sin_2t * f[J] - t.cos_2t * f[2 + J];
  }
  Lanes* A = batch.A;
  for (int c = 0; c < 4; ++c) {
    const Lanes q = c < 2 ? -d[2 + c] : d[c - 2], w = c < 2 ? f[2 + c] : -f[c - 2];
    const Lanes u = u_1 * f[c] + u_d * d[c], v = v_1 * f[c] + v_d * d[c];
    const Lanes y = y_q * q + difference_b * w, z = difference_b * q + z_w * w;
    const Lanes stretch = t.cos_2t * v - t.sin_2t * y, shear = t.sin_2t * v + t.cos_2t * y;
    for (int J = 0; J < 2; ++J) {
      A[4 * J + c] = f[J] * (u + stretch) + f[2 + J] * (shear + z);
      A[4 * (2 + J) + c] = f[J] * (shear - z) + f[2 + J] * (u - stretch);
    }
  }
}

bool PlaneReturn::update(PointBatch<2>& batch, bool with_A) const {
  Trial trial = trial_of(batch);
  if (!trial.admissible()) return false;
  trial.eps = trial.sorted(
      {hencky_strain(trial.v[0]), hencky_strain(trial.v[1]), hencky_strain(trial.v[2])});
  for (int s = 0; s < 3; ++s) trial.eps[s] += trial.gap / 3;
  const LaneReturn::State state = return_.apply(trial.eps);
  const Returned returned{state, trial.on_axes(return_.stress(state.eps_e))};
  store(trial, returned, batch);
  if (with_A) store_tangent(trial, returned, batch);
  return true;
}

LaneMask PlaneReturn::update_elastic(PointBatch<2>& batch, const LaneStrength& surface,
                                     bool with_A) const {
  Trial trial = trial_of(batch);
  if (!trial.admissible()) return LaneMask{};
  trial.eps = trial.sorted(
      {hencky_strain(trial.v[0]), hencky_strain(trial.v[1]), hencky_strain(trial.v[2])});
  for (int s = 0; s < 3; ++s) trial.eps[s] += trial.gap / 3;
  const LaneMask elastic = ~return_.yields(trial.eps, surface);
  if (!any(elastic)) return LaneMask{};
  const LaneReturn::State state = LaneReturn::elastic_state(trial.eps);
  const Returned returned{state, trial.on_axes(return_.stress(state.eps_e))};
  store(trial, returned, batch);
  if (with_A) store_tangent(trial, returned, batch);
  return elastic;
}

}  // namespace gabion
