// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <string>

#include "common/mechanics/output/xdmf_series.hpp"
#include "fem_solver/step/equilibrium.hpp"
#include "fem_solver/step/structure_state.hpp"

namespace gabion::fem {

/// Time series "lines" of the deformed line cells, each with end points of its own, in the order of
/// the mesh. Fields: axial_force (tension positive); where there are beams, shear forces, torsion
/// and bending moments in their middles (in 2D shear_force and bending_moment); where there are
/// brakes, brake_run.
template <int dim>
class LineOutput {
 public:
  /// Refers to the settings.
  LineOutput(const FemSettings<dim>& settings, const std::string& folder);

  /// @throws Error  disk full, folder gone
  /// @note Collective.
  void write(double time, const StructureState& state, const Equilibrium<dim>& equilibrium);
  /// Size of a frame of all ranks before compression; 0 without lines.
  static std::int64_t frame_bytes(const FemSettings<dim>& settings);

 private:
  const FemSettings<dim>& settings_;
  XdmfSeries series_;
};

}  // namespace gabion::fem
