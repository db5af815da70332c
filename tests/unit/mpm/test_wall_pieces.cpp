// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <numeric>

#include "tests/support/expect_error.hpp"
#include "tests/unit/mpm/mpm_scene.hpp"
#include "tests/unit/mpm/soil_patch.hpp"

namespace gabion::test::test_wall_pieces {
namespace {

constexpr double degree = M_PI / 180;

mpm::WallSettings slip(const std::string& group, const std::vector<double>& velocity = {}) {
  return {.group = group, .fixed = false, .where = "/" + group, .motion = {velocity, {}}};
}

/// Constraint of the walls on each node of a mesh.
template <int dim>
struct Held {
  mpm::BackgroundGrid<dim> grid;
  mpm::WallConditions<dim> walls;
  std::vector<Matrix<dim>> Q;  // of each node of the mesh
  std::vector<Vector<dim>> w;  // displacement in a step of 1 s

  Held(const Mesh<dim>& mesh, const std::vector<mpm::WallSettings>& settings)
      : grid(mesh), walls(grid, settings), Q(mesh.nodes.size(), Matrix<dim>::Identity()) {
    std::vector<std::int32_t> all(mesh.nodes.size());
    std::iota(all.begin(), all.end(), 0);
    mpm::GridNodes<dim> nodes;
    mpm::number_nodes<dim>(comm(), grid, all, nodes);
    walls.begin_step(0, 1);
    walls.select(nodes);
    for (std::size_t k = 0; k < walls.constrained().size(); ++k) {
      Q[walls.constrained()[k]] = walls.projectors()[k];
    }
    w.assign(mesh.nodes.size(), Vector<dim>::Zero());
    walls.impose(flat_of(w), 1);
  }
  static std::span<double> flat_of(std::vector<Vector<dim>>& v) {
    return {v.front().data(), v.size() * dim};
  }
  /// Number of directions in which the node may move.
  int freedom(std::size_t node) const { return static_cast<int>(std::lround(Q[node].trace())); }
};

/// A strip of cells on a bed through these places; its group "bottom" is the bed.
Mesh<2> strip(const std::vector<Vector<2>>& bed, CellType type = CellType::quad4) {
  const auto cells = static_cast<int>(bed.size()) - 1;
  Mesh<2> mesh = box_mesh<2>({0, 0}, {double(cells), 1}, {cells, 1}, type);
  for (auto& x : mesh.nodes) x = bed[std::lround(x[0])] + Vector<2>(0, 5 * x[1]);
  return mesh;
}

/// Two segments of these lengths; the second one is turned by an angle, up if it is positive [deg].
Mesh<2> bent(double angle, double length_1, double length_2) {
  const double turn = 10 * degree;  // no segment is along an axis
  const Vector<2> e1(std::cos(turn), std::sin(turn));
  const Vector<2> e2(std::cos(turn + angle * degree), std::sin(turn + angle * degree));
  return strip({{0, 0}, length_1 * e1, length_1 * e1 + length_2 * e2});
}

Vector<2> normal_of(const Vector<2>& edge) {
  return Vector<2>(edge[1], -edge[0]);
}

TEST(WallPieces, a_bend_within_a_group_has_one_normal) {
  for (const double size : {1e-7, 1e-3, 0.01, 0.1, 1.0, 5.0, 10.0, 19.0, 20.0}) {
    for (const double angle : {size, -size}) {
      for (const double length : {1.0, 0.2, 7.0}) {
        const Mesh<2> mesh = bent(angle, 1, length);
        const Held<2> held(mesh, {slip("bottom")});
        ASSERT_EQ(held.freedom(1), 1) << angle;
        const Vector<2> n = normal_of(mesh.nodes[2] - mesh.nodes[0]).normalized();
        const Matrix<2> expected = Matrix<2>::Identity() - n * n.transpose();
        EXPECT_LT((held.Q[1] - expected).norm(), 2e-7) << angle << " " << length;
        EXPECT_TRUE(held.walls.corner_warnings().empty());
      }
    }
  }
}

TEST(WallPieces, a_corner_holds_both_directions) {
  for (const double size : {21.0, 45.0, 49.0, 51.0, 80.0}) {
    for (const double angle : {size, -size}) {
      const Held<2> held(bent(angle, 1, 2), {slip("bottom")});
      EXPECT_EQ(held.freedom(0), 1);
      EXPECT_EQ(held.freedom(1), 0) << angle;
      EXPECT_EQ(held.freedom(2), 1);
      const auto warnings = held.walls.corner_warnings();
      ASSERT_EQ(warnings.size(), size < 50 ? 1u : 0u) << angle;
      if (size == 21) {
        EXPECT_NE(warnings[0].find("\"bottom\" bends by 21 degrees at 1 grid nodes"),
                  std::string::npos)
            << warnings[0];
      }
    }
  }
}

/// A plane whose normals differ by nothing but round-off is held as its first facet says.
TEST(WallPieces, a_plane_keeps_its_bits) {
  Mesh<2> mesh = strip({{0, 0}, {0.3, 0.1}, {0.9, 0.3}, {2.7, 0.9}});
  const Held<2> held(mesh, {slip("bottom")});
  auto& bed = mesh.facet_groups["bottom"];
  const std::vector<std::int32_t> all = bed;
  for (int facet = 0; facet < 3; ++facet) {
    bed = {all[2 * facet], all[2 * facet + 1]};
    const Held<2> alone(mesh, {slip("bottom")});
    EXPECT_EQ(held.Q[facet + 1], alone.Q[facet + 1]) << facet;
  }
}

/// Two groups that meet are a corner, whatever their angle, but for flush ones.
TEST(WallPieces, two_groups_make_a_corner) {
  for (const double angle : {1e-4, 0.5, 0.9, -0.9, 1.1, -1.1, 10.0, -19.0, 60.0}) {
    Mesh<2> mesh = bent(angle, 1, 3);
    auto& bed = mesh.facet_groups["bottom"];
    mesh.facet_groups["rest"] = {bed.begin() + 2, bed.end()};
    bed.resize(2);
    const Held<2> held(mesh, {slip("bottom"), slip("rest")});
    const bool corner = std::abs(angle) > 1;
    EXPECT_EQ(held.freedom(1), corner ? 0 : 1) << angle;
    const auto warnings = held.walls.corner_warnings();
    EXPECT_EQ(warnings.size(), corner && std::abs(angle) < 50 ? 1u : 0u) << angle;
    if (corner) continue;
    const Vector<2> t = (mesh.nodes[2] - mesh.nodes[0]).normalized();
    EXPECT_LT((held.Q[1] - t * t.transpose()).norm(), 1e-5);
  }
}

/// A ring of segments around a hole, outside and inside: each node may go round.
TEST(WallPieces, closed_circle) {
  for (const int segments : {20, 72}) {
    Mesh<2> mesh = box_mesh<2>({0, 0}, {double(segments), 1}, {segments, 1}, CellType::quad4);
    const int columns = segments + 1;
    const auto around = [&](std::int32_t node) { return node % columns == segments; };
    for (auto& x : mesh.nodes) {
      const double phi = -2 * M_PI * x[0] / segments, r = 1 + x[1];
      x = Vector<2>(r * std::cos(phi), r * std::sin(phi));
    }
    const auto close = [&](std::vector<std::int32_t>& nodes) {
      for (auto& node : nodes) node -= around(node) ? segments : 0;
    };
    close(mesh.cells);
    for (auto& group : mesh.facet_groups) close(group.second);
    const Held<2> held(mesh, {slip("bottom"), slip("top")});
    for (std::int32_t node = 0; node < mesh.num_nodes_total(); ++node) {
      if (around(node)) continue;
      ASSERT_EQ(held.freedom(node), 1) << node;
      EXPECT_LT((held.Q[node] * mesh.nodes[node]).norm(), 1e-12) << node;
    }
  }
}

/// A fin as thin as a bend is still a corner: its sides look away from each other.
TEST(WallPieces, the_edge_of_a_fin_is_a_corner) {
  const Held<2> held(strip({{0, 0}, {1, 4}, {1.1, 0}, {3, 0}}), {slip("bottom")});
  EXPECT_EQ(held.freedom(1), 0);
}

template <int dim>
Mesh<dim> over(const std::function<double(Vector<dim>)>& height, CellType type, int cells) {
  Mesh<dim> mesh = unit_box<dim>(type, cells);
  for (auto& x : mesh.nodes) x[dim - 1] += height(x);
  return mesh;
}

/// The normal of a bowl, to first order in the size of its facets.
TEST(WallPieces, a_bowl_in_space) {
  const auto height = [](const Vector<3>& x) { return 0.3 * (x[0] * x[0] + x[1] * x[1] * x[0]); };
  for (const CellType type : {CellType::hex8, CellType::tet4}) {
    double error[2];
    for (const int level : {0, 1}) {
      const int cells = 6 << level;
      const Mesh<3> mesh = over<3>(height, type, cells);
      const Held<3> held(mesh, {slip("bottom")});
      error[level] = 0;
      for (std::size_t k = 0; k < mesh.nodes.size(); ++k) {
        const double x = mesh.nodes[k][0], y = mesh.nodes[k][1];
        if (held.freedom(k) == 3) continue;
        ASSERT_EQ(held.freedom(k), 2) << k;
        const Vector<3> n = Vector<3>(0.6 * x + 0.3 * y * y, 0.6 * x * y, -1).normalized();
        const Matrix<3> exact = Matrix<3>::Identity() - n * n.transpose();
        error[level] = std::max(error[level], (held.Q[k] - exact).norm());
      }
    }
    EXPECT_LT(error[1], 0.07);
    EXPECT_GT(std::log2(error[0] / error[1]), 0.9);
  }
}

/// A fold along y: one normal below the angle of a corner, above it soil slides along the fold.
TEST(WallPieces, a_fold_in_space) {
  for (const CellType type : {CellType::hex8, CellType::tet4}) {
    for (const double angle : {0.001, -0.01, 5.0, -19.0, 21.0, -45.0}) {
      const double slope = std::tan(angle * degree);
      const Mesh<3> mesh =
          over<3>([&](const Vector<3>& x) { return slope * std::max(0.0, x[0] - 0.5); }, type, 4);
      const Held<3> held(mesh, {slip("bottom")});
      for (int node : mesh.group_nodes("bottom", "")) {
        const bool at_fold = std::abs(mesh.nodes[node][0] - 0.5) < 1e-9;
        ASSERT_EQ(held.freedom(node), at_fold && std::abs(angle) > 20 ? 1 : 2) << angle;
        EXPECT_LT((held.Q[node].col(1) - Vector<3>::Unit(1)).norm(), 1e-12) << angle;
      }
    }
  }
}

/// Between cells the facets of a group may look to either side.
/// A slice of one cell along z, turned about x, with both its sides and `others` held.
Held<3> held_slice(double turn, std::vector<int> count, const std::vector<std::string>& others) {
  Mesh<3> mesh = box_mesh<3>({0, 0, 0}, {2, 2, 1}, {count[0], count[1], count[2]}, CellType::hex8);
  const Eigen::AngleAxisd rotation(turn * degree, Vector<3>::UnitX());
  for (auto& x : mesh.nodes) x = rotation * x;
  // bottom and top are the sides along z, the last axis of space
  std::vector<mpm::WallSettings> walls = {slip("bottom"), slip("top")};
  for (const std::string& group : others) walls.push_back(slip(group));
  return {mesh, walls};
}

TEST(WallPieces, a_slice_between_slip_walls_is_held_in_a_plane) {
  for (const double turn : {0.0, 0.01, 30.0}) {
    for (const auto& others :
         std::vector<std::vector<std::string>>{{}, {"left"}, {"left", "front"}}) {
      const Held<3> slice = held_slice(turn, {3, 2, 1}, others);
      const Vector<3>* n = slice.walls.held_normal();
      ASSERT_NE(n, nullptr) << turn;
      const Vector<3> z(0, -std::sin(turn * degree), std::cos(turn * degree));
      EXPECT_LT(n->cross(z).norm(), 1e-12);
    }
    EXPECT_EQ(held_slice(turn, {3, 2, 2}, {}).walls.held_normal(), nullptr);  // two cells
    // a column of one cell is held along two directions, neither of which is the one
    EXPECT_EQ(held_slice(turn, {1, 3, 1}, {"left", "right"}).walls.held_normal(), nullptr);
  }
}

TEST(WallPieces, facets_between_cells_in_any_sense) {
  for (const CellType type : {CellType::hex8, CellType::tet4}) {
    Mesh<3> mesh = over<3>([](const Vector<3>& x) { return 0.2 * x[0] * x[0]; }, type, 4);
    const int n = num_nodes(facet_type(type));
    auto& gate = mesh.facet_groups["gate"];
    gate = mesh.facet_groups["bottom"];
    const Held<3> held(mesh, {slip("bottom")});
    for (std::size_t k = 0; k < gate.size(); k += 2 * n) {
      std::reverse(gate.begin() + k, gate.begin() + k + n);
    }
    const Held<3> turned(mesh, {slip("gate")});
    gate.insert(gate.end(), gate.begin() + n, gate.begin() + 3 * n);  // facets a second time
    const Held<3> twice(mesh, {slip("gate")});
    for (std::size_t k = 0; k < mesh.nodes.size(); ++k) {
      EXPECT_LT((held.Q[k] - turned.Q[k]).norm(), 1e-14) << k;
      EXPECT_LT((held.Q[k] - twice.Q[k]).norm(), 1e-14) << k;
    }
  }
}

/// A bent wall that moves as a whole takes each node along its normal.
TEST(WallPieces, a_bent_wall_that_moves) {
  const std::vector<double> velocity = {0.3, -0.2};
  const Mesh<2> mesh = bent(-15, 1, 2);
  const Held<2> held(mesh, {slip("bottom", velocity)});
  const Vector<2> V(0.3, -0.2);
  for (int node = 0; node < 3; ++node) {
    EXPECT_LT((held.w[node] - (V - held.Q[node] * V)).norm(), 1e-15);
  }
  // Flush groups are one wall if they move as one, along it they may differ.
  Mesh<2> parts = bent(0.5, 1, 2);
  auto& bed = parts.facet_groups["bottom"];
  parts.facet_groups["rest"] = {bed.begin() + 2, bed.end()};
  bed.resize(2);
  Held<2> one(parts, {slip("bottom", velocity), slip("rest", velocity)});
  EXPECT_NO_THROW(one.walls.require_agreement(0, INFINITY));
  EXPECT_LT((one.w[1] - (V - one.Q[1] * V)).norm(), 1e-15);
  const Vector<2> t = (parts.nodes[2] - parts.nodes[0]).normalized();
  Held<2> belt(parts, {slip("bottom"), slip("rest", {t[0], t[1]})});
  EXPECT_NO_THROW(belt.walls.require_agreement(0, INFINITY));
  Held<2> two(parts, {slip("bottom"), slip("rest", velocity)});
  expect_error<ConfigError>([&] { two.walls.require_agreement(0, INFINITY); },
                            {"/rest", "\"rest\"", "\"bottom\"", "grid node 1", "from 0 s on"});
}

}  // namespace
}  // namespace gabion::test::test_wall_pieces
