// SPDX-License-Identifier: BSD-3-Clause
#include "coupler/mapping/closest_point.hpp"

#include <Eigen/Dense>
#include <algorithm>

namespace gabion {

namespace {

using Vector3 = Eigen::Vector3d;

/// The nearest of the border segments.
template <std::size_t n>
ClosestPoint closest_on_border(const Vector3& p, const std::array<Vector3, n>& corners) {
  ClosestPoint best;
  for (std::size_t i = 0; i < n; ++i) {
    const std::size_t j = (i + 1) % n;
    const ClosestPoint edge = closest_on_segment(p, corners[i], corners[j]);
    if (i > 0 && edge.distance >= best.distance) continue;
    best = ClosestPoint{};
    best.weights[i] = edge.weights[0];
    best.weights[j] = edge.weights[1];
    best.distance = edge.distance;
  }
  return best;
}

}  // namespace

ClosestPoint closest_on_segment(const Vector3& p, const Vector3& a, const Vector3& b) {
  const Vector3 along = b - a;
  const double t = std::clamp((p - a).dot(along) / along.squaredNorm(), 0.0, 1.0);
  return {{1 - t, t}, (p - (a + t * along)).norm()};
}

ClosestPoint closest_on_triangle(const Vector3& p, const std::array<Vector3, 3>& corners) {
  Eigen::Matrix<double, 3, 2> edges;
  edges << corners[1] - corners[0], corners[2] - corners[0];
  const Eigen::Vector2d t =
      (edges.transpose() * edges).ldlt().solve(edges.transpose() * (p - corners[0]));
  if (t.minCoeff() < 0 || t.sum() > 1) return closest_on_border(p, corners);
  return {{1 - t.sum(), t(0), t(1)}, (p - corners[0] - edges * t).norm()};
}

ClosestPoint closest_on_quad(const Vector3& p, const std::array<Vector3, 4>& corners) {
  const ClosestPoint border = closest_on_border(p, corners);
  // x(s, t) = c0 + c1 s + c2 t + c3 s t on [-1, 1]^2
  const Vector3 c0 = (corners[0] + corners[1] + corners[2] + corners[3]) / 4;
  const Vector3 c1 = (-corners[0] + corners[1] + corners[2] - corners[3]) / 4;
  const Vector3 c2 = (-corners[0] - corners[1] + corners[2] + corners[3]) / 4;
  const Vector3 c3 = (corners[0] - corners[1] + corners[2] - corners[3]) / 4;
  Eigen::Vector2d st = Eigen::Vector2d::Zero();
  constexpr int max_iterations = 30;
  for (int k = 0; k < max_iterations; ++k) {
    const double s = st(0);
    const double t = st(1);
    const Vector3 gap = c0 + c1 * s + c2 * t + c3 * (s * t) - p;
    const Vector3 ds = c1 + c3 * t;
    const Vector3 dt = c2 + c3 * s;
    const Eigen::Vector2d gradient(gap.dot(ds), gap.dot(dt));
    Eigen::Matrix2d hessian;
    const double mixed = ds.dot(dt) + gap.dot(c3);
    hessian << ds.squaredNorm(), mixed, mixed, dt.squaredNorm();
    const Eigen::Vector2d step = hessian.fullPivLu().solve(-gradient);
    st += step;
    if (!st.allFinite() || st.cwiseAbs().maxCoeff() > 4) return border;  // left the facet for good
    if (step.cwiseAbs().maxCoeff() > 1e-14) continue;
    break;
  }
  if (st.cwiseAbs().maxCoeff() > 1) return border;
  const double s = st(0);
  const double t = st(1);
  const ClosestPoint inside{
      {(1 - s) * (1 - t) / 4, (1 + s) * (1 - t) / 4, (1 + s) * (1 + t) / 4, (1 - s) * (1 + t) / 4},
      (c0 + c1 * s + c2 * t + c3 * (s * t) - p).norm()};
  return inside.distance <= border.distance ? inside : border;
}

}  // namespace gabion
