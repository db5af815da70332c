// SPDX-License-Identifier: BSD-3-Clause
#include "mpm_solver/contact/contact_law.hpp"

namespace gabion::mpm {

template <int dim>
ContactTraction<dim> ContactLaw::traction(const Vector<dim>& gap, Matrix<dim>* slope) const {
  ContactTraction<dim> result;
  result.closed = mode == ContactMode::fixed || gap[0] < 0;
  if (slope) slope->setZero();
  if (!result.closed) return result;

  Vector<dim> eps = Vector<dim>::Constant(tangential_penalty());
  eps[0] = penalty;
  Vector<dim>& t = result.t;
  t = -eps.cwiseProduct(gap);
  if (slope) *slope = eps.asDiagonal();
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
  *slope -= eps[dim - 1] * (limit / size) * direction * direction.transpose();
  slope->col(0) = mu * eps[0] * direction;
  (*slope)(0, 0) = eps[0];
  return result;
}

template ContactTraction<2> ContactLaw::traction<2>(const Vector<2>&, Matrix<2>*) const;
template ContactTraction<3> ContactLaw::traction<3>(const Vector<3>&, Matrix<3>*) const;

}  // namespace gabion::mpm
