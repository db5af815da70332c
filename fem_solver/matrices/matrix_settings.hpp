// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "fem_solver/fem_config.hpp"

namespace gabion::fem {

/// Files of a structure that is given as matrices, as the scene names them; empty: none.
struct MatrixFiles {
  std::string stiffness, mass, damping, load, unknowns, held, nodes, cells;
};

/// fem.json of a structure that is given as matrices.
template <int dim>
struct MatrixSettings : MotionSettings<dim> {
  MatrixFiles files;
  RayleighFactors rayleigh;
  /// Craig-Bampton reduction to the wet surfaces and so many modes; none: all unknowns.
  std::optional<int> modes;
  std::vector<WetSurfaceSettings> interfaces;  ///< their group: the file of their facets
  std::vector<ProbeSettings<dim>> probes;
  std::string where;  ///< place of "matrices", for error messages
};

/// Keys of "matrices".
KeyTable matrix_keys();

/// Read everything of fem.json but "dimension", "time" and "output".
/// @throws ConfigError
template <int dim>
MatrixSettings<dim> read_matrix_settings(ConfigReader& in);

}  // namespace gabion::fem
