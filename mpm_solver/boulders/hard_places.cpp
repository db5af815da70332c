// SPDX-License-Identifier: BSD-3-Clause
#include "mpm_solver/boulders/hard_places.hpp"

#include <Eigen/Geometry>
#include <algorithm>

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

Vector<3> place(const HardFoot& foot, const HardCorners& corners) {
  Vector<3> x = Vector<3>::Zero();
  for (int k = 0; k < corners.count; ++k) x += foot.weights[k] * corners.x[k];
  return x;
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
  // What is above the border of a face is above the face.
  const auto in_use = std::ranges::count_if(foot.weights, [](double w) { return w > 0; });
  foot.support = inside ? corners.count : static_cast<int>(in_use);
  foot.on_border = in_use < corners.count;
  return foot;
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
  Vector<3> d0 = y[0] - place(foot, start), d1 = y[1] - place(foot, end);
  if (foot.is_face()) {
    gap = {.g0 = n0.dot(d0), .g1 = n1.dot(d1), .normal = (n0 + n1).normalized()};
    return true;
  }
  if ((n0 + n1).dot(d0 + d1) <= 0) return false;
  if (foot.support == 2) {
    int i = 0, j = 2;
    if (foot.weights[2] == 0) j = 1;
    if (foot.weights[0] == 0) i = 1;
    const Vector<3> e0 = (start.x[j] - start.x[i]).normalized();
    const Vector<3> e1 = (end.x[j] - end.x[i]).normalized();
    d0 -= e0.dot(d0) * e0;
    d1 -= e1.dot(d1) * e1;
  }
  gap = gap_of_points(d0, d1);
  return true;
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
