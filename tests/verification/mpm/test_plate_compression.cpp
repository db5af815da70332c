// SPDX-License-Identifier: BSD-3-Clause
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <cmath>

#include "tests/support/verification_row.hpp"
#include "tests/unit/mpm/mpm_scene.hpp"

namespace gabion::test {
namespace {

/// V19: a rigid plate, by facets, goes a quarter of a cube's height into it. The sides are held,
/// nu = 0, Hencky's law: with the stretch s, E ln s is Kirchhoff's stress, E ln s / s Cauchy's. The
/// plate is carried by penetration:
///
///     s = 0.75 + d / L ,  -E ln(s) / s = (A' / A) c E (d / h)^2
///
/// A' is the area that the points stand for, A that of the plate.
constexpr double E = 1e6, L = 1, factor = 10;

double stretch(double area_ratio, double h) {
  double low = 0.75, high = 1;
  while (high - low > 1e-15) {
    const double s = 0.5 * (low + high), d = (s - 0.75) * L;
    (area_ratio * factor * d * d / (h * h) > -std::log(s) / s ? high : low) = s;
  }
  return low;
}

struct Compressed {
  double tau = 0;    ///< mean Kirchhoff stress of the points [Pa]
  double force = 0;  ///< on the plate [N]
};

/// A unit cube of `cells` cells a side, in cells of the grid of the same size.
template <int dim>
Compressed compress(const std::string& basis, int cells) {
  const double h = L / cells;
  const std::string type = dim == 2 ? "quad4" : "hex8";
  const std::vector<double> low(dim, 0.0), high(dim, L);
  const Json unit = box(low, high, std::vector<int>(dim, cells), type);
  Json json = {{"dimension", dim},
               {"grid", unit},
               {"basis", basis},
               {"analysis", "quasi_static"},
               {"walls", {wall("bottom", "slip"), wall("left", "slip"), wall("right", "slip")}},
               {"bodies",
                {body("cube", unit, dim == 2 ? 4 : 8, elastic_soil("hencky_elastic", E, 0, 1000))}},
               {"newton", exact_newton}};
  Json surface;
  if constexpr (dim == 2) {
    surface = {{"polyline", {{-1, L}, {2, L}}}, {"spacing", h}};
  } else {
    json["walls"].push_back(wall("front", "slip"));
    json["walls"].push_back(wall("back", "slip"));
    surface = {{"mesh", box({-1, -1, L}, {2, 2, L + 1}, {3, 3, 1}, "hex8")},
               {"groups", {"bottom"}}};
  }
  std::vector<double> start(dim + 1, 0.0), end(dim + 1, 0.0);
  end[0] = 1;
  end[dim] = -0.25 * L;
  json["rigid_walls"] = {{{"name", "plate"},
                          {"surface", surface},
                          {"mode", "slip"},
                          {"motion", {{"table", {start, end}}}}}};
  const auto solver = mpm_solver<dim>(json);
  run_steps(*solver, 0.05, 20);
  Compressed result;
  const auto& points = solver->points();
  for (const auto& tau : points.tau) result.tau += tau[dim - 1] / points.size();
  result.force = probe(*solver, dim == 2 ? "plate.fy" : "plate.fz");
  return result;
}

template <int dim>
void check(const std::string& basis, int cells) {
  const Compressed found = compress<dim>(basis, cells);
  // Gauss points lie less deep in their cell than half of what they stand for.
  const double area_ratio = basis == "linear" ? 0.5 / (1 - std::sqrt(1 / 3.0)) : 1;
  const double s = stretch(area_ratio, L / cells);
  VerificationRow row = {
      .id = "V19",
      .what = fmt::format("compression by a plate of facets, {}D, {} cells, MPM {}: ", dim, cells,
                          basis),
      .bound = 1e-6};
  const std::string what = row.what;
  row.what = what + "mean Kirchhoff stress";
  row.exact = E * std::log(s);
  row.computed = found.tau;
  row.unit = "Pa";
  verify(row);
  row.what = what + "force on the plate";
  row.exact = -E * std::log(s) / s * L;
  row.computed = found.force;
  row.unit = dim == 2 ? "N/m" : "N";
  verify(row);
}

/// No point crosses a line of the grid.
TEST(V19_PlateCompression, one_cell) {
  check<2>("linear", 1);
  check<3>("linear", 1);
}

TEST(V19_PlateCompression, points_cross_cells) {
  check<2>("gimp", 4);
  check<2>("gimp", 8);
  check<2>("gimp", 16);
  check<3>("gimp", 4);
}

}  // namespace
}  // namespace gabion::test
