// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "common/mechanics/mesh/mesh.hpp"

namespace gabion {

/// Distance up to which nodes of a mesh are in one place [m]: 1e-6 of its longest side, as the
/// digits of a file may leave them apart, and at most a hundredth of its shortest cell edge.
template <int dim>
double coincidence_distance(const Mesh<dim>& mesh);

/// The first node, by number, in the place of each node: itself where it is alone. Nodes that
/// follow each other at no more than the distance are in one place. n log n for n nodes.
template <int dim>
std::vector<std::int32_t> nodes_in_place(std::span<const Vector<dim>> nodes, double distance);

}  // namespace gabion
