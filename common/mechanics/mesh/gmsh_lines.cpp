// SPDX-License-Identifier: BSD-3-Clause
#include "common/mechanics/mesh/gmsh_lines.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <utility>

#include "common/base/require.hpp"
#include "common/mechanics/mesh/mesh_box.hpp"

namespace gabion {

namespace {

constexpr double shortest_share = 1e-10;  // of the longest side of the mesh

template <int dim>
std::string text_of(const Vector<dim>& x) {
  return fmt::format("({:.6g})", fmt::join(x.data(), x.data() + dim, ", "));
}

}  // namespace

template <int dim>
void GmshLines<dim>::add(const GmshFile::ElementBlock& block, std::span<const std::string> groups,
                         std::span<const std::int32_t> nodes) {
  const double shortest = shortest_share * box_around(mesh_).sizes().maxCoeff();
  for (std::size_t k = 0; k < block.tags.size(); ++k) {
    const std::int32_t i = nodes[2 * k], j = nodes[2 * k + 1];
    const Vector<dim>& x = mesh_.nodes[i];
    const double length = (mesh_.nodes[j] - x).norm();
    require<ConfigError>(length > shortest, [&] {
      return fmt::format(
          "{}: section $Elements: found line {} of group \"{}\" at {} with length {}, allowed: > 0",
          origin_.path, block.tags[k], groups.front(), text_of<dim>(x), length);
    });
    if (!is_new({&block, block.tags[k]}, i, j)) continue;
    for (const std::string& group : groups) mesh_.line_groups[group].push_back(mesh_.num_lines());
    mesh_.lines.insert(mesh_.lines.end(), {i, j});
  }
}

/// @returns false: a label of a line that is there already
template <int dim>
bool GmshLines<dim>::is_new(const FileElement& element, std::int32_t i, std::int32_t j) {
  const auto [found, added] = known_.try_emplace(std::minmax(i, j), element);
  if (added) return true;
  const FileElement& first = found->second;
  require<ConfigError>(first.block != element.block && first.block->entity == element.block->entity,
                       [&] {
                         return fmt::format(
                             "{}: section $Elements: found a line twice from {} to {}: elements {} "
                             "and {}; both would have mass and stiffness there, allowed: each once",
                             origin_.path, text_of<dim>(mesh_.nodes[i]),
                             text_of<dim>(mesh_.nodes[j]), first.tag, element.tag);
                       });
  return false;
}

template class GmshLines<2>;
template class GmshLines<3>;

}  // namespace gabion
