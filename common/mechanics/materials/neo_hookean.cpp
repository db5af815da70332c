// SPDX-License-Identifier: BSD-3-Clause
#include <cmath>

#include "common/mechanics/materials/elastic.hpp"
#include "common/mechanics/tensor_functions.hpp"

namespace gabion {
namespace {

/// det b - 1 from e = b - 1.
template <int dim>
double determinant_minus_one_of(const Symmetric<dim>& e) {
  const double d = determinant_minus_one<dim>(in_plane<dim>(e));
  if constexpr (dim == 2) return d + e[2] + d * e[2];
  return d;
}

}  // namespace

// With l = dF F^-1 the derivative d tau - tau l^T is
// lambda tr(l) 1 + mu l b + (mu - lambda ln J) l^T; pulled back, F^-1 b F^-T is b_n.
template <int dim>
bool NeoHookean<dim>::update(const Matrix<dim>& H, const MaterialState<dim>& state_n,
                             StressUpdate<dim>& out, Tangent<dim>* A) const {
  out.J = 1 + determinant_minus_one<dim>(H);
  if (!(out.J > 0)) return false;
  const Symmetric<dim> e = push_forward<dim>(H, state_n.e);
  const double det_b_minus_one = determinant_minus_one_of<dim>(e);
  if (!(det_b_minus_one > -1)) return false;
  const double log_J = 0.5 * std::log1p(det_b_minus_one);
  out.tau = mu * e;
  out.tau.template head<3>().array() += lambda * log_J;
  const Matrix<dim> F = Matrix<dim>::Identity() + H;
  const Matrix<dim> F_inverse = F.inverse();
  out.P = first_piola<dim>(out.tau, F_inverse);
  out.state = {.e = e, .plastic_strain = state_n.plastic_strain};
  out.energy = 0.5 * lambda * log_J * log_J + mu * (0.5 * trace<dim>(e) - log_J);
  out.region = YieldRegion::elastic;
  if (!A) return true;

  const Matrix<dim> b_n = Matrix<dim>::Identity() + in_plane<dim>(state_n.e);
  const double swap = mu - lambda * log_J;
  for (int i = 0; i < dim; ++i)
    for (int J = 0; J < dim; ++J)
      for (int k = 0; k < dim; ++k)
        for (int L = 0; L < dim; ++L)
          (*A)(i * dim + J, k * dim + L) = lambda * F_inverse(J, i) * F_inverse(L, k) +
                                           swap * F_inverse(J, k) * F_inverse(L, i) +
                                           (i == k ? mu * b_n(J, L) : 0.0);
  return true;
}

template struct NeoHookean<2>;
template struct NeoHookean<3>;

}  // namespace gabion
