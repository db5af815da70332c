// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <sstream>

#include "tests/unit/mesh/mesh_checks.hpp"

namespace gabion::test_gmsh_errors {
namespace {

using test::error_of;

/// A unit square of two triangles; parts can be replaced by broken ones.
struct SmallFile {
  std::string format = "4.1 0 8";
  std::string entities = "0 1 1 0\n1 0 0 0 1 1 0 1 5 0\n1 0 0 0 1 1 0 1 6 0\n";
  std::string nodes = "1 5 10 50\n2 1 0 5\n10\n20\n30\n50\n40\n0 0 0\n1 0 0\n1 1 0\n7 7 7\n0 1 0\n";
  std::string elements = "2 3 1 3\n1 1 1 1\n1 20 10\n2 1 2 2\n2 10 20 30\n3 10 40 30\n";

  std::string text() const {
    return "$MeshFormat\n" + format + "\n$EndMeshFormat\n" +
           "$PhysicalNames\n2\n1 5 \"ground level\"\n2 6 \"body\"\n$EndPhysicalNames\n" +
           "$Entities\n" + entities + "$EndEntities\n$Nodes\n" + nodes + "$EndNodes\n$Elements\n" +
           elements + "$EndElements\n";
  }
};

class GmshErrors : public testing::Test {
 protected:
  void SetUp() override {
    path_ = (std::filesystem::temp_directory_path() /
             (std::string("gabion_") +
              testing::UnitTest::GetInstance()->current_test_info()->name() + ".msh"))
                .string();
  }
  void TearDown() override { std::filesystem::remove(path_); }

  template <int dim = 2>
  Mesh<dim> read(const std::string& text) {
    std::ofstream(path_, std::ios::binary) << text;
    return read_gmsh<dim>(path_);
  }
  /// The message behind the file's name.
  template <int dim = 2>
  std::string message(const std::string& text) {
    const std::string whole = error_of<ConfigError>([&] { read<dim>(text); });
    const std::string head = path_ + ": ";
    return whole.starts_with(head) ? whole.substr(head.size()) : "no file name in: " + whole;
  }

  std::string path_;
};

TEST_F(GmshErrors, the_small_file_is_good_and_loses_its_unused_node) {
  const auto mesh = read(SmallFile().text());
  EXPECT_EQ(mesh.num_nodes_total(), 4);
  EXPECT_EQ(mesh.nodes[3], Vector<2>(0, 1));
  // The second triangle ran clockwise, and the facet ran against its cell.
  EXPECT_EQ(mesh.cells, (std::vector<std::int32_t>{0, 1, 2, 0, 2, 3}));
  EXPECT_EQ(mesh.facets("ground level", ""), (std::vector<std::int32_t>{0, 1}));
  EXPECT_EQ(mesh.cell_groups.at("body"), (std::vector<std::int32_t>{0, 1}));
}

TEST_F(GmshErrors, other_formats) {
  SmallFile file;
  file.format = "2.2 0 8";
  EXPECT_EQ(message(file.text()),
            "line 2, section $MeshFormat: found format 2.2, allowed: 4.1; convert with "
            "`gmsh old.msh -save -format msh41 -o new.msh`");
  file.format = "4.1 0 4";
  EXPECT_EQ(message(file.text()), "line 2, section $MeshFormat: found data size 4, allowed: 8");
  file.format = "4.1 2 8";
  EXPECT_EQ(message(file.text()), "line 2, section $MeshFormat: found file type 2, allowed: 0, 1");
  EXPECT_EQ(message("solid cube\n"), "line 1: expected $MeshFormat: this is no Gmsh mesh file");
  EXPECT_EQ(message(""), "line 1: found an empty file, expected a Gmsh mesh of format 4.1");
  EXPECT_EQ(message(std::string("$MeshFormat\n4.1 1 8\n\0\0\0\1\n$EndMeshFormat\n", 40)),
            "byte 24, section $MeshFormat: found a binary file of the other byte order, "
            "allowed: little-endian");
}

TEST_F(GmshErrors, missing_file_and_sections) {
  EXPECT_EQ(error_of<ConfigError>([] { read_gmsh<2>("/nowhere/a.msh"); }),
            "/nowhere/a.msh: cannot open this mesh file: No such file or directory");
  EXPECT_EQ(message("$MeshFormat\n4.1 0 8\n$EndMeshFormat\n"),
            "line 4: found the end of the file, expected a section $Nodes");
  EXPECT_EQ(message("$MeshFormat\n4.1 0 8\n$EndMeshFormat\n$Nodes\n0 0 0 0\n$EndNodes\n"),
            "line 7: found the end of the file, expected a section $Elements");
  EXPECT_EQ(message("$MeshFormat\n4.1 0 8\n$EndMeshFormat\n$Comments\nhello"),
            "line 4, section $Comments: found the end of the file, expected the section's end");
  EXPECT_EQ(message("$MeshFormat\n4.1 0 8\n$EndMeshFormat\n$PartitionedEntities\n"),
            "line 4, section $PartitionedEntities: found a mesh cut into parts, allowed: a mesh "
            "in one piece");
}

TEST_F(GmshErrors, unread_sections_are_passed_over) {
  const std::string text = SmallFile().text();
  const auto mesh = read(text + "$NodeData\n1\n\"x\"\n$EndNodeData\n");
  EXPECT_EQ(mesh.num_cells(), 2);
}

TEST_F(GmshErrors, broken_numbers_and_counts) {
  SmallFile file;
  file.nodes = "1 5 10 50\n2 1 0 5\n10\n20\n30\n50\n40\n0 0 0\n1 zero 0\n";
  EXPECT_EQ(message(file.text()), "line 23, section $Nodes: found \"zero\", expected a coordinate");
  file.nodes = "1 5 10 50\n2 1 0 99999999999\n";
  EXPECT_EQ(message(file.text())
                .find("line 16, section $Nodes: found 99999999999 nodes, more "
                      "than the rest of the file can hold"),
            0u);
  file.nodes = "1 2 1 2\n2 1 0 1\n10\n0 0 0\n";
  EXPECT_EQ(message(file.text()),
            "line 18, section $Nodes: found 1 nodes, the section's head says 2");
  file.nodes = "1 1 1 2\n2 1 0 1\n10\n0 inf 0\n";
  EXPECT_EQ(message(file.text()),
            "line 18, section $Nodes: found a coordinate that is no finite number");
  file = {};
  file.elements = "1 3 1 1\n2 1 2 1\n1 10 20 30\n";
  EXPECT_EQ(message(file.text()),
            "line 31, section $Elements: found 1 elements, the section's head says 3");
  file.elements = "1 1 1 1\n2 1 2 1\n1 10 20 30 40\n";
  EXPECT_EQ(message(file.text()),
            "line 31, section $Elements: found \"40\", expected $EndElements");
}

TEST_F(GmshErrors, elements_that_cannot_be_read) {
  SmallFile file;
  file.elements = "1 1 1 1\n2 1 21 1\n1 10 20 30 10 20 30 10 20 30 10\n";
  EXPECT_EQ(message(file.text()),
            "line 30, section $Elements: found Gmsh's element type 21, allowed: 15 (point), "
            "1 (line), 2 (triangle), 3 (quad), 4 (tetrahedron), 5 (hexahedron), and of order 2: "
            "8 (line3), 9 (tri6), 16 (quad8), 10 (quad9), 11 (tet10), 17 (hex20), 12 (hex27)");
  file.elements = "1 1 1 1\n2 1 9 1\n1 10 20 30 10 20 30\n";
  EXPECT_EQ(message(file.text()),
            "section $Elements: found cells of type tri6, which are of order 2, allowed: tri3, "
            "quad4, of order 1, here");
  file.elements = "2 2 1 2\n2 1 2 1\n1 10 20 30\n2 1 3 1\n2 10 20 30 40\n";
  EXPECT_EQ(message(file.text()),
            "section $Elements: found cells of types tri3 and quad4, allowed: one type a mesh");
  file.elements = "1 1 1 1\n2 1 2 1\n1 10 20 99\n";
  EXPECT_EQ(message(file.text()), "section $Elements: found node 99, which $Nodes does not have");
  file.elements = "1 1 1 1\n1 1 1 1\n1 10 20\n";
  EXPECT_EQ(
      message(file.text()),
      "section $Elements: found no cells of dimension 2 (the highest dimension is 1; its groups: "
      "ground level); a Gmsh file holds only elements of physical groups once there is one");
}

TEST_F(GmshErrors, dimension_mismatch) {
  EXPECT_EQ(
      message<3>(SmallFile().text()),
      "section $Elements: found no cells of dimension 3 (the highest dimension is 2; its groups: "
      "body, ground level); a Gmsh file holds only elements of physical groups once there is one");
  const std::string path = std::string(MESH_DATA) + "/bricks.msh";
  EXPECT_EQ(error_of<ConfigError>([&] { read_gmsh<2>(path); }),
            path +
                ": section $Elements: found elements of dimension 3, allowed: a mesh of "
                "dimension 2");
  SmallFile file;
  file.nodes = "1 4 10 40\n2 1 0 4\n10\n20\n30\n40\n0 0 0\n1 0 0\n1 1 0.5\n0 1 0\n";
  EXPECT_EQ(message(file.text()),
            "section $Nodes: found z from 0 to 0.5, allowed: one z for all nodes of a mesh of "
            "dimension 2");
}

TEST_F(GmshErrors, bad_geometry_and_topology) {
  SmallFile file;
  file.elements = "1 1 1 1\n2 1 2 1\n1 10 20 20\n";
  EXPECT_EQ(message(file.text()),
            "section $Elements: found a degenerate, folded or non-convex tri3 near (0, 0), "
            "element 1, allowed: cells of positive Jacobian");
  file.elements = "1 1 1 1\n2 1 3 1\n1 10 30 20 40\n";
  EXPECT_EQ(message(file.text()),
            "section $Elements: found a degenerate, folded or non-convex quad4 near (0, 0), "
            "element 1, allowed: cells of positive Jacobian");
  file = {};
  file.elements = "2 2 1 2\n1 1 1 1\n1 20 40\n2 1 2 1\n2 10 20 30\n";
  EXPECT_EQ(message(file.text()),
            "section $Elements: found a facet of group \"ground level\" (nodes 20, 40) that "
            "belongs to no cell");
  file.nodes = "1 4 10 40\n2 1 0 4\n10\n20\n20\n40\n0 0 0\n1 0 0\n1 1 0\n0 1 0\n";
  EXPECT_EQ(message(file.text()), "section $Nodes: found node 20 twice");
}

TEST_F(GmshErrors, every_truncation_is_an_error_and_none_crashes) {
  for (const std::string name : {"plate.msh", "plate_binary.msh", "tetrahedra_binary.msh"}) {
    std::ostringstream whole;
    whole << std::ifstream(std::string(MESH_DATA) + "/" + name, std::ios::binary).rdbuf();
    const std::string text = whole.str();
    ASSERT_GT(text.size(), 1000u);
    const std::string end = "$EndElements";
    for (std::size_t size = 0; size < text.rfind(end) + end.size(); size += 149) {
      std::ofstream(path_, std::ios::binary) << text.substr(0, size);
      SCOPED_TRACE(name + " " + std::to_string(size));
      test::expect_error<ConfigError>(
          [&] { name[0] == 'p' ? (void)read_gmsh<2>(path_) : (void)read_gmsh<3>(path_); },
          {path_ + ": ", "found "});
    }
  }
}

}  // namespace
}  // namespace gabion::test_gmsh_errors
