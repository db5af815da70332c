// SPDX-License-Identifier: BSD-3-Clause
#include "common/mechanics/materials/mu_i.hpp"

#include <algorithm>
#include <cmath>

#include "common/mechanics/materials/drucker_prager_return.hpp"
#include "common/mechanics/materials/principal_update.hpp"
#include "common/mechanics/materials/yield_tolerance.hpp"

namespace gabion {
namespace {

struct GranularReturn {
  YieldRegion region = YieldRegion::apex;
  Eigen::Vector3d eps_e;      // elastic Hencky strain
  Eigen::Vector3d plastic;    // trial minus elastic
  Eigen::Vector3d direction;  // s_trial / sqrt(J2_trial)
  double shrinkage = 0;       // sqrt(J2) / sqrt(J2_trial)
  GranularFlow flow;
};

// The return of the grains for principal_update().
struct Surface {
  using Return = GranularReturn;
  const MuIParameters& law;
  double dt;

  double lambda() const { return law.lambda; }
  double mu() const { return law.mu; }
  double bulk() const { return law.lambda + 2 * law.mu / 3; }
  bool keeps_gap() const { return law.apex_volume == ApexVolume::gap; }
  bool yields(const Eigen::Vector3d& eps, const Eigen::Vector3d& tau_trial) const {
    const double p = tau_trial.sum() / 3;
    const double root = shear_size((tau_trial.array() - p).matrix());
    const double friction = dt > 0 ? law.static_friction : law.limit_friction;
    const double size =
        (1 + friction) * (law.lambda + 2 * law.mu) * std::max(std::abs(eps[0]), std::abs(eps[2]));
    return root + friction * p > yield_tolerance * size;
  }
  Return return_to_surface(const Eigen::Vector3d& eps, const Eigen::Vector3d& tau_trial) const {
    const double p = tau_trial.sum() / 3;
    if (p >= 0) {
      return {.eps_e = Eigen::Vector3d::Zero(),
              .plastic = eps,
              .direction = Eigen::Vector3d::Zero(),
              .flow = {}};
    }
    const Eigen::Vector3d s = (tau_trial.array() - p).matrix();
    const double root = shear_size(s);
    const GranularFlow flow = solve_granular_flow(law, root, -p, dt);
    const Eigen::Vector3d n = s / root;
    const Eigen::Vector3d plastic = 0.5 * flow.shear * n;
    return {.region = YieldRegion::shear,
            .eps_e = eps - plastic,
            .plastic = plastic,
            .direction = n,
            .shrinkage = -p * flow.friction / root,
            .flow = flow};
  }
  YieldRegion region(const Return& r) const { return r.region; }
  Eigen::Matrix3d moduli(const Return& r) const {
    Eigen::Matrix3d D =
        law.mu * (r.flow.by_trial - r.shrinkage) * r.direction * r.direction.transpose();
    D -= bulk() * r.flow.by_pressure * r.direction * Eigen::RowVector3d::Ones();
    D.array() += bulk() - r.shrinkage * 2 * law.mu / 3;
    D.diagonal().array() += r.shrinkage * 2 * law.mu;
    return D;
  }
  double shear_factor(const Return& r, int, int, double G, double) const { return r.shrinkage * G; }
};

}  // namespace

// With b = I_0 dt sqrt(P / rho_s) / d, the shear at I_0, the equation is
//
//     G x^2 + (G b + P (mu_2 - mu_s) - beta) x - b beta = 0 ,   beta = root - mu_s P
//
// here divided by 1 + b, so that it stands for steps of no and of any length.
GranularFlow solve_granular_flow(const MuIParameters& law, double root, double pressure,
                                 double dt) {
  const double G = law.mu, range = pressure * (law.limit_friction - law.static_friction);
  const double beta = root - law.static_friction * pressure;
  const double b =
      law.inertial_number * dt * std::sqrt(pressure / law.grain_density) / law.grain_size;
  const double one = 1 / (1 + b), at_I_0 = std::isinf(b) ? 1 : b / (1 + b);
  const double B = G * at_I_0 + (range - beta) * one, C = at_I_0 * beta;
  const double R = std::sqrt(B * B + 4 * G * one * C);
  GranularFlow flow;
  flow.shear = B > 0 ? 2 * C / (B + R) : (R - B) / (2 * G * one);
  const double sum = at_I_0 + one * flow.shear;             // (b + x) / (1 + b)
  const double share = one * flow.shear / sum;              // I / (I_0 + I)
  const double slope = range * one / sum * (at_I_0 / sum);  // of P mu(I) by x
  flow.friction = law.static_friction + (law.limit_friction - law.static_friction) * share;
  flow.by_trial = slope / (G + slope);
  flow.by_pressure =
      G / (G + slope) *
      (flow.friction - 0.5 * (law.limit_friction - law.static_friction) * share * (1 - share));
  return flow;
}

template <int dim>
bool MuI<dim>::update(const PointContext& context, const Matrix<dim>& H,
                      const MaterialState<dim>& state_n, StressUpdate<dim>& out,
                      Tangent<dim>* A) const {
  return principal_update<dim>(Surface{parameters_, context.dt}, H, state_n, out, A);
}

template class MuI<2>;
template class MuI<3>;

}  // namespace gabion
