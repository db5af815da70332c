// SPDX-License-Identifier: BSD-3-Clause
#include "mpm_solver/contact/surface_features.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "mpm_solver/contact/facet_hash.hpp"
#include "mpm_solver/contact/shortest_exit.hpp"
#include "tests/unit/mpm/soil_patch.hpp"

namespace gabion::test::test_surface_features {
namespace {

using mpm::ContactSurface;
using mpm::FacingSimplex;
using mpm::Simplex;
using mpm::SurfaceFeature;

/// All simplices of a surface at rest, faced from x.
template <int dim>
struct Sighted {
  std::vector<Simplex<dim>> simplices;
  std::vector<Vector<dim>> vertices;
  std::vector<FacingSimplex> facing;

  Sighted(const ContactSurface<dim>& surface, const Vector<dim>& x)
      : simplices(mpm::simplices(surface)), vertices(surface.vertices) {
    for (std::size_t s = 0; s < simplices.size(); ++s) {
      std::array<Vector<dim>, dim> corners;
      for (int k = 0; k < dim; ++k) corners[k] = vertices[simplices[s][k]];
      const double height = (x - corners[0]).dot(mpm::simplex_normal<dim>(corners));
      if (height > 0) facing.push_back({.simplex = static_cast<std::int32_t>(s), .height = height});
    }
  }
};

template <int dim>
std::vector<SurfaceFeature<dim>> features(const ContactSurface<dim>& surface, const Vector<dim>& x,
                                          const Vector<dim>& y, double reach) {
  const Sighted<dim> seen(surface, x);
  std::vector<SurfaceFeature<dim>> found;
  mpm::find_features<dim>({.simplices = seen.simplices,
                           .start = seen.vertices,
                           .end = seen.vertices,
                           .facing = seen.facing},
                          x, y, {reach, reach}, found);
  return found;
}

/// Shortest displacement of a sphere with the radius `reach` out of the planes that it is in.
Vector<2> shortest_exit_of(const ContactSurface<2>& surface, const Vector<2>& x, const Vector<2>& y,
                           double reach) {
  std::vector<Vector<2>> normals;
  std::vector<double> depths;
  for (const auto& feature : features<2>(surface, x, y, reach)) {
    normals.push_back(feature.normal);
    depths.push_back(reach - feature.distance);
  }
  const auto path = mpm::shortest_exit<2>(normals, depths);
  Vector<2> u = Vector<2>::Zero();
  for (int k = 0; k < path.size; ++k) u += path.depths[k] * normals[path.planes[k]];
  return u;
}

/// Hills over [-1, 1]^2, of 2 n^2 triangles.
ContactSurface<3> hills(int n) {
  ContactSurface<3> surface{.vertices = {}, .facet_type = CellType::tri3, .facets = {}};
  for (int j = 0; j <= n; ++j) {
    for (int i = 0; i <= n; ++i) {
      const double x = 2.0 * i / n - 1, y = 2.0 * j / n - 1;
      surface.vertices.emplace_back(x, y, 0.1 * std::sin(7 * x) * std::cos(5 * y));
      if (i == n || j == n) continue;
      const std::int32_t v = j * (n + 1) + i;
      for (const std::int32_t k : {v, v + 1, v + n + 2, v, v + n + 2, v + n + 1}) {
        surface.facets.push_back(k);
      }
    }
  }
  return surface;
}

/// A wall 0.2 thick from the ground to the height 1, soil on all sides.
ContactSurface<2> thin_wall() {
  return {.vertices = {{1.2, 0}, {1.2, 1}, {1, 1}, {1, 0}},
          .facet_type = CellType::line2,
          .facets = {0, 1, 1, 2, 2, 3}};
}

/// Check by brute force: no place of the simplex, sampled finely, is closer.
template <int dim>
void check_closest_place() {
  Random random;
  for (int trial = 0; trial < 200; ++trial) {
    std::array<Vector<dim>, dim> corners;
    for (auto& corner : corners) corner = random.vector<dim>();
    const Vector<dim> y = 2 * random.vector<dim>();
    const auto place = mpm::closest_place<dim>(corners, y);
    double sum = 0;
    for (const double w : place.weights) {
      EXPECT_GE(w, 0);
      sum += w;
    }
    EXPECT_NEAR(sum, 1, 1e-14);
    for (int sample = 0; sample < 200; ++sample) {
      Vector<dim> x = Vector<dim>::Zero();
      double total = 0;
      std::array<double, dim> w;
      for (double& value : w) total += value = std::abs(random()) + 1e-9;
      for (int k = 0; k < dim; ++k) x += w[k] / total * corners[k];
      EXPECT_LE((place.x - y).norm(), (x - y).norm() + 1e-14);
    }
  }
}

/// The mirror image of each triangle of a plate is one, whatever its mesh does.
TEST(SurfaceFeatures, symmetric_plates_are_cut_symmetrically) {
  constexpr int n = 4;
  ContactSurface<3> plate{.vertices = {}, .facet_type = CellType::quad4, .facets = {}};
  for (int j = 0; j <= n; ++j) {
    for (int i = 0; i <= n; ++i) {
      plate.vertices.emplace_back(0.3 * i, 0.2 * j, 1);
      if (i == n || j == n) continue;
      const std::int32_t v = j * (n + 1) + i;
      for (const std::int32_t k : {v, v + 1, v + n + 2, v + n + 1}) plate.facets.push_back(k);
    }
  }
  const auto mirror = [](std::int32_t v) { return v / (n + 1) * (n + 1) + n - v % (n + 1); };
  std::vector<Simplex<3>> all, images;
  for (Simplex<3> triangle : mpm::simplices(plate)) {
    EXPECT_GT(mpm::simplex_normal<3>(mpm::corners_of<3>(triangle, plate.vertices))[2], 0.99);
    Simplex<3> image;
    std::transform(triangle.begin(), triangle.end(), image.begin(), mirror);
    std::sort(triangle.begin(), triangle.end());
    std::sort(image.begin(), image.end());
    all.push_back(triangle);
    images.push_back(image);
  }
  EXPECT_EQ(all.size(), 2 * n * n);
  std::sort(all.begin(), all.end());
  std::sort(images.begin(), images.end());
  EXPECT_EQ(all, images);
}

TEST(SurfaceFeatures, the_closest_place_of_a_simplex) {
  check_closest_place<2>();
  check_closest_place<3>();
}

/// Simplices that are known to be far are not looked at; what is found stays the same.
TEST(SurfaceFeatures, far_simplices_change_nothing) {
  const ContactSurface<3> surface = hills(20);
  Random random;
  std::size_t found = 0, skipped = 0;
  for (int trial = 0; trial < 100; ++trial) {
    const Vector<3> x(0.7 * random(), 0.7 * random(), 0.2);
    const Vector<3> y = x + Vector<3>(0.05 * random(), 0.05 * random(), -0.15);
    for (const double reach : {0.2, 0.05}) {  // longer and shorter than the path
      const Sighted<3> seen(surface, x);
      const auto bounds = mpm::bounds_of<3>(seen.simplices, seen.vertices);
      std::vector<FacingSimplex> facing = seen.facing;
      double size = 0;
      for (FacingSimplex& it : facing) {
        const auto corners = mpm::corners_of<3>(seen.simplices[it.simplex], seen.vertices);
        it.distance = (mpm::closest_place<3>(corners, x).x - x).norm();
        size = std::max(size, 2 * bounds[it.simplex].radius);
        skipped += it.distance > 1.1 * reach + size + (y - x).norm() ? 1 : 0;
        EXPECT_FALSE(bounds[it.simplex].is_beyond(x, it.distance));
      }
      std::vector<SurfaceFeature<3>> few;
      mpm::find_features<3>({.simplices = seen.simplices,
                             .start = seen.vertices,
                             .end = seen.vertices,
                             .facing = facing,
                             .size = size},
                            x, y, {reach, reach}, few);
      const auto all = features<3>(surface, x, y, reach);
      ASSERT_EQ(few.size(), all.size());
      found += all.size();
      for (std::size_t k = 0; k < all.size(); ++k) {
        EXPECT_EQ(few[k].simplex, all[k].simplex);
        EXPECT_EQ(few[k].weights, all[k].weights);
        EXPECT_EQ(few[k].distance, all[k].distance);
      }
    }
  }
  EXPECT_GT(found, 100U);
  EXPECT_GT(skipped, 1000U);
}

TEST(SurfaceFeatures, a_face_gives_its_normal_and_height) {
  const auto found = features<2>(thin_wall(), {0.8, 0.5}, {0.97, 0.4}, 0.1);
  ASSERT_EQ(found.size(), 1U);
  EXPECT_NEAR(found[0].distance, 0.03, 1e-15);
  EXPECT_LT((found[0].normal - Vector<2>(-1, 0)).norm(), 1e-15);
  EXPECT_LT((found[0].x - Vector<2>(1, 0.4)).norm(), 1e-15);
}

/// The other side of an inside corner does not let go when the centre goes through one side.
TEST(SurfaceFeatures, an_inside_corner_touches_twice_behind_one_side_too) {
  const ContactSurface<2> corner{.vertices = {{0, 1}, {0, 0}, {0.5, 0}, {-1, 0}},
                                 .facet_type = CellType::line2,
                                 .facets = {0, 1, 2, 3}};
  for (const double x : {-1e-6, 0.02}) {  // of the centre, before and behind the upright side
    const auto found = features<2>(corner, {-0.1, 0.1}, {x, 0.05}, 0.1);
    ASSERT_EQ(found.size(), 2U) << x;
    const int upright = std::abs(found[0].normal[0]) > 0.5 ? 0 : 1;
    EXPECT_NEAR(found[upright].distance, -x, 1e-15);
    EXPECT_NEAR(found[1 - upright].distance, 0.05, 1e-15);
  }
}

/// A point that went through stays in contact with the side that it entered, not with the far one,
/// until it has come back.
TEST(SurfaceFeatures, a_centre_that_went_through_stays_behind) {
  const ContactSurface<2> wall = thin_wall();
  const Sighted<2> seen(wall, {1.3, 0.5});
  std::vector<FacingSimplex> facing = {{.simplex = 2, .touched = true, .height = -0.3}};
  for (const double x : {1.25, 1.1, 1.02, 0.95}) {
    std::vector<SurfaceFeature<2>> found;
    mpm::find_features<2>({.simplices = seen.simplices,
                           .start = seen.vertices,
                           .end = seen.vertices,
                           .facing = facing},
                          {1.3, 0.5}, {x, 0.5}, {0.1, 0.1}, found);
    ASSERT_EQ(found.size(), 1U) << x;
    EXPECT_NEAR(found[0].distance, 1 - x, 1e-15);
    EXPECT_LT((found[0].normal - Vector<2>(-1, 0)).norm(), 1e-15);
  }
}

TEST(SurfaceFeatures, at_a_convex_corner_the_normal_turns_smoothly) {
  const Vector<2> corner(1, 1);
  for (const double angle : {0.51, 0.6, 0.75, 0.9, 0.99}) {  // of pi: from the top to the left
    const Vector<2> n(std::cos(angle * M_PI), std::sin(angle * M_PI));
    const auto found = features<2>(thin_wall(), corner + 0.2 * n, corner + 0.05 * n, 0.1);
    ASSERT_EQ(found.size(), 1U) << angle;
    EXPECT_NEAR(found[0].distance, 0.05, 1e-14);
    EXPECT_LT((found[0].normal - n).norm(), 1e-12);
  }
}

TEST(SurfaceFeatures, an_inside_corner_touches_twice) {
  const ContactSurface<2> valley{
      .vertices = {{1, 1}, {0, 0}, {-1, 1}}, .facet_type = CellType::line2, .facets = {0, 1, 1, 2}};
  const auto found = features<2>(valley, {0, 0.5}, {0, 0.1}, 0.2);
  ASSERT_EQ(found.size(), 2U);
  for (const auto& feature : found) EXPECT_NEAR(feature.distance, 0.1 / std::sqrt(2), 1e-14);
  EXPECT_NEAR(found[0].normal.dot(found[1].normal), 0, 1e-14);
}

/// Where two facets are slightly bent, the force of either goes to the same vertices.
TEST(SurfaceFeatures, beyond_the_end_of_a_facet_the_next_one_carries_its_force) {
  constexpr double bend = 1e-3;
  const ContactSurface<2> wall{.vertices = {{1, bend}, {0, 0}, {-1, bend}},
                               .facet_type = CellType::line2,
                               .facets = {0, 1, 1, 2}};
  const Sighted<2> seen(wall, {0, 0.5});
  for (const double x : {-0.02, 0.015}) {
    const auto found = features<2>(wall, {x, 0.5}, {x, 0.1}, 0.3);
    ASSERT_EQ(found.size(), 2U) << x;
    EXPECT_NE(found[0].normal[0] > 0, found[1].normal[0] > 0);
    EXPECT_EQ(found[0].simplex, found[1].simplex);
    for (const auto& feature : found) {
      const Vector<2>& n = feature.normal;
      EXPECT_NEAR(feature.distance, n.dot(Vector<2>(x, 0.1)), 1e-15);
      Vector<2> place = Vector<2>::Zero();
      for (int k = 0; k < 2; ++k) {
        EXPECT_GE(feature.weights[k], 0);
        place += feature.weights[k] * seen.vertices[seen.simplices[feature.simplex][k]];
      }
      EXPECT_LT((place - feature.x).norm(), 0.02 * 3 * bend);
    }
  }
}

/// The shortest displacement out of a bend changes continuously as a sphere of radius 0.1 goes
/// along it.
/// @param height  of the centre above the surface
void expect_smooth_way(double bend, double height) {
  constexpr double radius = 0.1, stretch = 0.2;
  constexpr int places = 4000;
  const ContactSurface<2> wall{.vertices = {{1, bend}, {0, 0}, {-1, bend}},
                               .facet_type = CellType::line2,
                               .facets = {0, 1, 1, 2}};
  Vector<2> before = Vector<2>::Zero();
  double largest = 0;
  for (int k = 0; k <= places; ++k) {
    const double x = stretch * k / places - stretch / 2;
    const Vector<2> path =
        shortest_exit_of(wall, {x, 0.5}, {x, bend * std::abs(x) + height}, radius);
    if (k > 0) largest = std::max(largest, (path - before).norm());
    before = path;
  }
  EXPECT_LT(largest, 3 * stretch / places) << bend << ' ' << height;
}

/// The forces fade in also for a centre that went through the surface.
TEST(SurfaceFeatures, a_bend_fades_in_at_every_angle) {
  for (const double bend : {0.06, 0.3, 0.49, 0.8}) {
    for (const double height : {0.05, 1e-4, -1e-4}) expect_smooth_way(bend, height);
  }
  expect_smooth_way(0.06, -0.02);
}

/// A vertex between two segments in line is one place, not two.
TEST(SurfaceFeatures, a_seam_of_a_plane_counts_once) {
  const ContactSurface<2> line{
      .vertices = {{2, 0}, {1, 0}, {0, 0}}, .facet_type = CellType::line2, .facets = {0, 1, 1, 2}};
  for (const double x : {0.99, 1.0, 1.01}) {
    EXPECT_EQ(features<2>(line, {x, 0.5}, {x, 0.1}, 0.2).size(), 1U) << x;
  }
  ContactSurface<3> plate{.vertices = {{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0}},
                          .facet_type = CellType::quad4,
                          .facets = {0, 1, 2, 3}};
  for (const double x : {0.3, 0.5, 0.6}) {  // 0.5: on the diagonal
    const auto found = features<3>(plate, {x, 0.5, 0.5}, {x, 0.5, 0.1}, 0.2);
    ASSERT_EQ(found.size(), 1U) << x;
    EXPECT_LT((found[0].normal - Vector<3>(0, 0, 1)).norm(), 1e-14);
  }
}

TEST(SurfaceFeatures, a_point_that_flew_through_a_thin_wall_is_behind_the_side_that_it_came_from) {
  for (const double height : {0.5, 0.95}) {
    const auto found = features<2>(thin_wall(), {0.9, height}, {1.6, height + 0.3}, 0.05);
    ASSERT_EQ(found.size(), 1U);
    EXPECT_LT((found[0].normal - Vector<2>(-1, 0)).norm(), 1e-15);
    EXPECT_NEAR(found[0].distance, -0.6, 1e-14);
  }
  EXPECT_TRUE(features<2>(thin_wall(), {0.9, 1.2}, {1.6, 1.3}, 0.05).empty());  // over its top
}

TEST(SurfaceFeatures, the_hash_finds_all_that_are_near) {
  Random random;
  std::vector<Vector<3>> vertices;
  for (int v = 0; v < 60; ++v) vertices.push_back(random.vector<3>());
  std::vector<Simplex<3>> triangles;
  for (std::int32_t s = 0; s < 20; ++s) triangles.push_back({3 * s, 3 * s + 1, 3 * s + 2});
  constexpr double margin = 0.1;
  const mpm::FacetHash<3> hash(triangles, vertices, margin);
  int found = 0;
  for (int trial = 0; trial < 500; ++trial) {
    const Vector<3> x = 1.2 * random.vector<3>();
    const auto near = hash.near(x);
    for (std::int32_t s = 0; s < 20; ++s) {
      std::array<Vector<3>, 3> corners;
      for (int k = 0; k < 3; ++k) corners[k] = vertices[triangles[s][k]];
      if ((mpm::closest_place<3>(corners, x).x - x).norm() > margin) continue;
      ++found;
      EXPECT_NE(std::find(near.begin(), near.end(), s), near.end());
    }
  }
  EXPECT_GT(found, 100);
}

/// A plane of 2 n^2 triangles with the edge 1.
std::pair<std::vector<Vector<3>>, std::vector<Simplex<3>>> plane(int n) {
  std::pair<std::vector<Vector<3>>, std::vector<Simplex<3>>> made;
  for (int j = 0; j <= n; ++j) {
    for (int i = 0; i <= n; ++i) made.first.emplace_back(i, j, 0);
  }
  for (int j = 0; j < n; ++j) {
    for (int i = 0; i < n; ++i) {
      const std::int32_t at = j * (n + 1) + i;
      made.second.push_back({at, at + 1, at + n + 2});
      made.second.push_back({at, at + n + 2, at + n + 1});
    }
  }
  return made;
}

/// Terrain far from the soil costs nothing: the lists are as long for 200 facets as for 20,000.
TEST(SurfaceFeatures, the_hash_lists_only_what_is_near_given_places) {
  Random random;
  std::vector<Vector<3>> places;
  for (int k = 0; k < 50; ++k) places.push_back(Vector<3>(2, 2, 0) + random.vector<3>());
  std::vector<std::size_t> listed;
  for (const int n : {10, 100}) {
    const auto [vertices, triangles] = plane(n);
    const mpm::FacetHash<3> all(triangles, vertices, 0.3);
    const mpm::FacetHash<3> some(triangles, vertices, 0.3, places);
    listed.push_back(some.num_listed());
    EXPECT_GT(all.num_listed(), triangles.size());
    for (const Vector<3>& x : places) {
      const auto expected = all.near(x), found = some.near(x);
      EXPECT_TRUE(std::equal(expected.begin(), expected.end(), found.begin(), found.end()));
    }
    EXPECT_EQ(
        mpm::FacetHash<3>(triangles, vertices, 0.3, std::span<const Vector<3>>()).num_listed(), 0U);
  }
  EXPECT_GT(listed[0], 0U);
  EXPECT_EQ(listed[0], listed[1]);
}

}  // namespace
}  // namespace gabion::test::test_surface_features
