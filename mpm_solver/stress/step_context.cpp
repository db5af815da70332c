// SPDX-License-Identifier: BSD-3-Clause
#include "mpm_solver/stress/step_context.hpp"

#include <algorithm>

namespace gabion::mpm {

// Width of the band over the cell size. With it a layer that is sheared along the rows of the grid,
// filled with rows of points as bodies are laid, does the work of a surface that slips by five
// times its softening slip.
constexpr double narrowest_band(Basis basis) {
  return basis == Basis::bspline ? 1.35 : 1;
}

template <int dim>
double band_width(const BackgroundGrid<dim>& grid, std::int32_t cell) {
  return narrowest_band(grid.basis) * shortest_edge(grid, cell);
}

template <int dim>
PointContext StepContext<dim>::of_point(const MaterialPoints<dim>& points, std::int32_t p) const {
  PointContext context{.dt = dt};
  if (grid != nullptr && points.cell[p] >= 0) {
    context.band_width = gabion::mpm::band_width(*grid, points.cell[p]);
  }
  if (!averages.empty()) {
    const auto next = std::ranges::upper_bound(points.body_starts, p);
    const SofteningAverage& average = averages[next - points.body_starts.begin() - 1];
    if (average.acts()) context.band_width = average.own_width();
  }
  if (!points.internal.empty()) context.internal = points.internal[p];
  if (!points.variables.empty()) context.variables = numbers_of(points.variables[p]);
  return context;
}

template double band_width<2>(const BackgroundGrid<2>&, std::int32_t);
template double band_width<3>(const BackgroundGrid<3>&, std::int32_t);
template struct StepContext<2>;
template struct StepContext<3>;

}  // namespace gabion::mpm
