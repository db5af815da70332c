// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <vector>

#include "common/run/facets.hpp"
#include "protocol/wire/message.hpp"

namespace gabion {

/// Arrays "facets:<interface>" of some interfaces, num_facets x vertices_per_facet.
/// @throws ProtocolError  an interface that is none of these, or that has no facets; a number of
///                        vertices that is no multiple of those of a facet
void put_facets(Message& message, const std::vector<InterfaceMesh>& interfaces,
                const InterfaceFacets& facets);
/// Those of the interfaces that the message has.
/// @throws ProtocolError  a facet names a vertex that does not exist, or an interface has none
InterfaceFacets read_facets(const Message& message, const std::vector<InterfaceMesh>& interfaces);

}  // namespace gabion
