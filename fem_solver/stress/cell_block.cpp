// SPDX-License-Identifier: BSD-3-Clause
#include "fem_solver/stress/cell_block.hpp"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <type_traits>
#include <utility>
#include <variant>

#include "common/mechanics/rotation_angle.hpp"
#include "fem_solver/stress/brick_kinematics.hpp"
#include "fem_solver/stress/crack_bands.hpp"
#include "fem_solver/stress/enhanced_cell.hpp"
#include "fem_solver/stress/point_stiffness.hpp"
#include "fem_solver/stress/point_update.hpp"
#include "fem_solver/stress/shell_kinematics.hpp"

namespace gabion::fem {

namespace {

/// Angle of the rotation R in F = R U [rad]; in 3D 0 below some 0.1 rad, where it is not needed.
template <int dim>
double angle_of(const Matrix<dim>& F) {
  if constexpr (dim == 3) {
    const Matrix<dim> skew = 0.5 * (F - F.transpose());
    if (skew.squaredNorm() < 2e-2 && F.trace() > 2.9) return 0;
  }
  return rotation_angle<dim>(F);
}

template <int dim>
Eigen::Map<const Vector<dim>> at(std::span<const double> u, std::int32_t node) {
  return Eigen::Map<const Vector<dim>>(u.data() + static_cast<std::size_t>(node) * dim);
}

/// f_a += P dN_a. Eigen's products become calls in the many instances of integrate(), not in here.
template <int dim, int nodes>
[[gnu::flatten, gnu::noinline]] void add_forces(const Matrix<dim>& P, const Vector<dim>* dN,
                                                Vector<dim>* f) {
  for (int a = 0; a < nodes; ++a) f[a] += P.lazyProduct(dN[a]);
}

/// H = sum_a u_a (x) dN_a; in the plane by component, which the compiler keeps in registers.
template <int dim, int nodes>
Matrix<dim> displacement_gradient(const Vector<dim>* dN, const Vector<dim>* u_cell) {
  Matrix<dim> H = Matrix<dim>::Zero();
  if constexpr (dim == 2) {
    double xx = 0, xy = 0, yx = 0, yy = 0;
    for (int a = 0; a < nodes; ++a) {
      xx += u_cell[a][0] * dN[a][0];
      xy += u_cell[a][0] * dN[a][1];
      yx += u_cell[a][1] * dN[a][0];
      yy += u_cell[a][1] * dN[a][1];
    }
    H << xx, xy, yx, yy;
  } else {
    for (int a = 0; a < nodes; ++a) H.noalias() += u_cell[a] * dN[a].transpose();
  }
  return H;
}

}  // namespace

template <int dim>
CellBlock<dim>::CellBlock(const Mesh<dim>& mesh, const CellMaterial<dim>& material,
                          std::vector<std::int32_t> cells, const MeshRanks& ranks)
    : material_(material),
      cells_(std::move(cells)),
      nodes_per_cell_(mesh.nodes_per_cell()),
      geometry_(cell_geometry<dim>(mesh, material_, cells_, ranks)),
      history_per_point_(static_cast<std::size_t>(fem::history_size<dim>(material.law))) {
  for (const std::int32_t c : cells_) {
    const auto nodes = mesh.cell(c);
    cell_nodes_.insert(cell_nodes_.end(), nodes.begin(), nodes.end());
  }
  bands_ = crack_bands<dim>(mesh, material_, cells_, ranks);
  history_width_ = history_per_point_ * static_cast<std::size_t>(geometry_.points_per_cell) +
                   (is_shell()      ? num_shell_modes
                    : is_enhanced() ? num_modes<dim>
                                    : 0) +
                   (may_fail() ? failure_numbers : 0);
}

/// The law, or its form in a cell.
template <int dim>
template <class Law>
decltype(auto) CellBlock<dim>::law_in(const Law& law, std::size_t c) const {
  if constexpr (std::same_as<Law, Concrete<dim>>) {
    return ConcreteOfCell<dim>{law, bands_[c]};
  } else {
    return (law);
  }
}

/// Keep the numbers of a cell that may fail in a step.
/// @param share  share_left()
template <int dim>
void CellBlock<dim>::keep_failure(std::size_t c, double share, HistoryStep history) const {
  if (!may_fail()) return;
  fem::keep_failure(share, history.part(c * history_width_, history_width_));
}

template <int dim>
template <int nodes, class Law>
StressIntegral CellBlock<dim>::integrate(const Law& law, std::span<const double> u,
                                         std::span<double> f_int, BlockMatrix<dim>* K,
                                         HistoryStep history) const {
  StressIntegral result;
  StressUpdate<dim> update;
  Tangent<dim> A;
  double K_cell[nodes * dim * nodes * dim];
  const auto num_cells = static_cast<std::int32_t>(cells_.size());
  for (std::int32_t c = 0; c < num_cells; ++c) {
    const double share = share_left(static_cast<std::size_t>(c), history.accepted);
    keep_failure(static_cast<std::size_t>(c), share, history);
    if (share == 0) continue;
    const std::int32_t* node = cell_nodes_.data() + static_cast<std::size_t>(c) * nodes;
    Vector<dim> u_cell[nodes], f_cell[nodes];
    for (int a = 0; a < nodes; ++a) {
      u_cell[a] = at<dim>(u, node[a]);
      f_cell[a].setZero();
    }
    if (K) std::fill(std::begin(K_cell), std::end(K_cell), 0.0);
    const auto& law_of_cell = law_in(law, static_cast<std::size_t>(c));
    for (int q = 0; q < geometry_.points_per_cell; ++q) {
      const std::size_t point = static_cast<std::size_t>(c) * geometry_.points_per_cell + q;
      const Vector<dim>* dN = geometry_.gradients.data() + point * nodes;
      const double w = share * geometry_.weights[point];
      const Matrix<dim> H = displacement_gradient<dim, nodes>(dN, u_cell);
      const HistoryStep of_point =
          LawWithHistory<Law>
              ? history.part(static_cast<std::size_t>(c) * history_width_ + q * history_per_point_,
                             history_per_point_)
              : HistoryStep{};
      if (!update_point<dim>(law_of_cell, H, of_point, update, K ? &A : nullptr)) {
        return {.inadmissible_cell = cells_[c], .fault = "det F <= 0", .energy = result.energy};
      }
      result.energy += w * update.energy;
      add_forces<dim, nodes>(w * update.P, dN, f_cell);
      if (K) add_point_stiffness<dim, nodes>(A, dN, w, K_cell);
    }
    for (int a = 0; a < nodes; ++a) {
      Eigen::Map<Vector<dim>>(f_int.data() + static_cast<std::size_t>(node[a]) * dim) += f_cell[a];
    }
    if (K) K->add_cell(cells_[c], K_cell);
  }
  return result;
}

template <int dim>
template <class Law, class Visit>
auto CellBlock<dim>::visit_enhanced(const Law& law, const Visit& visit) const {
  constexpr bool small = std::same_as<Law, LinearElastic<dim>>;
  if constexpr (dim == 3) {
    if (is_shell()) {
      return visit([&](std::size_t c) {
        const std::size_t point = c * geometry_.points_per_cell;
        using Kinematics = ShellKinematics<small>;
        return EnhancedCell<Law, Kinematics>(
            law, geometry_.shells.rule(c), geometry_.shells.shapes[c],
            geometry_.gradients.data() + point * Kinematics::num_nodes,
            geometry_.weights.data() + point);
      });
    }
  }
  return visit([&](std::size_t c) {
    using Kinematics = BrickKinematics<dim, small>;
    const std::size_t point = c * Kinematics::max_points;
    return EnhancedCell<Law, Kinematics>(
        law, typename Kinematics::Geometry{
                 .gradients = geometry_.gradients.data() + point * Kinematics::num_nodes,
                 .weights = geometry_.weights.data() + point,
                 .modes = geometry_.modes.data() + point});
  });
}

template <int dim>
template <class CellOf>
StressIntegral CellBlock<dim>::integrate_enhanced(const CellOf& cell_of, std::span<const double> u,
                                                  std::span<double> f_int, BlockMatrix<dim>* K,
                                                  HistoryStep history) const {
  using Cell = std::invoke_result_t<CellOf, std::size_t>;
  StressIntegral result;
  typename Cell::Stiffness K_cell;
  std::array<Vector<dim>, Cell::num_nodes> u_cell;
  for (std::size_t c = 0; c < cells_.size(); ++c) {
    const auto node = nodes_of(static_cast<std::int32_t>(c));
    for (int a = 0; a < Cell::num_nodes; ++a) u_cell[a] = at<dim>(u, node[a]);
    const double share = share_left(c, history.accepted);
    keep_failure(c, share, history);
    if (share == 0) continue;
    Cell cell = cell_of(c);
    const HistoryStep of_cell = history.part(c * history_width_, law_width());
    if (const char* fault = cell.balance(u_cell, of_cell.accepted, of_cell.trial)) {
      return {.inadmissible_cell = cells_[c], .fault = fault, .energy = result.energy};
    }
    result.energy += share * cell.energy();
    const typename Cell::Forces f = share * cell.forces();
    for (int a = 0; a < Cell::num_nodes; ++a) {
      Eigen::Map<Vector<dim>>(f_int.data() + static_cast<std::size_t>(node[a]) * dim) +=
          f.template segment<dim>(a * dim);
    }
    if (!K) continue;
    cell.find_stiffness(K_cell);
    if (share < 1) K_cell *= share;
    K->add_cell(cells_[c], K_cell.data());
  }
  return result;
}

template <int dim>
StressIntegral CellBlock<dim>::add_internal(std::span<const double> u, std::span<double> f_int,
                                            BlockMatrix<dim>* K, HistoryStep history) const {
  return std::visit(
      [&]<class Law>(const Law& law) {
        if constexpr (!std::same_as<Law, Concrete<dim>>) {
          if (is_enhanced()) {
            return visit_enhanced(law, [&](const auto& cell_of) {
              return integrate_enhanced(cell_of, u, f_int, K, history);
            });
          }
        }
        if constexpr (dim == 2) {
          switch (nodes_per_cell_) {
            case 3:
              return integrate<3>(law, u, f_int, K, history);
            case 4:
              return integrate<4>(law, u, f_int, K, history);
            case 6:
              return integrate<6>(law, u, f_int, K, history);
            case 8:
              return integrate<8>(law, u, f_int, K, history);
            default:
              assert(nodes_per_cell_ == 9);
              return integrate<9>(law, u, f_int, K, history);
          }
        } else {
          switch (nodes_per_cell_) {
            case 4:
              return integrate<4>(law, u, f_int, K, history);
            case 8:
              return integrate<8>(law, u, f_int, K, history);
            case 10:
              return integrate<10>(law, u, f_int, K, history);
            case 20:
              return integrate<20>(law, u, f_int, K, history);
            default:
              assert(nodes_per_cell_ == 27);
              return integrate<27>(law, u, f_int, K, history);
          }
        }
      },
      material_.law);
}

template <int dim>
Matrix<dim> CellBlock<dim>::gradient_at(std::int32_t c, int q, std::span<const double> u) const {
  const std::size_t point = static_cast<std::size_t>(c) * geometry_.points_per_cell + q;
  Matrix<dim> H = Matrix<dim>::Zero();
  for (int a = 0; a < nodes_per_cell_; ++a) {
    H += at<dim>(u, nodes_of(c)[a]) * geometry_.gradients[point * nodes_per_cell_ + a].transpose();
  }
  return H;
}

template <int dim>
template <class Law>
Symmetric<dim> CellBlock<dim>::mean_stress(const Law& law, std::int32_t c,
                                           std::span<const double> u,
                                           std::span<const double> history) const {
  Symmetric<dim> mean = Symmetric<dim>::Zero();
  double volume = 0;
  StressUpdate<dim> update;
  std::vector<double> unused(history.begin(), history.end());
  for (int q = 0; q < geometry_.points_per_cell; ++q) {
    const std::size_t point = static_cast<std::size_t>(c) * geometry_.points_per_cell + q;
    const HistoryStep of_point = HistoryStep{.accepted = history, .trial = unused}.part(
        q * history_per_point_, history_per_point_);
    update_point<dim>(law_in(law, static_cast<std::size_t>(c)), gradient_at(c, q, u), of_point,
                      update, nullptr);
    const bool small_strain = std::same_as<Law, LinearElastic<dim>>;
    mean += geometry_.weights[point] * update.tau / (small_strain ? 1.0 : update.J);
    volume += geometry_.weights[point];
  }
  return mean / volume;
}

template <int dim>
template <class CellOf>
Symmetric<dim> CellBlock<dim>::mean_enhanced_stress(const CellOf& cell_of, std::size_t c,
                                                    std::span<const double> u,
                                                    std::span<const double> history) const {
  auto cell = cell_of(c);
  std::array<Vector<dim>, decltype(cell)::num_nodes> u_cell;
  const auto nodes = nodes_of(static_cast<std::int32_t>(c));
  for (std::size_t a = 0; a < u_cell.size(); ++a) u_cell[a] = at<dim>(u, nodes[a]);
  std::vector<double> unused(history.begin(), history.end());
  if (cell.balance(u_cell, history, unused) != nullptr) {
    return Symmetric<dim>::Constant(std::nan(""));
  }
  Symmetric<dim> mean = Symmetric<dim>::Zero();
  double volume = 0;
  for (int q = 0; q < geometry_.points_per_cell; ++q) {
    const double w = geometry_.weights[c * geometry_.points_per_cell + q];
    mean += w * cell.kirchhoff_stress(q) / cell.volume_ratio(q);
    volume += w;
  }
  return mean / volume;
}

template <int dim>
void CellBlock<dim>::find_stresses(std::span<const double> u, std::span<const double> history,
                                   std::span<double> stresses) const {
  constexpr std::size_t size = symmetric_size<dim>;
  std::visit(
      [&]<class Law>(const Law& law) {
        for (std::size_t k = 0; k < cells_.size(); ++k) {
          const auto c = static_cast<std::int32_t>(k);
          const auto own = history.subspan(k * history_width_, law_width());
          const double share = share_left(k, history);
          Eigen::Map<Symmetric<dim>> mean(stresses.data() + cells_[k] * size);
          mean.setZero();
          if (share == 0) continue;
          if constexpr (!std::same_as<Law, Concrete<dim>>) {
            if (is_enhanced()) {
              visit_enhanced(law, [&](const auto& cell_of) {
                mean = share * mean_enhanced_stress(cell_of, k, u, own);
              });
              continue;
            }
          }
          mean = share * mean_stress(law, c, u, own);
        }
      },
      material_.law);
}

template <int dim>
double CellBlock<dim>::largest_rotation(std::span<const double> u) const {
  double largest = 0;
  if (!std::holds_alternative<LinearElastic<dim>>(material_.law)) return largest;
  for (std::size_t c = 0; c < cells_.size(); ++c) {
    Matrix<dim> F = Matrix<dim>::Identity();
    for (int q = 0; q < geometry_.points_per_cell; ++q) {
      F += gradient_at(static_cast<std::int32_t>(c), q, u) / geometry_.points_per_cell;
    }
    largest = std::max(largest, angle_of<dim>(F));
  }
  return largest;
}

template class CellBlock<2>;
template class CellBlock<3>;

}  // namespace gabion::fem
