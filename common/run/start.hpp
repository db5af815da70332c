// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <algorithm>

#include "common/run/solver.hpp"

namespace gabion {

/// A solver that sends displacement and may begin displaced: in equilibrium with its loads, or at
/// given displacements.
class DisplacedAtStart {
 public:
  virtual ~DisplacedAtStart() = default;
  /// Displacements of the interfaces in the accepted state, as solve_step sends them [m].
  /// @note Collective, as the functions of Solver.
  virtual InterfaceValues start_displacements() const = 0;
};

/// A solver that receives displacement and can be told where its interfaces begin.
class TakesStart {
 public:
  virtual ~TakesStart() = default;
  /// Whether set_start will be answered; false where the solver behind this proxy has none.
  virtual bool takes_start() const { return true; }
  /// Let the interfaces begin displaced [m]. Call it before the first step of a run that is no
  /// restart; a saved state contains the start. Displacements that solve_step receives remain those
  /// from the reference.
  /// @param displacements  of all interfaces
  /// @throws ConfigError  the solver cannot begin so, such as with soil inside a structure
  virtual void set_start(const InterfaceValues& displacements) = 0;
};

/// Displacements of the interfaces that begin displaced [m]; no entry for the others.
inline InterfaceValues start_displacements(const Solver& solver) {
  const auto* displaced = dynamic_cast<const DisplacedAtStart*>(&solver);
  if (displaced == nullptr) return {};
  InterfaceValues start = displaced->start_displacements();
  std::erase_if(start, [](const auto& entry) {
    return std::ranges::all_of(entry.second, [](double value) { return value == 0; });
  });
  return start;
}

inline bool takes_start(const Solver& solver) {
  const auto* taker = dynamic_cast<const TakesStart*>(&solver);
  return taker != nullptr && taker->takes_start();
}

/// @throws Error  the solver does not take it
inline void set_start(Solver& solver, const InterfaceValues& displacements) {
  if (!takes_start(solver)) throw Error("this solver does not take displacements of the start");
  dynamic_cast<TakesStart&>(solver).set_start(displacements);
}

}  // namespace gabion
