// SPDX-License-Identifier: BSD-3-Clause
#include "mpm_solver/boulders/random_places.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>

#include "common/base/error.hpp"
#include "mpm_solver/contact/start_check.hpp"

namespace gabion::mpm {

namespace {

using Corner = std::array<double, 2>;

double cross(const Corner& a, const Corner& b, const Corner& c) {
  return (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0]);
}

// A ray along x meets an odd number of sides.
bool is_inside(const std::vector<Corner>& polygon, const Corner& x) {
  bool inside = false;
  for (std::size_t k = 0; k < polygon.size(); ++k) {
    const Corner &a = polygon[k], &b = polygon[(k + 1) % polygon.size()];
    if ((a[1] > x[1]) == (b[1] > x[1])) continue;
    if ((cross(a, b, x) > 0) == (b[1] > a[1])) inside = !inside;
  }
  return inside;
}

double distance_to(const std::vector<Corner>& polygon, const Corner& x) {
  double least = std::numeric_limits<double>::infinity();
  for (std::size_t k = 0; k < polygon.size(); ++k) {
    const Corner &a = polygon[k], &b = polygon[(k + 1) % polygon.size()];
    const std::array<Vector<2>, 2> side = {Vector<2>(a[0], a[1]), Vector<2>(b[0], b[1])};
    const Vector<2> y(x[0], x[1]);
    least = std::min(least, (y - closest_place<2>(side, y).x).norm());
  }
  return least;
}

}  // namespace

template <int dim>
double RandomRegion<dim>::volume() const {
  if (polygon.empty()) return box.sizes().prod();
  double twice = 0;
  for (std::size_t k = 1; k + 1 < polygon.size(); ++k) {
    twice += cross(polygon[0], polygon[k], polygon[k + 1]);
  }
  return 0.5 * std::abs(twice) * (dim == 3 ? box.sizes()[dim - 1] : 1);
}

template <int dim>
bool RandomRegion<dim>::holds(const Vector<dim>& centre, double radius) const {
  const Vector<dim> low = centre.array() - radius, high = centre.array() + radius;
  if (!box.contains(low) || !box.contains(high)) return false;
  if (polygon.empty()) return true;
  const Corner x = {centre[0], centre[1]};
  return is_inside(polygon, x) && distance_to(polygon, x) >= radius;
}

template <int dim>
RandomPlaces<dim>::RandomPlaces(const RandomRegion<dim>& region, const BoulderScene<dim>& among,
                                double apart)
    : region_(region), apart_(apart) {
  for (const auto& boulder : among.boulders) {
    balls_.push_back({boulder.start.x.template head<dim>(), boulder.shape.radius});
  }
  for (const auto& surface : surfaces_at_start<dim>(among.interfaces, among.rigid_walls)) {
    Eigen::AlignedBox<double, dim> around = region.box;
    for (const Vector<dim>& x : surface.vertices) around.extend(x);
    surfaces_.emplace_back(surface.settings.surface, surface.vertices, around.diagonal().norm());
  }
}

// The count of the reason why a ball has no room, null: it has.
template <int dim>
int* RandomPlaces<dim>::refusal(const Ball& ball, Rejected& rejected) const {
  if (!region_.holds(ball.centre, ball.radius)) return &rejected.out_of_region;
  for (const Ball& other : balls_) {
    const double least = ball.radius + other.radius + apart_;
    if ((ball.centre - other.centre).squaredNorm() < least * least) return &rejected.at_boulder;
  }
  for (const auto& surface : surfaces_) {
    const SurfaceSide side = surface.side(ball.centre);
    const bool behind = side.known() && !side.in_front();
    if (behind || side.distance < ball.radius + apart_) return &rejected.at_surface;
  }
  return nullptr;
}

template <int dim>
Vector<dim> RandomPlaces<dim>::draw(double radius, RandomNumbers& random) {
  Rejected now;
  for (int k = 0; k < most_draws; ++k) {
    Ball ball{.centre = Vector<dim>::Zero(), .radius = radius};
    for (int d = 0; d < dim; ++d) {
      ball.centre[d] = random.between(region_.box.min()[d], region_.box.max()[d]);
    }
    if (int* reason = refusal(ball, now)) {
      ++*reason;
      continue;
    }
    balls_.push_back(ball);
    rejected_.out_of_region += now.out_of_region;
    rejected_.at_boulder += now.at_boulder;
    rejected_.at_surface += now.at_surface;
    return ball.centre;
  }
  throw ConfigError(fmt::format(
      "found no room in {} draws for a ball of radius {:.4g} m around a boulder, between ({:.6g}) "
      "and ({:.6g}): {} left the region, {} came to other boulders, {} to interfaces or rigid "
      "walls; "
      "allowed: fewer or smaller boulders, a smaller distance, a larger region",
      most_draws, radius, fmt::join(region_.box.min(), ", "), fmt::join(region_.box.max(), ", "),
      now.out_of_region, now.at_boulder, now.at_surface));
}

template struct RandomRegion<2>;
template struct RandomRegion<3>;
template class RandomPlaces<2>;
template class RandomPlaces<3>;

}  // namespace gabion::mpm
