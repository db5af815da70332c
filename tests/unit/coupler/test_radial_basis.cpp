// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <numbers>

#include "coupler/mapping/interface_map.hpp"
#include "coupler/mapping/mapping.hpp"
#include "tests/support/convergence_rate.hpp"
#include "tests/support/expect_error.hpp"
#include "tests/unit/coupler/sequence.hpp"

namespace gabion::test_radial_basis {
namespace {

using Eigen::Vector3d;
using Values = std::vector<double>;
using Field = std::function<double(const Vector3d&)>;

/// Part of a circle in 2D, of a torus in 3D, n facets a direction; `skew` moves the vertices along
/// the surface so that two meshes share none but the corners.
InterfaceMesh curved(int dim, int n, double skew) {
  InterfaceMesh mesh;
  mesh.name = "wall";
  mesh.dim = dim;
  mesh.vertices_per_facet = dim == 2 ? 2 : 4;
  const auto station = [&](int i) {
    const double s = static_cast<double>(i) / n;
    return s + skew * std::sin(std::numbers::pi * s) * (1 - s) * s;
  };
  for (int j = 0; j <= (dim == 2 ? 0 : n); ++j) {
    for (int i = 0; i <= n; ++i) {
      const double a = 1.2 * station(i), b = 1.1 * station(j);
      if (dim == 2) {
        mesh.coordinates.insert(mesh.coordinates.end(), {std::cos(a), std::sin(a)});
      } else {
        const double r = 2 + std::cos(b);
        mesh.coordinates.insert(mesh.coordinates.end(),
                                {r * std::cos(a), r * std::sin(a), std::sin(b)});
      }
    }
  }
  for (std::int64_t j = 0; j < (dim == 2 ? 1 : n); ++j) {
    for (std::int64_t i = 0; i < n; ++i) {
      const std::int64_t a = j * (n + 1) + i, d = a + n + 1;
      if (dim == 2) mesh.facets.insert(mesh.facets.end(), {i, i + 1});
      if (dim == 3) mesh.facets.insert(mesh.facets.end(), {a, a + 1, d + 1, d});
    }
  }
  return mesh;
}

Values evaluate(const InterfaceMesh& mesh, const Field& field) {
  Values values;
  for (std::int64_t v = 0; v < mesh.num_vertices(); ++v) {
    Vector3d x = Vector3d::Zero();
    for (int i = 0; i < mesh.dim; ++i) x(i) = mesh.coordinates[v * mesh.dim + i];
    for (int i = 0; i < mesh.dim; ++i) values.push_back((i + 1) * field(x));
  }
  return values;
}

double largest_error(const Mapping& mapping, const InterfaceMesh& structure,
                     const InterfaceMesh& soil, const Field& field) {
  Values found(soil.coordinates.size());
  mapping.to_soil(evaluate(structure, field), found);
  const Values exact = evaluate(soil, field);
  double largest = 0;
  for (std::size_t i = 0; i < found.size(); ++i) {
    largest = std::max(largest, std::abs(found[i] - exact[i]));
  }
  return largest;
}

MappingSettings method(const std::string& name, Kernel kernel = Kernel::wendland_c4,
                       int cluster_size = 50) {
  return {name, 0.2, {kernel, cluster_size}};
}

constexpr Kernel kernels[] = {Kernel::wendland_c2, Kernel::wendland_c4, Kernel::wendland_c6,
                              Kernel::thin_plate};

/// Order of the error in the mesh size from n to 2 n facets a direction.
double observed_order(int dim, const MappingSettings& settings) {
  const Field wave = [](const Vector3d& x) { return std::sin(3 * x(0) + 2 * x(1) - x(2)); };
  const int n = dim == 2 ? 32 : 16;
  double error[2];
  for (int k = 0; k < 2; ++k) {
    const InterfaceMesh structure = curved(dim, n << k, 0),
                        soil = curved(dim, (n << k) * 3 / 4, 0.3);
    error[k] = largest_error(Mapping(structure, soil, settings), structure, soil, wave);
  }
  return std::log2(error[0] / error[1]);
}

TEST(RadialBasis, orders_on_curved_surfaces) {
  for (const int dim : {2, 3}) {
    EXPECT_NEAR(observed_order(dim, method("nearest_neighbor")), 1, 0.3) << dim;
    EXPECT_NEAR(observed_order(dim, method("nearest_projection")), 2, 0.3) << dim;
    EXPECT_GT(observed_order(dim, method("radial_basis", Kernel::thin_plate)), 1.8) << dim;
    EXPECT_GT(observed_order(dim, method("radial_basis", Kernel::wendland_c2)), 1.8) << dim;
    EXPECT_GT(observed_order(dim, method("radial_basis", Kernel::wendland_c4)), 2.8) << dim;
    EXPECT_GT(observed_order(dim, method("radial_basis", Kernel::wendland_c6)), 3) << dim;
  }
}

TEST(RadialBasis, keeps_linear_fields_and_values_at_vertices) {
  const Field linear = [](const Vector3d& x) { return 3 + 2 * x(0) - x(1) + 0.5 * x(2); };
  for (const int dim : {2, 3}) {
    const InterfaceMesh structure = curved(dim, 20, 0), soil = curved(dim, 17, 0.3);
    for (const Kernel kernel : kernels) {
      const MappingSettings settings = method("radial_basis", kernel);
      const Mapping mapping(structure, soil, settings);
      EXPECT_LE(largest_error(mapping, structure, soil, linear), 1e-12);
      EXPECT_LE(mapping.report().largest_shift, 1e-12);
      InterfaceMesh reversed = structure;  // not the identity
      for (std::size_t v = 0, n = structure.coordinates.size() / dim; v < n; ++v) {
        for (int i = 0; i < dim; ++i) {
          reversed.coordinates[v * dim + i] = structure.coordinates[(n - 1 - v) * dim + i];
        }
      }
      reversed.facets.clear();
      const Field rough = [](const Vector3d& x) { return std::sin(1e4 * x(0)) + x(1) * x(1); };
      const Mapping same(structure, reversed, settings);
      EXPECT_FALSE(same.is_identity());
      EXPECT_LE(largest_error(same, structure, reversed, rough), 1e-6);
    }
  }
}

TEST(RadialBasis, flat_surfaces_and_few_vertices) {
  InterfaceMesh line = curved(2, 3, 0), plane = curved(3, 4, 0);
  for (std::size_t k = 1; k < line.coordinates.size(); k += 2) line.coordinates[k] = 0.25;
  for (std::size_t k = 2; k < plane.coordinates.size(); k += 3) plane.coordinates[k] = -3;
  const Field linear = [](const Vector3d& x) { return 1 - 2 * x(0) + 5 * x(1); };
  for (const InterfaceMesh& structure : {line, plane}) {
    InterfaceMesh soil = structure;
    soil.coordinates[0] -= 0.01;
    const Mapping mapping(structure, soil, method("radial_basis"));
    EXPECT_LE(largest_error(mapping, structure, soil, linear), 1e-12);
  }
}

TEST(RadialBasis, forces_keep_sum_moment_and_work) {
  for (const int dim : {2, 3}) {
    const InterfaceMesh structure = curved(dim, 20, 0), soil = curved(dim, 17, 0.3);
    const InterfaceMap map({{"wall", "soil", "structure"}},
                           {{"soil", {soil}}, {"structure", {structure}}},
                           method("radial_basis", Kernel::wendland_c6));
    test::Sequence random(3);
    Eigen::VectorXd x(map.size());
    for (double& value : x) value = random();
    Eigen::VectorXd f_soil(map.soil_size());
    for (double& value : f_soil) value = random();
    const Eigen::VectorXd u = map.soil_displacement(x), f = map.structure_force(f_soil);
    const Resultant here = map.soil_resultant(u, f_soil), there = map.structure_resultant(x, f);
    EXPECT_GT(here.force.norm(), 0.1);
    EXPECT_LE((here.force - there.force).norm(), 1e-12);
    EXPECT_NEAR(u.dot(f_soil), x.dot(f), 1e-11);
    const Resultant still = map.soil_resultant(Eigen::VectorXd::Zero(map.soil_size()), f_soil);
    const Resultant there_still = map.structure_resultant(Eigen::VectorXd::Zero(map.size()), f);
    EXPECT_GT(still.moment.norm(), 0.1);
    EXPECT_LE((still.moment - there_still.moment).norm(), 1e-11);
  }
}

TEST(RadialBasis, memory_grows_linearly) {
  const auto weights_of_a_vertex = [](int n) {
    const InterfaceMesh structure = curved(3, n, 0), soil = curved(3, 3 * n / 4, 0.3);
    const Mapping mapping(structure, soil, method("radial_basis", Kernel::wendland_c6, 30));
    return static_cast<double>(mapping.num_weights()) / static_cast<double>(soil.num_vertices());
  };
  const double coarse = weights_of_a_vertex(20), fine = weights_of_a_vertex(40);  // 4 times as many
  EXPECT_LT(fine, 1.2 * coarse);
  EXPECT_LT(fine, 30 * 6);
}

TEST(RadialBasis, a_surface_cut_into_clusters_gives_the_accuracy_of_the_interpolation) {
  const InterfaceMesh structure = curved(3, 40, 0), soil = curved(3, 30, 0.3);
  const Mapping clusters(structure, soil, method("radial_basis", Kernel::wendland_c6, 30));
  const Field wave = [](const Vector3d& x) { return std::sin(3 * x(0) + 2 * x(1) - x(2)); };
  EXPECT_LT(largest_error(clusters, structure, soil, wave), 1e-3);
}

TEST(RadialBasis, vertices_that_determine_nothing_are_refused) {
  InterfaceMesh twice = curved(2, 5, 0), soil = curved(2, 4, 0);
  twice.coordinates[2] = twice.coordinates[0];
  twice.coordinates[3] = twice.coordinates[1];
  twice.facets.clear();
  twice.vertices_per_facet = 0;
  test::expect_error<ConfigError>(
      [&] { Mapping(twice, soil, method("radial_basis")); },
      {"interface \"wall\": radial basis functions", "allowed: each vertex once"});
}

}  // namespace
}  // namespace gabion::test_radial_basis
