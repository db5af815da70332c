// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <algorithm>

#include "coupler/mapping/interface_map.hpp"
#include "coupler/mapping/mapping.hpp"
#include "tests/support/expect_error.hpp"
#include "tests/unit/coupler/sequence.hpp"
#include "tests/unit/coupler/surface_meshes.hpp"

namespace gabion::test_mapping {
namespace {

using test::expect_error;
using test::SurfacePair;
using Values = std::vector<double>;

/// Polyline from (0, 0) to (1, 2), unevenly divided; the structure lies to its left.
InterfaceMesh polyline(const Values& stations, bool facets = true) {
  return test::line_mesh(
      stations, [](double s) { return std::pair(s, 2 * s); }, facets);
}

/// Tilted plane z = x / 2 + y / 4 over the unit square, n x m quads or twice as many triangles.
InterfaceMesh plane(int n, int m, int vertices_per_facet) {
  return test::sheet_mesh(n, m, vertices_per_facet,
                          [](double x, double y) { return x / 2 + y / 4; });
}

std::vector<SurfacePair> pairs() {
  return {{polyline({0, 0.2, 0.55, 1}), polyline({0, 0.1, 0.37, 0.6, 0.93, 1})},
          {plane(3, 2, 3), plane(4, 5, 3)},
          {plane(3, 2, 4), plane(4, 5, 4)},
          {plane(3, 2, 4), plane(5, 3, 3)}};
}

const MappingSettings projection{"nearest_projection", 1e-9};

/// field(x) = a + B x at all vertices
Values linear_field(const InterfaceMesh& mesh, const Eigen::Vector3d& a, const Eigen::Matrix3d& B) {
  Values values;
  for (std::int64_t v = 0; v < mesh.num_vertices(); ++v) {
    Eigen::Vector3d x = Eigen::Vector3d::Zero();
    for (int i = 0; i < mesh.dim; ++i) x(i) = mesh.coordinates[v * mesh.dim + i];
    const Eigen::Vector3d u = a + B * x;
    for (int i = 0; i < mesh.dim; ++i) values.push_back(u(i));
  }
  return values;
}

Values random_values(std::size_t count, int seed) {
  test::Sequence sequence(seed);
  Values values(count);
  for (double& v : values) v = sequence();
  return values;
}

TEST(Mapping, projection_reproduces_constants_and_linear_fields) {
  Eigen::Matrix3d B;
  B << 1, 2, -1, 0.3, -0.7, 0.2, 2, 1, 0.1;
  for (const SurfacePair& pair : pairs()) {
    const Mapping mapping(pair.structure, pair.soil, projection);
    for (const Eigen::Matrix3d& gradient : {Eigen::Matrix3d(Eigen::Matrix3d::Zero()), B}) {
      const Eigen::Vector3d a(0.5, -2, 3);
      Values found(pair.soil.coordinates.size());
      mapping.to_soil(linear_field(pair.structure, a, gradient), found);
      const Values expected = linear_field(pair.soil, a, gradient);
      for (std::size_t i = 0; i < found.size(); ++i) EXPECT_NEAR(found[i], expected[i], 1e-13);
    }
    const MappingReport& report = mapping.report();
    EXPECT_LE(report.farthest, 1e-15);
    EXPECT_LE(report.largest_shift, 1e-15);
    EXPECT_LE(report.largest_weight, 1);
    EXPECT_EQ(report.soil_vertices, pair.soil.num_vertices());
    EXPECT_EQ(report.structure_vertices, pair.structure.num_vertices());
    EXPECT_EQ(report.unused_vertices, 0);
    EXPECT_FALSE(mapping.is_identity());
  }
}

TEST(Mapping, nearest_neighbor_reproduces_constants_only) {
  const SurfacePair pair = pairs()[0];
  const Mapping mapping(pair.structure, pair.soil, {"nearest_neighbor", 1});
  Values found(pair.soil.coordinates.size());
  mapping.to_soil(linear_field(pair.structure, {1, 2, 0}, Eigen::Matrix3d::Zero()), found);
  EXPECT_EQ(found, linear_field(pair.soil, {1, 2, 0}, Eigen::Matrix3d::Zero()));
  mapping.to_soil(linear_field(pair.structure, {0, 0, 0}, Eigen::Matrix3d::Identity()), found);
  EXPECT_EQ(found[2], 0.0);  // soil vertex 1 at 0.1 takes structure vertex 0 at 0
  EXPECT_EQ(found[4], 0.2);  // soil vertex 2 at 0.37 takes structure vertex 1 at 0.2
}

TEST(Mapping, forces_keep_sum_moment_and_work) {
  for (const SurfacePair& pair : pairs()) {
    const InterfaceMap map({{"wall", "soil", "structure"}},
                           {{"soil", {pair.soil}}, {"structure", {pair.structure}}}, projection);
    const Values x_values = random_values(pair.structure.coordinates.size(), 1);
    const Eigen::VectorXd x =
        Eigen::Map<const Eigen::VectorXd>(x_values.data(), Eigen::Index(x_values.size()));
    const Eigen::VectorXd u = map.soil_displacement(x);
    const Values f_values = random_values(pair.soil.coordinates.size(), 2);
    const Eigen::VectorXd f_soil =
        Eigen::Map<const Eigen::VectorXd>(f_values.data(), Eigen::Index(f_values.size()));
    const Eigen::VectorXd f = map.structure_force(f_soil);

    const Resultant here = map.soil_resultant(u, f_soil);
    const Resultant there = map.structure_resultant(x, f);
    EXPECT_GT(here.force.norm(), 0.1);
    EXPECT_GT(here.moment.norm(), 0.1);
    EXPECT_LE((here.force - there.force).norm(), 1e-12);
    EXPECT_LE((here.moment - there.moment).norm(), 1e-12);
    EXPECT_NEAR(u.dot(f_soil), x.dot(f), 1e-12);
  }
}

/// The moment about a place is that about the origin less place x force; several interfaces add up.
TEST(InterfaceMap, forces_and_moments_of_each_interface) {
  for (const SurfacePair& pair : pairs()) {
    InterfaceMesh roof_soil = pair.soil, roof = pair.structure;
    roof_soil.name = roof.name = "roof";
    std::vector<double> place = {0.3, -0.7, 0.2};
    place.resize(static_cast<std::size_t>(roof.dim));
    const InterfaceMap map(
        {{"wall", "soil", "structure"}, {"roof", "soil", "structure", place}},
        {{"soil", {pair.soil, roof_soil}}, {"structure", {pair.structure, roof}}}, projection);
    const Values values = random_values(2 * roof.coordinates.size(), 1);
    const Eigen::VectorXd x = Eigen::Map<const Eigen::VectorXd>(values.data(), map.size());
    Eigen::VectorXd f = x.reverse();
    f.tail(f.size() / 2) *= 3;
    const auto of = map.structure_resultants(x, f);
    const Resultant all = map.structure_resultant(x, f);
    ASSERT_EQ(of.size(), 2u);
    Eigen::Vector3d about = Eigen::Vector3d::Zero();
    for (std::size_t i = 0; i < place.size(); ++i) about(Eigen::Index(i)) = place[i];
    EXPECT_LE((of[0].force + of[1].force - all.force).norm(), 1e-12);
    const Eigen::Vector3d moment = of[0].moment + of[1].moment + about.cross(of[1].force);
    EXPECT_LE((moment - all.moment).norm(), 1e-12);
    EXPECT_GT(about.cross(of[1].force).norm(), 0.01);
  }
}

TEST(Mapping, matching_meshes_are_mapped_by_the_identity) {
  for (const InterfaceMesh& mesh : {polyline({0, 0.3, 0.7, 1}), plane(3, 4, 3), plane(3, 4, 4)}) {
    const Mapping mapping(mesh, mesh, projection);
    EXPECT_TRUE(mapping.is_identity());
    const Values x = random_values(mesh.coordinates.size(), 5);
    Values u(x.size()), f = x;
    mapping.to_soil(x, u);
    EXPECT_EQ(u, x);
    mapping.add_to_structure(x, f);
    for (std::size_t i = 0; i < x.size(); ++i) EXPECT_EQ(f[i], 2 * x[i]);
  }
}

TEST(Mapping, vertices_that_get_no_force_are_counted) {
  const Mapping mapping(polyline({0, 0.25, 0.5, 0.75, 1}), polyline({0, 0.3}), projection);
  EXPECT_EQ(mapping.report().unused_vertices, 2);  // at 0.75 and 1
}

/// Soil vertices on every second vertex of a structure, turned, scaled and far from the origin:
/// weights of 1e-16 of the vertices beside them count for nothing.
TEST(Mapping, the_count_of_unused_vertices_does_not_follow_round_off) {
  Values fine, coarse;
  for (int k = 0; k <= 40; ++k) (k % 2 == 0 ? coarse : fine).push_back(k / 40.0);
  for (const double s : coarse) fine.push_back(s);
  std::sort(fine.begin(), fine.end());
  for (const double unit : {1.0, 1e-3, 1e3}) {
    for (const double angle : {0.0, 0.3, 1.1, 2.0}) {
      const Eigen::Rotation2Dd turn(angle);
      const auto place = [&](double s) {
        const Eigen::Vector2d x =
            unit * (turn * Eigen::Vector2d(s, 0.7 * s) + Eigen::Vector2d(3.3, -17.1));
        return std::pair(x[0], x[1]);
      };
      const Mapping mapping(test::line_mesh(fine, place, true),
                            test::line_mesh(coarse, place, true),
                            {"nearest_projection", 1e-6 * unit});
      EXPECT_EQ(mapping.report().unused_vertices, 20) << unit << " " << angle;
    }
  }
}

TEST(Mapping, finds_the_closest_facet_even_if_none_of_its_vertices_is_close) {
  // A long segment passes near the point; vertices of short ones are nearer than its ends.
  InterfaceMesh structure;
  structure.name = "wall";
  structure.dim = 2;
  structure.vertices_per_facet = 2;
  structure.coordinates = {-10, 0, 10, 0, 0, 1, 0.1, 1};
  structure.facets = {0, 1, 2, 3};
  const Surface surface(structure);
  const SurfacePoint found = surface.nearest_on_facets({0, 0.2, 0});
  EXPECT_EQ(found.facet, 0);
  EXPECT_NEAR(found.distance, 0.2, 1e-15);
  EXPECT_NEAR(found.weights[0], 0.5, 1e-15);
}

TEST(ClosestPoint, agrees_with_a_search_over_the_facet) {
  const std::array<Eigen::Vector3d, 4> quad = {
      Eigen::Vector3d(0, 0, 0), {1, 0.1, 0.3}, {1.2, 1, -0.2}, {-0.1, 0.8, 0.1}};
  test::Sequence random(4);
  for (int trial = 0; trial < 50; ++trial) {
    const Eigen::Vector3d p(0.5 + 1.5 * random(), 0.5 + 1.5 * random(), random());
    const ClosestPoint on_quad = closest_on_quad(p, quad);
    const ClosestPoint on_triangle = closest_on_triangle(p, {quad[0], quad[1], quad[2]});
    double quad_best = 1e9;
    double triangle_best = 1e9;
    constexpr int n = 100;
    for (int i = 0; i <= n; ++i) {
      for (int j = 0; j <= n; ++j) {
        const double s = double(i) / n, t = double(j) / n;
        const Eigen::Vector3d q = (1 - s) * (1 - t) * quad[0] + s * (1 - t) * quad[1] +
                                  s * t * quad[2] + (1 - s) * t * quad[3];
        quad_best = std::min(quad_best, (q - p).norm());
        const Eigen::Vector3d r =
            quad[0] + s * (1 - t) * (quad[1] - quad[0]) + s * t * (quad[2] - quad[0]);
        triangle_best = std::min(triangle_best, (r - p).norm());
      }
    }
    EXPECT_LE(on_quad.distance, quad_best + 1e-12);
    EXPECT_GE(on_quad.distance, quad_best - 0.02);
    EXPECT_LE(on_triangle.distance, triangle_best + 1e-12);
    EXPECT_GE(on_triangle.distance, triangle_best - 0.02);
    Eigen::Vector3d image = Eigen::Vector3d::Zero();
    double sum = 0;
    for (int a = 0; a < 4; ++a) {
      image += on_quad.weights[a] * quad[a];
      sum += on_quad.weights[a];
      EXPECT_GE(on_quad.weights[a], -1e-12);
    }
    EXPECT_NEAR(sum, 1, 1e-13);
    EXPECT_NEAR((image - p).norm(), on_quad.distance, 1e-12);
  }
}

TEST(Mapping, surfaces_too_far_apart_are_refused_with_the_place) {
  InterfaceMesh soil = polyline({0, 0.5, 1});
  soil.coordinates[2] += 0.25;  // vertex 1 to (0.75, 1)
  expect_error<ConfigError>(
      [&] {
        Mapping(polyline({0, 1}), soil, {"nearest_projection", 1e-3});
      },
      {"interface \"wall\": soil vertex 1 at (0.75, 1) is 0.2236",
       "allowed: 0.001 m (coupling/mapping/tolerance)"});
}

TEST(Mapping, nearest_neighbor_measures_to_the_vertex_that_it_takes) {
  const InterfaceMesh structure = polyline({0, 1}), soil = polyline({0, 0.3, 1});
  EXPECT_NEAR(Mapping(structure, soil, {"nearest_neighbor", 0.7}).report().farthest,
              0.3 * std::sqrt(5), 1e-15);
  expect_error<ConfigError>(
      [&] {
        Mapping(structure, soil, {"nearest_neighbor", 0.1});
      },
      {"away from the structure's nearest vertex, allowed: 0.1 m"});
  EXPECT_LE(Mapping(structure, soil, {"nearest_projection", 0.1}).report().farthest, 1e-15);
}

TEST(Mapping, equal_vertices_need_no_facets) {
  const InterfaceMesh points = polyline({0, 0.4, 1}, false);
  EXPECT_TRUE(Mapping(points, points, projection).is_identity());
}

TEST(Mapping, opposite_normals_are_refused) {
  InterfaceMesh soil = polyline({0, 0.5, 1});
  std::swap(soil.facets[2], soil.facets[3]);
  expect_error<ConfigError>(
      [&] {
        Mapping(polyline({0, 1}), soil, projection);
      },
      {"facet 1 of the soil's surface", "normals that agree",
       "reverse the order of the soil's polyline"});
}

TEST(Mapping, unusable_meshes_are_refused) {
  const InterfaceMesh good = polyline({0, 1});
  InterfaceMesh bad = good;
  bad.facets[1] = 7;
  expect_error<ConfigError>([&] { Mapping(bad, good, projection); }, {"names vertex 7"});
  bad = good;
  bad.coordinates = {0, 0, 0, 0};
  expect_error<ConfigError>([&] { Mapping(bad, good, projection); }, {"facet 0 has no extent"});
  expect_error<ConfigError>([&] { Mapping(plane(1, 1, 3), good, projection); },
                            {"the structure's surface has dimension 3, the soil's 2"});
  expect_error<ConfigError>(
      [&] {
        Mapping(polyline({0, 1}, false), polyline({0, 0.5, 1}), {"nearest_projection", 2});
      },
      {"allowed: nearest_neighbor, radial_basis"});
}

TEST(InterfaceMap, several_interfaces_and_structures_share_one_vector) {
  InterfaceMesh left = polyline({0, 1});
  InterfaceMesh right = polyline({0, 0.5, 1});
  left.name = "left";
  right.name = "right";
  const InterfaceMap map({{"left", "soil", "post"}, {"right", "soil", "net"}},
                         {{"soil", {right, left}}, {"post", {left}}, {"net", {right}}}, projection);
  ASSERT_EQ(map.size(), 10);
  ASSERT_EQ(map.soil_size(), 10);
  const InterfaceLayout net = map.layout("net"), soil = map.layout("soil");
  Eigen::VectorXd x = Eigen::VectorXd::Zero(10);
  map.layout("post").put({{"left", {1, 2, 3, 4}}}, x);
  net.put({{"right", {5, 6, 7, 8, 9, 10}}}, x);
  for (int i = 0; i < 10; ++i) EXPECT_EQ(x(i), i + 1);
  EXPECT_EQ(net.values_in(x), (InterfaceValues{{"right", {5, 6, 7, 8, 9, 10}}}));
  EXPECT_EQ(soil.values_in(map.soil_displacement(x)),
            (InterfaceValues{{"left", {1, 2, 3, 4}}, {"right", {5, 6, 7, 8, 9, 10}}}));
}

TEST(InterfaceMap, values_of_one_soil_stand_together_in_the_order_of_names) {
  InterfaceMesh front = polyline({0, 1}), back = front, top = front;
  front.name = "front";
  back.name = "back";
  top.name = "top";
  const InterfaceMap map(
      {{"top", "sand", "box"}, {"front", "clay", "box"}, {"back", "sand", "box"}},
      {{"sand", {back, top}}, {"clay", {front}}, {"box", {top, front, back}}}, projection);
  Eigen::VectorXd x(12);
  map.layout("box").put({{"top", {1, 2, 3, 4}}, {"front", {5, 6, 7, 8}}, {"back", {9, 10, 11, 12}}},
                        x);
  for (int i = 0; i < 12; ++i) EXPECT_EQ(x(i), i + 1);  // as in coupler.json
  Eigen::VectorXd expected(12);
  expected << 5, 6, 7, 8, 9, 10, 11, 12, 1, 2, 3, 4;  // clay: front; sand: back, top
  EXPECT_EQ(map.soil_displacement(x), expected);
  EXPECT_EQ(map.structure_force(expected), x);
}

TEST(InterfaceLayout, what_a_participant_sends_has_to_fit) {
  const InterfaceLayout layout("net", {{.name = "right", .begin = 2, .size = 2}});
  Eigen::VectorXd all = Eigen::VectorXd::Ones(4);
  expect_error<Error>(
      [&] {
        layout.put({{"right", {5}}}, all);
      },
      {"participant \"net\" sent 1 values for interface \"right\", expected 2"});
  expect_error<Error>(
      [&] {
        layout.put({{"left", {5, 6}}}, all);
      },
      {"participant \"net\" sent nothing for interface \"right\""});
  EXPECT_EQ(all, Eigen::VectorXd::Ones(4));
  EXPECT_FALSE(layout.is_zero_in(all));
  layout.put({{"right", {0, -0.0}}}, all);
  EXPECT_EQ(all, Eigen::Vector4d(1, 1, 0, 0));
  EXPECT_TRUE(layout.is_zero_in(all));
}

TEST(InterfaceMap, interfaces_that_do_not_pair_up_are_refused) {
  const InterfaceMesh wall = polyline({0, 1});
  InterfaceMesh roof = wall;
  roof.name = "roof";
  const auto map_of = [](const std::vector<InterfaceMesh>& of_soil,
                         const std::vector<InterfaceMesh>& of_structure) {
    InterfaceMap({{"wall", "soil", "structure"}}, {{"soil", of_soil}, {"structure", of_structure}},
                 projection);
  };
  expect_error<ConfigError>([&] { map_of({wall}, {}); },
                            {"participant \"structure\" does not have it; it has: none"});
  expect_error<ConfigError>(
      [&] {
        map_of({wall, roof}, {wall});
      },
      {"participant \"soil\" offers the interface \"roof\""});
  expect_error<ConfigError>(
      [&] {
        InterfaceMap({{"wall", "soil", "structure", {1, 2, 3}}},
                     {{"soil", {wall}}, {"structure", {wall}}}, projection);
      },
      {"interface \"wall\"", "\"moment_about\" with 3 numbers, allowed: 2"});
}

}  // namespace
}  // namespace gabion::test_mapping
