// SPDX-License-Identifier: BSD-3-Clause
#include "common/mechanics/materials/umat.hpp"

namespace gabion {

class UmatModel {};

template <int dim>
bool Umat<dim>::update(const PointContext&, const Matrix<dim>&, const MaterialState<dim>&,
                       StressUpdate<dim>&, Tangent<dim>*) const {
  return false;
}
template <int dim>
bool Umat<dim>::symmetric_tangent() const {
  return false;
}
template <int dim>
double Umat<dim>::p_wave_modulus() const {
  return 0;
}
template <int dim>
double Umat<dim>::shear_modulus() const {
  return 0;
}
template <int dim>
int Umat<dim>::num_variables() const {
  return 0;
}

template class Umat<2>;
template class Umat<3>;

}  // namespace gabion
