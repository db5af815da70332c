// SPDX-License-Identifier: BSD-3-Clause
#include <cmath>
#include <filesystem>
#include <fstream>
#include <limits>
#include <numeric>
#include <random>
#include <sstream>

#include "common/mechanics/output/xdmf_series.hpp"
#include "tests/unit/output/output_folder.hpp"

namespace gabion::test_xdmf_series {
namespace {

using test::expect_error;
using test::read_dataset;

class XdmfSeriesTest : public test::OutputFolder {
 protected:
  std::string text(const std::string& file) const {
    std::ostringstream out;
    out << std::ifstream(path(file)).rdbuf();
    return out.str();
  }
};

int count(const std::string& text, const std::string& part) {
  int n = 0;
  for (std::size_t at = text.find(part); at != std::string::npos; at = text.find(part, at + 1)) ++n;
  return n;
}

/// Every opened element is closed in order.
bool is_well_formed(const std::string& xml) {
  std::vector<std::string> open;
  for (std::size_t at = xml.find('<'); at != std::string::npos; at = xml.find('<', at + 1)) {
    const std::size_t end = xml.find('>', at);
    if (end == std::string::npos) return false;
    const std::string tag = xml.substr(at + 1, end - at - 1);
    if (tag[0] == '?' || tag.back() == '/') continue;
    if (tag[0] == '/') {
      if (open.empty() || open.back() != tag.substr(1)) return false;
      open.pop_back();
    } else {
      open.push_back(tag.substr(0, tag.find(' ')));
    }
  }
  return open.empty();
}

TEST_F(XdmfSeriesTest, three_frames_are_three_files_and_one_index) {
  XdmfSeries series(path("results"), "soil");
  for (int frame = 0; frame < 3; ++frame) {
    const std::vector<double> x(2 * (4 + frame), 0.1 + frame);
    const std::vector<double> pressure(4 + frame, 2.0 * frame);
    series.write({.time = 0.1 * frame, .coordinates = x, .fields = {{"pressure", 1, pressure}}});
    EXPECT_EQ(series.num_frames(), frame + 1);
    const std::string index = text("results/soil.xdmf");
    EXPECT_TRUE(is_well_formed(index));
    EXPECT_EQ(count(index, "<Time "), frame + 1);
  }
  folder_ = folder_ / "results";
  EXPECT_EQ(files(), (std::vector<std::string>{"soil.xdmf", "soil_000000.h5", "soil_000001.h5",
                                               "soil_000002.h5"}));
  folder_ = folder_.parent_path();
  const std::string index = text("results/soil.xdmf");
  EXPECT_EQ(count(index, "<Time Value=\"0.2\"/>"), 1);
  EXPECT_EQ(count(index, ">soil_000002.h5:/point/pressure</DataItem>"), 1);
  EXPECT_EQ(count(index, "TopologyType=\"Polyvertex\""), 3);
  EXPECT_EQ(count(index, "HyperSlab"), 0);

  std::vector<hsize_t> sizes;
  const auto x = read_dataset(path("results/soil_000001.h5"), "coordinates", &sizes);
  EXPECT_EQ(sizes, (std::vector<hsize_t>{5, 3}));
  EXPECT_EQ(x[0], 1.1);  // 64 bits
  EXPECT_EQ(x[2], 0.0);
  EXPECT_EQ(read_dataset(path("results/soil_000001.h5"), "connectivity"),
            (std::vector<double>{0, 1, 2, 3, 4}));
  EXPECT_EQ(read_dataset(path("results/soil_000001.h5"), "point/pressure"),
            std::vector<double>(5, 2.0));
}

TEST_F(XdmfSeriesTest, tensors_are_reordered_and_vectors_padded) {
  const std::vector<double> x = {1, 2}, plane = {11, 22, 33, 12}, space = {11, 22, 33, 12, 23, 13};
  const std::vector<double> vector = {7, 8, 9};
  XdmfSeries series(folder_.string(), "a");
  series.write(
      {.coordinates = x,
       .fields = {{"plane", 4, plane}, {"space", 6, space}, {"v2", 2, x}, {"v3", 3, vector}}});
  EXPECT_EQ(read_dataset(path("a_000000.h5"), "point/plane"),
            (std::vector<double>{11, 12, 0, 22, 0, 33}));
  EXPECT_EQ(read_dataset(path("a_000000.h5"), "point/space"),
            (std::vector<double>{11, 12, 13, 22, 23, 33}));
  EXPECT_EQ(read_dataset(path("a_000000.h5"), "point/v2"), (std::vector<double>{1, 2, 0}));
  EXPECT_EQ(read_dataset(path("a_000000.h5"), "point/v3"), vector);
  EXPECT_EQ(count(text("a.xdmf"), "AttributeType=\"Tensor6\""), 2);
  EXPECT_EQ(count(text("a.xdmf"), "AttributeType=\"Vector\""), 2);
}

TEST_F(XdmfSeriesTest, a_mesh_has_its_cells_and_cell_values) {
  const std::vector<double> x = {0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0, 1}, value = {3.0};
  const std::vector<std::int32_t> cells = {0, 1, 2, 3};
  XdmfSeries series(folder_.string(), "mesh");
  series.write({.time = 1e-3,
                .dim = 3,
                .coordinates = x,
                .cell_type = CellType::tet4,
                .connectivity = cells,
                .fields = {{"damage", 1, value, true}}});
  const std::string index = text("mesh.xdmf");
  EXPECT_EQ(count(index, "TopologyType=\"Tetrahedron\" NumberOfElements=\"1\""), 1);
  EXPECT_EQ(count(index, "Center=\"Cell\""), 1);
  EXPECT_EQ(read_dataset(path("mesh_000000.h5"), "connectivity"),
            (std::vector<double>{0, 1, 2, 3}));
  EXPECT_EQ(read_dataset(path("mesh_000000.h5"), "cell/damage"), value);
}

/// VTK's middle nodes of a hexahedron: bottom edges, top edges, upright ones, then the faces.
TEST_F(XdmfSeriesTest, middle_nodes_are_written_in_the_order_of_vtk) {
  const std::vector<double> x(81, 0.0);
  std::vector<std::int32_t> cell(27);
  std::iota(cell.begin(), cell.end(), 0);
  XdmfSeries series(path("."), "mesh");
  series.write({.dim = 3, .coordinates = x, .cell_type = CellType::hex27, .connectivity = cell});
  EXPECT_EQ(read_dataset(path("mesh_000000.h5"), "connectivity"),
            (std::vector<double>{0,  1,  2,  3,  4,  5,  6,  7,  8,  11, 13, 9,  16, 18,
                                 19, 17, 10, 12, 14, 15, 22, 23, 21, 24, 20, 25, 26}));
  EXPECT_EQ(count(text("mesh.xdmf"), "TopologyType=\"Hexahedron_27\""), 1);
  cell.resize(10);
  series.write({.time = 1,
                .dim = 3,
                .coordinates = std::span(x).first(30),
                .cell_type = CellType::tet10,
                .connectivity = cell});
  EXPECT_EQ(read_dataset(path("mesh_000001.h5"), "connectivity"),
            (std::vector<double>{0, 1, 2, 3, 4, 5, 6, 7, 9, 8}));
  EXPECT_EQ(count(text("mesh.xdmf"), "TopologyType=\"Tetrahedron_10\""), 1);
}

TEST_F(XdmfSeriesTest, size_of_a_frame_is_foretold) {
  constexpr std::int64_t n = 3000;
  std::mt19937 random(1);  // next to nothing to compress
  std::uniform_real_distribution<double> number(-1, 1);
  std::vector<double> x(2 * n), scalar(n), stress(4 * (n / 3));
  for (std::vector<double>* values : {&x, &scalar, &stress}) {
    for (double& value : *values) value = number(random);
  }
  std::vector<std::int32_t> cells(n);
  for (std::int32_t i = 0; i < n; ++i) cells[i] = i;
  XdmfSeries series(folder_.string(), "mesh");
  series.write({.coordinates = x,
                .cell_type = CellType::tri3,
                .connectivity = cells,
                .fields = {{"u", 2, x}, {"p", 1, scalar}, {"stress", 4, stress, true}}});
  const std::int64_t foretold = XdmfSeries::frame_bytes(
      n, CellType::tri3, n / 3, {{"u", 2, {}}, {"p", 1, {}}, {"stress", 4, {}, true}});
  EXPECT_EQ(foretold, n * (3 * 8 + 3 * 4 + 4) + n / 3 * (3 * 4 + 6 * 4));
  const auto found = static_cast<std::int64_t>(std::filesystem::file_size(path("mesh_000000.h5")));
  // The zeros of the third components, the node numbers and some exponents are compressed.
  EXPECT_GE(found, foretold / 2);
  EXPECT_LE(found, foretold + 16384);
}

TEST_F(XdmfSeriesTest, bad_fields_are_refused_and_leave_no_frame) {
  const std::vector<double> x = {0, 0, 1, 1}, one = {1.0}, two = {1.0, 2.0}, huge = {1e39, 0};
  XdmfSeries series(folder_.string(), "a");
  const auto refuses = [&](const OutputField& field, const std::string& text) {
    expect_error<Error>([&] { series.write({.coordinates = x, .fields = {field}}); }, {text});
  };
  refuses({"p", 1, one}, "output field p: found 1 values, expected 2 x 1");
  refuses({"p", 5, one}, "output field p: found 5 components, allowed: 1, 2, 3, 4, 6");
  refuses({"a/b", 1, two},
          "output field: found the name \"a/b\", allowed: letters, digits, _ and -");
  refuses({"p", 1, huge}, "output field p: found 1e+39, allowed: what a 32-bit number can hold");
  expect_error<Error>([&] { series.write({.time = NAN, .coordinates = x}); },
                      {"output a: found time nan"});
  expect_error<Error>([&] { series.write({.dim = 0, .coordinates = x}); },
                      {"output a: found 4 coordinates of dimension 0"});
  EXPECT_TRUE(files().empty());
  EXPECT_EQ(series.num_frames(), 0);
}

TEST_F(XdmfSeriesTest, a_folder_that_cannot_be_or_is_gone_is_an_error) {
  std::ofstream(path("file")) << "x";
  const std::vector<double> x = {0, 0};
  const auto first_frame = [&] { XdmfSeries(path("file/results"), "a").write({.coordinates = x}); };
  expect_error<Error>(first_frame, {path("file/results") + ": cannot create this folder"});
  XdmfSeries series(path("results"), "a");
  series.write({.coordinates = x});
  std::filesystem::remove_all(path("results"));
  expect_error<Error>([&] { series.write({.time = 1, .coordinates = x}); },
                      {"cannot create this file"});
  EXPECT_EQ(series.num_frames(), 1);
}

}  // namespace
}  // namespace gabion::test_xdmf_series
