// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <map>
#include <string>
#include <vector>

#include "common/run/solver.hpp"

namespace gabion {

/// Interface name -> its facets, num_facets x vertices_per_facet, as those of InterfaceMesh.
using InterfaceFacets = std::map<std::string, std::vector<std::int64_t>>;

/// A structure whose interfaces may get other facets between steps, where cells leave it. Vertices
/// stay: from the beginning they are all that a facet may ever have.
class ChangesFacets {
 public:
  virtual ~ChangesFacets() = default;
  /// Facets in the accepted state, of the interfaces that may get others; none: nothing changes.
  virtual InterfaceFacets facets() const = 0;
};

/// A soil that can go on with other facets.
class TakesFacets {
 public:
  virtual ~TakesFacets() = default;
  /// Whether set_facets will be answered; false where the solver behind this one has none.
  virtual bool takes_facets() const { return true; }
  /// Let these interfaces have other facets from now on, of the same vertices. Between two steps; a
  /// saved state has them. @note Collective, as the functions of Solver.
  /// @throws Error  a vertex that is none, an interface that cannot change
  virtual void set_facets(const InterfaceFacets& facets) = 0;
};

/// Facets of the interfaces of a solver that may change.
inline InterfaceFacets changing_facets(const Solver& solver) {
  const auto* changer = dynamic_cast<const ChangesFacets*>(&solver);
  return changer == nullptr ? InterfaceFacets() : changer->facets();
}

/// Names of the interfaces of a solver that may get other facets.
inline std::vector<std::string> changing_interfaces(const Solver& solver) {
  std::vector<std::string> names;
  for (const auto& [name, facets] : changing_facets(solver)) names.push_back(name);
  return names;
}

inline bool takes_facets(const Solver& solver) {
  const auto* taker = dynamic_cast<const TakesFacets*>(&solver);
  return taker != nullptr && taker->takes_facets();
}

/// @throws Error  the solver does not take them
inline void set_facets(Solver& solver, const InterfaceFacets& facets) {
  if (!takes_facets(solver)) throw Error("this solver does not take other facets");
  dynamic_cast<TakesFacets&>(solver).set_facets(facets);
}

}  // namespace gabion
