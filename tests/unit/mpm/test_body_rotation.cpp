// SPDX-License-Identifier: BSD-3-Clause
#include "mpm_solver/points/body_rotation.hpp"

#include <Eigen/Geometry>
#include <cmath>

#include "tests/unit/mpm/mpm_scene.hpp"

namespace gabion::test::test_body_rotation {
namespace {

template <int dim>
Json block(const std::string& law) {
  const std::vector<double> low(dim, 0.0), high(dim, 4.0), from(dim, 1.0), to(dim, 2.0);
  const std::string type = dim == 2 ? "quad4" : "hex8";
  return {{"dimension", dim},
          {"grid", box(low, high, std::vector<int>(dim, 4), type)},
          {"basis", "linear"},
          {"bodies",
           {body("block", box(from, to, std::vector<int>(dim, 2), type), dim == 2 ? 4 : 8,
                 elastic_soil(law, 1e5, 0.3, 1000))}},
          {"time_integration", trapezoid}};
}

/// Turn and shift the points.
template <int dim>
mpm::MaterialPoints<dim> turned(mpm::MaterialPoints<dim> points, const Matrix<dim>& R) {
  const Vector<dim> centre = Vector<dim>::Constant(1.5), shift = Vector<dim>::Constant(0.3);
  for (std::int32_t p = 0; p < points.size(); ++p) {
    const Vector<dim> X = points.x[p] - points.u[p];
    points.x[p] = centre + shift + R * (X - centre);
    points.u[p] = points.x[p] - X;
  }
  return points;
}

TEST(BodyRotation, is_that_of_the_points) {
  for (const double degrees : {0.0, 8.0, 30.0, 100.0}) {
    const double angle = degrees * M_PI / 180;
    const auto flat = turned<2>(mpm_solver<2>(block<2>("linear_elastic"))->points(),
                                Eigen::Rotation2D<double>(angle).toRotationMatrix());
    EXPECT_NEAR(mpm::body_rotation<2>(comm(), flat, 0), angle, 1e-12);
    const Matrix<3> R =
        Eigen::AngleAxis<double>(angle, Vector<3>(2, -1, 1).normalized()).toRotationMatrix();
    const auto solid = turned<3>(mpm_solver<3>(block<3>("linear_elastic"))->points(), R);
    EXPECT_NEAR(mpm::body_rotation<3>(comm(), solid, 0), angle, 1e-7);
  }
}

TEST(BodyRotation, is_said_of_linear_elastic_bodies_alone) {
  for (const char* law : {"linear_elastic", "hencky_elastic"}) {
    const auto settings = mpm_settings<2>(block<2>(law));
    const auto points = turned<2>(mpm_solver<2>(block<2>(law))->points(),
                                  Eigen::Rotation2D<double>(0.7).toRotationMatrix());
    mpm::BodyRotations<2> rotations(comm(), settings.bodies);
    testing::internal::CaptureStderr();
    rotations.look(points);
    rotations.look(points);
    const std::string said = testing::internal::GetCapturedStderr();
    const auto place = said.find("body \"block\": linear_elastic has rotated by 40 degrees");
    EXPECT_EQ(place != std::string::npos, law == std::string("linear_elastic")) << said;
    EXPECT_EQ(said.find("turned", place + 60), std::string::npos) << said;
  }
}

}  // namespace
}  // namespace gabion::test::test_body_rotation
