// SPDX-License-Identifier: BSD-3-Clause
#include "fem_solver/stress/nodal_parts.hpp"

namespace gabion::fem {

template <int dim>
void NodalParts<dim>::add_mass_at(std::int32_t node, double mass) {
  masses_.push_back({node, mass});
}

template <int dim>
void NodalParts<dim>::add_spring_at(std::int32_t node, const Vector<dim>& stiffness) {
  springs_.push_back({node, stiffness});
}

template <int dim>
double NodalParts<dim>::add_internal(std::span<const double> u, std::span<double> f_int,
                                     BlockMatrix<dim>* K) const {
  double energy = 0;
  for (const auto& [node, stiffness] : springs_) {
    const std::size_t first = static_cast<std::size_t>(node) * dim;
    for (int c = 0; c < dim; ++c) {
      f_int[first + c] += stiffness[c] * u[first + c];
      energy += 0.5 * stiffness[c] * u[first + c] * u[first + c];
    }
    if (K) K->add_block(node, node, Matrix<dim>(stiffness.asDiagonal()));
  }
  return energy;
}

template <int dim>
void NodalParts<dim>::add_mass_times(std::span<const double> a, std::span<double> f) const {
  for (const auto& [node, mass] : masses_) {
    const std::size_t first = static_cast<std::size_t>(node) * dim;
    for (int c = 0; c < dim; ++c) f[first + c] += mass * a[first + c];
  }
}

template <int dim>
void NodalParts<dim>::add_mass(double scale, BlockMatrix<dim>& K) const {
  for (const auto& [node, mass] : masses_) K.add_diagonal(node, scale * mass);
}

template class NodalParts<2>;
template class NodalParts<3>;

}  // namespace gabion::fem
