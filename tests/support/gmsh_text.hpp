// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <unistd.h>

#include <array>
#include <filesystem>
#include <fstream>
#include <string>
#include <vector>

#include "common/mechanics/mesh/mesh.hpp"

namespace gabion::test {

/// A Gmsh file of format 4.1 as text. Nodes and elements are numbered from 1 on.
struct GmshText {
  struct Group {
    int dimension, tag;
    std::string name;
  };
  struct Entity {
    int dimension, tag;
    std::vector<int> groups;
  };
  struct Block {
    int dimension, entity,
        type;  ///< Gmsh's type: 1 line, 2 triangle, 3 quad, 4 tet, 5 hex, 15 point
    std::vector<std::vector<int>> elements;
  };
  std::vector<Group> groups;
  std::vector<Entity> entities;
  std::vector<std::array<double, 3>> nodes;
  std::vector<Block> blocks;

  std::string text() const {
    std::string names = fmt::format("{}\n", groups.size()), shapes, cells;
    for (const auto& g : groups) names += fmt::format("{} {} \"{}\"\n", g.dimension, g.tag, g.name);
    std::array<int, 4> counts{};
    for (int d = 0; d < 4; ++d) {
      for (const auto& entity : entities) {
        if (entity.dimension != d) continue;
        ++counts[d];
        shapes +=
            fmt::format("{} 0 0 0 {}{} {}{}\n", entity.tag, d > 0 ? "1 1 1 " : "",
                        entity.groups.size(), fmt::join(entity.groups, " "), d > 0 ? " 0" : "");
      }
    }
    int tag = 0;
    for (const auto& block : blocks) {
      cells += fmt::format("{} {} {} {}\n", block.dimension, block.entity, block.type,
                           block.elements.size());
      for (const auto& e : block.elements)
        cells += fmt::format("{} {}\n", ++tag, fmt::join(e, " "));
    }
    std::string points = fmt::format("1 {0} 1 {0}\n2 1 0 {0}\n", nodes.size());
    for (std::size_t i = 1; i <= nodes.size(); ++i) points += fmt::format("{}\n", i);
    for (const auto& x : nodes) points += fmt::format("{}\n", fmt::join(x, " "));
    return fmt::format(
        "$MeshFormat\n4.1 0 8\n$EndMeshFormat\n$PhysicalNames\n{}$EndPhysicalNames\n"
        "$Entities\n{}\n{}$EndEntities\n$Nodes\n{}$EndNodes\n$Elements\n{} {} 1 {}\n{}"
        "$EndElements\n",
        names, fmt::join(counts, " "), shapes, points, blocks.size(), tag, tag, cells);
  }
};

/// Two squares of 1 m on each other, or what is made of them: "foot" below, "top" above.
inline GmshText tower() {
  return {.groups = {{1, 1, "foot"}, {1, 2, "top"}, {2, 3, "body"}},
          .entities = {{1, 1, {1}}, {1, 2, {2}}, {2, 1, {3}}},
          .nodes = {{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0}, {1, 2, 0}, {0, 2, 0}},
          .blocks = {
              {1, 1, 1, {{1, 2}}}, {1, 2, 1, {{5, 6}}}, {2, 1, 3, {{1, 2, 3, 4}, {4, 3, 5, 6}}}}};
}

/// The squares of tower(), the upper one on nodes of its own.
inline GmshText loose_tower() {
  GmshText file = tower();
  file.nodes.insert(file.nodes.end(), {{1, 1, 0}, {0, 1, 0}});
  file.blocks[2].elements[1] = {8, 7, 5, 6};
  return file;
}

/// A mesh file that vanishes with this object; one a process and number.
class TemporaryMesh {
 public:
  explicit TemporaryMesh(const std::string& text, int number = 0)
      : path_(std::filesystem::temp_directory_path() /
              fmt::format("gabion_mesh_{}_{}.msh", getpid(), number)) {
    std::ofstream(path_) << text;
  }
  explicit TemporaryMesh(const GmshText& file, int number = 0)
      : TemporaryMesh(file.text(), number) {}
  ~TemporaryMesh() { std::filesystem::remove(path_); }
  TemporaryMesh(const TemporaryMesh&) = delete;
  TemporaryMesh& operator=(const TemporaryMesh&) = delete;
  TemporaryMesh(TemporaryMesh&&) = delete;
  TemporaryMesh& operator=(TemporaryMesh&&) = delete;

  std::string path() const { return path_.string(); }

 private:
  std::filesystem::path path_;
};

template <int dim>
Mesh<dim> read_text(const GmshText& file) {
  const TemporaryMesh mesh(file);
  return read_gmsh<dim>(mesh.path());
}

}  // namespace gabion::test
