// SPDX-License-Identifier: BSD-3-Clause
#include "mpm_solver/contact/penetration_at_rest.hpp"

#include <algorithm>
#include <cmath>
#include <vector>

namespace gabion::mpm {

namespace {

// Cosine of the angle below which two faces push as one.
constexpr double one_face = 0.866;

}  // namespace

template <int dim>
Vector<dim> penetration_at_rest(std::span<const RestingPlace<dim>> places) {
  std::vector<RestingPlace<dim>> nearest(places.begin(), places.end());
  std::stable_sort(nearest.begin(), nearest.end(),
                   [](const auto& a, const auto& b) { return std::abs(a.gap) < std::abs(b.gap); });
  Vector<dim> s = Vector<dim>::Zero();
  for (std::size_t k = 0; k < nearest.size(); ++k) {
    const bool known = std::any_of(
        nearest.begin(), nearest.begin() + static_cast<std::ptrdiff_t>(k),
        [&](const auto& other) { return other.normal.dot(nearest[k].normal) > one_face; });
    if (!known) s += nearest[k].square * nearest[k].normal;
  }
  const double size = s.norm();
  return size > 0 ? Vector<dim>(s / std::sqrt(size)) : s;
}

template Vector<2> penetration_at_rest<2>(std::span<const RestingPlace<2>>);
template Vector<3> penetration_at_rest<3>(std::span<const RestingPlace<3>>);

}  // namespace gabion::mpm
