// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstring>

#include "common/mechanics/materials/point_batch.hpp"
#include "mpm_solver/stress/stress_parts.hpp"

namespace gabion::mpm {

/// H of one entry of a group, sum_i du_i (x) grad N_ip, set in a lane of its batch.
/// @tparam num_nodes  see EntryValues
/// @param du          of the group's nodes [m], dim each
template <int num_nodes>
inline void set_gradient(const PointWeights<2>& weights, std::int32_t entry, const double* du,
                         PointBatch<2>& batch, int lane) {
  const EntryValues<2, num_nodes> values(weights, entry);
  const int n = num_nodes > 0 ? num_nodes : values.n;
  const Vector<2>* grad = values.grad;
  Lanes H{};  // 00, 10, 01, 11
  for (int i = 0; i < n; ++i) {
    const double* du_i = du + values.number(i) * 2;
#ifdef __AVX2__
    const Lanes rows = _mm256_broadcast_pd(reinterpret_cast<const __m128d*>(du_i));
    const __m128d g = _mm_loadu_pd(grad[i].data());
    H += rows * Lanes(_mm256_permute4x64_pd(_mm256_castpd128_pd256(g), 0x50));
#else
    H += Lanes{du_i[0], du_i[1], du_i[0], du_i[1]} *
         Lanes{grad[i][0], grad[i][0], grad[i][1], grad[i][1]};
#endif
  }
  batch.H[0][lane] = H[0];
  batch.H[1][lane] = H[2];
  batch.H[2][lane] = H[1];
  batch.H[3][lane] = H[3];
}

/// H of one entry in space, see above. @param du  with one number more than those of the nodes
template <int num_nodes>
inline void set_gradient(const PointWeights<3>& weights, std::int32_t entry, const double* du,
                         PointBatch<3>& batch, int lane) {
  const EntryValues<3, num_nodes> values(weights, entry);
  const int n = num_nodes > 0 ? num_nodes : values.n;
  const Vector<3>* grad = values.grad;
  Lanes columns[3] = {};  // and a lane that nobody reads
  for (int i = 0; i < n; ++i) {
    const Lanes rows = load_lanes(du + values.number(i) * 3);
    for (int J = 0; J < 3; ++J) columns[J] += rows * grad[i][J];
  }
  for (int a = 0; a < 3; ++a) {
    for (int J = 0; J < 3; ++J) batch.H[a * 3 + J][lane] = columns[J][a];
  }
}

/// Displacements of a group's nodes for set_gradient.
template <int dim>
struct NodeMotion {
  double du[max_group_nodes<dim> * dim + 1] = {};
};

}  // namespace gabion::mpm
