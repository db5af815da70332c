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
  return {.lambda = p.lambda,
          .mu = p.mu,
          .k = k,
          .m = flow_ratio(p.dilation_angle),
          .strength = 2 * p.cohesion * std::sqrt(k)};
}

}  // namespace

template <int dim>
MohrCoulomb<dim>::MohrCoulomb(const MohrCoulombParameters& parameters)
    : parameters_(parameters), principal_(principal_constants(parameters)) {
  if (parameters.tension_cutoff == no_cutoff) {
    batch_return_.emplace(principal_, parameters.apex_volume == ApexVolume::gap);
  }
}

template <int dim>
bool MohrCoulomb<dim>::update(const Matrix<dim>& H, const MaterialState<dim>& state_n,
                              StressUpdate<dim>& out, Tangent<dim>* A) const {
  const PrincipalSurface<return_to_surface> surface = {principal_, parameters_.apex_volume,
                                                       parameters_.tension_cutoff};
  return principal_update<dim>(surface, H, state_n, out, A);
}

template class MohrCoulomb<2>;
template class MohrCoulomb<3>;

}  // namespace gabion
