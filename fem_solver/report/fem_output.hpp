// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "common/mechanics/output/xdmf_series.hpp"
#include "fem_solver/step/equilibrium.hpp"
#include "fem_solver/step/structure_state.hpp"

namespace gabion::fem {

/// Time series of the deformed structure: displacement, velocity, external_force on nodes, stress
/// (Cauchy, cell mean) on cells.
template <int dim>
class FemOutput {
 public:
  /// @param folder  of the series "structure"; created with the first frame, by rank 0
  FemOutput(const Mesh<dim>& mesh, std::string folder, MPI_Comm comm);

  /// @throws Error  disk full, folder gone
  /// @note Collective.
  void write(double time, const StructureState& state, const Equilibrium<dim>& equilibrium);
  /// Size of a frame before compression.
  static std::int64_t frame_bytes(const Mesh<dim>& mesh);

 private:
  const Mesh<dim>& mesh_;
  MPI_Comm comm_;
  std::string folder_;
  std::optional<XdmfSeries> series_;  // rank 0, from the first frame on
};

}  // namespace gabion::fem
