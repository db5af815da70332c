// SPDX-License-Identifier: BSD-3-Clause
#include "mpm_solver/step/steady_seepage.hpp"

#include <algorithm>
#include <cmath>

#include "common/base/require.hpp"
#include "mpm_solver/checks/seepage.hpp"
#include "mpm_solver/points/retention.hpp"

namespace gabion::mpm {

template <int dim>
RigidSeepage<dim>::RigidSeepage(const Equilibrium<dim>& equilibrium, SeepageForces<dim>& water,
                                const DrainedNodes& drained, double unit_volume)
    : equilibrium_(equilibrium),
      water_(water),
      unit_volume_(unit_volume),
      scale_(water.modulus() / equilibrium.increment_scale()),
      q_start_(water.start_heads()),
      still_(q_start_.size() * dim, 0.0) {
  for (const char wet : water_.wet()) held_.push_back(wet ? 0 : 1);
  for (std::size_t k = 0; k < drained.nodes.size(); ++k) {
    const std::int32_t i = drained.nodes[k];
    if (held_[i] != 0) continue;
    held_[i] = 2;
    q_start_[i] = drained.q[k];
  }
}

template <int dim>
Evaluation RigidSeepage<dim>::evaluate(std::span<const double> x, std::span<double> r,
                                       BlockMatrix<block_size>* K) {
  q_ = q_start_;
  for (std::size_t i = 0; i < q_.size(); ++i) q_[i] += x[i * block_size + dim] * scale_;
  Evaluation result;
  RefusedPoint worst;
  if (K) K->set_zero();
  if (!water_.evaluate({.du = still_, .q = q_}, K, worst)) {
    result.admissible = false;
    result.reason = shared().first_text(
        worst.point < 0 ? "" : equilibrium_.describe_point(worst.point) + " has no pores");
    return result;
  }
  std::ranges::fill(r, 0.0);
  for (std::size_t i = 0; i < q_.size(); ++i) {
    if (held_[i] == 0) r[i * block_size + dim] = scale_ * water_.volumes()[i];
  }
  result.residual_norm = shared().norm(r);
  result.force_scale = scale_ * std::max(unit_volume_, water_.volume_scale());
  if (!std::isfinite(*result.residual_norm)) {
    result.admissible = false;
    result.reason = "pressures are not finite";
  }
  if (K) constrain(*K);
  return result;
}

template <int dim>
void RigidSeepage<dim>::constrain(BlockMatrix<block_size>& K) const {
  double* block = K.values().data();
  for (std::size_t s = 0; s < K.columns().size(); ++s, block += block_size * block_size) {
    block[dim * block_size + dim] *= scale_ * scale_;
  }
  std::vector<std::int32_t> nodes;
  std::vector<NodeBlock<block_size>> free;
  for (std::size_t i = 0; i < held_.size(); ++i) {
    nodes.push_back(static_cast<std::int32_t>(i));
    free.push_back(NodeBlock<block_size>::Zero());
    if (held_[i] == 0) free.back()(dim, dim) = 1;
  }
  K.constrain(nodes, free, [this](std::int32_t i) { return shared().owns(i); });
}

template <int dim>
double RigidSeepage<dim>::leaving() const {
  double sum = water_.leaving();
  for (std::size_t i = 0; i < held_.size(); ++i) {
    if (held_[i] != 2 || !shared().owns(static_cast<std::int32_t>(i))) continue;
    sum += std::max(0.0, -water_.volumes()[i]);
  }
  return shared().total(sum);
}

template <int dim>
void change_pressures(const std::vector<Body<dim>>& bodies, double by,
                      MaterialPoints<dim>& points) {
  for (std::size_t b = 0; b < bodies.size(); ++b) {
    if (!drains(bodies[b])) continue;
    const PoreWater& water = *bodies[b].water;
    for (std::int32_t p = points.body_starts[b]; p < points.body_starts[b + 1]; ++p) {
      const double pressure = water_pressure(water, points.water[p], points.J[p]) + by;
      points.water[p] = water.content_at(pressure, points.J[p]);
    }
  }
}

template <int dim>
double head_at(const BoxGrid<dim>& box, const HeadsOfNodes& heads, const Vector<dim>& x) {
  const Vector<dim> t = box.lattice_position(x);
  double sum = 0, shares = 0;
  for (int corner = 0; corner < (1 << dim); ++corner) {
    typename BoxGrid<dim>::Index at;
    double share = 1;
    for (int d = 0; d < dim; ++d) {
      const int up = (corner >> d) & 1;
      const int cell = std::clamp(static_cast<int>(std::floor(t[d])), 0, box.num_cells[d] - 1);
      const double s = std::clamp(t[d] - cell, 0.0, 1.0);
      at[d] = cell + up;
      share *= up != 0 ? s : 1 - s;
    }
    const auto head = heads.find(box.node(at));
    if (head == heads.end()) continue;
    sum += share * head->second;
    shares += share;
  }
  require(shares > 0, "mpm_solver: no node with water about a place where soil rests");
  return sum / shares;
}

template class RigidSeepage<2>;
template class RigidSeepage<3>;
template void change_pressures<2>(const std::vector<Body<2>>&, double, MaterialPoints<2>&);
template void change_pressures<3>(const std::vector<Body<3>>&, double, MaterialPoints<3>&);
template double head_at<2>(const BoxGrid<2>&, const HeadsOfNodes&, const Vector<2>&);
template double head_at<3>(const BoxGrid<3>&, const HeadsOfNodes&, const Vector<3>&);

}  // namespace gabion::mpm
