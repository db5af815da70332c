// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <algorithm>
#include <cmath>
#include <utility>

#include "common/mechanics/materials/spectral.hpp"
#include "common/mechanics/materials/stress_update.hpp"

namespace gabion {

/// Fraction of the elastic moduli in the tangent of the apex, whose exact value is zero: points
/// without stress must not leave the stiffness of a node singular. Only the tangent sees it.
inline constexpr double apex_stiffness = 1e-4;

using Permutation = std::array<int, 3>;  // position in descending order -> axis

inline Permutation descending(const std::array<double, 3>& value) {
  Permutation order = {0, 1, 2};
  if (value[order[0]] < value[order[1]]) std::swap(order[0], order[1]);
  if (value[order[1]] < value[order[2]]) std::swap(order[1], order[2]);
  if (value[order[0]] < value[order[1]]) std::swap(order[0], order[1]);
  return order;
}

/// Kirchhoff stress of Hencky strains.
inline Eigen::Vector3d hencky_stress(double lambda, double mu, const Eigen::Vector3d& eps) {
  return (lambda * eps.sum() + 2 * mu * eps.array()).matrix();
}

/// Turn elastic moduli on the axes of the trial state into those of the sorted return.
template <int dim, class Surface>
void make_plastic(const Surface& surface, const typename Surface::Return& returned,
                  const Permutation& order, const std::array<double, 3>& trial,
                  PrincipalModuli& moduli) {
  if (surface.region(returned) == YieldRegion::apex) {
    if constexpr (requires { surface.apex_moduli(returned); }) {
      const auto [sorted, share] = surface.apex_moduli(returned);
      moduli.D *= apex_stiffness;
      moduli.G *= apex_stiffness + share;
      for (int s = 0; s < 3; ++s)
        for (int t = 0; t < 3; ++t) moduli.D(order[s], order[t]) += sorted(s, t);
    } else {
      moduli.D *= apex_stiffness;
      moduli.G *= apex_stiffness;
    }
    return;
  }
  const Eigen::Matrix3d sorted = surface.moduli(returned);
  for (int s = 0; s < 3; ++s)
    for (int t = 0; t < 3; ++t) moduli.D(order[s], order[t]) = sorted(s, t);
  for (int s = 0; s < 3; ++s) {
    for (int t = s + 1; t < 3; ++t) {
      const int i = std::min(order[s], order[t]), j = std::max(order[s], order[t]);
      if (j >= dim) continue;
      double& G = moduli.G[pair_index(i, j)];
      G = surface.shear_factor(returned, s, t, G, trial[order[s]] - trial[order[t]]);
    }
  }
}

/// Stress update of Hencky elasticity with plasticity on an isotropic surface, which a `Surface`
/// describes in principal values, sorted in descending order:
///
///   struct Return;                       // at least eps_e and plastic, elastic and plastic strain
///   double lambda() const, mu() const;   // [Pa]
///   bool keeps_gap() const;              // see MaterialState::gap
///   bool yields(eps, tau_trial) const;
///   Return return_to_surface(eps, tau_trial) const;                // if it yields
///   YieldRegion region(returned) const;
///   Eigen::Matrix3d moduli(returned) const;                        // d tau / d eps, off the apex
///   double shear_factor(returned, s, t, G, difference) const;      // (tau_s - tau_t) / difference
///   std::pair<Eigen::Matrix3d, double> apex_moduli(returned) const;  // optional: d tau / d eps at
///                                          // the apex, and what is left there of the factors G
///
/// with G the elastic shear factor and difference = b_s - b_t, both of the trial state.
///
/// A gap g is part of the trial strain, eps + g/3: a state that returns to the apex keeps all
/// volume beyond it as the new gap; any other state has closed it. Within one step this is the
/// backward Euler return like any other, so that the moduli need no case of their own: g is a
/// constant of the step, and equal shifts of all strains leave the shear factors.
///
/// @see de Souza Neto, Peric and Owen (2008), chapters 8 and 14; for the gap, the volume correction
///      of Tampubolon et al. (2017), here undone exactly as it was opened
template <int dim, class Surface>
bool principal_update(const Surface& surface, const Matrix<dim>& H,
                      const MaterialState<dim>& state_n, StressUpdate<dim>& out, Tangent<dim>* A) {
  out.J = 1 + determinant_minus_one<dim>(H);
  if (!(out.J > 0)) return false;
  const Symmetric<dim> e = push_forward<dim>(H, state_n.e);
  const Eigenpairs<dim> trial = eigenpairs<dim>(e);
  const Permutation order = descending(trial.value);
  if (!(trial.value[order[2]] > -1)) return false;
  Eigen::Vector3d eps;
  for (int s = 0; s < 3; ++s) eps[s] = hencky_strain(trial.value[order[s]]);
  const bool gap_was_open = state_n.gap != 0;
  if (gap_was_open) eps.array() += state_n.gap / 3;

  const double lambda = surface.lambda(), mu = surface.mu();
  const Eigen::Vector3d tau_trial = hencky_stress(lambda, mu, eps);
  const bool plastic = surface.yields(eps, tau_trial);
  typename Surface::Return returned;
  Eigen::Vector3d eps_e = eps;
  out.region = YieldRegion::elastic;
  out.state = {.e = e, .plastic_strain = state_n.plastic_strain};
  if (plastic) {
    returned = surface.return_to_surface(eps, tau_trial);
    eps_e = returned.eps_e;
    out.region = surface.region(returned);
    Eigen::Vector3d increment = returned.plastic;
    if (surface.keeps_gap() && out.region == YieldRegion::apex) {
      out.state.gap = increment.sum();
      increment.array() -= out.state.gap / 3;
    }
    out.state.plastic_strain += increment.norm();
  }
  if (plastic || gap_was_open) {
    std::array<double, 3> e_principal;
    std::array<double, 3> not_elastic;
    for (int s = 0; s < 3; ++s) {
      e_principal[order[s]] = strain_from_hencky(eps_e[s]);
      not_elastic[order[s]] = eps[s] - state_n.gap / 3 - eps_e[s];
    }
    out.state.e = compose<dim>(e_principal, trial.n);
    out.plastic_increment = compose<dim>(not_elastic, trial.n);
  } else {
    out.plastic_increment.setZero();
  }
  const double volumetric = eps_e.sum();
  std::array<double, 3> tau;
  for (int s = 0; s < 3; ++s) tau[order[s]] = lambda * volumetric + 2 * mu * eps_e[s];
  const Matrix<dim> F = Matrix<dim>::Identity() + H;
  const Matrix<dim> F_inverse = F.inverse();
  out.tau = compose<dim>(tau, trial.n);
  out.P = first_piola<dim>(out.tau, F_inverse);
  out.energy = 0.5 * lambda * volumetric * volumetric + mu * eps_e.squaredNorm();
  if (!A) return true;

  PrincipalModuli moduli = hencky_moduli<dim>(lambda, mu, trial.value);
  if (plastic) make_plastic<dim>(surface, returned, order, trial.value, moduli);
  spectral_tangent<dim>(moduli, tau, trial, F_inverse, *A);
  return true;
}

}  // namespace gabion
