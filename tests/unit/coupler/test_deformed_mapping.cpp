// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include <Eigen/Geometry>

#include "coupler/mapping/interface_map.hpp"
#include "tests/unit/coupler/sequence.hpp"
#include "tests/unit/coupler/surface_meshes.hpp"

namespace gabion::test_deformed_mapping {
namespace {

using test::SurfacePair;
using Values = std::vector<double>;
using Motion = std::function<Eigen::Vector3d(const Eigen::Vector3d&)>;

/// Segments through these stations of the x axis, moved out of the structure by a gap [m].
InterfaceMesh line(const Values& stations, double gap = 0) {
  return test::line_mesh(stations, [gap](double s) { return std::pair(s, -gap); });
}

/// Unit square in the plane z = gap, n x m quads or twice as many triangles.
InterfaceMesh sheet(int n, int m, int vertices_per_facet, double gap = 0) {
  return test::sheet_mesh(n, m, vertices_per_facet, [gap](double, double) { return gap; });
}

std::vector<SurfacePair> gapped_pairs(double gap) {
  return {{line({0, 0.2, 0.55, 1}), line({0, 0.1, 0.37, 0.6, 0.93, 1}, gap)},
          {sheet(3, 2, 3), sheet(4, 5, 3, gap)},
          {sheet(3, 2, 4), sheet(4, 5, 3, gap)}};
}

/// Roll up around an axis along z (2D) or y (3D) by an angle [rad] at x = 1, and twist.
Motion roll(int dim, double angle) {
  return [=](const Eigen::Vector3d& X) {
    const int up = dim - 1;
    const double r = 1 / angle - X(up);
    Eigen::Vector3d x = X;
    x(0) = r * std::sin(angle * X(0));
    x(up) = 1 / angle - r * std::cos(angle * X(0));
    if (dim == 3) x(2) += 0.2 * angle * X(0) * X(1);
    return x;
  };
}

InterfaceMesh moved(InterfaceMesh mesh, const Motion& motion) {
  for (std::int64_t v = 0; v < mesh.num_vertices(); ++v) {
    Eigen::Vector3d X = Eigen::Vector3d::Zero();
    for (int i = 0; i < mesh.dim; ++i) X(i) = mesh.coordinates[v * mesh.dim + i];
    const Eigen::Vector3d x = motion(X);
    for (int i = 0; i < mesh.dim; ++i) mesh.coordinates[v * mesh.dim + i] = x(i);
  }
  return mesh;
}

Eigen::VectorXd vector_of(const Values& values) {
  return Eigen::Map<const Eigen::VectorXd>(values.data(), std::ssize(values));
}

Eigen::VectorXd displacement_of(const InterfaceMesh& mesh, const Motion& motion) {
  return vector_of(moved(mesh, motion).coordinates) - vector_of(mesh.coordinates);
}

Eigen::VectorXd random_vector(Eigen::Index size, int seed) {
  test::Sequence sequence(seed);
  Eigen::VectorXd values(size);
  for (double& value : values) value = sequence();
  return values;
}

InterfaceMap map_of(const SurfacePair& pair, bool deformed, double moved_share = 0) {
  MappingSettings settings;
  settings.tolerance = 0.1;
  settings.deformed = deformed;
  settings.moved = moved_share;
  return {{{"wall", "soil", "structure"}},
          {{"soil", {pair.soil}}, {"structure", {pair.structure}}},
          settings};
}

int num_set_ups(const InterfaceMap& map) {
  return map.report()["wall"]["set_ups"];
}

/// Follow the roll in five steps of 0.3 rad. @returns the last displacement
Eigen::VectorXd roll_up(const SurfacePair& pair, InterfaceMap& map) {
  Eigen::VectorXd x;
  for (int k = 1; k <= 5; ++k) {
    x = displacement_of(pair.structure, roll(pair.structure.dim, 0.3 * k));
    map.accept(x);
  }
  return x;
}

TEST(DeformedMapping, vertices_on_the_surface_keep_their_weights) {
  for (const SurfacePair& pair : gapped_pairs(0)) {
    InterfaceMap map = map_of(pair, true);
    const InterfaceMap reference = map_of(pair, false);
    roll_up(pair, map);
    EXPECT_EQ(num_set_ups(map), 6);
    const Eigen::VectorXd x = random_vector(map.size(), 1);
    EXPECT_LE((map.soil_displacement(x) - reference.soil_displacement(x)).cwiseAbs().maxCoeff(),
              1e-12);
  }
}

TEST(DeformedMapping, constants_are_exact_and_nothing_jumps) {
  for (const SurfacePair& pair : gapped_pairs(0.03)) {
    InterfaceMap map = map_of(pair, true);
    const int dim = pair.structure.dim;
    for (int k = 1; k <= 3; ++k) {
      const Eigen::VectorXd x = displacement_of(pair.structure, roll(dim, 0.4 * k));
      const Eigen::VectorXd before = map.soil_displacement(x);
      map.accept(x);
      EXPECT_EQ(map.soil_displacement(x), before);
      const Motion shift = [](const Eigen::Vector3d& X) -> Eigen::Vector3d {
        return X + Eigen::Vector3d(0.5, -2, 3);
      };
      const Eigen::VectorXd step =
          map.soil_displacement(x + displacement_of(pair.structure, shift)) - before;
      EXPECT_LE((step - displacement_of(pair.soil, shift)).cwiseAbs().maxCoeff(), 1e-14);
    }
    EXPECT_EQ(num_set_ups(map), 4);
  }
}

TEST(DeformedMapping, force_moment_and_work_are_conserved_in_deformed_positions) {
  for (const double gap : {0.0, 0.03}) {
    for (const SurfacePair& pair : gapped_pairs(gap)) {
      InterfaceMap map = map_of(pair, true);
      const Eigen::VectorXd x1 = roll_up(pair, map);
      const Eigen::VectorXd x2 = x1 + 0.1 * random_vector(map.size(), 2);
      const Eigen::VectorXd f = random_vector(std::ssize(pair.soil.coordinates), 3);
      const Eigen::VectorXd F = map.structure_force(f);
      EXPECT_NEAR(f.dot(map.soil_displacement(x2) - map.soil_displacement(x1)), F.dot(x2 - x1),
                  1e-12);

      const Resultant here = map.soil_resultant(map.soil_displacement(x2), f);
      const Resultant there = map.structure_resultant(x2, F);
      EXPECT_GT(here.moment.norm(), 0.1);
      EXPECT_LE((here.force - there.force).norm(), 1e-12);
      if (gap > 0) continue;
      EXPECT_LE((here.moment - there.moment).norm(), 1e-12);
    }
  }
}

TEST(DeformedMapping, across_a_gap_the_moment_of_normal_forces_is_kept) {
  constexpr double gap = 0.05;
  const SurfacePair pair = {line({0, 0.4, 1}), line({0.3, 0.5, 0.8}, gap)};
  const Motion upright = [](const Eigen::Vector3d& X) { return Eigen::Vector3d(-X(1), X(0), 0); };
  const Eigen::VectorXd x = displacement_of(pair.structure, upright);
  const Eigen::VectorXd push = vector_of({1, 0, 1, 0, 1, 0});  // along the normal
  const auto mismatch = [&](bool deformed) {
    InterfaceMap map = map_of(pair, deformed);
    map.accept(x);
    const Resultant here = map.soil_resultant(map.soil_displacement(x), push);
    return (here.moment - map.structure_resultant(x, map.structure_force(push)).moment).norm();
  };
  EXPECT_NEAR(mismatch(false), 3 * gap, 1e-14);  // the gap did not turn with the structure
  EXPECT_LE(mismatch(true), 1e-14);
}

TEST(DeformedMapping, a_rigid_motion_of_both_sides_leaves_the_map_unchanged) {
  for (const SurfacePair& pair : gapped_pairs(0.03)) {
    const int dim = pair.structure.dim;
    const Eigen::Vector3d axis =
        dim == 2 ? Eigen::Vector3d(0, 0, 1) : Eigen::Vector3d(1, -2, 0.5).normalized();
    const Eigen::Matrix3d R = Eigen::AngleAxisd(2.1, axis).toRotationMatrix();
    const Motion motion = [&](const Eigen::Vector3d& X) -> Eigen::Vector3d {
      return R * X + Eigen::Vector3d(3, -1, dim == 2 ? 0 : 2);
    };
    const InterfaceMap here = map_of(pair, false);
    const InterfaceMap there =
        map_of({moved(pair.structure, motion), moved(pair.soil, motion)}, false);
    const Eigen::VectorXd x = random_vector(here.size(), 4);
    EXPECT_LE((here.soil_displacement(x) - there.soil_displacement(x)).cwiseAbs().maxCoeff(),
              1e-12);
  }
}

TEST(DeformedMapping, a_state_that_was_saved_gives_the_same_bits) {
  for (const SurfacePair& pair : gapped_pairs(0.03)) {
    InterfaceMap map = map_of(pair, true, 0.01);
    roll_up(pair, map);
    State state;
    StateWriter writer(state);
    map.visit_state(writer);
    InterfaceMap again = map_of(pair, true, 0.01);
    StateReader reader(state);
    again.visit_state(reader);
    const Eigen::VectorXd x = random_vector(map.size(), 5);
    const Eigen::VectorXd f = random_vector(std::ssize(pair.soil.coordinates), 6);
    EXPECT_NE(again.soil_displacement(x), map_of(pair, true).soil_displacement(x));
    EXPECT_EQ(again.soil_displacement(x), map.soil_displacement(x));
    EXPECT_EQ(again.structure_force(f), map.structure_force(f));
  }
}

TEST(DeformedMapping, is_set_up_again_once_a_vertex_has_moved_enough) {
  const SurfacePair pair = gapped_pairs(0.03)[0];
  InterfaceMap map = map_of(pair, true, 0.1);  // of the extent 1 m
  Eigen::VectorXd x = Eigen::VectorXd::Zero(map.size());
  const auto set_ups_at = [&](double u) {
    x(3) = u;
    map.accept(x);
    return num_set_ups(map);
  };
  EXPECT_EQ(set_ups_at(0.09), 1);
  EXPECT_EQ(set_ups_at(0.11), 2);
  EXPECT_EQ(set_ups_at(0.2), 2);  // 0.09 since the last one
  EXPECT_EQ(set_ups_at(0.0), 3);
}

TEST(DeformedMapping, equal_vertices_stay_copied) {
  const SurfacePair pair = {line({0, 0.4, 1}), line({0, 0.4, 1})};
  InterfaceMap map = map_of(pair, true);
  const Eigen::VectorXd x = displacement_of(pair.structure, roll(2, 1));
  map.accept(x);
  EXPECT_EQ(num_set_ups(map), 1);
  EXPECT_EQ(map.soil_displacement(x), x);
}

}  // namespace
}  // namespace gabion::test_deformed_mapping
