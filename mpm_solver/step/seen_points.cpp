// SPDX-License-Identifier: BSD-3-Clause
#include "mpm_solver/step/seen_points.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "common/mechanics/ranks/gather.hpp"
#include "common/mechanics/ranks/packet.hpp"

namespace gabion::mpm {

namespace {

/// Box around cells, by the lattice; low above high: there is none.
template <int dim>
struct CellBox {
  Vector<dim> low = Vector<dim>::Constant(std::numeric_limits<double>::infinity());
  Vector<dim> high = -low;

  bool holds(const Vector<dim>& t, double margin) const {
    return ((t - low).array() >= -margin).all() && ((high - t).array() >= -margin).all();
  }
};

// Boxes around the cells of the points of each rank.
template <int dim>
std::vector<CellBox<dim>> boxes_of_ranks(const SightOfPoints<dim>& sight) {
  CellBox<dim> own;
  for (const std::int32_t cell : sight.points.cell) {
    const Vector<dim> at = sight.box.cell_index(cell).template cast<double>();
    own.low = own.low.cwiseMin(at);
    own.high = own.high.cwiseMax(at + Vector<dim>::Ones());
  }
  std::vector<double> values(own.low.begin(), own.low.end());
  values.insert(values.end(), own.high.begin(), own.high.end());
  const std::vector<double> all = gather_on_all<double>(sight.comm, values);
  std::vector<CellBox<dim>> boxes(all.size() / (2 * dim));
  for (std::size_t r = 0; r < boxes.size(); ++r) {
    boxes[r].low = Eigen::Map<const Vector<dim>>(&all[2 * dim * r]);
    boxes[r].high = Eigen::Map<const Vector<dim>>(&all[2 * dim * r + dim]);
  }
  return boxes;
}

template <int dim>
void add_points_of_others(const SightOfPoints<dim>& sight, SeenPoints<dim>& seen) {
  double largest = 0;
  for (const double volume : seen.volume) largest = std::max(largest, volume);
  largest = std::pow(max_over_ranks(sight.comm, largest), 1.0 / dim);
  const double margin = std::max(1.0, sight.reach * largest);
  const std::vector<CellBox<dim>> boxes = boxes_of_ranks(sight);
  Packets out;
  for (std::size_t p = 0; p < seen.x.size(); ++p) {
    const Vector<dim> t = sight.box.lattice_position(seen.x[p]);
    for (int r = 0; r < static_cast<int>(boxes.size()); ++r) {
      if (r == rank_of(sight.comm) || !boxes[r].holds(t, margin)) continue;
      out[r].put(seen.x[p]);
      out[r].put(seen.volume[p]);
      out[r].put(seen.cell[p]);
    }
  }
  for (auto& [rank, packet] : send_packets(sight.comm, out)) {
    while (!packet.empty()) {
      seen.x.push_back(packet.template take<Vector<dim>>());
      seen.volume.push_back(packet.template take<double>());
      seen.cell.push_back(packet.template take<std::int32_t>());
    }
  }
}

}  // namespace

template <int dim>
SeenPoints<dim> see_points(const SightOfPoints<dim>& sight) {
  const MaterialPoints<dim>& points = sight.points;
  SeenPoints<dim> seen{.x = points.x, .volume = {}, .cell = points.cell};
  const double cell_volume = sight.box.spacing.prod();
  for (std::int32_t p = 0; p < points.size(); ++p) {
    seen.volume.push_back(points.V0[p] * points.J[p] / cell_volume);
  }
  if (num_ranks(sight.comm) > 1) add_points_of_others(sight, seen);
  return seen;
}

template SeenPoints<2> see_points<2>(const SightOfPoints<2>&);
template SeenPoints<3> see_points<3>(const SightOfPoints<3>&);

}  // namespace gabion::mpm
