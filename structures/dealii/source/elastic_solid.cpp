// SPDX-License-Identifier: BSD-3-Clause
#include "elastic_solid.hpp"

#include <deal.II/base/quadrature_lib.h>
#include <deal.II/dofs/dof_tools.h>
#include <deal.II/fe/fe_q.h>
#include <deal.II/fe/fe_values.h>
#include <deal.II/fe/mapping_q1.h>
#include <deal.II/grid/grid_tools.h>
#include <deal.II/lac/dynamic_sparsity_pattern.h>

#include <common/base/error.hpp>

#include <cmath>

#include "mesh.hpp"

namespace dealii_structure {

namespace {

/// det(1 + H) - 1, without loss of digits where H is small.
template <int dim>
double determinant_minus_one(const dealii::Tensor<2, dim>& H) {
  if constexpr (dim == 2) return trace(H) + determinant(H);
  const double minors = H[0][0] * H[1][1] - H[0][1] * H[1][0] + H[0][0] * H[dim - 1][dim - 1] -
                        H[0][dim - 1] * H[dim - 1][0] + H[1][1] * H[dim - 1][dim - 1] -
                        H[1][dim - 1] * H[dim - 1][1];
  return trace(H) + minors + determinant(H);
}

template <int dim>
dealii::Tensor<2, dim> inverse_of_one_plus(const dealii::Tensor<2, dim>& H) {
  dealii::Tensor<2, dim> F = H;
  for (int i = 0; i < dim; ++i) F[i][i] += 1;
  return invert(F);
}

}  // namespace

template <int dim>
ElasticSolid<dim>::ElasticSolid(const Settings& settings)
    : lambda_(settings.material.young_modulus * settings.material.poisson_ratio /
              ((1 + settings.material.poisson_ratio) * (1 - 2 * settings.material.poisson_ratio))),
      mu_(settings.material.young_modulus / (2 * (1 + settings.material.poisson_ratio))),
      density_(settings.material.density),
      element_(dealii::FE_Q<dim>(settings.degree), dim) {
  make_mesh(settings, mesh_);
  number(settings);
  integrate_cells();
  Vector gravity(num_dofs());
  for (const CellValues& cell : cells_) {
    for (unsigned i = 0; i < cell.dofs.size(); ++i) {
      gravity[cell.dofs[i]] = settings.gravity[component_[i]];
    }
  }
  weight_ = mass_times(gravity);
}

template <int dim>
void ElasticSolid<dim>::number(const Settings& settings) {
  dofs_.reinit(mesh_);
  dofs_.distribute_dofs(element_);
  dealii::DoFTools::make_hanging_node_constraints(dofs_, constraints_);
  for (const auto& support : settings.supports) {
    dealii::ComponentMask mask(dim, false);
    for (const auto& component : support.components) mask.set(component[0] - 'x', true);
    for (const auto id : boundary_ids(settings, mesh_, support.groups)) {
      dealii::DoFTools::make_zero_boundary_constraints(dofs_, id, constraints_, mask);
    }
  }
  constraints_.close();
  dealii::DynamicSparsityPattern condensed(num_dofs()), full(num_dofs());
  dealii::DoFTools::make_sparsity_pattern(dofs_, condensed, constraints_,
                                          /*keep_constrained_dofs=*/false);
  dealii::DoFTools::make_sparsity_pattern(dofs_, full);
  condensed_pattern_.copy_from(condensed);
  full_pattern_.copy_from(full);
  mass_.reinit(full_pattern_);
}

/// Shape functions of all cells, and the mass.
template <int dim>
void ElasticSolid<dim>::integrate_cells() {
  const unsigned num_shapes = element_.n_dofs_per_cell();
  for (unsigned i = 0; i < num_shapes; ++i) {
    component_.push_back(element_.system_to_component_index(i).first);
    node_.push_back(element_.system_to_component_index(i).second);
  }
  const dealii::FE_Q<dim> scalar(element_.degree);
  const dealii::QGauss<dim> points(element_.degree + 1);
  dealii::FEValues<dim> values(
      scalar, points, dealii::update_values | dealii::update_gradients | dealii::update_JxW_values);
  dealii::FullMatrix<double> M(num_shapes);
  for (const auto& cell : dofs_.active_cell_iterators()) {
    values.reinit(typename dealii::Triangulation<dim>::cell_iterator(cell));
    CellValues found;
    found.dofs.resize(num_shapes);
    cell->get_dof_indices(found.dofs);
    for (unsigned q = 0; q < points.size(); ++q) {
      found.volumes.push_back(values.JxW(q));
      auto& gradients = found.gradients.emplace_back();
      auto& shapes = found.values.emplace_back();
      for (unsigned a = 0; a < scalar.n_dofs_per_cell(); ++a) {
        gradients.push_back(values.shape_grad(a, q));
        shapes.push_back(values.shape_value(a, q));
      }
    }
    M = 0;
    for (unsigned q = 0; q < points.size(); ++q) add_mass(found, q, 1, M);
    mass_.add(found.dofs, M);
    cells_.push_back(std::move(found));
  }
}

template <int dim>
dealii::Tensor<2, dim> ElasticSolid<dim>::displacement_gradient(const CellValues& cell, unsigned q,
                                                                const Vector& u) const {
  dealii::Tensor<2, dim> H;
  for (unsigned i = 0; i < cell.dofs.size(); ++i) {
    H[component_[i]] += u[cell.dofs[i]] * cell.gradients[q][node_[i]];
  }
  return H;
}

template <int dim>
bool ElasticSolid<dim>::internal_forces(const Vector& u, Vector& f) const {
  f.reinit(num_dofs());
  for (const CellValues& cell : cells_) {
    for (unsigned q = 0; q < cell.volumes.size(); ++q) {
      const auto H = displacement_gradient(cell, q, u);
      const double J_minus_one = determinant_minus_one<dim>(H);
      if (!(J_minus_one > -1)) return false;
      const auto F_inverse = inverse_of_one_plus<dim>(H);
      // F - F^-T = H + (F^-1 H)^T
      const auto P = mu_ * (H + transpose(F_inverse * H)) +
                     lambda_ * std::log1p(J_minus_one) * transpose(F_inverse);
      for (unsigned i = 0; i < cell.dofs.size(); ++i) {
        f[cell.dofs[i]] += cell.volumes[q] * (P[component_[i]] * cell.gradients[q][node_[i]]);
      }
    }
  }
  return true;
}

/// A_iJkL = mu delta_ik delta_JL + lambda F^-1_Ji F^-1_Lk + (mu - lambda ln J) F^-1_Jk F^-1_Li
template <int dim>
void ElasticSolid<dim>::add_tangent(const CellValues& cell, unsigned q,
                                    const dealii::Tensor<2, dim>& H,
                                    dealii::FullMatrix<double>& K) const {
  const auto F_inverse_transposed = transpose(inverse_of_one_plus<dim>(H));
  const double swap = mu_ - lambda_ * std::log1p(determinant_minus_one<dim>(H));
  const auto& gradients = cell.gradients[q];
  std::vector<dealii::Tensor<1, dim>> pushed;  // F^-T grad N
  for (const auto& gradient : gradients) pushed.push_back(F_inverse_transposed * gradient);
  for (unsigned i = 0; i < cell.dofs.size(); ++i) {
    const unsigned a = node_[i], ci = component_[i];
    for (unsigned j = 0; j < cell.dofs.size(); ++j) {
      const unsigned b = node_[j], cj = component_[j];
      double value = lambda_ * pushed[a][ci] * pushed[b][cj] + swap * pushed[a][cj] * pushed[b][ci];
      if (ci == cj) value += mu_ * (gradients[a] * gradients[b]);
      K(i, j) += cell.volumes[q] * value;
    }
  }
}

template <int dim>
void ElasticSolid<dim>::add_mass(const CellValues& cell, unsigned q, double factor,
                                 dealii::FullMatrix<double>& K) const {
  const auto& shapes = cell.values[q];
  for (unsigned i = 0; i < cell.dofs.size(); ++i) {
    for (unsigned j = 0; j < cell.dofs.size(); ++j) {
      if (component_[i] != component_[j]) continue;
      K(i, j) += factor * density_ * cell.volumes[q] * shapes[node_[i]] * shapes[node_[j]];
    }
  }
}

template <int dim>
void ElasticSolid<dim>::assemble(const Vector& u, double mass_factor,
                                 dealii::SparseMatrix<double>& matrix) const {
  matrix = 0;
  dealii::FullMatrix<double> K(element_.n_dofs_per_cell());
  for (const CellValues& cell : cells_) {
    K = 0;
    for (unsigned q = 0; q < cell.volumes.size(); ++q) {
      add_tangent(cell, q, displacement_gradient(cell, q, u), K);
      if (mass_factor != 0) add_mass(cell, q, mass_factor, K);
    }
    constraints_.distribute_local_to_global(K, cell.dofs, matrix);
  }
}

template <int dim>
void ElasticSolid<dim>::assemble_mass(dealii::SparseMatrix<double>& matrix) const {
  matrix = 0;
  dealii::FullMatrix<double> M(element_.n_dofs_per_cell());
  for (const CellValues& cell : cells_) {
    M = 0;
    for (unsigned q = 0; q < cell.volumes.size(); ++q) add_mass(cell, q, 1, M);
    constraints_.distribute_local_to_global(M, cell.dofs, matrix);
  }
}

template <int dim>
Vector ElasticSolid<dim>::mass_times(const Vector& a) const {
  Vector f(num_dofs());
  mass_.vmult(f, a);
  return f;
}

template <int dim>
auto ElasticSolid<dim>::interpolation(const ProbeSettings& probe) const -> Interpolation {
  const auto point = point_of<dim>(probe.point);
  const dealii::MappingQ1<dim> mapping;
  const auto [cell, place] =
      dealii::GridTools::find_active_cell_around_point(mapping, dofs_, point);
  if (cell == dofs_.end()) {
    throw gabion::ConfigError("structure: probe \"" + probe.name +
                              "\" is outside of the mesh, allowed: inside or on the boundary");
  }
  std::vector<unsigned> indices(element_.n_dofs_per_cell());
  cell->get_dof_indices(indices);
  Interpolation found;
  for (unsigned i = 0; i < indices.size(); ++i) {
    found.dofs[component_[i]].push_back(indices[i]);
    if (component_[i] == 0) found.weights.push_back(element_.shape_value(i, place));
  }
  return found;
}

template class ElasticSolid<2>;
template class ElasticSolid<3>;

}  // namespace dealii_structure
