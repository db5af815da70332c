// SPDX-License-Identifier: BSD-3-Clause
#include "common/mechanics/materials/tresca.hpp"

#include "common/mechanics/materials/principal_update.hpp"

namespace gabion {
template <int dim>
bool Tresca<dim>::update(const Matrix<dim>& H, const MaterialState<dim>& state_n,
                         StressUpdate<dim>& out, Tangent<dim>* A) const {
  const PrincipalSurface<return_to_tresca> surface = {principal_, parameters_.apex_volume,
                                                      parameters_.tension_cutoff};
  return principal_update<dim>(surface, H, state_n, out, A);
}

template class Tresca<2>;
template class Tresca<3>;

}  // namespace gabion
