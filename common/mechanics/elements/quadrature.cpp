// SPDX-License-Identifier: BSD-3-Clause
// Rules on the triangle: Strang and Fix (1973), Radon (1948), Dunavant (1985).
// Rules on the tetrahedron: Hammer and Stroud (1956), Walkington (2000).
#include <fmt/format.h>

#include <cassert>
#include <cmath>

#include "common/base/require.hpp"
#include "common/mechanics/elements/shape_functions.hpp"

namespace gabion {

namespace {

template <int dim>
using Rule = std::vector<QuadraturePoint<dim>>;

/// Gauss-Legendre rule on [-1, 1] with n = 1 to 4 points, exact to degree 2n - 1.
Rule<1> gauss_legendre(int n) {
  const auto symmetric = [](double x, double w, Rule<1>& rule) {
    rule.insert(rule.begin(), {Vector<1>(-x), w});
    rule.push_back({Vector<1>(x), w});
  };
  Rule<1> rule;
  if (n == 1) {
    rule.push_back({Vector<1>(0.0), 2.0});
  } else if (n == 2) {
    symmetric(1.0 / std::sqrt(3.0), 1.0, rule);
  } else if (n == 3) {
    rule.push_back({Vector<1>(0.0), 8.0 / 9.0});
    symmetric(std::sqrt(0.6), 5.0 / 9.0, rule);
  } else {
    const double s = 2.0 / 7.0 * std::sqrt(1.2);
    symmetric(std::sqrt(3.0 / 7.0 - s), (18.0 + std::sqrt(30.0)) / 36.0, rule);
    symmetric(std::sqrt(3.0 / 7.0 + s), (18.0 - std::sqrt(30.0)) / 36.0, rule);
  }
  return rule;
}

/// Centres of n equal parts of [-1, 1].
Rule<1> equal_parts(int n) {
  Rule<1> rule;
  for (int k = 0; k < n; ++k) rule.push_back({Vector<1>((2 * k + 1.0) / n - 1), 2.0 / n});
  return rule;
}

/// Product of rules of the line, for quads or hexes; the first coordinate runs fastest.
template <int dim>
Rule<dim> product_rule(const Rule<1>& line) {
  const int n = static_cast<int>(line.size());
  int count = 1;
  for (int i = 0; i < dim; ++i) count *= n;
  Rule<dim> rule(count);
  for (int q = 0; q < count; ++q) {
    rule[q].weight = 1.0;
    for (int i = 0, rest = q; i < dim; ++i, rest /= n) {
      rule[q].xi[i] = line[rest % n].xi[0];
      rule[q].weight *= line[rest % n].weight;
    }
  }
  return rule;
}

/// The barycentre. `weight` is the share of the simplex's volume, as in the functions below.
template <int dim>
void add_centre(double weight, Rule<dim>& rule) {
  rule.push_back({Vector<dim>::Constant(1.0 / (dim + 1)), weight});
}

/// The dim + 1 points with barycentric coordinates (a, .., a, 1 - dim a).
template <int dim>
void add_vertex_orbit(double a, double weight, Rule<dim>& rule) {
  rule.push_back({Vector<dim>::Constant(a), weight});
  for (int i = 0; i < dim; ++i) {
    Vector<dim> xi = Vector<dim>::Constant(a);
    xi[i] = 1.0 - dim * a;
    rule.push_back({xi, weight});
  }
}

/// The six points of a triangle with barycentric coordinates (a, b, 1 - a - b).
void add_triangle_orbit(double a, double b, double weight, Rule<2>& rule) {
  const double c = 1.0 - a - b;
  for (const auto& [x, y] : {std::pair{a, b}, {b, a}, {a, c}, {c, a}, {b, c}, {c, b}}) {
    rule.push_back({Vector<2>(x, y), weight});
  }
}

/// The six points of a tetrahedron with barycentric coordinates (a, a, 1/2 - a, 1/2 - a).
void add_edge_orbit(double a, double weight, Rule<3>& rule) {
  const double b = 0.5 - a;
  rule.push_back({Vector<3>(a, b, b), weight});
  rule.push_back({Vector<3>(b, a, b), weight});
  rule.push_back({Vector<3>(b, b, a), weight});
  rule.push_back({Vector<3>(b, a, a), weight});
  rule.push_back({Vector<3>(a, b, a), weight});
  rule.push_back({Vector<3>(a, a, b), weight});
}

Rule<2> triangle_rule(int degree) {
  Rule<2> rule;
  if (degree <= 1) {
    add_centre(1.0, rule);
  } else if (degree == 2) {
    add_vertex_orbit(1.0 / 6.0, 1.0 / 3.0, rule);
  } else if (degree <= 4) {
    const double p = 8.0 - std::sqrt(10.0), q = std::sqrt(38.0 - 44.0 * std::sqrt(0.4));
    const double s = std::sqrt(213125.0 - 53320.0 * std::sqrt(10.0));
    add_vertex_orbit((p + q) / 18.0, (620.0 + s) / 3720.0, rule);
    add_vertex_orbit((p - q) / 18.0, (620.0 - s) / 3720.0, rule);
  } else if (degree == 5) {
    const double s = std::sqrt(15.0);
    add_centre(9.0 / 40.0, rule);
    add_vertex_orbit((6.0 + s) / 21.0, (155.0 + s) / 1200.0, rule);
    add_vertex_orbit((6.0 - s) / 21.0, (155.0 - s) / 1200.0, rule);
  } else {
    add_vertex_orbit(0.24928674517091042129, 0.11678627572637936603, rule);
    add_vertex_orbit(0.06308901449150222834, 0.05084490637020681692, rule);
    add_triangle_orbit(0.05314504984481694735, 0.31035245103378440542, 0.08285107561837357519,
                       rule);
  }
  for (auto& point : rule) point.weight *= 0.5;
  return rule;
}

Rule<3> tetrahedron_rule(int degree) {
  Rule<3> rule;
  if (degree <= 1) {
    add_centre(1.0, rule);
  } else if (degree == 2) {
    add_vertex_orbit((5.0 - std::sqrt(5.0)) / 20.0, 0.25, rule);
  } else {
    add_vertex_orbit(0.31088591926330060980, 0.11268792571801585080, rule);
    add_vertex_orbit(0.09273525031089122640, 0.07349304311636194934, rule);
    add_edge_orbit(0.04550370412564964949, 0.04254602077708146686, rule);
  }
  for (auto& point : rule) point.weight /= 6.0;
  return rule;
}

/// Centroids of the n x n equal triangles that lines parallel to the sides cut out.
Rule<2> subtriangle_centroids(int n) {
  Rule<2> rule;
  const double weight = 0.5 / (n * n);
  for (int j = 0; j < n; ++j) {
    for (int i = 0; i + j < n; ++i) {
      rule.push_back({Vector<2>(i + 1.0 / 3.0, j + 1.0 / 3.0) / n, weight});
      if (i + j < n - 1) rule.push_back({Vector<2>(i + 2.0 / 3.0, j + 2.0 / 3.0) / n, weight});
    }
  }
  return rule;
}

int largest_degree(CellType any_type) {
  const CellType type = corner_type(any_type);
  return type == CellType::tri3 ? 6 : type == CellType::tet4 ? 5 : 7;
}

[[noreturn]] void refuse_count(CellType type, int num_points) {
  const char* allowed = type == CellType::tri3    ? "1, 3, 4, 6, 12, 16"
                        : type == CellType::quad4 ? "1, 4, 9, 16"
                        : type == CellType::tet4  ? "1, 4"
                                                  : "1, 8, 27";
  throw ConfigError(
      fmt::format("points per cell of {}: found {}, allowed: {}", name(type), num_points, allowed));
}

}  // namespace

template <int dim>
std::vector<QuadraturePoint<dim>> gauss_rule(CellType type, int degree) {
  assert(dimension(type) == dim);
  require(degree >= 0 && degree <= largest_degree(type),
          "Gauss rule of {}: found degree {}, allowed: 0 to {}", name(type), degree,
          largest_degree(type));
  if constexpr (dim == 2) {
    if (is_simplex(type)) return triangle_rule(degree);
  }
  if constexpr (dim == 3) {
    if (is_simplex(type)) return tetrahedron_rule(degree);
  }
  return product_rule<dim>(gauss_legendre(degree / 2 + 1));
}

template <int dim>
std::vector<QuadraturePoint<dim>> point_rule(CellType type, int num_points,
                                             PointPlacement placement) {
  assert(dimension(type) == dim);
  if constexpr (dim == 2) {
    if (type == CellType::tri3) {
      switch (num_points) {
        case 1:
          return triangle_rule(1);
        case 3:
          return triangle_rule(2);
        case 4:
          return subtriangle_centroids(2);
        case 6:
          return triangle_rule(4);
        case 12:
          return triangle_rule(6);
        case 16:
          return subtriangle_centroids(4);
        default:
          refuse_count(type, num_points);
      }
    }
  }
  if constexpr (dim == 3) {
    if (type == CellType::tet4) {
      if (num_points != 1 && num_points != 4) refuse_count(type, num_points);
      return tetrahedron_rule(num_points == 1 ? 1 : 2);
    }
  }
  for (int n = 1; n <= (dim == 2 ? 4 : 3); ++n) {
    if (num_points != (dim == 2 ? n * n : n * n * n)) continue;
    return product_rule<dim>(placement == PointPlacement::gauss ? gauss_legendre(n)
                                                                : equal_parts(n));
  }
  refuse_count(type, num_points);
}

template std::vector<QuadraturePoint<1>> gauss_rule(CellType, int);
template std::vector<QuadraturePoint<2>> gauss_rule(CellType, int);
template std::vector<QuadraturePoint<3>> gauss_rule(CellType, int);
template std::vector<QuadraturePoint<2>> point_rule(CellType, int, PointPlacement);
template std::vector<QuadraturePoint<3>> point_rule(CellType, int, PointPlacement);

}  // namespace gabion
