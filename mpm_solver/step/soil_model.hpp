// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <mpi.h>

#include <string>
#include <vector>

#include "mpm_solver/mpm_config.hpp"
#include "mpm_solver/step/grid_exits.hpp"

namespace gabion::mpm {

/// Parts of the soil's model that never change in a run.
template <int dim>
struct SoilModel {
  SoilModel(MPI_Comm comm_, MpmSettings<dim> settings_);
  SoilModel(const SoilModel&) = delete;  // exits refers to grid
  SoilModel& operator=(const SoilModel&) = delete;
  SoilModel(SoilModel&&) = delete;
  SoilModel& operator=(SoilModel&&) = delete;
  ~SoilModel() = default;

  MPI_Comm comm;
  MpmSettings<dim> settings;  ///< but for the grid, which is below
  BackgroundGrid<dim> grid;
  GridExits<dim> exits;
  double cell_size;                      ///< mean [m]
  std::vector<double> wave_speeds;       ///< of each body [m/s]
  double wave_speed = 0;                 ///< the largest [m/s]
  bool symmetric_laws = true;            ///< all bodies have symmetric tangents
  std::vector<char> elastic;             ///< of each body: it has an elastic law
  bool remembers_internal = false;       ///< a body has a law with internal variables
  bool remembers_variables = false;      ///< a body has a law with state variables, Umat
  bool varies = false;                   ///< a body has constants that vary in space
  std::vector<double> moduli;            ///< of P waves of the skeleton, of each body [Pa]
  std::vector<double> weights;           ///< pressure under each body by its own weight [Pa]
  bool drains = false;                   ///< a body has pore water that drains
  bool stressed = false;                 ///< a body has initial stress
  std::vector<std::string> wall_groups;  ///< of all phases, each once
  /// Facet groups through which soil may leave: all with `outside` `remove`, else those of
  /// outflows.
  std::vector<std::string> exit_sides;
  bool lets_out = false;  ///< soil may leave
};

}  // namespace gabion::mpm
