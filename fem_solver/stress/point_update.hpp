// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "fem_solver/materials/cell_material.hpp"
#include "fem_solver/stress/stress_integral.hpp"

namespace gabion::fem {

/// Stress update of a point, whichever kind of history the law has.
template <int dim, class Law>
bool update_point(const Law& law, const Matrix<dim>& H, HistoryStep history, StressUpdate<dim>& out,
                  Tangent<dim>* A) {
  if constexpr (LawWithHistory<Law>) {
    return law.update(H, history.accepted, history.trial, out, A);
  } else {
    const MaterialState<dim> virgin;  // here, for the compiler to see that it is zero
    return law.update(H, virgin, out, A);
  }
}

}  // namespace gabion::fem
