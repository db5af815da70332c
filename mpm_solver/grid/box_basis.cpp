// SPDX-License-Identifier: BSD-3-Clause
#include "mpm_solver/grid/box_basis.hpp"

#include <algorithm>
#include <utility>

#include "common/base/reserve.hpp"
#include "mpm_solver/grid/axis_basis.hpp"

namespace gabion::mpm {

namespace {

constexpr double widest_domain = 0.5;  // half length by the spacing
constexpr double rounding = 1e-12;     // a domain as wide as a cell is not cut
constexpr int unused = 255;

// The nodes of a cell and those one step around it, of which at most max_group_nodes act.
template <int dim>
struct Neighbourhood {
  typename BoxGrid<dim>::Index corner;  // lattice place of number 0; may lie outside the grid
  std::uint8_t local[max_group_nodes<dim>];

  explicit Neighbourhood(const typename BoxGrid<dim>::Index& cell)
      : corner(cell - BoxGrid<dim>::Index::Ones()) {
    std::fill(std::begin(local), std::end(local), std::uint8_t{unused});
  }
};

// Destinations of the values of a point.
template <int dim>
struct ValuePlace {
  std::uint8_t* local;  // gets numbers in the neighbourhood
  double* N;
  Vector<dim>* grad;
};

// The products of the values along the axes. @returns their number
template <int dim>
int set_products(const AxisValues* axes, const Vector<dim>& spacing, Neighbourhood<dim>& around,
                 const ValuePlace<dim>& to) {
  double slopes[dim][3];
  for (int d = 0; d < dim; ++d) {
    for (int a = 0; a < 3; ++a) slopes[d][a] = axes[d].dN[a] / spacing[d];
  }
  int first = 0;  // number in the neighbourhood
  for (int d = dim - 1; d >= 0; --d) first = 4 * first + axes[d].first - around.corner[d];
  const auto &x = axes[0], &y = axes[1];
  int n = 0;
  for (int k = 0; k < (dim == 3 ? axes[dim - 1].count : 1); ++k) {
    const double Nz = dim == 3 ? axes[dim - 1].N[k] : 1;
    for (int j = 0; j < y.count; ++j) {
      const double Nzy = Nz * y.N[j];
      for (int i = 0; i < x.count; ++i, ++n) {
        to.N[n] = Nzy * x.N[i];
        Vector<dim>& grad = to.grad[n];
        grad[0] = slopes[0][i] * y.N[j] * Nz;
        grad[1] = slopes[1][j] * x.N[i] * Nz;
        if constexpr (dim == 3) grad[2] = slopes[2][k] * x.N[i] * y.N[j];
        const int number = first + i + 4 * j + 16 * k;
        around.local[number] = 0;
        to.local[n] = static_cast<std::uint8_t>(number);
      }
    }
  }
  return n;
}

// Number the nodes that act on the group and list them.
template <int dim>
void number_nodes(const BoxGrid<dim>& box, Neighbourhood<dim>& around, CellGroup& group,
                  PointWeights<dim>& weights) {
  group.first_node = static_cast<std::int32_t>(weights.group_nodes.size());
  group.num_nodes = 0;
  for (int number = 0; number < max_group_nodes<dim>; ++number) {
    if (around.local[number] == unused) continue;
    around.local[number] = static_cast<std::uint8_t>(group.num_nodes++);
    typename BoxGrid<dim>::Index at = around.corner;
    for (int d = 0, rest = number; d < dim; ++d, rest /= 4) at[d] += rest % 4;
    weights.group_nodes.push_back(box.node(at));
  }
  for (std::int32_t k = weights.starts[group.first]; k < weights.starts[group.last]; ++k) {
    weights.local[k] = around.local[weights.local[k]];
  }
}

// An empty list with room for some more than it had: one that grows later has its old and its new
// memory at once.
template <class Value>
void begin_again(std::vector<Value>& values) {
  const std::size_t likely = values.size() + values.size() / 32;
  values.clear();
  if (likely <= values.capacity()) return;
  values = {};
  reserve_tightly(values, likely);
}

// Room for the values of a group behind the `used` ones: three nodes along each axis act on a
// point.
template <int dim>
void make_room(const CellGroup& group, std::size_t used, PointWeights<dim>& weights) {
  constexpr std::size_t most_nodes = dim == 2 ? 9 : 27;
  const std::size_t size = used + most_nodes * (group.last - group.first);
  const auto extend = [size](auto& values) {
    reserve_tightly(values, size);
    values.resize(size);
  };
  extend(weights.local);
  extend(weights.N);
  extend(weights.grad_N);
}

}  // namespace

template <int dim>
Vector<dim> gimp_domain(const BoxGrid<dim>& box, const MaterialPoints<dim>& points,
                        std::int32_t p) {
  return points.half_length[p].cwiseQuotient(box.spacing).cwiseMin(widest_domain);
}

template <int dim>
std::vector<DomainPart> cells_of_domain(const BoxGrid<dim>& box, const MaterialPoints<dim>& points,
                                        std::int32_t p) {
  const auto cell = box.cell_index(points.cell[p]);
  const Vector<dim> t = box.lattice_position(points.x[p]);
  const Vector<dim> domain = gimp_domain(box, points, p);
  std::vector<DomainPart> parts = {{points.cell[p], 1}};
  std::int32_t stride = 1;
  for (int d = 0; d < dim; ++d) {
    const double l = gimp_half_length(t[d], domain[d], box.num_cells[d]);
    const double before = cell[d] - (t[d] - l), after = t[d] + l - (cell[d] + 1);
    const std::size_t count = parts.size();
    for (const auto& [beyond, step] : {std::pair{before, -stride}, std::pair{after, stride}}) {
      if (beyond <= reach_by_rounding) continue;
      for (std::size_t k = 0; k < count; ++k) {
        parts.push_back({parts[k].cell + step, parts[k].share * beyond / (2 * l)});
      }
    }
    const double inside = 1 - (std::max(before, 0.0) + std::max(after, 0.0)) / (2 * l);
    for (std::size_t k = 0; k < count; ++k) parts[k].share *= inside;
    stride *= box.num_cells[d];
  }
  return parts;
}

template <int dim>
void evaluate_box_basis(const BackgroundGrid<dim>& grid, const MaterialPoints<dim>& points,
                        PointWeights<dim>& weights) {
  const BoxGrid<dim>& box = *grid.box;
  weights.constant_gradient = false;
  weights.whole_cells = false;
  weights.num_capped = 0;
  weights.starts.assign(1, 0);
  begin_again(weights.local);
  begin_again(weights.N);
  begin_again(weights.grad_N);
  weights.group_nodes.clear();
  std::size_t used = 0;  // number of values
  for (CellGroup& group : weights.groups) {
    const auto cell = box.cell_index(group.cell);
    Neighbourhood<dim> around(cell);
    make_room(group, used, weights);
    for (std::int32_t e = group.first; e < group.last; ++e) {
      const std::int32_t p = weights.point[e];
      const Vector<dim> t = box.lattice_position(points.x[p]);
      AxisValues axes[dim];
      if (grid.basis == Basis::gimp) {
        const Vector<dim> l = points.half_length[p].cwiseQuotient(box.spacing);
        weights.num_capped += l.maxCoeff() > widest_domain * (1 + rounding);
        for (int d = 0; d < dim; ++d)
          axes[d] = gimp_values(t[d], std::min(l[d], widest_domain), cell[d], box.num_cells[d]);
      } else {
        for (int d = 0; d < dim; ++d) axes[d] = bspline_values(t[d], cell[d], box.num_cells[d]);
      }
      used += set_products<dim>(axes, box.spacing, around,
                                {&weights.local[used], &weights.N[used], &weights.grad_N[used]});
      weights.starts.push_back(static_cast<std::int32_t>(used));
    }
    number_nodes(box, around, group, weights);
  }
  weights.local.resize(used);
  weights.N.resize(used);
  weights.grad_N.resize(used);
}

template Vector<2> gimp_domain<2>(const BoxGrid<2>&, const MaterialPoints<2>&, std::int32_t);
template Vector<3> gimp_domain<3>(const BoxGrid<3>&, const MaterialPoints<3>&, std::int32_t);
template std::vector<DomainPart> cells_of_domain<2>(const BoxGrid<2>&, const MaterialPoints<2>&,
                                                    std::int32_t);
template std::vector<DomainPart> cells_of_domain<3>(const BoxGrid<3>&, const MaterialPoints<3>&,
                                                    std::int32_t);
template void evaluate_box_basis<2>(const BackgroundGrid<2>&, const MaterialPoints<2>&,
                                    PointWeights<2>&);
template void evaluate_box_basis<3>(const BackgroundGrid<3>&, const MaterialPoints<3>&,
                                    PointWeights<3>&);

}  // namespace gabion::mpm
