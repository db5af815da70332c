// SPDX-License-Identifier: BSD-3-Clause
#include "coupler/mapping/mapping.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cassert>
#include <cmath>
#include <map>

#include "common/base/require.hpp"

namespace gabion {

namespace {

using WeightRows = Eigen::SparseMatrix<double, Eigen::RowMajor>;
// A weight below this is round-off of a vertex that lies on the rim of a facet: no force comes by
// it.
constexpr double round_off_weight = 1e-9;

using VertexValues = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;

std::string point_text(const Eigen::Vector3d& x, int dim) {
  return dim == 2 ? fmt::format("({}, {})", x(0), x(1))
                  : fmt::format("({}, {}, {})", x(0), x(1), x(2));
}

/// Each soil facet must have the same orientation as the structure's facet under its centroid.
void check_normals(const Surface& structure, const Surface& soil, const InterfaceMesh& mesh) {
  for (std::int64_t f = 0; f < soil.num_facets(); ++f) {
    const Eigen::Vector3d normal = soil.normal(f);
    const SurfacePoint image = structure.nearest_on_facets(soil.centroid(f), normal);
    const Eigen::Vector3d other = structure.normal(image.facet);
    require<ConfigError>(
        normal.dot(other) > 0,
        "interface \"{}\": facet {} of the soil's surface at {} has normal {}, the structure's "
        "facet {} there has {}; allowed: normals that agree and point out of the structure, into "
        "the soil; reverse the order of the soil's polyline (the soil is to its right), or take "
        "its facets from a mesh of the structure",
        mesh.name, f, point_text(soil.centroid(f), mesh.dim), point_text(normal, mesh.dim),
        image.facet, point_text(other, mesh.dim));
  }
}

/// Rows of weights, one for each image.
WeightRows interpolation(const std::vector<SurfacePoint>& images, std::int64_t num_columns) {
  std::vector<Eigen::Triplet<double>> entries;
  for (std::size_t v = 0; v < images.size(); ++v) {
    for (int a = 0; a < images[v].count; ++a) {
      entries.emplace_back(v, images[v].vertices[a], images[v].weights[a]);
    }
  }
  WeightRows H(static_cast<Eigen::Index>(images.size()), num_columns);
  H.setFromTriplets(entries.begin(), entries.end());
  return H;
}

/// Refuse keys that belong to another choice, which `owner` names.
void refuse_keys(const ConfigReader& in, const std::vector<std::string>& keys,
                 const std::string& owner) {
  for (const auto& key : keys) {
    if (in.has(key)) in.fail(key, "allowed only with " + owner);
  }
}

}  // namespace

KeyTable mapping_keys() {
  const MappingSettings defaults;
  const std::vector<std::string> wendland = {"wendland_c2", "wendland_c4", "wendland_c6"};
  std::vector<std::string> all_kernels = wendland;
  all_kernels.push_back("thin_plate");
  return {
      "mapping",
      "Displacements go from the structure's vertices to the soil's, forces come back by the "
      "transpose.",
      {key::choice(
           "method", {"nearest_projection", "nearest_neighbor", "radial_basis"},
           "Value at a soil vertex. `nearest_projection`: that at the closest point of the "
           "structure's facets; `nearest_neighbor`: that at its nearest vertex; `radial_basis`: "
           "that of radial functions through its vertices.")
           .or_else(defaults.method),
       key::number("tolerance", "m",
                   "Largest distance of a soil vertex from its place on the structure.")
           .in(positive()),
       key::choice(
           "positions", {"reference", "deformed"},
           "Positions from which the mapping is set up. `deformed`: again and again as vertices "
           "move; with `nearest_projection` only.")
           .or_else("reference"),
       key::number(
           "moved", "",
           "Displacement of a vertex after which the mapping is set up again, over the largest "
           "extent of the surface along an axis.")
           .in(non_negative())
           .or_else(defaults.moved)
           .when("positions", {"deformed"}),
       key::choice("kernel", all_kernels, "Radial function; `thin_plate`: r^2 ln r.")
           .or_else("wendland_c4")
           .when("method", {"radial_basis"}),
       key::integer("cluster_size", "Number of vertices of one interpolant.")
           .in(between(4, 1000))
           .or_else(defaults.radial_basis.cluster_size)
           .when("method", {"radial_basis"}),
       key::number(
           "support", "m",
           "Radius of the Wendland functions; none: largest extent of the surface along an axis.")
           .in(positive())
           .or_none()
           .when("method", {"radial_basis"})
           .when("kernel", wendland)}};
}

MappingSettings read_mapping_settings(ConfigReader in) {
  static const std::map<std::string, Kernel> kernels = {{"wendland_c2", Kernel::wendland_c2},
                                                        {"wendland_c4", Kernel::wendland_c4},
                                                        {"wendland_c6", Kernel::wendland_c6},
                                                        {"thin_plate", Kernel::thin_plate}};
  MappingSettings settings;
  settings.method = in.choice("method");
  settings.tolerance = in.number("tolerance");
  settings.deformed = in.choice("positions") == "deformed";
  if (settings.deformed && settings.method != "nearest_projection") {
    in.fail("positions", fmt::format("found \"deformed\" with \"{}\", allowed: reference, or "
                                     "nearest_projection, which keeps the vertices at the surface",
                                     settings.method));
  }
  if (settings.deformed) {
    settings.moved = in.number("moved");
  } else {
    refuse_keys(in, {"moved"}, R"("method": "nearest_projection" and "positions": "deformed")");
  }
  if (settings.method == "radial_basis") {
    RadialBasisSettings& rbf = settings.radial_basis;
    rbf.kernel = kernels.at(in.choice("kernel"));
    rbf.cluster_size = in.integer("cluster_size");
    if (rbf.kernel == Kernel::thin_plate) {
      refuse_keys(in, {"support"}, "the kernels wendland_c2, wendland_c4, wendland_c6");
    } else {
      rbf.support = in.optional_number("support");
    }
  } else {
    refuse_keys(in, {"kernel", "cluster_size", "support"}, R"("method": "radial_basis")");
  }
  in.finish();
  return settings;
}

Mapping::Mapping(const InterfaceMesh& structure, const InterfaceMesh& soil,
                 const MappingSettings& settings)
    : dim_(structure.dim) {
  require<ConfigError>(structure.dim == soil.dim,
                       "interface \"{}\": the structure's surface has dimension {}, the soil's {}; "
                       "allowed: equal",
                       structure.name, structure.dim, soil.dim);
  const Surface from(structure);
  const Surface to(soil);
  identity_ = structure.coordinates == soil.coordinates;
  require<ConfigError>(
      identity_ || from.has_facets() || settings.method != "nearest_projection",
      "interface \"{}\": the structure's surface has no facets, which nearest_projection needs; "
      "allowed: nearest_neighbor, radial_basis",
      from.name());
  const std::vector<SurfacePoint> images = find_images(from, to, settings);
  if (from.has_facets() && to.has_facets()) check_normals(from, to, soil);
  if (identity_) {
    H_.resize(from.num_vertices(), from.num_vertices());
    H_.setIdentity();
  } else if (settings.method == "radial_basis") {
    H_ = radial_basis_weights(from, to, settings.radial_basis);
  } else {
    H_ = interpolation(images, from.num_vertices());
  }
  measure(from, to);
}

/// The place on the structure that each soil vertex belongs to.
std::vector<SurfacePoint> Mapping::find_images(const Surface& from, const Surface& to,
                                               const MappingSettings& settings) {
  // Vertices that are the same are where they are, on a facet or not.
  const bool on_facets = from.has_facets() && settings.method != "nearest_neighbor" && !identity_;
  std::vector<SurfacePoint> images;
  for (std::int64_t v = 0; v < to.num_vertices(); ++v) {
    const Eigen::Vector3d x = to.vertex(v);
    images.push_back(on_facets ? from.nearest_on_facets(x) : from.nearest_vertex(x));
    const double distance = images.back().distance;
    report_.farthest = std::max(report_.farthest, distance);
    if (distance <= settings.tolerance) continue;
    throw ConfigError(
        fmt::format("interface \"{}\": soil vertex {} at {} is {} m away from the structure's {}, "
                    "allowed: {} m (coupling/mapping/tolerance)",
                    to.name(), v, point_text(x, dim_), distance,
                    on_facets ? "surface" : "nearest vertex", settings.tolerance));
  }
  return images;
}

void Mapping::measure(const Surface& from, const Surface& to) {
  report_.soil_vertices = to.num_vertices();
  report_.structure_vertices = from.num_vertices();
  std::vector<bool> used(static_cast<std::size_t>(from.num_vertices()), false);
  for (Eigen::Index v = 0; v < H_.rows(); ++v) {
    Eigen::Vector3d image = Eigen::Vector3d::Zero();
    for (WeightRows::InnerIterator entry(H_, v); entry; ++entry) {
      image += entry.value() * from.vertex(entry.col());
      report_.largest_weight = std::max(report_.largest_weight, std::abs(entry.value()));
      if (std::abs(entry.value()) > round_off_weight) {
        used[static_cast<std::size_t>(entry.col())] = true;
      }
    }
    report_.largest_shift = std::max(report_.largest_shift, (image - to.vertex(v)).norm());
  }
  report_.unused_vertices = std::count(used.begin(), used.end(), false);
}

void Mapping::to_soil(std::span<const double> structure, std::span<double> soil) const {
  assert(std::ssize(soil) == H_.rows() * dim_ && std::ssize(structure) == H_.cols() * dim_);
  if (identity_) {
    std::copy(structure.begin(), structure.end(), soil.begin());
    return;
  }
  Eigen::Map<VertexValues>(soil.data(), H_.rows(), dim_) =
      H_ * Eigen::Map<const VertexValues>(structure.data(), H_.cols(), dim_);
}

void Mapping::add_to_structure(std::span<const double> soil, std::span<double> structure) const {
  assert(std::ssize(soil) == H_.rows() * dim_ && std::ssize(structure) == H_.cols() * dim_);
  Eigen::Map<VertexValues> sum(structure.data(), H_.cols(), dim_);
  const Eigen::Map<const VertexValues> values(soil.data(), H_.rows(), dim_);
  if (identity_) {
    sum += values;
  } else {
    sum += H_.transpose() * values;
  }
}

}  // namespace gabion
