// SPDX-License-Identifier: BSD-3-Clause
// Which groups of points a contact looks at.
#include <gtest/gtest.h>

#include <algorithm>
#include <memory>

#include "mpm_solver/contact/facet_parts.hpp"
#include "mpm_solver/contact/soil_extent.hpp"
#include "tests/unit/mpm/soil_patch.hpp"

namespace gabion::test::test_soil_extent {
namespace {

template <int dim>
mpm::SoilSurface<dim> surface_of(const SoilPatch<dim>& soil) {
  return {.grid = soil.grid,
          .nodes = soil.nodes,
          .points = soil.points,
          .weights = soil.weights,
          .cell_size = 1.0 / 8,
          .dt = 1e-3};
}

// Boxes of any size and place, a plane and a point have all groups with a point in them.
template <int dim>
void check_boxes() {
  SoilPatch<dim> soil(dim == 2 ? CellType::quad4 : CellType::hex8, 8);
  soil.scatter(dim == 2 ? 300 : 900);
  soil.to_grid();
  const mpm::SoilExtent<dim> extent(surface_of(soil));
  const auto& groups = soil.weights.groups;
  Random random;
  std::size_t few = 0, others = 0;
  for (int k = 0; k < 300; ++k) {
    const Vector<dim> half =
        std::pow(10, 2 * random() - 1) * (random.template vector<dim>() + Vector<dim>::Ones());
    const Vector<dim> middle = Vector<dim>::Constant(0.5) + random.template vector<dim>();
    const Eigen::AlignedBox<double, dim> box(middle - half, middle + half);
    const auto found = extent.groups_in(box);
    ASSERT_TRUE(std::ranges::is_sorted(found));
    ASSERT_EQ(std::ranges::adjacent_find(found), found.end());
    few += found.size() < groups.size() / 2 ? 1 : 0;
    for (std::int32_t g = 0; g < std::ssize(groups); ++g) {
      const bool listed = std::ranges::binary_search(found, g);
      bool inside = false;
      for (std::int32_t e = groups[g].first; e < groups[g].last; ++e) {
        inside |= box.contains(soil.points.x[soil.weights.point[e]]);
      }
      ASSERT_TRUE(listed || !inside);
      others += listed && !inside ? 1 : 0;
    }
  }
  EXPECT_GT(few, 100u);
  EXPECT_GT(others, 0u);
  const Vector<dim> far = Vector<dim>::Constant(1e300);
  EXPECT_EQ(extent.groups_in({-far, far}).size(), groups.size());
  EXPECT_TRUE(extent.groups_in({far, far}).empty());
  EXPECT_TRUE(extent.groups_in({}).empty());
}

TEST(SoilExtent, has_all_groups_with_a_point_in_a_box) {
  check_boxes<2>();
  check_boxes<3>();
}

/// A surface of one segment below the soil, at a depth.
struct Below {
  SoilPatch<2> soil{CellType::quad4, 8};
  mpm::ContactSettings<2> settings;
  std::vector<char> elastic{0};
  std::vector<double> moduli{1e4}, weights{100};
  std::unique_ptr<mpm::FacetParts<2>> parts;

  explicit Below(double depth) {
    settings.method =
        mpm::FacetSettings{.penalty_factor = 50, .resting_factor = 12, .tangential_factor = 0.5};
    settings.friction = 0.3;
    settings.surface.vertices = {{1.2, -depth}, {-0.2, -depth}};
    settings.surface.facets = {0, 1};
    soil.fill(4);
    soil.to_grid();
    parts = std::make_unique<mpm::FacetParts<2>>(
        std::vector<const mpm::ContactSettings<2>*>{&settings});
  }
  void begin() {
    auto surface = surface_of(soil);
    surface.elastic = elastic;
    surface.moduli = moduli;
    surface.weights_of = weights;
    parts->laws.begin_step(surface);
    parts->search.begin_step(surface, 0);
    parts->surface.set_displacement(std::vector<double>(4), 0);
  }
  std::size_t found(double down) {
    std::vector<double> du;
    for (std::int32_t i = 0; i < soil.nodes.size(); ++i) du.insert(du.end(), {0, -down});
    parts->points.find(du);
    return parts->points.all().size();
  }
};

TEST(SoilExtent, soil_near_a_surface_meets_it) {
  Below near(0.01), far(30);
  near.begin();
  far.begin();
  EXPECT_EQ(near.found(0.02), 16u);  // two points a cell
  EXPECT_TRUE(near.parts->search.can_touch(0));
  EXPECT_EQ(far.found(0.02), 0u);
  EXPECT_FALSE(far.parts->search.can_touch(0));
}

/// A force of the step before acts on its point wherever the surface has gone.
TEST(SoilExtent, points_that_are_remembered_are_watched_at_any_distance) {
  Below far(30);
  far.parts->memory.add(7).push_back({.normal = {0, 1}, .force = {0, 1}});
  far.begin();
  EXPECT_EQ(far.found(0.02), 0u);
  const auto& candidates = far.parts->search.candidates();
  ASSERT_EQ(candidates.size(), 1u);
  EXPECT_EQ(candidates[0].id, 7);
  EXPECT_TRUE(far.parts->search.can_touch(0));
}

}  // namespace
}  // namespace gabion::test::test_soil_extent
