// SPDX-License-Identifier: BSD-3-Clause
#include "common/mechanics/materials/space_return.hpp"

#include <algorithm>
#include <utility>

#include "common/mechanics/materials/principal_update.hpp"
#include "common/mechanics/simd/lane_tensors.hpp"

namespace gabion {

namespace {

// Symmetric tensors: xx, yy, zz, xy, yz, xz. Place of the component ab among them.
constexpr int place[3][3] = {{0, 3, 5}, {3, 1, 4}, {5, 4, 2}};

/// Axes: n[a][s] is component a of the axis of principal value s.
using AxesLanes = Lanes[3][3];

// See rotate() of spectral.cpp; where A_pq is negligible nothing turns.
void rotate(Lanes (&A)[6], AxesLanes& n, int p, int q, const LaneMask& turns) {
  const int r = 3 - p - q, pp = place[p][p], qq = place[q][q], pq = place[p][q];
  const Lanes ratio = (A[qq] - A[pp]) / (2 * A[pq]);
  const Lanes size = 1 / (abs(ratio) + sqrt(1 + ratio * ratio));
  const Lanes t = select(turns, select(ratio < 0, -size, size), Lanes{});
  const Lanes c = 1 / sqrt(1 + t * t), s = t * c;
  const Lanes shift = t * A[pq];
  A[pp] -= shift;
  A[qq] += shift;
  A[pq] = select(turns, Lanes{}, A[pq]);
  Lanes &A_rp = A[place[r][p]], &A_rq = A[place[r][q]];
  const Lanes rp = A_rp, rq = A_rq;
  A_rp = c * rp - s * rq;
  A_rq = s * rp + c * rq;
  for (int a = 0; a < 3; ++a) {
    const Lanes n_p = n[a][p], n_q = n[a][q];
    n[a][p] = c * n_p - s * n_q;
    n[a][q] = s * n_p + c * n_q;
  }
}

// See eigenpairs<3>() of one point. A becomes diagonal.
void find_axes(Lanes (&A)[6], AxesLanes& n) {
  for (int a = 0; a < 3; ++a) {
    for (int s = 0; s < 3; ++s) n[a][s] = lanes(a == s ? 1 : 0);
  }
  Lanes largest = abs(A[0]);
  for (int k = 1; k < 6; ++k) largest = select(abs(A[k]) > largest, abs(A[k]), largest);
  const Lanes negligible = 1e-18 * largest;
  constexpr int max_sweeps = 20;
  for (int sweep = 0; sweep < max_sweeps; ++sweep) {
    bool rotated = false;
    for (const auto& [p, q] : {std::pair{0, 1}, {0, 2}, {1, 2}}) {
      const LaneMask turns = abs(A[place[p][q]]) > negligible;
      if (!any(turns)) continue;
      rotate(A, n, p, q, turns);
      rotated = true;
    }
    if (!rotated) break;
  }
}

void order(PrincipalLanes& v, AxesLanes& n, int s, int t) {
  const LaneMask wrong = v[s] < v[t];
  const auto exchange = [&wrong](Lanes& x, Lanes& y) {
    const Lanes old = x;
    x = select(wrong, y, x);
    y = select(wrong, old, y);
  };
  exchange(v[s], v[t]);
  for (int a = 0; a < 3; ++a) exchange(n[a][s], n[a][t]);
}

// The tensor that has these values on the axes.
void compose(const PrincipalLanes& value, const AxesLanes& n, Lanes (&x)[6]) {
  for (int a = 0; a < 3; ++a) {
    const Lanes scaled[3] = {value[0] * n[a][0], value[1] * n[a][1], value[2] * n[a][2]};
    for (int b = a; b < 3; ++b) {
      x[place[a][b]] = scaled[0] * n[b][0] + scaled[1] * n[b][1] + scaled[2] * n[b][2];
    }
  }
}

void store_four(const Lanes (&x)[6], Symmetric<3>* to) {
  LaneBlock{{x[0], x[1], x[2], x[3]}}.store(to[0].data(), to[1].data(), to[2].data(), to[3].data());
  for (int k = 4; k < 6; ++k) {
    for (int l = 0; l < num_lanes; ++l) to[l][k] = x[k][l];
  }
}

}  // namespace

struct SpaceReturn::Trial {
  Lanes F_inverse[9];
  Lanes J;
  Lanes e[6];
  PrincipalLanes v;  // descending
  AxesLanes n;
  PrincipalLanes eps;  // with the gap
  Lanes gap, plastic_strain;

  bool admissible() const { return !any(J <= 0) && !any(v[2] <= -1); }
};

/// State after the return, and its stress.
struct SpaceReturn::Returned : LaneReturn::State {
  PrincipalLanes tau;
};

SpaceReturn::SpaceReturn(const PrincipalMohrCoulomb& law, bool keeps_gap)
    : return_(law), keeps_gap_(keeps_gap) {
  for (int face = 0; face < LaneReturn::num_faces; ++face) {
    const Eigen::Matrix3d D = return_.moduli(static_cast<LaneReturn::Face>(face));
    for (int k = 0; k < 9; ++k) moduli_[face][k] = D(k / 3, k % 3);
  }
}

SpaceReturn::Trial SpaceReturn::trial_of(const PointBatch<3>& batch) {
  Trial t;
  const Lanes* H = batch.H;
  Lanes F[9], e_n[6];
  for (int k = 0; k < 9; ++k) F[k] = k % 4 == 0 ? 1 + H[k] : H[k];
  LaneBlock first;
  first.load(batch.state_n[0]->e.data(), batch.state_n[1]->e.data(), batch.state_n[2]->e.data(),
             batch.state_n[3]->e.data());
  for (int k = 0; k < 4; ++k) e_n[k] = first[k];
  for (int l = 0; l < num_lanes; ++l) {
    const MaterialState<3>& state = *batch.state_n[l];
    e_n[4][l] = state.e[4];
    e_n[5][l] = state.e[5];
    t.gap[l] = state.gap;
    t.plastic_strain[l] = state.plastic_strain;
  }
  t.J = 1 + determinant_minus_one<3>(H);
  Lanes G[9];
  invert_transposed<3>(F, t.J, G);
  for (int i = 0; i < 3; ++i) {
    for (int j = 0; j < 3; ++j) t.F_inverse[3 * i + j] = G[3 * j + i];
  }
  // See push_forward().
  for (int a = 0; a < 3; ++a) {
    Lanes Fe[3];
    for (int k = 0; k < 3; ++k) {
      Fe[k] = F[3 * a] * e_n[place[0][k]] + F[3 * a + 1] * e_n[place[1][k]] +
              F[3 * a + 2] * e_n[place[2][k]];
    }
    for (int b = a; b < 3; ++b) {
      const Lanes HH =
          H[3 * a] * H[3 * b] + H[3 * a + 1] * H[3 * b + 1] + H[3 * a + 2] * H[3 * b + 2];
      t.e[place[a][b]] = Fe[0] * F[3 * b] + Fe[1] * F[3 * b + 1] + Fe[2] * F[3 * b + 2] +
                         (H[3 * a + b] + H[3 * b + a] + HH);
    }
  }
  Lanes A[6];
  std::copy_n(t.e, 6, A);
  find_axes(A, t.n);
  t.v = {A[0], A[1], A[2]};
  order(t.v, t.n, 0, 1);
  order(t.v, t.n, 1, 2);
  order(t.v, t.n, 0, 1);
  return t;
}

void SpaceReturn::store(const Trial& t, const Returned& r, PointBatch<3>& batch) const {
  const BatchResults<3>& out = batch.out;
  Lanes tau[6], e[6], increment[6] = {};
  compose(r.tau, t.n, tau);
  for (int a = 0; a < 3; ++a) {
    for (int J = 0; J < 3; ++J) {  // P = tau F^-T
      batch.P[3 * a + J] = tau[place[a][0]] * t.F_inverse[3 * J] +
                           tau[place[a][1]] * t.F_inverse[3 * J + 1] +
                           tau[place[a][2]] * t.F_inverse[3 * J + 2];
    }
  }
  const double lambda = return_.law().lambda, mu = return_.law().mu;
  const Lanes volumetric = r.eps_e.sum();
  const Lanes energy = 0.5 * lambda * volumetric * volumetric + mu * r.eps_e.squares();
  const LaneMask changed = ~r.on[LaneReturn::elastic] | (t.gap != 0);
  std::copy_n(t.e, 6, e);
  Lanes gap{}, plastic{};
  if (any(changed)) {
    const PrincipalLanes strain = {strain_from_hencky(r.eps_e[0]), strain_from_hencky(r.eps_e[1]),
                                   strain_from_hencky(r.eps_e[2])};
    const Lanes third = t.gap / 3;
    PrincipalLanes not_elastic, kept = r.plastic;
    for (int s = 0; s < 3; ++s) not_elastic[s] = t.eps[s] - third - r.eps_e[s];
    Lanes returned[6];
    compose(strain, t.n, returned);
    compose(not_elastic, t.n, increment);
    for (int c = 0; c < 6; ++c) {
      e[c] = select(changed, returned[c], t.e[c]);
      increment[c] = select(changed, increment[c], Lanes{});
    }
    if (keeps_gap_) gap = select(r.on[LaneReturn::apex], kept.sum(), Lanes{});
    for (int s = 0; s < 3; ++s) kept[s] -= gap / 3;
    plastic = sqrt(kept.squares());
  }
  store_four(tau, out.tau);
  store_four(increment, out.plastic_increment);
  plastic += t.plastic_strain;
  const LaneBlock head{{e[0], e[1], e[2], e[3]}}, tail{{e[4], e[5], plastic, gap}};
  static_assert(sizeof(MaterialState<3>) == 8 * sizeof(double));
  head.store(out.state[0].e.data(), out.state[1].e.data(), out.state[2].e.data(),
             out.state[3].e.data());
  tail.store(out.state[0].e.data() + 4, out.state[1].e.data() + 4, out.state[2].e.data() + 4,
             out.state[3].e.data() + 4);
  store_lanes(t.J, out.J);
  store_lanes(energy, out.energy);
  for (int l = 0; l < num_lanes; ++l) out.region[l] = r.region(l);
}

// See spectral_tangent() of one point: with m_j = F^-1 n_j,
//
//     A_(aJ)(bL) = sum_i n_ia T_i(J)(bL) ,   T_i(J)(bL) = sum_j m_jJ R_ij(bL)
//     R_ii = sum_j (D_ij - tau_i delta_ij) n_j m_j ,   R_ij = G_ij b_j n_i m_j + mixed_ij n_j m_i
void SpaceReturn::store_tangent(const Trial& t, const Returned& r, PointBatch<3>& batch) const {
  Lanes D[3][3], m[3][3];  // m[j][J]
  for (int l = 0; l < num_lanes; ++l) {
    const double* moduli = moduli_[r.face(l)];
    for (int k = 0; k < 9; ++k) D[k / 3][k % 3][l] = moduli[k];
  }
  for (int i = 0; i < 3; ++i) D[i][i] -= r.tau[i];
  for (int j = 0; j < 3; ++j) {
    for (int J = 0; J < 3; ++J) {
      m[j][J] = t.F_inverse[3 * J] * t.n[0][j] + t.F_inverse[3 * J + 1] * t.n[1][j] +
                t.F_inverse[3 * J + 2] * t.n[2][j];
    }
  }
  Lanes R[3][3][9];
  for (int i = 0; i < 3; ++i) {
    Lanes weighted[3][3];  // D_ij m_j
    for (int j = 0; j < 3; ++j) {
      for (int L = 0; L < 3; ++L) weighted[j][L] = D[i][j] * m[j][L];
    }
    for (int bL = 0; bL < 9; ++bL) {
      const int b = bL / 3, L = bL % 3;
      R[i][i][bL] =
          t.n[b][0] * weighted[0][L] + t.n[b][1] * weighted[1][L] + t.n[b][2] * weighted[2][L];
    }
  }
  for (const auto& [i, j] : {std::pair{0, 1}, {0, 2}, {1, 2}}) {
    const Lanes G = shear_factor(t, r, i, j);
    const Lanes b_i = 1 + t.v[i], b_j = 1 + t.v[j];
    const Lanes mixed = 0.5 * (G * (b_i + b_j) - (r.tau[i] + r.tau[j]));
    for (int L = 0; L < 3; ++L) {
      const Lanes of_ij = G * b_j * m[j][L], of_ji = G * b_i * m[i][L];
      const Lanes mixed_i = mixed * m[i][L], mixed_j = mixed * m[j][L];
      for (int b = 0; b < 3; ++b) {
        R[i][j][3 * b + L] = t.n[b][i] * of_ij + t.n[b][j] * mixed_i;
        R[j][i][3 * b + L] = t.n[b][j] * of_ji + t.n[b][i] * mixed_j;
      }
    }
  }
  for (int J = 0; J < 3; ++J) {
    for (int bL = 0; bL < 9; ++bL) {
      Lanes T[3];
      for (int i = 0; i < 3; ++i) {
        T[i] = m[0][J] * R[i][0][bL] + m[1][J] * R[i][1][bL] + m[2][J] * R[i][2][bL];
      }
      for (int a = 0; a < 3; ++a) {
        batch.A[(3 * a + J) * 9 + bL] = t.n[a][0] * T[0] + t.n[a][1] * T[1] + t.n[a][2] * T[2];
      }
    }
  }
}

// (tau_i - tau_j) / (b_i - b_j), see make_plastic().
Lanes SpaceReturn::shear_factor(const Trial& t, const Returned& r, int i, int j) const {
  const double mu = return_.law().mu;
  const Lanes elastic_G = 2 * mu * hencky_slope(1 + t.v[i], 1 + t.v[j]);
  const Lanes change = r.plastic[i] - r.plastic[j];
  const Lanes G = elastic_G - select(change != 0, 2 * mu * change / (t.v[i] - t.v[j]), Lanes{});
  const LaneMask none{};
  const LaneMask equal = (i + j == 1 ? r.on[LaneReturn::edge_12] : none) |
                         (i + j == 3 ? r.on[LaneReturn::edge_23] : none);
  return select(equal, Lanes{}, select(r.on[LaneReturn::apex], apex_stiffness * elastic_G, G));
}

bool SpaceReturn::update(PointBatch<3>& batch, bool with_A) const {
  Trial trial = trial_of(batch);
  if (!trial.admissible()) return false;
  for (int s = 0; s < 3; ++s) trial.eps[s] = hencky_strain(trial.v[s]) + trial.gap / 3;
  const LaneReturn::State state = return_.apply(trial.eps);
  const Returned returned{state, return_.stress(state.eps_e)};
  store(trial, returned, batch);
  if (with_A) store_tangent(trial, returned, batch);
  return true;
}

LaneMask SpaceReturn::update_elastic(PointBatch<3>& batch, const LaneStrength& surface,
                                     bool with_A) const {
  Trial trial = trial_of(batch);
  if (!trial.admissible()) return LaneMask{};
  for (int s = 0; s < 3; ++s) trial.eps[s] = hencky_strain(trial.v[s]) + trial.gap / 3;
  const LaneMask elastic = ~return_.yields(trial.eps, surface);
  if (!any(elastic)) return LaneMask{};
  const LaneReturn::State state = LaneReturn::elastic_state(trial.eps);
  const Returned returned{state, return_.stress(state.eps_e)};
  store(trial, returned, batch);
  if (with_A) store_tangent(trial, returned, batch);
  return elastic;
}

}  // namespace gabion
