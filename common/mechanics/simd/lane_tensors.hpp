// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "common/mechanics/simd/lanes.hpp"

// Tensors of four points, row by row: dim x dim.
namespace gabion {

/// det(1 + H) - 1 without the cancellation of the 1.
template <int dim>
inline Lanes determinant_minus_one(const Lanes* H) {
  if constexpr (dim == 2) {
    return H[0] + H[3] + (H[0] * H[3] - H[1] * H[2]);
  } else {
    const Lanes minor_0 = H[4] * H[8] - H[5] * H[7];
    const Lanes minor_1 = H[3] * H[8] - H[5] * H[6];
    const Lanes minor_2 = H[3] * H[7] - H[4] * H[6];
    const Lanes second = minor_0 + (H[0] * H[4] - H[1] * H[3]) + (H[0] * H[8] - H[2] * H[6]);
    return H[0] + H[4] + H[8] + second + (H[0] * minor_0 - H[1] * minor_1 + H[2] * minor_2);
  }
}

/// G = F^-T. @param J  det F
template <int dim>
inline void invert_transposed(const Lanes* F, const Lanes& J, Lanes* G) {
  const Lanes over_J = 1 / J;
  if constexpr (dim == 2) {
    G[0] = over_J * F[3];
    G[1] = -over_J * F[2];
    G[2] = -over_J * F[1];
    G[3] = over_J * F[0];
  } else {
    for (int i = 0; i < 3; ++i) {
      const int i1 = (i + 1) % 3, i2 = (i + 2) % 3;
      for (int j = 0; j < 3; ++j) {
        const int j1 = (j + 1) % 3, j2 = (j + 2) % 3;
        G[3 * i + j] = over_J * (F[3 * i1 + j1] * F[3 * i2 + j2] - F[3 * i1 + j2] * F[3 * i2 + j1]);
      }
    }
  }
}

}  // namespace gabion
