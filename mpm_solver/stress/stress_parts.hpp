// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <span>
#include <string>
#include <variant>
#include <vector>

#include "common/mechanics/petsc/node_block.hpp"
#include "mpm_solver/grid/basis.hpp"
#include "mpm_solver/grid/entry_values.hpp"
#include "mpm_solver/grid/grid_nodes.hpp"
#include "mpm_solver/points/laws_of_points.hpp"
#include "mpm_solver/stress/step_context.hpp"
#include "mpm_solver/stress/trial_points.hpp"

namespace gabion::mpm {

/// A step that squeezes a point below this share of its volume is inadmissible.
inline constexpr double min_J_ratio = 0.1;

/// State of each point's material at the start of a substep, pulled back to the configuration at
/// the start of the step.
template <int dim>
struct MaterialPath {
  std::vector<MaterialState<dim>> history;
  std::vector<InternalState> internal;  ///< empty where MaterialPoints::internal is
  /// State variables of a Umat, and 1 + H of the step up to here: such a law is not pulled back.
  /// Empty where MaterialPoints::variables is.
  std::vector<StateVariables> variables;
  std::vector<Matrix<dim>> F;
};

/// A material point whose law gives no stress.
struct RefusedPoint {
  std::int32_t point = -1;  ///< -1: none of this rank
  Refusal refusal = Refusal::squeezed;
};

/// The fault of the point in words, to follow its name.
std::string refusal_text(Refusal refusal);

/// Nodal forces of some groups, kept as they are found.
template <int dim>
struct GroupForces {
  std::vector<std::int32_t> place;  ///< of each group: where its values begin, -1: it is not kept;
                                    ///< empty: none is
  std::vector<double> values;       ///< of the nodes of a group, dim each [N]
};

/// Data on which the stresses of one rank's material points depend, and their destination.
///
/// A solution in substeps has a `path`. Every evaluation then begins there, and replaces it by what
/// it found. Without (null or empty), all begin at points.history and points.internal.
///
/// `held_normal` is WallConditions::held_normal, null where there is none.
///
/// `kept` (null: nothing) takes what the groups that it names add to the internal forces.
///
/// `laws` are those of points whose constants vary (PointLaws).
///
/// `context` is that of the current step or substep; only bodies of a ContextualLaw need it.
template <int dim>
struct StressParts {
  const std::vector<Body<dim>>& bodies;
  const MaterialPoints<dim>& points;
  const PointWeights<dim>& weights;
  const GridNodes<dim>& nodes;
  TrialPoints<dim>& trial;
  MaterialPath<dim>* path = nullptr;
  const StepContext<dim>* context = nullptr;
  const Vector<dim>* held_normal = nullptr;
  GroupForces<dim>* kept = nullptr;
  /// Law of each point, null: that of its body; empty: every point has that of its body.
  LawsOfPoints<dim> laws = {};

  /// @param own  that of its body
  template <class Law>
  const Law& law_of(std::int32_t p, const Law& own) const {
    return laws.empty() || laws[p] == nullptr ? own : std::get<Law>(*laws[p]);
  }
  bool has_path() const { return path && !path->history.empty(); }
};

/// Room for the displacements of a group's nodes.
template <int dim>
using GroupDisplacements = std::array<double, max_group_nodes<dim> * dim>;

/// Consecutive groups of one body.
struct GroupRange {
  std::int32_t first, last;
};

/// H of one entry of a group, sum_i du_i (x) grad N_ip.
/// @tparam num_nodes  see EntryValues
/// @param du          of the group's nodes [m], dim each
template <int dim, int num_nodes = 0>
inline Matrix<dim> displacement_gradient(const PointWeights<dim>& weights, std::int32_t entry,
                                         const double* du) {
  const EntryValues<dim, num_nodes> values(weights, entry);
  const int n = num_nodes > 0 ? num_nodes : values.n;
  BlockVector<dim> sum = BlockVector<dim>::zero();
  for (int i = 0; i < n; ++i) {
    sum += BlockVector<dim>::rows(du + values.number(i) * dim) *
           BlockVector<dim>::columns(values.grad[i].data());
  }
  Matrix<dim> H;
  sum.store(H.data());
  return H;
}

}  // namespace gabion::mpm
