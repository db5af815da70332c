// SPDX-License-Identifier: BSD-3-Clause
#include <fmt/format.h>
#include <gtest/gtest.h>
#include <unistd.h>

#include <cmath>
#include <filesystem>
#include <fstream>

#include "tests/support/verification_row.hpp"
#include "tests/unit/mpm/mpm_scene.hpp"

namespace gabion::test {
namespace {

/// V9: an elastic block on terrain, a plane of triangles from a file, that goes down by the angle
/// `slope` in the direction `azimuth` of the grid. The block is laid in upright columns that stand
/// on the plane.
///
///     a = g (sin - mu cos)
struct Incline {
  double slope, azimuth;  // [deg]
  double mu;
  double g = 9.81, h = 0.25;  // cells [m]

  Vector<3> down() const {
    const double t = std::tan(slope * M_PI / 180), a = azimuth * M_PI / 180;
    return {-t * std::cos(a), -t * std::sin(a), 0};
  }
  /// Height over the place.
  double height(double x, double y) const { return 3 + down().dot(Vector<3>(x - 2, y - 2, 0)); }
  double acceleration() const {
    const double angle = slope * M_PI / 180;
    return g * (std::sin(angle) - mu * std::cos(angle));
  }
  /// Along the slope, pointing down.
  Vector<3> direction() const {
    const double angle = slope * M_PI / 180, a = azimuth * M_PI / 180;
    return {std::cos(angle) * std::cos(a), std::cos(angle) * std::sin(a), -std::sin(angle)};
  }
};

class Terrain : public testing::Test {
 protected:
  void SetUp() override {
    folder_ = std::filesystem::temp_directory_path() / fmt::format("gabion_terrain_{}", getpid());
    std::filesystem::create_directories(folder_);
  }
  void TearDown() override { std::filesystem::remove_all(folder_); }

  /// Triangles of the plane, their normals down where `key` "normals" has to turn them.
  std::string surface(const Incline& incline) const {
    std::ofstream out(folder_ / "plane.stl");
    out.precision(17);
    out << "solid plane\n";
    constexpr double size = 0.5;
    const auto vertex = [&](double x, double y) {
      out << "vertex " << x << " " << y << " " << incline.height(x, y) << "\n";
    };
    for (double y = 0; y < 5; y += size) {
      for (double x = 0; x < 5; x += size) {
        for (const bool upper : {false, true}) {
          out << "facet normal 0 0 0\nouter loop\n";
          vertex(x, y);
          vertex(x + size, y + size);
          vertex(upper ? x : x + size, upper ? y + size : y);
          out << "endloop\nendfacet\n";
        }
      }
    }
    out << "endsolid\n";
    return (folder_ / "plane.stl").string();
  }

  /// Cells of the block as a Gmsh file.
  std::string block(const Incline& incline, double size, int cells, int layers) const {
    std::ofstream out(folder_ / "block.msh");
    out.precision(17);
    const int n = cells + 1, num_nodes = n * n * (layers + 1), num_cells = cells * cells * layers;
    out << "$MeshFormat\n4.1 0 8\n$EndMeshFormat\n$Nodes\n1 " << num_nodes << " 1 " << num_nodes
        << "\n3 1 0 " << num_nodes << "\n";
    for (int k = 1; k <= num_nodes; ++k) out << k << "\n";
    for (int k = 0; k <= layers; ++k) {
      for (int j = 0; j < n; ++j) {
        for (int i = 0; i < n; ++i) {
          const double x = 1.33 + i * size, y = 1.41 + j * size;
          out << x << " " << y << " " << incline.height(x, y) + k * size << "\n";
        }
      }
    }
    out << "$EndNodes\n$Elements\n1 " << num_cells << " 1 " << num_cells << "\n3 1 5 " << num_cells
        << "\n";
    int tag = 0;
    for (int k = 0; k < layers; ++k) {
      for (int j = 0; j < cells; ++j) {
        for (int i = 0; i < cells; ++i) {
          const int a = 1 + i + n * (j + n * k), b = a + n * n;
          out << fmt::format("{} {} {} {} {} {} {} {} {}\n", ++tag, a, a + 1, a + n + 1, a + n, b,
                             b + 1, b + n + 1, b + n);
        }
      }
    }
    out << "$EndElements\n";
    return (folder_ / "block.msh").string();
  }

  Json scene(const Incline& incline) const {
    const int cells = static_cast<int>(std::lround(5 / incline.h));
    return {{"dimension", 3},
            {"grid", box({0, 0, 0}, {5, 5, 5}, {cells, cells, cells}, "hex8")},
            {"gravity", {0, 0, -incline.g}},
            {"bodies",
             {body("block", {{"file", block(incline, incline.h, 4, 2)}}, 8,
                   elastic_soil("neo_hookean", 2e6, 0.2, 1000))}},
            {"time_integration", {{"scheme", "bossak"}, {"alpha", -0.3}}},
            {"rigid_walls",
             {{{"name", "terrain"},
               {"surface", {{"triangles", surface(incline)}, {"normals", "up"}}},
               {"friction", incline.mu}}}}};
  }

  std::filesystem::path folder_;
};

TEST_F(Terrain, a_block_slides_as_fast_whatever_the_slope_against_the_grid) {
  for (const Incline& incline :
       {Incline{25, 0, 0.2}, Incline{25, 30, 0.2}, Incline{35, 45, 0.3}, Incline{15, 117, 0}}) {
    const auto solver = make_mpm(scene(incline));
    const auto speed = [&]() -> Vector<3> {
      Vector<3> momentum = Vector<3>::Zero();
      const char* names[] = {"momentum_x", "momentum_y", "momentum_z"};
      for (int d = 0; d < 3; ++d) momentum[d] = probe(*solver, names[d]);
      return Vector<3>(momentum / probe(*solver, "mass"));
    };
    constexpr double dt = 4e-3;
    run_steps(*solver, dt, 50);
    const Vector<3> before = speed();
    run_steps(*solver, dt, 200, 51);
    const Vector<3> gained = (speed() - before) / (200 * dt);
    verify({.id = "V9",
            .what = fmt::format("acceleration of a block on terrain of {} degrees that falls "
                                "towards {} degrees of the grid, mu {}, 3D",
                                incline.slope, incline.azimuth, incline.mu),
            .exact = incline.acceleration(),
            .computed = gained.dot(incline.direction()),
            .bound = 5e-3,
            .unit = "m/s^2"});
    const Vector<3> aside = gained - gained.dot(incline.direction()) * incline.direction();
    EXPECT_LT(aside.norm(), 0.02 * incline.acceleration()) << incline.azimuth;
  }
}

}  // namespace
}  // namespace gabion::test
