// SPDX-License-Identifier: BSD-3-Clause
#include "common/mechanics/materials/herschel_bulkley.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "common/mechanics/materials/drucker_prager_return.hpp"
#include "common/mechanics/materials/principal_update.hpp"
#include "common/mechanics/materials/yield_tolerance.hpp"

namespace gabion {
namespace {

struct FluidReturn {
  Eigen::Vector3d eps_e;      // elastic Hencky strain
  Eigen::Vector3d plastic;    // trial minus elastic
  Eigen::Vector3d direction;  // s_trial / sqrt(J2_trial)
  double shrinkage = 1;       // sqrt(J2) / sqrt(J2_trial)
  double slope = 1;           // d sqrt(J2) / d sqrt(J2_trial)
};

// The return of the fluid for principal_update().
struct Surface {
  using Return = FluidReturn;
  const HerschelBulkleyParameters& law;
  double dt;
  bool& solved;

  double lambda() const { return law.lambda; }
  double mu() const { return law.mu; }
  bool keeps_gap() const { return false; }
  bool yields(const Eigen::Vector3d& eps, const Eigen::Vector3d& tau_trial) const {
    if (!(dt > 0)) return false;
    const double p = tau_trial.sum() / 3;
    const double size = (law.lambda + 2 * law.mu) * std::max(std::abs(eps[0]), std::abs(eps[2]));
    return shear_size((tau_trial.array() - p).matrix()) - law.yield_stress > yield_tolerance * size;
  }
  Return return_to_surface(const Eigen::Vector3d& eps, const Eigen::Vector3d& tau_trial) const {
    const Eigen::Vector3d s = (tau_trial.array() - tau_trial.sum() / 3).matrix();
    const double root = shear_size(s);
    ViscousFlow flow;
    solved = solve_viscous_flow(law, root - law.yield_stress, dt, flow);
    const Eigen::Vector3d n = s / root;
    const Eigen::Vector3d plastic = 0.5 * flow.shear * n;
    return {.eps_e = eps - plastic,
            .plastic = plastic,
            .direction = n,
            .shrinkage = 1 - law.mu * flow.shear / root,
            .slope = flow.slope};
  }
  YieldRegion region(const Return&) const { return YieldRegion::shear; }
  Eigen::Matrix3d moduli(const Return& r) const {
    Eigen::Matrix3d D = law.mu * (r.slope - r.shrinkage) * r.direction * r.direction.transpose();
    D.array() += law.lambda + 2 * law.mu / 3 - r.shrinkage * 2 * law.mu / 3;
    D.diagonal().array() += r.shrinkage * 2 * law.mu;
    return D;
  }
  double shear_factor(const Return& r, int, int, double G, double) const { return r.shrinkage * G; }
};

}  // namespace

// With p = max(n, 1/n) the unknown is the viscous stress (n <= 1) or mu x (n > 1): u + A u^p =
// excess. The left side is convex and grows, so Newton's method falls to the root from any start
// above it, and both terms alone give such a start.
bool solve_viscous_flow(const HerschelBulkleyParameters& law, double excess, double dt,
                        ViscousFlow& flow) {
  const bool thins = law.flow_index <= 1;
  const double p = thins ? 1 / law.flow_index : law.flow_index;
  const double unit = thins ? law.consistency : law.mu * dt;  // of u in the power
  const double factor = thins ? law.mu * dt : law.consistency;
  double u = std::min(excess, unit * std::pow(excess / factor, 1 / p));
  double power = factor * std::pow(u / unit, p);
  bool solved = false;
  for (int pass = 0; pass < 50 && !solved; ++pass) {
    const double change = (u + power - excess) / (1 + p * power / u);
    solved = std::abs(change) <= 4 * std::numeric_limits<double>::epsilon() * u;
    u -= change;
    power = factor * std::pow(u / unit, p);
  }
  const double viscous = thins ? u : power;  // K (x / dt)^n
  const double elastic = thins ? power : u;  // mu x
  flow.shear = elastic / law.mu;
  flow.slope = law.flow_index * viscous / (elastic + law.flow_index * viscous);
  return solved && std::isfinite(flow.slope);
}

template <int dim>
bool HerschelBulkley<dim>::update(const PointContext& context, const Matrix<dim>& H,
                                  const MaterialState<dim>& state_n, StressUpdate<dim>& out,
                                  Tangent<dim>* A) const {
  bool solved = true;
  const Surface surface{parameters_, context.dt, solved};
  if (!principal_update<dim>(surface, H, state_n, out, A)) return false;
  if (!solved) out.refusal = Refusal::unsolved;
  return solved;
}

template class HerschelBulkley<2>;
template class HerschelBulkley<3>;

}  // namespace gabion
