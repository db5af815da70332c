// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include <cmath>

#include "common/mechanics/elements/cell_facets.hpp"
#include "tests/unit/elements/reference_cells.hpp"

namespace gabion::test_shape_functions {
namespace {

using test::reference_nodes;
using test::sample_points;

template <class Check>
void for_each_cell_type(Check check) {
  check.template operator()<2>(CellType::tri3);
  check.template operator()<2>(CellType::quad4);
  check.template operator()<3>(CellType::tet4);
  check.template operator()<3>(CellType::hex8);
}

TEST(ShapeFunctions, are_one_at_their_node_and_zero_at_others) {
  for_each_cell_type([]<int dim>(CellType type) {
    const auto nodes = reference_nodes<dim>(type);
    for (std::size_t b = 0; b < nodes.size(); ++b) {
      ShapeValues<dim> shape;
      shape_functions<dim>(type, nodes[b], shape);
      for (std::size_t a = 0; a < nodes.size(); ++a) {
        EXPECT_EQ(shape.N[a], a == b ? 1.0 : 0.0) << name(type);
      }
    }
  });
}

TEST(ShapeFunctions, sum_to_one_and_reproduce_linear_fields) {
  for_each_cell_type([]<int dim>(CellType type) {
    const auto nodes = reference_nodes<dim>(type);
    for (const auto& xi : sample_points<dim>(type)) {
      ShapeValues<dim> shape;
      shape_functions<dim>(type, xi, shape);
      double sum = 0;
      Vector<dim> x = Vector<dim>::Zero(), gradient_sum = Vector<dim>::Zero();
      for (std::size_t a = 0; a < nodes.size(); ++a) {
        sum += shape.N[a];
        gradient_sum += shape.dN[a];
        x += shape.N[a] * nodes[a];
      }
      EXPECT_NEAR(sum, 1.0, 1e-15) << name(type);
      EXPECT_LT(gradient_sum.norm(), 1e-15) << name(type);
      EXPECT_LT((x - xi).norm(), 1e-15) << name(type);
    }
  });
}

TEST(ShapeFunctions, derivatives_match_differences) {
  for_each_cell_type([]<int dim>(CellType type) {
    const double h = 0.25;  // multilinear: central differences are exact
    for (const auto& xi : sample_points<dim>(type, 10)) {
      ShapeValues<dim> shape, plus, minus;
      shape_functions<dim>(type, xi, shape);
      for (int i = 0; i < dim; ++i) {
        shape_functions<dim>(type, xi + h * Vector<dim>::Unit(i), plus);
        shape_functions<dim>(type, xi - h * Vector<dim>::Unit(i), minus);
        for (int a = 0; a < num_nodes(type); ++a) {
          EXPECT_NEAR(shape.dN[a][i], (plus.N[a] - minus.N[a]) / (2 * h), 4e-15) << name(type);
        }
      }
    }
  });
}

TEST(ShapeFunctions, mapped_gradients_of_a_linear_field_are_exact_in_a_distorted_cell) {
  for_each_cell_type([]<int dim>(CellType type) {
    auto x_nodes = reference_nodes<dim>(type);
    for (std::size_t a = 0; a < x_nodes.size(); ++a) {
      for (int i = 0; i < dim; ++i) x_nodes[a][i] += 0.1 * std::sin(3.0 * a + 5.0 * i);
    }
    const Vector<dim> slope = Vector<dim>::LinSpaced(1.5, -0.5);
    for (const auto& xi : sample_points<dim>(type)) {
      ShapeValues<dim> shape;
      shape_functions<dim>(type, xi, shape);
      EXPECT_GT(map_gradients<dim>(type, x_nodes.data(), shape), 0.0);
      Vector<dim> gradient = Vector<dim>::Zero();
      for (std::size_t a = 0; a < x_nodes.size(); ++a) {
        gradient += slope.dot(x_nodes[a]) * shape.dN[a];
      }
      EXPECT_LT((gradient - slope).norm(), 1e-13) << name(type);
    }
  });
}

TEST(ShapeFunctions, determinant_of_an_affine_map_is_that_of_the_map) {
  for_each_cell_type([]<int dim>(CellType type) {
    Matrix<dim> map = Matrix<dim>::Identity() * 2.0;
    map(0, 1) = 0.7;
    map(1, 0) = -0.3;
    auto x_nodes = reference_nodes<dim>(type);
    for (auto& x : x_nodes) x = (map * x).eval();
    ShapeValues<dim> shape;
    shape_functions<dim>(type, Vector<dim>::Constant(0.2), shape);
    const double expected = (4.0 + 0.21) * (dim == 3 ? 2.0 : 1.0);
    EXPECT_NEAR(map_gradients<dim>(type, x_nodes.data(), shape), expected, 1e-14);
  });
}

TEST(CellFacets, point_out_of_the_reference_cell) {
  for_each_cell_type([]<int dim>(CellType type) {
    const auto nodes = reference_nodes<dim>(type);
    Vector<dim> centre = Vector<dim>::Zero();
    for (const auto& x : nodes) centre += x / static_cast<double>(nodes.size());
    for (int f = 0; f < num_facets(type); ++f) {
      const auto facet = facet_nodes(type, f);
      ASSERT_EQ(static_cast<int>(facet.size()), num_nodes(facet_type(type)));
      const Vector<dim> a = nodes[facet[1]] - nodes[facet[0]];
      Vector<dim> normal;
      if constexpr (dim == 2) {
        normal = {a[1], -a[0]};
      } else {
        const Vector<3> b = nodes[facet[2]] - nodes[facet[0]];
        normal = Vector<3>(a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2],
                           a[0] * b[1] - a[1] * b[0]);
      }
      EXPECT_GT(normal.dot(nodes[facet[0]] - centre), 0.0) << name(type) << " facet " << f;
      // All other nodes lie behind the plane of the facet.
      for (const auto& x : nodes) EXPECT_LE(normal.dot(x - nodes[facet[0]]), 0.0);
    }
  });
}

TEST(CellType, has_its_name) {
  EXPECT_EQ(name(CellType::tri3), "tri3");
  EXPECT_EQ(name(CellType::hex8), "hex8");
}

}  // namespace
}  // namespace gabion::test_shape_functions
