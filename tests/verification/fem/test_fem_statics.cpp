// SPDX-License-Identifier: BSD-3-Clause
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <array>
#include <cmath>

#include "tests/support/convergence_rate.hpp"
#include "tests/support/verification_row.hpp"
#include "tests/unit/fem/fem_scene.hpp"
#include "tests/verification/elastica.hpp"

namespace gabion::test {
namespace {

constexpr double E = 1e6, length = 1, thickness = 0.05;

/// A horizontal cantilever, fixed at the left, end force spread over the right side, put on in
/// ten parts.
Json cantilever(const std::string& law, double nu, double force, int cells_along,
                int cells_across = 1) {
  return {{"dimension", 2},
          {"mesh", box_2d({length, thickness}, {cells_along, cells_across})},
          {"material", elastic(law, E, nu, 1)},
          {"analysis", "static"},
          {"supports", {{{"group", "left"}}}},
          {"tractions",
           {{{"group", "right"},
             {"traction", {0.0, -force / thickness}},
             {"table", {{0, 0}, {1, 1}}}}}},
          {"probes", {{{"name", "tip"}, {"point", {length, thickness / 2}}}}}};
}

struct Tip {
  double down, inward;
};

/// The scene in space: one cell of width 1 across, bent in the plane of x and y.
Json in_3d(Json json, int cells_along, double force) {
  json["dimension"] = 3;
  json["mesh"] = box_3d({length, thickness, 1}, {cells_along, 1, 1});
  json["tractions"][0]["traction"] = {0.0, -force / thickness, 0.0};
  json["probes"][0]["point"] = {length, thickness / 2, 0.5};
  return json;
}

template <int dim = 2>
Tip tip_of(const Json& json, int steps) {
  const auto solver = fem_solver<dim>(json);
  run_steps(*solver, 1.0 / steps, steps);
  return {-probe(*solver, "tip.uy"), -probe(*solver, "tip.ux")};
}

/// Three meshes, each with half the cell length of the last.
struct Refinement {
  double order, limit;
  Refinement(double coarse, double middle, double fine)
      : order(std::log2((middle - coarse) / (fine - middle))), limit(fine + (fine - middle) / 3) {}
};

/// Large bending against the elastica, alpha = P L^2 / EI. The full integration of quad4 and hex8
/// is too stiff by 0.5 (cell length / thickness)^2, second order; what remains in the limit is the
/// shear deformation of the real plate, 0.6 (thickness / length)^2, and its stretch.
template <int dim>
void elastica(double alpha, double nu) {
  SCOPED_TRACE(alpha);
  const double force = alpha * E / (1 - nu * nu) * std::pow(thickness, 3) / 12 / (length * length);
  std::array<Tip, 3> tips;
  for (int k = 0; k < 3; ++k) {
    Json json = cantilever("hencky_elastic", nu, force, 40 << k, nu == 0 ? 1 : 2 << k);
    if constexpr (dim == 3) json = in_3d(json, 40 << k, force);
    json["newton"] = {{"reuse_matrix", false}};
    tips[k] = tip_of<dim>(json, 5 + static_cast<int>(2 * alpha));
  }
  const Refinement vertical(tips[0].down, tips[1].down, tips[2].down);
  const Refinement horizontal(tips[0].inward, tips[1].inward, tips[2].inward);
  EXPECT_NEAR(vertical.order, 2, 0.25);
  EXPECT_NEAR(horizontal.order, 2, 0.25);
  const Elastica exact(alpha);
  const std::string type = dim == 2 ? "quad4" : "hex8";
  const auto row = [&](const std::string& what, double computed, double reference, double bound,
                       const std::string& limitation = "") {
    verify({.id = "V6",
            .what = fmt::format("elastica, alpha = {}, nu = {}, FEM {}: {}", alpha, nu, type, what),
            .exact = reference,
            .computed = computed,
            .bound = bound,
            .limitation = limitation});
  };
  row("deflection / L, h to 0", vertical.limit / length, exact.deflection, 0.01);
  row("shortening / L, h to 0", horizontal.limit / length, exact.shortening, 0.01);
  row("deflection / L, 80 cells", tips[1].down / length, exact.deflection, 0.06,
      "full integration is too stiff in bending by about 0.5 (cell length / thickness)^2, however "
      "many cells lie across");
}

TEST(V6_Cantilever, elastica) {
  for (const double alpha : {1.0, 2.0, 5.0, 10.0}) elastica<2>(alpha, 0);
}
TEST(V6_Cantilever, elastica_in_plane_strain) {
  elastica<2>(9.6, 0.2);
}
TEST(V6_Cantilever, elastica_3d) {
  elastica<3>(1, 0);
}

/// Small load in plane strain: P L^3 / 3 E' I with E' = E / (1 - nu^2).
TEST(V6_Cantilever, plane_strain_stiffness) {
  const double nu = 0.3, force = 1e-3;
  const double inertia = std::pow(thickness, 3) / 12;
  const double exact = force * std::pow(length, 3) * (1 - nu * nu) / (3 * E * inertia);
  std::array<double, 3> tips;
  for (int k = 0; k < 3; ++k) {
    tips[k] = tip_of(cantilever("linear_elastic", nu, force, 40 << k, 2 << k), 1).down;
  }
  const Refinement bending(tips[0], tips[1], tips[2]);
  EXPECT_NEAR(bending.order, 2, 0.25);
  verify({.id = "V6",
          .what = "small deflection in plane strain, nu = 0.3, h to 0, FEM quad4",
          .exact = exact,
          .computed = bending.limit,
          .bound = 0.005,
          .unit = "m"});
}

constexpr double rho = 1000, g = 9.81, height = 2;

Json column_2d(const std::string& type, int across, int along) {
  return {{"dimension", 2},
          {"mesh", box_2d({0.4, height}, {across, along}, type)},
          {"material", elastic("linear_elastic", E, 0, rho)},
          {"gravity", {0, -g}},
          {"initial_equilibrium", true},
          {"supports", {{{"group", "bottom"}, {"report_reaction", true}}}},
          {"probes",
           {{{"name", "top"}, {"point", {0.4, height}}},
            {{"name", "low"}, {"point", {0.0, height / 4}}}}}};
}

/// A column under its weight without lateral strain: u(y) = -rho g (h y - y^2 / 2) / E, exact at
/// the nodes of quad4.
TEST(V2_Column, own_weight_is_exact_at_the_nodes) {
  const auto solver = fem_solver<2>(column_2d("quad4", 2, 8));
  verify({.id = "V2",
          .what = "settlement of a linear column, FEM quad4",
          .exact = -rho * g * height * height / (2 * E),
          .computed = probe(*solver, "top.uy"),
          .bound = 1e-10,
          .unit = "m"});
  EXPECT_NEAR(probe(*solver, "low.uy"), -rho * g * height * height * (0.25 - 1.0 / 32) / E, 1e-12);
  EXPECT_NEAR(probe(*solver, "reaction_bottom_y"), rho * g * 0.4 * height, 1e-8);
  EXPECT_NEAR(probe(*solver, "reaction_bottom_x"), 0, 1e-8);
}

/// Triangles share the weight of a layer unevenly: second order instead of exactness.
TEST(V2_Column, triangles_converge_and_carry_the_weight) {
  std::vector<double> sizes, errors;
  for (const int n : {1, 2, 4}) {
    const auto solver = fem_solver<2>(column_2d("tri3", 2 * n, 8 * n));
    EXPECT_NEAR(probe(*solver, "reaction_bottom_y"), rho * g * 0.4 * height, 1e-8);
    EXPECT_NEAR(probe(*solver, "reaction_bottom_x"), 0, 1e-8);
    sizes.push_back(1.0 / n);
    errors.push_back(
        std::abs(probe(*solver, "low.uy") + rho * g * height * height * (0.25 - 1.0 / 32) / E));
  }
  verify({.id = "V2",
          .what = "order of displacement in h, linear column, FEM tri3",
          .exact = 2,
          .computed = last_rate(sizes, errors),
          .measure = Measure::order,
          .bound = 1.7});
}

TEST(V2_Column, own_weight_in_3d) {
  for (const std::string type : {"hex8", "tet4"}) {
    const Json json = {{"dimension", 3},
                       {"mesh", box_3d({0.4, 0.4, height}, {1, 1, 6}, type)},
                       {"material", elastic("linear_elastic", E, 0, rho)},
                       {"gravity", {0, 0, -g}},
                       {"analysis", "static"},
                       {"supports", {{{"group", "bottom"}, {"report_reaction", true}}}},
                       {"probes", {{{"name", "top"}, {"point", {0.4, 0.4, height}}}}}};
    const auto solver = fem_solver<3>(json);
    run_steps(*solver, 1, 1);
    verify({.id = "V2",
            .what = "reaction below a linear column, FEM " + type,
            .exact = rho * g * 0.16 * height,
            .computed = probe(*solver, "reaction_bottom_z"),
            .bound = 1e-11,
            .unit = "N"});
    if (type == "hex8") {
      EXPECT_NEAR(probe(*solver, "top.uz"), -rho * g * height * height / (2 * E), 1e-12);
    }
  }
}

/// Uniaxial strain to a stretch of 0.75, Hencky elastic with nu = 0: force per area of the
/// reference face = Kirchhoff stress / stretch = E ln(0.75) / 0.75.
TEST(V19_Compression, to_three_quarters) {
  const Json json = {{"dimension", 2},
                     {"mesh", box_2d({1, 1}, {3, 3})},
                     {"material", elastic("hencky_elastic", E, 0, 1)},
                     {"analysis", "static"},
                     {"supports",
                      {{{"group", "bottom"}, {"components", {"y"}}, {"report_reaction", true}},
                       {{"group", "left"}, {"components", {"x"}}},
                       {{"group", "right"}, {"components", {"x"}}}}},
                     {"prescribed", {{{"group", "top"}, {"component", "y"}, {"rate", -0.25}}}}};
  const auto solver = fem_solver<2>(json);
  run_steps(*solver, 0.25, 4);
  verify({.id = "V19",
          .what = "force at a stretch of 0.75, sides held, Hencky, FEM quad4",
          .exact = -E * std::log(0.75) / 0.75,
          .computed = probe(*solver, "reaction_bottom_y"),
          .bound = 1e-8,
          .unit = "N/m"});
}

}  // namespace
}  // namespace gabion::test
