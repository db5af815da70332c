// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cmath>
#include <functional>
#include <string>
#include <utility>
#include <vector>

#include "tests/unit/mpm/mpm_scene.hpp"

namespace gabion::test {

/// Speed along the channel by the distance y from the lower plate [m/s].
using Profile = std::function<double(double y)>;

/// A layer between a plate at rest and one that moves. Its ends are free and so far off that the
/// middle does not feel them: what they change of it is as the inverse of the length.
struct Channel {
  Json fluid;
  Profile start;
  double gap = 0.1;    ///< distance of the plates [m]
  double speed = 0;    ///< of the upper plate [m/s]
  double pull = 0;     ///< acceleration along the channel [m/s^2]
  double length = 24;  ///< over the gap
  std::string scheme = "explicit";
};

/// A run of a channel, and what it does in the middle of its length. Velocities are means over the
/// last step, those of the grid by which the points moved: FLIP leaves the points beside a wall to
/// which soil sticks an error of their own, of the order of the cell.
class Flow {
 public:
  /// @param cells  over the gap; along the channel they are half as long as the gap
  /// @param dt  step [s]
  Flow(const Channel& channel, int cells, double dt)
      : channel_(channel), dt_(dt), solver_(comm(), settings(cells), "") {
    std::vector<Vector<2>> v;
    for (const Vector<2>& x : solver_.points().x) v.emplace_back(channel_.start(x[1]), 0);
    const std::vector<Vector<2>> at_rest(v.size(), Vector<2>::Zero());
    solver_.set_motion(std::move(v), at_rest);
  }
  void step() {
    const auto& points = solver_.points();
    std::vector<Vector<2>>& v = velocities_;
    v = points.u;
    plastic_strain_.clear();
    for (const auto& history : points.history) plastic_strain_.push_back(history.plastic_strain);
    run_steps(solver_, dt_, 1, ++steps_);
    for (std::size_t p = 0; p < v.size(); ++p) v[p] = (points.u[p] - v[p]) / dt_;
  }
  /// Steps up to a time [s].
  void run(double time) {
    while (steps_ * dt_ < time - 0.5 * dt_) step();
  }
  /// Middle of the last step, at which its velocities hold [s].
  double time() const { return (steps_ - 0.5) * dt_; }

  /// Root mean square of the difference of the velocities to a profile [m/s].
  double error(const Profile& exact) const {
    return std::sqrt(mean([&](std::size_t p) {
      return (velocities_[p] - exact(solver_.points().x[p][1]) * Vector<2>::Unit(0)).squaredNorm();
    }));
  }
  /// The same to the velocities of the same points in another run [m/s].
  double difference(const Flow& other) const {
    return std::sqrt(
        mean([&](std::size_t p) { return (velocities_[p] - other.velocities_[p]).squaredNorm(); }));
  }
  /// Mean speed [m/s].
  double speed() const {
    return mean([&](std::size_t p) { return velocities_[p][0]; });
  }
  /// Mean displacement along the channel [m].
  double displacement() const {
    return mean([&](std::size_t p) { return solver_.points().u[p][0]; });
  }
  /// Mean shear stress [Pa].
  double stress() const {
    return mean([&](std::size_t p) { return in_plane<2>(solver_.points().tau[p])(0, 1); });
  }
  /// Share of the volume that did not yield in the last step.
  double plug() const {
    return mean([&](std::size_t p) {
      return solver_.points().history[p].plastic_strain == plastic_strain_[p] ? 1 : 0;
    });
  }

 private:
  mpm::MpmSettings<2> settings(int cells) const {
    const double gap = channel_.gap, half = 0.5 * channel_.length * gap, room = 2 * gap;
    const auto columns = [gap](double size) {
      return static_cast<int>(std::lround(2 * size / gap));
    };
    Json top = wall("top", "fixed");
    top["motion"] = {{"velocity", {channel_.speed, 0}}};
    Json json = {{"dimension", 2},
                 {"grid", box({-half - room, 0}, {half + room, gap},
                              {columns(2 * (half + room)), cells}, "quad4")},
                 {"walls", {wall("bottom", "fixed"), top}},
                 {"bodies",
                  {body("fluid", box({-half, 0}, {half, gap}, {columns(2 * half), cells}, "quad4"),
                        4, channel_.fluid)}},
                 {"time_integration", {{"scheme", channel_.scheme}}}};
    if (channel_.scheme == "explicit") json["step_control"] = {{"strain", nullptr}};
    auto settings = mpm_settings<2>(json);
    settings.body_acceleration = [pull = channel_.pull](const Vector<2>&, double) -> Vector<2> {
      return pull * Vector<2>::Unit(0);
    };
    return settings;
  }
  /// Mean over the volume of the points within a gap of the middle.
  template <class Value>
  double mean(const Value& value) const {
    const auto& points = solver_.points();
    double sum = 0, volume = 0;
    for (std::size_t p = 0; p < points.x.size(); ++p) {
      if (std::abs(points.x[p][0]) > channel_.gap) continue;
      const double V = points.V0[p] * points.J[p];
      sum += V * value(p);
      volume += V;
    }
    return sum / volume;
  }

  Channel channel_;
  double dt_;
  mpm::MpmSolver<2> solver_;
  std::vector<Vector<2>> velocities_;   // of the points [m/s]
  std::vector<double> plastic_strain_;  // of the points before the last step
  int steps_ = 0;
};

}  // namespace gabion::test
