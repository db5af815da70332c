// SPDX-License-Identifier: BSD-3-Clause
#include "mpm_solver/ranks/point_ranks.hpp"

#include <algorithm>

#include "common/base/log.hpp"
#include "common/base/require.hpp"
#include "common/mechanics/ranks/sum.hpp"

namespace gabion::mpm {

namespace {

// Largest share of points, over the mean, that a rank may have before space is divided anew; where
// cells are too coarse for that, the share that the last partition left, times this.
constexpr double large_share = 1.3;
constexpr double growth = 1.1;

}  // namespace

template <int dim>
double PointRanks<dim>::largest_share(const MaterialPoints<dim>& points) const {
  const auto own = static_cast<double>(points.size());
  double sum = own;
  sum_over_ranks(comm_, std::span<double>(&sum, 1));
  const double largest = max_over_ranks(comm_, own);
  return sum > 0 ? largest * num_ranks(comm_) / sum : 1;
}

template <int dim>
void PointRanks<dim>::divide(MaterialPoints<dim>& points, Surfaces<dim>& surfaces) {
  partition_ = {};
  if (num_ranks(comm_) == 1) return;
  std::vector<Vector<dim>> homes;
  for (const std::int32_t cell : points.cell) homes.push_back(grid_.home(cell));
  partition_ = bisect<dim>(comm_, num_ranks(comm_), homes);
  migrate(owners(), points, surfaces);
  allowed_share_ = std::max(large_share, growth * largest_share(points));
}

template <int dim>
void PointRanks<dim>::follow(MaterialPoints<dim>& points, Surfaces<dim>& surfaces) {
  if (num_ranks(comm_) == 1) return;
  const std::int64_t moved = migrate(owners(), points, surfaces);
  num_moved_ += moved;
  const double share = largest_share(points);
  if (share <= allowed_share_) return;
  log::info("points of ranks: largest {:.2f} of the mean; partition anew", share);
  divide(points, surfaces);
  ++num_divisions_;
}

template <int dim>
void PointRanks<dim>::visit_state(StateVisitor& visitor) {
  std::vector<std::int64_t> axes;
  std::vector<double> positions;
  for (const AxisPlane& plane : partition_.planes()) {
    axes.push_back(plane.axis);
    positions.push_back(plane.position);
  }
  visitor.list("ranks.axes", axes);
  visitor.list("ranks.positions", positions);
  visitor.real("ranks.allowed_share", allowed_share_);
  visitor.integer("ranks.divisions", num_divisions_);
  visitor.integer("ranks.moved", num_moved_);
  require(axes.size() == positions.size(),
          "saved state: found {} axes for {} positions of planes between ranks", axes.size(),
          positions.size());
  std::vector<AxisPlane> planes;
  for (std::size_t k = 0; k < axes.size(); ++k) {
    require(axes[k] >= 0 && axes[k] < dim, "saved state: ranks.axes: found {}, allowed: 0 to {}",
            axes[k], dim - 1);
    planes.push_back({static_cast<int>(axes[k]), positions[k]});
  }
  partition_ = Partition<dim>(std::move(planes));
}

template class PointRanks<2>;
template class PointRanks<3>;

}  // namespace gabion::mpm
