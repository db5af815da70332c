// SPDX-License-Identifier: BSD-3-Clause
#include "mpm_solver/boulders/boulder_shape.hpp"
#include "mpm_solver/boulders/polygon.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <string>

#include "common/base/error.hpp"
#include "tests/support/expect_error.hpp"

namespace gabion::mpm::test_boulder_shape {
namespace {

template <int dim>
void expect_same_mass(const BoulderShape<dim>& shape, double density, double tolerance) {
  const BodyMass meshed = mass_within(shape.surface, density);
  EXPECT_NEAR(meshed.mass / shape.mass.mass, 1, 1e-12);
  EXPECT_LT(meshed.centre.norm(), 1e-12 * shape.radius);
  EXPECT_LT((meshed.inertia - shape.mass.inertia).norm(), tolerance * shape.mass.inertia.norm());
}

TEST(BoulderShape, balls_have_the_mass_of_their_radius) {
  const auto sphere = sphere_shape<3>(0.5, 2650);
  EXPECT_NEAR(sphere.mass.mass, 1387.537, 1e-3);
  EXPECT_NEAR(sphere.mass.inertia(0, 0), 0.4 * sphere.mass.mass * 0.25, 1e-9);
  EXPECT_EQ(sphere.surface.facets.size(), 3u * 1280);
  expect_same_mass(sphere, 2650, 1e-3);
  const auto disc = sphere_shape<2>(0.5, 1000);
  EXPECT_NEAR(disc.mass.mass, 250 * std::numbers::pi, 1e-9);
  EXPECT_NEAR(disc.mass.inertia(2, 2), 0.5 * disc.mass.mass * 0.25, 1e-9);
  expect_same_mass(disc, 1000, 1e-3);
}

TEST(BoulderShape, facets_of_boxes_hold_their_mass) {
  const auto box = box_shape<3>({1, 2, 0.5}, 2000);
  EXPECT_NEAR(box.mass.mass, 2000, 1e-9);
  EXPECT_NEAR(box.mass.inertia(0, 0), 2000 * (4 + 0.25) / 12, 1e-9);
  EXPECT_EQ(box.thickness, 0.5);
  expect_same_mass(box, 2000, 1e-12);
  const auto sides = box_shape<2>({1, 2}, 2000);
  EXPECT_NEAR(sides.mass.inertia(2, 2), 4000 * 5 / 12., 1e-9);
  expect_same_mass(sides, 2000, 1e-12);
}

ContactSurface<3> tetrahedron() {
  return {.vertices = {{1, 1, 1}, {2, 1, 1}, {1, 2, 1}, {1, 1, 2}},
          .facet_type = CellType::tri3,
          .facets = {0, 2, 1, 0, 1, 3, 0, 3, 2, 1, 2, 3}};
}

TEST(BoulderShape, a_surface_is_moved_to_its_centre) {
  const auto shape = surface_shape<3>(tetrahedron(), 600);
  EXPECT_NEAR(shape.mass.mass, 100, 1e-10);
  EXPECT_LT((shape.mass.centre - Vector<3>(1.25, 1.25, 1.25)).norm(), 1e-14);
  EXPECT_NEAR(shape.mass.inertia(0, 0), 100 * 2 * 3. / 80, 1e-10);
  EXPECT_NEAR(shape.mass.inertia(0, 1), 100 / 80., 1e-10);
  expect_same_mass(shape, 600, 1e-12);
}

TEST(BoulderShape, a_surface_far_from_the_origin_has_the_same_mass) {
  const auto near = surface_shape<3>(tetrahedron(), 600);
  const Vector<3> far(5e5, 5e6, 300);
  auto moved = tetrahedron();
  for (Vector<3>& X : moved.vertices) X += far;
  const auto shape = surface_shape<3>(moved, 600);
  EXPECT_NEAR(shape.mass.mass, 100, 1e-10);
  EXPECT_LT((shape.mass.inertia - near.mass.inertia).norm(), 1e-12 * near.mass.inertia.norm());
  EXPECT_LT((shape.mass.centre - far - near.mass.centre).norm(), 2e-9);
  for (std::size_t v = 0; v < near.surface.vertices.size(); ++v) {
    EXPECT_LT((shape.surface.vertices[v] - near.surface.vertices[v]).norm(), 1e-14);
  }
  ContactSurface<2> square{
      .vertices = {{5e5, 5e6}, {5e5 + 1, 5e6}, {5e5 + 1, 5e6 + 1}, {5e5, 5e6 + 1}},
      .facets = {0, 1, 1, 2, 2, 3, 3, 0}};
  EXPECT_NEAR(surface_shape<2>(square, 600).mass.inertia(2, 2), 100, 1e-10);
}

TEST(BoulderShape, an_inertia_that_is_not_positive_is_refused) {
  auto surface = tetrahedron();
  const auto hole = tetrahedron();
  for (const Vector<3>& X : hole.vertices) surface.vertices.push_back(0.5 * X + Vector<3>(9, 0, 0));
  for (std::size_t f = 0; f < hole.facets.size(); f += 3) {
    for (const int k : {1, 0, 2}) surface.facets.push_back(4 + hole.facets[f + k]);
  }
  std::string text;
  try {
    surface_shape<3>(surface, 1);
  } catch (const ConfigError& error) {
    text = error.what();
  }
  EXPECT_NE(text.find("found a least moment of inertia of -"), std::string::npos) << text;
}

TEST(BoulderShape, thickness_is_that_of_a_slab_at_any_angle) {
  for (const double angle : {0.0, 0.3, M_PI / 4, 1.2}) {
    const Eigen::Rotation2Dd turn(angle);
    ContactSurface<2> slab;
    for (const Vector<2>& corner : {Vector<2>(-0.7, -0.05), Vector<2>(0.7, -0.05),
                                    Vector<2>(0.7, 0.05), Vector<2>(-0.7, 0.05)}) {
      slab.vertices.push_back(turn * corner);
    }
    slab.facets = {0, 1, 1, 2, 2, 3, 3, 0};
    EXPECT_NEAR(surface_shape<2>(slab, 2600).thickness, 0.1, 1e-12) << angle;
  }
}

TEST(BoulderShape, open_and_inward_surfaces_are_refused_with_the_place) {
  auto open = tetrahedron();
  open.facets.resize(9);
  auto inward = tetrahedron();
  for (std::size_t f = 0; f < inward.facets.size(); f += 3) {
    std::swap(inward.facets[f], inward.facets[f + 1]);
  }
  const auto text_of = [](const ContactSurface<3>& surface) {
    try {
      surface_shape<3>(surface, 1);
    } catch (const ConfigError& error) {
      return std::string(error.what());
    }
    return std::string();
  };
  EXPECT_NE(text_of(open).find("found an edge at ("), std::string::npos);
  EXPECT_NE(text_of(inward).find("found a volume of -0.166667"), std::string::npos);
}

std::string fault_of(const Polygon& polygon) {
  try {
    require_simple(polygon);
  } catch (const ConfigError& error) {
    return error.what();
  }
  return "";
}

TEST(BoulderShape, a_polygon_that_crosses_itself_is_refused) {
  ContactSurface<2> bow{.vertices = {{0, 0}, {1, 1}, {1, 0}, {0, 1}},
                        .facets = {0, 1, 1, 2, 2, 3, 3, 0}};
  const auto text = test::error_of<ConfigError>([&] { surface_shape<2>(bow, 1); });
  EXPECT_NE(text.find("found sides 0 and 2 that meet"), std::string::npos) << text;
  EXPECT_NE(fault_of(bow.vertices).find("found sides 0 and 2 that meet"), std::string::npos);
  EXPECT_NE(fault_of({{0, 0}, {2, 0}, {1, 0}, {1, 1}}).find("sides 0 and 1"), std::string::npos);
  EXPECT_NE(fault_of({{1, 0}, {2, 0}, {2, 1}, {0, 0}, {1.5, 0}}).find("meet"), std::string::npos);
  EXPECT_NE(fault_of({{0, 0}, {1, 0}, {1, 1}, {0, 1}, {0, 0}}).find("twice in a row"),
            std::string::npos);
}

/// Sides on one line that do not touch are no crossing, turned by any angle.
TEST(BoulderShape, a_polygon_with_a_notch_is_simple) {
  for (const double angle : {0.0, 0.3, 1.0, 2.0}) {
    Polygon notched = {{0, 0}, {3, 0}, {3, 1}, {2, 1}, {2, 0.5}, {1, 0.5}, {1, 1}, {0, 1}};
    for (auto& x : notched) x = Eigen::Rotation2Dd(angle) * x;
    EXPECT_EQ(fault_of(notched), "") << angle;
    EXPECT_NEAR(signed_area(notched), 2.5, 1e-12);
    EXPECT_TRUE(is_inside(notched, Eigen::Rotation2Dd(angle) * Vector<2>(1.5, 0.4)));
    EXPECT_FALSE(is_inside(notched, Eigen::Rotation2Dd(angle) * Vector<2>(1.5, 0.6)));
    EXPECT_NEAR(distance_to(notched, Eigen::Rotation2Dd(angle) * Vector<2>(1.5, 0.7)), 0.2, 1e-12);
  }
}

}  // namespace
}  // namespace gabion::mpm::test_boulder_shape
