// SPDX-License-Identifier: BSD-3-Clause
#include "mpm_solver/contact/contact_fields.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <utility>

#include "mpm_solver/contact/facet_hash.hpp"

namespace gabion::mpm {

namespace {

// Facets that look within 60 degrees of a mark's normal may share it.
constexpr double same_side = 0.5;

// Distances within this share of a limit may be on either side of it by rounding.
constexpr double rounding = 1e-9;

// Places that follow each other share a look around in blocks of this size.
constexpr std::size_t block = 8;

// In 3D the square of a mark is cut into this many parts along each side.
constexpr int parts = 4;

/// Simplices of a surface, in its order, and the facet of each.
template <int dim>
struct CutFacets {
  std::vector<Simplex<dim>> simplices;
  std::vector<std::size_t> facets;
};

/// The facets of a surface whose bounding boxes, widened by the margin [m], meet that of the
/// places.
template <int dim>
CutFacets<dim> facets_near(const ContactSurface<dim>& surface, std::span<const Vector<dim>> at,
                           double margin, std::span<const Vector<dim>> places) {
  using Box = Eigen::AlignedBox<double, dim>;
  Box around;
  for (const Vector<dim>& x : places) around.extend(x);
  const std::size_t cuts_per_facet = surface.facet_type == CellType::quad4 ? 2 : 1;
  const std::vector<Simplex<dim>> all = simplices(surface);
  CutFacets<dim> near;
  for (std::size_t s = 0; s < all.size(); ++s) {
    Box box;
    for (const std::int32_t v : all[s]) box.extend(at[v]);
    box.min().array() -= margin;
    box.max().array() += margin;
    if (!box.intersects(around)) continue;
    near.simplices.push_back(all[s]);
    near.facets.push_back(s / cuts_per_facet);
  }
  return near;
}

/// The facets of a surface where they are, to be found from some places; those far from all of them
/// are left out.
template <int dim>
struct PlacedSurface {
  PlacedSurface(const ContactSurface<dim>& surface, std::span<const Vector<dim>> at, double margin,
                std::span<const Vector<dim>> places)
      : vertices(at),
        near(facets_near(surface, at, margin, places)),
        bounds(bounds_of<dim>(near.simplices, at)),
        hash(near.simplices, at, margin, places) {}

  std::array<Vector<dim>, dim> corners(std::int32_t s) const {
    return corners_of<dim>(near.simplices[s], vertices);
  }
  double height(std::int32_t s, const Vector<dim>& x) const {
    return (x - vertices[near.simplices[s][0]]).dot(bounds[s].normal);
  }
  std::size_t facet(std::int32_t s) const { return near.facets[s]; }

  std::span<const Vector<dim>> vertices;
  CutFacets<dim> near;
  std::vector<SimplexBounds<dim>> bounds;
  FacetHash<dim> hash;
};

/// Sphere around some places.
template <int dim>
struct Surrounding {
  Vector<dim> middle = Vector<dim>::Zero();
  double radius = 0;  // [m]
};

/// Simplices near each of some places. Places that follow each other, as those of the points laid
/// in one cell do, share one query of the surface's lists.
template <int dim>
class NearPoints {
 public:
  NearPoints(const PlacedSurface<dim>& surface, std::span<const Vector<dim>> x, double reach)
      : surface_(surface), x_(x), reach_(reach) {}

  /// All simplices within reach of place p, in the order of the surface, and some others; valid
  /// until the next call.
  std::span<const std::int32_t> of(std::size_t p) {
    return of(p, [](std::int32_t, const Surrounding<dim>&) { return true; });
  }
  /// @param matters  whether simplex s matters to any of the places within the Surrounding
  template <class Matters>
  std::span<const std::int32_t> of(std::size_t p, const Matters& matters) {
    if (p / block != block_) start_block(p / block);
    const auto list = surface_.hash.near(x_[p]);
    if (list.data() == list_) return near_;
    list_ = list.data();
    near_.clear();
    const double limit = (1 + rounding) * (reach_ + around_.radius);
    for (const std::int32_t s : list) {
      if (surface_.bounds[s].is_beyond(around_.middle, limit) || !matters(s, around_)) continue;
      near_.push_back(s);
    }
    return near_;
  }

 private:
  void start_block(std::size_t number) {
    block_ = number;
    list_ = nullptr;
    Eigen::AlignedBox<double, dim> box;
    const std::size_t end = std::min(x_.size(), (number + 1) * block);
    for (std::size_t p = number * block; p < end; ++p) box.extend(x_[p]);
    around_ = {box.center(), box.diagonal().norm() / 2};
  }

  const PlacedSurface<dim>& surface_;
  std::span<const Vector<dim>> x_;
  double reach_;
  std::size_t block_ = std::numeric_limits<std::size_t>::max();
  Surrounding<dim> around_;             // the places of the block
  const std::int32_t* list_ = nullptr;  // that near_ was made of
  std::vector<std::int32_t> near_;
};

/// Numbers of places that lie together one after the other: cube by cube of this side [m].
template <int dim>
std::vector<std::int32_t> in_cubes(std::span<const Vector<dim>> places, double side) {
  using Cube = std::array<std::int64_t, dim>;
  std::vector<std::pair<Cube, std::int32_t>> all(places.size());
  for (std::size_t p = 0; p < places.size(); ++p) {
    for (int d = 0; d < dim; ++d) {
      all[p].first[d] = static_cast<std::int64_t>(std::floor(places[p][d] / side));
    }
    all[p].second = static_cast<std::int32_t>(p);
  }
  std::sort(all.begin(), all.end());
  std::vector<std::int32_t> order;
  for (const auto& each : all) order.push_back(each.second);
  return order;
}

/// Numbers of the points that may be within a distance of a simplex by its bounding sphere, which
/// goes no farther beyond the simplex than its corners are apart; those that lie together follow
/// each other, cube by cube of a side [m].
template <int dim>
std::vector<std::int32_t> points_near(const ContactSurface<dim>& surface,
                                      std::span<const Vector<dim>> vertices, double distance,
                                      std::span<const Vector<dim>> x, double side) {
  Eigen::AlignedBox<double, dim> box;
  double widest = 0;
  for (std::size_t f = 0, n = num_nodes(surface.facet_type); f < surface.facets.size(); f += n) {
    Eigen::AlignedBox<double, dim> own;
    for (std::size_t k = f; k < f + n; ++k) own.extend(vertices[surface.facets[k]]);
    widest = std::max(widest, own.sizes().norm());
    box.extend(own);
  }
  const Vector<dim> beyond = Vector<dim>::Constant(distance + widest);
  const Eigen::AlignedBox<double, dim> around(box.min() - beyond, box.max() + beyond);
  std::vector<std::int32_t> numbers;
  std::vector<Vector<dim>> places;
  for (std::int32_t p = 0; p < std::ssize(x); ++p) {
    if (!around.contains(x[p])) continue;
    numbers.push_back(p);
    places.push_back(x[p]);
  }
  std::vector<std::int32_t> order = in_cubes<dim>(places, side);
  std::ranges::transform(order, order.begin(), [&](std::int32_t k) { return numbers[k]; });
  return order;
}

/// Contact spheres of the material points of a block, once one of them is asked for.
template <int dim>
class SpheresOfBlock {
 public:
  /// @param order  of the material points, block by block
  SpheresOfBlock(const SphereOfPoint<dim>& sphere_of, std::span<const std::int32_t> order)
      : sphere_of_(sphere_of), order_(order) {}

  /// @param k  place in the order
  const ContactSphere<dim>& of(std::size_t k) {
    look_at(k);
    return spheres_[k % block];
  }
  /// No sphere of the block of place k reaches farther [m].
  double most(std::size_t k) {
    look_at(k);
    return most_;
  }

 private:
  void look_at(std::size_t k) {
    const std::size_t number = k / block;
    if (number == block_) return;
    block_ = number;
    most_ = 0;
    for (std::size_t i = 0; i < std::min(block, order_.size() - number * block); ++i) {
      spheres_[i] = sphere_of_(order_[number * block + i]);
      most_ = std::max(most_, spheres_[i].shape.norm() + spheres_[i].offset.norm());
    }
  }

  const SphereOfPoint<dim>& sphere_of_;
  std::span<const std::int32_t> order_;
  std::size_t block_ = std::numeric_limits<std::size_t>::max();
  double most_ = 0;
  std::array<ContactSphere<dim>, block> spheres_;
};

/// Part of a mark on a facet.
struct FacetShare {
  std::size_t facet;
  double size;
};

double width_of(double area, int dim) {
  return dim == 2 ? area : std::sqrt(area);
}

// Overlap of the strip with the segments, seen along the normal.
// @param about  all simplices within 1.5 widths of the mark, and others
void shares_of(const PlacedSurface<2>& surface, std::span<const std::int32_t> about,
               const ContactMark<2>& mark, std::vector<FacetShare>& shares) {
  const double half = mark.area / 2;
  const Vector<2> along(-mark.normal[1], mark.normal[0]);
  for (const std::int32_t s : about) {
    if (surface.bounds[s].normal.dot(mark.normal) <= same_side) continue;
    const auto c = surface.corners(s);
    const double a = along.dot(c[0] - mark.x), b = along.dot(c[1] - mark.x);
    const double first = std::max(std::min(a, b), -half), last = std::min(std::max(a, b), half);
    if (last <= first) continue;
    const double at = ((first + last) / 2 - a) / (b - a);
    const Vector<2> middle = (1 - at) * c[0] + at * c[1];
    if (std::abs(mark.normal.dot(middle - mark.x)) > half) continue;
    shares.push_back({surface.facet(s), last - first});
  }
}

// Each part of the square goes to the nearest triangle, of equally near ones to the first.
void shares_of(const PlacedSurface<3>& surface, std::span<const std::int32_t> about,
               const ContactMark<3>& mark, std::vector<FacetShare>& shares) {
  const double width = std::sqrt(mark.area);
  const Vector<3> e1 = mark.normal.unitOrthogonal(), e2 = mark.normal.cross(e1);
  std::vector<std::int32_t> near;  // of the square and of half its width around it
  for (const std::int32_t s : about) {
    const SimplexBounds<3>& bounds = surface.bounds[s];
    if (bounds.normal.dot(mark.normal) > same_side && !bounds.is_beyond(mark.x, 1.5 * width)) {
      near.push_back(s);
    }
  }
  for (int k = 0; k < parts * parts; ++k) {
    const double u = ((k % parts + 0.5) / parts - 0.5) * width;
    const double v = ((k / parts + 0.5) / parts - 0.5) * width;
    const Vector<3> y = mark.x + u * e1 + v * e2;
    double least = width / 2;
    std::int32_t nearest = -1;
    for (const std::int32_t s : near) {
      if (surface.bounds[s].is_beyond(y, least)) continue;
      const double distance = (closest_place<3>(surface.corners(s), y).x - y).norm();
      if (distance >= least - 1e-9 * width) continue;
      least = distance;
      nearest = s;
    }
    if (nearest >= 0) shares.push_back({surface.facet(nearest), 1});
  }
}

// Gap between a triangle or segment and the soil of a point that it faces [m]. That soil is the
// sphere of radius R, extended sideways up to half_width; the extension never penetrates, since it
// ends where the surface falls away.
template <int dim>
double gap_to_soil(const std::array<Vector<dim>, dim>& corners, const Vector<dim>& x, double height,
                   double R, double half_width) {
  const double distance = (x - closest_place<dim>(corners, x).x).norm();
  const double aside = std::sqrt(std::max(0.0, distance * distance - height * height));
  const double of_soil = std::hypot(height, std::max(0.0, aside - half_width)) - R;
  return of_soil < 0 ? std::min(distance - R, 0.0) : of_soil;
}

}  // namespace

template <int dim>
ContactFields<dim>::ContactFields(std::vector<Vector<dim>> vertices_, std::size_t num_facets)
    : vertices(std::move(vertices_)),
      force(num_facets, Vector<dim>::Zero()),
      slip(num_facets, Vector<dim>::Zero()),
      area(num_facets, 0.0),
      gap(num_facets, std::numeric_limits<double>::infinity()),
      status(num_facets, 0.0) {}

template <int dim>
void ContactFields<dim>::add(std::size_t facet, double share, const ContactMark<dim>& mark) {
  force[facet] += share * mark.force;
  slip[facet] += share * mark.area * mark.slip;
  area[facet] += share * mark.area;
  gap[facet] = std::min(gap[facet], mark.gap);
  status[facet] = std::max(status[facet], mark.sliding ? 2.0 : 1.0);
}

template <int dim>
void spread_marks(const ContactSurface<dim>& surface, std::span<const ContactMark<dim>> marks,
                  ContactFields<dim>& fields) {
  double widest = 0;
  std::vector<Vector<dim>> places;
  for (const auto& mark : marks) {
    widest = std::max(widest, width_of(mark.area, dim));
    places.push_back(mark.x);
  }
  if (!(widest > 0)) return;
  const PlacedSurface<dim> placed(surface, fields.vertices, widest, places);
  NearPoints<dim> near(placed, places, 1.5 * widest);
  std::vector<FacetShare> shares;
  for (std::size_t m = 0; m < marks.size(); ++m) {
    const ContactMark<dim>& mark = marks[m];
    shares.clear();
    shares_of(placed, near.of(m), mark, shares);
    double sum = 0;
    for (const FacetShare& share : shares) sum += share.size;
    if (!(sum > 0)) {
      shares.assign(1, {static_cast<std::size_t>(mark.facet), 1});
      sum = 1;
    }
    for (const FacetShare& share : shares) fields.add(share.facet, share.size / sum, mark);
  }
}

template <int dim>
void add_gaps(const ContactSurface<dim>& surface, const MaterialPoints<dim>& points,
              const SphereOfPoint<dim>& sphere_of, double reach, ContactFields<dim>& fields) {
  double widest = 0;
  for (std::int32_t p = 0; p < points.size(); ++p) {
    widest = std::max(widest, points.V0[p] * points.J[p]);
  }
  if (!(widest > 0)) return;
  const double side = cube_side<dim>(widest), farthest = reach + side;
  // Points of one number range may be far apart: in soil that flows they mix.
  const std::vector<std::int32_t> order =
      points_near<dim>(surface, fields.vertices, farthest, points.x, 2 * side);
  std::vector<Vector<dim>> places;
  for (const std::int32_t p : order) places.push_back(points.x[p]);
  const PlacedSurface<dim> placed(surface, fields.vertices, farthest, places);
  NearPoints<dim> near(placed, places, farthest);
  SpheresOfBlock<dim> spheres(sphere_of, order);
  for (std::size_t k = 0; k < order.size(); ++k) {
    const std::int32_t p = order[k];
    const Vector<dim>& x = places[k];
    // Higher points are passed over: their gap is at least the height less R, which is more than
    // the gap known.
    const auto highest = [&](std::int32_t s) {
      const double known = std::min(fields.gap[placed.facet(s)], reach);
      return (1 + rounding) * (std::max(0.0, known) + spheres.most(k));
    };
    const auto matters = [&](std::int32_t s, const Surrounding<dim>& around) {
      const double height = placed.height(s, around.middle);
      const double radius = (1 + rounding) * around.radius;
      return height >= -radius && height - radius <= highest(s);
    };
    for (const std::int32_t s : near.of(k, matters)) {
      const double height = placed.height(s, x);
      if (height <= 0 || height > highest(s)) continue;
      const SimplexBounds<dim>& bounds = placed.bounds[s];
      if (bounds.is_beyond(x, farthest)) continue;
      const double R = spheres.of(k).reach(bounds.normal);
      const double half_width = width_of(points.V0[p] * points.J[p] / (2 * R), dim) / 2;
      double& least = fields.gap[placed.facet(s)];
      // the gap is at least the distance of the simplex - half_width - R
      const double limit =
          std::max(0.0, (1 + rounding) * (std::min(least, reach) + R + half_width));
      if (height > limit || bounds.is_beyond(x, limit)) continue;
      const double gap = gap_to_soil<dim>(placed.corners(s), x, height, R, half_width);
      if (gap <= reach) least = std::min(least, gap);
    }
  }
}

template struct ContactFields<2>;
template struct ContactFields<3>;
template void spread_marks<2>(const ContactSurface<2>&, std::span<const ContactMark<2>>,
                              ContactFields<2>&);
template void spread_marks<3>(const ContactSurface<3>&, std::span<const ContactMark<3>>,
                              ContactFields<3>&);
template void add_gaps<2>(const ContactSurface<2>&, const MaterialPoints<2>&,
                          const SphereOfPoint<2>&, double, ContactFields<2>&);
template void add_gaps<3>(const ContactSurface<3>&, const MaterialPoints<3>&,
                          const SphereOfPoint<3>&, double, ContactFields<3>&);

}  // namespace gabion::mpm
