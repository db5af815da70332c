// SPDX-License-Identifier: BSD-3-Clause
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <cmath>

#include "tests/support/verification_row.hpp"
#include "tests/unit/mpm/mpm_scene.hpp"

namespace gabion::test {
namespace {

/// Half of a rigid rough strip footing of width 2 b on weightless Tresca soil, pushed into it by a
/// settlement so small that the geometry does not change. Bearing capacity (Prandtl, 1920):
///
///     q = (2 + pi) c
///
/// The failure mechanism reaches 3 b to the side and sqrt(2) b down.
struct Footing {
  double b = 1, c = 1e3, E = 1e7, nu = 0.49, settlement = 1.5e-3;
  double width = 4, depth = 2;  ///< of the half domain, by b
  int steps = 12;
};

constexpr double prandtl = 2 + M_PI;

struct Form {
  std::string type = "quad4", basis = "linear", locking = "fbar";
  bool by_facets = false;  ///< else tied by boundary points
  bool saturated = false;  ///< soil with friction and pore water, else Tresca soil
};

/// Soil with friction and cohesion whose pore water keeps its volume, and with psi = 0 its mean
/// effective stress of 0: its undrained strength is c again.
void saturate(const Footing& footing, Json& soil) {
  constexpr double phi = 20;
  Json& material = soil["material"];
  material = elastic_soil("mohr_coulomb", footing.E, 0.3, 1990);
  material["friction_angle"] = phi;
  material["cohesion"] = footing.c / std::cos(phi * M_PI / 180);
  soil["water"] = {{"porosity", 0.4}, {"cavitation_pressure", 1e6}};
}

/// The plate that pushes the soil.
Json rough_plate(const Footing& footing, double h, bool by_facets) {
  Json json = {{"name", "footing"},
               {"surface",
                {{"polyline", {{0, footing.depth}, {footing.b, footing.depth}}}, {"spacing", h}}}};
  if (by_facets) {
    json["friction"] = 0.5;
  } else {
    json["method"] = "boundary_points";
    json["mode"] = "fixed";
    json["penalty"] = 1000 * footing.E / h;
  }
  return json;
}

Json footing_scene(const Footing& footing, const Form& form, int cells) {
  const std::string& type = form.type;
  const double h = footing.b / cells, width = footing.width, depth = footing.depth;
  const std::vector<int> count = {static_cast<int>(width * cells), static_cast<int>(depth * cells)};
  Json material = elastic_soil("tresca", footing.E, footing.nu, 1000);
  material["cohesion"] = footing.c;
  Json json = {
      {"dimension", 2},
      {"analysis", "quasi_static"},
      {"grid", box({0, 0}, {width, depth + h}, {count[0], count[1] + 1}, type)},
      {"basis", form.basis},
      {"walls", {wall("bottom", "fixed"), wall("left", "slip"), wall("right", "slip")}},
      {"bodies",
       {body("soil", box({0, 0}, {width, depth}, count, type), type == "tri3" ? 3 : 4, material)}},
      {"interfaces", {rough_plate(footing, h, form.by_facets)}},
      {"locking", {{"method", form.locking}}},
      {"newton", {{"max_iterations", 60}}},
      {"linear_solver", {{"method", "lu"}}}};
  if (form.saturated) saturate(footing, json["bodies"][0]);
  return json;
}

/// q / c at the end of each step. @param cells  under half of the footing
std::vector<double> push(const Form& form, int cells) {
  const Footing footing;
  const auto solver = make_mpm(footing_scene(footing, form, cells));
  const std::size_t num_values = solver->interfaces()[0].coordinates.size();
  std::vector<double> q;
  for (int n = 1; n <= footing.steps; ++n) {
    InterfaceValues displacement, force;
    auto& u = displacement["footing"];
    u.assign(num_values, 0);
    for (std::size_t k = 1; k < num_values; k += 2) u[k] = -footing.settlement * n / footing.steps;
    solver->solve_step({n, 0, n - 1.0, 1}, displacement, force);
    solver->accept_step({n, 0, n - 1.0, 1}, true);
    double sum = 0;
    for (std::size_t k = 1; k < num_values; k += 2) sum += force.at("footing")[k];
    q.push_back(sum / (footing.b * footing.c));
  }
  return q;
}

/// Growth of the load over the last step, as a share of the elastic one of the first step.
double last_growth(const std::vector<double>& q) {
  return (q.back() - q[q.size() - 2]) / q.front();
}

/// A cell beside the footing's edge carries part of it along, so the error is of first order in h.
void check_footing(const std::string& type) {
  const auto coarse = push({.type = type}, 4), fine = push({.type = type}, 8);
  EXPECT_LT(last_growth(coarse), 0.01) << type;
  EXPECT_LT(last_growth(fine), 0.01) << type;
  const std::string what = "limit load q / c of a strip footing, Tresca, " + type + ", F-bar, ";
  verify({.id = "V11",
          .what = what + "8 cells under half of it",
          .exact = prandtl,
          .computed = fine.back(),
          .bound = 0.065});
  verify({.id = "V11",
          .what = what + "4 and 8 cells extrapolated in h",
          .exact = prandtl,
          .computed = 2 * fine.back() - coarse.back(),
          .bound = 0.03});
  const auto locked = push({.type = type, .locking = "none"}, 8);
  EXPECT_GT(locked.back(), 1.25 * prandtl) << type;
  EXPECT_GT(last_growth(locked), 0.025) << type;
}

TEST(StripFooting, quad4_reaches_prandtls_limit) {
  check_footing("quad4");
}

TEST(StripFooting, tri3_reaches_prandtls_limit) {
  check_footing("tri3");
}

TEST(StripFooting, saturated_soil_reaches_prandtls_limit) {
  const auto q = push({.saturated = true}, 8);
  EXPECT_LT(last_growth(q), 0.01);
  verify({.id = "V11",
          .what = "limit load q / (c cos phi) of a strip footing, Mohr-Coulomb with pore water, "
                  "psi = 0, quad4, F-bar, 8 cells under half of it",
          .exact = prandtl,
          .computed = q.back(),
          .bound = 0.065});
}

/// @param cells  under half of the footing on the finer grid, twice those on the coarser one
void check_smooth_functions(const Form& form, int cells, double bound) {
  const auto coarse = push(form, cells / 2), fine = push(form, cells);
  EXPECT_LT(last_growth(fine), 0.01) << form.basis;
  const std::string what = fmt::format("limit load q / c of a strip footing{}, Tresca, {}, F-bar, ",
                                       form.by_facets ? " by facets" : "", form.basis);
  verify({.id = "V11",
          .what = what + fmt::format("{} cells under half of it", cells),
          .exact = prandtl,
          .computed = fine.back(),
          .bound = bound});
  verify({.id = "V11",
          .what = what + fmt::format("{} and {} cells extrapolated in h", cells / 2, cells),
          .exact = prandtl,
          .computed = 2 * fine.back() - coarse.back(),
          .bound = 0.03});
}

TEST(StripFooting, facets_push_soil_on_smooth_functions) {
  check_smooth_functions({.basis = "gimp", .by_facets = true}, 8, 0.065);
  check_smooth_functions({.basis = "bspline", .by_facets = true}, 16, 0.02);
}

TEST(StripFooting, points_tie_soil_on_smooth_functions) {
  check_smooth_functions({.basis = "gimp"}, 8, 0.065);
  check_smooth_functions({.basis = "bspline"}, 8, 0.065);
}

TEST(StripFooting, limit_load_within_three_percent) {
  for (const std::string type : {"quad4", "tri3"}) {
    verify({.id = "V11",
            .what = "limit load q / c of a strip footing, Tresca, " + type +
                    ", F-bar, 16 cells under half of it",
            .exact = prandtl,
            .computed = push({.type = type}, 16).back(),
            .bound = 0.03});
  }
}

}  // namespace
}  // namespace gabion::test
