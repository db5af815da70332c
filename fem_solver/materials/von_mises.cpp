// SPDX-License-Identifier: BSD-3-Clause
#include "fem_solver/materials/von_mises.hpp"

#include <algorithm>
#include <cmath>

#include "common/mechanics/materials/yield_tolerance.hpp"
#include "fem_solver/materials/log_law.hpp"

namespace gabion::fem {

namespace {

template <int dim>
Eigen::Map<const Symmetric<dim>> plastic_strain_of(std::span<const double> history) {
  return Eigen::Map<const Symmetric<dim>>(history.data());
}

template <int dim>
Symmetric<dim> deviator(Symmetric<dim> s) {
  s.template head<3>().array() -= trace<dim>(s) / 3;
  return s;
}

/// dT/dE = bulk 1 (x) 1 + shear (I - 1 (x) 1 / 3)
template <int dim>
StrainMatrix<dim> isotropic_moduli(double bulk, double shear) {
  StrainMatrix<dim> D = shear * StrainMatrix<dim>::Identity();
  D.template topLeftCorner<dim, dim>().array() += bulk - shear / 3;
  return D;
}

/// Radial return from the elastic trial state, into stress and history.
template <int dim>
void return_to_surface(const VonMises<dim>& law, const Symmetric<dim>& E, LogStress<dim>& stress,
                       std::span<double> history) {
  const Symmetric<dim> E_p = plastic_strain_of<dim>(history);
  const double p = history.back();
  const Symmetric<dim> xi =
      2 * law.mu * deviator<dim>(E - E_p) - 2.0 / 3 * law.kinematic_modulus * E_p;
  const double norm = std::sqrt(contract<dim>(xi, xi));
  const double q = std::sqrt(1.5) * norm;
  const double yield_stress = law.hardening.yield_stress(p);
  const double size = 2 * law.mu * (E.norm() + E_p.norm());
  if (q - yield_stress <= yield_tolerance * (size + yield_stress)) return;
  const double stiffness = 3 * law.mu + law.kinematic_modulus;
  const PlasticFlow flow = law.hardening.flow(q, p, stiffness);
  const Symmetric<dim> n = xi / norm, increment = std::sqrt(1.5) * flow.strain * n;
  stress.T -= 2 * law.mu * increment;
  Eigen::Map<Symmetric<dim>>(history.data()) += increment;
  history.back() = p + flow.strain;
  const double elastic_share = 1 - 3 * law.mu * flow.strain / q;
  const double along_n = 3 * law.mu / (stiffness + flow.slope) - (1 - elastic_share);
  const StrainVector<dim> direction = strain_vector<dim>(in_plane<dim>(n));
  stress.D = isotropic_moduli<dim>(law.lambda + 2.0 / 3 * law.mu, 2 * law.mu * elastic_share) -
             2 * law.mu * along_n * direction * direction.transpose();
}

}  // namespace

template <int dim>
double VonMises<dim>::plastic_work(std::span<const double> history) const {
  const Symmetric<dim> E_p = plastic_strain_of<dim>(history);
  return hardening.work(history.back()) + kinematic_modulus / 3 * contract<dim>(E_p, E_p);
}

template <int dim>
void VonMises<dim>::log_stress(const Symmetric<dim>& E, std::span<const double> history_n,
                               std::span<double> history, LogStress<dim>& out) const {
  std::ranges::copy(history_n, history.begin());
  const Symmetric<dim> E_trial = E - plastic_strain_of<dim>(history_n);
  out.T = 2 * mu * E_trial;
  out.T.template head<3>().array() += lambda * trace<dim>(E_trial);
  out.D = isotropic_moduli<dim>(lambda + 2.0 / 3 * mu, 2 * mu);
  return_to_surface(*this, E, out, history);
  out.energy = 0.5 * contract<dim>(out.T, E - plastic_strain_of<dim>(history));
}

template <int dim>
bool VonMises<dim>::update(const Matrix<dim>& H, std::span<const double> history_n,
                           std::span<double> history, StressUpdate<dim>& out,
                           Tangent<dim>* A) const {
  return update_by_log_stress<dim>(
      H,
      [&](const Symmetric<dim>& E, LogStress<dim>& stress) {
        log_stress(E, history_n, history, stress);
      },
      out, A);
}

template struct VonMises<2>;
template struct VonMises<3>;

}  // namespace gabion::fem
