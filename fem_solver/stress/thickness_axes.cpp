// SPDX-License-Identifier: BSD-3-Clause
#include "fem_solver/stress/thickness_axes.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <array>

#include "common/base/require.hpp"
#include "common/mechanics/elements/cell_facets.hpp"
#include "common/mechanics/mesh/boundary.hpp"
#include "fem_solver/stress/brick_widths.hpp"
#include "fem_solver/stress/cells_of_materials.hpp"

namespace gabion::fem {

namespace {

constexpr double rounding = 1e-9;  // of lengths that are differences of coordinates

constexpr const char* other_ways =
    "\"thickness\" \"side\" with a group of facets, \"numbering\", or another formulation";

/// Finds axes by what the whole mesh shows.
class Finder {
 public:
  Finder(const Mesh<3>& mesh, const CellMaterial<3>& material, const MeshRanks& ranks)
      : mesh_(mesh), material_(material), ranks_(ranks), neighbours_(cell_neighbours(mesh)) {}

  int shortest(std::int32_t c) const {
    const auto width = brick_widths(mesh_, c);
    const int axis = static_cast<int>(std::min_element(width.begin(), width.end()) - width.begin());
    const double next = std::min(width[(axis + 1) % 3], width[(axis + 2) % 3]);
    require<ConfigError>(2 * width[axis] <= (1 + rounding) * next, [&] {
      return fmt::format(
          "{}: found {}, {:.4g} by {:.4g} by {:.4g} m along its axes: which is the thickness is "
          "not clear; allowed: a thickness of at most half the other two, {}",
          material_.thickness_where, describe_cell(mesh_, ranks_, c), width[0], width[1], width[2],
          other_ways);
    });
    for (const int other : {(axis + 1) % 3, (axis + 2) % 3}) {
      require<ConfigError>(!goes_on(c, axis) || !is_free(c, other), [&] {
        return fmt::format(
            "{}: found {}, whose shortest axis leads to other cells and another one to none on "
            "both sides: which is the thickness is not clear; allowed: {}",
            material_.thickness_where, describe_cell(mesh_, ranks_, c), other_ways);
      });
    }
    return axis;
  }

  /// The axis between facets of which one is in the group.
  int from_side(std::int32_t c, std::span<const char> facets_of_group) const {
    int found = -1, count = 0;
    for (int axis = 0; axis < 3; ++axis) {
      const char* of_cell = facets_of_group.data() + static_cast<std::size_t>(c) * 6;
      if (of_cell[brick_facet(3, axis, 0)] || of_cell[brick_facet(3, axis, 1)]) {
        found = axis;
        ++count;
      }
    }
    require<ConfigError>(count == 1, [&] {
      return fmt::format(
          "{}: found {} with facets of \"{}\" on {} of its axes; allowed: one, across which the "
          "thickness lies",
          material_.thickness_where, describe_cell(mesh_, ranks_, c), material_.thickness_side,
          count);
    });
    return found;
  }

 private:
  /// Another cell, of any rank, at this facet.
  bool has_neighbour(std::int32_t c, int axis, int end) const {
    const int f = brick_facet(3, axis, end);
    if (neighbours_[static_cast<std::size_t>(c) * 6 + f] >= 0) return true;
    const auto facet = cell_facet(mesh_, c, f);
    return is_shared(std::span(facet).first(4), ranks_.shared());
  }
  bool goes_on(std::int32_t c, int axis) const {
    return has_neighbour(c, axis, 0) || has_neighbour(c, axis, 1);
  }
  bool is_free(std::int32_t c, int axis) const { return !goes_on(c, axis); }

  const Mesh<3>& mesh_;
  const CellMaterial<3>& material_;
  const MeshRanks& ranks_;
  std::vector<std::int32_t> neighbours_;
};

/// 1 for the facets of cells that are of the group, cells x 6.
std::vector<char> facets_of_group(const Mesh<3>& mesh, const CellMaterial<3>& material) {
  std::vector<char> marks(static_cast<std::size_t>(mesh.num_cells()) * 6, 0);
  const auto& facets = mesh.facets(material.thickness_side, material.thickness_where);
  const FacetOwners owners(mesh);
  for (std::size_t f = 0; f + 4 <= facets.size(); f += 4) {
    for (const auto& owner : owners.find(std::span(facets).subspan(f, 4))) {
      marks[static_cast<std::size_t>(owner.cell) * 6 + owner.facet] = 1;
    }
  }
  return marks;
}

}  // namespace

std::vector<int> thickness_axes(const Mesh<3>& mesh, const CellMaterial<3>& material,
                                std::span<const std::int32_t> cells, const MeshRanks& ranks) {
  if (material.thickness == Thickness::numbering) return std::vector<int>(cells.size(), 2);
  const Finder finder(mesh, material, ranks);
  std::vector<char> marks;
  if (material.thickness == Thickness::side) marks = facets_of_group(mesh, material);
  std::vector<int> axes;
  for (const std::int32_t c : cells) {
    axes.push_back(marks.empty() ? finder.shortest(c) : finder.from_side(c, marks));
  }
  return axes;
}

}  // namespace gabion::fem
