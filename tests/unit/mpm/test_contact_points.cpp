// SPDX-License-Identifier: BSD-3-Clause
// The contact points of a step alone: without forces, memory of steps before, or an accepted state.
#include <gtest/gtest.h>

#include <algorithm>
#include <map>

#include "mpm_solver/contact/facet_parts.hpp"
#include "tests/unit/mpm/soil_patch.hpp"

namespace gabion::test::test_contact_points {
namespace {

using mpm::ContactSettings;
using Point = mpm::ContactPoint<2>;

ContactSettings<2> surface_through(const std::vector<Vector<2>>& vertices) {
  ContactSettings<2> settings;
  settings.name = "surface";
  settings.friction = 0.3;
  settings.method =
      mpm::FacetSettings{.penalty_factor = 50, .resting_factor = 12, .tangential_factor = 0.5};
  settings.surface.vertices = vertices;
  for (std::int32_t v = 0; v + 1 < std::ssize(vertices); ++v) {
    settings.surface.facets.insert(settings.surface.facets.end(), {v, v + 1});
  }
  return settings;
}

/// Soil that fills the unit box in 3 x 3 cells, and a surface in contact with it.
struct Met {
  SoilPatch<2> soil{CellType::quad4, 3};
  mpm::FacetParts<2> parts;
  std::vector<char> elastic{0};
  std::vector<double> moduli{1e4}, weights{100};

  explicit Met(const std::vector<const ContactSettings<2>*>& members) : parts(members) {
    soil.fill(4);
    soil.to_grid();
    const mpm::SoilSurface<2> surface{.grid = soil.grid,
                                      .nodes = soil.nodes,
                                      .points = soil.points,
                                      .weights = soil.weights,
                                      .cell_size = 1.0 / 3,
                                      .dt = 1e-3,
                                      .elastic = elastic,
                                      .moduli = moduli,
                                      .weights_of = weights};
    parts.laws.begin_step(surface);
    parts.search.begin_step(surface, 0);
    for (std::size_t m = 0; m < members.size(); ++m) {
      parts.surface.set_displacement(std::vector<double>(members[m]->surface.vertices.size() * 2),
                                     m);
    }
  }
  /// The contact points of soil that moves as a whole.
  const std::vector<Point>& found(const Vector<2>& move) {
    std::vector<double> du;
    for (std::int32_t i = 0; i < soil.nodes.size(); ++i) du.insert(du.end(), {move[0], move[1]});
    parts.points.find(du);
    return parts.points.all();
  }
};

/// The lowest row of six points comes down on a floor below it and slides from there on.
TEST(ContactPoints, path_begins_to_slip_where_it_meets_the_surface) {
  const double open = 0.003, down = 0.01, along = 0.02;
  const auto settings = surface_through({{1.2, -open}, {-0.2, -open}});
  Met met({&settings});
  EXPECT_TRUE(met.found({along, -0.99 * open}).empty());
  const auto& points = met.found({along, -down});
  ASSERT_EQ(points.size(), 6u);
  for (const Point& point : points) {
    const auto& c = met.parts.points.candidate(point);
    const double share = (down - open) / down;
    EXPECT_NEAR(point.gap, open - down, 1e-15);
    EXPECT_NEAR(point.depth, down - open, 1e-15);
    EXPECT_NEAR(point.radius, c.x[1], 1e-15);
    EXPECT_NEAR(point.area, c.volume / (2 * c.x[1]), 1e-15);
    EXPECT_NEAR(point.slip_share, share, 1e-12);
    EXPECT_LT((point.slip - share * Vector<2>(along, 0)).norm(), 1e-15);
    EXPECT_LT((point.relative - Vector<2>(along, -down)).norm(), 1e-15);
    EXPECT_EQ(point.part, 1);
    EXPECT_EQ(point.initial_penetration, 0);
    double sum = 0;
    for (std::int32_t k = 0; k < c.num_values; ++k) sum += met.parts.points.weights_of(point)[k];
    EXPECT_NEAR(sum, 1, 1e-14);
  }
}

/// In a right corner the displacement out is (a, b): tractions go with |u| a and |u| b, and the two
/// springs along the faces are one.
TEST(ContactPoints, point_in_a_corner_shares_depth_and_stiffness) {
  const double a = 0.003, b = 0.004, u = 0.005;
  const auto settings = surface_through({{1.2, 0}, {0, 0}, {0, 1.2}});
  Met met({&settings});
  std::map<std::int32_t, std::vector<Point>> of_candidate;
  for (const Point& point : met.found({-a, -b})) of_candidate[point.candidate].push_back(point);
  EXPECT_EQ(of_candidate.size(), 11u);  // six beside each face, one of them in the corner
  int corners = 0;
  for (const auto& [candidate, points] : of_candidate) {
    if (points.size() == 1) continue;
    ASSERT_EQ(points.size(), 2u);
    ++corners;
    EXPECT_NEAR(points[0].part + points[1].part, 1, 1e-12);
    for (const Point& point : points) {
      const double own = point.feature.normal[0] > 0.5 ? a : b;
      EXPECT_NEAR(point.depth * point.depth, u * own, 1e-15);
      EXPECT_NEAR(point.part, own * own / (u * u), 1e-12);
      EXPECT_EQ(point.num_others, 2);
    }
  }
  EXPECT_EQ(corners, 1);
}

TEST(ContactPoints, numbers_of_the_members_are_all_of_them_in_the_order_of_the_search) {
  const auto right = surface_through({{1.2, 0}, {0.5, 0}}),
             left = surface_through({{0.5, 0}, {-0.2, 0}});
  Met met({&right, &left});
  const auto& points = met.found({0, -0.01});
  ASSERT_EQ(points.size(), 6u);
  std::vector<std::int32_t> all;
  for (std::int32_t m = 0; m < 2; ++m) {
    const auto own = met.parts.points.of(m);
    EXPECT_EQ(own.size(), 3u);
    EXPECT_TRUE(std::is_sorted(own.begin(), own.end()));
    for (const std::int32_t k : own) EXPECT_EQ(points[k].owner, m);
    all.insert(all.end(), own.begin(), own.end());
  }
  const auto by_owner = met.parts.points.by_owner();
  EXPECT_TRUE(std::equal(all.begin(), all.end(), by_owner.begin(), by_owner.end()));
  met.parts.points.clear();
  EXPECT_TRUE(met.parts.points.all().empty());
  EXPECT_TRUE(met.parts.points.of(0).empty() && met.parts.points.of(1).empty());
}

}  // namespace
}  // namespace gabion::test::test_contact_points
