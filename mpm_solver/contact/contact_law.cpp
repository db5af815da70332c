// SPDX-License-Identifier: BSD-3-Clause
#include "mpm_solver/contact/contact_law.hpp"

#include <algorithm>
#include <cmath>

namespace gabion::mpm {

double ContactLaw::stored(double depth) const {
  if (!(depth > 0)) return 0;
  const double square = penalty * depth * depth;
  return normal == NormalLaw::linear ? square / 2 : square * depth / 3;
}

double ContactLaw::reduced(double depth) const {
  if (depth <= linear_from) return depth;
  return 2 * linear_from - linear_from * linear_from / depth;
}

double ContactLaw::reduced_slope(double depth) const {
  if (depth <= linear_from) return 1;
  const double share = linear_from / depth;
  return share * share;
}

double ContactLaw::storing(double depth) const {
  if (depth <= linear_from) return depth;
  const double d = linear_from, more = depth - d;
  return (d * d * d + 3 * d * more * (d + more)) / (depth * depth);
}

double ContactLaw::depth_of(double square) const {
  const double depth = std::sqrt(square);
  if (depth <= linear_from) return depth;
  return 0.5 * (square / linear_from + linear_from);
}

// k s + drag (s / time)^2 = excess.
ContactLaw::Slide ContactLaw::slide_beyond(double excess) const {
  const double k = tangential_penalty;
  const double root = std::sqrt(k * k + 4 * drag * excess / (time * time));
  return {.slip = 2 * excess / (k + root), .elastic = 1 - k / root};
}

double ContactLaw::on_grains(double t_n) const {
  return (1 - drained) * grain_share * t_n + drained * std::max(0.0, t_n - pore_pressure);
}

double ContactLaw::on_grains_slope(double t_n) const {
  return (1 - drained) * grain_share + (t_n > pore_pressure ? drained : 0);
}

double ContactLaw::friction_now() const {
  if (weakening.fall == 0) return friction;
  return friction + weakening.fall * std::expm1(-speed / weakening.speed);
}

double ContactLaw::friction_slope() const {
  if (weakening.fall == 0) return 0;
  return -weakening.fall / weakening.speed * std::exp(-speed / weakening.speed);
}

template <int dim>
ContactTraction<dim> ContactLaw::traction(const Vector<dim>& gap, Matrix<dim>* slope) const {
  ContactTraction<dim> result;
  result.closed = mode == ContactMode::fixed || gap[0] < 0;
  if (slope) slope->setZero();
  if (!result.closed) return result;

  const bool linear = normal == NormalLaw::linear;
  const double normal_slope = linear ? penalty : -2 * penalty * gap[0];
  Vector<dim>& t = result.t;
  t = -tangential_penalty * gap;
  t[0] = linear ? -penalty * gap[0] : penalty * gap[0] * gap[0];
  if (slope) {
    slope->diagonal().setConstant(tangential_penalty);
    (*slope)(0, 0) = normal_slope;
  }
  const double mu = mode == ContactMode::slip ? 0 : friction_now();
  if (mode == ContactMode::fixed || mu < 0) return result;

  const double borne = on_grains(t[0]);
  const bool grains_touch = borne > 0;
  double limit = grains_touch ? mu * borne : 0;
  const double size = t.template tail<dim - 1>().norm();
  if (size <= limit) return result;
  result.sliding = true;
  result.elastic = 0;
  if (drag > 0) {
    const Slide slide = slide_beyond(size - limit);
    limit = size - tangential_penalty * slide.slip;
    result.elastic = slide.elastic;
  }
  if (grains_touch) result.by_speed = (1 - result.elastic) * friction_slope() * borne;
  Vector<dim> direction = t / size;
  direction[0] = 0;
  t.template tail<dim - 1>() = limit * direction.template tail<dim - 1>();
  if (!slope) return result;
  *slope *= limit / size;
  *slope -=
      tangential_penalty * (limit / size - result.elastic) * direction * direction.transpose();
  const double borne_slope = on_grains_slope(t[0]) * normal_slope;
  slope->col(0) = (grains_touch ? (1 - result.elastic) * mu * borne_slope : 0) * direction;
  (*slope)(0, 0) = normal_slope;
  return result;
}

template ContactTraction<2> ContactLaw::traction<2>(const Vector<2>&, Matrix<2>*) const;
template ContactTraction<3> ContactLaw::traction<3>(const Vector<3>&, Matrix<3>*) const;

}  // namespace gabion::mpm
