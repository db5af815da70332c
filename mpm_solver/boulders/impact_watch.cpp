// SPDX-License-Identifier: BSD-3-Clause
#include "mpm_solver/boulders/impact_watch.hpp"

#include <algorithm>

#include "common/base/log.hpp"

namespace gabion::mpm {

namespace {

constexpr int steps_an_impact = 10;  // fewer do not resolve its force

}  // namespace

void ImpactWatch::look_at(std::size_t interface, const std::string& name,
                          std::span<const Vector<3>> forces, double dt) {
  if (has_warned_) return;
  steps_.resize(std::max(steps_.size(), interface + 1));
  int& steps = steps_[interface];
  if (std::ranges::any_of(forces, [](const Vector<3>& force) { return !force.isZero(0); })) {
    ++steps;
    return;
  }
  if (steps > 0 && steps < steps_an_impact) {
    log::warn(
        "boulders pressed on \"{}\" for {} steps of {:.3g} s: the structure gets the mean force of "
        "each step, so the peaks of forces and stresses depend on the step; {} steps an impact "
        "resolve them",
        name, steps, dt, steps_an_impact);
    has_warned_ = true;
  }
  steps = 0;
}

}  // namespace gabion::mpm
