// SPDX-License-Identifier: BSD-3-Clause
#include "mpm_solver/contact/surface_config.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>

#include "common/mechanics/mesh/cell_groups.hpp"
#include "common/mechanics/mesh/surface_mesh.hpp"
#include "common/mechanics/mesh/triangle_surface.hpp"

namespace gabion::mpm {

namespace {

// Facets of a mesh, with only the vertices that they use.
template <int dim>
ContactSurface<dim> surface_of_mesh(const Mesh<dim>& mesh, const std::vector<std::string>& groups,
                                    const std::string& where) {
  ContactSurface<dim> surface;
  surface.facet_type = facet_type(mesh.cell_type);
  std::map<std::int32_t, std::int32_t> vertex_of_node;
  for (const auto& group : groups) {
    for (const std::int32_t node : mesh.facets(group, where)) {
      const auto [entry, is_new] =
          vertex_of_node.try_emplace(node, static_cast<std::int32_t>(surface.vertices.size()));
      if (is_new) surface.vertices.push_back(mesh.nodes[node]);
      surface.facets.push_back(entry->second);
    }
  }
  return surface;
}

// The surface with all nodes of groups of cells, in the order of the mesh as the structure has it.
template <int dim>
ContactSurface<dim> surface_before_cells(const Mesh<dim>& mesh,
                                         const std::vector<std::string>& groups,
                                         const std::vector<std::string>& cells,
                                         const ConfigReader& in) {
  std::vector<std::int32_t> nodes =
      nodes_of_cells(mesh, cells_of_groups(mesh, cells, in.where("behind")));
  std::vector<std::int32_t> of_facets;
  for (const auto& group : groups) {
    const auto& own = mesh.facets(group, in.where("groups"));
    of_facets.insert(of_facets.end(), own.begin(), own.end());
  }
  nodes.insert(nodes.end(), of_facets.begin(), of_facets.end());
  std::ranges::sort(nodes);
  nodes.erase(std::unique(nodes.begin(), nodes.end()), nodes.end());
  ContactSurface<dim> surface;
  surface.facet_type = facet_type(mesh.cell_type);
  for (const std::int32_t node : nodes) surface.vertices.push_back(mesh.nodes[node]);
  for (const std::int32_t node : of_facets) {
    const auto vertex = std::ranges::lower_bound(nodes, node);
    surface.facets.push_back(static_cast<std::int32_t>(vertex - nodes.begin()));
  }
  return surface;
}

// Number of pieces of an edge, as a double, since too small a spacing would overflow an int. The
// length of the edge has the round-off of its ends, which grows with their distance from the
// origin.
double pieces_of_edge(const Vector<2>& from, const Vector<2>& to, double spacing) {
  const double farthest = std::max(from.lpNorm<Eigen::Infinity>(), to.lpNorm<Eigen::Infinity>());
  const double round_off = 4 * std::numeric_limits<double>::epsilon() * farthest;
  return std::max(1.0, std::ceil(((to - from).norm() - round_off) / spacing - 1e-9));
}

// Refuse a corner that equals the one before, and more pieces in all than anyone can mean.
void check_polyline(const ConfigReader& in, const std::vector<std::vector<double>>& corners,
                    double spacing) {
  double pieces = 0;
  for (std::size_t k = 1; k < corners.size(); ++k) {
    const Vector<2> from(corners[k - 1][0], corners[k - 1][1]);
    const Vector<2> to(corners[k][0], corners[k][1]);
    if (!((to - from).norm() > 0)) {
      in.fail(fmt::format("polyline/{}", k),
              fmt::format("found ({}, {}), the point before it, allowed: points that differ",
                          corners[k][0], corners[k][1]));
    }
    pieces += pieces_of_edge(from, to, spacing);
  }
  if (pieces <= max_surface_points) return;
  in.fail("spacing", fmt::format("found {}, which makes {:.0f} segments, allowed: at most {}",
                                 spacing, pieces, max_surface_points));
}

// Segments of at most `spacing` along a line through the given corners.
ContactSurface<2> surface_of_polyline(const std::vector<std::vector<double>>& corners,
                                      double spacing) {
  ContactSurface<2> surface;
  surface.facet_type = CellType::line2;
  surface.vertices.push_back({corners[0][0], corners[0][1]});
  for (std::size_t k = 1; k < corners.size(); ++k) {
    const Vector<2> from(corners[k - 1][0], corners[k - 1][1]);
    const Vector<2> to(corners[k][0], corners[k][1]);
    const int pieces = static_cast<int>(pieces_of_edge(from, to, spacing));
    for (int i = 1; i <= pieces; ++i) {
      const auto last = static_cast<std::int32_t>(surface.vertices.size()) - 1;
      surface.vertices.push_back(from + (to - from) * (static_cast<double>(i) / pieces));
      surface.facets.insert(surface.facets.end(), {last, last + 1});
    }
  }
  return surface;
}

ContactSurface<3> surface_of_triangles(const Scene& scene, ConfigReader& in) {
  const std::string file = in.text("triangles");
  const auto normals = in.choice("normals") == "up" ? TriangleNormals::up : TriangleNormals::file;
  ContactSurface<3> surface;
  surface.facet_type = CellType::tri3;
  try {
    TriangleSurface read = read_triangles(scene.path(file), normals);
    surface.vertices = std::move(read.vertices);
    for (const auto& triangle : read.triangles) {
      surface.facets.insert(surface.facets.end(), triangle.begin(), triangle.end());
    }
  } catch (const ConfigError& error) {
    in.fail("triangles", error.what());
  }
  return surface;
}

}  // namespace

KeyTable surface_keys() {
  return {
      "surface",
      "The soil's copy of a surface. Normals point into the soil; each facet belongs to one "
      "surface only, and once.",
      {key::rows("polyline", "m",
                 "Corners [x, y], with the soil to the right of the line; no two successive ones "
                 "are equal.")
           .wide(2, 2)
           .not_empty(2)
           .or_none()
           .only("in 2D"),
       key::number("spacing", "m",
                   "The polyline is cut into segments of at most this length, at most 1 000 000 in "
                   "all.")
           .in(positive())
           .with("polyline"),
       key::text(
           "triangles",
           "File of a surface of triangles, .stl or .ply, relative to the scene; vertices closer "
           "than 1e-6 of its size become one.")
           .or_none()
           .only("in 3D"),
       key::choice("normals", {"file", "up"},
                   "Side on which the soil lies. `file`: by the order of the vertices; `up`: "
                   "triangles that look down are turned, as terrain needs.")
           .or_else("file")
           .with("triangles"),
       key::object("mesh", mesh_keys(), "Mesh of the structure.")
           .without("polyline")
           .without("triangles"),
       key::texts("groups", "Facet groups of that mesh.").without("polyline").without("triangles"),
       key::texts("behind",
                  "Groups of cells that may fail and leave the structure, as the structure's "
                  "interface names them.")
           .not_empty()
           .or_none()
           .without("polyline")
           .without("triangles")}};
}

template <int dim>
ContactSurface<dim> read_surface(const Scene& scene, ConfigReader in) {
  ContactSurface<dim> surface;
  if (in.has("polyline") && in.has("triangles")) {
    in.fail("triangles", "allowed: only one of \"polyline\", \"triangles\" and \"mesh\"");
  }
  if (in.has("triangles")) {
    if constexpr (dim == 3) {
      surface = surface_of_triangles(scene, in);
    } else {
      in.fail("triangles", "allowed in 3D only; in 2D give \"polyline\"");
    }
  } else if (in.has("polyline")) {
    if constexpr (dim == 2) {
      const auto corners = in.rows("polyline", 2);
      if (corners.size() < 2) in.fail("polyline", "allowed: at least two points");
      const double spacing = in.number("spacing");
      check_polyline(in, corners, spacing);
      surface = surface_of_polyline(corners, spacing);
    } else {
      in.fail("polyline",
              "allowed in 2D only; in 3D give \"triangles\", or \"mesh\" and \"groups\"");
    }
  } else {
    const std::vector<std::string> groups = in.texts("groups");
    const Mesh<dim> mesh = read_surface_mesh<dim>(scene, in.object("mesh"), groups);
    surface = in.has("behind") ? surface_before_cells(mesh, groups, in.texts("behind"), in)
                               : surface_of_mesh(mesh, groups, in.where("groups"));
  }
  in.finish();
  return surface;
}

template <int dim>
void check_point_count(const ConfigReader& in, const ContactSurface<dim>& surface,
                       int points_per_facet) {
  const auto facets =
      static_cast<std::int64_t>(surface.facets.size()) / num_nodes(surface.facet_type);
  const std::int64_t points = facets * points_per_facet;
  if (points <= max_surface_points) return;
  in.fail("points_per_facet",
          fmt::format("found {} on {} facets, which makes {} boundary points, allowed: at most {}",
                      points_per_facet, facets, points, max_surface_points));
}

template <int dim>
void require_new_facets(const ConfigReader& in, const ContactSurface<dim>& surface,
                        SeenFacets<dim>& seen) {
  const std::size_t n = num_nodes(surface.facet_type);
  for (std::size_t f = 0; f < surface.facets.size(); f += n) {
    const std::span facet = std::span(surface.facets).subspan(f, n);
    if (seen.add(surface.vertices, facet)) continue;
    const Vector<dim>& x = surface.vertices[facet.front()];
    in.fail("surface",
            fmt::format("found the facet at ({}) a second time, allowed: each facet in one surface "
                        "and once, else its penalty would act twice",
                        fmt::join(x.data(), x.data() + dim, ", ")));
  }
}

template ContactSurface<2> read_surface<2>(const Scene&, ConfigReader);
template void check_point_count<2>(const ConfigReader&, const ContactSurface<2>&, int);
template void require_new_facets<2>(const ConfigReader&, const ContactSurface<2>&, SeenFacets<2>&);
template ContactSurface<3> read_surface<3>(const Scene&, ConfigReader);
template void check_point_count<3>(const ConfigReader&, const ContactSurface<3>&, int);
template void require_new_facets<3>(const ConfigReader&, const ContactSurface<3>&, SeenFacets<3>&);

}  // namespace gabion::mpm
