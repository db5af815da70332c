// SPDX-License-Identifier: BSD-3-Clause
// Serendipity cells: Zienkiewicz and Taylor (2000), volume 1, chapter 8.
#include "common/mechanics/elements/quadratic_cells.hpp"

#include <algorithm>
#include <array>
#include <bit>
#include <cassert>
#include <initializer_list>
#include <vector>

#include "common/mechanics/elements/shape_functions.hpp"

namespace gabion {

namespace {

constexpr CornerSet set_of(std::initializer_list<int> corners) {
  CornerSet set = 0;
  for (const int a : corners) set |= static_cast<CornerSet>(1 << a);
  return set;
}

constexpr CornerSet line3_nodes[] = {set_of({0, 1})};
constexpr CornerSet tri6_nodes[] = {set_of({0, 1}), set_of({1, 2}), set_of({2, 0})};
constexpr CornerSet quad9_nodes[] = {set_of({0, 1}), set_of({1, 2}), set_of({2, 3}), set_of({3, 0}),
                                     set_of({0, 1, 2, 3})};
constexpr CornerSet tet10_nodes[] = {set_of({0, 1}), set_of({1, 2}), set_of({2, 0}),
                                     set_of({3, 0}), set_of({2, 3}), set_of({1, 3})};
constexpr CornerSet hex27_nodes[] = {set_of({0, 1}),
                                     set_of({0, 3}),
                                     set_of({0, 4}),
                                     set_of({1, 2}),
                                     set_of({1, 5}),
                                     set_of({2, 3}),
                                     set_of({2, 6}),
                                     set_of({3, 7}),
                                     set_of({4, 5}),
                                     set_of({4, 7}),
                                     set_of({5, 6}),
                                     set_of({6, 7}),
                                     set_of({0, 1, 2, 3}),
                                     set_of({0, 1, 5, 4}),
                                     set_of({0, 3, 7, 4}),
                                     set_of({1, 2, 6, 5}),
                                     set_of({2, 3, 7, 6}),
                                     set_of({4, 5, 6, 7}),
                                     0xff};

/// Place of a corner in the reference cell.
template <int dim>
Vector<dim> corner_place(CellType type, int corner) {
  Vector<dim> xi;
  if (is_simplex(type)) {
    xi.setZero();
    if (corner > 0) xi[corner - 1] = 1;
    return xi;
  }
  constexpr int sign[8][3] = {{-1, -1, -1}, {1, -1, -1}, {1, 1, -1}, {-1, 1, -1},
                              {-1, -1, 1},  {1, -1, 1},  {1, 1, 1},  {-1, 1, 1}};
  for (int i = 0; i < dim; ++i) xi[i] = sign[corner][i];
  return xi;
}

/// tri6, tet10: barycentric l; l (2 l - 1) at corners, 4 l_a l_b between two.
template <int dim>
void simplex_shapes(CellType type, const Vector<dim>& xi, AnyShapeValues<dim>& out) {
  double l[dim + 1];
  Vector<dim> dl[dim + 1];
  l[0] = 1 - xi.sum();
  dl[0].setConstant(-1);
  for (int i = 0; i < dim; ++i) {
    l[i + 1] = xi[i];
    dl[i + 1] = Vector<dim>::Unit(i);
  }
  for (int a = 0; a <= dim; ++a) {
    out.N[a] = l[a] * (2 * l[a] - 1);
    out.dN[a] = (4 * l[a] - 1) * dl[a];
  }
  int node = dim + 1;
  for (const CornerSet set : middle_nodes(type)) {
    const int a = std::countr_zero(set), b = std::bit_width(set) - 1;
    out.N[node] = 4 * l[a] * l[b];
    out.dN[node++] = 4 * (l[a] * dl[b] + l[b] * dl[a]);
  }
}

/// A factor of a product and its slope.
struct Factor {
  double value, slope;
};

/// Lagrange's polynomial of degree 2 that is 1 at s, one of -1, 0, 1.
Factor quadratic_factor(double s, double x) {
  if (s == 0) return {1 - x * x, -2 * x};
  return {0.5 * x * (x + s), x + 0.5 * s};
}

template <int dim>
void set_product(const Factor* factor, int node, AnyShapeValues<dim>& out) {
  out.N[node] = 1;
  out.dN[node].setOnes();
  for (int i = 0; i < dim; ++i) {
    out.N[node] *= factor[i].value;
    for (int j = 0; j < dim; ++j) out.dN[node][j] *= i == j ? factor[i].slope : factor[i].value;
  }
}

/// quad8, hex20: (1 + s.xi) products, times 1/2^dim (s.xi - dim + 1) at corners, and with
/// 1 - xi_k^2 along the edge of a middle node.
template <int dim>
void serendipity_shape(const Vector<dim>& s, const Vector<dim>& xi, int node,
                       AnyShapeValues<dim>& out) {
  Factor factor[dim];
  bool is_corner = true;
  for (int i = 0; i < dim; ++i) {
    const bool along = s[i] == 0;
    is_corner = is_corner && !along;
    factor[i] = along ? Factor{1 - xi[i] * xi[i], -2 * xi[i]}
                      : Factor{0.5 * (1 + s[i] * xi[i]), 0.5 * s[i]};
  }
  set_product<dim>(factor, node, out);
  if (!is_corner) return;
  const double last = s.dot(xi) - (dim - 1);
  out.dN[node] = last * out.dN[node] + out.N[node] * s;
  out.N[node] *= last;
}

template <int dim>
void quadratic_shapes(CellType type, const Vector<dim>& xi, AnyShapeValues<dim>& out) {
  if (is_simplex(type)) return simplex_shapes<dim>(type, xi, out);
  const bool serendipity = type == CellType::quad8 || type == CellType::hex20;
  for (int a = 0; a < num_nodes(type); ++a) {
    const Vector<dim> s = node_place<dim>(type, a);
    if (serendipity) {
      serendipity_shape<dim>(s, xi, a, out);
      continue;
    }
    Factor factor[dim];
    for (int i = 0; i < dim; ++i) factor[i] = quadratic_factor(s[i], xi[i]);
    set_product<dim>(factor, a, out);
  }
}

}  // namespace

std::span<const CornerSet> middle_nodes(CellType type) {
  switch (type) {
    case CellType::line3:
      return line3_nodes;
    case CellType::tri6:
      return tri6_nodes;
    case CellType::quad8:
      return std::span(quad9_nodes).first(4);
    case CellType::quad9:
      return quad9_nodes;
    case CellType::tet10:
      return tet10_nodes;
    case CellType::hex20:
      return std::span(hex27_nodes).first(12);
    case CellType::hex27:
      return hex27_nodes;
    default:
      return {};
  }
}

template <int dim>
Vector<dim> node_place(CellType type, int node) {
  const int corners = num_corners(type);
  if (node < corners) return corner_place<dim>(type, node);
  const CornerSet set = middle_nodes(type)[node - corners];
  Vector<dim> sum = Vector<dim>::Zero();
  for (int a = 0; a < corners; ++a) {
    if (set >> a & 1) sum += corner_place<dim>(type, a);
  }
  return sum / std::popcount(set);
}

template <int dim>
void shape_functions(CellType type, const Vector<dim>& xi, AnyShapeValues<dim>& out) {
  assert(dimension(type) == dim);
  if (is_quadratic(type)) return quadratic_shapes<dim>(type, xi, out);
  ShapeValues<dim> linear;
  shape_functions<dim>(type, xi, linear);
  std::copy_n(linear.N, num_nodes(type), out.N);
  std::copy_n(linear.dN, num_nodes(type), out.dN);
}

void mirror_cell(CellType type, std::span<std::int32_t> nodes) {
  std::array<int, max_cell_nodes> image = {0, 1, 2, 3, 4, 5, 6, 7};
  const int corners = num_corners(type);
  if (is_simplex(type)) {
    std::swap(image[1], image[2]);
  } else {
    std::swap(image[1], image[3]);
    if (corners == 8) std::swap(image[5], image[7]);
  }
  const std::vector<std::int32_t> before(nodes.begin(), nodes.end());
  for (int a = 0; a < corners; ++a) nodes[a] = before[image[a]];
  const auto sets = middle_nodes(type);
  for (std::size_t k = 0; k < sets.size(); ++k) {
    CornerSet turned = 0;
    for (int a = 0; a < corners; ++a) {
      if (sets[k] >> a & 1) turned |= static_cast<CornerSet>(1 << image[a]);
    }
    nodes[corners + k] = before[corners + (std::ranges::find(sets, turned) - sets.begin())];
  }
}

std::span<const int> linear_parts(CellType facet_type) {
  static constexpr int line2[] = {0, 1}, tri3[] = {0, 1, 2}, quad4[] = {0, 1, 2, 3};
  static constexpr int line3[] = {0, 2, 2, 1};
  static constexpr int tri6[] = {0, 3, 5, 3, 1, 4, 5, 4, 2, 3, 4, 5};
  static constexpr int quad8[] = {0, 4, 7, 4, 1, 5, 5, 2, 6, 6, 3, 7, 4, 5, 6, 4, 6, 7};
  static constexpr int quad9[] = {0, 4, 8, 7, 4, 1, 5, 8, 8, 5, 2, 6, 7, 8, 6, 3};
  switch (facet_type) {
    case CellType::line3:
      return line3;
    case CellType::tri6:
      return tri6;
    case CellType::quad8:
      return quad8;
    case CellType::quad9:
      return quad9;
    case CellType::line2:
      return line2;
    case CellType::tri3:
      return tri3;
    default:
      assert(facet_type == CellType::quad4);
      return quad4;
  }
}

int linear_part_nodes(CellType facet_type) {
  if (facet_type == CellType::quad8) return 3;
  return num_corners(facet_type);
}

template Vector<1> node_place(CellType, int);
template Vector<2> node_place(CellType, int);
template Vector<3> node_place(CellType, int);
template void shape_functions(CellType, const Vector<1>&, AnyShapeValues<1>&);
template void shape_functions(CellType, const Vector<2>&, AnyShapeValues<2>&);
template void shape_functions(CellType, const Vector<3>&, AnyShapeValues<3>&);

}  // namespace gabion
