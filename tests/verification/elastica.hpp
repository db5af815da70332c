// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cmath>
#include <numbers>

namespace gabion::test {

/// Tip of an inextensible cantilever of length 1 under a dead end load alpha = P L^2 / (E I)
/// across its straight axis.
struct Elastica {
  double deflection = 0;  ///< along the load, by L
  double shortening = 0;  ///< along the axis, by L

  /// theta'' = -alpha cos(theta), theta(0) = 0, theta'(1) = 0, solved from the tip, where the slope
  /// theta_1 < 90 degrees is unknown: bisection for theta(0) = 0, Runge-Kutta of fourth order.
  /// @see Bisshopp, Drucker (1945)
  explicit Elastica(double alpha) {
    double low = 0, high = 0.5 * std::numbers::pi;
    for (int k = 0; k < 60; ++k) {
      const double middle = 0.5 * (low + high);
      (integrate(alpha, middle) > 0 ? high : low) = middle;
    }
    integrate(alpha, 0.5 * (low + high));
  }

 private:
  // Integrates from the tip (s = 0) to the support and returns theta there; sets the tip.
  double integrate(double alpha, double tip_slope) {
    constexpr int steps = 2000;
    constexpr double ds = 1.0 / steps;
    double theta = tip_slope, slope = 0;  // slope = d theta / ds, s from the tip
    deflection = 0;
    double along = 0;
    for (int n = 0; n < steps; ++n) {
      const auto bending = [&](double angle) { return -alpha * std::cos(angle); };
      const double k1 = slope, l1 = bending(theta);
      const double k2 = slope + 0.5 * ds * l1, l2 = bending(theta + 0.5 * ds * k1);
      const double k3 = slope + 0.5 * ds * l2, l3 = bending(theta + 0.5 * ds * k2);
      const double k4 = slope + ds * l3, l4 = bending(theta + ds * k3);
      const double theta_new = theta + ds / 6 * (k1 + 2 * k2 + 2 * k3 + k4);
      const double middle = theta + ds / 2 * (k1 + ds / 4 * l1);
      deflection += ds / 6 * (std::sin(theta) + 4 * std::sin(middle) + std::sin(theta_new));
      along += ds / 6 * (std::cos(theta) + 4 * std::cos(middle) + std::cos(theta_new));
      theta = theta_new;
      slope += ds / 6 * (l1 + 2 * l2 + 2 * l3 + l4);
    }
    shortening = 1 - along;
    return theta;
  }
};

}  // namespace gabion::test
