// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>

#include "tests/unit/mesh/mesh_checks.hpp"

namespace gabion::test_read_mesh {
namespace {

/// A scene folder with one fem.json whose "mesh" is the given text.
class ReadMesh : public testing::Test {
 protected:
  void SetUp() override {
    folder_ = std::filesystem::temp_directory_path() /
              (std::string("gabion_read_mesh_") +
               testing::UnitTest::GetInstance()->current_test_info()->name());
    std::filesystem::create_directories(folder_);
    std::filesystem::copy_file(std::filesystem::path(MESH_DATA) / "plate.msh",
                               folder_ / "plate.msh",
                               std::filesystem::copy_options::overwrite_existing);
  }
  void TearDown() override { std::filesystem::remove_all(folder_); }

  template <int dim = 2>
  Mesh<dim> read(const std::string& mesh) {
    std::ofstream(folder_ / "fem.json") << "{\"mesh\": " << mesh << "}";
    const Scene scene(folder_.string(), {});
    auto in = scene.reader("fem.json", {"fem", "", {key::object("mesh", mesh_keys(), "")}});
    return read_mesh<dim>(scene, in.object("mesh"));
  }
  void expect_refused(const std::string& mesh, const std::vector<std::string_view>& parts) {
    test::expect_error<ConfigError>([&] { read(mesh); }, parts);
  }

  std::filesystem::path folder_;
};

TEST_F(ReadMesh, from_a_file_of_the_scene) {
  const auto mesh = read(R"({"file": "plate.msh"})");
  const auto direct = read_gmsh<2>(MESH_DATA "/plate.msh");
  EXPECT_EQ(mesh.cell_type, CellType::tri3);
  EXPECT_EQ(mesh.nodes, direct.nodes);
  EXPECT_EQ(mesh.cells, direct.cells);
  EXPECT_EQ(mesh.facet_groups, direct.facet_groups);
}

TEST_F(ReadMesh, from_a_box) {
  const auto mesh = read<3>(
      R"({"box": {"low": [0, 0, 0], "high": [1, 2, 3], "cells": [2, 2, 2], "type": "tet4", "alternate": true}})");
  EXPECT_EQ(mesh.num_cells(), 40);
  EXPECT_NEAR(test::total_volume(mesh), 6.0, 1e-14);
}

TEST_F(ReadMesh, exactly_one_source) {
  expect_refused("{}", {"/mesh/file: found neither, allowed: exactly one of \"file\" and \"box\""});
  expect_refused(R"({"file": "plate.msh", "box": {}})", {"found both \"file\" and \"box\""});
}

TEST_F(ReadMesh, errors_name_the_key) {
  expect_refused(R"({"box": {"low": [0, 0], "high": [1, 0], "cells": [1, 1], "type": "tri3"}})",
                 {"/mesh/box/high: component 1: found 0, allowed: a number > low = 0"});
  expect_refused(R"({"box": {"low": [0, 0], "high": [1, 1], "cells": [1, 0], "type": "tri3"}})",
                 {"/mesh/box/cells", "found 0", "1"});
  expect_refused(R"({"box": {"low": [0, 0], "high": [1, 1], "cells": [1, 1], "type": "hex8"}})",
                 {"/mesh/box/type: found \"hex8\"", "tri3"});
  expect_refused(R"({"box": {"low": [0], "high": [1, 1], "cells": [1, 1], "type": "tri3"}})",
                 {"/mesh/box/low", "2 numbers"});
  expect_refused(
      R"({"box": {"low": [0, 0], "high": [1, 1], "cells": [1, 1], "type": "quad4", "alternate": true}})",
      {"/mesh/box/alternate: found true, allowed: only with type tri3"});
  expect_refused(
      R"({"box": {"low": [0, 0], "high": [1, 1], "cells": [1, 1], "type": "tri3", "x": 1}})",
      {"/mesh/box/x", "unknown"});
  expect_refused(
      R"({"box": {"low": [0, 0], "high": [1, 1], "cells": [100000, 100000], "type": "tri3"}})",
      {"/mesh/box/cells: box mesh: found more cells"});
  expect_refused(R"({"file": "none.msh"})",
                 {"/mesh/file: ", "none.msh: cannot open this mesh file"});
}

}  // namespace
}  // namespace gabion::test_read_mesh
