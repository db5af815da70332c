// SPDX-License-Identifier: BSD-3-Clause
#include "mpm_solver/boulders/hard_places.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <numbers>

namespace gabion::mpm {

namespace {

void take_edge(const HardCorners& c, int i, const Vector<3>& y, double& best, HardFoot& foot) {
  const int j = (i + 1) % c.count;
  const Vector<3> edge = c.x[j] - c.x[i];
  const double t = std::clamp((y - c.x[i]).dot(edge) / edge.squaredNorm(), 0.0, 1.0);
  const double distance = (y - c.x[i] - t * edge).squaredNorm();
  if (best >= 0 && distance >= best) return;
  best = distance;
  foot.weights = {};
  foot.weights[i] = 1 - t;
  foot.weights[j] = t;
}

// Feet that are nearer to each other than this share of the size of a facet are one place.
constexpr double same_place = 1e-9;
// Slope between two facets that are one plane.
constexpr double flat = 1e-6;
// Gaps are differences of coordinates, with this share of them as rounding.
constexpr double rounding = 1e-13;

// The share of a facet in the normal at a foot: its angle at a corner, its half of an edge.
double share_of(const HardFoot& foot, const HardCorners& c) {
  if (c.count == 2) return 1;
  const auto corner =
      static_cast<int>(std::ranges::max_element(foot.weights) - foot.weights.begin());
  if (foot.weights[corner] < 1 - same_place) return std::numbers::pi;
  const Vector<3> a = c.x[(corner + 1) % 3] - c.x[corner], b = c.x[(corner + 2) % 3] - c.x[corner];
  return std::atan2(a.cross(b).norm(), a.dot(b));
}

// The part of a vector across the edge, if the foot is on one.
Vector<3> across(const HardFoot& foot, const HardCorners& c, const Vector<3>& d) {
  if (foot.count == 2 || foot.support != 2) return d;
  int i = 0, j = 2;
  if (foot.weights[2] == 0) j = 1;
  if (foot.weights[0] == 0) i = 1;
  const Vector<3> edge = (c.x[j] - c.x[i]).normalized();
  return d - edge.dot(d) * edge;
}

}  // namespace

Vector<3> HardCorners::normal() const {
  const Vector<3> edge = x[1] - x[0];
  if (count == 2) return Vector<3>(edge[1], -edge[0], 0).normalized();
  return edge.cross(x[2] - x[0]).normalized();
}

HardCorners middle(const HardCorners& a, const HardCorners& b) {
  HardCorners result{.count = a.count};
  for (int k = 0; k < a.count; ++k) result.x[k] = 0.5 * (a.x[k] + b.x[k]);
  return result;
}

HardFoot foot_of(const HardCorners& corners, const Vector<3>& y) {
  HardFoot foot{.count = corners.count};
  const auto& c = corners.x;
  bool inside = false;
  if (corners.count == 3) {
    const Vector<3> n = (c[1] - c[0]).cross(c[2] - c[0]);
    for (int k = 0; k < 3; ++k) {
      const Vector<3>&p = c[(k + 1) % 3], &q = c[(k + 2) % 3];
      foot.weights[k] = n.dot((p - y).cross(q - y)) / n.squaredNorm();
    }
    inside = std::ranges::all_of(foot.weights, [](double w) { return w >= 0; });
  } else {
    const Vector<3> edge = c[1] - c[0];
    const double t = (y - c[0]).dot(edge) / edge.squaredNorm();
    inside = t >= 0 && t <= 1;
    foot.weights = {1 - t, t, 0};
  }
  if (!inside) {
    double best = -1;
    for (int k = 0; k < (corners.count == 2 ? 1 : 3); ++k) {
      take_edge(corners, k, y, best, foot);
    }
  }
  // A point above the border of a face is above the face.
  const auto in_use = std::ranges::count_if(foot.weights, [](double w) { return w > 0; });
  foot.support = inside ? corners.count : static_cast<int>(in_use);
  foot.on_border = in_use < corners.count;
  return foot;
}

Vector<3> place_of(const HardFoot& foot, const HardCorners& corners) {
  Vector<3> x = Vector<3>::Zero();
  for (int k = 0; k < corners.count; ++k) x += foot.weights[k] * corners.x[k];
  return x;
}

double distance_at_least(const HardCorners& corners, const Vector<3>& y) {
  Vector<3> centre = Vector<3>::Zero();
  for (int k = 0; k < corners.count; ++k) centre += corners.x[k] / corners.count;
  double radius = 0;
  for (int k = 0; k < corners.count; ++k) {
    radius = std::max(radius, (corners.x[k] - centre).norm());
  }
  return (y - centre).norm() - radius;
}

HardGap gap_of_points(const Vector<3>& d0, const Vector<3>& d1) {
  const double g0 = d0.norm(), g1 = d1.norm();
  return {.g0 = g0, .g1 = g1, .normal = (d0 + d1) / (g0 + g1)};
}

bool gap_of_facet(const HardFoot& foot, const HardCorners& start, const HardCorners& end,
                  const std::array<Vector<3>, 2>& y, HardGap& gap) {
  const Vector<3> n0 = start.normal(), n1 = end.normal();
  Vector<3> d0 = y[0] - place_of(foot, start), d1 = y[1] - place_of(foot, end);
  if (foot.is_face()) {
    gap = {.g0 = n0.dot(d0), .g1 = n1.dot(d1), .normal = 0.5 * (n0 + n1)};
    return true;
  }
  if ((n0 + n1).dot(d0 + d1) <= 0) return false;
  d0 = across(foot, start, d0);
  d1 = across(foot, end, d1);
  gap = gap_of_points(d0, d1);
  return true;
}

HardNearest nearest_of(std::span<const HardCorners> facets, const Vector<3>& y) {
  HardNearest nearest;
  double best = std::numeric_limits<double>::infinity();
  std::vector<Vector<3>> places;
  std::vector<HardFoot> feet;
  for (const HardCorners& c : facets) {
    feet.push_back(foot_of(c, y));
    places.push_back(place_of(feet.back(), c));
    const double distance = (y - places.back()).squaredNorm();
    if (distance >= best) continue;
    best = distance;
    nearest.facet = static_cast<std::int32_t>(feet.size()) - 1;
  }
  if (nearest.facet < 0) return nearest;
  const HardCorners& own = facets[nearest.facet];
  HardFoot& foot = nearest.foot = feet[nearest.facet];
  const Vector<3> d = y - places[nearest.facet];
  if (foot.is_face() && !foot.on_border) {
    nearest.out = own.normal();
    nearest.gap = nearest.out.dot(d);
    return nearest;
  }
  foot.support =
      static_cast<int>(std::ranges::count_if(foot.weights, [](double w) { return w > 0; }));
  const double same = same_place * (own.x[1] - own.x[0]).norm();
  Vector<3> normal = Vector<3>::Zero();
  int count = 0;
  for (std::size_t f = 0; f < facets.size(); ++f) {
    if ((places[f] - places[nearest.facet]).norm() > same) continue;
    normal += share_of(feet[f], facets[f]) * facets[f].normal();
    ++count;
  }
  const double side = normal.dot(d);
  if (side < 0 && count == 1) return {};
  nearest.gap = std::copysign(d.norm(), side);
  nearest.out = d.norm() > 0 ? Vector<3>(d / nearest.gap) : Vector<3>(normal.normalized());
  return nearest;
}

Vector<3> mean_normal(const HardNearest& nearest, const HardCorners& start, const HardCorners& end,
                      const std::array<Vector<3>, 2>& y) {
  const HardFoot& foot = nearest.foot;
  if (foot.is_face()) return 0.5 * (start.normal() + end.normal());
  const Vector<3> d0 = across(foot, start, y[0] - place_of(foot, start));
  const Vector<3> d1 = across(foot, end, y[1] - place_of(foot, end));
  const double both = d0.norm() + d1.norm();
  if (both == 0) return nearest.out;
  return (nearest.gap < 0 ? -1 : 1) / both * (d0 + d1);
}

Vector<3> along_motion(const Vector<3>& normal, const Vector<3>& path, double change,
                       double scale) {
  const double missing = change - normal.dot(path);
  if (std::abs(missing) <= rounding * scale) return normal;
  return normal + missing / path.squaredNorm() * path;
}

void LeastDistances::add(const std::array<std::int32_t, 3>& facet, int count, double distance) {
  for (int i = 0; i < count; ++i) {
    for (int j = i; j < count; ++j) {
      const auto [entry, is_new] = least_.try_emplace(
          {std::min(facet[i], facet[j]), std::max(facet[i], facet[j])}, distance);
      if (!is_new) entry->second = std::min(entry->second, distance);
    }
  }
}

bool LeastDistances::is_least(const std::array<std::int32_t, 3>& facet, const HardFoot& foot,
                              double distance) const {
  std::array<std::int32_t, 2> shared = {-1, -1};
  for (int k = 0; k < foot.count; ++k) {
    if (foot.weights[k] > 0) shared = {shared[0] < 0 ? facet[k] : shared[0], facet[k]};
  }
  if (shared[0] > shared[1]) std::swap(shared[0], shared[1]);
  return distance <= (1 + same_place) * least_.at(shared);
}

std::vector<char> sticking_out(std::span<const std::array<std::int32_t, 3>> facets, int count,
                               std::span<const Vector<3>> vertices, std::vector<char> asked) {
  struct Side {
    Vector<3> normal, opposite;
  };
  // The facets are listed by the vertices that two of them share, in 2D one.
  std::map<std::array<std::int32_t, 2>, std::vector<Side>> borders;
  for (const auto& facet : facets) {
    HardCorners corners{.count = count};
    bool near = false;
    for (int k = 0; k < count; ++k) {
      corners.x[k] = vertices[facet[k]];
      near = near || asked[facet[k]] != 0;
    }
    if (!near) continue;
    const Vector<3> normal = corners.normal();
    for (int k = 0; k < count; ++k) {
      const std::int32_t i = facet[(k + 1) % count], j = facet[(k + count - 1) % count];
      if (asked[i] == 0 && asked[j] == 0) continue;
      borders[{std::min(i, j), std::max(i, j)}].push_back({normal, corners.x[k]});
    }
  }
  std::vector<char> result(asked.size(), 0);
  const auto behind = [](const Side& own, const Vector<3>& from, const Vector<3>& x) {
    return own.normal.dot(x - from) < -flat * (x - from).norm();
  };
  for (const auto& [border, sides] : borders) {
    const Vector<3>& from = vertices[border[0]];
    if (sides.size() == 2 && !behind(sides[0], from, sides[1].opposite) &&
        !behind(sides[1], from, sides[0].opposite)) {
      continue;
    }
    for (const std::int32_t v : border) result[v] = asked[v];
  }
  return result;
}

void FootVertices::add(const std::array<std::int32_t, 3>& facet, const HardFoot& foot) {
  auto& vertices = known_.emplace_back();
  for (int k = 0; k < foot.count; ++k) {
    if (foot.is_face() || foot.weights[k] > 0) vertices.push_back(facet[k]);
  }
}

bool FootVertices::has(const std::array<std::int32_t, 3>& facet, const HardFoot& foot) const {
  return std::ranges::any_of(known_, [&](const std::vector<std::int32_t>& vertices) {
    for (int k = 0; k < foot.count; ++k) {
      if (foot.weights[k] > 0 && std::ranges::find(vertices, facet[k]) == vertices.end()) {
        return false;
      }
    }
    return true;
  });
}

}  // namespace gabion::mpm
