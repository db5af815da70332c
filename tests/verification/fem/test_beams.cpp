// SPDX-License-Identifier: BSD-3-Clause
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <Eigen/Eigenvalues>
#include <cmath>
#include <numbers>

#include "tests/support/verification_row.hpp"
#include "tests/unit/fem/beam_scene.hpp"
#include "tests/verification/elastica.hpp"

namespace gabion::test {
namespace {

using Eigen::MatrixXd;
using Eigen::VectorXd;
using std::numbers::pi;

/// Hardly stretches or shears: E I = 1, E A = 1e6 for length 1.
Json slender_material() {
  return beam_material(1e6, 0, general_section(2, 1e-6, 2e-6));
}

/// Tip of a cantilever of length 1 under a dead load across its axis.
Vector<2> tip_of(int cells, double alpha) {
  const TemporaryMesh mesh(chain(1, cells).file());
  Json json = cantilever_of_beams(2, mesh.path(), slender_material(), 1);
  json["loads"] = {rising_load({0, alpha})};
  const auto solver = fem_solver<2>(json);
  for (int n = 1; n <= 20; ++n) advance(*solver, n, 0.05);
  return {1 + probe(*solver, "tip.ux"), probe(*solver, "tip.uy")};
}

TEST(beams_Elastica, dead_load_across_a_cantilever) {
  constexpr double alpha = 10;
  const Elastica exact(alpha);
  double errors[3] = {};
  for (int k = 0; k < 3; ++k) {
    const int cells = 8 << k;
    errors[k] = std::abs(tip_of(cells, alpha)[1] - exact.deflection);
  }
  verify({.id = "beams",
          .what = "elastica, alpha = 10, 32 beams: deflection of the tip over L",
          .exact = exact.deflection,
          .computed = tip_of(32, alpha)[1],
          .bound = 2e-4});
  verify({.id = "beams",
          .what = "elastica, alpha = 10, 32 beams: place of the tip along the axis over L",
          .exact = 1 - exact.shortening,
          .computed = tip_of(32, alpha)[0],
          .bound = 1e-3});
  verify({.id = "beams",
          .what = "elastica, 16 and 32 beams: order of the deflection",
          .exact = 2,
          .computed = std::log2(errors[1] / errors[2]),
          .measure = Measure::order,
          .bound = 1.9});
}

TEST(beams_Circle, a_moment_rolls_a_cantilever_up) {
  for (const int cells : {4, 16}) {
    const TemporaryMesh mesh(chain(1, cells).file());
    Json json = cantilever_of_beams(2, mesh.path(), slender_material(), 1);
    Json load = rising_load({0, 0});
    load["moment"] = {2 * pi};
    json["loads"] = {load};
    json["newton"] = {{"residual_tolerance", 1e-12}};
    const auto solver = fem_solver<2>(json);
    for (int n = 1; n <= 10; ++n) advance(*solver, n, 0.1);
    verify({.id = "beams",
            .what = fmt::format("moment 2 pi E I / L, {} beams: tip from the clamp over L", cells),
            .exact = 0,
            .computed = std::hypot(1 + probe(*solver, "tip.ux"), probe(*solver, "tip.uy")),
            .measure = Measure::absolute_error,
            .bound = 1e-9});
  }
}

/// Tip of the 45 degree bend of Bathe and Bolourchi (1979): radius 100, section 1 x 1, E 1e7,
/// nu 0, force out of the plane in steps of 50; torsion constant 1/6 as Simo and Vu-Quoc (1986).
Vector<3> bend_tip(int cells, double force) {
  LineText text = chain(1, cells);
  for (int i = 0; i <= cells; ++i) {
    const double angle = pi / 4 * i / cells;
    text.nodes[i] = {100 * std::sin(angle), 100 * (1 - std::cos(angle)), 0};
  }
  const auto& end = text.nodes.back();
  const TemporaryMesh mesh(text.file());
  Json json =
      line_scene(3, mesh.path(), beam_material(1e7, 0, general_section(1, 1.0 / 12, 1.0 / 6)));
  json["analysis"] = "static";
  json["supports"] = {clamp(3)};
  json["probes"] = {{{"name", "tip"}, {"point", {end[0], end[1], 0.0}}}};
  json["loads"] = {{{"group", "high"}, {"force", {0, 0, 50}}, {"table", {{0, 0}, {12, 12}}}}};
  const auto solver = fem_solver<3>(json);
  for (int n = 1; n <= std::lround(force / 50); ++n) advance(*solver, n, 1);
  return {end[0] + probe(*solver, "tip.ux"), end[1] + probe(*solver, "tip.uy"),
          probe(*solver, "tip.uz")};
}

/// Computed once with another program for the same beam, written from its equations alone.
TEST(beams_Bend, a_bent_cantilever_out_of_its_plane) {
  struct Case {
    int cells;
    double force;
    Vector<3> tip;
  };
  const Case cases[] = {{8, 300, {58.861, 22.296, 40.077}},
                        {8, 600, {47.260, 15.742, 53.374}},
                        {16, 600, {47.178, 15.699, 53.449}}};
  for (const auto& [cells, force, tip] : cases) {
    const Vector<3> found = bend_tip(cells, force);
    for (int c = 0; c < 3; ++c) {
      verify({.id = "beams",
              .what = fmt::format("45 degree bend, {} beams, force {}: {} of the tip", cells, force,
                                  fem::component_names[c]),
              .exact = tip[c],
              .computed = found[c],
              .bound = 5e-5});
    }
  }
}

/// A cantilever along x in the plane: stiffness in a state of plain compression, and mass.
struct LinearCantilever {
  fem::FemSettings<2> settings;
  fem::CellIntegrals<2> cells{settings.mesh,
                              settings.materials,
                              false,
                              {},
                              fem::LinesOfMesh<2>{settings.line_materials, settings.beam_nodes()}};

  static LinearCantilever of(int cells, double density) {
    const TemporaryMesh mesh(chain(1, cells).file());
    Json material = slender_material();
    material["density"] = density;
    return {fem_settings<2>(cantilever_of_beams(2, mesh.path(), material, 1))};
  }
  std::vector<int> free_unknowns() const {
    std::vector<int> free;
    const int places = settings.num_places();
    for (int i = 1; i < places; ++i) free.insert(free.end(), {2 * i, 2 * i + 1});
    for (int i = 1; i < places; ++i) free.push_back(2 * (places + i));
    return free;
  }
  MatrixXd dense(const BlockMatrix<2>& K) const {
    const int n = 2 * K.num_nodes();
    MatrixXd all(n, n);
    for (int i = 0; i < n; ++i) {
      std::vector<double> x(n, 0.0), y(n, 0.0);
      x[i] = 1;
      K.multiply(x, y);
      all.col(i) = Eigen::Map<VectorXd>(y.data(), n);
    }
    const auto free = free_unknowns();
    return all(free, free);
  }
  /// @param strain  of all beams
  MatrixXd stiffness(double strain) const {
    BlockMatrix<2> K;
    cells.set_pattern(K);
    K.set_zero();
    std::vector<double> u(2 * settings.mesh.nodes.size(), 0.0), f = u;
    for (int i = 0; i < settings.num_places(); ++i) u[2 * i] = strain * settings.mesh.nodes[i][0];
    cells.add_internal(u, f, &K);
    return dense(K);
  }
  MatrixXd mass() const {
    BlockMatrix<2> M;
    cells.set_pattern(M);
    M.set_zero();
    cells.add_mass(1, M);
    return dense(M);
  }
};

/// The compression at which the stiffness of a straight cantilever is singular.
double buckling_load(int cells) {
  const auto beam = LinearCantilever::of(cells, 1);
  double low = 0, high = 4;
  for (int k = 0; k < 50; ++k) {
    const double P = 0.5 * (low + high);
    const Eigen::SelfAdjointEigenSolver<MatrixXd> modes(beam.stiffness(-P / 1e6),
                                                        Eigen::EigenvaluesOnly);
    (modes.eigenvalues()[0] > 0 ? low : high) = P;
  }
  return low;
}

TEST(beams_Buckling, euler_load_of_a_cantilever) {
  const double exact = pi * pi / 4;
  const double coarse = buckling_load(16), fine = buckling_load(32);
  verify({.id = "beams",
          .what = "cantilever of 32 beams: buckling load over E I / L^2",
          .exact = exact,
          .computed = fine,
          .bound = 1e-3});
  verify({.id = "beams",
          .what = "cantilever of 16 and 32 beams: order of the buckling load",
          .exact = 2,
          .computed = std::log2((coarse - exact) / (fine - exact)),
          .measure = Measure::order,
          .bound = 1.9});
}

TEST(beams_Frequencies, of_a_cantilever) {
  const auto beam = LinearCantilever::of(32, 1);
  const Eigen::GeneralizedSelfAdjointEigenSolver<MatrixXd> modes(beam.stiffness(0), beam.mass());
  const double roots[] = {1.87510407, 4.69409113, 7.85475744};
  const double bounds[] = {1e-3, 3e-3, 8e-3};
  for (int k = 0; k < 3; ++k) {
    verify({.id = "beams",
            .what = fmt::format("cantilever of 32 beams: frequency {} [rad/s]", k + 1),
            .exact = roots[k] * roots[k],
            .computed = std::sqrt(modes.eigenvalues()[k]),
            .bound = bounds[k],
            .unit = "rad/s"});
  }
}

/// Largest force of Lee's frame, both ends pinned, pushed down at 24 cm from the corner.
double lee_limit(int column, int beam) {
  LineText text;
  std::vector<std::vector<int>> lines;
  for (int i = 0; i <= column; ++i) text.nodes.push_back({0, 120.0 * i / column, 0});
  for (int i = 1; i <= beam; ++i) text.nodes.push_back({120.0 * i / beam, 120, 0});
  for (int i = 1; i <= column + beam; ++i) lines.push_back({i, i + 1});
  const int loaded = column + beam / 5 + 1;
  text.lines = {{"rope", lines}};
  text.points = {{"feet", {1, column + beam + 1}}, {"loaded", {loaded}}};
  const TemporaryMesh mesh(text.file());
  const Json section = {{"shape", "general"},
                        {"area", 6},
                        {"shear_areas", {5, 5}},
                        {"second_moments", {2, 2}},
                        {"torsion_constant", 4}};
  Json json = line_scene(2, mesh.path(), beam_material(720, 0.3, section));
  json["analysis"] = "static";
  json["newton"] = {{"max_iterations", 60}};
  json["supports"] = {{{"group", "feet"}}};
  json["prescribed"] = {{{"group", "loaded"}, {"component", "y"}, {"rate", -1.0}}};
  const auto solver = fem_solver<2>(json);
  double largest = 0;
  for (int n = 1; n <= 110; ++n) {
    advance(*solver, n, 0.5);
    largest = std::max(largest, -solver->state().reactions[2 * (loaded - 1) + 1]);
  }
  return largest;
}

/// 1.85 is published; the same equations in another program give 1.887 and 1.862.
TEST(beams_LeeFrame, limit_load) {
  verify({.id = "beams",
          .what = "Lee's frame, 8 + 10 beams: limit load",
          .exact = 1.887,
          .computed = lee_limit(8, 10),
          .bound = 2e-3});
  verify({.id = "beams",
          .what = "Lee's frame, 16 + 20 beams: limit load",
          .exact = 1.862,
          .computed = lee_limit(16, 20),
          .bound = 2e-3});
}

/// Deflection of a post under the pressure of soil at rest, q (1 - z / L) per metre, as nodal
/// loads: of beams, and of enhanced hexahedra.
TEST(beams_Post, as_the_same_post_in_solids) {
  constexpr double L = 2, side = 0.2, E = 1e7, q = 100;
  constexpr int cells = 20;
  const auto load_at = [&](int i) {
    const double h = L / cells, z = i * h;
    const double share = i == 0       ? h / 2 - h * h / (6 * L)
                         : i == cells ? h * h / (6 * L)
                                      : h * (1 - z / L);
    return q * share;
  };
  LineText text = chain(L, cells);
  for (auto& node : text.nodes) node = {0, 0, node[0]};
  const TemporaryMesh mesh(text.file());
  Json material = beam_material(E, 0.2, rectangle(side, side));
  Json json = line_scene(3, mesh.path(), material);
  json["analysis"] = "static";
  json["supports"] = {clamp(3)};
  json["probes"] = {{{"name", "top"}, {"point", {0.0, 0.0, L}}}};
  Json solid = {
      {"dimension", 3},
      {"mesh", box_3d({side, side, L}, {2, 2, cells})},
      {"material", elastic("neo_hookean", E, 0.2, 1)},
      {"analysis", "static"},
      {"supports", {{{"group", "bottom"}, {"report_reaction", true}, {"report_moment", true}}}},
      {"probes", {{{"name", "top"}, {"point", {side / 2, side / 2, L}}}}}};
  solid["material"]["formulation"] = "enhanced";
  for (int i = 0; i <= cells; ++i) {
    const double z = L * i / cells;
    json["loads"].push_back({{"point", {0.0, 0.0, z}}, {"force", {load_at(i), 0, 0}}});
    solid["loads"].push_back({{"point", {side / 2, side / 2, z}}, {"force", {load_at(i), 0, 0}}});
  }
  const auto beams = fem_solver<3>(json), solids = fem_solver<3>(solid);
  advance(*beams, 1, 1);
  advance(*solids, 1, 1);
  const double I = std::pow(side, 4) / 12;
  verify({.id = "beams",
          .what = "post under a triangle of pressure, 20 beams: top, by beam theory",
          .exact = q * std::pow(L, 4) / (30 * E * I),
          .computed = probe(*beams, "top.ux"),
          .bound = 0.02,
          .unit = "m"});
  verify({.id = "beams",
          .what = "post under a triangle of pressure: top, of beams against solids",
          .exact = probe(*solids, "top.ux"),
          .computed = probe(*beams, "top.ux"),
          .bound = 0.03,
          .unit = "m"});
  verify({.id = "beams",
          .what = "post under a triangle of pressure: moment at the foot",
          .exact = -q * L * L / 6,
          .computed = probe(*beams, "moment_low_y"),
          .bound = 0.01,
          .unit = "N m"});
}

}  // namespace
}  // namespace gabion::test
