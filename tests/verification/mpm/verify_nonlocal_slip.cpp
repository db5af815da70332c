// SPDX-License-Identifier: BSD-3-Clause
// Over-nonlocal softening of a layer that is sheared, on several grids and on grids turned by 20
// degrees against it. The layer is long: near its ends the stress is not even.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "tests/support/verification_row.hpp"
#include "tests/verification/mpm/turned_layer.hpp"

namespace gabion::test {
namespace {

constexpr double G = 3e6, peak = 40e3, loss = 20e3, loss_slip = 0.02;  // [Pa], [m]
constexpr double length = 0.1, height = 1, width = 8;                  // l, of the layer [m]

struct Layer {
  double h;      ///< of the cells [m]
  double angle;  ///< of the layer to the rows of the grid [rad]
  double m = 2;

  TurnedLayer shape() const { return {width, height, h, angle}; }
  Json plate(const std::string& name, double y, double speed) const {
    return shape().plate(name, {{-0.5 * width, y}, {0.5 * width, y}}, {speed, 0}, 1000 * G / h);
  }
};

Json scene_of(const Layer& layer, double speed) {
  Json clay = elastic_soil("tresca", 2 * G * 1.45, 0.45, 2000);
  clay["cohesion"] = peak;
  clay["softening"] = {{"table", {{loss_slip, peak - loss}, {1.5 * loss_slip, peak - 1.5 * loss}}}};
  Json soil = body("soil", layer.shape().mesh(), 4, clay);
  soil["softening_average"] = {{"length", length}, {"weight", layer.m}};
  return {{"dimension", 2},
          {"analysis", "quasi_static"},
          {"basis", "linear"},
          {"grid", layer.shape().grid()},
          {"bodies", {soil}},
          {"rigid_walls",
           {layer.plate("below", -0.5 * height, 0), layer.plate("above", 0.5 * height, speed)}},
          {"newton", {{"residual_tolerance", 1e-7}, {"increment_tolerance", 1e-5}}},
          {"linear_solver", {{"method", "lu"}}}};
}

/// State of the middle part of the layer.
struct Middle {
  double stress = 0;          ///< mean shear stress [Pa]
  double slip = 0;            ///< by the softening strain [m]
  std::vector<double> kappa;  ///< of its points
};

Middle middle_of(const mpm::MpmSolver<2>& solver, const Layer& layer) {
  constexpr double part = 0.5;  // its width [m]
  const auto& points = solver.points();
  const Vector<2> along = layer.shape().along(), across = layer.shape().across();
  Middle found;
  double volume = 0;
  for (std::int32_t p = 0; p < points.size(); ++p) {
    const Vector<2> X = points.x[p] - points.u[p];
    const bool is_in = std::abs(X.dot(along)) < 0.5 * part;
    found.kappa.push_back(is_in ? points.internal[p][0] : 0);
    if (!is_in) continue;
    const double V = points.V0[p] * points.J[p];
    volume += V;
    found.stress += V * along.dot(in_plane<2>(points.tau[p]) * across);
    found.slip += std::numbers::sqrt3 * V * points.internal[p][0] / part;
  }
  found.stress /= volume;
  return found;
}

struct Band {
  double slope;          ///< of the stress by the slip [Pa/m]
  double participation;  ///< (integral of kappa)^2 / integral of kappa^2, over l
};

/// A first step to 0.97 of the peak, then short ones: the mean of the strains lags behind by a
/// step.
Band shear(const Layer& layer) {
  const double speed = peak / G * height + 0.006;  // in one second
  const double elastic = 0.97 * peak / G * height / speed;
  const int steps = 80;
  auto settings = layer.shape().settings(scene_of(layer, speed));
  // The stress is largest in the middle, by 1 % of that at the plates.
  const double push = 0.01 * peak / (0.5 * height) / 2000;
  const Vector<2> along = layer.shape().along(), across = layer.shape().across();
  settings.body_acceleration = [&](const Vector<2>& X, double) {
    return Vector<2>((X.dot(across) > 0 ? push : -push) * along);
  };
  mpm::MpmSolver<2> solver(comm(), std::move(settings), "");
  Middle first, last;
  double time = 0;
  for (int n = 1; n <= steps + 1; ++n) {
    const double dt = n == 1 ? elastic : (1 - elastic) / steps;
    const StepRequest request{n, 0, time, dt};
    InterfaceValues sent;
    solver.solve_step(request, {}, sent);
    solver.accept_step(request, true);
    time += dt;
    last = middle_of(solver, layer);
    if (first.slip == 0 && last.slip > 0.1 * loss_slip) first = last;
  }
  double sum = 0, squares = 0;
  const auto& points = solver.points();
  for (std::int32_t p = 0; p < points.size(); ++p) {
    const double V = points.V0[p] * points.J[p], kappa = last.kappa[p] - first.kappa[p];
    sum += V * kappa / 0.5;
    squares += V * kappa * kappa / 0.5;
  }
  return {(last.stress - first.stress) / (last.slip - first.slip), sum * sum / squares / length};
}

/// kappa = K (1 + sqrt(m / (m - 1)) cos(y / (l sqrt(m - 1)))) in the band |y| < w / 2.
double exact_participation(double m) {
  const double q = std::sqrt(m - 1), s = std::numbers::pi - std::atan(1 / q);
  const double b = std::sqrt(m / (m - 1));
  const double sum = 2 * q * (s + b * std::sin(s));
  const double squares =
      2 * q * (s + 2 * b * std::sin(s) + 0.5 * b * b * (s + 0.5 * std::sin(2 * s)));
  return sum * sum / squares;
}

void check(const Layer& layer) {
  const Band band = shear(layer);
  const std::string lag = "the mean of the strains lags behind by a step, which widens the band";
  const std::string what = fmt::format(
      "sheared layer, l 0.1 m, m {}, cells of {:.3g} m, turned by {:.3g} deg: ", layer.m, layer.h,
      layer.angle * 180 / M_PI);
  verify({.id = "VA3",
          .what = what + "stress over slip",
          .exact = -loss / loss_slip,
          .computed = band.slope,
          .bound = 0.06,
          .unit = "Pa/m",
          .limitation = lag});
  verify({.id = "VA3",
          .what = what + "(integral of kappa)^2 / integral of kappa^2, over l",
          .exact = exact_participation(layer.m),
          .computed = band.participation,
          .bound = 0.08,
          .limitation = lag});
}

TEST(VA3_NonlocalLayer, has_slope_and_width_of_its_own) {
  for (const double h : {1.0 / 15, 0.05, 1.0 / 30}) check({h, 0});
}

TEST(VA3_NonlocalLayer, has_them_on_turned_grids) {
  for (const double h : {1.0 / 15, 0.05}) check({h, 20 * M_PI / 180});
}

TEST(VA3_NonlocalLayer, follows_the_weight) {
  check({0.05, 0, 1.5});
}

}  // namespace
}  // namespace gabion::test
