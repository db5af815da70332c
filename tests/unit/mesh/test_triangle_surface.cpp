// SPDX-License-Identifier: BSD-3-Clause
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <cstring>
#include <filesystem>
#include <fstream>

#include "common/mechanics/mesh/triangle_surface.hpp"
#include "tests/support/expect_error.hpp"

namespace gabion::test::test_triangle_surface {
namespace {

using Triangle = std::array<Vector<3>, 3>;

/// A square of two triangles that look up.
std::vector<Triangle> square() {
  const Vector<3> a(0, 0, 0), b(2, 0, 0.5), c(2, 2, 1), d(0, 2, 0.25);
  return {{a, b, c}, {a, c, d}};
}

std::string stl_text(const std::vector<Triangle>& triangles) {
  std::ostringstream out;
  out.precision(17);
  out << "solid some name\n";
  for (const auto& triangle : triangles) {
    out << "facet normal 0 0 0\n outer loop\n";
    for (const auto& x : triangle) out << "  vertex " << x.transpose() << "\n";
    out << " endloop\nendfacet\n";
  }
  return out.str() + "endsolid some name\n";
}

template <class Number>
void append(std::string& bytes, Number value) {
  char raw[sizeof(Number)];
  std::memcpy(raw, &value, sizeof(Number));
  bytes.append(raw, sizeof(Number));
}

std::string stl_bytes(const std::vector<Triangle>& triangles) {
  std::string bytes = fmt::format("{:80}", "solid that is none");  // as some programs write it
  append(bytes, static_cast<std::uint32_t>(triangles.size()));
  for (const auto& triangle : triangles) {
    for (int d = 0; d < 3; ++d) append(bytes, 0.0F);
    for (const auto& x : triangle) {
      for (int d = 0; d < 3; ++d) append(bytes, static_cast<float>(x[d]));
    }
    append(bytes, std::uint16_t{0});
  }
  return bytes;
}

constexpr std::string_view ply_head =
    "comment made by hand\nelement vertex 4\nproperty float x\nproperty float y\n"
    "property double z\nproperty uchar red\nelement face 2\n"
    "property list uchar int vertex_indices\nend_header\n";

std::string ply_text() {
  return fmt::format("ply\nformat ascii 1.0\n{}{}", ply_head,
                     "0 0 0 7\n2 0 0.5 7\n2 2 1 7\n0 2 0.25 7\n3 0 1 2\n3 0 2 3\n");
}

std::string ply_bytes() {
  std::string bytes = fmt::format("ply\nformat binary_little_endian 1.0\n{}", ply_head);
  const auto triangles = square();
  for (const Vector<3>& x : {triangles[0][0], triangles[0][1], triangles[0][2], triangles[1][2]}) {
    append(bytes, static_cast<float>(x[0]));
    append(bytes, static_cast<float>(x[1]));
    append(bytes, x[2]);
    append(bytes, std::uint8_t{7});
  }
  for (const std::array<std::int32_t, 3>& face : {std::array{0, 1, 2}, std::array{0, 2, 3}}) {
    append(bytes, std::uint8_t{3});
    for (const std::int32_t v : face) append(bytes, v);
  }
  return bytes;
}

class TriangleFiles : public testing::Test {
 protected:
  void TearDown() override { std::filesystem::remove(path_); }

  TriangleSurface read(const std::string& content, const std::string& ending,
                       TriangleNormals normals = TriangleNormals::file) {
    path_ = (std::filesystem::temp_directory_path() /
             (std::string("gabion_") +
              testing::UnitTest::GetInstance()->current_test_info()->name() + ending))
                .string();
    std::ofstream(path_, std::ios::binary) << content;
    return read_triangles(path_, normals);
  }
  void expect_refused(const std::string& content, const std::string& ending,
                      const std::vector<std::string_view>& parts) {
    expect_error<ConfigError>([&] { read(content, ending); }, parts);
  }

  std::string path_;
};

TEST_F(TriangleFiles, every_format_gives_the_same_surface) {
  const auto triangles = square();
  for (const auto& [content, ending] :
       {std::pair<std::string, std::string>{stl_text(triangles), ".stl"},
        {stl_bytes(triangles), ".stl"},
        {ply_text(), ".ply"},
        {ply_bytes(), ".PLY"}}) {
    const auto surface = read(content, ending);
    ASSERT_EQ(surface.vertices.size(), 4U) << ending;
    ASSERT_EQ(surface.triangles.size(), 2U);
    for (std::size_t t = 0; t < 2; ++t) {
      for (int k = 0; k < 3; ++k) {
        EXPECT_EQ(surface.vertices[surface.triangles[t][k]], triangles[t][k]);
      }
    }
    std::filesystem::remove(path_);
  }
}

TEST_F(TriangleFiles, near_vertices_are_one_and_others_are_not) {
  for (const auto& [shift, vertices] : {std::pair{1e-6, 4U}, {5e-6, 6U}}) {  // 2e-6: a millionth
    auto triangles = square();
    for (Vector<3>& x : triangles[1]) x[1] += shift;
    EXPECT_EQ(read(stl_text(triangles), ".stl").vertices.size(), vertices) << shift;
  }
}

TEST_F(TriangleFiles, sides_are_checked_and_turned_where_asked_for) {
  auto triangles = square();
  std::swap(triangles[1][0], triangles[1][1]);
  expect_refused(stl_text(triangles), ".stl", {"triangles 0 and 1", "different sides"});
  const auto surface = read(stl_text(triangles), ".stl", TriangleNormals::up);
  for (const auto& t : surface.triangles) {
    const auto& x = surface.vertices;
    EXPECT_GT((x[t[1]] - x[t[0]]).cross(x[t[2]] - x[t[0]])[2], 0);
  }
  const std::vector<Triangle> wall = {{{{0, 0, 0}, {1, 0, 0}, {1, 0, 1}}}};
  EXPECT_EQ(read(stl_text(wall), ".stl").triangles.size(), 1U);
  expect_error<ConfigError>([&] { read(stl_text(wall), ".stl", TriangleNormals::up); },
                            {"triangle 0", "vertical", "up"});
}

TEST_F(TriangleFiles, broken_files_are_refused_with_the_place) {
  const auto triangles = square();
  const std::string text = stl_text(triangles), bytes = stl_bytes(triangles);
  expect_refused(text.substr(0, text.size() - 29), ".stl", {"line 14", "found the end"});
  expect_refused("solid x\nfacet normal 0 0 1\nouter loop\nvertex 0 O 0\n", ".stl",
                 {"line 4", "\"O\"", "a coordinate"});
  expect_refused("solid x\nfacet normal 0 0 1\nouter loop\nvertex 0 nan 0\n", ".stl",
                 {"line 4", "not finite"});
  expect_refused("solid x\nendsolid x\n", ".stl", {"found no triangle"});
  std::string cut = bytes.substr(0, bytes.size() - 1);
  cut[0] = 'S';
  expect_refused(cut, ".stl", {"found 183 bytes, expected 184 of the 2 triangles"});
  expect_refused("nothing", ".stl", {"found 7 bytes", "STL"});
  expect_refused(text, ".obj", {".stl or .ply"});
  expect_refused(stl_text({{{{0, 0, 0}, {1, 0, 0}, {2, 0, 0}}}}), ".stl",
                 {"triangle 0", "without area"});
  expect_refused("ply\nformat ascii 1.0\nelement vertex x\n", ".ply", {"line 4", "a count"});
  expect_refused("ply\nformat binary_big_endian 1.0\nend_header\n", ".ply", {"binary_big_endian"});
  std::string quads = ply_text();
  quads.replace(quads.find("3 0 1 2"), 7, "4 0 1 2 3");
  expect_refused(quads, ".ply", {"a face of 4 vertices", "triangles"});
  std::string beyond = ply_text();
  beyond.replace(beyond.find("3 0 1 2"), 7, "3 0 1 4");
  expect_refused(beyond, ".ply", {"found the vertex 4, allowed: 0 to 3"});
  const auto with_header = [](const std::string& lines) {
    return "ply\nformat ascii 1.0\n" + lines + "end_header\n0 0 0\n1 0 0\n0 1 0\n3 0 1 2\n";
  };
  const std::string xyz =
      "element vertex 3\nproperty double x\nproperty double y\nproperty double z\n";
  const std::string corners = "property list uint uint vertex_indices\n";
  EXPECT_EQ(read(with_header(xyz + "element face 1\n" + corners), ".ply").triangles.size(), 1U);
  std::filesystem::remove(path_);
  expect_refused(with_header("element face 9000000000000000000\n"), ".ply", {"without a property"});
  expect_refused(with_header(xyz + "element face 9000000000000000000\n" + corners), ".ply",
                 {"more than the rest of the file"});
  expect_refused(with_header(xyz + "element face 1\nproperty list uint float vertex_indices\n"),
                 ".ply", {"\"vertex_indices\" of the type \"float\"", "whole numbers"});
  expect_refused(with_header(xyz + "element face 1\nproperty list float uint vertex_indices\n"),
                 ".ply", {"whole numbers for counts"});
  std::string long_list = with_header(xyz + "element face 1\nproperty list uint uint tags\n");
  long_list.replace(long_list.find("3 0 1 2"), 7, "4294967295");
  expect_refused(long_list, ".ply", {"a list \"tags\" of 4294967295 numbers"});
  auto far = triangles;
  far[0][0][0] = 1e308;
  far[1][0][0] = -1e308;
  expect_refused(stl_text(far), ".stl", {"digits do not resolve"});
  const std::string binary = ply_bytes();
  expect_refused(binary.substr(0, binary.size() - 2), ".ply", {"byte ", "found the end"});
  expect_error<ConfigError>([] { read_triangles("none.stl", TriangleNormals::file); },
                            {"none.stl: cannot open"});
}

}  // namespace
}  // namespace gabion::test::test_triangle_surface
