// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Geometry>
#include <optional>
#include <string>
#include <vector>

#include "mpm_solver/boulders/aitken.hpp"
#include "mpm_solver/boulders/boulder_ledger.hpp"
#include "mpm_solver/boulders/boulder_settings.hpp"
#include "mpm_solver/boulders/impact_watch.hpp"
#include "mpm_solver/contact/surfaces.hpp"
#include "mpm_solver/grid/background_grid.hpp"
#include "mpm_solver/phases/phases.hpp"

namespace gabion::mpm {

/// The surroundings of boulders. Refers to the settings of the run.
template <int dim>
struct BoulderScene {
  const BackgroundGrid<dim>& grid;
  const Vector<dim>& gravity;  ///< [m/s^2]
  const std::vector<Phase>& phases;
  const std::vector<ContactSettings<dim>>& interfaces;
  const std::vector<RigidWallSettings<dim>>& rigid_walls;  ///< those of the boulders at the end
  const std::vector<BoulderSettings<dim>>& boulders;
};

/// The surroundings of boulders by MpmSettings, which may have given away its grid.
template <int dim, class Settings>
BoulderScene<dim> boulder_scene(const Settings& settings, const BackgroundGrid<dim>& grid) {
  return {grid,
          settings.gravity,
          settings.phases,
          settings.interfaces,
          settings.rigid_walls,
          settings.boulders};
}

/// The boulders of a run, equal on all ranks (docs/theory/boulders.md). A step: begin; then place,
/// the soil's solution and follow until `follow` says that both agree; then accept. Soil and
/// boulders agree on their forces to rounding whenever `follow` was called last.
template <int dim>
class Boulders {
 public:
  explicit Boulders(const BoulderScene<dim>& settings);

  bool empty() const { return contact_.bodies().empty(); }

  /// A step from the accepted state.
  struct Request {
    double time = 0, dt = 0;                    ///< [s]
    const Phase* phase = nullptr;               ///< which rigid walls act, the ramp of gravity
    const InterfaceValues* received = nullptr;  ///< displacements of the interfaces
    double tolerance = 0;                       ///< of the places of boulders [m]
  };
  void begin(const Request& request);
  /// Move the surfaces to where the boulders would be at the end of the step.
  void place(Surfaces<dim>& surfaces) const;
  /// Move the boulders by the forces of the soil.
  /// @param forces  Surfaces::forces_on_walls
  /// @returns whether the boulders are where they were placed
  /// @throws ConvergenceError  soil and boulders do not come together
  bool follow(std::span<const double> forces);
  /// @throws ConvergenceError  the centre of a boulder leaves the box around the grid
  void refuse_exits() const;
  void accept();

  /// Whether a boulder may come into contact with an interface in the step.
  bool may_touch_interface() const;
  /// Add the mean forces of the boulders in the last step to those of the soil.
  void add_forces(InterfaceValues& forces) const;
  /// Add them to the forces on rigid walls. @param forces  as Surfaces::forces_on_walls
  void add_forces(std::span<double> forces) const;

  /// Columns of the tables: of each boulder, of all of them, then the part of the force on each
  /// interface and rigid wall that boulders exert.
  static std::vector<std::string> names(const BoulderScene<dim>& settings);
  std::vector<double> values() const;
  const std::vector<BodyState>& states() const { return accepted_.states; }

  HardContact::Overlap overlap_at_start() const;
  std::string name_of_partner(std::int32_t number) const;

  void visit_state(StateVisitor& visitor);

 private:
  Obstacle obstacle(std::size_t surface) const;
  Obstacle obstacle_in_step(std::size_t surface, const Request& request) const;
  std::vector<BodyLoad> soil_loads(std::span<const double> forces) const;
  std::vector<double> difference(const std::vector<BodyLoad>& loads) const;
  std::size_t num_interfaces() const { return settings_.interfaces.size(); }
  std::size_t first_wall() const { return settings_.rigid_walls.size() - contact_.bodies().size(); }

  BoulderScene<dim> settings_;
  Eigen::AlignedBox<double, dim> grid_;  // around it [m]
  HardContact contact_;
  std::vector<std::vector<HardFacet>> facets_;  // of the interfaces, then of the rigid walls
  std::vector<std::vector<Vector<3>>> interface_places_;  // of the accepted step
  HardContact::Start accepted_;
  std::vector<BodyLoad> last_loads_;  // of the soil, in the accepted step
  std::vector<double> works_;         // of contact with hard bodies, since the start [J]
  BoulderLedger ledger_;
  std::vector<Vector<3>> forces_;  // mean in the accepted step, on interfaces, rigid walls [N]
  ImpactWatch impacts_;            // on interfaces

  // the current step
  double dt_ = 0, tolerance_ = 0;
  HardContact::Step step_;
  std::optional<HardContact::End> end_;
  AitkenRelaxation relaxation_;
  int passes_ = 0;
};

}  // namespace gabion::mpm
