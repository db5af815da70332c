// SPDX-License-Identifier: BSD-3-Clause
#include "mpm_solver/stress/internal_forces.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <variant>

#include "common/base/require.hpp"
#include "common/mechanics/tensor_functions.hpp"
#include "mpm_solver/stress/averaged_forces.hpp"
#include "mpm_solver/stress/cell_sums.hpp"
#include "mpm_solver/stress/point_stresses.hpp"

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

std::string refusal_text(Refusal refusal) {
  if (refusal == Refusal::squeezed) {
    return fmt::format("would be squeezed below {} of its volume", min_J_ratio);
  }
  if (refusal == Refusal::pores_closed) return "would be squeezed until its pores are closed";
  return "strains more in this step than its law can follow";
}

/// Room for the points and the cell at hand.
template <int dim>
struct InternalForces<dim>::Work {
  using Terms = PointTerms<dim, 1>;
  PointStresses<dim> stresses;
  std::vector<Terms> terms;  // of the same points

  /// Order what the points add to forces and stiffness.
  void order_terms(const StressParts<dim>& parts, bool with_K) {
    terms.resize(stresses.batches().size() * PointBatch<dim>::size);
    Terms* of_batch = terms.data();
    for (std::size_t b = 0; b < stresses.batches().size(); ++b, of_batch += num_lanes) {
      PointBatch<dim>& batch = stresses.batches()[b];
      const Lanes V0 = stresses.V0(parts, b);
      for (Lanes& P : batch.P) P *= V0;
      spread_stress(batch.P, of_batch);
      if (!with_K) continue;
      for (Lanes& A : batch.A) A *= V0;
      spread_tangent(batch.A, of_batch);
    }
  }
};

template <int dim>
InternalForces<dim>::InternalForces(const StressParts<dim>& parts, double cell_size,
                                    double same_strain, bool average_volumes, bool repeats)
    : parts_(parts),
      cell_size_(cell_size),
      given_same_strain_(same_strain),
      work_(std::make_unique<Work>()),
      repeats_(repeats) {
  if (average_volumes) averaged_ = std::make_unique<AveragedForces<dim>>(parts);
  f_int_.resize(static_cast<std::size_t>(parts_.nodes.size()) * dim);
  parts_.trial.resize(parts_.points);
  forget();
}

template <int dim>
InternalForces<dim>::~InternalForces() = default;

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
bool InternalForces<dim>::group_stress(const Law& law, std::int32_t g, const Matrix<dim>& H,
                                       const Request& request) {
  const CellGroup& group = parts_.weights.groups[g];
  const bool with_K = request.K != nullptr;
  GroupStress& known = known_[g];
  known = {.is_known = false, .has_A = with_K, .H = H};
  PointStresses<dim>& stresses = work_->stresses;
  stresses.start(group.body, group.first, group.last);
  for (std::int32_t e = group.first; e < group.last; ++e) stresses.set_gradient(e, H);
  if (!stresses.evaluate(parts_, law, with_K, request.worst)) return false;
  for (std::int32_t e = group.first; e < group.last; ++e) {
    const double V0 = parts_.weights.volume[e];
    known.P += V0 * stresses.P(e);
    if (with_K) known.A += V0 * stresses.A(e);
  }
  known.is_known = true;
  return true;
}

// Stress of a triangle or tetrahedron at H, null: inadmissible.
template <int dim>
template <class Law>
bool InternalForces<dim>::simplex_stress(const Law& law, std::int32_t g, const Matrix<dim>& H,
                                         const Request& request, Matrix<dim>& P) {
  const GroupStress& known = known_[g];
  const Matrix<dim> change = H - known.H;
  const double size = change.cwiseAbs().maxCoeff();
  const bool near =
      known.is_known && (known.has_A ? size <= same_strain_ : size == 0 && !request.K);
  if (!near && !group_stress(law, g, H, request)) return false;
  P = known.P;
  if (!near || size == 0) return true;
  for (int aJ = 0; aJ < dim * dim; ++aJ) {
    for (int bL = 0; bL < dim * dim; ++bL) {
      P(aJ / dim, aJ % dim) += known.A(aJ, bL) * change(bL / dim, bL % dim);
    }
  }
  return true;
}

// f_int and its derivative of triangles or tetrahedra with the linear basis.
template <int dim>
template <class Law>
bool InternalForces<dim>::simplex_forces(const Law& law, const GroupRange& range,
                                         const Request& request) {
  constexpr int n = dim + 1;
  const auto& weights = parts_.weights;
  CellSums<dim, 1, n> sums;
  PointTerms<dim, 1> terms;
  GroupDisplacements<dim> of_group;
  for (std::int32_t g = range.first; g < range.last; ++g) {
    const CellGroup& group = weights.groups[g];
    parts_.nodes.gather(weights.nodes_of(group), request.du, of_group.data());
    const Matrix<dim> H = displacement_gradient<dim, n>(weights, group.first, of_group.data());
    Matrix<dim> P;
    if (!simplex_stress(law, g, H, request, P)) return false;
    terms.set_stress(P);
    if (request.K) terms.set_tangent(known_[g].A);
    sums.start(n);
    sums.add_forces(weights, group.first, terms);
    sums.scatter(parts_, group, f_int_.data());
    if (!request.K) continue;
    sums.K.start(n, request.K->cell_blocks(g));
    sums.add_stiffness(weights, group.first, terms);
    sums.K.finish();
  }
  return true;
}

// Stresses of the points of cells that have gradients of their own.
template <int dim>
template <int n, class Law>
bool InternalForces<dim>::find_terms(const Law& law, const GroupRange& range,
                                     const Request& request) {
  PointStresses<dim>& stresses = work_->stresses;
  stresses.start(parts_.weights, range);
  stresses.template set_gradients<n>(parts_, range, request.du);
  if (!stresses.evaluate(parts_, law, request.K != nullptr, request.worst)) return false;
  work_->order_terms(parts_, request.K != nullptr);
  return true;
}

// f_int and its derivative of cells whose points have gradients of their own.
template <int dim>
template <int n, class Law>
bool InternalForces<dim>::point_forces(const Law& law, const GroupRange& range,
                                       const Request& request) {
  if (!find_terms<n>(law, range, request)) return false;
  const auto& weights = parts_.weights;
  CellSums<dim, 1, n> sums;
  const PointTerms<dim, 1>* terms = work_->terms.data();
  for (std::int32_t g = range.first; g < range.last; ++g) {
    const CellGroup& group = weights.groups[g];
    sums.start(group.num_nodes);
    if (request.K) sums.K.start(group.num_nodes, request.K->cell_blocks(g));
    for (std::int32_t e = group.first; e < group.last; ++e, ++terms) {
      sums.add_forces(weights, e, *terms);
      if (request.K) sums.add_stiffness(weights, e, *terms);
    }
    sums.scatter(parts_, group, f_int_.data());
    if (request.K) sums.K.finish();
  }
  return true;
}

// f_int and its derivative of some cells of one body.
template <int dim>
template <class Law>
bool InternalForces<dim>::range_forces(const Law& law, const GroupRange& range,
                                       const Request& request) {
  const auto& weights = parts_.weights;
  if (weights.constant_gradient) return simplex_forces(law, range, request);
  return weights.whole_cells ? point_forces<num_brick_nodes<dim>>(law, range, request)
                             : point_forces<0>(law, range, request);
}

template <int dim>
bool InternalForces<dim>::forces_of(const GroupRange& range, const Request& request) {
  if (averaged_) {
    return averaged_->evaluate(
        range, {.du = request.du, .K = request.K, .f = f_int_, .worst = request.worst});
  }
  const Body<dim>& body = parts_.bodies[parts_.weights.groups[range.first].body];
  return std::visit([&](const auto& law) { return range_forces(law, range, request); },
                    body.material.law);
}

template <int dim>
void InternalForces<dim>::add_known(std::int32_t g, const double* forces) {
  const CellGroup& group = parts_.weights.groups[g];
  std::int32_t active[max_group_nodes<dim>];
  parts_.nodes.list_active(parts_.weights.nodes_of(group), active);
  for (int i = 0; i < group.num_nodes; ++i) {
    for (int d = 0; d < dim; ++d) f_int_[std::size_t(active[i]) * dim + d] += forces[i * dim + d];
  }
}

template <int dim>
bool InternalForces<dim>::evaluate_part(std::span<const double> du, const ForcePart& part,
                                        RefusedPoint& worst) {
  require(!parts_.weights.constant_gradient, "mpm_solver: a part without gradients of each point");
  du_known_.clear();
  std::fill(f_int_.begin(), f_int_.end(), 0.0);
  const double* forces = part.known_forces.data();
  std::size_t k = 0;
  const auto add_known_before = [&](std::int32_t end) {
    for (; k < part.known.size() && part.known[k] < end; ++k) {
      add_known(part.known[k], forces);
      forces += parts_.weights.groups[part.known[k]].num_nodes * dim;
    }
  };
  for (const GroupRange& range : part.ranges) {
    add_known_before(range.first);
    if (!forces_of(range, {.du = du, .K = nullptr, .worst = worst})) return false;
  }
  add_known_before(static_cast<std::int32_t>(parts_.weights.groups.size()));
  return true;
}

template <int dim>
bool InternalForces<dim>::all_forces(const Request& request) {
  return for_each_range(parts_, [&](const Body<dim>& body, const GroupRange& range) {
    return std::visit([&](const auto& law) { return range_forces(law, range, request); },
                      body.material.law);
  });
}

template <int dim>
bool InternalForces<dim>::evaluate(std::span<const double> du, BlockMatrix<dim>* K,
                                   RefusedPoint& worst) {
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
                              : all_forces({.du = du, .K = K, .worst = worst});
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
  PointTerms<dim, 1> share;
  std::int32_t active[max_group_nodes<dim>];
  with_num_nodes(weights, [&]<int n>() {
    NodalSums<dim, 1, n> sum;
    for (const CellGroup& group : weights.groups) {
      parts_.nodes.list_active(weights.nodes_of(group), active);
      sum.start(group.num_nodes);
      Matrix<dim> P = Matrix<dim>::Zero();
      for (std::int32_t e = group.first; e < group.last; ++e) {
        P += weights.volume[e] * in_plane<dim>(parts_.points.tau[weights.point[e]]);
        if (weights.constant_gradient && e + 1 < group.last) continue;
        const EntryValues<dim, n> values(weights, weights.constant_gradient ? group.first : e);
        share.set_stress(P);
        sum.add(values.n, values.local, values.grad, share.nodal[0]);
        P.setZero();
      }
      sum.scatter(group.num_nodes, active, f.data());
    }
  });
  return f;
}

template <int dim>
void InternalForces<dim>::finish(std::span<const double> du) {
  if (!averaged_ && parts_.weights.constant_gradient) {
    same_strain_ = 0;  // where stresses followed from their tangent, they are evaluated now
    du_known_.clear();
  }
  RefusedPoint worst;
  require(evaluate(du, nullptr, worst), "mpm_solver: an inadmissible state was accepted");
}

template class InternalForces<2>;
template class InternalForces<3>;

}  // namespace gabion::mpm
