// SPDX-License-Identifier: BSD-3-Clause
// Wet facets of structures that lose cells.
#include "fem_solver/interface/exposed_facets.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <random>
#include <set>

#include "common/mechanics/mesh/boundary.hpp"
#include "common/mechanics/mesh/cell_groups.hpp"
#include "tests/support/expect_error.hpp"
#include "tests/unit/fem/energy_balance.hpp"
#include "tests/unit/fem/yielding_tower.hpp"

namespace gabion::test::test_exposed_facets {
namespace {

using fem::ExposedFacets;

/// Facets as a set, each from its least node on: its sense is kept.
template <class Number>
std::multiset<std::vector<std::int64_t>> facet_set(const std::vector<Number>& facets, int n) {
  std::multiset<std::vector<std::int64_t>> result;
  for (std::size_t f = 0; f < facets.size(); f += n) {
    std::vector<std::int64_t> facet(facets.begin() + f, facets.begin() + f + n);
    std::rotate(facet.begin(), std::min_element(facet.begin(), facet.end()), facet.end());
    result.insert(facet);
  }
  return result;
}

/// Cells that grow from one side of a box into it.
template <int dim>
std::vector<char> grown_hole(const Mesh<dim>& mesh, std::int32_t first, int size, unsigned seed) {
  std::mt19937 random(seed);
  const auto neighbours = cell_neighbours(mesh);
  const auto faces = neighbours.size() / mesh.num_cells();
  std::vector<char> gone(static_cast<std::size_t>(mesh.num_cells()), 0);
  std::vector<std::int32_t> hole = {first};
  gone[first] = 1;
  while (std::ssize(hole) < size) {
    const std::int32_t c = hole[random() % hole.size()];
    const std::int32_t next = neighbours[c * faces + random() % faces];
    if (next < 0 || gone[next] != 0) continue;
    gone[next] = 1;
    hole.push_back(next);
  }
  return gone;
}

/// The boundary of the cells that remain, less what was the boundary before and was not wet.
template <int dim>
std::multiset<std::vector<std::int64_t>> boundary_of_rest(const Mesh<dim>& mesh,
                                                          const std::vector<char>& gone,
                                                          const std::string& wet) {
  const int n = num_nodes(facet_type(mesh.cell_type));
  Mesh<dim> rest = mesh;
  rest.cells.clear();
  for (std::int32_t c = 0; c < mesh.num_cells(); ++c) {
    const auto cell = mesh.cell(c);
    if (gone[c] == 0) rest.cells.insert(rest.cells.end(), cell.begin(), cell.end());
  }
  if (rest.cells.empty()) return {};
  auto expected = facet_set(boundary_facets(rest), n);
  const auto outer = facet_set(boundary_facets(mesh), n);
  const auto side = facet_set(mesh.facets(wet, "here"), n);
  std::erase_if(expected,
                [&](const auto& facet) { return outer.contains(facet) && !side.contains(facet); });
  return expected;
}

template <int dim>
void expect_boundary(CellType type, const std::array<int, dim>& cells) {
  Eigen::Matrix<int, dim, 1> counts;
  for (int i = 0; i < dim; ++i) counts[i] = cells[i];
  const Mesh<dim> mesh = box_mesh<dim>(Vector<dim>::Zero(), Vector<dim>::Ones(), counts, type);
  const std::vector<std::int32_t> all = cells_of_groups(mesh, {"all"}, "here");
  ASSERT_EQ(std::ssize(all), mesh.num_cells());
  const auto& left = mesh.facets("left", "here");
  const ExposedFacets<dim> exposed(mesh, std::vector<std::int64_t>(left.begin(), left.end()), all);
  const int n = num_nodes(facet_type(type));
  std::vector<char> none(all.size(), 0);
  EXPECT_EQ(exposed.facets(none), std::vector<std::int64_t>(left.begin(), left.end()));
  const std::int32_t first = exposed.cells()[exposed.cells().size() / 2];
  ASSERT_GE(first, 0);
  for (unsigned seed = 1; seed <= 20; ++seed) {
    for (const int size : {1, 2, 5, mesh.num_cells() / 2, mesh.num_cells()}) {
      const auto gone = grown_hole(mesh, first, size, seed);
      EXPECT_EQ(facet_set(exposed.facets(gone), n), boundary_of_rest(mesh, gone, "left"))
          << seed << " " << size;
    }
  }
}

TEST(ExposedFacets, are_the_boundary_of_the_cells_that_remain) {
  expect_boundary<2>(CellType::quad4, {4, 5});
  expect_boundary<2>(CellType::tri3, {3, 4});
  expect_boundary<3>(CellType::hex8, {3, 3, 3});
  expect_boundary<3>(CellType::tet4, {2, 2, 2});
}

/// A hole inside, and one behind cells that may not leave, has no soil.
TEST(ExposedFacets, holes_without_soil_are_dry) {
  const Mesh<2> mesh = box_mesh<2>({0, 0}, {3, 3}, {3, 3}, CellType::quad4);
  const auto& left = mesh.facets("left", "here");
  const std::vector<std::int64_t> wet(left.begin(), left.end());
  const auto all = cells_of_groups(mesh, {"all"}, "here");
  std::vector<char> gone(9, 0);
  gone[4] = 1;  // the middle one
  EXPECT_EQ(ExposedFacets<2>(mesh, wet, all).facets(gone), wet);
  gone[3] = 1;  // left of it: three faces around each, less the one between them
  EXPECT_EQ(ExposedFacets<2>(mesh, wet, all).facets(gone).size(), 2 * (3 - 1 + 5));
  const std::vector<std::int32_t> first_column = {0, 3, 6};
  EXPECT_EQ(ExposedFacets<2>(mesh, wet, first_column).facets(gone).size(), 2 * (3 - 1 + 3));
  const std::vector<std::int32_t> middle = {4};
  EXPECT_EQ(ExposedFacets<2>(mesh, wet, middle).facets(gone), wet);
}

/// Two columns of a wall, pushed from the left until the first cell is gone.
Json wall() {
  Json material = elastic("von_mises", 1e6, 0.3, 1000);
  material["yield_stress"] = 1e3;
  material["hardening_modulus"] = 1e4;
  material["failure_plastic_strain"] = 0.05;
  material["fade_steps"] = 2;
  return {{"dimension", 2},
          {"mesh", box_2d({0.5, 1}, {2, 4})},
          {"material", material},
          {"mass", "lumped"},
          {"gravity", {0, -10}},
          {"supports", {{{"group", "bottom"}}, {{"group", "right"}}}},
          {"interfaces", {{{"name", "wall"}, {"groups", {"left"}}, {"behind", {"all"}}}}}};
}

/// Forces to the right on the vertices that facets have, and an answer of the step.
InterfaceValues pushed(fem::FemSolver<2>& solver, int n, double force) {
  const InterfaceMesh mesh = solver.interfaces().front();
  std::vector<double> values(mesh.coordinates.size(), 0.0);
  const InterfaceFacets facets = solver.facets();
  for (const std::int64_t v : facets.at("wall")) values[v * 2] += force;
  InterfaceValues sent;
  const StepRequest request{n, 0, (n - 1) * 1e-3, 1e-3};
  solver.solve_step(request, {{"wall", values}}, sent);
  solver.accept_step(request, true);
  return sent;
}

TEST(ChangingSurfaces, facets_go_with_their_cells_and_come_back_at_a_restart) {
  const auto solver = fem_solver<2>(wall());
  const InterfaceMesh mesh = solver->interfaces().front();
  EXPECT_EQ(mesh.num_vertices(), 15);  // all nodes of the cells
  EXPECT_EQ(solver->facets().at("wall"), mesh.facets);
  int n = 0;
  while (solver->facets().at("wall") == mesh.facets && n < 300) pushed(*solver, ++n, 2000);
  ASSERT_LT(n, 300);
  const InterfaceFacets changed = solver->facets();
  const State state = solver->save_state();
  const auto other = fem_solver<2>(wall());
  other->load_state(state);
  EXPECT_EQ(other->facets(), changed);
  InterfaceFacets last = changed;
  for (int k = 0; k < 200; ++k) {
    ++n;
    const InterfaceValues sent = pushed(*solver, n, 2000), again = pushed(*other, n, 2000);
    ASSERT_EQ(sent, again) << n;
    ASSERT_EQ(solver->facets(), other->facets()) << n;
    last = solver->facets();
  }
  EXPECT_NE(last, changed);  // the second column fails too
  EXPECT_EQ(solver->save_state().reals, other->save_state().reals);
}

TEST(ChangingSurfaces, what_cannot_change_is_refused) {
  Json json = wall();
  json["interfaces"][0]["behind"] = {"stone"};
  expect_error<ConfigError>([&] { fem_solver<2>(json); },
                            {"/interfaces/0/behind", "\"stone\"", "allowed: all"});
  json = wall();
  json["material"] = elastic("neo_hookean", 1e6, 0.3, 1000);
  expect_error<ConfigError>([&] { fem_solver<2>(json); },
                            {"/interfaces/0/behind", "failure_plastic_strain"});
  json = wall();
  json["interfaces"].push_back({{"name", "roof"}, {"groups", {"top"}}});
  expect_error<ConfigError>([&] { fem_solver<2>(json); },
                            {"/interfaces/1/groups", "behind the interface \"wall\""});
  json["interfaces"][1]["behind"] = {"all"};
  expect_error<ConfigError>([&] { fem_solver<2>(json); },
                            {"/interfaces/1/behind", "behind another interface too"});
  json = wall();
  json["mesh"] = box_2d({0.5, 1}, {2, 4}, "quad8");
  expect_error<ConfigError>([&] { fem_solver<2>(json); },
                            {"/interfaces/0/behind", "quadratic cells"});
}

}  // namespace
}  // namespace gabion::test::test_exposed_facets
