// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <mpi.h>

#include <cstdint>
#include <functional>
#include <memory>
#include <span>
#include <vector>

#include "mpm_solver/grid/grid_nodes.hpp"
#include "mpm_solver/points/laid_sides.hpp"

namespace gabion::mpm {

template <int dim>
class SoilExtent;

/// Pore water of a body in a step; of a dry one there is none.
template <int dim>
struct WaterOfBody {
  Vector<dim> weight = Vector<dim>::Zero();  ///< rho_w g, 0 under pools [N/m^3]
  /// Share of a change of pressure that drains in the step: T / (1 + T), T = c_v dt / h^2; 1 of dry
  /// soil.
  double drained = 1;
};

/// The soil as a contact sees it in a step, at the accepted positions.
template <int dim>
struct SoilSurface {
  const BackgroundGrid<dim>& grid;
  const GridNodes<dim>& nodes;        ///< active ones
  const MaterialPoints<dim>& points;  ///< of this rank
  const PointWeights<dim>& weights;   ///< of this rank's points
  /// 1 for grid cells with a point of any rank; on the first rank, where a contact asks_for_cells
  const SparseList<char>* occupied = nullptr;
  bool has_points(std::int32_t cell) const { return (*occupied)[cell] != 0; }
  double reach = 0;                  ///< how far soil extends beyond its points [m]
  double cell_size = 0;              ///< mean [m]
  double dt = 0;                     ///< of the step [s]
  double step_force_weight = 1;      ///< of NewmarkBossak; quasi-static: 1
  std::span<const char> elastic{};   ///< 1 for bodies that never yield
  std::span<const double> moduli{};  ///< of P waves, of the bodies [Pa]
  double strength_factor = 1;        ///< by which friction is divided, of strength reduction
  /// Soil takes its weight in the step: it is quasi-static, or gravity grows. New contacts are then
  /// as stiff as the pressures of that weight ask for.
  bool takes_weight = false;
  std::span<const double> weights_of{};  ///< pressure under each body by its own weight [Pa]
  /// Pressure of the pore water at the points when the step begins, beyond that of pools; 0 of soil
  /// without water [Pa]; empty: there is none.
  std::span<const double> pore_pressures{};
  /// Effective Cauchy stress of the points then [Pa]; empty with pore_pressures.
  std::span<const Symmetric<dim>> grain_stresses{};
  std::span<const WaterOfBody<dim>> pore_waters{};  ///< of the bodies; empty with pore_pressures
  MPI_Comm comm = MPI_COMM_SELF;                    ///< of the ranks that share the soil
  std::shared_ptr<const SoilExtent<dim>> extent{};  ///< null: a contact finds it by itself
};

/// Soil as it was laid when the run begins.
template <int dim>
struct SoilAtRest {
  /// Sides that a point was laid at.
  std::function<std::vector<LaidSide<dim>>(std::int32_t body, std::int64_t id)> sides;
  /// 1 for bodies under stress. The others lie on a surface and do not press on it.
  std::vector<char> is_stressed;
  /// Cauchy stresses of a body under stress along the axes at a place [Pa].
  std::function<Vector<dim>(std::int32_t body, const Vector<dim>& x)> stress;
  /// Soil farther than this from a surface does not lie on it [m].
  double deepest_row = 0;
};

}  // namespace gabion::mpm
