// SPDX-License-Identifier: BSD-3-Clause
#include "mpm_solver/stress/yielding_points.hpp"

#include <algorithm>
#include <variant>

#include "mpm_solver/stress/cell_stiffness.hpp"
#include "mpm_solver/stress/point_terms.hpp"

namespace gabion::mpm {

namespace {

// dP/dH of linear elasticity [Pa].
template <int dim>
Tangent<dim> elastic_tangent(const MaterialLaw<dim>& law) {
  const auto [M, mu] = std::visit(
      [](const auto& model) { return std::pair(model.p_wave_modulus(), model.shear_modulus()); },
      law);
  Tangent<dim> A = Tangent<dim>::Zero();
  for (int i = 0; i < dim; ++i) {
    for (int j = 0; j < dim; ++j) {
      A(i * dim + i, j * dim + j) += M - 2 * mu;
      A(i * dim + j, i * dim + j) += mu;
      A(i * dim + j, j * dim + i) += mu;
    }
  }
  return A;
}

}  // namespace

template <int dim>
void YieldingPoints<dim>::add(const std::vector<YieldRegion>& region) {
  yielded_.resize(region.size(), 0);
  std::uint8_t* const yielded = yielded_.data();  // a loop over bytes that the compiler can widen
  const YieldRegion* const at = region.data();
  const std::size_t count = region.size();
  for (std::size_t e = 0; e < count; ++e) yielded[e] |= at[e] == YieldRegion::elastic ? 0 : 1;
}

template <int dim>
bool YieldingPoints<dim>::any() const {
  return std::find(yielded_.begin(), yielded_.end(), 1) != yielded_.end();
}

template <int dim>
void YieldingPoints<dim>::add_stiffness(double share, const StressParts<dim>& parts,
                                        BlockMatrix<dim>& K) const {
  if (!any()) return;
  const PointWeights<dim>& weights = parts.weights;
  CellStiffness<dim> sum;
  PointTerms<dim, 1> of_point;
  for (std::size_t g = 0; g < weights.groups.size(); ++g) {
    const CellGroup& group = weights.groups[g];
    const auto first = yielded_.begin() + group.first, last = yielded_.begin() + group.last;
    if (std::find(first, last, 1) == last) continue;
    const MaterialLaw<dim>& own = parts.bodies[group.body].material.law;
    Tangent<dim> A = share * elastic_tangent<dim>(own);
    sum.start(group.num_nodes, K.cell_blocks(static_cast<std::int32_t>(g)));
    for (std::int32_t e = group.first; e < group.last; ++e) {
      if (!yielded_[e]) continue;
      const std::int32_t row = weights.constant_gradient ? group.first : e;
      const std::int32_t p = weights.point[e];
      if (!parts.laws.empty() && parts.laws[p] != nullptr) {
        A = share * elastic_tangent<dim>(*parts.laws[p]);
      }
      of_point.set_tangent(weights.volume[e] * A);
      sum.add_point(weights.num_nodes(row), weights.local_of(row), weights.grad_of(row),
                    of_point.A);
    }
    sum.finish();
  }
}

template class YieldingPoints<2>;
template class YieldingPoints<3>;

}  // namespace gabion::mpm
