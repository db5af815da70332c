// SPDX-License-Identifier: BSD-3-Clause
#include "common/mechanics/materials/mohr_coulomb.hpp"

#include "common/mechanics/materials/principal_update.hpp"

namespace gabion {
namespace {

double flow_ratio(double angle) {
  const double sine = std::sin(angle);
  return (1 + sine) / (1 - sine);
}

PrincipalMohrCoulomb principal_constants(const MohrCoulombParameters& p) {
  const double k = flow_ratio(p.friction_angle);
  return {p.lambda, p.mu, k, flow_ratio(p.dilation_angle), 2 * p.cohesion * std::sqrt(k)};
}

struct Surface : PrincipalSurface {
  Return return_to_surface(const Eigen::Vector3d& eps, const Eigen::Vector3d& tau_trial) const {
    return gabion::return_to_surface(law, eps, tau_trial);
  }
};

}  // namespace

template <int dim>
MohrCoulomb<dim>::MohrCoulomb(const MohrCoulombParameters& parameters)
    : parameters_(parameters), principal_(principal_constants(parameters)) {}

template <int dim>
bool MohrCoulomb<dim>::update(const Matrix<dim>& H, const MaterialState<dim>& state_n,
                              StressUpdate<dim>& out, Tangent<dim>* A) const {
  return principal_update<dim>(Surface{{principal_, parameters_.apex_volume}}, H, state_n, out, A);
}

template class MohrCoulomb<2>;
template class MohrCoulomb<3>;

}  // namespace gabion
