// SPDX-License-Identifier: BSD-3-Clause
#include "fem_solver/materials/elastic_log_stress.hpp"

#include <Eigen/LU>

namespace gabion::fem {

namespace {

/// T = lambda tr(E) 1 + 2 mu E
template <int dim, class Law>
void linear_stress(const Law& law, const Symmetric<dim>& E, LogStress<dim>& out) {
  out.T = 2 * law.mu * E;
  out.T.template head<3>().array() += law.lambda * trace<dim>(E);
  out.D = 2 * law.mu * StrainMatrix<dim>::Identity();
  out.D.template topLeftCorner<dim, dim>().array() += law.lambda;
  out.energy = 0.5 * contract<dim>(out.T, E);
}

}  // namespace

template <int dim>
void log_stress(const LinearElastic<dim>& law, const Symmetric<dim>& E, LogStress<dim>& out) {
  linear_stress<dim>(law, E, out);
}

template <int dim>
void log_stress(const HenckyElastic<dim>& law, const Symmetric<dim>& E, LogStress<dim>& out) {
  linear_stress<dim>(law, E, out);
}

/// T = lambda tr(E) 1 + mu (exp(2 E) - 1)
template <int dim>
void log_stress(const NeoHookean<dim>& law, const Symmetric<dim>& E, LogStress<dim>& out) {
  const Eigenpairs<dim> pairs = eigenpairs<dim>(E);
  const double volumetric = trace<dim>(E);
  std::array<double, 3> stretched;  // exp(2 E) - 1
  for (int i = 0; i < 3; ++i) stretched[i] = strain_from_hencky(pairs.value[i]);
  out.T = law.mu * compose<dim>(stretched, pairs.n);
  out.T.template head<3>().array() += law.lambda * volumetric;
  out.energy = 0.5 * law.lambda * volumetric * volumetric +
               law.mu * (0.5 * (stretched[0] + stretched[1] + stretched[2]) - volumetric);
  // d exp(2 E)_ab = dE_ab times the quotient of differences, on the axes of E
  const LogStrain<dim> strain = log_strain_of<dim>(E);
  out.D = 2 * law.mu * log_by_green<dim>(strain).inverse();
  out.D.template topLeftCorner<dim, dim>().array() += law.lambda;
}

template void log_stress<2>(const NeoHookean<2>&, const Symmetric<2>&, LogStress<2>&);
template void log_stress<3>(const NeoHookean<3>&, const Symmetric<3>&, LogStress<3>&);
template void log_stress<2>(const HenckyElastic<2>&, const Symmetric<2>&, LogStress<2>&);
template void log_stress<3>(const HenckyElastic<3>&, const Symmetric<3>&, LogStress<3>&);
template void log_stress<2>(const LinearElastic<2>&, const Symmetric<2>&, LogStress<2>&);
template void log_stress<3>(const LinearElastic<3>&, const Symmetric<3>&, LogStress<3>&);

}  // namespace gabion::fem
