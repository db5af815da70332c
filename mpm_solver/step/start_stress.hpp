// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <functional>
#include <span>
#include <string>
#include <vector>

#include "mpm_solver/contact/soil_surface.hpp"
#include "mpm_solver/points/pool.hpp"
#include "mpm_solver/step/implicit_step.hpp"
#include "mpm_solver/step/soil_model.hpp"

namespace gabion::mpm {

/// Soil as it lies on the surfaces. Without stress the spheres of rectangular cells alone are set
/// off to the surface. Rows of triangles are not symmetric, and where a surface cuts the grid all
/// spheres in contact bear less than some of them would. Sand in sheared cells that would be in
/// contact with walls and floor at once finds no first balance.
/// @param first_ids  of the bodies
/// @param pressure   of flowing water at a place of a body [Pa]
template <int dim>
SoilAtRest<dim> soil_at_rest(
    const MpmSettings<dim>& settings, const Vector<dim>& gravity, const PoolLevels& pools,
    const std::vector<std::int64_t>& first_ids,
    const std::function<double(std::int32_t body, const Vector<dim>& x)>& pressure);

/// Parts of a start in steady flow.
template <int dim>
struct StartInFlow {
  const SoilModel<dim>& model;
  ImplicitStep<dim>& step;
  SoilOnGrid<dim>& soil;
  const StepStart& start;  ///< of a quasi-static step
  PoolLevels pools;        ///< at the start
  Vector<dim> gravity;     ///< then [m/s^2]
  std::string where;       ///< the setting that asks for it, for messages
};
/// Find the steady flow of the water and put the bodies that begin in it under its pressures. The
/// stresses are those of level ground; the balance (ImplicitStep::balance_flow) comes after contact
/// has begun.
/// @returns discharge of the flow [m^3/s]
/// @throws ConfigError
/// @note Collective.
template <int dim>
double begin_in_flow(const StartInFlow<dim>& parts, MaterialPoints<dim>& points);

/// Warn of rows of points deeper than steps search for contact, some three quarters of a cell of
/// the grid.
void warn_of_deep_rows(double deepest, double cell_size);
/// Largest depth of rows of points free of stress whose spheres do not reach the surface [m].
template <int dim>
double deepest_row_to_reach(const MpmSettings<dim>& settings);

/// The initial stress with the least max_displacement; null: there is none.
template <int dim>
const InitialStress* strictest_stress(const MpmSettings<dim>& settings);
/// Place of the setting of a steady flow at the start, for messages; empty: water is at rest.
template <int dim>
std::string flow_that_is_asked_for(const MpmSettings<dim>& settings);
/// Undrained soil hardly moves under a load that its skeleton should have borne from the start, so
/// its displacement does not show a jump of the stress between bodies.
/// @throws ConfigError  there is one
template <int dim>
void refuse_jump_on_water(const MpmSettings<dim>& settings, const Vector<dim>& gravity,
                          const std::string& where);

/// Largest displacement of a point that would balance the initial stress, and the cell size [m].
struct InitialSettlement {
  double largest, cell_size;
};
/// Log it, and refuse one above the least max_displacement.
/// @throws ConfigError
template <int dim>
void require_small_settlement(const MpmSettings<dim>& settings, const Vector<dim>& gravity,
                              const InitialSettlement& found);

}  // namespace gabion::mpm
