// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "common/mechanics/simd/lane_tensors.hpp"
#include "common/mechanics/materials/point_batch.hpp"
#include "mpm_solver/points/pore_water.hpp"

namespace gabion::mpm {

/// Stress of the pore water of four points, added to that of their law, in each lane. With the
/// water pressure p and its stiffness K_w / n at the volume ratio J since the stress-free state,
/// tau = tau' - J p 1:
///
///     P = P' - J p G ,  A = A' + J (K_w / n - p) G (x) G + J p G_aL G_bJ ,  G = (1 + H)^-T
struct PoreStress {
  Lanes Jp{};  ///< J p [Pa]
  Lanes Jq{};  ///< J K_w / n [Pa]
};

/// Add it to P and, if `with_A`, to A of a batch, as docs/theory/water.md, (W4) has it.
/// @pre the batch has H, P and A of its law
template <int dim>
inline void add_pore_stress(const PoreStress& water, bool with_A, PointBatch<dim>& batch) {
  constexpr int n = dim * dim;
  Lanes F[n], G[n];
  for (int k = 0; k < n; ++k) F[k] = k % (dim + 1) == 0 ? 1 + batch.H[k] : batch.H[k];
  invert_transposed<dim>(F, 1 + determinant_minus_one<dim>(batch.H), G);
  for (int k = 0; k < n; ++k) batch.P[k] -= water.Jp * G[k];
  if (!with_A) return;
  const Lanes volumetric = water.Jq - water.Jp;
  for (int a = 0; a < dim; ++a) {
    for (int J = 0; J < dim; ++J) {
      for (int b = 0; b < dim; ++b) {
        for (int L = 0; L < dim; ++L) {
          const int aJ = a * dim + J, bL = b * dim + L;
          batch.A[aJ * n + bL] +=
              volumetric * G[aJ] * G[bL] + water.Jp * G[a * dim + L] * G[b * dim + J];
        }
      }
    }
  }
}

}  // namespace gabion::mpm
