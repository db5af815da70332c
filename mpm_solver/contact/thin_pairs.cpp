// SPDX-License-Identifier: BSD-3-Clause
#include "mpm_solver/contact/thin_pairs.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <optional>
#include <unordered_map>

#include "mpm_solver/contact/facet_hash.hpp"

namespace gabion::mpm {

namespace {

// Functions of a cell reach over the next one: soil on both sides of a wall that is thinner than
// two cells shares nodes.
constexpr double thin_cells = 2;

// Opposite faces of a wall face away from each other to within 25 degrees, along the line through
// it.
constexpr double opposite_cosine = 0.9;

// Where the other face ends in an inner corner of the wall, the line to it may lean by 70 degrees,
// and be half as long again as the wall is thick.
constexpr double inner_corner_cosine = 0.34, inner_corner_reach = 1.5;
// Faces that bend by less than 45 degrees, as those of rough ground, are no corner.
constexpr double least_bend_cosine = 0.7;
constexpr double same_place = 1e-6;  // share of two cells
constexpr double infinity = std::numeric_limits<double>::infinity();

/// A box around the normals of some faces.
template <int dim>
struct NormalBox {
  Vector<dim> low = Vector<dim>::Constant(1), high = Vector<dim>::Constant(-1);

  void add(const Vector<dim>& normal) {
    const bool known = normal.allFinite();
    low = low.cwiseMin(known ? normal : Vector<dim>::Constant(-1));
    high = high.cwiseMax(known ? normal : Vector<dim>::Constant(1));
  }
  // Whether a normal in the box may look away from this one.
  bool may_oppose(const Vector<dim>& normal) const {
    const double least = low.cwiseProduct(normal).cwiseMin(high.cwiseProduct(normal)).sum();
    return !(least > 1e-9 - opposite_cosine);
  }
  bool may_oppose(const NormalBox& other) const {
    const auto products = [this](const Vector<dim>& normal) {
      return Vector<dim>(low.cwiseProduct(normal).cwiseMin(high.cwiseProduct(normal)));
    };
    return products(other.low).cwiseMin(products(other.high)).sum() <= 1e-9 - opposite_cosine;
  }
};

// Cubes of normals, by numbers.
template <int dim>
class NormalCubes {
  static constexpr int a_length = 4, a_side = 2 * a_length + 1;

 public:
  static constexpr int count = (dim == 2 ? 1 : a_side) * a_side * a_side;

  // 0, where no normal is, if it is not known.
  static int of(const Vector<dim>& normal) {
    int cube = 0;
    for (int d = 0; d < dim && normal.allFinite(); ++d) {
      cube = cube * a_side + a_length +
             static_cast<int>(std::floor(a_length * std::clamp(normal[d], -1.0, 1.0)));
    }
    return cube;
  }
  // Cubes of normals that may look away from this one.
  static const std::vector<std::int32_t>& opposite(const Vector<dim>& normal) {
    static const auto table = make_table();
    return table[of(normal)];
  }

 private:
  static NormalBox<dim> box_of(int cube) {
    Vector<dim> low;
    for (int d = dim - 1; d >= 0; --d, cube /= a_side) low[d] = 1. * (cube % a_side) / a_length - 1;
    NormalBox<dim> box;
    box.add(low);
    box.add(low + Vector<dim>::Constant(1. / a_length));
    return box;
  }
  static std::vector<std::vector<std::int32_t>> make_table() {
    std::vector<std::vector<std::int32_t>> table(count);
    for (int cube = 0; cube < count; ++cube) {
      const NormalBox<dim> box = box_of(cube);
      for (int other = 0; other < count; ++other) {
        if (cube == 0 || other == 0 || box.may_oppose(box_of(other))) table[cube].push_back(other);
      }
    }
    return table;
  }
};

// The simplices of a list by their surfaces, and by where their normals point to: of many, few look
// away from a face and are behind it. Of a heap of bodies most are far.
template <int dim>
class ByNormal {
  using Cubes = NormalCubes<dim>;

 public:
  ByNormal(const Faces<dim>& faces, std::span<const std::int32_t> list) : simplices_(list.size()) {
    for (std::size_t first = 0, end = 0; first < list.size(); first = end) {
      const std::size_t surface = faces.surface[list[first]];
      while (end < list.size() && faces.surface[list[end]] == surface) ++end;
      add_surface(faces, list.subspan(first, end - first), first);
    }
  }
  // Call with each that may look away from a face, be behind its middle and no farther from that
  // than `reach`, in any order.
  template <class Function>
  void for_opposite(const SimplexBounds<dim>& face, double reach, const Function& call) const {
    for (const Surface& surface : surfaces_) {
      if (surface.place.is_apart(face, reach)) continue;
      for (const std::int32_t cube : Cubes::opposite(face.normal)) {
        const std::int32_t g = surface.group_of[cube];
        if (g < 0) continue;
        const Group& group = groups_[g];
        if (!group.normals.may_oppose(face.normal) || group.place.is_apart(face, reach)) continue;
        std::for_each(simplices_.begin() + group.first, simplices_.begin() + group.end, call);
      }
    }
  }

 private:
  // A box around simplices.
  struct Place {
    Vector<dim> low = Vector<dim>::Constant(infinity), high = Vector<dim>::Constant(-infinity);

    void add(const SimplexBounds<dim>& of) {
      low = low.cwiseMin((of.centre.array() - of.radius).matrix());
      high = high.cwiseMax((of.centre.array() + of.radius).matrix());
    }
    // Whether all of it is farther from the middle of a face, or before the face.
    bool is_apart(const SimplexBounds<dim>& face, double reach) const {
      const Vector<dim> nearest = face.centre.cwiseMax(low).cwiseMin(high);
      const double farthest = (1 + same_place) * reach;
      if ((face.centre - nearest).squaredNorm() > farthest * farthest) return true;
      const Vector<dim>& n = face.normal;
      const double before =
          n.cwiseProduct(low - face.centre).cwiseMin(n.cwiseProduct(high - face.centre)).sum();
      return before > same_place * reach;
    }
  };
  // All of a surface; simplices of a surface with about one normal.
  struct Surface {
    Place place = {};
    std::vector<std::int32_t> group_of = std::vector<std::int32_t>(Cubes::count, -1);  // -1: none
  };
  struct Group {
    Place place = {};
    NormalBox<dim> normals = {};
    std::size_t first = 0, end = 0;  // in simplices_
  };

  // @param place  of the surface in simplices_
  void add_surface(const Faces<dim>& faces, std::span<const std::int32_t> list, std::size_t place) {
    std::array<std::size_t, Cubes::count> counts{};
    for (const std::int32_t s : list) ++counts[Cubes::of(faces.bounds[s].normal)];
    Surface& surface = surfaces_.emplace_back();
    for (int cube = 0; cube < Cubes::count; ++cube) {
      if (counts[cube] == 0) continue;
      surface.group_of[cube] = static_cast<std::int32_t>(groups_.size());
      Group& group = groups_.emplace_back();
      group.first = group.end = place;
      place += counts[cube];
    }
    for (const std::int32_t s : list) {
      const SimplexBounds<dim>& bounds = faces.bounds[s];
      Group& group = groups_[surface.group_of[Cubes::of(bounds.normal)]];
      simplices_[group.end++] = s;
      group.normals.add(bounds.normal);
      group.place.add(bounds);
      surface.place.add(bounds);
    }
  }

  std::vector<std::int32_t> simplices_;
  std::vector<Group> groups_;
  std::vector<Surface> surfaces_;
};

// The faces that may have an opposite face; on a slope there are none.
template <int dim>
std::vector<std::int32_t> possible_fronts(const Faces<dim>& faces) {
  std::vector<NormalBox<dim>> boxes(faces.num_simplices.size());
  for (std::int32_t s = 0; s < std::ssize(faces.simplices); ++s) {
    boxes[faces.surface[s]].add(faces.bounds[s].normal);
  }
  std::vector<std::int32_t> fronts;
  for (std::int32_t s = 0; s < std::ssize(faces.simplices); ++s) {
    const Vector<dim>& normal = faces.bounds[s].normal;
    if (std::ranges::any_of(boxes, [&](const auto& box) { return box.may_oppose(normal); })) {
      fronts.push_back(s);
    }
  }
  return fronts;
}

// Finds corners, where a face ends at a place and another one is before it.
template <int dim>
class Corners {
 public:
  // @param limit  thickness of a thin wall [m]
  Corners(const Faces<dim>& faces, double limit) : faces_(faces), limit_(limit) {}

  // Whether there is one with any of these, which ascend.
  bool has(std::int32_t face, const Vector<dim>& place, std::span<const std::int32_t> others) {
    if (!hash_) list_faces();
    const auto is_before = [&](std::int32_t other) {
      return before(other, face, place) && std::ranges::binary_search(others, other);
    };
    return std::ranges::any_of(hash_->near(place),
                               [&](std::int32_t k) { return is_before(small_[k]); }) ||
           std::ranges::any_of(large_, is_before);
  }

 private:
  // Large faces would be in many of the hash's small cubes.
  void list_faces() {
    std::vector<Simplex<dim>> simplices;
    for (std::int32_t s = 0; s < std::ssize(faces_.simplices); ++s) {
      const bool large = !(faces_.bounds[s].radius <= limit_);
      (large ? large_ : small_).push_back(s);
      if (!large) simplices.push_back(faces_.simplices[s]);
    }
    hash_.emplace(simplices, faces_.vertices, limit_ / 16);
  }
  bool before(std::int32_t u, std::int32_t face, const Vector<dim>& place) const {
    const double tiny = same_place * limit_;
    const Vector<dim>& normal = faces_.bounds[face].normal;
    const SimplexBounds<dim>& other = faces_.bounds[u];
    if (other.normal.dot(normal) > least_bend_cosine) return false;
    if ((other.centre - place).dot(normal) <= tiny || other.is_beyond(place, tiny)) return false;
    return (faces_.closest(u, place) - place).norm() <= tiny;
  }

  const Faces<dim>& faces_;
  double limit_;
  std::vector<std::int32_t> small_, large_;
  std::optional<FacetHash<dim>> hash_;  // of the small ones, made when it is first asked
};

}  // namespace

template <int dim>
Faces<dim>::Faces(const std::vector<StartSurface<dim>>& surfaces) {
  for (std::size_t k = 0; k < surfaces.size(); ++k) {
    first_simplex.push_back(static_cast<std::int32_t>(simplices.size()));
    first_vertex.push_back(static_cast<std::int32_t>(vertices.size()));
    num_simplices.push_back(0);
    if (surfaces[k].settings.mode == ContactMode::fixed) continue;
    for (Simplex<dim> simplex : mpm::simplices(surfaces[k].settings.surface)) {
      for (std::int32_t& vertex : simplex) vertex += first_vertex.back();
      simplices.push_back(simplex);
      surface.push_back(k);
      ++num_simplices.back();
    }
    vertices.insert(vertices.end(), surfaces[k].vertices.begin(), surfaces[k].vertices.end());
  }
  bounds = bounds_of<dim>(simplices, vertices);
}

template <int dim>
bool Faces<dim>::can_have_fields(const FacePair& pair,
                                 const std::vector<StartSurface<dim>>& surfaces) const {
  const auto by_facets = [&](std::int32_t s) {
    return std::holds_alternative<FacetSettings>(surfaces[surface[s]].settings.method);
  };
  return by_facets(pair.front) && by_facets(pair.back);
}

template <int dim>
std::vector<FacePair> thin_pairs(const Faces<dim>& faces, double cell_size) {
  const double limit = thin_cells * cell_size;
  const auto fronts = possible_fronts(faces);
  std::vector<Vector<dim>> places;
  for (const std::int32_t s : fronts) places.push_back(faces.bounds[s].centre);
  const FacetHash<dim> hash(faces.simplices, faces.vertices, inner_corner_reach * limit, places);
  Corners<dim> corners(faces, limit);
  std::unordered_map<const std::int32_t*, ByNormal<dim>> lists;  // by the first entry of `near`
  std::vector<FacePair> pairs;
  for (const std::int32_t s : fronts) {
    const SimplexBounds<dim>& front = faces.bounds[s];
    const auto near = hash.near(front.centre);
    const auto known = std::ssize(pairs);
    const auto look_at = [&](std::int32_t t) {
      const SimplexBounds<dim>& back = faces.bounds[t];
      if (front.normal.dot(back.normal) > -opposite_cosine) return;
      if (back.is_beyond(front.centre, inner_corner_reach * limit)) return;
      const Vector<dim> place = faces.closest(t, front.centre), through = front.centre - place;
      const double distance = through.norm(), thickness = through.dot(front.normal);
      const bool behind = thickness >= opposite_cosine * distance;
      if (behind && distance < (1 - same_place) * limit) pairs.push_back({s, t, distance});
      if (behind || thickness < inner_corner_cosine * distance) return;
      if (thickness >= (1 - same_place) * limit) return;
      if (corners.has(t, place, near)) pairs.push_back({s, t, thickness});
    };
    lists.try_emplace(near.data(), faces, near)
        .first->second.for_opposite(front, inner_corner_reach * limit, look_at);
    std::sort(pairs.begin() + known, pairs.end(),
              [](const FacePair& a, const FacePair& b) { return a.back < b.back; });
  }
  return pairs;
}

std::vector<std::int32_t> members(const std::vector<FacePair>& pairs) {
  std::vector<std::int32_t> all;
  for (const FacePair& pair : pairs) all.insert(all.end(), {pair.front, pair.back});
  std::sort(all.begin(), all.end());
  all.erase(std::unique(all.begin(), all.end()), all.end());
  return all;
}

template struct Faces<2>;
template struct Faces<3>;
template std::vector<FacePair> thin_pairs<2>(const Faces<2>&, double);
template std::vector<FacePair> thin_pairs<3>(const Faces<3>&, double);

}  // namespace gabion::mpm
