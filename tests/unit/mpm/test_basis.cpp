// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include <Eigen/Eigenvalues>
#include <Eigen/Geometry>
#include <map>
#include <set>

#include "mpm_solver/grid/axis_basis.hpp"
#include "mpm_solver/grid/box_basis.hpp"
#include "mpm_solver/grid/point_domains.hpp"
#include "tests/support/expect_error.hpp"
#include "tests/unit/mpm/soil_patch.hpp"

namespace gabion::test::test_basis {
namespace {

using mpm::AxisValues;
using mpm::Basis;

constexpr double round_off = 1e-13;

/// Values of one basis along an axis of `num_cells` cells, at any t.
struct Axis {
  Basis basis;
  int num_cells;
  double l;  ///< of gimp

  AxisValues at(double t) const { return at(t, std::clamp(static_cast<int>(t), 0, num_cells - 1)); }
  AxisValues at(double t, int cell) const {
    return basis == Basis::gimp ? mpm::gimp_values(t, l, cell, num_cells)
                                : mpm::bspline_values(t, cell, num_cells);
  }
  /// N or dN/dt of each node of the axis.
  std::vector<double> all(const AxisValues& values, const double* of_three) const {
    std::vector<double> result(num_cells + 1, 0.0);
    for (int i = 0; i < values.count; ++i) result.at(values.first + i) = of_three[i];
    return result;
  }
  std::vector<double> N(double t) const {
    const auto values = at(t);
    return all(values, values.N);
  }
};

template <class Check>
void for_each_axis(const Check& check) {
  for (const int num_cells : {1, 2, 3, 6}) {
    check(Axis{Basis::bspline, num_cells, 0});
    for (const double l : {1e-3, 0.25, 0.4, 0.5}) check(Axis{Basis::gimp, num_cells, l});
  }
}

double largest_difference(const std::vector<double>& a, const std::vector<double>& b) {
  double largest = 0;
  for (std::size_t i = 0; i < a.size(); ++i) largest = std::max(largest, std::abs(a[i] - b[i]));
  return largest;
}

TEST(AxisBasis, adds_up_to_one_and_reproduces_the_coordinate) {
  for_each_axis([](const Axis& axis) {
    for (int k = 0; k <= 60 * axis.num_cells; ++k) {
      const double t = k / 60.0;
      const AxisValues values = axis.at(t);
      double sum = 0, x = 0, d_sum = 0, slope = 0;
      for (int i = 0; i < values.count; ++i) {
        const int node = values.first + i;
        EXPECT_GE(node, 0);
        EXPECT_LE(node, axis.num_cells);
        EXPECT_GE(values.N[i], 0);
        sum += values.N[i];
        x += values.N[i] * node;
        d_sum += values.dN[i];
        slope += values.dN[i] * node;
      }
      EXPECT_NEAR(sum, 1, round_off);
      EXPECT_NEAR(x, t, round_off);
      EXPECT_NEAR(d_sum, 0, 1e-12);
      EXPECT_NEAR(slope, 1, 1e-12);
    }
  });
}

/// Central differences of quadratic pieces are exact but for rounding.
TEST(AxisBasis, derivatives_are_those_of_the_values) {
  const double step = 1e-4;
  for_each_axis([&](const Axis& axis) {
    for (int k = 0; k < 37 * axis.num_cells; ++k) {
      const double t = (k + 0.3) / 37;  // kinks at t = n / 2, n +- l are farther than a step
      const auto values = axis.at(t);
      const auto before = axis.N(t - step), after = axis.N(t + step);
      const auto slope = axis.all(values, values.dN);
      const bool at_kink = std::abs(std::remainder(t - axis.l, 1)) < step ||
                           std::abs(std::remainder(t + axis.l, 1)) < step;
      if (at_kink) continue;
      for (std::size_t i = 0; i < slope.size(); ++i) {
        EXPECT_NEAR(slope[i], (after[i] - before[i]) / (2 * step), 1e-9) << t;
      }
    }
  });
}

/// Both cells of a node give the same values and gradients there; so do both sides of the places
/// where a domain begins to reach into the next cell and where a spline begins.
TEST(AxisBasis, values_and_derivatives_are_continuous) {
  const double tiny = 1e-9;
  for_each_axis([&](const Axis& axis) {
    const double l = axis.l;
    const double steepest = axis.basis == Basis::gimp ? 1 / l : 2;
    for (int node = 0; node <= axis.num_cells; ++node) {
      for (const double t : {node + 0.0, node + 0.5, node + l, node - l}) {
        if (t < tiny || t > axis.num_cells - tiny) continue;
        const auto left = axis.at(t - tiny), right = axis.at(t + tiny);
        EXPECT_LT(largest_difference(axis.all(left, left.N), axis.all(right, right.N)), 4 * tiny);
        EXPECT_LT(largest_difference(axis.all(left, left.dN), axis.all(right, right.dN)),
                  4 * steepest * tiny);
      }
      if (node == 0 || node == axis.num_cells) continue;
      const auto left = axis.at(node, node - 1), right = axis.at(node, node);
      EXPECT_LT(largest_difference(axis.all(left, left.N), axis.all(right, right.N)), round_off);
      EXPECT_LT(largest_difference(axis.all(left, left.dN), axis.all(right, right.dN)), 1e-12);
    }
  });
}

/// Cells of the unit square, 0.25 wide, and a domain of 0.125.
TEST(BoxBasis, cells_of_a_domain_have_its_area_in_them) {
  const auto shares = [](const Vector<2>& x) {
    SoilPatch<2> soil(CellType::quad4, 4, Basis::gimp);
    soil.add(x);
    soil.points.half_length[0].setConstant(0.0625);
    EXPECT_TRUE(find_cells(soil.grid, soil.points).empty());
    std::map<std::int32_t, double> result;
    for (const auto& part : mpm::cells_of_domain(*soil.grid.box, soil.points, 0)) {
      EXPECT_EQ(result.count(part.cell), 0U);
      result[part.cell] = part.share;
    }
    return result;
  };
  const auto expect = [&](const Vector<2>& x, const std::map<std::int32_t, double>& exact) {
    const auto found = shares(x);
    ASSERT_EQ(found.size(), exact.size());
    for (const auto& [cell, share] : exact) EXPECT_NEAR(found.at(cell), share, round_off) << cell;
  };
  expect({0.375, 0.375}, {{5, 1.0}});
  expect({0.475, 0.375}, {{5, 0.7}, {6, 0.3}});
  expect({0.275, 0.475}, {{5, 0.49}, {4, 0.21}, {9, 0.21}, {8, 0.09}});
  expect({0.0625, 0.03}, {{0, 1.0}});  // cut at the sides of the grid
}

/// The definition: the mean of the hat function over the domain.
TEST(AxisBasis, gimp_is_the_mean_of_the_hat) {
  const auto integral = [](double r) {  // of the hat, from -1
    if (r <= -1) return 0.0;
    if (r >= 1) return 1.0;
    return r < 0 ? 0.5 * (1 + r) * (1 + r) : 1 - 0.5 * (1 - r) * (1 - r);
  };
  for (const double l : {0.1, 0.25, 0.5}) {
    const Axis axis{Basis::gimp, 5, l};
    for (double t = 0.5; t <= 4.5; t += 0.013) {
      const auto N = axis.N(t);
      for (int i = 0; i <= 5; ++i) {
        EXPECT_NEAR(N[i], (integral(t + l - i) - integral(t - l - i)) / (2 * l), 1e-14);
      }
    }
  }
}

/// A domain that ends on a node, or the edge of a spline, but for rounding: that node is left out.
TEST(AxisBasis, a_touch_within_rounding_is_none) {
  for (const double rounding : {0.0, 1e-15, -1e-15}) {
    for (const double t : {2.25, 2.75}) {
      EXPECT_EQ(mpm::gimp_values(t + rounding, 0.25, 2, 5).count, 2);
    }
    const Axis spline{Basis::bspline, 5, 0};
    EXPECT_EQ(spline.at(2.5 + rounding).count, 2);
    EXPECT_EQ(spline.at(2.5 + rounding).first, 2);
  }
}

/// Along the wall half a cell is linear: the wall's node carries the wall's value alone.
TEST(AxisBasis, is_linear_at_the_walls) {
  for_each_axis([](const Axis& axis) {
    const double reach = axis.basis == Basis::gimp ? axis.l : 0.5;
    for (const double t : {0.0, 0.3 * reach, 0.99 * reach}) {
      const auto low = axis.N(t), high = axis.N(axis.num_cells - t);
      EXPECT_NEAR(low[0], 1 - t, round_off);
      EXPECT_NEAR(low[1], t, round_off);
      EXPECT_NEAR(high[axis.num_cells], 1 - t, round_off);
      EXPECT_NEAR(high[axis.num_cells - 1], t, round_off);
    }
  });
}

TEST(Basis, reproduces_linear_fields_at_every_point) {
  for_each_basis([]<int dim>(CellType type, Basis basis) {
    SoilPatch<dim> soil(type, 3, basis);
    soil.scatter(200);
    soil.add(Vector<dim>::Zero());  // corners, a wall, a node
    soil.add(Vector<dim>::Ones());
    soil.add(0.4 * Vector<dim>::Unit(0));
    soil.add(Vector<dim>::Constant(1.0 / 3));
    soil.to_grid();
    std::vector<int> seen(soil.points.size(), 0);
    for (const auto& group : soil.weights.groups) {
      const auto nodes = soil.weights.nodes_of(group);
      for (std::int32_t e = group.first; e < group.last; ++e) {
        const std::int32_t p = soil.weights.point[e];
        ++seen[p];
        const auto* grad = soil.weights.grad_of(soil.weights.constant_gradient ? group.first : e);
        double sum = 0;
        Vector<dim> x = Vector<dim>::Zero();
        Matrix<dim> slope = Matrix<dim>::Zero();
        for (int i = 0; i < soil.weights.num_nodes(e); ++i) {
          const double N = soil.weights.N_of(e)[i];
          const auto& node = soil.mesh.nodes[nodes[soil.weights.local_of(e)[i]]];
          EXPECT_GE(N, -1e-11);
          sum += N;
          x += N * node;
          slope += node * grad[i].transpose();
        }
        EXPECT_NEAR(sum, 1, round_off);
        EXPECT_LT((x - soil.points.x[p]).norm(), round_off);
        EXPECT_LT((slope - Matrix<dim>::Identity()).norm(), 1e-12);
      }
    }
    EXPECT_EQ(seen, std::vector<int>(soil.points.size(), 1));
  });
}

/// N of all grid nodes at the only point of the patch.
template <int dim>
std::map<std::int32_t, double> values_at(SoilPatch<dim>& soil, const Vector<dim>& x) {
  soil.points.x[0] = x;
  soil.to_grid();
  std::map<std::int32_t, double> values;
  const auto nodes = soil.weights.nodes_of(soil.weights.groups.at(0));
  for (int i = 0; i < soil.weights.num_nodes(0); ++i) {
    values[nodes[soil.weights.local_of(0)[i]]] = soil.weights.N_of(0)[i];
  }
  return values;
}

TEST(Basis, gradients_are_the_derivatives_of_the_values) {
  for_each_basis([]<int dim>(CellType type, Basis basis) {
    SoilPatch<dim> soil(type, 4, basis);
    soil.add(Vector<dim>::Zero());
    const double step = 1e-5;
    for (int k = 0; k < 40; ++k) {
      Vector<dim> x = 0.5 * (Vector<dim>::Ones() + 0.99 * soil.random.template vector<dim>());
      if (k == 0) x *= 0.02;    // a corner of the grid
      if (k == 1) x[0] = 0.01;  // a wall
      values_at(soil, x);
      const auto nodes = soil.weights.nodes_of(soil.weights.groups.at(0));
      std::map<std::int32_t, Vector<dim>> grad;
      for (int i = 0; i < soil.weights.num_nodes(0); ++i) {
        grad[nodes[soil.weights.local_of(0)[i]]] = soil.weights.grad_of(0)[i];
      }
      for (int d = 0; d < dim; ++d) {
        auto after = values_at<dim>(soil, x + step * Vector<dim>::Unit(d));
        auto before = values_at<dim>(soil, x - step * Vector<dim>::Unit(d));
        for (const auto& [node, slope] : grad) {
          EXPECT_NEAR(slope[d], (after[node] - before[node]) / (2 * step), 1e-7) << x.transpose();
        }
      }
    }
  });
}

/// Boundary points of a structure use the corners of their cell.
TEST(Basis, all_corners_of_an_occupied_cell_are_active) {
  for_each_basis([]<int dim>(CellType type, Basis basis) {
    SoilPatch<dim> soil(type, 3, basis);
    soil.scatter(1);
    for (const double first : {0.0, 1e-9, 1.0 / 6, 1.0 / 3, 0.5, 1.0}) {
      for (const double second : {0.0, 1.0 / 6, 2.0 / 3, 0.9}) {
        soil.points.x[0].setConstant(0.5);
        soil.points.x[0][0] = first;
        soil.points.x[0][1] = second;
        soil.to_grid();
        for (const std::int32_t node : soil.mesh.cell(soil.points.cell[0])) {
          EXPECT_GE(soil.nodes.active[node], 0) << name(type) << soil.points.x[0].transpose();
        }
      }
    }
  });
}

TEST(Basis, number_of_nodes_a_point) {
  const auto count = []<int dim>(CellType type, Basis basis, double x) {
    SoilPatch<dim> soil(type, 4, basis);
    soil.add(Vector<dim>::Constant(x));
    if (basis == Basis::gimp) soil.points.half_length[0].setConstant(0.25 * 0.25);
    soil.to_grid();
    EXPECT_EQ(soil.weights.num_nodes(0), soil.nodes.size());
    return soil.weights.num_nodes(0);
  };
  EXPECT_EQ(count.operator()<2>(CellType::quad4, Basis::bspline, 0.3), 9);
  EXPECT_EQ(count.operator()<3>(CellType::hex8, Basis::bspline, 0.3), 27);
  EXPECT_EQ(count.operator()<2>(CellType::quad4, Basis::bspline, 0.375), 4);  // third one is 0
  EXPECT_EQ(count.operator()<2>(CellType::quad4, Basis::bspline, 0.1), 4);    // linear at the wall
  EXPECT_EQ(count.operator()<2>(CellType::quad4, Basis::gimp, 0.3), 9);
  EXPECT_EQ(count.operator()<3>(CellType::hex8, Basis::gimp, 0.3), 27);
  EXPECT_EQ(count.operator()<2>(CellType::quad4, Basis::gimp, 0.35), 4);  // inside its cell
}

TEST(Basis, other_than_linear_needs_cells_in_rows) {
  const std::vector<std::string_view> parts = {"a basis other than linear", "equal cells in rows"};
  const auto triangles = unit_box<2>(CellType::tri3, 2);
  expect_error<Error>([&] { mpm::BackgroundGrid<2>(triangles, Basis::gimp); }, parts);
  auto moved = unit_box<2>(CellType::quad4, 2);
  moved.nodes[4][0] += 0.01;
  expect_error<Error>([&] { mpm::BackgroundGrid<2>(moved, Basis::bspline); }, parts);
}

TEST(PointDomains, fill_a_body_of_bricks) {
  const Mesh<2> plane = box_mesh<2>({1, 2}, {3, 3}, {4, 5}, CellType::quad4);
  mpm::MaterialPoints<2> points;
  mpm::lay_points<2>({.mesh = plane,
                      .points_per_cell = 9,
                      .placement = PointPlacement::regular,
                      .with_domains = true},
                     1, {}, points);
  std::set<std::pair<int, int>> places;  // in a lattice of domains
  for (std::int32_t p = 0; p < points.size(); ++p) {
    EXPECT_LT((points.half_length[p] - Vector<2>(0.5 / 6, 0.2 / 6)).norm(), 1e-15);
    EXPECT_NEAR(4 * points.half_length[p].prod(), points.V0[p], 1e-16);
    const Vector<2> at = (points.x[p] - Vector<2>(1, 2)).cwiseQuotient(2 * points.half_length[p]);
    places.insert({static_cast<int>(at[0]), static_cast<int>(at[1])});
    EXPECT_NEAR(at[0] - std::floor(at[0]), 0.5, 1e-12);
    EXPECT_NEAR(at[1] - std::floor(at[1]), 0.5, 1e-12);
  }
  EXPECT_EQ(places.size(), 12u * 15u);
}

TEST(PointDomains, have_the_volume_of_the_point_in_any_cell) {
  for_each_cell_type([]<int dim>(CellType type) {
    Mesh<dim> mesh = unit_box<dim>(type, 2);
    for (auto& x : mesh.nodes) x[0] = 3 * x[0] + 0.4 * x[1];
    mpm::MaterialPoints<dim> points;
    mpm::lay_points<dim>({.mesh = mesh, .with_domains = true}, 1, {}, points);
    for (std::int32_t p = 0; p < points.size(); ++p) {
      EXPECT_NEAR((2 * points.half_length[p]).prod(), points.V0[p], 1e-15);
    }
  });
}

/// Soil between two surfaces: columns whose bottom and top follow them.
template <int dim, class Bottom, class Top>
Mesh<dim> columns(const Eigen::Matrix<int, dim, 1>& cells, const Bottom& bottom, const Top& top) {
  const CellType brick = dim == 2 ? CellType::quad4 : CellType::hex8;
  Mesh<dim> mesh = box_mesh<dim>(Vector<dim>::Zero(), Vector<dim>::Ones(), cells, brick);
  for (auto& x : mesh.nodes) {
    const double low = bottom(x), height = top(x) - low;
    x[dim - 1] = low + x[dim - 1] * height;
  }
  return mesh;
}

template <int dim>
mpm::MaterialPoints<dim> points_of(const Mesh<dim>& mesh) {
  mpm::MaterialPoints<dim> points;
  mpm::lay_points<dim>({.mesh = mesh,
                        .points_per_cell = 1 << dim,
                        .placement = PointPlacement::regular,
                        .with_domains = true},
                       1, {}, points);
  return points;
}

/// A column stands on an inclined plane: contact spheres touch it, domains are as wide as the
/// column.
TEST(PointDomains, fill_columns_on_an_inclined_plane) {
  const Vector<3> slope(0.7, -0.4, 0);
  const auto bottom = [&](const Vector<3>& x) { return slope.dot(x); };
  const auto top = [&](const Vector<3>& x) { return slope.dot(x) + 0.4; };
  const auto mesh = columns<3>({4, 5, 2}, bottom, top);
  EXPECT_TRUE(mpm::has_columns<3>(mesh));
  const auto points = points_of<3>(mesh);
  double volume = 0;
  for (std::int32_t p = 0; p < points.size(); ++p) {
    EXPECT_LT((points.half_length[p] - Vector<3>(1. / 16, 1. / 20, 0.05)).norm(), 1e-14);
    volume += points.V0[p];
    const double above = points.x[p][2] - bottom(points.x[p]);
    if (above > 0.1) continue;
    EXPECT_NEAR(points.depth[p], above / std::sqrt(1 + slope.squaredNorm()), 1e-14);
  }
  EXPECT_NEAR(volume, 0.4, 1e-13);
}

/// A contact sphere on a warped bottom touches the plane that is tangent to it below the point.
TEST(PointDomains, balls_touch_a_warped_surface) {
  const auto bottom = [](const Vector<3>& x) { return 0.3 * x[0] * x[1]; };
  constexpr int n = 8;
  const auto mesh =
      columns<3>({n, n, 1}, bottom, [&](const Vector<3>& x) { return bottom(x) + 0.5 / n; });
  const auto points = points_of<3>(mesh);
  int touching = 0;
  for (std::int32_t p = 0; p < points.size(); ++p) {
    const Vector<3>& x = points.x[p];
    const double above = x[2] - bottom(x);
    if (above > 0.2 / n) continue;
    ++touching;
    EXPECT_NEAR(points.depth[p], above / std::hypot(1, 0.3 * x[0], 0.3 * x[1]), 1e-15);
  }
  EXPECT_EQ(touching, 4 * n * n);
}

/// Volume between a plane and a dome, 1 + sin sin: exact 1 + 4 / pi^2, order 2.
TEST(PointDomains, volume_between_two_surfaces) {
  std::vector<double> errors;
  for (const int n : {4, 8, 16}) {
    const auto mesh = columns<3>(
        {n, n, 2}, [](const Vector<3>& x) { return 0.5 * x[0]; },
        [](const Vector<3>& x) {
          return 0.5 * x[0] + 1 + std::sin(M_PI * x[0]) * std::sin(M_PI * x[1]);
        });
    const auto points = points_of<3>(mesh);
    const double volume = std::accumulate(points.V0.begin(), points.V0.end(), 0.0);
    errors.push_back(std::abs(volume - 1 - 4 / (M_PI * M_PI)));
  }
  EXPECT_GT(std::log2(errors[0] / errors[1]), 1.9);
  EXPECT_GT(std::log2(errors[1] / errors[2]), 1.9);
}

TEST(PointDomains, other_cells_are_no_columns) {
  EXPECT_TRUE(mpm::has_columns<2>(unit_box<2>(CellType::quad4, 3)));
  EXPECT_FALSE(mpm::has_columns<2>(unit_box<2>(CellType::tri3, 3)));
  EXPECT_FALSE(mpm::has_columns<3>(unit_box<3>(CellType::tet4, 2)));
  auto moved = unit_box<3>(CellType::hex8, 2);
  moved.nodes[13] += Vector<3>(0.1, 0.05, 0);
  EXPECT_FALSE(mpm::has_columns<3>(moved));
  auto turned = unit_box<2>(CellType::quad4, 2);
  for (auto& x : turned.nodes) x = Vector<2>(x[0] - 0.2 * x[1], x[1] + 0.2 * x[0]);
  EXPECT_FALSE(mpm::has_columns<2>(turned));
}

template <int dim>
Matrix<dim> rotation(double angle) {
  Matrix<dim> R = Matrix<dim>::Identity();
  if constexpr (dim == 2) {
    R = Eigen::Rotation2Dd(angle).toRotationMatrix();
  } else {
    R = Eigen::AngleAxisd(angle, Vector<3>(1, -2, 0.5).normalized()).toRotationMatrix();
  }
  return R;
}

template <int dim>
void check_stretches() {
  Random random;
  const Vector<dim> none = Vector<dim>::Ones();
  EXPECT_LT((mpm::axis_stretches<dim>(rotation<dim>(2.1)) - none).norm(), 1e-14);
  for (int k = 0; k < 20; ++k) {
    Matrix<dim> A;
    for (int d = 0; d < dim; ++d) A.col(d) = 0.4 * random.vector<dim>();
    const Matrix<dim> U = Matrix<dim>::Identity() + A * A.transpose();  // any stretch > 0
    const Vector<dim> found = mpm::axis_stretches<dim>(rotation<dim>(k) * U);
    EXPECT_LT((found - U.diagonal()).norm(), 1e-14 * U.norm());
  }
}

TEST(PointDomains, stretch_by_the_right_stretch_tensor) {
  check_stretches<2>();
  check_stretches<3>();
}

/// Two steps with linear displacements: domains have the volume of the product of their gradients.
TEST(PointDomains, follow_the_volume) {
  SoilPatch<3> soil(CellType::hex8, 3, Basis::gimp);
  soil.scatter(5);
  const auto before = soil.points.half_length;
  Matrix<3> expected = Matrix<3>::Identity();
  for (int step = 0; step < 2; ++step) {
    soil.to_grid();
    Matrix<3> H;
    for (int d = 0; d < 3; ++d) H.col(d) = 0.2 * soil.random.vector<3>();
    std::vector<double> du;
    for (std::int32_t i = 0; i < soil.nodes.size(); ++i) {
      const Vector<3> u = H * soil.node(i);
      du.insert(du.end(), u.data(), u.data() + 3);
    }
    mpm::deform_points<3>(soil.nodes, du, soil.weights, soil.points);
    expected = (Matrix<3>::Identity() + H) * expected;
  }
  for (std::int32_t p = 0; p < soil.points.size(); ++p) {
    EXPECT_NEAR(soil.points.half_length[p].prod() / before[p].prod(), expected.determinant(),
                1e-13);
  }
}

/// Linear displacements H x in `steps` steps of equal gradient; l / l_0 of a point.
Vector<2> stretched(const Matrix<2>& H, int steps) {
  SoilPatch<2> soil(CellType::quad4, 3, Basis::gimp);
  soil.add({0.45, 0.55});
  const Vector<2> before = soil.points.half_length[0];
  soil.to_grid();
  std::vector<double> du;
  for (std::int32_t i = 0; i < soil.nodes.size(); ++i) {
    const Vector<2> u = H * soil.node(i);
    du.insert(du.end(), u.data(), u.data() + 2);
  }
  for (int n = 0; n < steps; ++n) {
    mpm::deform_points<2>(soil.nodes, du, soil.weights, soil.points);
  }
  return soil.points.half_length[0].cwiseQuotient(before);
}

TEST(PointDomains, are_stretched_along_the_axes_but_not_by_shear_and_turns) {
  const Vector<2> squeezed = stretched((Matrix<2>() << 0.02, 0, 0, -0.01).finished(), 50);
  EXPECT_NEAR(squeezed[0], std::pow(1.02, 50), 1e-12);
  EXPECT_NEAR(squeezed[1], std::pow(0.99, 50), 1e-12);
  const Vector<2> sheared = stretched((Matrix<2>() << 0, 0.01, 0, 0).finished(), 300);
  EXPECT_LT((sheared - Vector<2>::Ones()).norm(), 300 * 0.01 * 0.01);
  const Vector<2> turned = stretched(rotation<2>(0.1) - Matrix<2>::Identity(), 40);
  EXPECT_LT((turned - Vector<2>::Ones()).norm(), 1e-12);
}

/// A wider domain reaches farther; beyond a cell it is cut and counted.
TEST(PointDomains, are_cut_to_a_cell_and_counted) {
  SoilPatch<2> soil(CellType::quad4, 4, Basis::gimp);
  soil.add({0.5, 0.5});
  const double h = 0.25;
  soil.points.half_length[0] = {0.45 * h, 0.3 * h};
  soil.to_grid();
  EXPECT_EQ(soil.weights.num_capped, 0);
  const auto weight_beside = [&] {  // of the node one cell to the right
    double sum = 0;
    const auto nodes = soil.weights.nodes_of(soil.weights.groups[0]);
    for (int i = 0; i < soil.weights.num_nodes(0); ++i) {
      const auto& x = soil.mesh.nodes[nodes[soil.weights.local_of(0)[i]]];
      if (x[0] > 0.7) sum += soil.weights.N_of(0)[i];
    }
    return sum;
  };
  EXPECT_NEAR(weight_beside(), 0.45 / 4, 1e-14);  // l / 4 on a node
  soil.points.half_length[0][0] = 0.6 * h;
  soil.to_grid();
  EXPECT_EQ(soil.weights.num_capped, 1);
  EXPECT_NEAR(weight_beside(), 0.5 / 4, 1e-14);
}

}  // namespace
}  // namespace gabion::test::test_basis
