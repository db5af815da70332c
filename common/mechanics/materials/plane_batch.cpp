// SPDX-License-Identifier: BSD-3-Clause
#include "common/mechanics/materials/plane_batch.hpp"

#include "common/mechanics/materials/principal_update.hpp"
#include "common/mechanics/materials/yield_tolerance.hpp"

namespace gabion {

namespace {

/// Three principal values of four points.
struct Principal {
  Lanes x[3];

  Lanes& operator[](int k) { return x[k]; }
  const Lanes& operator[](int k) const { return x[k]; }
  Lanes sum() const { return x[0] + x[1] + x[2]; }
  Lanes squares() const { return x[0] * x[0] + x[1] * x[1] + x[2] * x[2]; }
};

/// See hencky_stress() of one point.
Principal stress_of(const PrincipalMohrCoulomb& law, const Principal& eps) {
  const Lanes pressure = law.lambda * eps.sum();
  return {pressure + 2 * law.mu * eps[0], pressure + 2 * law.mu * eps[1],
          pressure + 2 * law.mu * eps[2]};
}

Principal choose(const LaneMask& mask, const Principal& a, const Principal& b) {
  return {mask ? a[0] : b[0], mask ? a[1] : b[1], mask ? a[2] : b[2]};
}

// The series of the scalar functions hold for all lanes, or each lane goes its own way.
constexpr double small = 1.0 / 16;

Lanes artanh_series(const Lanes& s) {
  const Lanes q = s * s;
  return 1 + q * (1.0 / 3 +
                  q * (1.0 / 5 + q * (1.0 / 7 + q * (1.0 / 9 + q * (1.0 / 11 + q * (1.0 / 13))))));
}

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

}  // namespace

/// Trial state: in the plane v[0] >= v[1]; v[2] belongs to the axis out of it.
struct PlaneReturn::Trial {
  Lanes F_inverse[4];  // 00, 01, 10, 11
  Lanes J;
  LaneBlock e;
  Principal v;
  Lanes cos_2t, sin_2t;
  LaneMask above_0, above_1;  // v[2] > v[0], v[2] > v[1]
  Principal eps;              // in descending order, with the gap
  Lanes gap;

  bool admissible() const { return !any(J <= 0) && !any(v[1] <= -1) && !any(v[2] <= -1); }
  Principal sorted(const Principal& x) const {
    return {above_0 ? x[2] : x[0], above_0 ? x[0] : (above_1 ? x[2] : x[1]), above_1 ? x[1] : x[2]};
  }
  Principal on_axes(const Principal& x) const {
    return {above_0 ? x[1] : x[0], above_1 ? x[2] : x[1], above_0 ? x[0] : (above_1 ? x[1] : x[2])};
  }
  /// The tensor that has these values on the axes.
  LaneBlock compose(const Principal& on_axes) const {
    const Lanes mean = 0.5 * (on_axes[0] + on_axes[1]), radius = 0.5 * (on_axes[0] - on_axes[1]);
    return {mean + radius * cos_2t, mean - radius * cos_2t, on_axes[2], radius * sin_2t};
  }
};

/// State after the return, in descending order.
struct PlaneReturn::Returned {
  Principal eps_e, plastic{};
  Principal tau;  // of eps_e, on the axes
  LaneMask on[num_faces]{};
};

PlaneReturn::PlaneReturn(const PrincipalMohrCoulomb& law, bool keeps_gap)
    : law_(law), keeps_gap_(keeps_gap) {
  apex_strain_ = law.strength / (law.k - 1) / (3 * law.lambda + 2 * law.mu);
  constexpr YieldFace faces[] = {YieldFace::plane, YieldFace::edge_12, YieldFace::edge_23};
  plane_stiffness_ = active_face(law, faces[0]).stiffness(law);
  for (int k = 0; k < 2; ++k) edge_stiffness_[k] = active_face(law, faces[1 + k]).stiffness(law);
  for (int face = 0; face < num_faces; ++face) {
    Eigen::Matrix3d D;
    if (face == elastic || face == apex) {
      D.setConstant(law.lambda);
      D.diagonal().array() += 2 * law.mu;
      if (face == apex) D *= apex_stiffness;
    } else {
      D = return_moduli(law, faces[face - plane]);
    }
    for (int out = 0; out < 3; ++out) {
      const int first = out == 0 ? 1 : 0, second = out == 2 ? 1 : 2;
      moduli_[face][out][0] = D(first, first);
      moduli_[face][out][1] = D(first, second);
      moduli_[face][out][2] = D(second, first);
      moduli_[face][out][3] = D(second, second);
    }
  }
}

PlaneReturn::Trial PlaneReturn::trial_of(const PlaneBatch& batch) {
  Trial t;
  LaneBlock columns, e;  // of H
  columns.load(batch.H[0].data(), batch.H[1].data(), batch.H[2].data(), batch.H[3].data());
  e.load(batch.state_n[0]->e.data(), batch.state_n[1]->e.data(), batch.state_n[2]->e.data(),
         batch.state_n[3]->e.data());
  for (int l = 0; l < num_lanes; ++l) t.gap[l] = batch.state_n[l]->gap;
  const Lanes &H00 = columns[0], &H10 = columns[1], &H01 = columns[2], &H11 = columns[3];
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
  t.cos_2t = radius > 0 ? half / radius : lanes(1);
  t.sin_2t = radius > 0 ? t.e[3] / radius : lanes(0);
  t.above_0 = t.v[2] > t.v[0];
  t.above_1 = t.v[2] > t.v[1];
  return t;
}

// See return_to_surface() and return_to_tresca() of one point.
void PlaneReturn::return_to_surface(const Trial& t, const Lanes (&tau)[3], Returned& r) const {
  const double k = law_.k, m = law_.m;
  const Principal& eps = t.eps;
  const Lanes on_plane = (k * tau[0] - tau[2] - law_.strength) / plane_stiffness_;
  const Principal plastic = {m * on_plane, lanes(0), -on_plane};
  const Principal flat = {eps[0] - plastic[0], eps[1], eps[2] - plastic[2]};
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
  const Principal at_12 = {pair_12, pair_12, eps[2] + on_12};
  const Principal at_23 = {eps[0] - m * on_23, pair_23, pair_23};
  const Lanes at_apex = lanes(apex_strain_);
  r.on[edge_12] = breaks_12 & (at_12[0] > at_12[2]);
  r.on[edge_23] = breaks_23 & ~r.on[edge_12] & (at_23[0] > at_23[2]);
  r.on[apex] = (breaks_12 | breaks_23) & ~r.on[edge_12] & ~r.on[edge_23];
  r.eps_e = choose(r.on[edge_12], at_12, r.eps_e);
  r.eps_e = choose(r.on[edge_23], at_23, r.eps_e);
  r.eps_e = choose(r.on[apex], {at_apex, at_apex, at_apex}, r.eps_e);
  for (int s = 0; s < 3; ++s) {
    r.plastic[s] = breaks_12 | breaks_23 ? eps[s] - r.eps_e[s] : r.plastic[s];
  }
}

PlaneReturn::Returned PlaneReturn::return_of(const Trial& t) const {
  Returned r;
  const Principal tau = stress_of(law_, t.eps);
  const Lanes largest = abs(t.eps[0]) > abs(t.eps[2]) ? abs(t.eps[0]) : abs(t.eps[2]);
  const double size = yield_tolerance * (law_.k + 1) * (law_.lambda + 2 * law_.mu);
  const LaneMask yields = law_.k * tau[0] - tau[2] - law_.strength > size * largest;
  r.on[elastic] = ~yields;
  r.eps_e = t.eps;
  if (any(yields)) return_to_surface(t, tau.x, r);
  r.tau = t.on_axes(stress_of(law_, r.eps_e));
  return r;
}

void PlaneReturn::store(const Trial& t, const Returned& r, PlaneBatch& batch) const {
  auto& out = batch.out;
  const Lanes volumetric = r.eps_e.sum();
  const LaneBlock tau = t.compose(r.tau);
  const Lanes* G = t.F_inverse;
  const LaneBlock P = {tau[0] * G[0] + tau[3] * G[1], tau[3] * G[0] + tau[1] * G[1],
                       tau[0] * G[2] + tau[3] * G[3], tau[3] * G[2] + tau[1] * G[3]};
  const Lanes energy = 0.5 * law_.lambda * volumetric * volumetric + law_.mu * r.eps_e.squares();
  const LaneMask changed = ~r.on[elastic] | (t.gap != 0);
  LaneBlock e = t.e, increment{};
  Lanes gap{}, plastic{};
  if (any(changed)) {
    const Principal strain = {strain_from_hencky(r.eps_e[0]), strain_from_hencky(r.eps_e[1]),
                              strain_from_hencky(r.eps_e[2])};
    const LaneBlock returned = t.compose(t.on_axes(strain));
    const Lanes third = t.gap / 3;
    Principal not_elastic, kept = r.plastic;
    for (int s = 0; s < 3; ++s) not_elastic[s] = t.eps[s] - third - r.eps_e[s];
    increment = t.compose(t.on_axes(not_elastic));
    for (int c = 0; c < 4; ++c) {
      e[c] = changed ? returned[c] : t.e[c];
      increment[c] = changed ? increment[c] : lanes(0);
    }
    if (keeps_gap_) gap = r.on[apex] ? kept.sum() : lanes(0);
    for (int s = 0; s < 3; ++s) kept[s] -= gap / 3;
    plastic = sqrt(kept.squares());
  }
  P.store(out[0].P.data(), out[1].P.data(), out[2].P.data(), out[3].P.data());
  tau.store(out[0].tau.data(), out[1].tau.data(), out[2].tau.data(), out[3].tau.data());
  e.store(out[0].state.e.data(), out[1].state.e.data(), out[2].state.e.data(),
          out[3].state.e.data());
  increment.store(out[0].plastic_increment.data(), out[1].plastic_increment.data(),
                  out[2].plastic_increment.data(), out[3].plastic_increment.data());
  for (int l = 0; l < num_lanes; ++l) {
    out[l].state.gap = gap[l];
    out[l].state.plastic_strain = batch.state_n[l]->plastic_strain + plastic[l];
    out[l].J = t.J[l];
    out[l].energy = energy[l];
    out[l].region = r.on[elastic][l] ? YieldRegion::elastic
                    : r.on[apex][l]  ? YieldRegion::apex
                                     : YieldRegion::shear;
  }
}

// See spectral_tangent<2>() of one point.
void PlaneReturn::store_tangent(const Trial& t, const Returned& r, PlaneBatch& batch) const {
  LaneBlock D;  // 00, 01, 10, 11
  {
    const double* rows[num_lanes];
    for (int l = 0; l < num_lanes; ++l) {
      const int out = t.above_0[l] ? 0 : t.above_1[l] ? 1 : 2;
      int face = elastic;
      for (const Face other : {plane, edge_12, edge_23, apex}) face = r.on[other][l] ? other : face;
      rows[l] = moduli_[face][out];
    }
    D.load(rows[0], rows[1], rows[2], rows[3]);
  }
  const Principal plastic = t.on_axes(r.plastic);
  const Lanes &tau_0 = r.tau[0], &tau_1 = r.tau[1];
  const Lanes b_0 = 1 + t.v[0], b_1 = 1 + t.v[1];
  const Lanes elastic_G = 2 * law_.mu * hencky_slope(b_0, b_1);
  const Lanes change = plastic[0] - plastic[1];
  Lanes G = elastic_G - (change != 0 ? 2 * law_.mu * change / (t.v[0] - t.v[1]) : lanes(0));
  const LaneMask equal = (r.on[edge_12] & ~t.above_1) | (r.on[edge_23] & t.above_0);
  G = equal ? lanes(0) : r.on[apex] ? apex_stiffness * elastic_G : G;

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
  LaneBlock rows[4];
  for (int c = 0; c < 4; ++c) {
    const Lanes q = c < 2 ? -d[2 + c] : d[c - 2], w = c < 2 ? f[2 + c] : -f[c - 2];
    const Lanes u = u_1 * f[c] + u_d * d[c], v = v_1 * f[c] + v_d * d[c];
    const Lanes y = y_q * q + difference_b * w, z = difference_b * q + z_w * w;
    const Lanes stretch = t.cos_2t * v - t.sin_2t * y, shear = t.sin_2t * v + t.cos_2t * y;
    for (int J = 0; J < 2; ++J) {
      rows[J][c] = f[J] * (u + stretch) + f[2 + J] * (shear + z);
      rows[2 + J][c] = f[J] * (shear - z) + f[2 + J] * (u - stretch);
    }
  }
  auto& A = batch.A;
  for (int i = 0; i < 4; ++i) {
    rows[i].store(A[0]->data() + 4 * i, A[1]->data() + 4 * i, A[2]->data() + 4 * i,
                  A[3]->data() + 4 * i);
  }
}

bool PlaneReturn::update(PlaneBatch& batch, bool with_A) const {
  Trial trial = trial_of(batch);
  if (!trial.admissible()) return false;
  trial.eps = trial.sorted(
      {hencky_strain(trial.v[0]), hencky_strain(trial.v[1]), hencky_strain(trial.v[2])});
  for (int s = 0; s < 3; ++s) trial.eps[s] += trial.gap / 3;
  const Returned returned = return_of(trial);
  store(trial, returned, batch);
  if (with_A) store_tangent(trial, returned, batch);
  return true;
}

}  // namespace gabion
