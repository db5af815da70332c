// SPDX-License-Identifier: BSD-3-Clause
#include "common/mechanics/materials/drucker_prager.hpp"

#include <numbers>

#include "common/mechanics/materials/principal_update.hpp"
#include "common/mechanics/materials/yield_tolerance.hpp"

namespace gabion {
namespace {

/// The return of the cone for principal_update().
struct Surface {
  using Return = ConeReturn;
  const PrincipalDruckerPrager& law;
  ApexVolume apex_volume;

  double lambda() const { return law.lambda; }
  double mu() const { return law.mu; }
  bool keeps_gap() const { return apex_volume == ApexVolume::gap; }
  bool yields(const Eigen::Vector3d& eps, const Eigen::Vector3d& tau_trial) const {
    const double p = tau_trial.sum() / 3;
    const double root = shear_size((tau_trial.array() - p).matrix());
    const double size =
        (1 + law.eta) * (law.lambda + 2 * law.mu) * std::max(std::abs(eps[0]), std::abs(eps[2]));
    return root + law.eta * p - law.strength > yield_tolerance * size;
  }
  Return return_to_surface(const Eigen::Vector3d& eps, const Eigen::Vector3d& tau_trial) const {
    return return_to_cone(law, eps, tau_trial);
  }
  YieldRegion region(const Return& returned) const { return returned.region; }
  Eigen::Matrix3d moduli(const Return& returned) const { return return_moduli(law, returned); }
  double shear_factor(const Return& returned, int, int, double G, double) const {
    return returned.shrinkage * G;
  }
};

double triaxial_slope(double angle, ConeMatch match) {
  const double sine = std::sin(angle);
  const double side = match == ConeMatch::compression ? -1 : 1;
  return 2 * std::numbers::sqrt3 * sine / (3 + side * sine);
}

}  // namespace

PrincipalDruckerPrager cone_constants(const DruckerPragerParameters& p) {
  double eta, eta_bar;
  if (p.match == ConeMatch::plane_strain) {
    const double sin_phi = std::sin(p.friction_angle), sin_psi = std::sin(p.dilation_angle);
    const double root = std::sqrt(1 + sin_psi * sin_psi / 3);
    eta = sin_phi * root / (1 + sin_phi * sin_psi / 3);
    eta_bar = sin_psi / root;
  } else {
    eta = triaxial_slope(p.friction_angle, p.match);
    eta_bar = triaxial_slope(p.dilation_angle, p.match);
  }
  return {.lambda = p.lambda,
          .mu = p.mu,
          .eta = eta,
          .eta_bar = eta_bar,
          .strength = eta * p.cohesion / std::tan(p.friction_angle)};
}

template <int dim>
bool DruckerPrager<dim>::update(const Matrix<dim>& H, const MaterialState<dim>& state_n,
                                StressUpdate<dim>& out, Tangent<dim>* A) const {
  return principal_update<dim>(Surface{cone_, parameters_.apex_volume}, H, state_n, out, A);
}

template class DruckerPrager<2>;
template class DruckerPrager<3>;

}  // namespace gabion
