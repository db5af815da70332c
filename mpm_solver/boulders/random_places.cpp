// SPDX-License-Identifier: BSD-3-Clause
#include "mpm_solver/boulders/random_places.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>

#include "common/base/error.hpp"
#include "mpm_solver/contact/start_check.hpp"

namespace gabion::mpm {

template <int dim>
double RandomRegion<dim>::volume() const {
  if (polygon.empty()) return box.sizes().prod();
  return std::abs(signed_area(polygon)) * (dim == 3 ? box.sizes()[dim - 1] : 1);
}

template <int dim>
bool RandomRegion<dim>::holds(const Vector<dim>& centre, double radius) const {
  const Vector<dim> low = centre.array() - radius, high = centre.array() + radius;
  if (!box.contains(low) || !box.contains(high)) return false;
  if (polygon.empty()) return true;
  const Vector<2> x = centre.template head<2>();
  return is_inside(polygon, x) && distance_to(polygon, x) >= radius;
}

template <int dim>
RandomPlaces<dim>::RandomPlaces(const RandomRegion<dim>& region, const BoulderScene<dim>& among,
                                double apart)
    : region_(region), apart_(apart) {
  for (const auto& boulder : among.boulders) {
    spheres_.push_back({boulder.start.x.template head<dim>(), boulder.shape.radius});
  }
  for (const auto& surface : surfaces_at_start<dim>(among.interfaces, among.rigid_walls)) {
    Eigen::AlignedBox<double, dim> around = region.box;
    for (const Vector<dim>& x : surface.vertices) around.extend(x);
    surfaces_.emplace_back(surface.settings.surface, surface.vertices, around.diagonal().norm());
  }
}

// The count of the reason why a sphere has no room, null: it has.
template <int dim>
int* RandomPlaces<dim>::refusal(const Sphere& sphere, Rejected& rejected) const {
  if (!region_.holds(sphere.centre, sphere.radius)) return &rejected.out_of_region;
  for (const Sphere& other : spheres_) {
    const double least = sphere.radius + other.radius + apart_;
    if ((sphere.centre - other.centre).squaredNorm() < least * least) return &rejected.at_boulder;
  }
  for (const auto& surface : surfaces_) {
    const SurfaceSide side = surface.side(sphere.centre);
    const bool behind = side.known() && !side.in_front();
    if (behind || side.distance < sphere.radius + apart_) return &rejected.at_surface;
  }
  return nullptr;
}

template <int dim>
Vector<dim> RandomPlaces<dim>::draw(double radius, RandomNumbers& random) {
  Rejected now;
  for (int k = 0; k < most_draws; ++k) {
    Sphere sphere{.centre = Vector<dim>::Zero(), .radius = radius};
    for (int d = 0; d < dim; ++d) {
      sphere.centre[d] = random.between(region_.box.min()[d], region_.box.max()[d]);
    }
    if (int* reason = refusal(sphere, now)) {
      ++*reason;
      continue;
    }
    spheres_.push_back(sphere);
    rejected_.out_of_region += now.out_of_region;
    rejected_.at_boulder += now.at_boulder;
    rejected_.at_surface += now.at_surface;
    return sphere.centre;
  }
  throw ConfigError(fmt::format(
      "found no room in {} draws for a sphere of radius {:.4g} m around a boulder, between "
      "({:.6g}) and ({:.6g}): {} left the region, {} overlapped other boulders, {} interfaces or "
      "rigid walls; allowed: fewer or smaller boulders, a smaller distance, a larger region",
      most_draws, radius, fmt::join(region_.box.min(), ", "), fmt::join(region_.box.max(), ", "),
      now.out_of_region, now.at_boulder, now.at_surface));
}

template struct RandomRegion<2>;
template struct RandomRegion<3>;
template class RandomPlaces<2>;
template class RandomPlaces<3>;

}  // namespace gabion::mpm
