// SPDX-License-Identifier: BSD-3-Clause
#include "common/mechanics/materials/strength_curve.hpp"

#include <algorithm>
#include <cmath>

namespace gabion {
namespace {

constexpr double Strength::*members[] = {&Strength::cohesion, &Strength::sin_friction,
                                         &Strength::sin_dilation};

// sin psi of Rowe with its derivative by sin phi.
struct RoweDilation {
  double value, slope;
};
RoweDilation rowe(double sin_phi, double sin_cv) {
  const double below = 1 - sin_phi * sin_cv;
  return {(sin_phi - sin_cv) / below, (1 - sin_cv * sin_cv) / (below * below)};
}

// Slopes of a monotone cubic at its points: the harmonic mean of the secants beside them, weighted
// by the lengths; zero at an extremum. At the ends, the secant.
std::vector<double> monotone_slopes(const std::vector<double>& x, const std::vector<double>& y) {
  const std::size_t n = x.size();
  std::vector<double> secant(n - 1), slope(n);
  for (std::size_t i = 0; i + 1 < n; ++i) secant[i] = (y[i + 1] - y[i]) / (x[i + 1] - x[i]);
  slope.front() = secant.front();
  slope.back() = 0;  // constant beyond
  for (std::size_t i = 1; i + 1 < n; ++i) {
    if (!(secant[i - 1] * secant[i] > 0)) continue;
    const double before = x[i] - x[i - 1], after = x[i + 1] - x[i];
    slope[i] = 3 * (before + after) /
               ((2 * after + before) / secant[i - 1] + (after + 2 * before) / secant[i]);
  }
  return slope;
}

}  // namespace

StrengthCurve::StrengthCurve(const TabulatedCurve& curve) : table_(curve), slopes_(curve.x.size()) {
  for (double Strength::*const member : members) {
    std::vector<double> y;
    for (const Strength& value : table_.values) y.push_back(value.*member);
    const auto slopes = monotone_slopes(table_.x, y);
    for (std::size_t i = 0; i < slopes.size(); ++i) slopes_[i].*member = slopes[i];
  }
}

StrengthCurve::Point StrengthCurve::exponential_at(double x) const {
  const ExponentialCurve& c = exponential_;
  const double left = std::exp(-x / c.scale), slope = -left / c.scale;
  const double lost = c.peak.cohesion - c.residual.cohesion;
  const double friction = c.peak.sin_friction - c.residual.sin_friction;
  Point point;
  point.value.cohesion = c.residual.cohesion + lost * left;
  point.slope.cohesion = lost * slope;
  if (c.remoulding_scale > 0) {
    const double intact = std::exp(-x / c.remoulding_scale);
    const double remoulds = c.residual.cohesion - c.remoulded_cohesion;
    point.value.cohesion = c.remoulded_cohesion + remoulds * intact + lost * left;
    point.slope.cohesion -= remoulds * intact / c.remoulding_scale;
  }
  point.value.sin_friction = c.residual.sin_friction + friction * left;
  point.slope.sin_friction = friction * slope;
  if (c.dilation == Dilation::rowe) {
    const RoweDilation psi = rowe(point.value.sin_friction, c.residual.sin_friction);
    point.value.sin_dilation = psi.value;
    point.slope.sin_dilation = psi.slope * point.slope.sin_friction;
  } else {
    point.value.sin_dilation = c.peak.sin_dilation * left;
    point.slope.sin_dilation = c.peak.sin_dilation * slope;
  }
  return point;
}

StrengthCurve::Point StrengthCurve::table_at(double x) const {
  if (x >= table_.x.back()) return {.value = table_.values.back(), .slope = {}};
  const auto next = std::upper_bound(table_.x.begin() + 1, table_.x.end() - 1, x);
  const std::size_t j = static_cast<std::size_t>(next - table_.x.begin()), i = j - 1;
  const double h = table_.x[j] - table_.x[i], t = (x - table_.x[i]) / h;
  Point point;
  for (double Strength::*const member : members) {
    const double y_0 = table_.values[i].*member, rise = table_.values[j].*member - y_0;
    const double m_0 = h * slopes_[i].*member, m_1 = h * slopes_[j].*member;
    const double b = 3 * rise - 2 * m_0 - m_1, c = m_0 + m_1 - 2 * rise;
    point.value.*member = y_0 + t * (m_0 + t * (b + t * c));
    point.slope.*member = (m_0 + t * (2 * b + t * 3 * c)) / h;
  }
  return point;
}

std::vector<double> StrengthCurve::samples() const {
  constexpr int count = 64;
  std::vector<double> ends = table_.x;
  if (ends.empty()) {
    ends = {0, 5 * exponential_.scale};
    if (exponential_.remoulding_scale > 0) ends.push_back(5 * exponential_.remoulding_scale);
    std::sort(ends.begin(), ends.end());
  }
  std::vector<double> samples;
  for (std::size_t i = 0; i + 1 < ends.size(); ++i) {
    for (int k = 0; k < count; ++k)
      samples.push_back(ends[i] + (ends[i + 1] - ends[i]) * k / count);
  }
  samples.push_back(ends.back());
  return samples;
}

}  // namespace gabion
