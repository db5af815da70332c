// SPDX-License-Identifier: BSD-3-Clause
#include "model.hpp"

namespace model {

namespace {

constexpr double left = 0.16, right = 0.17, top = 0.05;  // the plate from y = 0 up [m]
constexpr double width = 0.1;                            // in z, in 3D [m]
constexpr int segments = 10;                             // of its height; in 3D of its width too

}  // namespace

Surface surface() {
  constexpr int line = 2 * (segments + 1);  // points in the plane
  constexpr int layers = dimension == 2 ? 1 : segments + 1;
  Surface surface;
  for (int layer = 0; layer < layers; ++layer) {
    for (int k = 0; k < line; ++k) {
      const int height = k <= segments ? k : line - 1 - k;
      surface.points.push_back(k <= segments ? right : left);
      surface.points.push_back(top * height / segments);
      if (dimension == 3) surface.points.push_back(width * layer / segments);
    }
  }
  for (int layer = 0; layer < (dimension == 2 ? 1 : segments); ++layer) {
    for (int k = 0; k + 1 < line; ++k) {
      const std::int64_t first = layer * line + k;
      surface.facets.insert(surface.facets.end(), {first, first + 1});
      if (dimension == 3) {
        surface.facets.insert(surface.facets.end(), {first + 1 + line, first + line});
      }
    }
  }
  return surface;
}

State step(const State& state, double dt, std::span<const double> force) {
  std::array<double, dimension> sum = {};
  for (std::size_t i = 0; i < force.size(); ++i) sum[i % dimension] += force[i];
  State next;
  for (std::size_t i = 0; i < dimension; ++i) {
    next.v[i] = (sum[i] + mass / dt * state.v[i] - stiffness * state.u[i]) /
                (mass / dt + damping + stiffness * dt);
    next.u[i] = state.u[i] + dt * next.v[i];
  }
  return next;
}

std::vector<double> displacement(const State& state, std::size_t num_points) {
  std::vector<double> values(num_points * dimension);
  for (std::size_t i = 0; i < values.size(); ++i) values[i] = state.u[i % dimension];
  return values;
}

}  // namespace model
