// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <span>

namespace gabion::fem {

/// Result of the integration of the stresses.
struct StressIntegral {
  std::int32_t inadmissible_cell = -1;  ///< cell of the mesh with a fault, -1 = none
  const char* fault = "";               ///< of that cell, such as "det F <= 0"
  double energy = 0;                    ///< elastic energy [J]
};

/// Histories of cells, one after the other: the accepted ones, which stay, and those of the trial
/// state, a function of the accepted ones and the displacement. Empty where no cell has any.
struct HistoryStep {
  std::span<const double> accepted;
  std::span<double> trial;

  HistoryStep part(std::size_t first, std::size_t size) const {
    return {.accepted = accepted.subspan(first, size), .trial = trial.subspan(first, size)};
  }
};

}  // namespace gabion::fem
