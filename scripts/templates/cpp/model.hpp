// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

/// The structure: a rigid plate on a spring and a damper in each direction, m a + c v + k u = F.
namespace model {

inline constexpr int dimension = __DIMENSION__;
inline constexpr int vertices_per_facet = dimension == 2 ? 2 : 4;
inline constexpr double mass = 0.6;       ///< [kg]; in 2D per metre of width, as all that follows
inline constexpr double damping = 10;     ///< [N s/m]
inline constexpr double stiffness = 5e3;  ///< [N/m]

/// Surface that the soil can reach, at the start. Up the right side, over the top, down the left
/// side: the soil is on the right of that line. In 3D this line is drawn along z.
struct Surface {
  std::vector<double> points;        ///< [m], num_points x dimension
  std::vector<std::int64_t> facets;  ///< points of each, num_facets x vertices_per_facet
};
Surface surface();

/// All that later steps depend on.
struct State {
  std::array<double, dimension> u = {};  ///< displacement of the plate [m]
  std::array<double, dimension> v = {};  ///< its velocity [m/s]
};

/// The state after dt [s], by implicit Euler.
/// @param force  of the soil on each point [N], num_points x dimension
/// A step without solution throws gabion::ConvergenceError; a smaller dt follows.
State step(const State& state, double dt, std::span<const double> force);

/// [m] of each point, total: from where it was at the start.
std::vector<double> displacement(const State& state, std::size_t num_points);

}  // namespace model
