// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <utility>
#include <vector>

#include "common/run/facets.hpp"
#include "protocol/wire/message.hpp"

namespace gabion {

/// Arrays "facets:<interface>" of some interfaces, num_facets x vertices_per_facet.
/// @throws ProtocolError  an interface that is none of these, or that has no facets; a number of
///                        vertices that is no multiple of those of a facet
void put_facets(Message& message, const std::vector<InterfaceMesh>& interfaces,
                const InterfaceFacets& facets);
/// Facets of the interfaces that the message names.
/// @throws ProtocolError  a facet names a vertex that does not exist, or an interface has none
InterfaceFacets read_facets(const Message& message, const std::vector<InterfaceMesh>& interfaces);

/// Facets that the coupler knows of a structure whose facets may change.
class SentFacets {
 public:
  SentFacets() = default;
  /// @param first  those of the hello, of the interfaces that may change
  explicit SentFacets(InterfaceFacets first) : sent_(std::move(first)) {}

  /// Add to an answer "accepted" the facets that are others than those sent last.
  /// @param now  of the interfaces that may change, in the accepted state
  /// @throws ProtocolError  as put_facets()
  void put_changed(Message& accepted, const std::vector<InterfaceMesh>& interfaces,
                   const InterfaceFacets& now);
  /// Send all of them again: after "load" the coupler may know others.
  void forget() { sent_.clear(); }

 private:
  InterfaceFacets sent_;
};

}  // namespace gabion
