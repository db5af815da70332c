// SPDX-License-Identifier: BSD-3-Clause
#include "mpm_solver/grid/surface_values.hpp"

#include "mpm_solver/grid/box_basis.hpp"

namespace gabion::mpm {

namespace {

// Linear functions averaged over the part t + e - rest .. t + e + rest of a domain, for the nodes
// of `domain`. @pre the part lies in the domain
std::array<double, 3> gimp_part(const AxisValues& domain, double at, double rest, int cell,
                                int num_cells) {
  if (at < cell && domain.first < cell) --cell;
  if (at > cell + 1 && domain.first + domain.count > cell + 2) ++cell;
  const AxisValues part = gimp_values(at, rest, cell, num_cells);
  std::array<double, 3> N{};
  for (int m = 0; m < part.count; ++m) N[part.first + m - domain.first] = part.N[m];
  return N;
}

// Splines at t + e. A node gets the sum of the gradients at points 2 |e| apart, from the knot
// behind or where its spline begins.
std::array<double, 3> bspline_shifted(const AxisValues& values, double t, double e) {
  std::array<double, 3> N{};
  for (int m = 0; m < values.count; ++m) N[m] = values.N[m] + e * values.dN[m];
  if (values.count < 3 || e == 0) return N;
  const double z = t - (values.first + 1), step = 2 * std::abs(e);
  const double behind = std::fmod(e > 0 ? z + 0.5 : 0.5 - z, step);
  const double c = 0.5 * behind * (step - behind);
  N[0] += c;
  N[1] -= 2 * c;
  N[2] += c;
  return N;
}

}  // namespace

template <int dim>
SurfaceValues<dim>::SurfaceValues(const BackgroundGrid<dim>& grid,
                                  const MaterialPoints<dim>& points, std::int32_t p)
    : basis_(grid.basis), l_(Vector<dim>::Zero()), spacing_(grid.box->spacing) {
  const BoxGrid<dim>& box = *grid.box;
  t_ = box.lattice_position(points.x[p]);
  cell_ = box.cell_index(points.cell[p]);
  num_cells_ = box.num_cells;
  if (basis_ == Basis::gimp) l_ = gimp_domain(box, points, p);
  for (int d = 0; d < dim; ++d) {
    if (basis_ == Basis::gimp) {
      axes_[d] = gimp_values(t_[d], l_[d], cell_[d], num_cells_[d]);
      l_[d] = gimp_half_length(t_[d], l_[d], num_cells_[d]);
    } else {
      axes_[d] = bspline_values(t_[d], cell_[d], num_cells_[d]);
    }
  }
}

template <int dim>
std::array<double, 3> SurfaceValues<dim>::along(int d, double e, double rest) const {
  return basis_ == Basis::gimp ? gimp_part(axes_[d], t_[d] + e, rest, cell_[d], num_cells_[d])
                               : bspline_shifted(axes_[d], t_[d], e);
}

template <int dim>
Vector<dim> SurfaceValues<dim>::at(const Vector<dim>& n, double R, double* w) const {
  Vector<dim> e;
  std::array<double, 3> N[dim];
  for (int d = 0; d < dim; ++d) {
    e[d] = -n[d] * (basis_ == Basis::gimp ? l_[d] : R / spacing_[d]);
    N[d] = along(d, e[d], l_[d] * (1 - std::min(1.0, std::abs(n[d]))));
  }
  const int layers = dim == 3 ? axes_[dim - 1].count : 1;
  for (int k = 0; k < layers; ++k) {
    for (int j = 0; j < axes_[1].count; ++j) {
      for (int i = 0; i < axes_[0].count; ++i) {
        *w = N[0][i] * N[1][j];
        if constexpr (dim == 3) *w *= N[2][k];
        ++w;
      }
    }
  }
  return e.cwiseProduct(spacing_);
}

template class SurfaceValues<2>;
template class SurfaceValues<3>;

}  // namespace gabion::mpm
