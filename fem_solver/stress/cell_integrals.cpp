// SPDX-License-Identifier: BSD-3-Clause
#include "fem_solver/stress/cell_integrals.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cassert>
#include <cmath>
#include <limits>
#include <variant>

#include "common/base/require.hpp"
#include "common/mechanics/elements/shape_functions.hpp"
#include "common/mechanics/rotation_angle.hpp"

namespace gabion::fem {

namespace {

/// Of the rotation R in F = R U [rad]; 0 below some 0.1 rad in space, where nobody asks for it.
template <int dim>
double angle_of(const Matrix<dim>& F) {
  if constexpr (dim == 3) {
    const Matrix<dim> skew = 0.5 * (F - F.transpose());
    if (skew.squaredNorm() < 2e-2 && F.trace() > 2.9) return 0;
  }
  return rotation_angle<dim>(F);
}

/// Degree that integrates the stiffness of an undistorted cell exactly; full integration.
int stiffness_degree(CellType type) {
  return type == CellType::tri3 || type == CellType::tet4 ? 1 : 3;
}

/// Degree that integrates N_a N_b of an undistorted cell exactly.
int mass_degree(CellType type) {
  return type == CellType::tri3 || type == CellType::tet4 ? 2 : 3;
}

}  // namespace

template <int dim>
CellIntegrals<dim>::CellIntegrals(const Mesh<dim>& mesh, const Material<dim>& material,
                                  bool lumped_mass, const MeshRanks& ranks)
    : material_(material),
      nodes_per_cell_(mesh.nodes_per_cell()),
      num_nodes_(mesh.num_nodes_total()),
      num_cells_(mesh.num_cells()),
      cell_nodes_(mesh.cells) {
  compute_geometry(mesh, ranks);
  compute_mass(mesh, lumped_mass);
}

template <int dim>
void CellIntegrals<dim>::compute_geometry(const Mesh<dim>& mesh, const MeshRanks& ranks) {
  const auto rule = gauss_rule<dim>(mesh.cell_type, stiffness_degree(mesh.cell_type));
  points_per_cell_ = static_cast<int>(rule.size());
  double smallest_volume = std::numeric_limits<double>::infinity();
  for (std::int32_t c = 0; c < mesh.num_cells(); ++c) {
    smallest_volume = std::min(smallest_volume, cell_volume(mesh, c));
  }
  smallest_cell_size_ = cube_side<dim>(smallest_volume);
  ShapeValues<dim> shape;
  Vector<dim> x[max_cell_nodes];
  for (std::int32_t c = 0; c < num_cells_; ++c) {
    for (int a = 0; a < nodes_per_cell_; ++a) x[a] = mesh.nodes[cell(c)[a]];
    for (const auto& q : rule) {
      shape_functions<dim>(mesh.cell_type, q.xi, shape);
      const double jacobian = map_gradients<dim>(mesh.cell_type, x, shape);
      require<ConfigError>(jacobian > 0,
                           "mesh: cell {} has the Jacobian {:.3g} at a quadrature "
                           "point; allowed: convex cells of positive volume",
                           ranks.cell_of_all(c), jacobian);
      weights_.push_back(q.weight * jacobian);
      gradients_.insert(gradients_.end(), shape.dN, shape.dN + nodes_per_cell_);
    }
  }
}

template <int dim>
void CellIntegrals<dim>::compute_mass(const Mesh<dim>& mesh, bool lumped) {
  const auto rule = gauss_rule<dim>(mesh.cell_type, mass_degree(mesh.cell_type));
  const int n = nodes_per_cell_;
  if (lumped) {
    lumped_masses_.assign(mesh.nodes.size(), 0.0);
  } else {
    cell_masses_.assign(static_cast<std::size_t>(num_cells_) * n * n, 0.0);
  }
  ShapeValues<dim> shape;
  Vector<dim> x[max_cell_nodes];
  for (std::int32_t c = 0; c < num_cells_; ++c) {
    for (int a = 0; a < n; ++a) x[a] = mesh.nodes[cell(c)[a]];
    for (const auto& q : rule) {
      shape_functions<dim>(mesh.cell_type, q.xi, shape);
      double N[max_cell_nodes];
      std::copy(shape.N, shape.N + n, N);
      const double mass =
          material_.density * q.weight * map_gradients<dim>(mesh.cell_type, x, shape);
      for (int a = 0; a < n; ++a) {
        if (lumped) lumped_masses_[cell(c)[a]] += mass * N[a];
        if (lumped) continue;
        double* row = cell_masses_.data() + (static_cast<std::size_t>(c) * n + a) * n;
        for (int b = 0; b < n; ++b) row[b] += mass * N[a] * N[b];
      }
    }
  }
}

template <int dim>
template <int nodes>
Matrix<dim> CellIntegrals<dim>::displacement_gradient(const Vector<dim>* dN,
                                                      const Vector<dim>* u_cell) const {
  Matrix<dim> H = Matrix<dim>::Zero();
  for (int a = 0; a < nodes; ++a) H.noalias() += u_cell[a] * dN[a].transpose();
  return H;
}

namespace {

/// K_ab += w dN_a . A . dN_b, row-major (nodes dim) x (nodes dim).
template <int dim, int nodes>
void add_point_stiffness(const Tangent<dim>& A, const Vector<dim>* dN, double w, double* K) {
  constexpr int n = nodes * dim;
  for (int b = 0; b < nodes; ++b) {
    double AdN[dim * dim][dim];  // (iJ, k) = w A(iJ, kL) dN_b,L
    for (int iJ = 0; iJ < dim * dim; ++iJ) {
      for (int k = 0; k < dim; ++k) {
        double sum = 0;
        for (int L = 0; L < dim; ++L) sum += A(iJ, k * dim + L) * dN[b][L];
        AdN[iJ][k] = w * sum;
      }
    }
    for (int a = 0; a < nodes; ++a) {
      for (int i = 0; i < dim; ++i) {
        double* row = K + (a * dim + i) * n + b * dim;
        for (int k = 0; k < dim; ++k) {
          double sum = 0;
          for (int J = 0; J < dim; ++J) sum += dN[a][J] * AdN[i * dim + J][k];
          row[k] += sum;
        }
      }
    }
  }
}

}  // namespace

template <int dim>
template <int nodes, class Law>
StressIntegral CellIntegrals<dim>::integrate(const Law& law, std::span<const double> u,
                                             std::span<double> f_int, BlockMatrix<dim>* K) const {
  StressIntegral result;
  const MaterialState<dim> virgin;
  StressUpdate<dim> update;
  Tangent<dim> A;
  double K_cell[nodes * dim * nodes * dim];
  for (std::int32_t c = 0; c < num_cells_; ++c) {
    const std::int32_t* node = cell_nodes_.data() + static_cast<std::size_t>(c) * nodes;
    Vector<dim> u_cell[nodes], f_cell[nodes];
    for (int a = 0; a < nodes; ++a) {
      u_cell[a] = Eigen::Map<const Vector<dim>>(u.data() + static_cast<std::size_t>(node[a]) * dim);
      f_cell[a].setZero();
    }
    if (K) std::fill(std::begin(K_cell), std::end(K_cell), 0.0);
    for (int q = 0; q < points_per_cell_; ++q) {
      const std::size_t point = static_cast<std::size_t>(c) * points_per_cell_ + q;
      const Vector<dim>* dN = gradients_.data() + point * nodes;
      const double w = weights_[point];
      if (!law.update(displacement_gradient<nodes>(dN, u_cell), virgin, update, K ? &A : nullptr)) {
        result.inadmissible_cell = c;
        return result;
      }
      result.energy += w * update.energy;
      for (int a = 0; a < nodes; ++a) f_cell[a].noalias() += w * (update.P * dN[a]);
      if (K) add_point_stiffness<dim, nodes>(A, dN, w, K_cell);
    }
    for (int a = 0; a < nodes; ++a) {
      Eigen::Map<Vector<dim>>(f_int.data() + static_cast<std::size_t>(node[a]) * dim) += f_cell[a];
    }
    if (K) K->add_cell(c, K_cell);
  }
  return result;
}

template <int dim>
StressIntegral CellIntegrals<dim>::add_internal(std::span<const double> u, std::span<double> f_int,
                                                BlockMatrix<dim>* K) const {
  return std::visit(
      [&](const auto& law) {
        switch (nodes_per_cell_) {
          case 3:
            return integrate<3>(law, u, f_int, K);
          case 4:
            return integrate<4>(law, u, f_int, K);
          default:
            assert(nodes_per_cell_ == 8);
            return integrate<8>(law, u, f_int, K);
        }
      },
      material_.law);
}

template <int dim>
void CellIntegrals<dim>::add_mass_times(std::span<const double> a, std::span<double> f) const {
  for (std::size_t i = 0; i < lumped_masses_.size(); ++i) {
    for (int k = 0; k < dim; ++k) f[i * dim + k] += lumped_masses_[i] * a[i * dim + k];
  }
  if (cell_masses_.empty()) return;
  const int n = nodes_per_cell_;
  for (std::int32_t c = 0; c < num_cells_; ++c) {
    const auto node = cell(c);
    const double* M = cell_masses_.data() + static_cast<std::size_t>(c) * n * n;
    for (int i = 0; i < n; ++i) {
      Vector<dim> sum = Vector<dim>::Zero();
      for (int j = 0; j < n; ++j) {
        sum += M[i * n + j] *
               Eigen::Map<const Vector<dim>>(a.data() + static_cast<std::size_t>(node[j]) * dim);
      }
      Eigen::Map<Vector<dim>>(f.data() + static_cast<std::size_t>(node[i]) * dim) += sum;
    }
  }
}

template <int dim>
void CellIntegrals<dim>::add_mass(double scale, BlockMatrix<dim>& K) const {
  for (std::size_t i = 0; i < lumped_masses_.size(); ++i) {
    if (lumped_masses_[i] != 0) {
      K.add_diagonal(static_cast<std::int32_t>(i), scale * lumped_masses_[i]);
    }
  }
  if (cell_masses_.empty()) return;
  const int n = nodes_per_cell_;
  std::vector<double> K_cell(static_cast<std::size_t>(n * dim) * n * dim, 0.0);
  for (std::int32_t c = 0; c < num_cells_; ++c) {
    const double* M = cell_masses_.data() + static_cast<std::size_t>(c) * n * n;
    for (int a = 0; a < n; ++a) {
      for (int b = 0; b < n; ++b) {
        for (int k = 0; k < dim; ++k) {
          K_cell[static_cast<std::size_t>(a * dim + k) * n * dim + b * dim + k] =
              scale * M[a * n + b];
        }
      }
    }
    K.add_cell(c, K_cell.data());
  }
}

template <int dim>
void CellIntegrals<dim>::set_pattern(BlockMatrix<dim>& K) const {
  std::vector<std::int32_t> offsets(static_cast<std::size_t>(num_cells_) + 1);
  for (std::size_t c = 0; c < offsets.size(); ++c) {
    offsets[c] = static_cast<std::int32_t>(c) * nodes_per_cell_;
  }
  K.set_pattern(num_nodes_, offsets, cell_nodes_);
}

template <int dim>
std::vector<double> CellIntegrals<dim>::cell_stresses(std::span<const double> u) const {
  constexpr int size = symmetric_size<dim>;
  std::vector<double> result(static_cast<std::size_t>(num_cells_) * size, 0.0);
  const MaterialState<dim> virgin;
  StressUpdate<dim> update;
  for (std::int32_t c = 0; c < num_cells_; ++c) {
    Symmetric<dim> mean = Symmetric<dim>::Zero();
    double volume = 0;
    for (int q = 0; q < points_per_cell_; ++q) {
      const std::size_t point = static_cast<std::size_t>(c) * points_per_cell_ + q;
      Matrix<dim> H = Matrix<dim>::Zero();
      for (int a = 0; a < nodes_per_cell_; ++a) {
        H += Eigen::Map<const Vector<dim>>(u.data() + static_cast<std::size_t>(cell(c)[a]) * dim) *
             gradients_[point * nodes_per_cell_ + a].transpose();
      }
      std::visit([&](const auto& law) { law.update(H, virgin, update, nullptr); }, material_.law);
      const bool small_strain = std::holds_alternative<LinearElastic<dim>>(material_.law);
      mean += weights_[point] * update.tau / (small_strain ? 1.0 : update.J);
      volume += weights_[point];
    }
    Eigen::Map<Symmetric<dim>>(result.data() + static_cast<std::size_t>(c) * size) = mean / volume;
  }
  return result;
}

template <int dim>
double CellIntegrals<dim>::largest_rotation(std::span<const double> u) const {
  double largest = 0;
  for (std::int32_t c = 0; c < num_cells_; ++c) {
    Matrix<dim> F = Matrix<dim>::Identity();
    for (int q = 0; q < points_per_cell_; ++q) {
      const std::size_t point = static_cast<std::size_t>(c) * points_per_cell_ + q;
      for (int a = 0; a < nodes_per_cell_; ++a) {
        const Eigen::Map<const Vector<dim>> u_a(u.data() +
                                                static_cast<std::size_t>(cell(c)[a]) * dim);
        F += u_a * gradients_[point * nodes_per_cell_ + a].transpose() / points_per_cell_;
      }
    }
    largest = std::max(largest, angle_of<dim>(F));
  }
  return largest;
}

template class CellIntegrals<2>;
template class CellIntegrals<3>;

}  // namespace gabion::fem
