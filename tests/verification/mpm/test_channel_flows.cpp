// SPDX-License-Identifier: BSD-3-Clause
// A fluid and a mud that shear between two plates, on three grids.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <memory>
#include <numbers>
#include <string>
#include <vector>

#include "tests/support/verification_row.hpp"
#include "tests/verification/mpm/channel_flow.hpp"

namespace gabion::test {
namespace {

constexpr double density = 1500, viscosity = 50, yield_stress = 50;  // [kg/m^3], [Pa s], [Pa]

Json newtonian() {
  return {{"law", "newtonian"},
          {"density", density},
          {"sound_speed", 20},
          {"viscosity", viscosity},
          {"cavitation_pressure", 1e6}};
}

/// @param G  shear modulus [Pa]
Json bingham(double G) {
  Json mud = elastic_soil("herschel_bulkley", 2 * G * 1.45, 0.45, density);
  mud["yield_stress"] = yield_stress;
  mud["consistency"] = viscosity;
  return mud;
}

/// Rows of the errors of a flow on three grids, each twice as fine as the one before.
struct Convergence {
  std::string id, what;
  int cells = 0;  ///< of the coarsest grid over the gap
  std::array<double, 3> error;
  double bound = 0;    ///< of the error on the finest grid
  double order = 1.9;  ///< at least, of both refinements together
};

void verify_convergence(const Convergence& of) {
  verify({.id = of.id,
          .what = fmt::format("{}, {} cells: error", of.what, 4 * of.cells),
          .exact = 0,
          .computed = of.error[2],
          .measure = Measure::absolute_error,
          .bound = of.bound});
  verify({.id = of.id,
          .what = fmt::format("{}, {} to {} cells: order in h", of.what, of.cells, 4 * of.cells),
          .exact = 2,
          .computed = 0.5 * std::log2(of.error[0] / of.error[2]),
          .measure = Measure::order,
          .bound = of.order});
}

/// Plane Couette flow from rest: at T = nu t / H^2
///
///     u / U = y / H + sum_n 2 (-1)^n / (n pi) exp(-n^2 pi^2 T) sin(n pi y / H)
Profile couette(double U, double H, double T) {
  return [=](double y) {
    double u = y / H;
    for (int n = 1; n < 40; ++n) {
      const double k = n * std::numbers::pi;
      u += (n % 2 == 0 ? 2 : -2) / k * std::exp(-k * k * T) * std::sin(k * y / H);
    }
    return U * u;
  };
}

constexpr double gap = 0.1;                                    // [m]
constexpr double unit_time = gap * gap * density / viscosity;  // [s]: T = 1

/// The plate has moved for T = 0.05 at the start, and moves by half of the gap until T = 0.15.
TEST(N1_Couette, starts_up) {
  const double U = 1.7, T = 0.05, more = 0.1 * unit_time;
  Channel channel{.fluid = newtonian(), .start = couette(U, gap, T), .speed = U};
  std::array<double, 3> error;
  int cells = 6;
  for (double& one : error) {
    Flow flow(channel, cells, 5e-4);
    flow.run(more);
    one = flow.error(couette(U, gap, T + flow.time() / unit_time)) / U;
    cells *= 2;
  }
  verify_convergence({.id = "N1",
                      .what = "Couette flow from rest, T = 0.15, velocities over that of the plate",
                      .cells = 6,
                      .error = error,
                      .bound = 3e-4});
  channel.scheme = "bossak";
  std::array<std::unique_ptr<Flow>, 3> flows;
  double dt = more / 10;
  for (auto& flow : flows) {
    flow = std::make_unique<Flow>(channel, 6, dt);
    flow->run(more);
    dt /= 2;
  }
  verify({.id = "N1",
          .what = "the same by implicit steps, 6 cells, 10, 20 and 40 steps: order in dt",
          .exact = 1,
          .computed = std::log2(flows[0]->difference(*flows[1]) / flows[1]->difference(*flows[2])),
          .measure = Measure::order,
          .bound = 0.9});
}

TEST(N1_Couette, becomes_steady) {
  const double U = 0.3;
  Flow flow({.fluid = newtonian(), .start = couette(U, gap, 0.05), .speed = U}, 6, 1e-3);
  flow.run(1.2 * unit_time);
  verify({.id = "N1",
          .what = "Couette flow from rest, T = 1.25, 6 cells: error over the speed of the plate",
          .exact = 0,
          .computed = flow.error([U](double y) { return U * y / gap; }) / U,
          .measure = Measure::absolute_error,
          .bound = 1e-3});
  verify({.id = "N1",
          .what = "the same: shear stress",
          .exact = viscosity * U / gap,
          .computed = flow.stress(),
          .bound = 1e-3,
          .unit = "Pa"});
}

/// Couette flow that is steady has one shear stress, tau_y + mu U / H, in all of the gap.
TEST(N1_Couette, of_a_mud_has_the_stress_of_its_rate) {
  constexpr double U = 0.2;
  Flow flow({.fluid = bingham(2e4), .start = [](double y) { return U * y / gap; }, .speed = U}, 6,
            1e-3);
  flow.run(0.5 * unit_time);
  verify({.id = "N1",
          .what = "Couette flow, Bingham, 6 cells: shear stress",
          .exact = yield_stress + viscosity * U / gap,
          .computed = flow.stress(),
          .bound = 2e-4,
          .unit = "Pa"});
}

/// Flow that a body force f drives: |tau| = f |y - H / 2| is below the yield stress in a plug of
/// the width w = 2 tau_y / f,
///
///     u_plug = f (H - w)^2 / (8 mu) ,  mean = u_plug (2 + w / H) / 3
TEST(N4_BinghamPlug, keeps_its_profile_between_plates) {
  const double f = 2200, width = 2 * yield_stress / f;
  const double plug = f * std::pow(gap - width, 2) / (8 * viscosity);
  const auto profile = [=](double y) {
    const double beyond = std::max(0.0, std::abs(y - 0.5 * gap) - 0.5 * width);
    return plug - f / (2 * viscosity) * beyond * beyond;
  };
  const Channel channel{.fluid = bingham(2e4), .start = profile, .pull = f / density};
  std::array<double, 3> error;
  double mean = 0, share = 0;
  int cells = 6;
  for (double& one : error) {
    Flow flow(channel, cells, 1e-3);
    flow.run(0.5 * unit_time);
    one = flow.error(profile) / plug;
    mean = flow.speed();
    share = flow.plug();
    cells *= 2;
  }
  const std::string what = "Bingham flow between plates by a body force";
  verify_convergence({.id = "N4",
                      .what = what + ", velocities over that of the plug",
                      .cells = 6,
                      .error = error,
                      .bound = 0.008});
  verify({.id = "N4",
          .what = what + ", 24 cells: mean speed",
          .exact = plug * (2 + width / gap) / 3,
          .computed = mean,
          .bound = 0.008,
          .unit = "m/s"});
  verify({.id = "N4",
          .what = what + ", 24 cells: width of the plug, points that do not yield",
          .exact = width,
          .computed = share * gap,
          .measure = Measure::absolute_error,
          .bound = gap / 24,
          .unit = "m"});
}

/// Bingham flow between plates at rest that comes to a stop: rho du/dt = f + dtau/dy, tau elastic
/// with G up to the yield stress, by finite differences in half of the gap.
class Slowing {
 public:
  Slowing(const Profile& start, double half, double force, double G)
      : dy_(half / cells), dt_(0.5 * dy_ / std::sqrt(G / density)), force_(force), G_(G) {
    for (int i = 0; i <= cells; ++i) u_.push_back(start(i * dy_));
  }
  void run(double time) {
    while (time_ < time) step();
  }
  double speed(double y) const {
    const double place = std::min(y / dy_, cells - 1e-9);
    const auto i = static_cast<int>(place);
    return u_[i] + (place - i) * (u_[i + 1] - u_[i]);
  }
  /// Time at which the mean speed is first 0 [s].
  double stop() {
    double before = mean();
    for (;;) {
      step();
      const double now = mean();
      if (now <= 0) return time_ - dt_ * now / (now - before);
      before = now;
    }
  }

 private:
  static constexpr int cells = 400;

  double mean() const {
    double sum = 0.5 * u_[cells];
    for (int i = 0; i < cells; ++i) sum += u_[i];
    return sum / cells;
  }
  void step() {
    for (int i = 0; i < cells; ++i) {
      double& tau = tau_[i];
      tau += G_ * dt_ * (u_[i + 1] - u_[i]) / dy_;
      const double beyond = std::abs(tau) - yield_stress;
      if (beyond > 0) tau -= std::copysign(beyond * G_ * dt_ / (viscosity + G_ * dt_), tau);
    }
    for (int i = 1; i < cells; ++i) {
      u_[i] += dt_ / density * (force_ + (tau_[i] - tau_[i - 1]) / dy_);
    }
    u_[cells] += dt_ / density * (force_ - 2 * tau_[cells - 1] / dy_);  // the middle of the gap
    time_ += dt_;
  }

  double dy_, dt_, force_, G_, time_ = 0;
  std::vector<double> u_, tau_ = std::vector<double>(cells, 0.0);
};

/// Runs on to the time at which the mean speed is first 0. @returns it [s]
double stop(Flow& flow) {
  double before = flow.speed(), at = flow.time();
  for (;;) {
    flow.step();
    const double now = flow.speed(), dt = flow.time() - at;
    at = flow.time();
    if (now <= 0) return at - dt * now / (now - before);
    before = now;
    if (at > 1) throw Error("the mud does not stop");
  }
}

/// The profile of a slope of 10 degrees, twice as a channel, on one of 1 degree that the yield
/// stress holds.
TEST(N6_BinghamArrest, stops_in_time_and_rests) {
  constexpr double half = 0.1, g = 9.81, degree = std::numbers::pi / 180, G = 2e5;
  const double steep = density * g * std::sin(10 * degree), flat = density * g * std::sin(degree);
  const double sheared = half - yield_stress / steep;
  const auto profile = [=](double y) {
    const double from_plug = std::max(0.0, sheared - std::min(y, 2 * half - y));
    return steep / (2 * viscosity) * (sheared * sheared - from_plug * from_plug);
  };
  const Channel channel{
      .fluid = bingham(G), .start = profile, .gap = 2 * half, .pull = flat / density};
  const double plug = profile(half), exact_stop = Slowing(profile, half, flat, G).stop();
  std::array<double, 3> error, late;
  double creep = 0;
  int cells = 8;
  for (std::size_t k = 0; k < 3; ++k) {
    Flow flow(channel, cells, 1e-3);
    flow.run(0.1);
    Slowing exact(profile, half, flat, G);
    exact.run(flow.time());
    error[k] = flow.error([&](double y) { return exact.speed(std::min(y, 2 * half - y)); }) / plug;
    late[k] = std::abs(stop(flow) / exact_stop - 1);
    cells *= 2;
    if (k > 0) continue;
    flow.run(0.3);
    const double before = flow.displacement();
    flow.run(0.8);
    creep = (flow.displacement() - before) / 0.5;
  }
  const std::string what = "Bingham flow between plates that comes to a stop";
  verify_convergence({.id = "N6",
                      .what = what + ", 0.1 s, velocities over that of the plug at the start",
                      .cells = 8,
                      .error = error,
                      .bound = 8e-4,
                      .order = 1.7});
  verify_convergence({.id = "N6",
                      .what = what + ", time at which it stops",
                      .cells = 8,
                      .error = late,
                      .bound = 0.003});
  verify({.id = "N6",
          .what = what + ", 8 cells, 0.3 to 0.8 s: mean speed over that of the plug at the start",
          .exact = 0,
          .computed = creep / plug,
          .measure = Measure::absolute_error,
          .bound = 1e-4});
}

}  // namespace
}  // namespace gabion::test
