// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <gtest/gtest.h>

#include <cmath>

#include "tests/support/verification_row.hpp"
#include "tests/unit/mpm/mpm_scene.hpp"

namespace gabion::test {

/// Layer of dry soil with psi = 0 on a rough bed that is steeper than the soil can bear, axes along
/// and across the layer. In simple shear at constant volume the stresses along the layer are
/// tau = sin phi sigma_n (Davis, 1968), at every depth by the same share of the weight above:
///
///     a = g (sin theta - sin phi cos theta)
///
/// The ends lie so far off that no wave reaches the middle in time.
struct Layer {
  std::string type = "quad4";
  std::string basis = "linear";
  double k0 = 1;                             ///< 1: the stress does not turn until Davis' state
  double H = 1, length = 40;                 // [m]
  double slope = 35 * M_PI / 180, phi = 25;  // [rad], [deg]
  double E = 1e7, nu = 0.3, density = 2000, g = 9.81;  // pressure waves need 0.24 s to the middle
  int rows = 4;

  double acceleration() const {
    return g * (std::sin(slope) - std::sin(phi * M_PI / 180) * std::cos(slope));
  }
};

inline constexpr double ramp = 0.1;  // of the pull along the layer [s]
inline constexpr double from = 0.14,
                        until = 0.24;  // time in which the acceleration is measured [s]

template <int dim>
mpm::MpmSettings<dim> layer_settings(const Layer& layer) {
  const double h = layer.H / layer.rows;
  std::vector<double> low(dim, 0.0), high(dim, h), gravity(dim, 0.0);
  std::vector<int> count(dim, 1);
  high[0] = layer.length;
  high[dim - 1] = layer.H;
  count[0] = static_cast<int>(std::lround(layer.length / h));
  count[dim - 1] = layer.rows;
  gravity[dim - 1] = -layer.g * std::cos(layer.slope);
  Json material = elastic_soil("mohr_coulomb", layer.E, layer.nu, layer.density);
  material["friction_angle"] = layer.phi;
  const int points = dim == 3 ? 8 : layer.type == "tri3" ? 3 : 4;
  Json soil = body("soil", box(low, high, count, layer.type), points, material);
  soil["initial_stress"] = {{"k0", layer.k0}, {"surface", layer.H}, {"max_displacement", 0.01}};
  Json walls = {wall("bottom", "fixed"), wall("left", "slip"), wall("right", "slip")};
  if (dim == 3) {
    walls.push_back(wall("front", "slip"));
    walls.push_back(wall("back", "slip"));
  }
  high[dim - 1] += h;
  count[dim - 1] += 1;
  auto settings = mpm_settings<dim>({{"dimension", dim},
                                     {"basis", layer.basis},
                                     {"grid", box(low, high, count, layer.type)},
                                     {"gravity", gravity},
                                     {"walls", walls},
                                     {"bodies", {soil}}});
  const double pull = layer.g * std::sin(layer.slope);
  settings.body_acceleration = [pull](const Vector<dim>&, double time) -> Vector<dim> {
    return pull * std::min(1.0, time / ramp) * Vector<dim>::Unit(0);
  };
  return settings;
}

/// Mean velocity along the layer, middle tenth, above the row of cells that shears.
template <int dim>
double speed(const mpm::MaterialPoints<dim>& points, const Layer& layer) {
  double momentum = 0, mass = 0;
  for (std::int32_t p = 0; p < points.size(); ++p) {
    const Vector<dim> X = points.x[p] - points.u[p];
    if (std::abs(X[0] / layer.length - 0.5) > 0.05 || X[dim - 1] < 0.5 * layer.H) continue;
    momentum += points.m[p] * points.v[p][0];
    mass += points.m[p];
  }
  return momentum / mass;
}

template <int dim>
void slide(const Layer& layer, const std::string& what) {
  mpm::MpmSolver<dim> solver(comm(), layer_settings<dim>(layer), "");
  constexpr double dt = 4e-3;
  const int first = static_cast<int>(std::lround(from / dt)),
            last = static_cast<int>(std::lround(until / dt));
  run_steps(solver, dt, first);
  const double before = speed(solver.points(), layer);
  run_steps(solver, dt, last - first, first + 1);
  verify({.id = "V15",
          .what = "acceleration of a layer that slides down a slope, psi 0, " + what,
          .exact = layer.acceleration(),
          .computed = (speed(solver.points(), layer) - before) / ((last - first) * dt),
          .bound = 0.01,
          .unit = "m/s^2"});
}

}  // namespace gabion::test
