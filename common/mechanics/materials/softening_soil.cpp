// SPDX-License-Identifier: BSD-3-Clause
#include "common/mechanics/materials/softening_soil.hpp"

#include <cmath>
#include <numbers>
#include <utility>

#include "common/mechanics/materials/principal_update.hpp"

namespace gabion {
namespace {

/// The return of the law for principal_update(). `share` is what becomes plastic of the inviscid
/// return within the step, r / (1 + r) of Duvaut and Lions.
struct Surface {
  struct Return {
    SofteningReturn inviscid;
    Eigen::Vector3d eps_e, plastic;
  };
  const SofteningSurface& soil;
  const ShearSoFar& before;
  const SoftenedConstants& start;
  bool gap;
  bool at_once;  // no time to flow in, though the strength grows with the rate without bound
  double share;
  double& kappa;  // what the step adds
  bool& solved;

  double lambda() const { return soil.lambda; }
  double mu() const { return soil.mu; }
  bool keeps_gap() const { return gap; }
  bool yields(const Eigen::Vector3d& eps, const Eigen::Vector3d& tau_trial) const {
    return !at_once && principal(start).yields(eps, tau_trial);
  }
  Return return_to_surface(const Eigen::Vector3d& eps, const Eigen::Vector3d& tau_trial) const {
    Return found;
    solved = solve_softening_return(soil, before, eps, tau_trial, found.inviscid);
    found.plastic = share * found.inviscid.state.plastic;
    found.eps_e = share == 1 ? found.inviscid.state.eps_e : Eigen::Vector3d(eps - found.plastic);
    kappa = share * found.inviscid.kappa;
    return found;
  }
  YieldRegion region(const Return& r) const { return region_of(r.inviscid.state.face); }
  Eigen::Matrix3d moduli(const Return& r) const {
    Eigen::Matrix3d D = share * softening_moduli(r.inviscid);
    D.array() += (1 - share) * soil.lambda;
    D.diagonal().array() += (1 - share) * 2 * soil.mu;
    return D;
  }
  std::pair<Eigen::Matrix3d, double> apex_moduli(const Return& r) const {
    return {moduli(r), 1 - share};
  }
  double shear_factor(const Return& r, int s, int t, double G, double difference) const {
    const double inviscid =
        principal(r.inviscid.constants).shear_factor(r.inviscid.state, s, t, G, difference);
    return share == 1 ? inviscid : share * inviscid + (1 - share) * G;
  }

 private:
  static PrincipalSurface<gabion::return_to_surface> principal(const SoftenedConstants& now) {
    return {now.law, ApexVolume::forget, now.tension_cutoff};
  }
};

SofteningSurface surface_of(const SofteningParameters& p) {
  return {.lambda = p.lambda,
          .mu = p.mu,
          .curve = p.curve,
          .frictional = p.frictional,
          .cutoff_share = p.tension_cutoff == no_cutoff
                              ? no_cutoff
                              : p.tension_cutoff / p.curve.at(0).value.cohesion,
          .rate_gain = p.rate_gain};
}

}  // namespace

template <int dim>
SofteningSoil<dim>::SofteningSoil(const SofteningParameters& parameters)
    : parameters_(parameters),
      surface_(surface_of(parameters)),
      virgin_(surface_.at(0, 1)),
      batch_(virgin_.law, parameters.apex_volume == ApexVolume::gap) {}

template <int dim>
ShearSoFar SofteningSoil<dim>::shear_of(const PointContext& context) const {
  if (!parameters_.by_slip) return {.x = context.internal[0], .rate = 1, .dt = context.dt};
  return {
      .x = context.internal[1], .rate = std::numbers::sqrt3 * context.band_width, .dt = context.dt};
}

template <int dim>
bool SofteningSoil<dim>::update(const PointContext& context, const Matrix<dim>& H,
                                const MaterialState<dim>& state_n, StressUpdate<dim>& out,
                                Tangent<dim>* A) const {
  const ShearSoFar before = shear_of(context);
  const bool is_virgin = before.x == 0;
  const SoftenedConstants start = is_virgin ? virgin_ : surface_.at(before.x, before.rate);
  double kappa = 0;
  bool solved = true;
  const double t_v = parameters_.relaxation_time;
  const Surface surface{.soil = surface_,
                        .before = before,
                        .start = start,
                        .gap = parameters_.apex_volume == ApexVolume::gap,
                        .at_once = parameters_.rate_gain.gain > 0 && context.dt == 0,
                        .share = t_v > 0 ? 1 / (1 + t_v / context.dt) : 1,
                        .kappa = kappa,
                        .solved = solved};
  if (!principal_update<dim>(surface, H, state_n, out, A)) return false;
  if (!solved) out.refusal = Refusal::unsolved;
  out.internal = context.internal;
  out.internal[0] += kappa;
  out.internal[1] += std::numbers::sqrt3 * context.band_width * kappa;
  return solved;
}

template <int dim>
LaneMask SofteningSoil<dim>::update_elastic(const std::array<PointContext, num_lanes>& contexts,
                                            PointBatch<dim>& batch, bool with_A) const {
  if (parameters_.tension_cutoff != no_cutoff) return LaneMask{};
  Lanes k, strength;
  for (int l = 0; l < num_lanes; ++l) {
    const ShearSoFar before = shear_of(contexts[l]);
    const PrincipalMohrCoulomb law =
        before.x == 0 ? virgin_.law : surface_.at(before.x, before.rate).law;
    k[l] = law.k;
    strength[l] = law.strength;
  }
  return batch_.update_elastic(batch, {k, strength}, with_A);
}

template class SofteningSoil<2>;
template class SofteningSoil<3>;

}  // namespace gabion
