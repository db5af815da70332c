// SPDX-License-Identifier: BSD-3-Clause
#include "mpm_solver/grid/cell_patches.hpp"

#include <Eigen/Geometry>
#include <algorithm>

#include "common/mechanics/elements/cell_facets.hpp"

namespace gabion::mpm {

namespace {

// Facets count as equally large when they differ by less than this share.
constexpr double same_size = 1e-6;

template <int dim>
class PatchBuilder {
 public:
  PatchBuilder(const Mesh<dim>& mesh, const CellLocator<dim>& locator)
      : mesh_(mesh), locator_(locator), patch_(mesh.num_cells(), -1) {}

  CellPatches build() {
    for (std::int32_t c = 0; c < mesh_.num_cells(); ++c) {
      if (patch_[c] < 0) grow(c);
    }
    place_rest();
    return list();
  }

 private:
  // A free cell beside the patch.
  struct Candidate {
    std::int32_t cell = -1;
    int new_nodes = 0;
    double facet = 0;         // size of the facet between them
    int free_neighbours = 0;  // cells that could still take it
  };
  static bool better(const Candidate& a, const Candidate& b) {
    if (b.cell < 0 || a.new_nodes != b.new_nodes) return b.cell < 0 || a.new_nodes < b.new_nodes;
    if (a.facet > (1 + same_size) * b.facet) return true;
    if (b.facet > (1 + same_size) * a.facet) return false;
    if (a.free_neighbours != b.free_neighbours) return a.free_neighbours < b.free_neighbours;
    return a.cell < b.cell;
  }

  double facet_size(std::int32_t c, int f) const {
    const auto nodes = mesh_.cell(c);
    const auto local = facet_nodes(mesh_.cell_type, f);
    const Vector<dim> side = mesh_.nodes[nodes[local[1]]] - mesh_.nodes[nodes[local[0]]];
    if constexpr (dim == 2) {
      return side.norm();
    } else {
      return side.cross(mesh_.nodes[nodes[local[2]]] - mesh_.nodes[nodes[local[0]]]).norm();
    }
  }
  int free_neighbours(std::int32_t c) const {
    int count = 0;
    for (const std::int32_t other : locator_.neighbours(c))
      count += other >= 0 && patch_[other] < 0;
    return count;
  }
  int new_nodes(std::int32_t c) const {
    int count = 0;
    for (const std::int32_t node : mesh_.cell(c)) {
      count += std::find(nodes_.begin(), nodes_.end(), node) == nodes_.end();
    }
    return count;
  }

  Candidate best_candidate() const {
    Candidate best;
    for (const std::int32_t c : cells_) {
      const auto neighbours = locator_.neighbours(c);
      for (int f = 0; f < num_facets(mesh_.cell_type); ++f) {
        const std::int32_t other = neighbours[f];
        if (other < 0 || patch_[other] >= 0) continue;
        const Candidate candidate{other, new_nodes(other), facet_size(c, f),
                                  free_neighbours(other)};
        if (better(candidate, best)) best = candidate;
      }
    }
    return best;
  }

  void take(std::int32_t c, std::int32_t number) {
    patch_[c] = number;
    cells_.push_back(c);
    for (const std::int32_t node : mesh_.cell(c)) {
      if (std::find(nodes_.begin(), nodes_.end(), node) == nodes_.end()) nodes_.push_back(node);
    }
  }

  // A patch that starts with one cell. Stays incomplete where it finds no free neighbour.
  void grow(std::int32_t seed) {
    constexpr std::size_t full = 1 << dim;
    const auto number = static_cast<std::int32_t>(complete_.size());
    cells_.clear();
    nodes_.clear();
    take(seed, number);
    while (true) {
      const Candidate best = best_candidate();
      if (best.cell < 0 || nodes_.size() + best.new_nodes > full) break;
      take(best.cell, number);
    }
    complete_.push_back(nodes_.size() >= full);
    sizes_.push_back(static_cast<int>(cells_.size()));
  }

  // Give each cell of an incomplete patch to the smallest complete patch beside it, one after the
  // other; where there is none the patch stays as it is.
  void place_rest() {
    for (bool moved = true; moved;) {
      moved = false;
      for (std::int32_t c = 0; c < mesh_.num_cells(); ++c) {
        if (complete_[patch_[c]]) continue;
        std::int32_t best = -1;
        for (const std::int32_t other : locator_.neighbours(c)) {
          if (other < 0 || !complete_[patch_[other]]) continue;
          if (best < 0 || sizes_[patch_[other]] < sizes_[best]) best = patch_[other];
        }
        if (best < 0) continue;
        --sizes_[patch_[c]];
        ++sizes_[best];
        patch_[c] = best;
        moved = true;
      }
    }
  }

  CellPatches list() const {
    std::vector<std::int32_t> order(complete_.size(), -1);
    std::vector<std::vector<std::int32_t>> members;
    for (std::int32_t c = 0; c < mesh_.num_cells(); ++c) {
      std::int32_t& number = order[patch_[c]];
      if (number < 0) {
        number = static_cast<std::int32_t>(members.size());
        members.emplace_back();
      }
      members[number].push_back(c);
    }
    CellPatches patches;
    patches.starts.push_back(0);
    patches.first_of.resize(patch_.size());
    for (const auto& cells : members) {
      patches.cells.insert(patches.cells.end(), cells.begin(), cells.end());
      patches.starts.push_back(static_cast<std::int32_t>(patches.cells.size()));
      for (const std::int32_t c : cells) patches.first_of[c] = cells.front();
    }
    return patches;
  }

  const Mesh<dim>& mesh_;
  const CellLocator<dim>& locator_;
  std::vector<std::int32_t> patch_;  // of each cell; -1: free
  std::vector<char> complete_;       // of each patch
  std::vector<int> sizes_;           // of each patch, cells
  std::vector<std::int32_t> cells_;  // of the patch that grows
  std::vector<std::int32_t> nodes_;
};

}  // namespace

template <int dim>
CellPatches join_cells(const Mesh<dim>& mesh, const CellLocator<dim>& locator) {
  return PatchBuilder<dim>(mesh, locator).build();
}

template CellPatches join_cells<2>(const Mesh<2>&, const CellLocator<2>&);
template CellPatches join_cells<3>(const Mesh<3>&, const CellLocator<3>&);

}  // namespace gabion::mpm
