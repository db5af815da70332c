// SPDX-License-Identifier: BSD-3-Clause
#include "mpm_solver/report/memory.hpp"

#include <array>

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

// Of one entry of TrialPoints: they may have been given up since the last step.
template <int dim>
constexpr double bytes_of_trial_point() {
  return sizeof(MaterialState<dim>) + 2 * sizeof(Symmetric<dim>) + 2 * sizeof(double) +
         sizeof(YieldRegion);
}

template <int dim>
double bytes_of(const GridNodes<dim>& nodes) {
  return bytes_of(nodes.grid_node) + bytes_of(nodes.active) + bytes_of(nodes.listed) +
         bytes_of(nodes.x) + bytes_of(nodes.m) + bytes_of(nodes.v) + bytes_of(nodes.a);
}

template <int dim>
double bytes_of_stiffness(MPI_Comm comm, const BlockMatrix<dim>& K) {
  const int copies = num_ranks(comm) > 1 ? 2 : 1;
  return static_cast<double>(copies * K.columns().size()) *
         (dim * dim * sizeof(double) + sizeof(std::int32_t));
}

}  // namespace

template <int dim>
Json memory_by_field(const SoilModel<dim>& model, const SoilState<dim>& state,
                     const SoilStep<dim>& step) {
  static constexpr std::array names = {"points",    "weights", "trial",         "nodes",
                                       "stiffness", "pattern", "preconditioner"};
  const PointWeights<dim>& weights = step.soil().weights();
  const BlockMatrix<dim>& K = step.stiffness();
  std::array<double, names.size()> bytes = {
      bytes_of(state.points),
      bytes_of(weights),
      static_cast<double>(weights.point.size()) * bytes_of_trial_point<dim>(),
      bytes_of(step.soil().nodes()),
      bytes_of_stiffness(model.comm, K),
      static_cast<double>(K.pattern_bytes()),
      step.linear_solver().preconditioner_bytes()};
  sum_over_ranks(model.comm, std::span<double>(bytes));
  Json result = Json::object();
  for (std::size_t k = 0; k < names.size(); ++k) {
    result[names[k]] = static_cast<std::int64_t>(bytes[k]);
  }
  return result;
}

template Json memory_by_field<2>(const SoilModel<2>&, const SoilState<2>&, const SoilStep<2>&);
template Json memory_by_field<3>(const SoilModel<3>&, const SoilState<3>&, const SoilStep<3>&);

}  // namespace gabion::mpm
