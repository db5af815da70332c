// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "common/mechanics/materials/stress_update.hpp"
#include "common/mechanics/simd/lanes.hpp"

namespace gabion {

/// Destinations of the results of four points in a step: each member names the first of four in a
/// row.
template <int dim>
struct BatchResults {
  MaterialState<dim>* state;
  Symmetric<dim>* tau;
  double* J;
  double* energy;
  Symmetric<dim>* plastic_increment;
  YieldRegion* region;
};

/// Four points whose stresses are found side by side, a point in each lane. Tensors stand row by
/// row; A is the tangent dP/dH in the order of Tangent. See StressUpdate for what they mean.
template <int dim>
struct PointBatch {
  static constexpr int size = num_lanes;
  static constexpr int num_entries = dim * dim;
  Lanes H[num_entries];
  Lanes P[num_entries];
  Lanes A[num_entries * num_entries];
  const MaterialState<dim>* state_n[size];
  BatchResults<dim> out;

  Matrix<dim> gradient(int lane) const { return tensor(H, lane); }
  Matrix<dim> stress(int lane) const { return tensor(P, lane); }
  Tangent<dim> tangent(int lane) const {
    Tangent<dim> result;
    for (int k = 0; k < num_entries * num_entries; ++k) result.data()[k] = A[k][lane];
    return result;
  }
  void set_gradient(int lane, const Matrix<dim>& value) {
    for (int k = 0; k < num_entries; ++k) H[k][lane] = value(k / dim, k % dim);
  }
  void set_stress(int lane, const Matrix<dim>& value) {
    for (int k = 0; k < num_entries; ++k) P[k][lane] = value(k / dim, k % dim);
  }
  /// Result of a law for one point. @param with_A  A is set too
  void set(int lane, const StressUpdate<dim>& found, const Tangent<dim>* with_A) {
    set_stress(lane, found.P);
    for (int k = 0; with_A && k < num_entries * num_entries; ++k) A[k][lane] = with_A->data()[k];
    out.state[lane] = found.state;
    out.tau[lane] = found.tau;
    out.J[lane] = found.J;
    out.energy[lane] = found.energy;
    out.plastic_increment[lane] = found.plastic_increment;
    out.region[lane] = found.region;
  }

 private:
  static Matrix<dim> tensor(const Lanes* x, int lane) {
    Matrix<dim> m;
    for (int k = 0; k < num_entries; ++k) m(k / dim, k % dim) = x[k][lane];
    return m;
  }
};

}  // namespace gabion
