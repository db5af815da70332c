// SPDX-License-Identifier: BSD-3-Clause
#include "mpm_solver/points/point_totals.hpp"

#include <algorithm>
#include <limits>

#include "common/mechanics/ranks/sum.hpp"

namespace gabion::mpm {

template <int dim>
PointTotals<dim> point_totals(MPI_Comm comm, const MaterialPoints<dim>& points) {
  std::vector<double> sums(3 + dim, 0.0);  // mass, kinetic, elastic, momentum
  PointTotals<dim> totals;
  for (std::int32_t b = 0; b < points.num_bodies(); ++b) {
    double front = -std::numeric_limits<double>::infinity();
    for (std::int32_t p = points.body_starts[b]; p < points.body_starts[b + 1]; ++p) {
      sums[0] += points.m[p];
      sums[1] += 0.5 * points.m[p] * points.v[p].squaredNorm();
      sums[2] += points.V0[p] * points.energy[p];
      for (int d = 0; d < dim; ++d) sums[3 + d] += points.m[p] * points.v[p][d];
      front = std::max(front, points.x[p][0]);
    }
    totals.front.push_back(max_over_ranks(comm, front));
  }
  sum_over_ranks(comm, std::span<double>(sums));
  totals.mass = sums[0];
  totals.kinetic_energy = sums[1];
  totals.elastic_energy = sums[2];
  for (int d = 0; d < dim; ++d) totals.momentum[d] = sums[3 + d];
  return totals;
}

template PointTotals<2> point_totals<2>(MPI_Comm, const MaterialPoints<2>&);
template PointTotals<3> point_totals<3>(MPI_Comm, const MaterialPoints<3>&);

}  // namespace gabion::mpm
