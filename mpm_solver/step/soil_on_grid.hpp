// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "common/base/timer.hpp"
#include "mpm_solver/contact/side_fields.hpp"
#include "mpm_solver/parameters/point_laws.hpp"
#include "mpm_solver/small_cuts/ghost_stiffness.hpp"
#include "mpm_solver/small_cuts/weak_nodes.hpp"
#include "mpm_solver/step/soil_state.hpp"
#include "mpm_solver/stress/cell_quadrature.hpp"
#include "mpm_solver/walls/inelastic_projection.hpp"

namespace gabion::mpm {

/// Counts of the cures of small cuts over all steps.
struct SmallCutCounts {
  std::int64_t joined_nodes = 0;
  std::int64_t ghost_steps = 0;  ///< in which a cell needed ghost stiffness
  std::int64_t ghost_facets = 0;
};

/// The soil on the nodes of its grid in the current step: weights of the points, active nodes with
/// mass and motion, their walls, and the cures of small cuts. Refers to model, state and times.
/// Functions are collective.
template <int dim>
class SoilOnGrid {
 public:
  SoilOnGrid(const SoilModel<dim>& model, const SoilState<dim>& state, PhaseTimes& times);

  /// Evaluate the basis at the points, and find their laws.
  void weigh();
  /// Weigh the points, map their mass and motion to the nodes, and let the walls stop them.
  struct Mapping {
    std::size_t phase;  ///< number, whose walls act
    double dt;          ///< of the step [s]
    bool with_inertia;  ///< of the step
    /// Grid nodes that this rank needs besides those of its points.
    std::vector<std::int32_t> other_nodes = {};
  };
  void map(Mapping mapping);

  /// Release the memory of the weights until the next map().
  void release() {
    weights_ = {};
    stop_.forget();
  }

  /// Interfaces have other facets: find anew what depends on them.
  void renew_surfaces();

  const PointWeights<dim>& weights() const { return weights_; }
  const GridNodes<dim>& nodes() const { return nodes_; }
  /// Laws of the points whose constants vary.
  const PointLaws<dim>& laws() const { return laws_; }
  WallConditions<dim>& walls(std::size_t phase) { return walls_of_phases_[phase]; }
  /// Change of the points' velocities by the walls, not yet applied to the points.
  const InelasticProjection<dim>& stop() const { return stop_; }
  /// Add the mean forces of the points on the walls from the projection. @param forces  of
  /// the phase's walls
  void add_stopping_forces(std::size_t phase, double dt, std::span<Vector<dim>> forces) const;
  /// Faces of thin walls whose two sides share nodes: without fields by side (SideFields).
  const std::vector<FacePair>& shared_pairs() const { return shared_pairs_; }
  /// The ghost stiffness that acts in this step, null: none does.
  const GhostStiffness<dim>* ghost() const { return ghost_acts_ ? &*ghost_ : nullptr; }
  /// Whether a phase may have ghost stiffness.
  bool has_ghost() const { return ghost_.has_value(); }
  const SmallCutCounts& small_cuts() const { return small_cuts_; }

  /// Nodal forces of MpmSettings::body_acceleration at a time [s], empty when there is none.
  std::vector<double> body_forces(double time) const;
  /// 1 for each cell of the grid with a point of any rank, else 0; on the first rank.
  SparseList<char> occupied_cells() const;
  /// @param du  increment of the active nodes [m], num_nodes x dim
  /// @throws ConvergenceError  it would carry a point out of the grid; cause "outside"
  void refuse_exits(const Phase& phase, std::span<const double> du) const;

 private:
  bool wants_ghost(std::size_t phase) const;
  void find_thin_walls();
  void split_sides();
  void cure_small_cuts(const Mapping& mapping);

  const SoilModel<dim>& model_;
  const MaterialPoints<dim>& points_;
  const PointRanks<dim>& ranks_;
  PhaseTimes& times_;
  std::vector<WallConditions<dim>> walls_of_phases_;
  PointWeights<dim> weights_;
  std::vector<std::int32_t> doubled_;  // numbers of nodes whose other numbers act here
  PointLaws<dim> laws_;
  GridNodes<dim> nodes_;
  InelasticProjection<dim> stop_;
  std::optional<CellQuadrature<dim>> quadrature_;  // none: stresses are summed over points
  std::vector<OpenNodes> open_of_phases_;          // with it
  std::optional<GhostStiffness<dim>> ghost_;
  bool ghost_acts_ = false;
  std::optional<FacetSights<dim>> sights_;  // none: no node is weak
  SmallCutCounts small_cuts_;
  const Surfaces<dim>& surfaces_;
  std::vector<FacePair> shared_pairs_;
  std::optional<SideFields<dim>> sides_;  // none: no thin wall, or none that can have them
  bool said_doubled_ = false;
};

}  // namespace gabion::mpm
