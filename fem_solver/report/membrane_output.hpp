// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "common/mechanics/output/xdmf_series.hpp"
#include "fem_solver/step/equilibrium.hpp"
#include "fem_solver/step/structure_state.hpp"

namespace gabion::fem {

/// Membranes in the results of a structure. Columns of probes.csv, of each group: tension_max_GROUP
/// and tension_min_GROUP, the largest and least principal force per deformed length in the middle
/// of a cell [N/m], and strain_max_GROUP, the largest principal strain from the stress-free state.
/// Time series "membranes" of the deformed cells, in the order of the materials: displacement and
/// velocity on nodes; on cells membrane_force, a symmetric tensor [N/m], its principal values
/// tension_1 and tension_2, strain, and where some may wrinkle `wrinkled`: 0 taut, 1 wrinkled, 2
/// slack.
template <int dim>
class MembraneOutput {
 public:
  /// Refers to the settings.
  /// @param folder  of the series; empty: no frames are written
  MembraneOutput(const FemSettings<dim>& settings, const std::string& folder);

  std::vector<std::string> probe_names() const;
  static std::vector<double> probes(const StructureState& state,
                                    const Equilibrium<dim>& equilibrium);
  /// @throws Error  disk full, folder gone
  void write(double time, const StructureState& state, const Equilibrium<dim>& equilibrium);
  /// Size of a frame before compression; 0 without membranes.
  static std::int64_t frame_bytes(const FemSettings<dim>& settings);

 private:
  const FemSettings<dim>& settings_;
  std::vector<std::int32_t> nodes_;  // of sheets, ascending
  bool writes_;
  XdmfSeries series_;
};

}  // namespace gabion::fem
