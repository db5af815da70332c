// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <deal.II/dofs/dof_handler.h>
#include <deal.II/fe/fe_system.h>
#include <deal.II/grid/tria.h>
#include <deal.II/lac/affine_constraints.h>
#include <deal.II/lac/sparse_matrix.h>
#include <deal.II/lac/vector.h>

#include <vector>

#include "settings.hpp"

namespace dealii_structure {

using Vector = dealii::Vector<double>;

/// Total Lagrangian solid of neo-Hookean material with elements of any degree and hanging nodes:
///
///     r_a = int P grad N_a dV ,  P = mu (F - F^-T) + lambda ln J F^-T
///
/// Vectors have a value for each component of each node, those of hanging and held nodes included;
/// `condense` moves forces on hanging nodes to the nodes that they hang on.
template <int dim>
class ElasticSolid {
 public:
  explicit ElasticSolid(const Settings& settings);

  unsigned num_dofs() const { return dofs_.n_dofs(); }
  const dealii::Triangulation<dim>& mesh() const { return mesh_; }
  const dealii::DoFHandler<dim>& dofs() const { return dofs_; }
  /// Hanging nodes follow their neighbours, held ones stay.
  const dealii::AffineConstraints<double>& constraints() const { return constraints_; }

  /// Inner forces [N] (2D: per metre) at the displacement u [m], not condensed.
  /// @returns false where J <= 0: f is of no use then
  bool internal_forces(const Vector& u, Vector& f) const;
  /// Tangent at u plus `mass_factor` times the mass, condensed.
  void assemble(const Vector& u, double mass_factor, dealii::SparseMatrix<double>& matrix) const;
  /// The mass, condensed.
  void assemble_mass(dealii::SparseMatrix<double>& matrix) const;
  /// The pattern for `assemble`; this object keeps it.
  void init(dealii::SparseMatrix<double>& matrix) const { matrix.reinit(condensed_pattern_); }
  /// M a, not condensed.
  Vector mass_times(const Vector& a) const;
  /// Forces of gravity, not condensed.
  const Vector& weight() const { return weight_; }
  void condense(Vector& f) const { constraints_.condense(f); }

  /// Displacement of a point of the reference configuration: sum of weight times nodal value.
  struct Interpolation {
    std::vector<unsigned> dofs[dim];
    std::vector<double> weights;
  };
  /// @throws gabion::ConfigError  outside of the mesh
  Interpolation interpolation(const ProbeSettings& probe) const;

 private:
  /// Shape functions at the integration points of a cell.
  struct CellValues {
    std::vector<unsigned> dofs;                                  // of the cell, deal.II's order
    std::vector<std::vector<dealii::Tensor<1, dim>>> gradients;  // point, node
    std::vector<std::vector<double>> values;                     // point, node
    std::vector<double> volumes;                                 // [m^dim]
  };
  void number(const Settings& settings);
  void integrate_cells();
  dealii::Tensor<2, dim> displacement_gradient(const CellValues& cell, unsigned q,
                                               const Vector& u) const;
  void add_tangent(const CellValues& cell, unsigned q, const dealii::Tensor<2, dim>& H,
                   dealii::FullMatrix<double>& K) const;
  void add_mass(const CellValues& cell, unsigned q, double factor,
                dealii::FullMatrix<double>& K) const;

  double lambda_, mu_, density_;  // [Pa], [Pa], [kg/m^3]
  dealii::Triangulation<dim> mesh_;
  dealii::FESystem<dim> element_;
  dealii::DoFHandler<dim> dofs_;
  dealii::AffineConstraints<double> constraints_;
  dealii::SparsityPattern condensed_pattern_, full_pattern_;
  dealii::SparseMatrix<double> mass_;
  Vector weight_;
  std::vector<CellValues> cells_;
  std::vector<unsigned> component_, node_;  // of each shape function
};

}  // namespace dealii_structure
