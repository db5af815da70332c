// SPDX-License-Identifier: BSD-3-Clause
#include "common/mechanics/materials/elastic.hpp"
#include "common/mechanics/tensor_functions.hpp"

namespace gabion {

template <int dim>
bool LinearElastic<dim>::update(const Matrix<dim>& H, const MaterialState<dim>& state_n,
                                StressUpdate<dim>& out, Tangent<dim>* A) const {
  out.J = 1 + determinant_minus_one<dim>(H);
  if (!(out.J > 0)) return false;
  const Symmetric<dim> epsilon = state_n.e + symmetric<dim>(H);
  out.tau = 2 * mu * epsilon;
  out.tau.template head<3>().array() += lambda * trace<dim>(epsilon);
  out.P = in_plane<dim>(out.tau);
  out.state = {.e = epsilon, .plastic_strain = state_n.plastic_strain};
  out.energy = 0.5 * contract<dim>(out.tau, epsilon);
  out.region = YieldRegion::elastic;
  if (!A) return true;

  A->setZero();
  for (int i = 0; i < dim; ++i) {
    for (int j = 0; j < dim; ++j) {
      (*A)(i * dim + i, j * dim + j) += lambda;
      (*A)(i * dim + j, i * dim + j) += mu;
      (*A)(i * dim + j, j * dim + i) += mu;
    }
  }
  return true;
}

template struct LinearElastic<2>;
template struct LinearElastic<3>;

}  // namespace gabion
