// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include <algorithm>

#include "common/mechanics/mesh/connected_parts.hpp"
#include "tests/support/gmsh_text.hpp"
#include "tests/unit/mesh/mesh_checks.hpp"

namespace gabion::test_doubled_elements {
namespace {

using test::expect_error;
using test::GmshText;
using test::loose_tower;
using test::read_text;
using test::tower;

/// Two tetrahedra on one triangle, whose outer side is the group "side".
GmshText two_tetrahedra() {
  return {.groups = {{2, 1, "side"}, {3, 2, "rock"}},
          .entities = {{2, 1, {1}}, {3, 1, {2}}},
          .nodes = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}, {1, 1, 1}},
          .blocks = {{2, 1, 2, {{1, 2, 4}}}, {3, 1, 4, {{1, 2, 3, 4}, {2, 3, 4, 5}}}}};
}

TEST(DoubledElements, a_cell_that_stands_twice_is_refused_with_both_names) {
  GmshText file = tower();
  file.blocks[2].elements.push_back({1, 2, 3, 4});
  expect_error<ConfigError>([&] { read_text<2>(file); },
                            {"quad4 twice at (0.5, 0.5)", "elements 3 (entity 1", "and 5 (entity 1",
                             "\"body\"", "each cell once"});
}

/// A model whose surface was made twice has the same facet with another order of nodes, entity and
/// group.
TEST(DoubledElements, whatever_the_order_of_nodes_and_whichever_the_entity) {
  GmshText file = tower();
  file.groups.push_back({2, 4, "again"});
  file.entities.push_back({2, 2, {4}});
  file.blocks.push_back({2, 2, 3, {{3, 4, 1, 2}}});
  expect_error<ConfigError>([&] { read_text<2>(file); }, {"\"body\"", "\"again\"", "twice"});
  file.blocks.back().elements = {{4, 3, 2, 1}};  // the other way round
  expect_error<ConfigError>([&] { read_text<2>(file); }, {"\"body\"", "\"again\"", "twice"});
  GmshText solid = two_tetrahedra();
  solid.blocks[1].elements.push_back({4, 1, 2, 3});
  expect_error<ConfigError>([&] { read_text<3>(solid); },
                            {"tet4 twice", "2 (entity 1", "4 (entity"});
}

/// A copy on nodes of its own, exact or within the digits of a file.
TEST(DoubledElements, a_copy_on_other_nodes_is_refused) {
  for (const double shift : {0.0, 1e-12, 1e-9}) {
    GmshText file = tower();
    for (int i = 0; i < 4; ++i) {
      auto x = file.nodes[i];
      x[0] += shift;
      file.nodes.push_back(x);
    }
    file.blocks[2].elements.push_back({7, 8, 9, 10});
    expect_error<ConfigError>([&] { read_text<2>(file); }, {"twice", "nodes of its own"});
  }
}

/// Gmsh writes files of format 2 with a cell once for each physical group, and keeps that as it
/// converts them.
TEST(DoubledElements, cells_of_an_entity_with_two_labels_count_once) {
  GmshText file = tower();
  file.groups.push_back({2, 4, "all"});
  file.entities[2].groups = {3, 4};
  const auto once = read_text<2>(file);
  file.blocks[2].elements = {{1, 2, 3, 4}, {1, 2, 3, 4}, {4, 3, 5, 6}, {4, 3, 5, 6}};
  const auto doubled = read_text<2>(file);
  EXPECT_EQ(doubled.cells, once.cells);
  EXPECT_EQ(doubled.cell_groups, once.cell_groups);
  EXPECT_EQ(doubled.facet_groups, once.facet_groups);
  file.blocks[2].elements.push_back({1, 2, 3, 4});  // a third time is no label
  expect_error<ConfigError>([&] { read_text<2>(file); }, {"twice", "\"body\", \"all\""});
}

TEST(DoubledElements, a_facet_counts_once_in_each_of_its_groups) {
  GmshText file = tower();
  file.groups.push_back({1, 4, "crown"});
  file.entities[1].groups = {2, 4};
  file.blocks[1].elements = {{5, 6}, {6, 5}, {5, 6}};
  const auto mesh = read_text<2>(file);
  EXPECT_EQ(mesh.facets("top", ""), read_text<2>(tower()).facets("top", ""));
  EXPECT_EQ(mesh.facets("crown", ""), mesh.facets("top", ""));
  // Another entity of the same group.
  file.entities.push_back({1, 3, {2}});
  file.blocks.push_back({1, 3, 1, {{6, 5}}});
  EXPECT_EQ(read_text<2>(file).facets("top", "").size(), 2u);
}

TEST(DoubledElements, a_facet_between_cells_has_one_sense_in_a_group) {
  GmshText file = tower();
  file.blocks[1].elements = {{3, 4}, {3, 4}};
  EXPECT_EQ(read_text<2>(file).facets("top", ""), (std::vector<std::int32_t>{2, 3}));
  file.blocks[1].elements = {{3, 4}, {4, 3}};
  expect_error<ConfigError>([&] { read_text<2>(file); },
                            {"both senses", "elements 2", "and 3", "\"top\""});
  GmshText solid = two_tetrahedra();
  solid.blocks[0].elements = {{2, 3, 4}, {3, 4, 2}, {4, 2, 3}};
  EXPECT_EQ(read_text<3>(solid).facets("side", "").size(), 3u);
  solid.blocks[0].elements.push_back({3, 2, 4});
  expect_error<ConfigError>([&] { read_text<3>(solid); }, {"both senses", "\"side\""});
}

TEST(DoubledElements, cells_on_one_side_of_a_facet_overlap) {
  GmshText solid = two_tetrahedra();
  solid.nodes.push_back({2, 1, 1});
  solid.blocks[1].elements.push_back({2, 3, 4, 6});
  expect_error<ConfigError>([&] { read_text<3>(solid); }, {"two tet4 on one side", "3 (", "4 ("});
  GmshText file = tower();
  file.nodes.insert(file.nodes.end(), {{1.5, 2, 0}, {0, 3, 0}});
  file.blocks[2].elements.push_back({4, 3, 7, 8});
  expect_error<ConfigError>([&] { read_text<2>(file); }, {"two quad4 on one side", "they overlap"});
}

TEST(DoubledElements, an_empty_group_is_none) {
  GmshText file = tower();
  file.blocks[1].elements.clear();
  testing::internal::CaptureStderr();
  const auto mesh = read_text<2>(file);
  EXPECT_NE(
      testing::internal::GetCapturedStderr().find("\"top\" of a group of facets that has none"),
      std::string::npos);
  expect_error<ConfigError>([&] { static_cast<void>(mesh.facets("top", "here")); },
                            {"here", "\"top\"", "foot"});
}

TEST(ConnectedParts, nodes_in_one_place_that_are_not_joined) {
  const auto joined = connection_of(read_text<2>(tower()));
  EXPECT_EQ(joined.parts.size(), 1u);
  EXPECT_EQ(joined.num_unjoined, 0);
  for (const double gap : {0.0, 1e-12, 1e-9}) {
    GmshText file = loose_tower();
    file.nodes[6][1] += gap;
    const auto apart = connection_of(read_text<2>(file));
    ASSERT_EQ(apart.parts.size(), 2u);
    EXPECT_EQ(apart.num_unjoined, 2);
    EXPECT_EQ(apart.unjoined, (std::vector<std::int32_t>{2, 3, 6, 7}));
    EXPECT_EQ(apart.parts[0].groups, std::set<std::string>{"foot"});
    EXPECT_EQ(apart.parts[1].groups, std::set<std::string>{"top"});
    EXPECT_EQ(apart.parts[1].num_touching, 2);
    EXPECT_EQ(text_of(apart.parts[1]), "1 cell from (0, 1) to (1, 2)");
  }
}

/// A gap that is there on purpose is none of round-off.
TEST(ConnectedParts, a_real_gap_is_no_seam) {
  GmshText file = loose_tower();
  for (const int i : {6, 7}) file.nodes[i][1] += 1e-3;
  const auto apart = connection_of(read_text<2>(file));
  EXPECT_EQ(apart.parts.size(), 2u);
  EXPECT_EQ(apart.num_unjoined, 0);
}

/// The places are found in any lattice and far from the origin.
TEST(ConnectedParts, two_blocks_of_bricks) {
  for (const double origin : {0.0, 1e6}) {
    const Vector<3> low(origin, -origin, 0), middle = low + Vector<3>(1, 1, 1);
    auto mesh = box_mesh<3>(low, middle, {5, 4, 3}, CellType::hex8);
    const auto upper = box_mesh<3>(low + Vector<3>(0, 0, 1), middle + Vector<3>(0, 0, 1), {5, 4, 3},
                                   CellType::hex8);
    const std::int32_t count = mesh.num_nodes_total();
    mesh.nodes.insert(mesh.nodes.end(), upper.nodes.begin(), upper.nodes.end());
    for (const std::int32_t i : upper.cells) mesh.cells.push_back(i + count);
    mesh.facet_groups.clear();
    const auto apart = connection_of(mesh);
    EXPECT_EQ(apart.parts.size(), 2u);
    EXPECT_EQ(apart.num_unjoined, 30);
    EXPECT_EQ(apart.first_unjoined.size(), 3u);
  }
}

}  // namespace
}  // namespace gabion::test_doubled_elements
