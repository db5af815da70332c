// SPDX-License-Identifier: BSD-3-Clause
#include "mpm_solver/stress/internal_forces.hpp"

#include <algorithm>
#include <cmath>
#include <variant>

#include "common/base/require.hpp"
#include "common/mechanics/tensor_functions.hpp"

namespace gabion::mpm {

namespace {

// A first evaluation takes the tangent of the stresses from a state where no component of du
// differs by more than this share of a cell.
constexpr double same_tangent = 1e-4;

bool is_near(std::span<const double> x, const std::vector<double>& y, double distance) {
  if (x.size() != y.size()) return false;
  for (std::size_t k = 0; k < x.size(); ++k) {
    if (std::abs(x[k] - y[k]) > distance) return false;
  }
  return true;
}

}  // namespace

template <int dim>
InternalForces<dim>::InternalForces(const StressParts<dim>& parts, double cell_size,
                                    double same_strain, bool average_volumes, bool repeats)
    : parts_(parts), cell_size_(cell_size), given_same_strain_(same_strain), repeats_(repeats) {
  if (average_volumes) averaged_.emplace(parts);
  f_int_.resize(static_cast<std::size_t>(parts_.nodes.size()) * dim);
  parts_.trial.resize(parts_.points.size());
  forget();
}

template <int dim>
void InternalForces<dim>::forget() {
  du_known_.clear();
  du_K_.clear();
  const bool per_group = !averaged_ && parts_.weights.constant_gradient;
  known_.assign(per_group ? parts_.weights.groups.size() : 0, {});
  same_strain_ = given_same_strain_;
}

// V0 P and V0 dP/dH summed over the points of a cell that share one gradient.
template <int dim>
template <class Law>
bool InternalForces<dim>::group_stress(const Law& law, const GroupRequest& request,
                                       const Matrix<dim>& H) {
  const CellGroup& group = parts_.weights.groups[request.number];
  GroupStress& known = known_[request.number];
  known.is_known = false;
  known.H = H;
  known.P.setZero();
  known.A.setZero();
  stresses_.start(group.first, group.last);
  for (std::int32_t e = group.first; e < group.last; ++e) stresses_.H(e) = H;
  if (!stresses_.evaluate(parts_, law, request.with_K, request.worst)) return false;
  for (std::int32_t e = group.first; e < group.last; ++e) {
    const double V0 = parts_.points.V0[parts_.weights.point[e]];
    known.P += V0 * stresses_.P(e);
    if (request.with_K) known.A += V0 * stresses_.A(e);
  }
  known.is_known = true;
  known.has_A = request.with_K;
  return true;
}

// Forces and stiffness of a triangle or tetrahedron.
template <int dim>
template <class Law>
bool InternalForces<dim>::add_simplex(const Law& law, const GroupRequest& request) {
  const CellGroup& group = parts_.weights.groups[request.number];
  const std::uint8_t* local = parts_.weights.local_of(group.first);
  const Vector<dim>* grad = parts_.weights.grad_of(group.first);
  const int n = group.num_nodes;
  const Matrix<dim> H = gradient_of(request, group.first);
  GroupStress& known = known_[request.number];
  const Matrix<dim> change = H - known.H;
  const double size = change.cwiseAbs().maxCoeff();
  const bool near =
      known.is_known && (known.has_A ? size <= same_strain_ : size == 0 && !request.with_K);
  if (!near && !group_stress(law, request, H)) return false;
  request.sum.add_stress(n, local, known.P, grad);
  if (near && size > 0) {
    Matrix<dim> P_change;
    for (int aJ = 0; aJ < dim * dim; ++aJ) {
      double value = 0;
      for (int bL = 0; bL < dim * dim; ++bL) value += known.A(aJ, bL) * change(bL / dim, bL % dim);
      P_change(aJ / dim, aJ % dim) = value;
    }
    request.sum.add_stress(n, local, P_change, grad);
  }
  if (request.with_K) request.sum.add_tangent(n, local, n, known.A, grad);
  return true;
}

// Stresses of the points of cells that have gradients of their own.
template <int dim>
template <class Law>
bool InternalForces<dim>::find_stresses(const Law& law, const GroupRange& range,
                                        std::span<const double> du, bool with_K,
                                        std::int32_t& worst) {
  const auto& weights = parts_.weights;
  stresses_.start(weights.groups[range.first].first, weights.groups[range.last - 1].last);
  GroupDisplacements<dim> of_group;
  for (std::int32_t g = range.first; g < range.last; ++g) {
    const CellGroup& group = weights.groups[g];
    parts_.nodes.gather(weights.nodes_of(group), du, of_group.data());
    for (std::int32_t e = group.first; e < group.last; ++e) {
      stresses_.H(e) = displacement_gradient(weights, e, of_group.data());
    }
  }
  return stresses_.evaluate(parts_, law, with_K, worst);
}

// Forces and stiffness of these stresses.
template <int dim>
void InternalForces<dim>::add_points(const CellGroup& group, bool with_K,
                                     CellForces<dim>& sum) const {
  const auto& weights = parts_.weights;
  for (std::int32_t e = group.first; e < group.last; ++e) {
    const int n = weights.num_nodes(e);
    const std::uint8_t* local = weights.local_of(e);
    const double V0 = parts_.points.V0[weights.point[e]];
    sum.add_stress(n, local, V0 * stresses_.P(e), weights.grad_of(e));
    if (!with_K) continue;
    sum.add_tangent(n, local, group.num_nodes, V0 * stresses_.A(e), weights.grad_of(e));
  }
}

// f_int and its derivative of some cells of one body.
template <int dim>
template <class Law>
bool InternalForces<dim>::range_forces(const Law& law, const GroupRange& range,
                                       std::span<const double> du, BlockMatrix<dim>* K,
                                       std::int32_t& worst) {
  const auto& weights = parts_.weights;
  const bool with_K = K != nullptr, shared_gradient = weights.constant_gradient;
  if (!shared_gradient && !find_stresses(law, range, du, with_K, worst)) return false;
  CellForces<dim> sum;
  std::int32_t active[max_group_nodes<dim>];
  GroupDisplacements<dim> of_group;
  for (std::int32_t g = range.first; g < range.last; ++g) {
    const CellGroup& group = weights.groups[g];
    sum.set_zero(group.num_nodes, with_K);
    if (shared_gradient) {
      parts_.nodes.gather(weights.nodes_of(group), du, of_group.data());
      const GroupRequest request{
          .number = g, .du = of_group.data(), .with_K = with_K, .sum = sum, .worst = worst};
      if (!add_simplex(law, request)) return false;
    } else {
      add_points(group, with_K, sum);
    }
    parts_.nodes.list_active(weights.nodes_of(group), active);
    sum.scatter(group.num_nodes, active, f_int_.data());
    if (K) K->add_cell_blocks(g, sum.K);
  }
  return true;
}

// f_int and its derivative of the cells that hold points of one body.
template <int dim>
template <class Law>
bool InternalForces<dim>::body_forces(const Law& law, std::int32_t body, std::span<const double> du,
                                      BlockMatrix<dim>* K, std::int32_t& worst) {
  const std::int32_t last = parts_.weights.body_groups[body + 1];
  GroupRange range;
  for (range.first = parts_.weights.body_groups[body]; range.first < last;
       range.first = range.last) {
    range.last = std::min(range.first + groups_at_once, last);
    if (!range_forces(law, range, du, K, worst)) return false;
  }
  return true;
}

template <int dim>
bool InternalForces<dim>::all_forces(std::span<const double> du, BlockMatrix<dim>* K,
                                     std::int32_t& worst) {
  for (std::int32_t b = 0; b < parts_.points.num_bodies(); ++b) {
    const bool admissible =
        std::visit([&](const auto& law) { return body_forces(law, b, du, K, worst); },
                   parts_.bodies[b].material.law);
    if (!admissible) return false;
  }
  return true;
}

template <int dim>
bool InternalForces<dim>::evaluate(std::span<const double> du, BlockMatrix<dim>* K,
                                   std::int32_t& worst) {
  const double near = first_evaluation_ ? same_tangent * cell_size_ : 0;
  first_evaluation_ = false;
  if (std::ranges::equal(du, du_known_) && (!K || is_near(du, du_K_, near))) {
    neighbours_matrix_ = K && !std::ranges::equal(du, du_K_);
    if (K) std::copy(K_int_.begin(), K_int_.end(), K->values().begin());
    yielding_.add(parts_.trial.region);
    return true;
  }
  neighbours_matrix_ = false;
  du_known_.clear();
  std::fill(f_int_.begin(), f_int_.end(), 0.0);
  if (K) K->set_zero();
  const bool admissible = averaged_
                              ? averaged_->evaluate({.du = du, .K = K, .f = f_int_, .worst = worst})
                              : all_forces(du, K, worst);
  if (!admissible) return false;
  yielding_.add(parts_.trial.region);
  du_known_.assign(du.begin(), du.end());
  if (K && repeats_) {
    du_K_ = du_known_;
    K_int_.assign(K->values().begin(), K->values().end());
  }
  return true;
}

template <int dim>
std::vector<double> InternalForces<dim>::start_forces() const {
  if (averaged_) return averaged_->start_forces(f_int_.size());
  const auto& weights = parts_.weights;
  std::vector<double> f(f_int_.size(), 0.0);
  CellForces<dim> sum;
  std::int32_t active[max_group_nodes<dim>];
  for (const CellGroup& group : weights.groups) {
    parts_.nodes.list_active(weights.nodes_of(group), active);
    sum.set_zero(group.num_nodes, false);
    Matrix<dim> P = Matrix<dim>::Zero();
    for (std::int32_t e = group.first; e < group.last; ++e) {
      const std::int32_t p = weights.point[e];
      P += parts_.points.V0[p] * in_plane<dim>(parts_.points.tau[p]);
      if (weights.constant_gradient && e + 1 < group.last) continue;
      const std::int32_t row = weights.constant_gradient ? group.first : e;
      sum.add_stress(weights.num_nodes(row), weights.local_of(row), P, weights.grad_of(row));
      P.setZero();
    }
    sum.scatter(group.num_nodes, active, f.data());
  }
  return f;
}

template <int dim>
void InternalForces<dim>::finish(std::span<const double> du) {
  if (!averaged_ && parts_.weights.constant_gradient) {
    same_strain_ = 0;  // where stresses followed from their tangent, they are evaluated now
    du_known_.clear();
  }
  std::int32_t worst = -1;
  require(evaluate(du, nullptr, worst), "mpm_solver: an inadmissible state was accepted");
}

template class InternalForces<2>;
template class InternalForces<3>;

}  // namespace gabion::mpm
