// SPDX-License-Identifier: BSD-3-Clause
#include "mpm_solver/contact/thin_walls.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <map>
#include <span>
#include <utility>

#include "common/mechanics/ranks/sum.hpp"
#include "mpm_solver/contact/facet_hash.hpp"

namespace gabion::mpm {

namespace {

// Soil within this many cells of a face stands on its side.
constexpr double beside_cells = 4;

// Faces of a wall look away from each other to within 25 degrees, along the way through it.
constexpr double opposite_cosine = 0.9;

// A point is before a simplex up to 60 degrees off its normal.
constexpr double before_cosine = 0.5;

/// All simplices of several surfaces.
template <int dim>
struct Faces {
  std::vector<Vector<dim>> vertices;
  std::vector<Simplex<dim>> simplices;
  std::vector<std::size_t> surface;  // of each simplex
  std::vector<SimplexBounds<dim>> bounds;

  Vector<dim> closest(std::int32_t s, const Vector<dim>& x) const {
    return closest_place<dim>(corners_of<dim>(simplices[s], vertices), x).x;
  }
};

template <int dim>
Faces<dim> faces_of(const std::vector<StartSurface<dim>>& surfaces) {
  Faces<dim> faces;
  for (std::size_t k = 0; k < surfaces.size(); ++k) {
    if (surfaces[k].settings.mode == ContactMode::fixed) continue;
    const auto first = static_cast<std::int32_t>(faces.vertices.size());
    for (Simplex<dim> simplex : simplices(surfaces[k].settings.surface)) {
      for (std::int32_t& vertex : simplex) vertex += first;
      faces.simplices.push_back(simplex);
      faces.surface.push_back(k);
    }
    const auto& vertices = surfaces[k].vertices;
    faces.vertices.insert(faces.vertices.end(), vertices.begin(), vertices.end());
  }
  faces.bounds = bounds_of<dim>(faces.simplices, faces.vertices);
  return faces;
}

/// Two simplices with a structure between them.
struct Pair {
  std::int32_t front, back;
  double thickness;  // [m]
};

// Pairs thinner than a cell, seen from the centre of the front.
template <int dim>
std::vector<Pair> thin_pairs(const Faces<dim>& faces, double cell_size) {
  const FacetHash<dim> hash(faces.simplices, faces.vertices, cell_size);
  std::vector<Pair> pairs;
  for (std::int32_t s = 0; s < std::ssize(faces.simplices); ++s) {
    const SimplexBounds<dim>& front = faces.bounds[s];
    for (const std::int32_t t : hash.near(front.centre)) {
      const SimplexBounds<dim>& back = faces.bounds[t];
      if (front.normal.dot(back.normal) > -opposite_cosine) continue;
      if (back.is_beyond(front.centre, cell_size)) continue;
      const Vector<dim> through = front.centre - faces.closest(t, front.centre);
      const double thickness = through.norm();
      const bool behind = through.dot(front.normal) >= opposite_cosine * thickness;
      if (behind && thickness < (1 - 1e-6) * cell_size) pairs.push_back({s, t, thickness});
    }
  }
  return pairs;
}

/// Marks the simplices that have soil before them.
template <int dim>
class SoilBefore {
 public:
  SoilBefore(const Faces<dim>& faces, std::vector<std::int32_t> which, double cell_size)
      : faces_(faces),
        which_(std::move(which)),
        cell_size_(cell_size),
        reach_(beside_cells * cell_size),
        hash_(chosen(faces, which_), faces.vertices, reach_),
        marks_(faces.simplices.size(), 0.0) {}

  /// The nearest simplex that the point is before, and those within half a cell more: a point
  /// stands for soil around it.
  void add(const Vector<dim>& x) {
    double nearest = reach_;
    std::vector<std::pair<std::int32_t, double>> seen;
    for (const std::int32_t k : hash_.near(x)) {
      const std::int32_t s = which_[k];
      if (faces_.bounds[s].is_beyond(x, nearest + cell_size_ / 2)) continue;
      const Vector<dim> way = x - faces_.closest(s, x);
      const double distance = way.norm();
      if (distance > reach_ || way.dot(faces_.bounds[s].normal) < before_cosine * distance)
        continue;
      nearest = std::min(nearest, distance);
      seen.emplace_back(s, distance);
    }
    for (const auto& [s, distance] : seen) {
      if (distance <= nearest + cell_size_ / 2) marks_[s] = 1;
    }
  }

  /// Not zero: there is soil of some rank. @note Collective.
  std::vector<double> marks(MPI_Comm comm) const {
    std::vector<double> all = marks_;
    sum_over_ranks(comm, std::span<double>(all));
    return all;
  }

 private:
  static std::vector<Simplex<dim>> chosen(const Faces<dim>& faces,
                                          const std::vector<std::int32_t>& which) {
    std::vector<Simplex<dim>> simplices;
    for (const std::int32_t s : which) simplices.push_back(faces.simplices[s]);
    return simplices;
  }

  const Faces<dim>& faces_;
  std::vector<std::int32_t> which_;
  double cell_size_, reach_;
  FacetHash<dim> hash_;
  std::vector<double> marks_;
};

std::vector<std::int32_t> members(const std::vector<Pair>& pairs) {
  std::vector<std::int32_t> all;
  for (const Pair& pair : pairs) all.insert(all.end(), {pair.front, pair.back});
  std::sort(all.begin(), all.end());
  all.erase(std::unique(all.begin(), all.end()), all.end());
  return all;
}

template <int dim>
std::string text_of(const ContactSettings<dim>& a, const ContactSettings<dim>& b, double thickness,
                    double cell_size) {
  const std::string names = a.name == b.name
                                ? fmt::format("\"{}\"", a.name)
                                : fmt::format("the wall between \"{}\" and \"{}\"", a.name, b.name);
  return fmt::format(
      "{}: found soil on both sides of {}, which is {:.3g} m thick there, {:.3g} cells of {:.3g} "
      "m: soil in cells that both sides share acts on itself through the structure, whose forces "
      "are wrong; advised: cells smaller than the thickness",
      a.where, names, thickness, thickness / cell_size, cell_size);
}

}  // namespace

template <int dim>
std::vector<std::string> thin_walls(MPI_Comm comm, const std::vector<StartSurface<dim>>& surfaces,
                                    const MaterialPoints<dim>& points, double cell_size) {
  const Faces<dim> faces = faces_of(surfaces);
  const std::vector<Pair> pairs = thin_pairs(faces, cell_size);
  if (pairs.empty()) return {};
  SoilBefore<dim> soil(faces, members(pairs), cell_size);
  for (const Vector<dim>& x : points.x) soil.add(x);
  const std::vector<double> marks = soil.marks(comm);
  std::map<std::pair<std::size_t, std::size_t>, double> thinnest;
  for (const Pair& pair : pairs) {
    if (marks[pair.front] == 0 || marks[pair.back] == 0) continue;
    const auto ends = std::minmax(faces.surface[pair.front], faces.surface[pair.back]);
    const auto entry = thinnest.try_emplace(ends, pair.thickness).first;
    entry->second = std::min(entry->second, pair.thickness);
  }
  std::vector<std::string> texts;
  for (const auto& [ends, thickness] : thinnest) {
    texts.push_back(text_of<dim>(surfaces[ends.first].settings, surfaces[ends.second].settings,
                                 thickness, cell_size));
  }
  return texts;
}

template std::vector<std::string> thin_walls<2>(MPI_Comm, const std::vector<StartSurface<2>>&,
                                                const MaterialPoints<2>&, double);
template std::vector<std::string> thin_walls<3>(MPI_Comm, const std::vector<StartSurface<3>>&,
                                                const MaterialPoints<3>&, double);

}  // namespace gabion::mpm
