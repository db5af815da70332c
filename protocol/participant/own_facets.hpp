// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <functional>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "protocol/wire/facets.hpp"

namespace gabion {

/// Facets of a structure that keeps its own time loop, of those interfaces whose facets may change.
class OwnFacets {
 public:
  /// Note an interface with the facets of the beginning.
  /// @throws UsageError  an interface without facets
  void let_change(const InterfaceMesh& surface);
  /// Names of these interfaces.
  std::vector<std::string> names() const;
  /// Set all facets of an interface.
  /// @param accepted  whether the code has just got to know that a step was accepted
  /// @throws UsageError  neither accepted nor loading; a vertex that is none
  void write(const InterfaceMesh& surface, std::span<const std::int64_t> facets, bool accepted);
  /// Run a code's function that loads a state, in which it has to write the facets of each of these
  /// interfaces.
  /// @throws UsageError  it did not
  void while_loading(const std::function<void()>& load);
  /// Add to an answer "accepted" what the coupler does not know.
  void put_changed(Message& accepted, const std::vector<InterfaceMesh>& interfaces) {
    sent_.put_changed(accepted, interfaces, facets_);
  }

 private:
  InterfaceFacets facets_;                 // in the accepted state
  std::optional<InterfaceFacets> loaded_;  // that were written so far, while a state is loaded
  SentFacets sent_;
};

}  // namespace gabion
