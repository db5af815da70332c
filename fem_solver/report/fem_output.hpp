// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <string>

#include "common/mechanics/output/xdmf_series.hpp"
#include "fem_solver/step/equilibrium.hpp"
#include "fem_solver/step/structure_state.hpp"

namespace gabion::fem {

/// Time series of the deformed structure: displacement, velocity, external_force on nodes, stress
/// (Cauchy, cell mean) on cells, plastic_strain (cell mean) where cells may yield. Nodes and cells
/// stand in the order of the mesh, on any number of ranks, which write together.
template <int dim>
class FemOutput {
 public:
  /// Refers to the settings.
  /// @param folder  of the series "structure"; created with the first frame
  FemOutput(const FemSettings<dim>& settings, const std::string& folder);

  /// @throws Error  disk full, folder gone
  /// @note Collective.
  void write(double time, const StructureState& state, const Equilibrium<dim>& equilibrium);
  /// Size of a frame of all ranks before compression.
  static std::int64_t frame_bytes(const FemSettings<dim>& settings);

 private:
  const FemSettings<dim>& settings_;
  XdmfSeries series_;
};

}  // namespace gabion::fem
