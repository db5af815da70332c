// SPDX-License-Identifier: BSD-3-Clause
#include "mpm_solver/step/seepage_balance.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "common/base/require.hpp"

namespace gabion::mpm {

template <int dim>
SeepageBalance<dim>::SeepageBalance(Equilibrium<dim>& equilibrium, SeepageForces<dim>& water,
                                    BlockMatrix<dim>& K_uu, const DrainedNodes& drained)
    : equilibrium_(equilibrium),
      water_(water),
      K_uu_(K_uu),
      scale_(water.modulus() / equilibrium.increment_scale()),
      q_start_(water.start_heads()) {
  // Nodes of dry soil have no pressure.
  for (const char wet : water_.wet()) held_.push_back(wet ? 0 : 1);
  p_drained_.assign(held_.size(), 0.0);
  for (std::size_t k = 0; k < drained.nodes.size(); ++k) {
    const std::int32_t i = drained.nodes[k];
    if (held_[i] != 0) continue;
    held_[i] = 2;
    q_start_[i] = drained.q[k];
    p_drained_[i] = drained.p[k];
  }
}

template <int dim>
std::vector<double> SeepageBalance<dim>::guess(std::span<const double> du) const {
  std::vector<double> x(q_start_.size() * block_size, 0.0);
  for (std::size_t k = 0; k < du.size(); ++k) x[k / dim * block_size + k % dim] = du[k];
  return x;
}

template <int dim>
std::vector<double> SeepageBalance<dim>::displacement(std::span<const double> x) const {
  std::vector<double> du(q_start_.size() * dim);
  for (std::size_t k = 0; k < du.size(); ++k) du[k] = x[k / dim * block_size + k % dim];
  return du;
}

template <int dim>
std::string SeepageBalance<dim>::describe_worst_point(std::span<const double> x) const {
  return equilibrium_.describe_worst_point(displacement(x));
}

template <int dim>
Evaluation SeepageBalance<dim>::evaluate(std::span<const double> x, std::span<double> r,
                                         BlockMatrix<block_size>* K) {
  const std::vector<double> du = displacement(x);
  q_ = q_start_;
  for (std::size_t i = 0; i < q_.size(); ++i) q_[i] += x[i * block_size + dim] * scale_;
  Evaluation result;
  RefusedPoint worst;
  if (K) K->set_zero();
  if (!water_.evaluate({.du = du, .q = q_}, K, worst)) {
    result.admissible = false;
    result.reason = shared().first_text(
        worst.point < 0 ? ""
                        : fmt::format("{} {}", equilibrium_.describe_point(worst.point),
                                      refusal_text(worst.refusal)));
    return result;
  }
  r_u_.resize(du.size());
  result = equilibrium_.evaluate(du, r_u_, K ? &K_uu_ : nullptr);
  result.likely_last = false;  // water is not linear, even where the soil was
  if (!result.admissible) return result;
  for (std::size_t k = 0; k < du.size(); ++k) r[k / dim * block_size + k % dim] = r_u_[k];
  outflow_ = drained_work_ = 0;
  for (std::size_t i = 0; i < q_.size(); ++i) {
    const double missing = water_.volumes()[i];
    if (held_[i] == 2 && shared().owns(static_cast<std::int32_t>(i))) {
      outflow_ -= missing;
      drained_work_ += missing * p_drained_[i];
    }
    r[i * block_size + dim] = held_[i] != 0 ? 0 : scale_ * missing;
  }
  outflow_ = shared().total(outflow_);
  result.residual_norm = shared().norm(r);
  result.force_scale = std::max(result.force_scale, scale_ * water_.volume_scale());
  if (!std::isfinite(*result.residual_norm)) {
    result.admissible = false;
    result.reason = "pressures are not finite";
  }
  if (K) {
    add_equilibrium(*K);
    constrain(*K);
  }
  return result;
}

// Add the part of the skeleton to that of the water, whose rows are scaled by M / h and whose
// pressures by h / M.
template <int dim>
void SeepageBalance<dim>::add_equilibrium(BlockMatrix<block_size>& K) const {
  require(std::ranges::equal(K.columns(), K_uu_.columns()), "mpm_solver: two patterns of a step");
  constexpr int size = block_size * block_size;
  double* block = K.values().data();
  const double* added = K_uu_.values().data();
  for (std::size_t s = 0; s < K.columns().size(); ++s, block += size, added += dim * dim) {
    for (int c = 0; c < dim; ++c) {
      for (int d = 0; d < dim; ++d) block[c * block_size + d] += added[c * dim + d];
      block[c * block_size + dim] *= scale_;
      block[dim * block_size + c] *= scale_;
    }
    block[dim * block_size + dim] *= scale_ * scale_;
  }
}

template <int dim>
void SeepageBalance<dim>::constrain(BlockMatrix<block_size>& K) const {
  const auto& walls = equilibrium_.parts().walls;
  std::vector<NodeBlock<block_size>> of_node;
  std::vector<std::int32_t> nodes;
  std::vector<std::int32_t> place(held_.size(), -1);
  const auto add = [&](std::int32_t i) -> NodeBlock<block_size>& {
    if (place[i] < 0) {
      place[i] = static_cast<std::int32_t>(nodes.size());
      nodes.push_back(i);
      of_node.push_back(NodeBlock<block_size>::Identity());
    }
    return of_node[place[i]];
  };
  for (std::size_t k = 0; k < walls.constrained().size(); ++k) {
    add(walls.constrained()[k]).template topLeftCorner<dim, dim>() = walls.projectors()[k];
  }
  for (std::size_t i = 0; i < held_.size(); ++i) {
    if (held_[i] != 0) add(static_cast<std::int32_t>(i))(dim, dim) = 0;
  }
  K.constrain(nodes, of_node, [this](std::int32_t i) { return shared().owns(i); });
}

template class SeepageBalance<2>;
template class SeepageBalance<3>;

}  // namespace gabion::mpm
