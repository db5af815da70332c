// SPDX-License-Identifier: BSD-3-Clause
#include "common/mechanics/materials/tresca.hpp"

#include "common/mechanics/materials/principal_update.hpp"

namespace gabion {
namespace {

struct Surface : PrincipalSurface {
  Return return_to_surface(const Eigen::Vector3d& eps, const Eigen::Vector3d& tau_trial) const {
    return return_to_tresca(law, eps, tau_trial);
  }
};

}  // namespace

template <int dim>
bool Tresca<dim>::update(const Matrix<dim>& H, const MaterialState<dim>& state_n,
                         StressUpdate<dim>& out, Tangent<dim>* A) const {
  return principal_update<dim>(Surface{{principal_, ApexVolume::forget}}, H, state_n, out, A);
}

template class Tresca<2>;
template class Tresca<3>;

}  // namespace gabion
