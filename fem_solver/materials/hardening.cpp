// SPDX-License-Identifier: BSD-3-Clause
#include "fem_solver/materials/hardening.hpp"

#include <algorithm>
#include <utility>

namespace gabion::fem {

Hardening Hardening::linear(double yield_stress, double modulus) {
  Hardening hardening;
  hardening.stresses_ = {yield_stress};
  hardening.last_slope_ = modulus;
  return hardening;
}

Hardening Hardening::table(std::vector<double> strains, std::vector<double> stresses) {
  Hardening hardening;
  hardening.strains_ = std::move(strains);
  hardening.stresses_ = std::move(stresses);
  return hardening;
}

std::size_t Hardening::row_at(double p) const {
  const auto after = std::upper_bound(strains_.begin() + 1, strains_.end(), p);
  return static_cast<std::size_t>(after - strains_.begin()) - 1;
}

double Hardening::slope_of(std::size_t row) const {
  if (row + 1 == strains_.size()) return last_slope_;
  return (stresses_[row + 1] - stresses_[row]) / (strains_[row + 1] - strains_[row]);
}

double Hardening::yield_stress(double p) const {
  const std::size_t row = row_at(p);
  return stresses_[row] + slope_of(row) * (p - strains_[row]);
}

double Hardening::work(double p) const {
  const std::size_t last = row_at(p);
  double sum = 0;
  for (std::size_t row = 0; row < last; ++row) {
    sum += 0.5 * (stresses_[row] + stresses_[row + 1]) * (strains_[row + 1] - strains_[row]);
  }
  return sum + 0.5 * (stresses_[last] + yield_stress(p)) * (p - strains_[last]);
}

PlasticFlow Hardening::flow(double q, double p, double stiffness) const {
  std::size_t row = row_at(p);
  double excess = q - yield_stress(p), strain = 0;
  for (;; ++row) {
    const double slope = slope_of(row);
    const double step = excess / (stiffness + slope);
    const bool is_last = row + 1 == strains_.size();
    if (is_last || p + strain + step <= strains_[row + 1]) return {strain + step, slope};
    const double to_end = strains_[row + 1] - (p + strain);
    excess -= (stiffness + slope) * to_end;
    strain += to_end;
  }
}

}  // namespace gabion::fem
