// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>
#include <cmath>
#include <utility>

#include "common/mechanics/materials/material.hpp"
#include "common/mechanics/materials/mohr_coulomb_return.hpp"
#include "common/mechanics/materials/spectral.hpp"

namespace gabion {
namespace {

/// A state counts as elastic up to f = yield_tolerance (k + 1) M max|eps|: some hundred roundings,
/// so that a returned state which is not strained again stays as it is.
constexpr double yield_tolerance = 1e-13;

/// Fraction of the elastic moduli in the tangent of the apex, whose exact value is zero: points
/// without stress must not leave the stiffness of a node singular. Only the tangent sees it.
constexpr double apex_stiffness = 1e-4;

using Permutation = std::array<int, 3>;  // position in descending order -> axis

Permutation descending(const std::array<double, 3>& value) {
  Permutation order = {0, 1, 2};
  if (value[order[0]] < value[order[1]]) std::swap(order[0], order[1]);
  if (value[order[1]] < value[order[2]]) std::swap(order[1], order[2]);
  if (value[order[0]] < value[order[1]]) std::swap(order[0], order[1]);
  return order;
}

double flow_ratio(double angle) {
  const double sine = std::sin(angle);
  return (1 + sine) / (1 - sine);
}

/// Turn elastic moduli on the axes of the trial state into those of the sorted return.
template <int dim>
void make_plastic(const PrincipalMohrCoulomb& law, const PrincipalReturn& returned,
                  const Permutation& order, const std::array<double, 3>& trial,
                  PrincipalModuli& moduli) {
  if (returned.region == YieldRegion::apex) {
    moduli.D *= apex_stiffness;
    moduli.G *= apex_stiffness;
    return;
  }
  const Eigen::Matrix3d sorted = return_moduli(law, returned.region);
  for (int s = 0; s < 3; ++s)
    for (int t = 0; t < 3; ++t) moduli.D(order[s], order[t]) = sorted(s, t);
  for (int s = 0; s < 3; ++s) {
    for (int t = s + 1; t < 3; ++t) {
      const int i = std::min(order[s], order[t]), j = std::max(order[s], order[t]);
      if (j >= dim) continue;
      double& G = moduli.G[pair_index(i, j)];
      if (made_equal(returned.region, s, t)) {
        G = 0;
      } else {
        G -= 2 * law.mu * (returned.plastic[s] - returned.plastic[t]) /
             (trial[order[s]] - trial[order[t]]);
      }
    }
  }
}

}  // namespace

template <int dim>
MohrCoulomb<dim>::MohrCoulomb(double lambda, double mu, double friction_angle,
                              double dilation_angle, double cohesion)
    : lambda_(lambda),
      mu_(mu),
      friction_angle_(friction_angle),
      dilation_angle_(dilation_angle),
      cohesion_(cohesion),
      k_(flow_ratio(friction_angle)),
      m_(flow_ratio(dilation_angle)),
      strength_(2 * cohesion * std::sqrt(k_)) {}

template <int dim>
bool MohrCoulomb<dim>::update(const Matrix<dim>& H, const MaterialState<dim>& state_n,
                              StressUpdate<dim>& out, Tangent<dim>* A) const {
  out.J = 1 + determinant_minus_one<dim>(H);
  if (!(out.J > 0)) return false;
  const Symmetric<dim> e = push_forward<dim>(H, state_n.e);
  const Eigenpairs<dim> trial = eigenpairs<dim>(e);
  const Permutation order = descending(trial.value);
  if (!(trial.value[order[2]] > -1)) return false;
  Eigen::Vector3d eps;
  for (int s = 0; s < 3; ++s) eps[s] = hencky_strain(trial.value[order[s]]);

  const PrincipalMohrCoulomb law = {lambda_, mu_, k_, m_, strength_};
  const Eigen::Vector3d tau_trial = (lambda_ * eps.sum() + 2 * mu_ * eps.array()).matrix();
  const double tolerance =
      yield_tolerance * (k_ + 1) * p_wave_modulus() * std::max(std::abs(eps[0]), std::abs(eps[2]));
  out.plastic = k_ * tau_trial[0] - tau_trial[2] - strength_ > tolerance;

  PrincipalReturn returned;
  std::array<double, 3> tau;
  Eigen::Vector3d eps_e = eps;
  if (out.plastic) {
    returned = return_to_surface(law, eps, tau_trial);
    eps_e = returned.eps_e;
    std::array<double, 3> e_principal;
    for (int s = 0; s < 3; ++s) e_principal[order[s]] = strain_from_hencky(eps_e[s]);
    out.state = {.e = compose<dim>(e_principal, trial.n),
                 .plastic_strain = state_n.plastic_strain + returned.plastic.norm()};
  } else {
    out.state = {.e = e, .plastic_strain = state_n.plastic_strain};
  }
  const double volumetric = eps_e.sum();
  for (int s = 0; s < 3; ++s) tau[order[s]] = lambda_ * volumetric + 2 * mu_ * eps_e[s];
  out.dissipation = 0;
  for (int s = 0; out.plastic && s < 3; ++s) out.dissipation += tau[order[s]] * returned.plastic[s];
  const Matrix<dim> F = Matrix<dim>::Identity() + H;
  const Matrix<dim> F_inverse = F.inverse();
  out.tau = compose<dim>(tau, trial.n);
  out.P = first_piola<dim>(out.tau, F_inverse);
  out.energy = 0.5 * lambda_ * volumetric * volumetric + mu_ * eps_e.squaredNorm();
  if (!A) return true;

  PrincipalModuli moduli = hencky_moduli<dim>(lambda_, mu_, trial.value);
  if (out.plastic) make_plastic<dim>(law, returned, order, trial.value, moduli);
  spectral_tangent<dim>(moduli, tau, trial, F_inverse, *A);
  return true;
}

template struct MohrCoulomb<2>;
template struct MohrCoulomb<3>;

}  // namespace gabion
