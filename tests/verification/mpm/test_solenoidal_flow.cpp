// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include <cmath>

#include "tests/support/convergence_rate.hpp"
#include "tests/support/verification_row.hpp"
#include "tests/unit/mpm/mpm_scene.hpp"

namespace gabion::test {
namespace {

/// Nearly incompressible elastic soil in a box of unit sides, whose walls hold it, turned by a body
/// acceleration b so that it is displaced without any change of volume (3D: in each plane y):
///
///     u_x = A (1 - cos 2 pi x) sin(2 pi z) / 2 ,   u_z = -A (1 - cos 2 pi z) sin(2 pi x) / 2 ,
///     rho b = -mu laplace(u) ,
///
/// z the last axis, A so small that strains are. The exact displacement does not depend on nu.
struct SolenoidalFlow {
  double A = 1e-6, E = 1e6, nu = 0.4999, density = 1000;

  template <int dim>
  Vector<dim> displacement(const Vector<dim>& X) const {
    const double x = 2 * M_PI * X[0], z = 2 * M_PI * X[dim - 1];
    Vector<dim> u = Vector<dim>::Zero();
    u[0] = 0.5 * A * (1 - std::cos(x)) * std::sin(z);
    u[dim - 1] = -0.5 * A * (1 - std::cos(z)) * std::sin(x);
    return u;
  }
  template <int dim>
  Vector<dim> acceleration(const Vector<dim>& X) const {
    const double x = 2 * M_PI * X[0], z = 2 * M_PI * X[dim - 1];
    const double size = 2 * M_PI * M_PI * A * E / (2 * (1 + nu)) / density;
    Vector<dim> b = Vector<dim>::Zero();
    b[0] = -size * std::sin(z) * (2 * std::cos(x) - 1);
    b[dim - 1] = size * std::sin(x) * (2 * std::cos(z) - 1);
    return b;
  }
};

/// Error of the points' displacement in the mean square, relative to the exact one.
template <int dim>
double displacement_error(const std::string& type, int cells, const std::string& locking) {
  const SolenoidalFlow flow;
  std::vector<double> low(dim, 0.0), high(dim, 1.0);
  std::vector<int> count(dim, cells);
  Json walls = {wall("left", "fixed"), wall("right", "fixed"), wall("bottom", "fixed"),
                wall("top", "fixed")};
  if (dim == 3) {  // one layer of cells between smooth walls
    high[1] = 1.0 / cells;
    count[1] = 1;
    walls.push_back(wall("front", "slip"));
    walls.push_back(wall("back", "slip"));
  }
  Json mesh = box(low, high, count, type);
  if (type == "tet4") mesh["box"]["alternate"] = false;  // six a brick lock as hard as cells do
  const Json json = {{"dimension", dim},
                     {"analysis", "quasi_static"},
                     {"grid", mesh},
                     {"basis", "linear"},
                     {"walls", walls},
                     {"bodies",
                      {body("soil", mesh,
                            type == "hex8"   ? 8
                            : type == "tri3" ? 3
                                             : 4,
                            elastic_soil("hencky_elastic", flow.E, flow.nu, flow.density))}},
                     {"locking", {{"method", locking}}},
                     {"linear_solver", {{"method", "lu"}}}};
  const TemporaryScene folder("mpm.json", json);
  const Scene scene(folder.path(), {});
  ConfigReader in = scene.reader("mpm.json", mpm::mpm_keys());
  in.integer("dimension");
  auto settings = mpm::read_mpm_settings<dim>(scene, in, nullptr);
  settings.body_acceleration = [&](const Vector<dim>& X, double) {
    return flow.acceleration<dim>(X);
  };
  mpm::MpmSolver<dim> solver(comm(), std::move(settings), "");
  run_steps(solver, 1, 1);

  const auto& points = solver.points();
  double error = 0, size = 0;
  for (std::int32_t p = 0; p < points.size(); ++p) {
    const Vector<dim> exact = flow.displacement<dim>(points.x[p] - points.u[p]);
    error += points.V0[p] * (points.u[p] - exact).squaredNorm();
    size += points.V0[p] * exact.squaredNorm();
  }
  return std::sqrt(error / size);
}

/// @param bound   of the error with F-bar on the finest grid
/// @param locked  least error without it on the same grid
template <int dim>
void check(const std::string& type, double bound, double locked) {
  std::vector<double> sizes, errors;
  for (const int cells : {8, 16, 32}) {
    sizes.push_back(1.0 / cells);
    errors.push_back(displacement_error<dim>(type, cells, "fbar"));
  }
  const double without = displacement_error<dim>(type, 32, "none");
  const std::string what = "displacement of " + type + " with nu = 0.4999, F-bar";
  verify({.id = "solenoidal",
          .what = what + ", 32 cells",
          .exact = 0,
          .computed = errors.back(),
          .measure = Measure::absolute_error,
          .bound = bound});
  verify({.id = "solenoidal",
          .what = what + ", order in h",
          .exact = 2,
          .computed = last_rate(sizes, errors),
          .measure = Measure::order,
          .bound = 1.8});
  EXPECT_GT(without, locked) << type;
}

TEST(SolenoidalFlow, nearly_incompressible_soil_moves_with_averaged_volumes_only) {
  check<2>("quad4", 0.01, 0.5);
  check<2>("tri3", 0.01, 0.5);
  check<3>("hex8", 0.01, 0.5);
  check<3>("tet4", 0.01, 0.5);
}

}  // namespace
}  // namespace gabion::test
