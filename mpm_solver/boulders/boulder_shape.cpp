// SPDX-License-Identifier: BSD-3-Clause
#include "mpm_solver/boulders/boulder_shape.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <map>
#include <numbers>

#include "common/base/error.hpp"
#include "mpm_solver/boulders/polygon.hpp"
#include "mpm_solver/contact/surface_features.hpp"

namespace gabion::mpm {

namespace {

constexpr int icosphere_divisions = 3;  // 1280 facets, of 0.15 radii
constexpr int disc_facets = 32;
constexpr std::size_t most_across = 2000;  // facets that a thickness is sought across
constexpr int most_divisions = 3;          // of the facets of a given surface

using Edge = std::array<std::int32_t, 2>;

template <int dim>
void close_extents(BoulderShape<dim>& shape) {
  Vector<dim> low = Vector<dim>::Zero(), high = Vector<dim>::Zero();
  for (const Vector<dim>& X : shape.surface.vertices) {
    shape.radius = std::max(shape.radius, X.norm());
    low = low.cwiseMin(X);
    high = high.cwiseMax(X);
  }
  shape.thickness = (high - low).minCoeff();
}

// The least extent across a facet; of many facets only some are looked at.
template <int dim>
double width_across_facets(const ContactSurface<dim>& surface) {
  const std::size_t count = surface.facets.size() / dim;
  double least = std::numeric_limits<double>::infinity();
  for (std::size_t f = 0; f < count; f += count / most_across + 1) {
    Simplex<dim> facet;
    std::copy_n(surface.facets.begin() + f * dim, dim, facet.begin());
    const Vector<dim> n = simplex_normal<dim>(corners_of<dim>(facet, surface.vertices));
    double low = 0, high = 0;
    for (const Vector<dim>& X : surface.vertices) {
      low = std::min(low, n.dot(X));
      high = std::max(high, n.dot(X));
    }
    least = std::min(least, high - low);
  }
  return least;
}

// Divide each triangle into four, with one vertex on the midpoint of each edge.
void divide(ContactSurface<3>& surface) {
  std::map<Edge, std::int32_t> middles;
  const auto middle = [&](std::int32_t i, std::int32_t j) {
    const auto [place, is_new] = middles.try_emplace(
        {std::min(i, j), std::max(i, j)}, static_cast<std::int32_t>(surface.vertices.size()));
    if (is_new) {
      surface.vertices.push_back(0.5 * (surface.vertices[i] + surface.vertices[j]));
    }
    return place->second;
  };
  std::vector<std::int32_t> facets;
  for (std::size_t f = 0; f < surface.facets.size(); f += 3) {
    const std::int32_t a = surface.facets[f], b = surface.facets[f + 1], c = surface.facets[f + 2];
    const std::int32_t ab = middle(a, b), bc = middle(b, c), ca = middle(c, a);
    for (const std::int32_t v : {a, ab, ca, ab, b, bc, ca, bc, c, ab, bc, ca}) facets.push_back(v);
  }
  surface.facets = std::move(facets);
}

void divide(ContactSurface<2>& surface) {
  std::vector<std::int32_t> facets;
  for (std::size_t f = 0; f < surface.facets.size(); f += 2) {
    const std::int32_t a = surface.facets[f], b = surface.facets[f + 1];
    const auto m = static_cast<std::int32_t>(surface.vertices.size());
    surface.vertices.push_back(0.5 * (surface.vertices[a] + surface.vertices[b]));
    for (const std::int32_t v : {a, m, m, b}) facets.push_back(v);
  }
  surface.facets = std::move(facets);
}

ContactSurface<2> unit_sphere(std::integral_constant<int, 2>) {
  ContactSurface<2> surface;
  for (int k = 0; k < disc_facets; ++k) {
    const double angle = 2 * std::numbers::pi * k / disc_facets;
    surface.vertices.emplace_back(std::cos(angle), std::sin(angle));
    surface.facets.push_back(k);
    surface.facets.push_back((k + 1) % disc_facets);
  }
  return surface;
}

ContactSurface<3> unit_sphere(std::integral_constant<int, 3>) {
  ContactSurface<3> surface;
  surface.facet_type = CellType::tri3;
  const double g = std::numbers::phi;
  surface.vertices = {{-1, g, 0},  {1, g, 0},  {-1, -g, 0}, {1, -g, 0}, {0, -1, g},  {0, 1, g},
                      {0, -1, -g}, {0, 1, -g}, {g, 0, -1},  {g, 0, 1},  {-g, 0, -1}, {-g, 0, 1}};
  surface.facets = {0, 11, 5,  0, 5,  1, 0, 1, 7, 0, 7,  10, 0, 10, 11, 1, 5, 9, 5, 11,
                    4, 11, 10, 2, 10, 7, 6, 7, 1, 8, 3,  9,  4, 3,  4,  2, 3, 2, 6, 3,
                    6, 8,  3,  8, 9,  4, 9, 5, 2, 4, 11, 6,  2, 10, 8,  6, 7, 9, 8, 1};
  for (int k = 0; k < icosphere_divisions; ++k) divide(surface);
  for (Vector<3>& X : surface.vertices) X.normalize();
  return surface;
}

// One square face of a box, whose lattice points become vertices once, found by their numbers along
// the axes.
struct BoxLattice {
  Vector<3> size;
  std::array<int, 3> cells;
  ContactSurface<3> surface{.vertices = {}, .facet_type = CellType::tri3, .facets = {}};
  std::map<std::array<int, 3>, std::int32_t> known = {};

  std::int32_t vertex(const std::array<int, 3>& place) {
    const auto [entry, is_new] =
        known.try_emplace(place, static_cast<std::int32_t>(surface.vertices.size()));
    if (is_new) {
      Vector<3> X;
      for (int d = 0; d < 3; ++d) X[d] = size[d] * (1. * place[d] / cells[d] - 0.5);
      surface.vertices.push_back(X);
    }
    return entry->second;
  }
  void add_side(int axis, bool high) {
    const int b = (axis + 1) % 3, c = (axis + 2) % 3;
    for (int i = 0; i < cells[b]; ++i) {
      for (int j = 0; j < cells[c]; ++j) {
        std::array<std::int32_t, 4> v{};
        for (int k = 0; k < 4; ++k) {
          std::array<int, 3> place{};
          place[axis] = high ? cells[axis] : 0;
          place[b] = i + (k == 1 || k == 2 ? 1 : 0);
          place[c] = j + (k >= 2 ? 1 : 0);
          v[k] = vertex(place);
        }
        if (!high) std::swap(v[1], v[3]);
        for (const int k : {0, 1, 2, 0, 2, 3}) surface.facets.push_back(v[k]);
      }
    }
  }
};

ContactSurface<3> box_surface(const Vector<3>& size) {
  const double wanted = 0.5 * size.norm() / facets_along_radius;
  BoxLattice lattice{.size = size, .cells = {}};
  for (int d = 0; d < 3; ++d)
    lattice.cells[d] = std::max(1, static_cast<int>(std::ceil(size[d] / wanted)));
  for (int axis = 0; axis < 3; ++axis) {
    lattice.add_side(axis, false);
    lattice.add_side(axis, true);
  }
  return lattice.surface;
}

ContactSurface<2> box_surface(const Vector<2>& size) {
  const double wanted = 0.5 * size.norm() / facets_along_radius;
  ContactSurface<2> surface;
  const Vector<2> half = 0.5 * size;
  const std::array<Vector<2>, 4> corners = {Vector<2>(-half), Vector<2>(half[0], -half[1]), half,
                                            Vector<2>(-half[0], half[1])};
  for (int k = 0; k < 4; ++k) {
    const Vector<2> side = corners[(k + 1) % 4] - corners[k];
    const int n = std::max(1, static_cast<int>(std::ceil(side.norm() / wanted)));
    for (int i = 0; i < n; ++i) surface.vertices.push_back(corners[k] + i * side / n);
  }
  const auto count = static_cast<std::int32_t>(surface.vertices.size());
  for (std::int32_t v = 0; v < count; ++v) {
    surface.facets.push_back(v);
    surface.facets.push_back((v + 1) % count);
  }
  return surface;
}

// Each edge (in 2D: vertex) of a closed surface has one facet on each side.
void require_closed(const ContactSurface<3>& surface) {
  std::map<Edge, int> edges;
  for (std::size_t f = 0; f < surface.facets.size(); f += 3) {
    for (int k = 0; k < 3; ++k) ++edges[{surface.facets[f + k], surface.facets[f + (k + 1) % 3]}];
  }
  for (const auto& [edge, count] : edges) {
    const auto other = edges.find({edge[1], edge[0]});
    if (count == 1 && other != edges.end()) continue;
    const Vector<3> x = 0.5 * (surface.vertices[edge[0]] + surface.vertices[edge[1]]);
    throw ConfigError(fmt::format(
        "found an edge at ({}) {}, allowed: a closed surface, whose edges have one triangle on "
        "each side",
        fmt::join(x.data(), x.data() + 3, ", "),
        count == 1 ? "with a triangle on one side only" : "that several triangles share"));
  }
}

void require_closed(const ContactSurface<2>& surface) {
  Polygon corners;
  for (std::size_t f = 0; f < surface.facets.size(); f += 2) {
    corners.push_back(surface.vertices[surface.facets[f]]);
  }
  require_simple(corners);
}

// d^n of X over the simplex of the origin and a facet: volume, first and second moments.
template <int dim>
struct Moments {
  double volume = 0;
  Vector<dim> first = Vector<dim>::Zero();
  Matrix<dim> second = Matrix<dim>::Zero();

  void add(const std::array<Vector<dim>, dim>& corners) {
    Matrix<dim> A;
    for (int k = 0; k < dim; ++k) A.col(k) = corners[k];
    const double v = A.determinant() / (dim == 2 ? 2 : 6);
    Vector<dim> sum = Vector<dim>::Zero();
    for (const auto& X : corners) sum += X;
    volume += v;
    first += v / (dim + 1) * sum;
    Matrix<dim> squares = sum * sum.transpose();
    for (const auto& X : corners) squares += X * X.transpose();
    second += v / ((dim + 1) * (dim + 2)) * squares;
  }
};

// Moments about a place; far from the body their differences cancel.
template <int dim>
Moments<dim> moments_of(const ContactSurface<dim>& surface,
                        const Vector<dim>& about = Vector<dim>::Zero()) {
  Moments<dim> moments;
  for (std::size_t f = 0; f < surface.facets.size(); f += dim) {
    std::array<Vector<dim>, dim> corners;
    for (int k = 0; k < dim; ++k) corners[k] = surface.vertices[surface.facets[f + k]] - about;
    moments.add(corners);
  }
  return moments;
}

// Tensor of inertia from int X X^T of a body.
Matrix<3> inertia_of(const Matrix<3>& second) {
  return second.trace() * Matrix<3>::Identity() - second;
}
Matrix<3> inertia_of(const Matrix<2>& second) {
  return second.trace() * Matrix<3>::Identity();
}

// Parts that are turned inward may leave a volume and take away more inertia than there is.
void require_inertia(const Matrix<3>& inertia) {
  const double least = Eigen::SelfAdjointEigenSolver<Matrix<3>>(inertia).eigenvalues()[0];
  if (least > 0) return;
  throw ConfigError(fmt::format(
      "found a least moment of inertia of {:.6g} kg m^2, allowed: a surface whose normals point "
      "out of the body everywhere and that does not cross itself",
      least));
}

template <int dim>
BodyMass mass_of(double volume, const Vector<dim>& mean_squares, double density) {
  BodyMass result;
  result.mass = density * volume;
  result.inertia = inertia_of(Matrix<dim>(result.mass * mean_squares.asDiagonal()));
  return result;
}

// A sphere or ellipsoid as a polyhedron of its area or volume.
template <int dim>
BoulderShape<dim> round_shape(const Vector<dim>& axes, double density) {
  constexpr double pi = std::numbers::pi;
  const double volume = (dim == 2 ? pi : 4 * pi / 3) * axes.prod();
  BoulderShape<dim> shape;
  shape.mass = mass_of<dim>(volume, axes.cwiseAbs2() / (dim + 2), density);
  shape.surface = unit_sphere(std::integral_constant<int, dim>{});
  for (Vector<dim>& X : shape.surface.vertices) X = X.cwiseProduct(axes);
  const double scale = std::pow(volume / moments_of(shape.surface).volume, 1. / dim);
  for (Vector<dim>& X : shape.surface.vertices) X *= scale;
  close_extents(shape);
  return shape;
}

}  // namespace

template <int dim>
BodyMass mass_within(const ContactSurface<dim>& surface, double density) {
  const Vector<dim>& about = surface.vertices.front();
  const Moments<dim> moments = moments_of(surface, about);
  BodyMass result;
  result.mass = density * moments.volume;
  const Vector<dim> centre = moments.first / moments.volume;
  result.centre.template head<dim>() = about + centre;
  result.inertia = inertia_of(
      Matrix<dim>(density * (moments.second - moments.volume * centre * centre.transpose())));
  return result;
}

template <int dim>
BoulderShape<dim> sphere_shape(double radius, double density) {
  BoulderShape<dim> shape = round_shape<dim>(Vector<dim>::Constant(radius), density);
  shape.sphere = radius;
  shape.thickness = 2 * radius;
  return shape;
}

template <int dim>
BoulderShape<dim> ellipsoid_shape(const Vector<dim>& axes, double density) {
  BoulderShape<dim> shape = round_shape<dim>(axes, density);
  shape.axes = axes;
  return shape;
}

template <int dim>
BoulderShape<dim> box_shape(const Vector<dim>& size, double density) {
  BoulderShape<dim> shape;
  shape.mass = mass_of<dim>(size.prod(), size.cwiseAbs2() / 12, density);
  shape.surface = box_surface(size);
  close_extents(shape);
  return shape;
}

template <int dim>
BoulderShape<dim> surface_shape(ContactSurface<dim> surface, double density) {
  require_closed(surface);
  const Vector<dim> first = surface.vertices.front();
  for (Vector<dim>& X : surface.vertices) X -= first;
  const double volume = moments_of(surface).volume;
  if (!(volume > 0)) {
    throw ConfigError(
        fmt::format("found a volume of {:.6g}, allowed: a surface whose normals "
                    "point out of the body",
                    volume));
  }
  BoulderShape<dim> shape;
  shape.mass = mass_within(surface, density);
  shape.surface = std::move(surface);
  require_inertia(shape.mass.inertia);
  for (Vector<dim>& X : shape.surface.vertices) X -= shape.mass.centre.template head<dim>();
  shape.mass.centre.template head<dim>() += first;
  close_extents(shape);
  shape.thickness = std::min(shape.thickness, width_across_facets(shape.surface));
  for (int k = 0; k < most_divisions; ++k) {
    double longest = 0;
    const auto& facets = shape.surface.facets;
    for (std::size_t f = 0; f < facets.size(); f += dim) {
      const auto& X = shape.surface.vertices;
      for (int i = 0; i < dim; ++i) {
        longest = std::max(longest, (X[facets[f + i]] - X[facets[f + (i + 1) % dim]]).norm());
      }
    }
    if (longest <= 1.5 * shape.radius / facets_along_radius) break;
    divide(shape.surface);
  }
  return shape;
}

template BodyMass mass_within<2>(const ContactSurface<2>&, double);
template BodyMass mass_within<3>(const ContactSurface<3>&, double);
template BoulderShape<2> sphere_shape<2>(double, double);
template BoulderShape<3> sphere_shape<3>(double, double);
template BoulderShape<2> box_shape<2>(const Vector<2>&, double);
template BoulderShape<3> box_shape<3>(const Vector<3>&, double);
template BoulderShape<2> ellipsoid_shape<2>(const Vector<2>&, double);
template BoulderShape<3> ellipsoid_shape<3>(const Vector<3>&, double);
template BoulderShape<2> surface_shape<2>(ContactSurface<2>, double);
template BoulderShape<3> surface_shape<3>(ContactSurface<3>, double);

}  // namespace gabion::mpm
