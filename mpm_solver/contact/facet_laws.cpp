// SPDX-License-Identifier: BSD-3-Clause
#include "mpm_solver/contact/facet_laws.hpp"

#include <algorithm>

#include "common/mechanics/tensor_functions.hpp"

namespace gabion::mpm {

template <int dim>
FacetLaws<dim>::FacetLaws(const std::vector<const ContactSettings<dim>*>& members,
                          const JointSurface<dim>& surface, const PointSearch<dim>& search)
    : surface_(surface), search_(search) {
  for (const auto* settings : members) {
    Member& member = members_.emplace_back();
    member.mode = settings->mode;
    member.friction = settings->friction;
    member.drained = settings->drained;
    member.drag = settings->drag;
    member.weakening = settings->weakening;
    member.method = std::get<FacetSettings>(settings->method);
  }
}

template <int dim>
ContactLaw FacetLaws<dim>::law_of(const ContactCandidate<dim>& c, std::int32_t owner,
                                  double part) const {
  const Member& member = members_[owner];
  const FacetSettings& method = member.method;
  const double M = c.modulus, h = cell_size_;
  ContactLaw law{.mode = member.mode,
                 .friction = member.friction / strength_factor_,
                 .penalty = method.penalty_factor * M / (h * h),
                 .tangential_penalty = part * method.tangential_factor * M / h,
                 .normal = NormalLaw::quadratic,
                 .drag = member.drag,
                 .time = search_.soil() ? surface_.share() * search_.soil()->dt : 0,
                 .weakening = {.fall = member.weakening.fall / strength_factor_,
                               .speed = member.weakening.speed}};
  const double k = method.resting_factor;
  if (c.took_weight && k * k * M > 4 * c.weight * method.penalty_factor) {
    law.penalty = k * k * M / (4 * c.weight) * M / (h * h);
    law.linear_from = 2 * h * c.weight / (k * M);
  }
  return law;
}

template <int dim>
void FacetLaws<dim>::add_water(const ContactCandidate<dim>& c, std::int32_t owner, double radius,
                               const Vector<dim>& n, ContactLaw& law) const {
  const std::optional<SoilSurface<dim>>& soil = search_.soil();
  if (!soil || soil->pore_waters.empty() || members_[owner].drained) return;
  const WaterOfBody<dim>& water = soil->pore_waters[c.body];
  // Without flow along the normal.
  law.pore_pressure = std::max(0.0, c.pore_pressure - radius * n.dot(water.weight));
  law.drained = water.drained;
  if (!(c.pore_pressure > 0)) return;
  const double grains = std::max(0.0, -n.dot(in_plane<dim>(c.grain_stress) * n));
  law.grain_share = grains / (grains + c.pore_pressure);
}

template class FacetLaws<2>;
template class FacetLaws<3>;

}  // namespace gabion::mpm
