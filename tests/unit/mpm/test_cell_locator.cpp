// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <random>

#include "common/mechanics/elements/cell_facets.hpp"
#include "common/mechanics/elements/shape_functions.hpp"
#include "common/mechanics/mesh/boundary.hpp"
#include "mpm_solver/grid/cell_locator.hpp"
#include "tests/support/expect_error.hpp"

namespace gabion::mpm::test_cell_locator {
namespace {

template <int dim>
Vector<dim> position(const Mesh<dim>& mesh, std::int32_t c, const Vector<dim>& xi) {
  ShapeValues<dim> shape;
  shape_functions<dim>(mesh.cell_type, xi, shape);
  Vector<dim> x = Vector<dim>::Zero();
  for (int a = 0; a < mesh.nodes_per_cell(); ++a) x += shape.N[a] * mesh.nodes[mesh.cell(c)[a]];
  return x;
}

/// Search of all cells by the planes of their facets; for cells with flat sides.
template <int dim>
class BruteForce {
 public:
  explicit BruteForce(const Mesh<dim>& mesh) : mesh_(mesh), facets_(num_facets(mesh.cell_type)) {
    const CellType type = facet_type(mesh.cell_type);
    for (std::int32_t c = 0; c < mesh.num_cells(); ++c) {
      for (int f = 0; f < facets_; ++f) {
        const auto nodes = cell_facet(mesh, c, f);
        const std::span facet(nodes.data(), static_cast<std::size_t>(num_nodes(type)));
        normals_.push_back(facet_geometry<dim>(mesh.nodes, type, facet)[0].normal);
        offsets_.push_back(normals_.back().dot(mesh.nodes[nodes[0]]));
      }
    }
  }

  /// Lowest cell that contains x up to 1e-11; -1 when none does.
  std::int32_t locate(const Vector<dim>& x) const {
    for (std::int32_t c = 0; c < mesh_.num_cells(); ++c) {
      bool inside = true;
      for (int f = c * facets_; f < (c + 1) * facets_; ++f) {
        inside &= normals_[f].dot(x) <= offsets_[f] + 1e-11;
      }
      if (inside) return c;
    }
    return -1;
  }

 private:
  const Mesh<dim>& mesh_;
  int facets_;
  std::vector<Vector<dim>> normals_;
  std::vector<double> offsets_;
};

template <int dim>
void move_inner_nodes(Mesh<dim>& mesh, double amount) {
  for (auto& x : mesh.nodes) {
    double bubble = amount;
    for (int i = 0; i < dim; ++i) bubble *= std::sin(M_PI * x[i]);
    x += bubble * Vector<dim>::LinSpaced(1.0, -0.6);
  }
}

template <int dim>
std::vector<Vector<dim>> special_points(const Mesh<dim>& mesh) {
  std::vector<Vector<dim>> points = mesh.nodes;
  for (std::int32_t c = 0; c < mesh.num_cells(); ++c) {
    const auto cell = mesh.cell(c);
    for (std::size_t a = 0; a < cell.size(); ++a) {  // middle of edges and diagonals
      points.push_back(0.5 * (mesh.nodes[cell[a]] + mesh.nodes[cell[(a + 1) % cell.size()]]));
    }
  }
  return points;
}

template <int dim>
void check_against_brute_force(const Mesh<dim>& mesh, int num_random) {
  const CellLocator<dim> locator(mesh);
  const BruteForce<dim> reference(mesh);
  auto points = special_points(mesh);
  std::mt19937 random(3);
  std::uniform_real_distribution<double> uniform(-0.1, 1.1);
  for (int i = 0; i < num_random; ++i) {
    Vector<dim> x;
    for (int k = 0; k < dim; ++k) x[k] = uniform(random);
    points.push_back(x);
  }
  std::uniform_int_distribution<std::int32_t> any_cell(0, mesh.num_cells() - 1);
  int outside = 0, wrong = 0;
  for (const auto& x : points) {
    const std::int32_t expected = reference.locate(x);
    outside += expected < 0;
    for (const std::int32_t hint : {-1, expected, any_cell(random), any_cell(random), 1 << 30}) {
      wrong += locator.locate(x, hint) != expected;
    }
  }
  EXPECT_EQ(wrong, 0);
  EXPECT_GT(outside, num_random / 20);
}

TEST(CellLocator, agrees_with_brute_force_in_the_plane) {
  for (const CellType type : {CellType::tri3, CellType::quad4}) {
    SCOPED_TRACE(name(type));
    auto mesh = box_mesh<2>({0, 0}, {1, 1}, {12, 9}, type, true);
    check_against_brute_force(mesh, 10000);
    move_inner_nodes(mesh, 0.06);
    check_against_brute_force(mesh, 10000);
  }
}

TEST(CellLocator, agrees_with_brute_force_in_space) {
  for (const CellType type : {CellType::tet4, CellType::hex8}) {
    SCOPED_TRACE(name(type));
    auto mesh = box_mesh<3>({0, 0, 0}, {1, 1, 1}, {4, 3, 3}, type);
    check_against_brute_force(mesh, 3000);
    if (type == CellType::hex8) continue;  // moved hexes have curved sides
    move_inner_nodes(mesh, 0.1);
    check_against_brute_force(mesh, 3000);
  }
}

template <int dim>
void check_round_trip(const Mesh<dim>& mesh, double tolerance) {
  const CellLocator<dim> locator(mesh);
  std::mt19937 random(5);
  std::uniform_real_distribution<double> uniform(0.001, 0.999);
  const bool simplex = mesh.nodes_per_cell() == dim + 1;
  for (std::int32_t c = 0; c < mesh.num_cells(); ++c) {
    for (int i = 0; i < 20; ++i) {
      Vector<dim> xi;
      for (int k = 0; k < dim; ++k) xi[k] = simplex ? uniform(random) : 2 * uniform(random) - 1;
      if (simplex && xi.sum() > 0.999) continue;
      const Vector<dim> x = position(mesh, c, xi);
      EXPECT_EQ(locator.locate(x, c), c);
      EXPECT_EQ(locator.locate(x, mesh.num_cells() - 1 - c), c);
      EXPECT_EQ(locator.locate(x, -1), c);
      EXPECT_LT((locator.local_coordinates(c, x) - xi).norm(), tolerance);
    }
  }
}

TEST(CellLocator, finds_local_coordinates_in_regular_and_distorted_cells) {
  for (const double amount : {0.0, 0.1}) {
    auto triangles = box_mesh<2>({0, 0}, {1, 1}, {6, 5}, CellType::tri3);
    auto quads = box_mesh<2>({0, 0}, {1, 1}, {6, 5}, CellType::quad4);
    auto tetrahedra = box_mesh<3>({0, 0, 0}, {1, 1, 1}, {4, 3, 3}, CellType::tet4);
    auto hexahedra = box_mesh<3>({0, 0, 0}, {1, 1, 1}, {4, 3, 3}, CellType::hex8);
    move_inner_nodes(triangles, amount);
    move_inner_nodes(quads, amount);
    move_inner_nodes(tetrahedra, amount);
    move_inner_nodes(hexahedra, amount);
    check_round_trip(triangles, 1e-13);
    check_round_trip(quads, 1e-13);
    check_round_trip(tetrahedra, 1e-13);
    check_round_trip(hexahedra, 1e-13);
  }
}

TEST(CellLocator, finds_local_coordinates_in_a_strongly_distorted_quad_and_hex) {
  Mesh<2> quad;
  quad.cell_type = CellType::quad4;
  quad.nodes = {{0, 0}, {4, 0}, {2.05, 1.5}, {0, 3}};  // nearly a triangle
  quad.cells = {0, 1, 2, 3};
  check_round_trip(quad, 1e-11);

  auto hex = box_mesh<3>({0, 0, 0}, {1, 1, 1}, {1, 1, 1}, CellType::hex8);
  for (auto& x : hex.nodes) {
    if (x[2] > 0) x = Vector<3>(0.2 * x[0] + 0.5 * x[1], 0.2 * x[1] - 0.4 * x[0], 2.0 + x[0]);
  }
  check_round_trip(hex, 1e-12);
}

TEST(CellLocator, works_far_from_the_origin) {
  const Vector<2> shift(3.1e5, -7.7e5);
  auto mesh = box_mesh<2>({0, 0}, {1, 1}, {10, 10}, CellType::tri3);
  for (auto& x : mesh.nodes) x += shift;
  const CellLocator<2> locator(mesh);
  for (const auto& x : special_points(mesh)) {
    const std::int32_t found = locator.locate(x, -1);
    EXPECT_GE(found, 0);
    for (std::int32_t hint = 0; hint < mesh.num_cells(); hint += 17) {
      EXPECT_EQ(locator.locate(x, hint), found);
    }
  }
}

TEST(CellLocator, walks_round_a_hole_or_finds_its_way_by_the_bins) {
  const auto whole = box_mesh<2>({0, 0}, {1, 1}, {20, 20}, CellType::quad4);
  Mesh<2> ring = whole;
  ring.cells.clear();
  for (std::int32_t c = 0; c < whole.num_cells(); ++c) {
    const Vector<2> centre = position<2>(whole, c, Vector<2>(0, 0));
    if ((centre - Vector<2>(0.5, 0.5)).norm() < 0.3) continue;
    ring.cells.insert(ring.cells.end(), whole.cell(c).begin(), whole.cell(c).end());
  }
  const CellLocator<2> locator(ring);
  for (std::int32_t c = 0; c < ring.num_cells(); ++c) {
    const Vector<2> x = position<2>(ring, c, Vector<2>(0.3, -0.7));
    for (std::int32_t hint = 0; hint < ring.num_cells(); hint += 7) {
      EXPECT_EQ(locator.locate(x, hint), c);
    }
  }
  EXPECT_EQ(locator.locate({0.5, 0.5}, 0), -1);
}

TEST(CellLocator, gives_minus_one_outside_and_for_what_is_no_point) {
  const auto mesh = box_mesh<2>({0, 0}, {1, 1}, {4, 4}, CellType::tri3);
  const CellLocator<2> locator(mesh);
  const double nan = std::numeric_limits<double>::quiet_NaN();
  const double inf = std::numeric_limits<double>::infinity();
  for (const Vector<2>& x : {Vector<2>(1 + 1e-9, 0.5), Vector<2>(0.5, -1e-9), Vector<2>(1e300, 0),
                             Vector<2>(nan, 0.5), Vector<2>(0.5, inf)}) {
    for (std::int32_t hint : {-1, 0, 31, 1000}) EXPECT_EQ(locator.locate(x, hint), -1);
  }
  EXPECT_GE(locator.locate({1 + 1e-14, 0.5}, -1), 0);
}

TEST(CellLocator, refuses_a_cell_of_negative_volume) {
  auto mesh = box_mesh<2>({0, 0}, {1, 1}, {1, 1}, CellType::tri3);
  std::swap(mesh.cells[3], mesh.cells[4]);
  test::expect_error<ConfigError>([&] { CellLocator<2>{mesh}; },
                                  {"cell locator: found no positive volume in cell 1"});
}

}  // namespace
}  // namespace gabion::mpm::test_cell_locator
