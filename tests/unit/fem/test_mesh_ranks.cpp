// SPDX-License-Identifier: BSD-3-Clause
// How the mesh of a structure is shared out among the ranks.
#include <gtest/gtest.h>

#include <map>
#include <numeric>

#include "common/mechanics/ranks/gather.hpp"
#include "fem_solver/step/equilibrium.hpp"
#include "fem_solver/step/kept_factor.hpp"
#include "tests/support/expect_error.hpp"
#include "tests/unit/fem/fem_scene.hpp"

namespace gabion::test::test_mesh_ranks {
namespace {

template <int dim>
Json structure(const Json& mesh, const std::string& group) {
  return {{"dimension", dim},
          {"mesh", mesh},
          {"material", elastic("neo_hookean", 1e6, 0.3, 1000)},
          {"supports", {{{"group", group}}}}};
}

Json mesh_file(const std::string& name) {
  return {{"file", std::string(MESH_DATA) + "/" + name}};
}

/// Numbers of all ranks, ascending.
std::vector<std::int64_t> sorted_of_all(const std::vector<std::int64_t>& own) {
  auto all = gather_on_all<std::int64_t>(comm(), own);
  std::ranges::sort(all);
  return all;
}

std::vector<std::int64_t> numbers_up_to(std::int64_t end) {
  std::vector<std::int64_t> numbers(end);
  std::iota(numbers.begin(), numbers.end(), 0);
  return numbers;
}

/// Each facet of a group once, by the numbers of its nodes in the whole, in any order.
template <int dim>
std::vector<std::vector<std::int64_t>> facets_of_all(const fem::FemSettings<dim>& settings,
                                                     const std::string& group, MPI_Comm on) {
  const std::size_t n = num_nodes(facet_type(settings.mesh.cell_type));
  std::vector<std::int64_t> own;
  for (const std::int32_t i : settings.mesh.facet_groups.at(group)) {
    own.push_back(settings.ranks.node_of_all(i));
  }
  const auto all = gather_on_all<std::int64_t>(on, own);
  std::vector<std::vector<std::int64_t>> facets;
  for (std::size_t first = 0; first < all.size(); first += n) {
    facets.emplace_back(all.begin() + first, all.begin() + first + n);
  }
  std::ranges::sort(facets);
  return facets;
}

/// The parts make up the whole mesh, which one rank reads beside them.
template <int dim>
void expect_whole(const Json& json) {
  SCOPED_TRACE(json.at("mesh").dump());
  const auto part = fem_settings<dim>(json, comm()), whole = fem_settings<dim>(json);
  const Mesh<dim>&mesh = part.mesh, &all = whole.mesh;
  const fem::MeshRanks& ranks = part.ranks;
  EXPECT_EQ(ranks.alone(), size() == 1);
  EXPECT_EQ(ranks.num_nodes_of_all(mesh), all.num_nodes_total());
  EXPECT_EQ(ranks.num_cells_of_all(mesh), all.num_cells());
  EXPECT_EQ(mesh.cell_type, all.cell_type);
  EXPECT_EQ(sorted_of_all(ranks.own_cells(mesh.num_cells())), numbers_up_to(all.num_cells()));
  EXPECT_EQ(sorted_of_all(ranks.owned_nodes(mesh.num_nodes_total())),
            numbers_up_to(all.num_nodes_total()));
  for (std::int32_t i = 0; i < mesh.num_nodes_total(); ++i) {
    EXPECT_EQ(mesh.nodes[i], all.nodes[ranks.node_of_all(i)]);
    EXPECT_EQ(ranks.held_node(ranks.node_of_all(i)), i);
  }
  for (std::int32_t c = 0; c < mesh.num_cells(); ++c) {
    const auto own = mesh.cell(c), expected = all.cell(ranks.cell_of_all(c));
    EXPECT_TRUE(
        std::ranges::equal(own, expected, {}, [&](auto i) { return ranks.node_of_all(i); }));
    EXPECT_EQ(ranks.held_cell(ranks.cell_of_all(c)), c);
  }
  ASSERT_EQ(mesh.facet_groups.size(), all.facet_groups.size());
  for (const auto& [group, facets] : all.facet_groups) {
    EXPECT_EQ(facets_of_all(part, group, comm()), facets_of_all(whole, group, MPI_COMM_SELF));
    std::vector<std::int32_t> expected;
    for (const std::int32_t i : all.group_nodes(group, "test")) {
      if (ranks.held_node(i) >= 0) expected.push_back(ranks.held_node(i));
    }
    EXPECT_EQ(ranks.group_nodes(mesh, group, "test"), expected) << group;
  }
  EXPECT_EQ(fem::front_width(mesh, ranks), fem::front_width(all));
  EXPECT_EQ(fem::is_slender(mesh, ranks), fem::is_slender(all));
}

TEST(MeshRanks, parts_of_a_box_make_up_the_whole) {
  for (const std::string type : {"tri3", "quad4"}) {
    expect_whole<2>(structure<2>(box_2d({3, 1}, {9, 4}, type), "left"));
  }
  for (const std::string type : {"tet4", "hex8"}) {
    expect_whole<3>(structure<3>(box_3d({1, 4, 2}, {3, 8, 5}, type), "bottom"));
  }
  Json alternate = structure<3>(box_3d({2, 1, 1}, {4, 3, 2}, "tet4"), "bottom");
  alternate["mesh"]["box"]["alternate"] = true;
  expect_whole<3>(alternate);
}

TEST(MeshRanks, parts_of_a_file_make_up_the_whole) {
  for (const char* name : {"bricks.msh", "tetrahedra.msh"}) {
    const auto mesh = read_gmsh<3>(std::string(MESH_DATA) + "/" + name);
    expect_whole<3>(structure<3>(mesh_file(name), mesh.facet_groups.begin()->first));
  }
  const auto mesh = read_gmsh<2>(std::string(MESH_DATA) + "/plate.msh");
  expect_whole<2>(structure<2>(mesh_file("plate.msh"), mesh.facet_groups.begin()->first));
}

TEST(MeshRanks, parts_are_of_equal_size) {
  const auto part = fem_settings<3>(structure<3>(box_3d({4, 1, 1}, {24, 6, 6}), "left"), comm());
  EXPECT_NEAR(part.mesh.num_cells(), 24.0 * 36 / size(), 36);
  EXPECT_LT(part.mesh.num_nodes_total(), 25.0 * 49 / size() + 2 * 49);
}

TEST(MeshRanks, errors_of_a_file_come_on_all_ranks) {
  expect_error<ConfigError>(
      [] {
        fem_settings<2>(structure<2>({{"file", "/nowhere/a.msh"}}, "left"), comm());
      },
      {"fem.json: at /mesh/file", "/nowhere/a.msh: cannot open this mesh file"});
}

/// M times a field that is linear in space: by node as on one rank, and its sum the first moment.
TEST(MeshRanks, nodal_sums_are_those_of_one_rank) {
  for (const std::string mass : {"consistent", "lumped"}) {
    Json json = structure<3>(box_3d({1, 3, 1}, {2, 7, 3}), "bottom");
    json["mass"] = mass;
    const auto times_x = [](const fem::FemSettings<3>& settings, MPI_Comm on) {
      const fem::BoundaryConditions<3> conditions(settings);
      const fem::Equilibrium<3> equilibrium(settings, conditions, on);
      std::vector<double> y;
      for (const auto& x : settings.mesh.nodes) y.insert(y.end(), {1.0, x[1], x[0] - x[2]});
      return equilibrium.mass_times(y);
    };
    const auto part = fem_settings<3>(json, comm()), whole = fem_settings<3>(json);
    const auto own = times_x(part, comm()), all = times_x(whole, MPI_COMM_SELF);
    double total = 0;
    for (std::size_t k = 0; k < own.size(); ++k) {
      const auto held = static_cast<std::int32_t>(k / 3);
      EXPECT_NEAR(own[k], all[part.ranks.node_of_all(held) * 3 + k % 3], 1e-9);
      if (part.ranks.shared().owns(held) && k % 3 == 0) total += own[k];
    }
    EXPECT_NEAR(part.ranks.shared().total(total), 3000, 1e-8);
    auto of_owners = own;
    part.ranks.shared().take_from_owners(of_owners, 3);
    EXPECT_EQ(of_owners, own);
  }
}

}  // namespace
}  // namespace gabion::test::test_mesh_ranks
