// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <gtest/gtest.h>

#include <Eigen/Core>
#include <span>
#include <vector>

#include "fem_solver/fem_config.hpp"
#include "fem_solver/stress/cell_integrals.hpp"

namespace gabion::test {

/// Cells with an accepted history, as functions of the displacement.
template <int dim>
struct Cells {
  explicit Cells(const fem::FemSettings<dim>& s)
      : integrals(s.mesh, s.materials, false), history(integrals.history_size(), 0.0) {}

  std::vector<double> trial() const { return std::vector<double>(history.size(), 0.0); }
  Eigen::VectorXd forces(const Eigen::VectorXd& u, double* energy = nullptr) const {
    Eigen::VectorXd f = Eigen::VectorXd::Zero(u.size());
    auto next = trial();
    const auto result = integrals.add_internal({u.data(), static_cast<std::size_t>(u.size())},
                                               {f.data(), static_cast<std::size_t>(f.size())},
                                               nullptr, {.accepted = history, .trial = next});
    EXPECT_EQ(result.inadmissible_cell, -1) << result.fault;
    if (energy) *energy = result.energy;
    return f;
  }
  void accept(const Eigen::VectorXd& u) {
    Eigen::VectorXd f = u;
    auto next = trial();
    integrals.add_internal({u.data(), static_cast<std::size_t>(u.size())},
                           {f.data(), static_cast<std::size_t>(f.size())}, nullptr,
                           {.accepted = history, .trial = next});
    history = next;
  }
  Eigen::MatrixXd tangent(const Eigen::VectorXd& u) const {
    BlockMatrix<dim> K;
    integrals.set_pattern(K);
    K.set_zero();
    Eigen::VectorXd f = Eigen::VectorXd::Zero(u.size());
    auto next = trial();
    integrals.add_internal({u.data(), static_cast<std::size_t>(u.size())},
                           {f.data(), static_cast<std::size_t>(f.size())}, &K,
                           {.accepted = history, .trial = next});
    Eigen::MatrixXd dense(u.size(), u.size());
    for (Eigen::Index k = 0; k < u.size(); ++k) {
      std::vector<double> unit(u.size(), 0.0), column(u.size(), 0.0);
      unit[k] = 1;
      K.multiply(unit, column);
      dense.col(k) = Eigen::Map<Eigen::VectorXd>(column.data(), u.size());
    }
    return dense;
  }

  fem::CellIntegrals<dim> integrals;
  std::vector<double> history;
};

/// 1 for nodes that are on no facet of a group, else 0.
template <int dim>
std::vector<char> inner_nodes(const Mesh<dim>& mesh) {
  std::vector<char> inner(mesh.nodes.size(), 1);
  for (const auto& [name, facets] : mesh.facet_groups) {
    for (const auto node : facets) inner[node] = 0;
  }
  return inner;
}

template <int dim>
Eigen::VectorXd affine(const Mesh<dim>& mesh, const Matrix<dim>& G) {
  Eigen::VectorXd u(static_cast<Eigen::Index>(mesh.nodes.size()) * dim);
  for (std::size_t i = 0; i < mesh.nodes.size(); ++i) {
    u.segment<dim>(static_cast<Eigen::Index>(i) * dim) = G * mesh.nodes[i];
  }
  return u;
}

template <int dim>
Matrix<dim> some_gradient(double scale) {
  Matrix<3> G;
  G << 0.11, -0.23, 0.05, 0.17, -0.08, 0.12, -0.06, 0.04, 0.14;
  return scale * G.topLeftCorner<dim, dim>();
}

}  // namespace gabion::test
