// SPDX-License-Identifier: BSD-3-Clause
#include "fem_solver/interface/displaced_start.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>

namespace gabion::fem {

namespace {

constexpr double noticed = 0.01;  // share of the shortest edge

double shortest_edge(const InterfaceMesh& mesh) {
  double shortest = std::numeric_limits<double>::infinity();
  const auto n = static_cast<std::size_t>(mesh.vertices_per_facet);
  for (std::size_t k = 0; n > 0 && k < mesh.facets.size(); ++k) {
    const std::size_t next = (k + 1) % n == 0 ? k + 1 - n : k + 1;
    double square = 0;
    for (int c = 0; c < mesh.dim; ++c) {
      const double d = mesh.coordinates[mesh.facets[k] * mesh.dim + c] -
                       mesh.coordinates[mesh.facets[next] * mesh.dim + c];
      square += d * d;
    }
    shortest = std::min(shortest, std::sqrt(square));
  }
  return shortest;
}

double largest_of(const std::vector<double>& u, int dim) {
  double largest = 0;
  for (std::size_t k = 0; k < u.size(); k += static_cast<std::size_t>(dim)) {
    double square = 0;
    for (int c = 0; c < dim; ++c) square += u[k + c] * u[k + c];
    largest = std::max(largest, std::sqrt(square));
  }
  return largest;
}

}  // namespace

std::optional<std::string> displaced_start(const std::vector<InterfaceMesh>& meshes,
                                           const InterfaceValues& start) {
  std::string text;
  for (const InterfaceMesh& mesh : meshes) {
    const double edge = shortest_edge(mesh), u = largest_of(start.at(mesh.name), mesh.dim);
    if (!(u > noticed * edge)) continue;
    text += fmt::format("{}\"{}\" by up to {:.3g} m, {:.3g} of its shortest edge",
                        text.empty() ? "" : ", ", mesh.name, u, u / edge);
  }
  if (text.empty()) return std::nullopt;
  return fmt::format(
      "interfaces that start displaced: {}; the soil has them at their reference places until its "
      "first step, in which they move by all of it at once",
      text);
}

}  // namespace gabion::fem
