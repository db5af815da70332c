// SPDX-License-Identifier: BSD-3-Clause
#include "mpm_solver/boulders/boulder_config.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <span>

#include "common/base/log.hpp"
#include "common/base/require.hpp"
#include "common/mechanics/mesh/triangle_surface.hpp"
#include "mpm_solver/boulders/boulder_law_config.hpp"
#include "mpm_solver/boulders/boulders.hpp"
#include "mpm_solver/boulders/random_boulder_config.hpp"
#include "mpm_solver/config_checks.hpp"

namespace gabion::mpm {

namespace {

// Least radius of a boulder in cells, since points of the soil do not see what is smaller; and the
// share of rounding allowed in it.
constexpr double least_radius = 1.5, thickness_rounding = 1e-9;
// Shapes in contact at the start overlap by rounding; this share of the radius is allowed.
constexpr double allowed_overlap = 1e-6;

KeyTable shape_keys() {
  return {
      "shape",
      "Shape of the body about its centre of mass.",
      {key::number("radius", "m", "A sphere, in 2D a disc.").in(positive()).or_none(),
       key::vector("box", "m", "Lengths of the sides of a box, in 2D a rectangle.")
           .in(positive())
           .or_none(),
       key::vector("ellipsoid", "m",
                   "Semi-axes of an ellipsoid, in 2D an ellipse. It meets hard bodies as such, and "
                   "soil as a polyhedron of 1280 facets, in 2D a polygon of 32.")
           .in(positive())
           .or_none(),
       key::rows("polygon", "m", "Corners [x, y], counterclockwise.")
           .wide(2, 2)
           .not_empty(3)
           .or_none()
           .only("in 2D"),
       key::text("triangles",
                 "File of a closed surface, .stl or .ply, with normals out of the body; "
                 "relative to the scene.")
           .or_none()
           .only("in 3D")},
      {"radius", "box", "ellipsoid", "polygon", "triangles"}};
}

template <int dim>
ContactSurface<dim> surface_of(const Scene& scene, ConfigReader& in) {
  ContactSurface<dim> surface;
  if constexpr (dim == 2) {
    const auto corners = in.rows("polygon", 2);
    const auto count = static_cast<std::int32_t>(corners.size());
    for (std::int32_t k = 0; k < count; ++k) {
      surface.vertices.push_back({corners[k][0], corners[k][1]});
      surface.facets.insert(surface.facets.end(), {k, (k + 1) % count});
    }
  } else {
    surface.facet_type = CellType::tri3;
    const TriangleSurface read =
        read_triangles(scene.path(in.text("triangles")), TriangleNormals::file);
    surface.vertices = read.vertices;
    for (const auto& triangle : read.triangles) {
      surface.facets.insert(surface.facets.end(), triangle.begin(), triangle.end());
    }
  }
  return surface;
}

template <int dim>
Vector<dim> positive_lengths(ConfigReader& in, const std::string& key) {
  const auto values = in.vector(key, dim);
  return Eigen::Map<const Vector<dim>>(values.data());
}

template <int dim>
BoulderShape<dim> read_shape(const Scene& scene, ConfigReader in, double density) {
  BoulderShape<dim> shape;
  const bool sphere = in.has("radius"), box = in.has("box"), ellipsoid = in.has("ellipsoid");
  const bool polygon = in.has("polygon"), triangles = in.has("triangles");
  if (dim == 2 && triangles) in.fail("triangles", "allowed in 2D: \"polygon\"");
  if (dim == 3 && polygon) in.fail("polygon", "allowed in 3D: \"triangles\"");
  const char* const keys[] = {"radius", "box", "ellipsoid", "polygon", "triangles"};
  const bool given[] = {sphere, box, ellipsoid, polygon, triangles};
  if (std::count(std::begin(given), std::end(given), true) != 1) {
    in.fail(box ? "box" : "radius",
            fmt::format("allowed: exactly one of {}", fmt::join(keys, ", ")));
  }
  if (sphere) {
    shape = sphere_shape<dim>(in.number("radius"), density);
  } else if (box) {
    shape = box_shape<dim>(positive_lengths<dim>(in, "box"), density);
  } else if (ellipsoid) {
    shape = ellipsoid_shape<dim>(positive_lengths<dim>(in, "ellipsoid"), density);
  } else {
    try {
      shape = surface_shape<dim>(surface_of<dim>(scene, in), density);
    } catch (const ConfigError& error) {
      in.fail(dim == 2 ? "polygon" : "triangles", error.what());
    }
  }
  in.finish();
  return shape;
}

template <int dim>
Eigen::Quaterniond read_orientation(ConfigReader& in) {
  if (!in.has("orientation")) return Eigen::Quaterniond::Identity();
  if constexpr (dim == 2) {
    const double angle = in.vector("orientation", 1)[0];
    return Eigen::Quaterniond(Eigen::AngleAxisd(angle, Vector<3>::UnitZ()));
  } else {
    const auto q = in.vector("orientation", 4);
    const Eigen::Quaterniond result(q[0], q[1], q[2], q[3]);
    if (!(result.norm() > 0)) in.fail("orientation", "found length 0, allowed: a quaternion");
    return result.normalized();
  }
}

template <int dim>
BodyState read_start(ConfigReader& in) {
  BodyState start;
  const auto x = in.vector("centre", dim), v = in.vector("velocity", dim);
  std::copy(x.begin(), x.end(), start.x.begin());
  std::copy(v.begin(), v.end(), start.v.begin());
  start.q = read_orientation<dim>(in);
  const auto spin = in.vector("spin", dim == 2 ? 1 : 3);
  const Vector<3> in_space =
      dim == 2 ? Vector<3>(0, 0, spin[0]) : Vector<3>(spin[0], spin[1], spin[2]);
  start.W = start.q.conjugate() * in_space;
  return start;
}

template <int dim>
BoulderSettings<dim> read_boulder(const Scene& scene, ConfigReader& in) {
  BoulderSettings<dim> boulder;
  boulder.name = in.name("name");
  boulder.where = in.where("shape");
  boulder.density = in.number("density");
  boulder.shape = read_shape<dim>(scene, in.object("shape"), boulder.density);
  boulder.start = read_start<dim>(in);
  read_boulder_law(in, boulder);
  boulder.law.stiffness = in.number_or("stiffness", usual_stiffness(boulder.shape));
  return boulder;
}

template <int dim>
RigidWallSettings<dim> wall_of(const BoulderSettings<dim>& boulder) {
  RigidWallSettings<dim> wall;
  wall.name = boulder.name;
  wall.is_boulder = true;
  wall.boundary.name = boulder.name;
  wall.boundary.where = boulder.where;
  wall.boundary.friction = boulder.soil_friction;
  wall.boundary.method = FacetSettings{};
  wall.boundary.surface = boulder.shape.surface;
  for (Vector<dim>& X : wall.boundary.surface.vertices) {
    Vector<3> in_body = Vector<3>::Zero();
    in_body.template head<dim>() = X;
    X = boulder.start.at(in_body).template head<dim>();
  }
  wall.moment_about = Vector<dim>::Zero();
  return wall;
}

template <int dim>
void check_boulder(const ConfigReader& in, const std::string& size_key,
                   const BoulderSettings<dim>& boulder, const BoulderScene<dim>& settings) {
  const double cell = mean_cell_size(settings.grid);
  if (0.5 * boulder.shape.thickness < (1 - thickness_rounding) * least_radius * cell) {
    in.fail(size_key, fmt::format("found a thickness of {:.4g} m, allowed in cells of {:.4g} m: at "
                                  "least {:.4g} m, soil does not feel smaller ones",
                                  boulder.shape.thickness, cell, 2 * least_radius * cell));
  }
  for (const auto& wall : settings.rigid_walls) {
    if (wall.name == boulder.name)
      in.fail("name",
              fmt::format("found \"{}\" a second time, allowed: a name of its own", boulder.name));
  }
  for (const auto& interface : settings.interfaces) {
    if (interface.name == boulder.name)
      in.fail("name",
              fmt::format("found \"{}\", which an interface has, allowed: a name of its own",
                          boulder.name));
  }
  for (std::size_t k = 0; k < settings.phases.size(); ++k) {
    const Phase& phase = settings.phases[k];
    if (phase.dynamic || boulder.free_from >= phase.until) continue;
    in.fail("free_from", fmt::format("found {} s with phase {}, quasi-static, until {} s, allowed: "
                                     "from its end on, a free body has no state without inertia",
                                     boulder.free_from, k, phase.until));
  }
}

template <int dim>
void check_overlaps(const ConfigReader& in, std::size_t num_given,
                    const BoulderScene<dim>& settings) {
  const Boulders<dim> boulders(settings);
  const auto overlap = boulders.overlap_at_start();
  const auto& boulder = settings.boulders[overlap.body];
  if (overlap.depth <= allowed_overlap * boulder.shape.radius) return;
  const std::string text = fmt::format(
      "found \"{}\" inside \"{}\", by {:.4g} m at ({:.6g}, {:.6g}, {:.6g}), allowed: "
      "no overlap",
      boulder.name, boulders.name_of_partner(overlap.other), overlap.depth, overlap.place[0],
      overlap.place[1], overlap.place[2]);
  const bool given = static_cast<std::size_t>(overlap.body) < num_given;
  require<ConfigError>(given, "{}: {}", boulder.where, text);
  in.fail(fmt::format("boulders/{}/centre", overlap.body), text);
}

// More boulders than this are told of together.
constexpr std::size_t most_names = 10;

// Names of boulders, of many the first ones.
std::string names_text(const std::vector<std::string>& names) {
  const std::size_t count = std::min(names.size(), most_names);
  const auto first = std::span(names).first(count);
  if (names.size() <= most_names) return fmt::format("{}", fmt::join(first, ", "));
  return fmt::format("{} and {} others", fmt::join(first, ", "), names.size() - count);
}

// Sizes are diameters of spheres of equal volume.
template <int dim>
void log_many(const std::string& where, const std::vector<BoulderSettings<dim>>& boulders) {
  if (boulders.size() <= most_names) return;
  constexpr double unit = std::numbers::pi / (dim == 2 ? 4 : 6);  // volume of size 1
  constexpr double infinity = std::numeric_limits<double>::infinity();
  double mass = 0, least = infinity, most = 0, lightest = infinity, heaviest = 0;
  for (const auto& boulder : boulders) {
    const double own = boulder.shape.mass.mass;
    const double size = std::pow(own / boulder.density / unit, 1.0 / dim);
    mass += own;
    least = std::min(least, size);
    most = std::max(most, size);
    lightest = std::min(lightest, own);
    heaviest = std::max(heaviest, own);
  }
  const char* const weight = dim == 2 ? "kg/m" : "kg";
  log::info("{}: {} boulders of {:.4g} to {:.4g} m, {:.4g} to {:.4g} {}, together {:.6g} {}", where,
            boulders.size(), least, most, lightest, heaviest, weight, mass, weight);
}

// Contact points are vertices: two edges that cross have none.
template <int dim>
void warn_of_edges(const ConfigReader& in, const BoulderScene<dim>& settings) {
  if (dim == 2) return;
  std::vector<std::string> names;
  for (const auto& boulder : settings.boulders) {
    const bool is_round = boulder.shape.sphere > 0 || boulder.shape.axes[0] > 0;
    if (!is_round) names.push_back(boulder.name);
  }
  if (names.empty()) return;
  log::warn(
      "{}: {} meet hard bodies at vertices alone, their own and those of the other surface. Edges "
      "that cross between vertices are not found: use facets smaller than the boulder, on both "
      "bodies, so that they do not pass through each other",
      in.where("boulders"), names_text(names));
}

}  // namespace

KeyTable boulder_keys() {
  KeyTable table{
      "boulder",
      "A rigid body on which soil, boulders, interfaces and rigid walls act; walls of the grid do "
      "not.",
      {key::plain_name("Unique name; columns of the tables start with it."),
       key::object("shape", shape_keys(), "Shape of the body."),
       key::vector("centre", "m", "Place of the centre of mass at the start."),
       key::vector("orientation", "rad",
                   "In 2D [angle]; in 3D, without unit, the quaternion [w, x, y, z] that turns the "
                   "shape; none: it is not turned.")
           .wide(1, 4)
           .or_none(),
       key::vector("spin", "rad/s", "Initial angular velocity, along the axes of space; in 2D [w].")
           .wide(1, 3)
           .or_else(0),
       key::number("stiffness", "N/m^2",
                   "Contact force on a hard body (wall, structure, boulder) "
                   "over the square of the penetration.")
           .in(positive())
           .or_computed(usual_stiffness_words())}};
  const auto others = boulder_law_keys();
  table.keys.insert(table.keys.end(), others.begin(), others.end());
  return table;
}

template <int dim>
void read_boulders(const Scene& scene, ConfigReader& in, const BoulderScene<dim>& among,
                   std::vector<BoulderSettings<dim>>& boulders,
                   std::vector<RigidWallSettings<dim>>& walls) {
  for (auto& item : in.objects("boulders")) {
    boulders.push_back(read_boulder<dim>(scene, item));
    item.finish();
    check_boulder(item, "shape", boulders.back(), among);
    require_own_name(item, boulders);
  }
  const std::size_t num_given = boulders.size();
  for (auto& item : in.objects("random_boulders")) {
    for (const auto& boulder : read_random_boulders<dim>(item, among)) {
      boulders.push_back(boulder);
      check_boulder(item, "sizes", boulders.back(), among);
      require_own_name(item, boulders);
    }
  }
  if (boulders.empty()) return;
  check_overlaps(in, num_given, among);
  warn_of_edges(in, among);
  log_many(in.where("boulders"), boulders);
  std::vector<RigidWallSettings<dim>> own;
  for (const auto& boulder : boulders) own.push_back(wall_of(boulder));
  walls.insert(walls.end(), own.begin(), own.end());
}

template void read_boulders<2>(const Scene&, ConfigReader&, const BoulderScene<2>&,
                               std::vector<BoulderSettings<2>>&,
                               std::vector<RigidWallSettings<2>>&);
template void read_boulders<3>(const Scene&, ConfigReader&, const BoulderScene<3>&,
                               std::vector<BoulderSettings<3>>&,
                               std::vector<RigidWallSettings<3>>&);

}  // namespace gabion::mpm
