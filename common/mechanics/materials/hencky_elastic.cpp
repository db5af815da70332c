// SPDX-License-Identifier: BSD-3-Clause
#include "common/mechanics/materials/elastic.hpp"
#include "common/mechanics/materials/spectral.hpp"

namespace gabion {

template <int dim>
bool HenckyElastic<dim>::update(const Matrix<dim>& H, const MaterialState<dim>& state_n,
                                StressUpdate<dim>& out, Tangent<dim>* A) const {
  out.J = 1 + determinant_minus_one<dim>(H);
  if (!(out.J > 0)) return false;
  const Symmetric<dim> e = push_forward<dim>(H, state_n.e);
  const Eigenpairs<dim> trial = eigenpairs<dim>(e);
  std::array<double, 3> eps, tau;
  for (int i = 0; i < 3; ++i) {
    if (!(trial.value[i] > -1)) return false;
    eps[i] = hencky_strain(trial.value[i]);
  }
  const double volumetric = eps[0] + eps[1] + eps[2];
  for (int i = 0; i < 3; ++i) tau[i] = lambda * volumetric + 2 * mu * eps[i];

  const Matrix<dim> F = Matrix<dim>::Identity() + H;
  const Matrix<dim> F_inverse = F.inverse();
  out.tau = compose<dim>(tau, trial.n);
  out.P = first_piola<dim>(out.tau, F_inverse);
  out.state = {.e = e, .plastic_strain = state_n.plastic_strain};
  out.energy = 0.5 * lambda * volumetric * volumetric +
               mu * (eps[0] * eps[0] + eps[1] * eps[1] + eps[2] * eps[2]);
  out.region = YieldRegion::elastic;
  if (A) {
    spectral_tangent<dim>(hencky_moduli<dim>(lambda, mu, trial.value), tau, trial, F_inverse, *A);
  }
  return true;
}

template struct HenckyElastic<2>;
template struct HenckyElastic<3>;

}  // namespace gabion
