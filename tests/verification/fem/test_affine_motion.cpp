// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <functional>
#include <random>
#include <set>

#include "fem_solver/stress/cell_integrals.hpp"
#include "tests/support/verification_row.hpp"
#include "tests/unit/fem/fem_scene.hpp"
#include "tests/verification/elastic_laws.hpp"

namespace gabion::test {
namespace {

constexpr double E = 1e6, nu = 0.3;
const Lame lame(E, nu);
constexpr int steps = 72;

/// Deformation gradient after a share s of the path, s from 0 to 1.
template <int dim>
using Path = std::function<Matrix<dim>(double s)>;

template <int dim>
std::set<std::int32_t> boundary_nodes(const Mesh<dim>& mesh) {
  std::set<std::int32_t> nodes;
  for (const auto& [name, facets] : mesh.facet_groups) nodes.insert(facets.begin(), facets.end());
  return nodes;
}

/// A unit box whose inner nodes are moved by up to a tenth of a cell and whose boundary nodes
/// follow the path exactly; 1 s, a step a row of their tables.
template <int dim>
fem::FemSettings<dim> driven_box(const std::string& type, const std::string& law,
                                 const Path<dim>& path) {
  Json mesh;
  if constexpr (dim == 2) mesh = box_2d({1, 1}, {4, 4}, type);
  if constexpr (dim == 3) mesh = box_3d({1, 1, 1}, {3, 3, 3}, type);
  auto settings =
      fem_settings<dim>({{"dimension", dim},
                         {"mesh", mesh},
                         {"material", elastic(law, E, nu, 1)},
                         {"newton", {{"residual_tolerance", 1e-13}, {"reuse_matrix", false}}}});
  settings.dynamic = false;  // a file could not say so without what holds the box, which comes here
  const auto boundary = boundary_nodes(settings.mesh);
  std::mt19937 random(7);
  std::uniform_real_distribution<double> shift(-0.025, 0.025);
  for (std::int32_t i = 0; i < settings.mesh.num_nodes_total(); ++i) {
    if (boundary.contains(i)) continue;
    for (int d = 0; d < dim; ++d) settings.mesh.nodes[i][d] += shift(random);
  }
  std::vector<double> times;
  for (int n = 0; n <= steps; ++n) times.push_back(static_cast<double>(n) / steps);
  for (const auto i : boundary) {
    const std::string name = "node " + std::to_string(i);
    settings.mesh.facet_groups[name] = {i};
    for (int d = 0; d < dim; ++d) {
      std::vector<double> values;
      for (const double s : times) {
        values.push_back(((path(s) - Matrix<dim>::Identity()) * settings.mesh.nodes[i])[d]);
      }
      settings.prescribed.push_back({name, d, TimeFunction::table(times, values), "test"});
    }
  }
  return settings;
}

struct Errors {
  double position = 0;  ///< largest of any node and step [m]
  double stress = 0;    ///< Cauchy, largest of any cell at the end, by E
  double energy = 0;    ///< largest of any step, by E
};

template <int dim>
Errors drive(const std::string& type, const std::string& law, const Path<dim>& path) {
  const auto settings = driven_box<dim>(type, law, path);
  const fem::CellIntegrals<dim> cells(settings.mesh, settings.materials, false);
  fem::FemSolver<dim> solver(comm(), settings, "");
  Errors errors;
  for (int n = 1; n <= steps; ++n) {
    run_steps(solver, 1.0 / steps, 1, n);
    const Matrix<dim> F = path(static_cast<double>(n) / steps);
    const auto& u = solver.state().motion.u;
    for (std::int32_t i = 0; i < settings.mesh.num_nodes_total(); ++i) {
      const Vector<dim>& X = settings.mesh.nodes[i];
      const Eigen::Map<const Vector<dim>> u_i(u.data() + std::ptrdiff_t{i} * dim);
      errors.position = std::max(errors.position, (X + u_i - F * X).norm());
    }
    const double energy = exact_energy<dim>(law, lame, F);
    errors.energy = std::max(errors.energy, std::abs(probe(solver, "elastic_energy") - energy) / E);
  }
  const Matrix<3> exact = exact_stress<dim>(law, lame, path(1)) / path(1).determinant();
  const auto stresses = cells.cell_stresses(solver.state().motion.u);
  constexpr int size = symmetric_size<dim>;
  for (std::size_t k = 0; k < stresses.size(); k += size) {
    const Matrix<3> found = full<dim>(Eigen::Map<const Symmetric<dim>>(stresses.data() + k));
    errors.stress = std::max(errors.stress, (found - exact).cwiseAbs().maxCoeff() / E);
  }
  return errors;
}

template <int dim>
void check(const std::string& what, const Path<dim>& path, double bound) {
  Errors worst;
  const std::vector<std::string> types = dim == 2 ? std::vector<std::string>{"tri3", "quad4"}
                                                  : std::vector<std::string>{"tet4", "hex8"};
  for (const auto& type : types) {
    for (const std::string law : {"neo_hookean", "hencky_elastic"}) {
      const Errors errors = drive<dim>(type, law, path);
      worst.position = std::max(worst.position, errors.position);
      worst.stress = std::max(worst.stress, errors.stress);
      worst.energy = std::max(worst.energy, errors.energy);
    }
  }
  const auto row = [&](const std::string& quantity, double error) {
    verify({.id = "V1",
            .what = what + ": " + quantity + ", FEM " + types[0] + ", " + types[1],
            .exact = 0,
            .computed = error,
            .measure = Measure::absolute_error,
            .bound = bound});
  };
  row("position [m]", worst.position);
  row("stress over E", worst.stress);
  row("energy over E", worst.energy);
}

template <int dim>
Matrix<dim> stretch_and_shear() {
  Matrix<3> F;
  F << 1.2, 0.15, -0.05, 0.1, 0.9, 0.2, 0.07, -0.1, 1.05;
  return F.topLeftCorner<dim, dim>();
}

template <int dim>
void patch() {
  check<dim>(
      "patch, distorted cells",
      [](double s) -> Matrix<dim> {
        return (1 - s) * Matrix<dim>::Identity() + s * stretch_and_shear<dim>();
      },
      1e-12);
}
TEST(V1_AffineMotion, patch_2d) {
  patch<2>();
}
TEST(V1_AffineMotion, patch_3d) {
  patch<3>();
}

/// Turn by 360 degrees while the strain grows.
template <int dim>
void rotate() {
  check<dim>(
      "rotation by 360 deg",
      [](double s) -> Matrix<dim> {
        const Matrix<dim> F = (1 - s) * Matrix<dim>::Identity() + s * stretch_and_shear<dim>();
        if constexpr (dim == 2) {
          return Eigen::Rotation2Dd(2 * M_PI * s).toRotationMatrix() * F;
        } else {
          return Eigen::AngleAxisd(2 * M_PI * s, Vector<3>(1, 2, 3).normalized())
                     .toRotationMatrix() *
                 F;
        }
      },
      1e-10);
}
TEST(V1_AffineMotion, rotation_2d) {
  rotate<2>();
}
TEST(V1_AffineMotion, rotation_3d) {
  rotate<3>();
}

template <int dim>
void shear() {
  check<dim>(
      "simple shear to gamma = 4",
      [](double s) -> Matrix<dim> {
        Matrix<dim> F = Matrix<dim>::Identity();
        F(0, 1) = 4 * s;
        return F;
      },
      1e-11);
}
TEST(V1_AffineMotion, simple_shear_2d) {
  shear<2>();
}
TEST(V1_AffineMotion, simple_shear_3d) {
  shear<3>();
}

}  // namespace
}  // namespace gabion::test
