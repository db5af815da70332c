// SPDX-License-Identifier: BSD-3-Clause
#include "mpm_solver/stress/seepage_inlets.hpp"

#include <algorithm>
#include <cmath>

#include "mpm_solver/grid/surface_values.hpp"

namespace gabion::mpm {

template <int dim>
SeepageInlets<dim>::SeepageInlets(const StressParts<dim>& parts, const BackgroundGrid<dim>& grid,
                                  std::span<const FedSide> sides, const Step& step)
    : weights_(parts.weights) {
  for (const CellGroup& group : weights_.groups) {
    const auto& water = parts.bodies[group.body].water;
    if (!water || !water->drains()) continue;
    const BoxGrid<dim>& box = *grid.box;
    for (std::int32_t e = group.first; e < group.last; ++e) {
      const std::int32_t p = weights_.point[e];
      const Vector<dim>& x = parts.points.x[p];
      const Vector<dim> sizes = 2 * parts.points.half_length[p];
      for (const FedSide& side : sides) {
        const int d = side.axis;
        const double to_side = side.high ? box.high[d] - x[d] : x[d] - box.low[d];
        if (to_side >= sizes[d]) continue;
        const Vector<dim> into = (side.high ? -1 : 1) * Vector<dim>::Unit(d);
        Inlet inlet{.entry = e};
        const Vector<dim> place =
            x + SurfaceValues<dim>(grid, parts.points, p).at(into, to_side, inlet.w.data());
        inlet.at_rest = water->density * step.gravity.dot(place);
        inlet.volume = side.rate * sizes.prod() / sizes[d] * step.dt;
        inlets_.push_back(inlet);
      }
    }
  }
}

template <int dim>
typename SeepageInlets<dim>::Fed SeepageInlets<dim>::add(const CellGroup& group, const double* q,
                                                         const std::int32_t* active,
                                                         std::vector<double>& r) const {
  Fed fed;
  auto inlet = std::ranges::lower_bound(inlets_, group.first, {}, &Inlet::entry);
  for (; inlet != inlets_.end() && inlet->entry < group.last; ++inlet) {
    const std::uint8_t* local = weights_.local_of(inlet->entry);
    double p = inlet->at_rest;
    for (int i = 0; i < weights_.num_nodes(inlet->entry); ++i) {
      p += inlet->w[i] * q[local[i]];
      r[active[local[i]]] -= inlet->w[i] * inlet->volume;
    }
    fed.volume += inlet->volume;
    fed.leaving += std::max(0.0, -inlet->volume);
    fed.work += p * inlet->volume;
  }
  return fed;
}

template <int dim>
double surface_area(const MaterialPoints<dim>& points, const OuterPoint<dim>& at) {
  if (points.half_length.empty()) return at.area;
  const Vector<dim> sides = 2 * points.half_length[at.point];
  int across = 0;
  at.n.cwiseProduct(sides).cwiseAbs().maxCoeff(&across);
  return sides.prod() / sides[across] / std::abs(at.n[across]);
}

template class SeepageInlets<2>;
template class SeepageInlets<3>;
template double surface_area<2>(const MaterialPoints<2>&, const OuterPoint<2>&);
template double surface_area<3>(const MaterialPoints<3>&, const OuterPoint<3>&);

}  // namespace gabion::mpm
