// SPDX-License-Identifier: BSD-3-Clause
#include "common/mechanics/materials/cam_clay.hpp"

#include <cmath>

#include "common/mechanics/materials/spectral.hpp"

namespace gabion {
namespace {

/// Trial state in principal values, in the order of the eigenpairs.
struct PrincipalTrial {
  Eigen::Vector3d eps;  // the open gap included
  Eigen::Vector3d deviator;
  Eigen::Vector3d direction;  // of the deviator, of length 1 or 0
  StrainInvariants invariants;
};

PrincipalTrial principal_trial(const std::array<double, 3>& value, double gap) {
  PrincipalTrial trial;
  for (int i = 0; i < 3; ++i) trial.eps[i] = hencky_strain(value[i]) + gap / 3;
  trial.invariants.volumetric = trial.eps.sum();
  trial.deviator = (trial.eps.array() - trial.eps.sum() / 3).matrix();
  const double size = trial.deviator.norm();
  trial.direction = size > 0 ? Eigen::Vector3d(trial.deviator / size) : Eigen::Vector3d::Zero();
  trial.invariants.distortion = std::sqrt(2.0 / 3) * size;
  return trial;
}

/// d tau / d eps of the trial state. @param mu  shear stress by the trial strain [Pa]
Eigen::Matrix3d principal_moduli(const Eigen::Matrix2d& of_invariants, const Eigen::Vector3d& n,
                                 double mu) {
  const Eigen::Vector3d one = Eigen::Vector3d::Ones();
  const double cross = std::sqrt(2.0 / 3);
  Eigen::Matrix3d D = 2 * mu * (Eigen::Matrix3d::Identity() - n * n.transpose());
  D.array() += of_invariants(0, 0) - 2 * mu / 3;
  D += cross *
       (of_invariants(0, 1) * one * n.transpose() + of_invariants(1, 0) * n * one.transpose());
  D += 2.0 / 3 * of_invariants(1, 1) * n * n.transpose();
  return D;
}

/// State and plastic strain at the end of the step; eps_e is the elastic strain.
template <int dim>
void set_state(const PrincipalTrial& trial, const CamClayState& end, const Eigenpairs<dim>& axes,
               const MaterialState<dim>& state_n, StressUpdate<dim>& out) {
  Eigen::Vector3d eps_e = end.share * trial.deviator;
  eps_e.array() += end.volumetric / 3;
  Eigen::Vector3d plastic = trial.eps - eps_e;
  std::array<double, 3> e, not_elastic;
  for (int i = 0; i < 3; ++i) {
    e[i] = strain_from_hencky(eps_e[i]);
    not_elastic[i] = plastic[i] - state_n.gap / 3;
  }
  out.state.e = compose<dim>(e, axes.n);
  out.plastic_increment = compose<dim>(not_elastic, axes.n);
  if (end.region == YieldRegion::apex) {
    out.state.gap = plastic.sum();
    plastic.array() -= out.state.gap / 3;
  }
  if (end.region != YieldRegion::elastic) out.state.plastic_strain += plastic.norm();
}

}  // namespace

template <int dim>
bool CamClay<dim>::update(const PointContext& context, const Matrix<dim>& H,
                          const MaterialState<dim>& state_n, StressUpdate<dim>& out,
                          Tangent<dim>* A) const {
  out.J = 1 + determinant_minus_one<dim>(H);
  if (!(out.J > 0)) return false;
  const Symmetric<dim> e = push_forward<dim>(H, state_n.e);
  const Eigenpairs<dim> axes = eigenpairs<dim>(e);
  for (const double value : axes.value)
    if (!(value > -1)) return false;
  const PrincipalTrial trial = principal_trial(axes.value, state_n.gap);
  const double mu = context.internal[1];
  CamClayState end;
  if (!cam_clay_step(parameters_, {context.internal[0], mu}, trial.invariants, end)) {
    out.refusal = Refusal::unsolved;
    return false;
  }
  out.region = end.region;
  out.internal = {end.preconsolidation, mu};
  out.state = {.e = e, .plastic_strain = state_n.plastic_strain};
  if (end.region != YieldRegion::elastic || state_n.gap != 0) {
    set_state<dim>(trial, end, axes, state_n, out);
  } else {
    out.plastic_increment.setZero();
  }
  const double a = parameters_.attraction, kappa = parameters_.swelling;
  const double distortion = end.share * trial.invariants.distortion;
  std::array<double, 3> tau;
  for (int i = 0; i < 3; ++i) tau[i] = a - end.P + 2 * mu * end.share * trial.deviator[i];
  out.energy = kappa * (end.P - a) + a * (end.volumetric - parameters_.strain_at(a)) +
               1.5 * mu * distortion * distortion;
  const Matrix<dim> F_inverse = (Matrix<dim>::Identity() + H).inverse();
  out.tau = compose<dim>(tau, axes.n);
  out.P = first_piola<dim>(out.tau, F_inverse);
  if (!A) return true;
  PrincipalModuli moduli = hencky_moduli<dim>(0, end.share * mu, axes.value);
  moduli.D = principal_moduli(end.moduli, trial.direction, end.share * mu);
  spectral_tangent<dim>(moduli, tau, axes, F_inverse, *A);
  return true;
}

template <int dim>
double CamClay<dim>::p_wave_modulus_at(const MaterialState<dim>& state,
                                       const InternalState& internal) const {
  double change = determinant_minus_one<dim>(in_plane<dim>(state.e));  // det b - 1
  if constexpr (dim == 2) change += state.e[2] + change * state.e[2];
  const double P = parameters_.pressure_at(hencky_strain(change));
  return P / parameters_.swelling + 4 * internal[1] / 3;
}

template class CamClay<2>;
template class CamClay<3>;

}  // namespace gabion
