// SPDX-License-Identifier: BSD-3-Clause
#include "mpm_solver/contact/contact_law.hpp"

namespace gabion::mpm {

double ContactLaw::stored(double depth) const {
  if (!(depth > 0)) return 0;
  if (depth < onset) return penalty * depth * depth * depth / (6 * onset);
  return penalty * (depth * depth / 2 - onset * depth / 2 + onset * onset / 6);
}

ContactLaw::Normal ContactLaw::normal(double gap) const {
  if (mode == ContactMode::fixed) return {-penalty * gap, penalty};
  if (-gap < onset) return {penalty * gap * gap / (2 * onset), -penalty * gap / onset};
  return {penalty * (-gap - onset / 2), penalty};
}

template <int dim>
ContactTraction<dim> ContactLaw::traction(const Vector<dim>& gap, Matrix<dim>* slope) const {
  ContactTraction<dim> result;
  result.closed = mode == ContactMode::fixed || gap[0] < 0;
  if (slope) slope->setZero();
  if (!result.closed) return result;

  const Normal normal_part = normal(gap[0]);
  const double tangential = tangential_penalty();
  Vector<dim>& t = result.t;
  t = -tangential * gap;
  t[0] = normal_part.traction;
  if (slope) {
    slope->diagonal().setConstant(tangential);
    (*slope)(0, 0) = normal_part.slope;
  }
  const double mu = mode == ContactMode::slip ? 0 : friction;
  if (mode == ContactMode::fixed || mu < 0) return result;

  const double limit = mu * t[0];
  const double size = t.template tail<dim - 1>().norm();
  if (size <= limit) return result;
  result.sliding = true;
  Vector<dim> direction = t / size;
  direction[0] = 0;
  t.template tail<dim - 1>() = limit * direction.template tail<dim - 1>();
  if (!slope) return result;
  *slope *= limit / size;
  *slope -= tangential * (limit / size) * direction * direction.transpose();
  slope->col(0) = mu * normal_part.slope * direction;
  (*slope)(0, 0) = normal_part.slope;
  return result;
}

template ContactTraction<2> ContactLaw::traction<2>(const Vector<2>&, Matrix<2>*) const;
template ContactTraction<3> ContactLaw::traction<3>(const Vector<3>&, Matrix<3>*) const;

}  // namespace gabion::mpm
