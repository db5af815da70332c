// SPDX-License-Identifier: BSD-3-Clause
#include "mpm_solver/step/stable_step.hpp"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <limits>

#include "common/mechanics/ranks/sum.hpp"
#include "mpm_solver/checks/seepage.hpp"

namespace gabion::mpm {

template <int dim>
double effective_size(const BackgroundGrid<dim>& grid, std::int32_t cell) {
  const int n = grid.nodes_per_cell();
  Vector<dim> x[max_cell_nodes];
  grid.corners(cell, x);
  const Vector<dim> middle = Vector<dim>::Constant(grid.is_simplex() ? 1.0 / n : 0.0);
  ShapeValues<dim> shape;
  shape_functions<dim>(grid.cell_type, middle, shape);
  map_gradients<dim>(grid.cell_type, x, shape);
  Matrix<dim> sum = Matrix<dim>::Zero();
  for (int i = 0; i < n; ++i) sum += shape.dN[i] * shape.dN[i].transpose();
  const Eigen::SelfAdjointEigenSolver<Matrix<dim>> spectrum(sum, Eigen::EigenvaluesOnly);
  return 2 / std::sqrt(n * spectrum.eigenvalues().maxCoeff());
}

template <int dim>
StableStep<dim>::StableStep(const SoilModel<dim>& model) : model_(model) {
  if (!any_explicit(model.settings.phases)) return;
  const std::int32_t num_sizes = model.grid.box ? 1 : model.grid.num_cells();
  for (std::int32_t c = 0; c < num_sizes; ++c) size_.push_back(effective_size(model.grid, c));
}

template <int dim>
double StableStep<dim>::of_soil(const MaterialPoints<dim>& points) const {
  double dt = std::numeric_limits<double>::infinity();
  for (std::int32_t b = 0; b < points.num_bodies(); ++b) {
    double smallest = std::numeric_limits<double>::infinity();
    for (std::int32_t p = points.body_starts[b]; p < points.body_starts[b + 1]; ++p) {
      smallest = std::min(smallest, size_[model_.grid.box ? 0 : points.cell[p]]);
    }
    dt = std::min(dt, smallest / wave_speed(points, b) * share_by_viscosity(b, smallest));
  }
  return -max_over_ranks(model_.comm, -dt);
}

// Wave speed of a body; for a law whose stiffness depends on the state that of the stiffest point.
template <int dim>
double StableStep<dim>::wave_speed(const MaterialPoints<dim>& points, std::int32_t b) const {
  const Body<dim>& body = model_.settings.bodies[b];
  return std::visit(
      [&](const auto& law) {
        if constexpr (requires { law.p_wave_modulus_at(points.history[0], points.internal[0]); }) {
          double M = 0;
          for (std::int32_t p = points.body_starts[b]; p < points.body_starts[b + 1]; ++p) {
            M = std::max(M, law.p_wave_modulus_at(points.history[p], points.internal[p]));
          }
          if (body.water && !body.water->drains()) M += body.water->modulus();
          return std::sqrt(M / body.material.density);
        } else {
          if (drains(body)) return std::sqrt(skeleton_modulus(body) / body.material.density);
          return model_.wave_speeds[b];
        }
      },
      body.material.law);
}

// Share of the step of a cell that viscosity leaves; its product with the size grows with the size.
template <int dim>
double StableStep<dim>::share_by_viscosity(std::int32_t b, double size) const {
  const Material<dim>& material = model_.settings.bodies[b].material;
  return std::visit(
      [&](const auto& law) {
        if constexpr (requires { law.viscosity(); }) {
          const double xi =
              4 * law.viscosity() / (3 * material.density * model_.wave_speeds[b] * size);
          return 1 / (std::sqrt(1 + xi * xi) + xi);
        } else {
          return 1.0;
        }
      },
      material.law);
}

template class StableStep<2>;
template class StableStep<3>;
template double effective_size<2>(const BackgroundGrid<2>&, std::int32_t);
template double effective_size<3>(const BackgroundGrid<3>&, std::int32_t);

}  // namespace gabion::mpm
