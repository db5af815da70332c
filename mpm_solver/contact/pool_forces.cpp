// SPDX-License-Identifier: BSD-3-Clause
#include "mpm_solver/contact/pool_forces.hpp"

#include <algorithm>
#include <cmath>
#include <functional>

#include "mpm_solver/contact/surface_features.hpp"

namespace gabion::mpm {

namespace {

constexpr double tiny = 1e-300;

/// A part of a simplex: a segment or a convex polygon, by the weights of the simplex's corners.
template <int dim>
using Part = std::vector<std::array<double, dim>>;

template <int dim>
std::array<double, dim> between(const std::array<double, dim>& a, const std::array<double, dim>& b,
                                double s) {
  std::array<double, dim> result;
  for (int k = 0; k < dim; ++k) result[k] = (1 - s) * a[k] + s * b[k];
  return result;
}

// The share of a part where a function, linear in it, is not negative; nothing where it is nowhere
// positive.
template <int dim>
Part<dim> clip(const Part<dim>& part,
               const std::function<double(const std::array<double, dim>&)>& value) {
  Part<dim> left;
  bool positive = false;
  const std::size_t num_sides = dim == 2 ? part.size() - 1 : part.size();
  for (std::size_t k = 0; k < part.size(); ++k) {
    const auto &a = part[k], &b = part[(k + 1) % part.size()];
    const double f_a = value(a), f_b = value(b);
    positive |= f_a > 0;
    if (f_a >= 0) left.push_back(a);
    if (k < num_sides && f_a * f_b < 0) left.push_back(between<dim>(a, b, f_a / (f_a - f_b)));
  }
  return positive && left.size() >= dim ? left : Part<dim>();
}

// Add the integral of a linear function times the weights over a simplex inside of the whole one,
// whose size is 1: Simpson's rule, or that of the middles of the sides.
template <int dim>
void add_integral(const std::array<std::array<double, dim>, dim>& corners,
                  const std::function<double(const std::array<double, dim>&)>& value,
                  std::array<double, dim>& sums) {
  const auto add = [&](const std::array<double, dim>& at, double share) {
    const double f = value(at) * share;
    for (int k = 0; k < dim; ++k) sums[k] += f * at[k];
  };
  if constexpr (dim == 2) {
    const double size = std::abs(corners[1][0] - corners[0][0]);
    add(corners[0], size / 6);
    add(corners[1], size / 6);
    add(between<dim>(corners[0], corners[1], 0.5), 2 * size / 3);
  } else {
    const auto side = [&](int k, int d) { return corners[k][d] - corners[0][d]; };
    const double size = std::abs(side(1, 0) * side(2, 1) - side(1, 1) * side(2, 0));
    for (int k = 0; k < dim; ++k) {
      add(between<dim>(corners[k], corners[(k + 1) % dim], 0.5), size / 3);
    }
  }
}

}  // namespace

template <int dim>
std::array<double, dim> pool_pressure_on(const PoolLevels& pools,
                                         const std::array<Vector<dim>, dim>& corners) {
  const auto place = [&](const std::array<double, dim>& weights) {
    Vector<dim> x = Vector<dim>::Zero();
    for (int k = 0; k < dim; ++k) x += weights[k] * corners[k];
    return x;
  };
  const auto pressure = [&](const std::array<double, dim>& weights) {
    return pools.signed_pressure<dim>(place(weights));
  };
  Part<dim> whole(dim);
  for (int k = 0; k < dim; ++k) {
    whole[k] = {};
    whole[k][k] = 1;
  }
  std::vector<Part<dim>> parts = {whole};
  for (const double bend : pools.bends()) {
    std::vector<Part<dim>> split;
    for (const Part<dim>& part : parts) {
      for (const double sign : {-1.0, 1.0}) {
        auto piece = clip<dim>(part, [&](const auto& weights) {
          const double beyond = sign * (place(weights)[0] - bend);
          return beyond == 0 && sign < 0 ? tiny : beyond;  // a facet on the bend is in one part
        });
        if (!piece.empty()) split.push_back(std::move(piece));
      }
    }
    parts = std::move(split);
  }
  std::array<double, dim> sums{};
  for (const Part<dim>& part : parts) {
    const Part<dim> wet = clip<dim>(part, pressure);
    for (std::size_t k = 1; k + dim - 2 < wet.size(); ++k) {
      if constexpr (dim == 2) {
        add_integral<dim>({wet[0], wet[k]}, pressure, sums);
      } else {
        add_integral<dim>({wet[0], wet[k], wet[k + 1]}, pressure, sums);
      }
    }
  }
  double size = 0;
  if constexpr (dim == 2) {
    size = (corners[1] - corners[0]).norm();
  } else {
    size = 0.5 * (corners[1] - corners[0]).cross(corners[2] - corners[0]).norm();
  }
  for (double& sum : sums) sum *= size;
  return sums;
}

template <int dim>
std::vector<double> pool_forces(const PoolLevels& pools, const ContactSurface<dim>& surface,
                                std::span<const double> displacement) {
  std::vector<Vector<dim>> vertices = surface.vertices;
  for (std::size_t v = 0; v < vertices.size(); ++v) {
    vertices[v] += Eigen::Map<const Vector<dim>>(displacement.data() + v * dim);
  }
  std::vector<double> forces(vertices.size() * dim, 0.0);
  for (const Simplex<dim>& simplex : simplices(surface)) {
    const auto corners = corners_of<dim>(simplex, vertices);
    const Vector<dim> n = simplex_normal<dim>(corners);
    const auto sums = pool_pressure_on<dim>(pools, corners);
    for (int k = 0; k < dim; ++k) {
      Eigen::Map<Vector<dim>>(forces.data() + std::ptrdiff_t{simplex[k]} * dim) -= sums[k] * n;
    }
  }
  return forces;
}

template <int dim>
Vector<dim> pool_force_on_sides(const PoolLevels& pools, const BoxGrid<dim>& box,
                                std::span<const std::int32_t> facets) {
  constexpr std::size_t n = dim == 2 ? 2 : 4;
  Vector<dim> force = Vector<dim>::Zero();
  for (std::size_t first = 0; first + n <= facets.size(); first += n) {
    std::array<Vector<dim>, n> x;
    for (std::size_t k = 0; k < n; ++k) x[k] = box.node_position(facets[first + k]);
    double sum = 0;
    const auto add = [&](const std::array<Vector<dim>, dim>& corners) {
      for (const double part : pool_pressure_on<dim>(pools, corners)) sum += part;
    };
    if constexpr (dim == 2) {
      add({x[0], x[1]});
    } else {
      add({x[0], x[1], x[2]});
      add({x[0], x[2], x[3]});
    }
    for (int d = 0; d < dim; ++d) {
      const auto at = [&](const Vector<dim>& node) {
        return static_cast<int>(std::round(box.lattice_position(node)[d]));
      };
      for (const int end : {0, box.num_cells[d]}) {
        if (std::all_of(x.begin(), x.end(), [&](const auto& node) { return at(node) == end; })) {
          force[d] += end == 0 ? -sum : sum;
        }
      }
    }
  }
  return force;
}

template std::array<double, 2> pool_pressure_on<2>(const PoolLevels&,
                                                   const std::array<Vector<2>, 2>&);
template std::array<double, 3> pool_pressure_on<3>(const PoolLevels&,
                                                   const std::array<Vector<3>, 3>&);
template std::vector<double> pool_forces<2>(const PoolLevels&, const ContactSurface<2>&,
                                            std::span<const double>);
template std::vector<double> pool_forces<3>(const PoolLevels&, const ContactSurface<3>&,
                                            std::span<const double>);
template Vector<2> pool_force_on_sides<2>(const PoolLevels&, const BoxGrid<2>&,
                                          std::span<const std::int32_t>);
template Vector<3> pool_force_on_sides<3>(const PoolLevels&, const BoxGrid<3>&,
                                          std::span<const std::int32_t>);

}  // namespace gabion::mpm
