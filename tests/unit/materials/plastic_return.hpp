// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cmath>
#include <functional>
#include <vector>

#include <Eigen/LU>

#include "tests/unit/materials/random_state.hpp"

namespace gabion::testing {

/// Constants of Mohr-Coulomb from the definition, not from the law.
template <int dim>
PrincipalMohrCoulomb principal_law(const MohrCoulomb<dim>& law) {
  const auto ratio = [](double angle) { return (1 + std::sin(angle)) / (1 - std::sin(angle)); };
  const auto& p = law.parameters();
  const double k = ratio(p.friction_angle);
  return {p.lambda, p.mu, k, ratio(p.dilation_angle), 2 * p.cohesion * std::sqrt(k)};
}
template <int dim>
PrincipalMohrCoulomb principal_law(const Tresca<dim>& law) {
  const auto& p = law.parameters();
  return {p.lambda, p.mu, 1, 1, 2 * p.cohesion};
}

template <int dim>
PrincipalReturn principal_return(const MohrCoulomb<dim>& law, const Eigen::Vector3d& eps,
                                 const Eigen::Vector3d& tau) {
  return return_to_surface(principal_law(law), eps, tau);
}
template <int dim>
PrincipalReturn principal_return(const Tresca<dim>& law, const Eigen::Vector3d& eps,
                                 const Eigen::Vector3d& tau) {
  return return_to_tresca(principal_law(law), eps, tau);
}

inline Eigen::Vector3d stress_of(const auto& law, const Eigen::Vector3d& eps) {
  return (law.lambda * eps.sum() + 2 * law.mu * eps.array()).matrix();
}

inline bool yields(const PrincipalMohrCoulomb& law, const Eigen::Vector3d& tau) {
  return law.k * tau[0] - tau[2] > law.strength;
}

/// Sorted trial Hencky strains of a step; an open gap counts as volumetric strain.
template <int dim>
Eigen::Vector3d trial_strain(const Matrix<dim>& H, const MaterialState<dim>& state_n) {
  const Eigen::Vector3d e = principal<dim>(push_forward<dim>(H, state_n.e));
  return e.unaryExpr([&](double x) { return 0.5 * std::log1p(x) + state_n.gap / 3; });
}

/// -1 elastic, otherwise the YieldFace of a step.
template <int dim, class Law>
int face_of(const Law& law, const Matrix<dim>& H, const MaterialState<dim>& state_n) {
  const auto constants = principal_law(law);
  const Eigen::Vector3d eps = trial_strain<dim>(H, state_n);
  const Eigen::Vector3d tau = stress_of(constants, eps);
  if (!yields(constants, tau)) return -1;
  return static_cast<int>(principal_return(law, eps, tau).face);
}

/// The part of a cone's yield surface that a step returns to: -1 elastic, otherwise the
/// YieldRegion.
template <int dim>
int face_of(const DruckerPrager<dim>& law, const Matrix<dim>& H,
            const MaterialState<dim>& state_n) {
  const auto& cone = law.cone();
  const Eigen::Vector3d eps = trial_strain<dim>(H, state_n);
  const Eigen::Vector3d tau = stress_of(cone, eps);
  const double p = tau.mean();
  if (shear_size((tau.array() - p).matrix()) + cone.eta * p <= cone.strength) return -1;
  return static_cast<int>(return_to_cone(cone, eps, tau).region);
}

/// A plane a . tau = strength of unsorted principal stresses with flow direction b.
struct YieldPlane {
  Eigen::Vector3d a, b;
  double strength;
};

/// The six planes k t_i - t_j = strength.
inline std::vector<YieldPlane> shear_planes(const PrincipalMohrCoulomb& law) {
  std::vector<YieldPlane> planes;
  for (int i = 0; i < 3; ++i) {
    for (int j = 0; j < 3; ++j) {
      if (i == j) continue;
      const Eigen::Vector3d e_i = Eigen::Vector3d::Unit(i), e_j = Eigen::Vector3d::Unit(j);
      planes.push_back({law.k * e_i - e_j, law.m * e_i - e_j, law.strength});
    }
  }
  return planes;
}

/// Every stress that satisfies the Kuhn-Tucker conditions of a return with one, two or three active
/// planes: on them, with non-negative multipliers, and beyond no other.
inline std::vector<Eigen::Vector3d> admissible_returns(const PrincipalMohrCoulomb& law,
                                                       const std::vector<YieldPlane>& planes,
                                                       const Eigen::Vector3d& trial) {
  Eigen::Matrix3d C = Eigen::Matrix3d::Constant(law.lambda);
  C.diagonal().array() += 2 * law.mu;
  const double small = 1e-10 * (trial.norm() + law.strength);
  std::vector<Eigen::Vector3d> found;
  const auto try_planes = [&](const std::vector<const YieldPlane*>& active) {
    const auto n = static_cast<Eigen::Index>(active.size());
    Eigen::Matrix<double, 3, Eigen::Dynamic, 0, 3, 3> Cb(3, n);
    Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, 0, 3, 3> system(n, n);
    Eigen::Matrix<double, Eigen::Dynamic, 1, 0, 3, 1> f(n);
    for (Eigen::Index p = 0; p < n; ++p) Cb.col(p) = C * active[p]->b;
    for (Eigen::Index p = 0; p < n; ++p) {
      f[p] = active[p]->a.dot(trial) - active[p]->strength;
      system.row(p) = active[p]->a.transpose() * Cb;
    }
    if (std::abs(system.determinant()) < 1e-9) return;
    const auto multipliers = system.inverse() * f;
    if (multipliers.minCoeff() < -small) return;
    const Eigen::Vector3d tau = trial - Cb * multipliers;
    for (const auto& plane : planes)
      if (plane.a.dot(tau) - plane.strength > small) return;
    found.push_back(tau);
  };
  for (std::size_t p = 0; p < planes.size(); ++p) {
    try_planes({&planes[p]});
    for (std::size_t q = p + 1; q < planes.size(); ++q) {
      try_planes({&planes[p], &planes[q]});
      for (std::size_t r = q + 1; r < planes.size(); ++r)
        try_planes({&planes[p], &planes[q], &planes[r]});
    }
  }
  return found;
}

/// Random trial strains, sorted, whose stress is outside the surface.
inline std::vector<Eigen::Vector3d> yielding_trials(
    int count, const std::function<bool(const Eigen::Vector3d& eps)>& outside) {
  Random random(17);
  std::vector<Eigen::Vector3d> list;
  while (static_cast<int>(list.size()) < count) {
    Eigen::Vector3d eps = Eigen::Vector3d::NullaryExpr([&] { return random.uniform(-0.1, 0.1); });
    eps.array() += random.uniform(-0.1, 0.1);
    std::sort(eps.data(), eps.data() + 3, std::greater<>());
    if (outside(eps)) list.push_back(eps);
  }
  return list;
}

}  // namespace gabion::testing
