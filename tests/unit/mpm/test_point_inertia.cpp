// SPDX-License-Identifier: BSD-3-Clause
#include "mpm_solver/grid/point_inertia.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>

#include "mpm_solver/grid/transfer.hpp"
#include "mpm_solver/step/stable_step.hpp"
#include "tests/support/mpi_main.hpp"

namespace gabion::test::test_point_inertia {
namespace {

using mpm::BackgroundGrid;
using mpm::Basis;

template <int dim>
Mesh<dim> box_of(int cells, CellType type, double length = 1) {
  return box_mesh<dim>(Vector<dim>::Zero(), length * Vector<dim>::Ones(),
                       Eigen::Matrix<int, dim, 1>::Constant(cells), type);
}

/// Points at random places of a grid, a few of them on lines between its cells.
template <int dim>
struct RandomPoints {
  BackgroundGrid<dim> grid;
  mpm::MaterialPoints<dim> points;
  mpm::PointWeights<dim> weights;
  mpm::GridNodes<dim> nodes;
  std::mt19937 random{3};

  RandomPoints(CellType type, Basis basis) : grid(box_of<dim>(4, type), basis) {
    mpm::lay_points<dim>({.mesh = box_of<dim>(2, type, 0.625),
                          .points_per_cell = type == CellType::tri3 ? 3 : 1 << dim,
                          .with_domains = basis == Basis::gimp},
                         1000, {}, points);
    for (auto& x : points.x) {
      for (int d = 0; d < dim; ++d) x[d] += 0.3 * any();
    }
    for (int p = 0; p < 3; ++p) points.x[p][0] = 0.25;
    points.x[0] = Vector<dim>::Constant(0.999999999);
    for (auto& v : points.v) v = vector();
    EXPECT_TRUE(mpm::find_cells(grid, points).empty());
    mpm::evaluate_basis(grid, points, weights);
    mpm::activate_nodes<dim>(comm(), grid, weights, {}, nodes);
    mpm::points_to_grid(points, weights, nodes);
  }

  double any() { return std::uniform_real_distribution<double>(0, 1)(random); }
  Vector<dim> vector() {
    Vector<dim> v;
    for (int d = 0; d < dim; ++d) v[d] = any() - 0.5;
    return v;
  }
  std::vector<double> field() {
    std::vector<double> f;
    for (std::int32_t i = 0; i < nodes.size() * dim; ++i) f.push_back(any() - 0.5);
    return f;
  }
};

double dot(const std::vector<double>& a, const std::vector<double>& b) {
  double sum = 0;
  for (std::size_t k = 0; k < a.size(); ++k) sum += a[k] * b[k];
  return sum;
}

template <int dim>
void check_inertia(CellType type, Basis basis) {
  SCOPED_TRACE(std::string(mpm::basis_name(basis)) + " " + name(type));
  RandomPoints<dim> soil(type, basis);
  const mpm::PointInertia<dim> inertia(soil.points, soil.weights, soil.nodes);
  const auto apply = [&](const std::vector<double>& I) {
    std::vector<double> dv(I.size());
    inertia.apply(I, dv);
    return dv;
  };
  const auto a = soil.field(), b = soil.field();
  const auto W_a = apply(a), W_b = apply(b);
  EXPECT_NEAR(dot(a, W_b), dot(b, W_a), 1e-13 * std::abs(dot(a, W_a)));

  // W as rows.
  const std::int32_t n = soil.nodes.size();
  std::vector<std::int32_t> starts(1, 0), columns;
  for (std::int32_t i = 0; i < n; ++i) {
    for (std::int32_t k = 0; k < n; ++k) columns.push_back(k);
    starts.push_back((i + 1) * n);
  }
  std::vector<double> W(columns.size(), 0.0);
  inertia.add_rows(starts, columns, W);
  double largest = 0;
  for (const double value : W_a) largest = std::max(largest, std::abs(value));
  for (std::int32_t i = 0; i < n * dim; ++i) {
    double row = 0;
    for (std::int32_t k = 0; k < n; ++k) row += W[i / dim * n + k] * a[k * dim + i % dim];
    EXPECT_NEAR(row, W_a[i], 1e-13 * largest);
  }

  // An impulse gives momentum I and, with that of the start, the energy I . (v + W I / 2).
  auto motion = mpm::NodalMotion<dim>{soil.nodes.v, soil.nodes.v, soil.nodes.v};
  double lumped = 0;
  bool any_weightless = false;
  std::vector<double> v;
  Vector<dim> sum = Vector<dim>::Zero();
  for (std::int32_t i = 0; i < soil.nodes.size(); ++i) {
    const Eigen::Map<const Vector<dim>> I(&a[i * dim]);
    v.insert(v.end(), soil.nodes.v[i].begin(), soil.nodes.v[i].end());
    sum += I;
    if (inertia.is_weightless(i)) {
      any_weightless = true;
      continue;
    }
    motion.v_new[i] += I / soil.nodes.m[i];
    lumped += I.squaredNorm() / soil.nodes.m[i];
  }
  if (!any_weightless) {
    EXPECT_LE(dot(a, W_a), lumped);
  }
  const auto before = soil.points;
  mpm::grid_to_points(soil.nodes, motion, soil.weights, 0, soil.points);
  inertia.kick_from_weightless(a, 1, soil.points);
  double energy = 0, size = 0;
  for (std::int32_t p = 0; p < before.size(); ++p) {
    const double m = before.m[p];
    energy += 0.5 * m * (soil.points.v[p].squaredNorm() - before.v[p].squaredNorm());
    sum -= m * (soil.points.v[p] - before.v[p]);
    size += m;
  }
  EXPECT_LT(sum.norm(), 1e-12);
  EXPECT_GT(size, 1);
  // A node without weight has the mean velocity of its points, not the one by rho.
  if (!any_weightless) {
    EXPECT_NEAR(energy, dot(a, v) + 0.5 * dot(a, W_a), 1e-12 * (std::abs(energy) + dot(a, W_a)));
  }
}

TEST(PointInertia, gives_momentum_and_energy_to_the_points) {
  check_inertia<2>(CellType::tri3, Basis::linear);
  for (const Basis basis : {Basis::linear, Basis::gimp, Basis::bspline}) {
    check_inertia<2>(CellType::quad4, basis);
    check_inertia<3>(CellType::hex8, basis);
  }
}

/// Springs k (w . u)^2 / 2 along x: the bound lies above the highest frequency, by power iteration.
TEST(PointInertia, row_sums_bound_the_highest_frequency) {
  RandomPoints<2> soil(CellType::quad4, Basis::linear);
  const mpm::PointInertia<2> inertia(soil.points, soil.weights, soil.nodes);
  const auto n = static_cast<std::size_t>(soil.nodes.size());
  std::vector<std::vector<double>> springs;
  for (int s = 0; s < 12; ++s) {
    std::vector<double> w(2 * n, 0.0);
    for (int k = 0; k < 4; ++k)
      w[2 * static_cast<std::size_t>(soil.any() * double(n))] = soil.any();
    springs.push_back(w);
  }
  std::vector<double> row_sums(n, 0.0);
  for (const auto& w : springs) {
    double all = 0;
    for (const double each : w) all += std::abs(each);
    for (std::size_t i = 0; i < n; ++i) row_sums[i] += std::abs(w[2 * i]) * all;
  }
  std::vector<double> u = soil.field(), f(2 * n);
  double rate = 0;
  for (int k = 0; k < 300; ++k) {
    std::fill(f.begin(), f.end(), 0.0);
    for (const auto& w : springs) {
      const double stretch = dot(w, u);
      for (std::size_t i = 0; i < f.size(); ++i) f[i] += stretch * w[i];
    }
    inertia.apply(f, u);
    rate = std::sqrt(dot(u, u));
    for (double& each : u) each /= rate;
  }
  const double bound = inertia.largest_rate(row_sums);
  EXPECT_LE(rate, bound);
  EXPECT_GT(rate, 0.1 * bound);
}

TEST(StableStep, effective_size_of_cells) {
  const auto in_plane = [](CellType type) {
    return mpm::effective_size(BackgroundGrid<2>(box_mesh<2>({0, 0}, {0.6, 0.2}, {2, 1}, type)), 0);
  };
  EXPECT_NEAR(in_plane(CellType::quad4), 0.2, 1e-15);
  EXPECT_NEAR(mpm::effective_size(BackgroundGrid<2>(box_of<2>(4, CellType::tri3)), 0),
              2. / 3 * 0.25, 1e-15);
  EXPECT_NEAR(mpm::effective_size(BackgroundGrid<3>(box_of<3>(4, CellType::hex8)), 0), 0.25, 1e-15);
}

}  // namespace
}  // namespace gabion::test::test_point_inertia
