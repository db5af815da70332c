// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <memory>
#include <string>

#include "tests/unit/mpm/mpm_scene.hpp"

namespace gabion::test {

/// V22: a cap of dry sand slides down a plane and spreads, in plane strain; x along the slope from
/// the middle of the cap, z across it. Similarity solution of the depth-averaged equations of
/// Savage and Hutter (1989, J. Fluid Mech. 199; in space Hutter, Siegel, Savage and Nohguchi, 1993,
/// Acta Mech. 100): the cap stays a parabola,
///
///     h = H / s (1 - ((x - x_c) / (L s))^2) ,   x_c = g (sin zeta - cos zeta tan delta) t^2 / 2 ,
///     s'' = 2 k g cos zeta H / (L^2 s^2) ,      s(0) = 1, s'(0) = 0 ,
///     sqrt(s (s - 1)) + ln(sqrt s + sqrt(s - 1)) = 2 sqrt(k g cos zeta H) / L t .
///
/// Theirs is k = K, the active earth pressure p_xx / p_zz where the bed is a plane of Coulomb's
/// friction delta and the soil yields,
///
///     K = 2 (1 - sqrt(1 - cos^2 phi (1 + tan^2 delta))) / cos^2 phi - 1 .
///
/// They take tan delta for small. Without that, balance across the slope has the shear
/// sigma_xz = tan delta p_zz too. Moments about the centre of mass, the terms with z'' left out and
/// the velocity alike over the depth:
///
///     sum m (x - x_c) x'' = int (p_xx - tan delta sigma_xz) dA = (K - tan^2 delta) int p_zz dA ,
///
/// since the friction tan delta p of the bed has the moment int p (x - x_c) dx = int sigma_xz dA.
/// Hence k = K - tan^2 delta, which is 0 for a rigid cap (phi = 90 degrees); K is not.
///
/// The sum x_c + tan delta z_c has, for any motion that slides all along the bed, exactly the
/// acceleration g (sin zeta - cos zeta tan delta).
struct ParabolicCap {
  double bed_angle = 25;                     ///< delta [deg]
  double L = 0.5, H = 0.05;                  ///< half length and height at the start [m]
  double zeta = 35 * M_PI / 180, phi = 35;   ///< [rad], [deg]
  double E = 1e6, nu = 0.3, density = 1500;  ///< [Pa], [kg/m^3]
  double g = 9.81;                           ///< [m/s^2]
  int rows = 4;                              ///< of cells over H
  std::string scheme = "bossak";
  double dt = 2e-3;  ///< [s]

  double mu() const { return std::tan(bed_angle * M_PI / 180); }
  double active_pressure() const {  ///< K
    const double c = std::pow(std::cos(phi * M_PI / 180), 2);
    return 2 * (1 - std::sqrt(1 - c * (1 + mu() * mu()))) / c - 1;
  }
  double driving() const { return active_pressure() - mu() * mu(); }  ///< k
  double acceleration() const { return g * (std::sin(zeta) - std::cos(zeta) * mu()); }

  double stretch(double k, double t) const {  ///< s
    const double path = 2 * std::sqrt(k * g * std::cos(zeta) * H) / L * t;
    double low = 1, high = 100;
    for (int n = 0; n < 60; ++n) {
      const double s = 0.5 * (low + high), root = std::sqrt(s - 1);
      (std::sqrt(s) * root + std::log(std::sqrt(s) + root) < path ? low : high) = s;
    }
    return low;
  }
  /// h [m] at x - x_c, of the parabola stretched by s.
  double depth(double s, double x) const {
    return std::max(0.0, H / s * (1 - std::pow(x / (L * s), 2)));
  }
};

/// Gravity comes within `ramp`, smoothly, so that the cap does not bounce; from then on it moves as
/// one released at ramp / 2 would, ahead of it by 0.025 ramp^2 times the acceleration.
inline constexpr double cap_ramp = 0.1, cap_end = 1;  // the end from ramp / 2 on [s]

/// Columns as wide as a cell, each with as many quadrilaterals as it is cells high.
inline Mesh<2> cap_mesh(const ParabolicCap& cap) {
  Mesh<2> mesh;
  mesh.cell_type = CellType::quad4;
  const int columns = static_cast<int>(std::lround(2 * cap.L * cap.rows / cap.H));
  const double width = 2 * cap.L / columns;
  for (int i = 0; i < columns; ++i) {
    const double x0 = -cap.L + i * width, x1 = x0 + width;
    // Ends of the line through the column's top that has the parabola's area.
    const double mean = cap.H * (1 - (x0 * x0 + x0 * x1 + x1 * x1) / (3 * cap.L * cap.L));
    const double rise = cap.depth(1, x1) - cap.depth(1, x0);
    const int rows = std::max(1, static_cast<int>(std::lround(mean * cap.rows / cap.H + 0.25)));
    const int first = mesh.num_nodes_total();
    for (int j = 0; j <= rows; ++j) {
      mesh.nodes.push_back({x0, (mean - 0.5 * rise) * j / rows});
      mesh.nodes.push_back({x1, (mean + 0.5 * rise) * j / rows});
    }
    for (int n = first; n < first + 2 * rows; n += 2) {
      mesh.cells.insert(mesh.cells.end(), {n, n + 1, n + 3, n + 2});
    }
  }
  return mesh;
}

inline std::unique_ptr<mpm::MpmSolver<2>> cap_solver(const ParabolicCap& cap) {
  const double h = cap.H / cap.rows, low = -cap.L - 4 * h;
  const double far = 0.55 * cap.acceleration() + 1.1 * cap.L * cap.stretch(1, cap_end);
  const int columns = static_cast<int>(std::ceil((far - low) / h));
  const double high = low + columns * h;
  Json sand = elastic_soil("mohr_coulomb", cap.E, cap.nu, cap.density);
  sand["friction_angle"] = cap.phi;
  auto settings = mpm_settings<2>(
      {{"dimension", 2},
       {"basis", "gimp"},
       {"grid", box({low, -2 * h}, {high, cap.H + 2 * h}, {columns, cap.rows + 4}, "quad4")},
       {"gravity", {cap.g * std::sin(cap.zeta), -cap.g * std::cos(cap.zeta)}},
       {"gravity_ramp", {{"duration", cap_ramp}, {"shape", "smooth"}}},
       {"time_integration", {{"scheme", cap.scheme}}},
       {"bodies", {body("cap", box({0, 0}, {h, h}, {1, 1}, "quad4"), 4, sand)}},
       {"rigid_walls",
        {{{"name", "bed"},
          {"surface", {{"polyline", {{high, 0}, {low, 0}}}, {"spacing", h}}},
          {"friction", cap.mu()}}}}});
  settings.layouts[0].mesh = cap_mesh(cap);
  return std::make_unique<mpm::MpmSolver<2>>(comm(), std::move(settings), "");
}

}  // namespace gabion::test
