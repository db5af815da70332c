// SPDX-License-Identifier: BSD-3-Clause
#include "common/mechanics/materials/newtonian.hpp"

#include <algorithm>
#include <cmath>

#include "common/mechanics/materials/principal_update.hpp"
#include "common/mechanics/materials/spectral.hpp"
#include "common/mechanics/materials/yield_tolerance.hpp"

namespace gabion {

template <int dim>
bool Newtonian<dim>::update(const PointContext& context, const Matrix<dim>& H,
                            const MaterialState<dim>& state_n, StressUpdate<dim>& out,
                            Tangent<dim>* A) const {
  out.J = 1 + determinant_minus_one<dim>(H);
  if (!(out.J > 0)) return false;
  const Eigenpairs<dim> trial = eigenpairs<dim>(push_forward<dim>(H, state_n.e));
  std::array<double, 3> eps;
  for (int i = 0; i < 3; ++i) {
    if (!(trial.value[i] > -1)) return false;
    eps[i] = hencky_strain(trial.value[i]);
  }
  const double volumetric = eps[0] + eps[1] + eps[2], K = parameters_.bulk_modulus;
  const double limit = parameters_.cavitation_pressure / K;
  const bool tears = volumetric + state_n.gap > limit;
  const double theta = tears ? limit : volumetric + state_n.gap;
  const double J_n = std::exp(volumetric) / out.J;
  const double eta = context.dt > 0 ? parameters_.viscosity / context.dt * J_n : 0;

  std::array<double, 3> tau, flow, not_elastic;
  double squared = 0;
  for (int i = 0; i < 3; ++i) {
    flow[i] = eps[i] - volumetric / 3;
    squared += flow[i] * flow[i];
    tau[i] = K * theta + 2 * eta * flow[i];
    not_elastic[i] = eps[i] - theta / 3;
  }
  const Matrix<dim> F_inverse = (Matrix<dim>::Identity() + H).inverse();
  out.tau = compose<dim>(tau, trial.n);
  out.P = first_piola<dim>(out.tau, F_inverse);
  out.state.e.setZero();
  out.state.e.template head<3>().setConstant(strain_from_hencky(theta / 3));
  out.state.gap = tears ? volumetric + state_n.gap - limit : 0;
  out.state.plastic_strain = state_n.plastic_strain + std::sqrt(squared);
  out.plastic_increment = compose<dim>(not_elastic, trial.n);
  out.energy = 0.5 * K * theta * theta;
  const double size = K * std::max({std::abs(eps[0]), std::abs(eps[1]), std::abs(eps[2])});
  const bool flows = 2 * eta * std::sqrt(squared) > yield_tolerance * size;
  out.region = tears ? YieldRegion::apex : flows ? YieldRegion::shear : YieldRegion::elastic;
  if (!A) return true;

  const double bulk = tears ? apex_stiffness * K : K;
  spectral_tangent<dim>(hencky_moduli<dim>(bulk - 2 * eta / 3, eta, trial.value), tau, trial,
                        F_inverse, *A);
  return true;
}

template class Newtonian<2>;
template class Newtonian<3>;

}  // namespace gabion
