// SPDX-License-Identifier: BSD-3-Clause
#include "common/mechanics/mesh/doubled_elements.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <array>
#include <limits>
#include <utility>

#include "common/base/error.hpp"
#include "common/base/log.hpp"
#include "common/mechanics/mesh/coincident_nodes.hpp"

namespace gabion {

namespace {

/// Corners of a cell or facet in ascending order; unused places hold the largest number.
using NodeSet = std::array<std::int32_t, max_cell_nodes>;

template <int dim>
std::span<const std::int32_t> corners_of(const Mesh<dim>& mesh, std::int32_t c) {
  return mesh.cell(c).first(num_corners(mesh.cell_type));
}

NodeSet node_set(std::span<const std::int32_t> nodes) {
  NodeSet set;
  set.fill(std::numeric_limits<std::int32_t>::max());
  std::copy(nodes.begin(), nodes.end(), set.begin());
  std::sort(set.begin(), set.end());
  return set;
}

/// Sets of nodes with the numbers of their elements; equal ones follow each other, those of lower
/// numbers first.
using SortedSets = std::vector<std::pair<NodeSet, std::int32_t>>;

/// Visit each run of equal sets that is longer than one: visit(span).
template <class Visit>
void for_each_run(SortedSets& sets, const Visit& visit) {
  std::sort(sets.begin(), sets.end());
  for (std::size_t first = 0, last = 0; first < sets.size(); first = last) {
    while (last < sets.size() && sets[last].first == sets[first].first) ++last;
    if (last - first > 1) visit(std::span(sets).subspan(first, last - first));
  }
}

/// Whether two facets with the same corners run around in the same sense.
bool same_sense(std::span<const std::int32_t> a, std::span<const std::int32_t> b) {
  if (a.size() == 2) return a[0] == b[0];
  std::vector<std::int32_t> turned(b.begin(), b.end());
  std::rotate(turned.begin(), std::find(turned.begin(), turned.end(), a[0]), turned.end());
  return std::equal(a.begin(), a.end(), turned.begin());
}

std::string text_of(const GmshFile& file, const FileElement& element) {
  const auto groups = group_names(file, *element.block);
  return fmt::format("{} (entity {}, {})", element.tag, element.block->entity,
                     groups.empty()
                         ? std::string("no physical group")
                         : fmt::format("physical group \"{}\"", fmt::join(groups, "\", \"")));
}

template <int dim>
std::string place_of(const Mesh<dim>& mesh, std::span<const std::int32_t> nodes) {
  Vector<dim> sum = Vector<dim>::Zero();
  for (const std::int32_t i : nodes) sum += mesh.nodes[i];
  const Vector<dim> x = sum / static_cast<double>(nodes.size());
  return fmt::format("({:.6g})", fmt::join(x.data(), x.data() + dim, ", "));
}

bool same_entity(const FileElement& a, const FileElement& b) {
  return a.block->dimension == b.block->dimension && a.block->entity == b.block->entity;
}

/// Marks the copies of cells that only label them.
template <int dim>
class CellCopies {
 public:
  CellCopies(const MeshOrigin& origin, const Mesh<dim>& mesh) : origin_(origin), mesh_(mesh) {
    const double distance = coincidence_distance(mesh);
    const auto place = nodes_in_place<dim>(mesh.nodes, distance);
    SortedSets sets;
    sets.reserve(mesh.num_cells());
    std::vector<std::int32_t> places;
    for (std::int32_t c = 0; c < mesh.num_cells(); ++c) {
      places.clear();
      for (const std::int32_t i : corners_of(mesh, c)) places.push_back(place[i]);
      sets.emplace_back(node_set(places), c);
    }
    for_each_run(sets, [this](std::span<const std::pair<NodeSet, std::int32_t>> run) {
      for (const auto& later : run.subspan(1)) {
        refuse_unless_label(run.front().second, later.second, run.size());
        copies_.push_back(later.second);
      }
    });
    std::sort(copies_.begin(), copies_.end());
  }

  const std::vector<std::int32_t>& cells() const { return copies_; }  ///< ascending

 private:
  void refuse_unless_label(std::int32_t first, std::int32_t later, std::size_t count) const {
    const FileElement &a = origin_.cells[first], &b = origin_.cells[later];
    const bool same_nodes =
        node_set(corners_of(mesh_, first)) == node_set(corners_of(mesh_, later));
    const std::size_t num_groups = group_names(origin_.file, *a.block).size();
    if (same_nodes && same_entity(a, b) && num_groups > 1 && count <= num_groups) return;
    throw ConfigError(fmt::format(
        "{}: section $Elements: found a {} twice at {}{}: elements {} and {}; both would have mass "
        "and stiffness there, allowed: each cell once",
        origin_.path, name(mesh_.cell_type), place_of(mesh_, mesh_.cell(later)),
        same_nodes ? "" : ", on nodes of its own each time", text_of(origin_.file, a),
        text_of(origin_.file, b)));
  }

  const MeshOrigin& origin_;
  const Mesh<dim>& mesh_;
  std::vector<std::int32_t> copies_;
};

}  // namespace

std::vector<std::string> group_names(const GmshFile& file, const GmshFile::ElementBlock& block) {
  std::vector<std::string> names;
  const auto tags = file.physical_tags.find({block.dimension, block.entity});
  if (tags == file.physical_tags.end()) return names;
  for (int tag : tags->second) {
    const auto found = file.physical_names.find({block.dimension, tag});
    names.push_back(found == file.physical_names.end() ? std::to_string(tag) : found->second);
  }
  return names;
}

template <int dim>
void settle_doubled_cells(MeshOrigin& origin, Mesh<dim>& mesh) {
  const CellCopies<dim> copies(origin, mesh);
  const std::vector<std::int32_t>& which = copies.cells();
  if (which.empty()) return;
  log::info("{}: {} cells are in the file once for each of their physical groups; each counts once",
            origin.path, which.size());
  Mesh<dim> all = std::move(mesh);
  const std::vector<FileElement> elements = std::move(origin.cells);
  mesh = {};
  mesh.cell_type = all.cell_type;
  mesh.nodes = std::move(all.nodes);
  origin.cells.clear();
  std::vector<std::int32_t> number(all.num_cells(), -1);
  for (std::int32_t c = 0; c < all.num_cells(); ++c) {
    if (std::binary_search(which.begin(), which.end(), c)) continue;
    number[c] = mesh.num_cells();
    const auto nodes = all.cell(c);
    mesh.cells.insert(mesh.cells.end(), nodes.begin(), nodes.end());
    origin.cells.push_back(elements[c]);
  }
  for (const auto& [group, cells] : all.cell_groups) {
    for (const std::int32_t c : cells) {
      if (number[c] >= 0) mesh.cell_groups[group].push_back(number[c]);
    }
  }
}

template <int dim>
void settle_doubled_facets(MeshOrigin& origin, Mesh<dim>& mesh) {
  const std::size_t n = num_nodes(facet_type(mesh.cell_type));
  const std::size_t corners = num_corners(facet_type(mesh.cell_type));
  for (auto& [group, facets] : mesh.facet_groups) {
    const auto facet = [&, &nodes = facets](std::int32_t f) {
      return std::span(nodes).subspan(f * n, corners);
    };
    SortedSets sets;
    const auto num_facets = static_cast<std::int32_t>(facets.size() / n);
    for (std::int32_t f = 0; f < num_facets; ++f) sets.emplace_back(node_set(facet(f)), f);
    std::vector<char> is_copy(num_facets, 0);
    const auto& elements = origin.facets.at(group);
    for_each_run(sets, [&](std::span<const std::pair<NodeSet, std::int32_t>> run) {
      const std::int32_t first = run.front().second;
      for (const auto& [set, later] : run.subspan(1)) {
        is_copy[later] = 1;
        if (same_sense(facet(first), facet(later))) continue;
        throw ConfigError(fmt::format(
            "{}: section $Elements: found a facet between two cells twice at {}, in both senses of "
            "rotation: elements {} and {}; allowed: each facet of a group once",
            origin.path, place_of(mesh, facet(first)), text_of(origin.file, elements[first]),
            text_of(origin.file, elements[later])));
      }
    });
    const auto count = std::count(is_copy.begin(), is_copy.end(), 1);
    if (count == 0) continue;
    log::info("{}: {} facets of group \"{}\" are in the file more than once; each counts once",
              origin.path, count, group);
    std::vector<std::int32_t> kept;
    for (std::int32_t f = 0; f < num_facets; ++f) {
      const auto nodes = std::span(facets).subspan(f * n, n);
      if (is_copy[f] == 0) kept.insert(kept.end(), nodes.begin(), nodes.end());
    }
    facets = std::move(kept);
  }
}

template <int dim>
void refuse_cells_on_one_side(const MeshOrigin& origin, const FacetOwners& owners,
                              const Mesh<dim>& mesh) {
  const std::size_t n = num_corners(facet_type(mesh.cell_type));
  owners.for_each_shared([&](std::span<const FacetOwners::Owner> of_facet) {
    for (std::size_t k = 1; k < of_facet.size(); ++k) {
      for (std::size_t l = 0; l < k; ++l) {
        const auto a = cell_facet(mesh, of_facet[l].cell, of_facet[l].facet);
        const auto b = cell_facet(mesh, of_facet[k].cell, of_facet[k].facet);
        if (!same_sense(std::span(a).first(n), std::span(b).first(n))) continue;
        throw ConfigError(fmt::format(
            "{}: section $Elements: found two {} on one side of a facet that they share, at {}: "
            "elements {} and {}; they overlap, allowed: cells that fill space once",
            origin.path, name(mesh.cell_type), place_of(mesh, std::span(a).first(n)),
            text_of(origin.file, origin.cells[of_facet[l].cell]),
            text_of(origin.file, origin.cells[of_facet[k].cell])));
      }
    }
  });
}

template void settle_doubled_cells<2>(MeshOrigin&, Mesh<2>&);
template void settle_doubled_cells<3>(MeshOrigin&, Mesh<3>&);
template void settle_doubled_facets<2>(MeshOrigin&, Mesh<2>&);
template void settle_doubled_facets<3>(MeshOrigin&, Mesh<3>&);
template void refuse_cells_on_one_side<2>(const MeshOrigin&, const FacetOwners&, const Mesh<2>&);
template void refuse_cells_on_one_side<3>(const MeshOrigin&, const FacetOwners&, const Mesh<3>&);

}  // namespace gabion
