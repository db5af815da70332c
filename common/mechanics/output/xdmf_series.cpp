// SPDX-License-Identifier: BSD-3-Clause
#include "common/mechanics/output/xdmf_series.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cerrno>
#include <cmath>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <numeric>
#include <system_error>

#include "common/base/names.hpp"
#include "common/base/require.hpp"
#include "common/mechanics/output/ranked_hdf5_file.hpp"
#include "common/mechanics/ranks/share.hpp"
#include "common/mechanics/ranks/text.hpp"

namespace gabion {

namespace {

/// Opening attributes of XDMF's topology element.
std::string topology(CellType type) {
  switch (type) {
    case CellType::point1:
      return R"(TopologyType="Polyvertex" NodesPerElement="1")";
    case CellType::line2:
      return R"(TopologyType="Polyline" NodesPerElement="2")";
    case CellType::tri3:
      return R"(TopologyType="Triangle")";
    case CellType::quad4:
      return R"(TopologyType="Quadrilateral")";
    case CellType::tet4:
      return R"(TopologyType="Tetrahedron")";
    case CellType::hex8:
      return R"(TopologyType="Hexahedron")";
    case CellType::line3:
      return R"(TopologyType="Edge_3")";
    case CellType::tri6:
      return R"(TopologyType="Triangle_6")";
    case CellType::quad8:
      return R"(TopologyType="Quadrilateral_8")";
    case CellType::quad9:
      return R"(TopologyType="Quadrilateral_9")";
    case CellType::tet10:
      return R"(TopologyType="Tetrahedron_10")";
    case CellType::hex20:
      return R"(TopologyType="Hexahedron_20")";
    case CellType::hex27:
      return R"(TopologyType="Hexahedron_27")";
  }
  return "";
}

/// Places in Gmsh's order of the nodes of a cell in VTK's, which ParaView reads; the two differ in
/// the middle nodes of tet10, hex20 and hex27.
std::vector<int> places_of_vtk(CellType type) {
  std::vector<int> places(num_nodes(type));
  std::iota(places.begin(), places.end(), 0);
  if (type == CellType::tet10) std::swap(places[8], places[9]);
  if (type == CellType::hex20 || type == CellType::hex27) {
    constexpr int middle[] = {8,  11, 13, 9,  16, 18, 19, 17, 10, 12,
                              14, 15, 22, 23, 21, 24, 20, 25, 26};
    std::copy_n(middle, places.size() - 8, places.begin() + 8);
  }
  return places;
}

std::vector<std::int32_t> in_vtk_order(std::span<const std::int32_t> connectivity, CellType type) {
  const std::vector<int> places = places_of_vtk(type);
  std::vector<std::int32_t> result;
  result.reserve(connectivity.size());
  for (std::size_t first = 0; first < connectivity.size(); first += places.size()) {
    for (const int place : places) result.push_back(connectivity[first + place]);
  }
  return result;
}

/// Layout of a stored field: each stored column is one of the field's components, or zero (-1).
struct Layout {
  const char* attribute_type;
  std::vector<int> columns;
};

/// Vectors become XYZ; symmetric tensors (see `Symmetric` in tensor.hpp) become XDMF's order
/// xx, xy, xz, yy, yz, zz.
Layout layout(const OutputField& field) {
  switch (field.components) {
    case 1:
      return {"Scalar", {0}};
    case 2:
      return {"Vector", {0, 1, -1}};
    case 3:
      return {"Vector", {0, 1, 2}};
    case 4:
      return {"Tensor6", {0, 3, -1, 1, -1, 2}};
    case 6:
      return {"Tensor6", {0, 3, 5, 1, 4, 2}};
    default:
      throw Error(fmt::format("output field {}: found {} components, allowed: 1, 2, 3, 4, 6",
                              field.name, field.components));
  }
}

template <class T>
std::vector<T> arrange(std::span<const double> values, int components,
                       const std::vector<int>& columns, const std::string& what) {
  const std::size_t rows = values.size() / components;
  std::vector<T> result;
  result.reserve(rows * columns.size());
  for (std::size_t r = 0; r < rows; ++r) {
    for (int column : columns) {
      const double value = column < 0 ? 0.0 : values[r * components + column];
      result.push_back(static_cast<T>(value));
      // require() would make a text for every value.
      if (std::isfinite(static_cast<double>(result.back())) || !std::isfinite(value)) continue;
      throw Error(fmt::format("output field {}: found {}, allowed: what a 32-bit number can hold",
                              what, value));
    }
  }
  return result;
}

/// Names of XDMF for the numbers of a dataset.
struct NumberFormat {
  const char* type;
  int bytes;
};
constexpr NumberFormat int32_format{.type = "Int", .bytes = 4};
constexpr NumberFormat float32_format{.type = "Float", .bytes = 4};
constexpr NumberFormat float64_format{.type = "Float", .bytes = 8};

/// @param place  file and dataset, "soil_000000.h5:/coordinates"
std::string data_item(const std::string& place, std::int64_t rows, int columns,
                      const NumberFormat& format) {
  const std::string size =
      columns == 1 ? fmt::format("{}", rows) : fmt::format("{} {}", rows, columns);
  return fmt::format(
      R"(<DataItem Dimensions="{}" NumberType="{}" Precision="{}" Format="HDF">{}</DataItem>)",
      size, format.type, format.bytes, place);
}

void check_name(const std::string& what, const std::string& name) {
  require(is_plain_name(name), "{}: found the name \"{}\", allowed: letters, digits, _ and -", what,
          name);
}

std::size_t num_points(const OutputFrame& frame) {
  return frame.coordinates.size() / frame.dim;
}

std::size_t num_cells(const OutputFrame& frame) {
  const bool points_are_cells = frame.cell_type == CellType::point1 && frame.connectivity.empty();
  return points_are_cells ? num_points(frame)
                          : frame.connectivity.size() / num_nodes(frame.cell_type);
}

std::size_t num_rows(const OutputFrame& frame, const OutputField& field) {
  return field.on_cells ? num_cells(frame) : num_points(frame);
}

void check_size(const OutputFrame& frame, const OutputField& field) {
  const std::size_t rows = num_rows(frame, field);
  require(field.values.size() == rows * field.components,
          "output field {}: found {} values, expected {} x {}", field.name, field.values.size(),
          rows, field.components);
}

std::string dataset_of(const OutputField& field) {
  return (field.on_cells ? "cell/" : "point/") + field.name;
}

void write_field(MPI_Comm comm, const OutputFrame& frame, OutputField field, ArrayFile& file) {
  std::vector<double> made;
  if (field.make) {
    made = field.make();
    field.values = made;
  }
  const Layout stored = layout(field);
  std::vector<float> values;
  together(comm, [&] {
    if (field.make) check_size(frame, field);
    values = arrange<float>(field.values, field.components, stored.columns, field.name);
  });
  made = {};
  file.write(dataset_of(field), static_cast<int>(stored.columns.size()), values);
}

}  // namespace

struct XdmfSeries::Rows {
  RowShare points, cells;
  const RowShare& of(const OutputField& field) const { return field.on_cells ? cells : points; }
};

XdmfSeries::XdmfSeries(std::string folder, std::string name, MPI_Comm comm)
    : folder_(std::move(folder)),
      name_(std::move(name)),
      comm_(comm),
      kept_({"coordinates", "connectivity"}) {
  check_name("output series", name_);
}

void XdmfSeries::check(const OutputFrame& frame) const {
  require(std::isfinite(frame.time), "output {}: found time {}", name_, frame.time);
  require((frame.dim == 2 || frame.dim == 3) && frame.coordinates.size() % frame.dim == 0,
          "output {}: found {} coordinates of dimension {}", name_, frame.coordinates.size(),
          frame.dim);
  const int per_cell = num_nodes(frame.cell_type);
  require(frame.connectivity.size() % per_cell == 0,
          "output {}: found {} node numbers for cells of {} nodes", name_,
          frame.connectivity.size(), per_cell);
  for (const OutputField& field : frame.fields) {
    check_name("output field", field.name);
    layout(field);
    if (!field.make) check_size(frame, field);
  }
}

void XdmfSeries::make_folder() const {
  std::error_code error;
  std::filesystem::create_directories(folder_, error);
  require(!error, "{}: cannot create this folder: {}", folder_, error.message());
}

void XdmfSeries::write(OutputFrame frame) {
  together(comm_, [&] { check(frame); });
  const Rows rows{.points = share_of_rows(comm_, std::ssize(frame.coordinates) / frame.dim),
                  .cells = share_of_rows(comm_, static_cast<std::int64_t>(num_cells(frame)))};
  std::vector<std::int32_t> own_cells;
  if (frame.connectivity.empty()) {
    own_cells.resize(num_cells(frame));  // ParaView's newer readers draw nothing without it
    std::iota(own_cells.begin(), own_cells.end(), static_cast<std::int32_t>(rows.cells.first));
    frame.connectivity = own_cells;
  } else if (is_quadratic(frame.cell_type)) {
    own_cells = in_vtk_order(frame.connectivity, frame.cell_type);
    frame.connectivity = own_cells;
  }
  const bool first = rank_of(comm_) == 0;
  together(comm_, [&] {
    if (first && times_.empty()) make_folder();
  });
  const std::string file_name = fmt::format("{}_{:06}.h5", name_, num_frames());
  const std::filesystem::path path = std::filesystem::path(folder_) / file_name;
  const auto file = new_array_file(path.string(), comm_, &kept_);
  // Coordinates stay in 64 bits: gaps and small motions far from the origin are read from them.
  const std::vector<int> xyz = frame.dim == 2 ? std::vector{0, 1, -1} : std::vector{0, 1, 2};
  file->write("coordinates", 3, arrange<double>(frame.coordinates, frame.dim, xyz, "coordinates"));
  file->write("connectivity", num_nodes(frame.cell_type), frame.connectivity);
  for (const OutputField& field : frame.fields) write_field(comm_, frame, field, *file);
  file->finish();
  times_.push_back(frame.time);
  grids_.push_back(grid_text(frame, rows, file_name));
  together(comm_, [&] {
    if (first) write_index();
  });
}

/// XML of one frame.
std::string XdmfSeries::grid_text(const OutputFrame& frame, const Rows& rows,
                                  const std::string& file_name) const {
  std::string text = fmt::format(
      "<Grid Name=\"{}\" GridType=\"Uniform\">\n<Time Value=\"{}\"/>\n"
      "<Topology {} NumberOfElements=\"{}\">{}</Topology>\n"
      "<Geometry GeometryType=\"XYZ\">{}</Geometry>\n",
      name_, frame.time, topology(frame.cell_type), rows.cells.total,
      data_item(file_name + ":/connectivity", rows.cells.total, num_nodes(frame.cell_type),
                int32_format),
      data_item(file_name + ":/coordinates", rows.points.total, 3, float64_format));
  for (const OutputField& field : frame.fields) {
    const Layout stored = layout(field);
    text +=
        fmt::format("<Attribute Name=\"{}\" AttributeType=\"{}\" Center=\"{}\">{}</Attribute>\n",
                    field.name, stored.attribute_type, field.on_cells ? "Cell" : "Node",
                    data_item(file_name + ":/" + dataset_of(field), rows.of(field).total,
                              static_cast<int>(stored.columns.size()), float32_format));
  }
  return text + "</Grid>\n";
}

std::int64_t XdmfSeries::frame_bytes(std::int64_t num_points, CellType type, std::int64_t num_cells,
                                     const std::vector<OutputField>& fields) {
  std::int64_t bytes = num_points * 3 * std::int64_t{sizeof(double)} +
                       num_cells * num_nodes(type) * std::int64_t{sizeof(std::int32_t)};
  for (const OutputField& field : fields) {
    const std::int64_t rows = field.on_cells ? num_cells : num_points;
    bytes += rows * std::ssize(layout(field).columns) * std::int64_t{sizeof(float)};
  }
  return bytes;
}

void XdmfSeries::write_index() const {
  const std::filesystem::path path = std::filesystem::path(folder_) / (name_ + ".xdmf");
  const std::filesystem::path part = path.string() + ".part";
  errno = 0;
  std::ofstream out(part);
  out << "<?xml version=\"1.0\"?>\n<Xdmf Version=\"3.0\">\n<Domain>\n"
      << "<Grid Name=\"" << name_ << "\" GridType=\"Collection\" CollectionType=\"Temporal\">\n";
  for (const auto& grid : grids_) out << grid;
  out << "</Grid>\n</Domain>\n</Xdmf>\n";
  out.close();
  require(out.good(), "{}: cannot write this file: {}", path.string(), std::strerror(errno));
  std::error_code error;
  std::filesystem::rename(part, path, error);
  require(!error, "{}: cannot give the written file its name: {}", path.string(), error.message());
}

}  // namespace gabion
