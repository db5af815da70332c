// SPDX-License-Identifier: BSD-3-Clause
#include "mpm_solver/report/memory.hpp"

#include <algorithm>

#include "common/mechanics/ranks/sum.hpp"

namespace gabion::mpm {

namespace {

template <class Value>
double bytes_of(const std::vector<Value>& values) {
  return static_cast<double>(values.capacity() * sizeof(Value));
}

template <int dim>
double bytes_of(const MaterialPoints<dim>& points) {
  double sum = 0;
  for_each_field<dim>([&](const char*, auto field) { sum += bytes_of(points.*field); });
  return sum;
}

template <int dim>
double bytes_of(const PointWeights<dim>& weights) {
  return bytes_of(weights.point) + bytes_of(weights.starts) + bytes_of(weights.local) +
         bytes_of(weights.N) + bytes_of(weights.grad_N) + bytes_of(weights.groups) +
         bytes_of(weights.group_nodes) + bytes_of(weights.body_groups);
}

// Size of one entry of TrialPoints.
template <int dim>
double bytes_of_trial_point(bool with_internal) {
  return (with_internal ? sizeof(InternalState) : 0) + sizeof(MaterialState<dim>) +
         2 * sizeof(Symmetric<dim>) + 2 * sizeof(double) + sizeof(YieldRegion);
}

template <int dim>
double bytes_of(const GridNodes<dim>& nodes) {
  return bytes_of(nodes.grid_node) + static_cast<double>(nodes.active.bytes()) +
         bytes_of(nodes.of_groups) + bytes_of(nodes.x) + bytes_of(nodes.m) + bytes_of(nodes.v) +
         bytes_of(nodes.a);
}

// Bytes of the pattern; one rank: with PETSc's list of columns.
template <int dim>
double bytes_of_stiffness(const BlockMatrix<dim>& K, bool alone) {
  return static_cast<double>(K.columns().size()) *
         (dim * dim * sizeof(double) + (alone ? sizeof(std::int32_t) : 0));
}

}  // namespace

template <int dim>
void Memory<dim>::look(const SoilState<dim>& state, const SoilStep<dim>& step) {
  const PointWeights<dim>& weights = step.soil().weights();
  const GridNodes<dim>& nodes = step.soil().nodes();
  const BlockMatrix<dim>& K = step.implicit_steps().stiffness();
  const std::array<double, names_.size()> bytes = {
      bytes_of(state.points),
      bytes_of(weights),
      static_cast<double>(weights.point.size()) *
          bytes_of_trial_point<dim>(!state.points.internal.empty()),
      bytes_of(nodes),
      bytes_of_stiffness(K, nodes.shared.alone()),
      static_cast<double>(K.pattern_bytes()),
      step.implicit_steps().linear_solver().preconditioner_bytes()};
  for (std::size_t k = 0; k < bytes.size(); ++k) largest_[k] = std::max(largest_[k], bytes[k]);
}

template <int dim>
Json Memory<dim>::json(MPI_Comm comm) const {
  std::array<double, names_.size()> sums = largest_;
  sum_over_ranks(comm, std::span<double>(sums));
  Json result = Json::object();
  for (std::size_t k = 0; k < sums.size(); ++k) {
    result[names_[k]] = static_cast<std::int64_t>(sums[k]);
  }
  return result;
}

template class Memory<2>;
template class Memory<3>;

}  // namespace gabion::mpm
