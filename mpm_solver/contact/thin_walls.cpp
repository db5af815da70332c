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

// A point is in front of a simplex up to 60 degrees off its normal.
constexpr double before_cosine = 0.5;

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
      const Vector<dim> path = x - faces_.closest(s, x);
      const double distance = path.norm();
      if (distance > reach_ || path.dot(faces_.bounds[s].normal) < before_cosine * distance)
        continue;
      nearest = std::min(nearest, distance);
      seen.emplace_back(s, distance);
    }
    for (const auto& [s, distance] : seen) {
      if (distance <= nearest + cell_size_ / 2) marks_[s] = 1;
    }
  }

  /// 1 for the simplices of `which` with soil of this rank before them, else 0.
  std::vector<double> marks() const {
    std::vector<double> chosen;
    for (const std::int32_t s : which_) chosen.push_back(marks_[s]);
    return chosen;
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

std::int32_t place_in(const std::vector<std::int32_t>& sorted, std::int32_t value) {
  return static_cast<std::int32_t>(std::ranges::lower_bound(sorted, value) - sorted.begin());
}

template <int dim>
std::string text_of(const ContactSettings<dim>& a, const ContactSettings<dim>& b,
                    const std::string& when, double thickness, double cell_size) {
  const std::string names = a.name == b.name
                                ? fmt::format("\"{}\"", a.name)
                                : fmt::format("the wall between \"{}\" and \"{}\"", a.name, b.name);
  return fmt::format(
      "{}: found soil on both sides of {}{}, which is {:.3g} m thick there, {:.3g} cells of {:.3g} "
      "m: soil in cells that both sides share acts on itself through the structure, and the forces "
      "on it are wrong; advised: cells of at most half the thickness, or nodes for each side, "
      "which need the method \"facets\" on both faces and a grid that is a box",
      a.where, names, when, thickness, thickness / cell_size, cell_size);
}

}  // namespace

template <int dim>
ThinWalls<dim>::ThinWalls(const std::vector<StartSurface<dim>>& surfaces,
                          std::vector<FacePair> pairs, double cell_size)
    : cell_size_(cell_size), pairs_(std::move(pairs)), which_(members(pairs_)) {
  for (const auto& surface : surfaces) settings_.push_back(&surface.settings);
  if (pairs_.empty()) return;
  const Faces<dim> faces(surfaces);
  for (const std::int32_t s : which_) {
    const std::size_t surface = faces.surface[s];
    std::vector<std::int32_t>& places = places_[surface];
    places.resize(faces.num_simplices[surface], -1);
    places[s - faces.first_simplex[surface]] = static_cast<std::int32_t>(surface_.size());
    surface_.push_back(surface);
  }
  for (FacePair& pair : pairs_) {
    pair.front = place_in(which_, pair.front);
    pair.back = place_in(which_, pair.back);
  }
  marks_.assign(surface_.size(), 0);
}

template <int dim>
std::vector<std::string> ThinWalls<dim>::at_start(MPI_Comm comm,
                                                  const std::vector<StartSurface<dim>>& surfaces,
                                                  const MaterialPoints<dim>& points,
                                                  const BodyGroups& groups) {
  if (pairs_.empty()) return {};
  const Faces<dim> faces(surfaces);
  SoilBefore<dim> soil(faces, which_, cell_size_);
  for (const Vector<dim>& x : points.x) soil.add(x);
  marks_ = soil.marks();
  std::vector<double> marks = marks_, by_group = marks_by_group(faces, points, groups);
  sum_over_ranks(comm, std::span<double>(marks));
  sum_over_ranks(comm, std::span<double>(by_group));
  return found(marks, by_group, "");
}

template <int dim>
std::vector<std::string> ThinWalls<dim>::after_step(MPI_Comm comm, const Surfaces<dim>& surfaces,
                                                    double time, const MaterialPoints<dim>& points,
                                                    const BodyGroups& groups) {
  if (pairs_.empty()) return {};
  bool any_new = false;
  for (const auto& [surface, places] : places_) {
    const CellType type = settings_[surface]->surface.facet_type;
    const std::int32_t cuts = type == CellType::quad4 ? 2 : 1;
    for (const ContactMark<dim>& mark : surfaces.marks(surface)) {
      for (std::int32_t s = cuts * mark.facet; s < cuts * (mark.facet + 1); ++s) {
        if (places[s] < 0 || marks_[places[s]] != 0) continue;
        marks_[places[s]] = 1;
        any_new = true;
      }
    }
  }
  if (!groups.any() && max_over_ranks(comm, any_new ? 1 : 0) == 0) return {};
  std::vector<double> marks = marks_, by_group;
  sum_over_ranks(comm, std::span<double>(marks));
  const auto on_both_sides = [&](const FacePair& pair) {
    return marks[pair.front] != 0 && marks[pair.back] != 0;
  };
  if (std::ranges::none_of(pairs_, on_both_sides)) return {};
  if (groups.any()) by_group = marks_by_group(faces_now(surfaces), points, groups);
  sum_over_ranks(comm, std::span<double>(by_group));
  return found(marks, by_group, fmt::format(" at {:.6g} s", time));
}

template <int dim>
Faces<dim> ThinWalls<dim>::faces_now(const Surfaces<dim>& surfaces) const {
  std::vector<StartSurface<dim>> now;
  for (std::size_t k = 0; k < settings_.size(); ++k) {
    now.push_back({*settings_[k], settings_[k]->surface.vertices});
    const auto x = surfaces.accepted_vertices(k);
    if (!x.empty()) now.back().vertices.assign(x.begin(), x.end());
  }
  return Faces<dim>(now);
}

// 1 for the simplices of which_ with soil of this rank and of a group before them, one group after
// the other; empty without groups.
template <int dim>
std::vector<double> ThinWalls<dim>::marks_by_group(const Faces<dim>& faces,
                                                   const MaterialPoints<dim>& points,
                                                   const BodyGroups& groups) const {
  std::vector<double> all;
  for (std::size_t g = 0; g < groups.names.size(); ++g) {
    SoilBefore<dim> soil(faces, which_, cell_size_);
    for (std::int32_t b = 0; b < points.num_bodies(); ++b) {
      if (groups.of_body[b] != static_cast<std::int32_t>(g)) continue;
      for (std::int32_t p = points.body_starts[b]; p < points.body_starts[b + 1]; ++p) {
        soil.add(points.x[p]);
      }
    }
    const std::vector<double> marks = soil.marks();
    all.insert(all.end(), marks.begin(), marks.end());
  }
  return all;
}

// Texts of walls with marks of any rank, and of one group, on both sides, which are not told again.
template <int dim>
std::vector<std::string> ThinWalls<dim>::found(std::span<const double> marks,
                                               std::span<const double> by_group,
                                               const std::string& when) {
  const auto share_nodes = [&](const FacePair& pair) {
    bool shared = by_group.empty();
    for (std::size_t first = 0; first < by_group.size(); first += marks.size()) {
      shared = shared || (by_group[first + pair.front] != 0 && by_group[first + pair.back] != 0);
    }
    return shared && marks[pair.front] != 0 && marks[pair.back] != 0;
  };
  std::map<std::pair<std::size_t, std::size_t>, double> thinnest;
  for (const FacePair& pair : pairs_) {
    if (!share_nodes(pair)) continue;
    const auto ends = std::minmax(surface_[pair.front], surface_[pair.back]);
    const auto entry = thinnest.try_emplace(ends, pair.thickness).first;
    entry->second = std::min(entry->second, pair.thickness);
  }
  std::vector<std::string> texts;
  for (const auto& [ends, thickness] : thinnest) {
    texts.push_back(
        text_of<dim>(*settings_[ends.first], *settings_[ends.second], when, thickness, cell_size_));
  }
  std::erase_if(pairs_, [&](const FacePair& pair) {
    return thinnest.contains(std::minmax(surface_[pair.front], surface_[pair.back]));
  });
  return texts;
}

template class ThinWalls<2>;
template class ThinWalls<3>;

}  // namespace gabion::mpm
