// SPDX-License-Identifier: BSD-3-Clause
#include "mpm_solver/boulders/ellipsoid_places.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <limits>

namespace gabion::mpm {

namespace {

// Gaps have this share of coordinates as rounding; over displacements of less than the second share
// of the radius their changes are as small.
constexpr double rounding = 1e-15, least_path = 1e-6;

HardFoot foot_on_edge(int i, int j, double t) {
  HardFoot foot{.on_border = true};
  foot.weights[i] = 1 - t;
  foot.weights[j] = t;
  foot.support =
      static_cast<int>(std::ranges::count_if(foot.weights, [](double w) { return w > 0; }));
  return foot;
}

// The gap of the face, edge or corner of a foot.
EllipsoidGap gap_of(const HardFoot& foot, const HardCorners& facet, const Ellipsoid& own) {
  const Vector<3> place = place_of(foot, facet);
  if (foot.is_face()) return own.to_plane(place, facet.normal());
  if (foot.support == 1) return own.to_point(place);
  const int i = foot.weights[0] > 0 ? 0 : 1, j = foot.weights[2] > 0 ? 2 : 1;
  return own.to_line(place, (facet.x[j] - facet.x[i]).normalized());
}

// The signed distance from an ellipsoid is convex: where its least place on the plane of a
// triangle is outside, that on the triangle is on an edge that can be seen from there.
HardFoot nearest_on_edges(const HardCorners& facet, const Vector<3>& below, const Ellipsoid& own) {
  const auto& c = facet.x;
  const Vector<3> n = (c[1] - c[0]).cross(c[2] - c[0]);
  double least = std::numeric_limits<double>::infinity();
  HardFoot nearest;
  for (int k = 0; k < 3; ++k) {
    const int i = (k + 1) % 3, j = (k + 2) % 3;
    if (n.dot((c[i] - below).cross(c[j] - below)) >= 0) continue;
    const Vector<3> edge = c[j] - c[i];
    const Vector<3> at = own.support(own.to_line(c[i], edge.normalized()).out);
    const double t = std::clamp((at - c[i]).dot(edge) / edge.squaredNorm(), 0.0, 1.0);
    const HardFoot foot = foot_on_edge(i, j, t);
    const double gap = gap_of(foot, facet, own).gap;
    if (gap >= least) continue;
    least = gap;
    nearest = foot;
  }
  return nearest;
}

HardFoot foot_of(const HardCorners& facet, const Ellipsoid& own) {
  const Vector<3> below = own.support(-facet.normal());
  const HardFoot foot = foot_of(facet, below);
  return foot.is_face() || facet.count == 2 ? foot : nearest_on_edges(facet, below, own);
}

EllipsoidPlace placed(const Ellipsoid& own, const EllipsoidGap& half) {
  return {.extent = own.extent(half.out),
          .direction = -half.out,
          .normal = -half.out,
          .x = own.support(half.out)};
}

}  // namespace

bool place_on_facet(const OnPath<Ellipsoid>& own, const OnPath<HardCorners>& facet,
                    EllipsoidPlace& place) {
  const HardFoot foot = foot_of(facet.half, own.half);
  place = placed(own.half, gap_of(foot, facet.half, own.half));
  place.foot = foot;
  place.g0 = gap_of(foot, facet.start, own.start).gap;
  place.g1 = gap_of(foot, facet.end, own.end).gap;
  return foot.is_face() || facet.half.normal().dot(place.direction) > 0;
}

EllipsoidPlace place_between(const OnPath<Ellipsoid>& own, const OnPath<Ellipsoid>& other) {
  EllipsoidPlace place = placed(own.half, own.half.to(other.half));
  place.extent = std::min(place.extent, other.half.extent(place.direction));
  place.foot.support = 0;
  place.g0 = own.start.to(other.start).gap;
  place.g1 = own.end.to(other.end).gap;
  return place;
}

void follow_gap(EllipsoidPlace& place, const Vector<3>& path, const Vector<3>& turn,
                double radius) {
  const double missing = place.g1 - place.g0 - place.direction.dot(path);
  const Vector<3> along = radius * place.direction.cross(turn);
  const double squares = path.squaredNorm() + along.squaredNorm();
  if (std::abs(missing) <= rounding * (place.x.norm() + radius)) return;
  if (squares < least_path * least_path * radius * radius) return;
  place.normal += missing / squares * path;
  place.x += radius * missing / squares * along;
}

}  // namespace gabion::mpm
