// SPDX-License-Identifier: BSD-3-Clause
#include "fem_solver/materials/brake.hpp"

#include <algorithm>
#include <utility>

namespace gabion::fem {

Brake::Brake(std::vector<double> runs, std::vector<double> forces, double run_limit)
    : runs_(std::move(runs)), forces_(std::move(forces)), run_limit_(run_limit) {}

std::size_t Brake::row_of(double run) const {
  const auto above = std::upper_bound(runs_.begin() + 1, runs_.end(), run);
  return static_cast<std::size_t>(above - runs_.begin()) - 1;
}

double Brake::slope_of(std::size_t row) const {
  if (row + 1 == runs_.size()) return 0;
  return (forces_[row + 1] - forces_[row]) / (runs_[row + 1] - runs_[row]);
}

double Brake::force(double run) const {
  const std::size_t row = row_of(run);
  return forces_[row] + slope_of(row) * (run - runs_[row]);
}

double Brake::work(double run) const {
  double sum = 0;
  const std::size_t last = row_of(run);
  for (std::size_t row = 0; row < last; ++row) {
    sum += 0.5 * (forces_[row] + forces_[row + 1]) * (runs_[row + 1] - runs_[row]);
  }
  return sum + 0.5 * (forces_[last] + force(run)) * (run - runs_[last]);
}

Brake::Balance Brake::balance(double stretch, double run, double stiffness) const {
  for (std::size_t row = row_of(run);; ++row) {
    const double excess = stiffness * (stretch - run) - force(run);
    if (run >= run_limit_ || excess <= 0) return {run, stiffness};
    const double slope = slope_of(row);
    const double end = row + 1 < runs_.size() ? std::min(runs_[row + 1], run_limit_) : run_limit_;
    const double next = run + excess / (stiffness + slope);
    if (next < end) return {next, stiffness * slope / (stiffness + slope)};
    run = end;
  }
}

double Brake::steepest_fall() const {
  double steepest = 0;
  for (std::size_t row = 0; row < runs_.size(); ++row) {
    steepest = std::max(steepest, -slope_of(row));
  }
  return steepest;
}

}  // namespace gabion::fem
