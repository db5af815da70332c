// SPDX-License-Identifier: BSD-3-Clause
#include "protocol/wire/facets.hpp"

#include <algorithm>

#include "common/base/require.hpp"

namespace gabion {

namespace {

std::string array_of(const std::string& interface) {
  return "facets:" + interface;
}

}  // namespace

void put_facets(Message& message, const std::vector<InterfaceMesh>& interfaces,
                const InterfaceFacets& facets) {
  for (const auto& [name, own] : facets) {
    const auto mesh = std::ranges::find(interfaces, name, &InterfaceMesh::name);
    require<ProtocolError>(mesh != interfaces.end(), "facets of interface \"{}\", which is none",
                           name);
    const std::int64_t width = mesh->vertices_per_facet;
    require<ProtocolError>(width > 0 && std::ssize(own) % width == 0,
                           "\"{}\": found {} vertices for facets of {}", array_of(name), own.size(),
                           width);
    message.add(array_of(name), {std::ssize(own) / width, width}, own);
  }
}

InterfaceFacets read_facets(const Message& message, const std::vector<InterfaceMesh>& interfaces) {
  InterfaceFacets facets;
  for (const InterfaceMesh& mesh : interfaces) {
    const std::string array = array_of(mesh.name);
    if (!message.has_array(array)) continue;
    require<ProtocolError>(mesh.vertices_per_facet > 0,
                           "message \"{}\": found \"{}\" of an interface without facets",
                           message.type, array);
    std::vector<std::int64_t>& own = facets[mesh.name];
    own = message.integers(array, {-1, mesh.vertices_per_facet});
    for (const std::int64_t vertex : own) {
      require<ProtocolError>(vertex >= 0 && vertex < mesh.num_vertices(),
                             "message \"{}\", \"{}\": a facet names vertex {}, there are {}",
                             message.type, array, vertex, mesh.num_vertices());
    }
  }
  return facets;
}

void SentFacets::put_changed(Message& accepted, const std::vector<InterfaceMesh>& interfaces,
                             const InterfaceFacets& now) {
  InterfaceFacets changed = now;
  std::erase_if(changed, [&](const auto& entry) {
    const auto before = sent_.find(entry.first);
    return before != sent_.end() && before->second == entry.second;
  });
  put_facets(accepted, interfaces, changed);
  for (auto& [name, facets] : changed) sent_[name] = std::move(facets);
}

}  // namespace gabion
