// SPDX-License-Identifier: BSD-3-Clause
#include "fem_solver/materials/softening.hpp"

#include <cmath>

namespace gabion::fem {

double TensionCurve::widest_band() const {
  return 2 * modulus * fracture_energy / (strength * strength);
}

CurvePoint TensionCurve::at(double r, double width) const {
  if (r <= strength) return {.stress = r, .slope = 1, .work = 0.5 * r * r / modulus};
  const double H = width / (widest_band() - width);
  const double left = std::exp(2 * H * (1 - r / strength));
  const double to_strength = 0.5 * strength * strength / modulus;
  return {.stress = strength * left,
          .slope = -2 * H * left,
          .work = to_strength * (1 - std::expm1(2 * H * (1 - r / strength)) / H)};
}

double CrushingCurve::least_strain() const {
  return (2 * strength - elastic_limit) / modulus;
}

double CrushingCurve::widest_band() const {
  return modulus * crushing_energy / (strength * strength);
}

CurvePoint CrushingCurve::at(double r, double width) const {
  if (r <= elastic_limit) return {.stress = r, .slope = 1, .work = 0.5 * r * r / modulus};
  const double strain = r / modulus, first = elastic_limit / modulus;
  const double rise = strength - elastic_limit, run = strain_at_strength - first;
  const double to_limit = 0.5 * elastic_limit * first;
  if (strain <= strain_at_strength) {
    const double left = (strain_at_strength - strain) / run;
    return {
        .stress = strength - rise * left * left,
        .slope = 2 * rise * left / (run * modulus),
        .work = to_limit + strength * (strain - first) - rise * run * (1 - left * left * left) / 3};
  }
  const double decay = crushing_energy / (width * strength);  // strain that takes 1/e of the stress
  const double left = std::exp((strain_at_strength - strain) / decay);
  return {.stress = strength * left,
          .slope = -strength * left / (decay * modulus),
          .work = to_limit + (strength - rise / 3) * run + strength * decay * (1 - left)};
}

Damage damage_at(const CurvePoint& point, double r, double modulus) {
  Damage damage{.value = 1 - point.stress / r,
                .slope = (point.stress / r - point.slope) / r,
                .dissipated = point.work - 0.5 * point.stress * r / modulus};
  if (damage.value > largest_damage) {
    damage.value = largest_damage;
    damage.slope = 0;
  }
  return damage;
}

}  // namespace gabion::fem
