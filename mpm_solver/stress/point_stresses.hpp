// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <algorithm>
#include <span>
#include <vector>

#include "mpm_solver/stress/stress_parts.hpp"

namespace gabion::mpm {

/// Groups whose points are evaluated in one go: enough to fill batches, few enough for the cache.
inline constexpr std::int32_t groups_at_once = 16;

/// Stresses of the points of consecutive entries of PointWeights, several at once where their law
/// can do that (PlaneReturn).
template <int dim>
class PointStresses {
 public:
  void start(std::int32_t first, std::int32_t last) {
    first_ = first;
    H_.resize(last - first);
    P_.resize(last - first);
    A_.resize(last - first);
  }

  /// Gradient of an entry, to be set before `evaluate`.
  Matrix<dim>& H(std::int32_t entry) { return H_[entry - first_]; }
  const Matrix<dim>& P(std::int32_t entry) const { return P_[entry - first_]; }
  const Tangent<dim>& A(std::int32_t entry) const { return A_[entry - first_]; }

  /// Set P, A if wanted, and the trial state.
  /// @param worst  set to the point that makes the state inadmissible
  /// @returns false when a point would be squeezed below min_J_ratio of its volume
  template <class Law>
  bool evaluate(const StressParts<dim>& parts, const Law& law, bool with_A, std::int32_t& worst) {
    if constexpr (dim == 2 && requires { law.plane_return(); }) {
      if (law.plane_return()) return in_batches(parts, law, with_A, worst);
    }
    for (std::size_t k = 0; k < H_.size(); ++k) {
      if (!one_by_one(parts, law, k, with_A, worst)) return false;
    }
    return true;
  }

 private:
  template <class Law>
  bool one_by_one(const StressParts<dim>& parts, const Law& law, std::size_t k, bool with_A,
                  std::int32_t& worst) {
    StressUpdate<dim> stress;
    const std::int32_t p = point(parts, k);
    if (!law.update(H_[k], parts.points.history[p], stress, with_A ? &A_[k] : nullptr)) {
      worst = p;
      return false;
    }
    return keep(parts, k, stress, worst);
  }

  template <class Law>
  bool in_batches(const StressParts<dim>& parts, const Law& law, bool with_A, std::int32_t& worst) {
    PlaneBatch batch;
    Tangent<dim> unused;
    for (std::size_t k = 0; k < H_.size(); k += PlaneBatch::size) {
      const std::size_t n = std::min<std::size_t>(PlaneBatch::size, H_.size() - k);
      for (std::size_t l = 0; l < PlaneBatch::size; ++l) {
        const std::size_t at = k + std::min(l, n - 1);  // the last one fills up
        batch.H[l] = H_[at];
        batch.state_n[l] = &parts.points.history[point(parts, at)];
        batch.A[l] = l < n ? &A_[at] : &unused;
      }
      const bool admissible = law.plane_return()->update(batch, with_A);
      for (std::size_t l = 0; l < n; ++l) {
        if (!(admissible ? keep(parts, k + l, batch.out[l], worst)
                         : one_by_one(parts, law, k + l, with_A, worst))) {
          return false;
        }
      }
    }
    return true;
  }

  std::int32_t point(const StressParts<dim>& parts, std::size_t k) const {
    return parts.weights.point[first_ + k];
  }

  bool keep(const StressParts<dim>& parts, std::size_t k, const StressUpdate<dim>& stress,
            std::int32_t& worst) {
    if (stress.J < min_J_ratio) {
      worst = point(parts, k);
      return false;
    }
    P_[k] = stress.P;
    const std::size_t entry = first_ + k;
    parts.trial.history[entry] = stress.state;
    parts.trial.tau[entry] = stress.tau;
    parts.trial.J_ratio[entry] = stress.J;
    parts.trial.energy[entry] = stress.energy;
    parts.trial.plastic_increment[entry] = stress.plastic_increment;
    parts.trial.region[entry] = stress.region;
    return true;
  }

  std::int32_t first_ = 0;
  std::vector<Matrix<dim>> H_, P_;
  std::vector<Tangent<dim>> A_;
};

}  // namespace gabion::mpm
