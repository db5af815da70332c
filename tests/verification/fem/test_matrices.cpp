// SPDX-License-Identifier: BSD-3-Clause
// A structure as matrices: against the mesh that the matrices are from, against CalculiX, against
// closed forms of a single mode, and against itself without reduction.
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "fem_solver/matrices/lowest_modes.hpp"
#include "fem_solver/matrices/matrix_files.hpp"
#include "tests/support/convergence_rate.hpp"
#include "tests/support/verification_row.hpp"
#include "tests/unit/fem/matrix_scene.hpp"

namespace gabion::test {
namespace {

const Json trapezoid = {{"scheme", "newmark"}};
const Json bossak = {{"scheme", "bossak"}, {"alpha", -0.1}};
const Json generalized = {{"scheme", "generalized_alpha"}, {"rho_inf", 0.6}};

/// A cantilever of 1 m, clamped at its foot, with an interface on one face. Units: kg, m, s.
template <int dim>
Json cantilever(const Json& scheme) {
  Json json = {{"dimension", dim},
               {"material", elastic("linear_elastic", 1e7, 0.3, 1000)},
               {"newton", {{"residual_tolerance", 1e-12}}},
               {"supports", {{{"group", "bottom"}}}},
               {"interfaces", {{{"name", "wall"}, {"groups", {"left"}}}}}};
  if (!scheme.is_null()) json["time_integration"] = scheme;
  if constexpr (dim == 2) {
    json["mesh"] = box_2d({0.1, 1}, {3, 20});
    json["probes"] = {{{"name", "tip"}, {"point", {0.1, 1}}}};
  } else {
    json["mesh"] = box_3d({0.1, 0.2, 1}, {2, 2, 10});
    json["probes"] = {{{"name", "tip"}, {"point", {0.1, 0.2, 1}}}};
  }
  return json;
}

/// 100 N on the interface, an equal part a vertex, along x.
template <int dim>
InterfaceValues push(const Solver& solver, double factor) {
  const auto count = static_cast<std::size_t>(solver.interfaces()[0].num_vertices());
  std::vector<double> f(count * dim, 0.0);
  for (std::size_t i = 0; i < f.size(); i += dim) f[i] = 100 * factor / static_cast<double>(count);
  return {{"wall", f}};
}

/// Displacement of the tip and of the interface after each of some steps under a push that lasts 20
/// ms, a static one where dt is 1.
template <int dim>
std::vector<double> history(Solver& solver, double dt, int steps) {
  std::vector<double> result;
  for (int n = 1; n <= steps; ++n) {
    const StepRequest request{n, 0, (n - 1) * dt, dt};
    InterfaceValues sent;
    const double share = std::min(n * dt / 0.02, 1.0);
    const double pulse = std::pow(std::sin(std::numbers::pi * share), 2);
    solver.solve_step(request, push<dim>(solver, dt == 1 ? 1 : pulse), sent);
    solver.accept_step(request, true);
    result.push_back(probe(solver, "tip.ux"));
    const auto& wall = sent.at("wall");
    result.insert(result.end(), wall.begin(), wall.end());
  }
  return result;
}

double difference(const std::vector<double>& x, const std::vector<double>& exact) {
  double error = 0, largest = 0;
  for (std::size_t i = 0; i < x.size(); ++i) {
    error = std::max(error, std::abs(x[i] - exact[i]));
    largest = std::max(largest, std::abs(exact[i]));
  }
  return error / largest;
}

void verify_zero(const std::string& what, double found, double bound) {
  verify({.id = "matrices",
          .what = what,
          .exact = 0,
          .computed = found,
          .measure = Measure::absolute_error,
          .bound = bound});
}

template <int dim>
void compare_with_mesh() {
  const std::string in_dim = dim == 2 ? ", 2D" : ", 3D";
  Json json = cantilever<dim>(nullptr);
  json["analysis"] = "static";
  const auto at_rest = MatrixScene::of<dim>(json);
  verify_zero("static against the mesh" + in_dim,
              difference(history<dim>(*at_rest.template solver<dim>(), 1, 1),
                         history<dim>(*fem_solver<dim>(json), 1, 1)),
              1e-10);
  for (const Json& scheme : {trapezoid, bossak}) {
    json = cantilever<dim>(scheme);
    const auto moving = MatrixScene::of<dim>(json);
    verify_zero("40 steps against the mesh, " + scheme["scheme"].get<std::string>() + in_dim,
                difference(history<dim>(*moving.template solver<dim>(), 1e-3, 40),
                           history<dim>(*fem_solver<dim>(json), 1e-3, 40)),
                1e-9);
  }
}

TEST(matrices_Mesh, equal_to_rounding) {
  compare_with_mesh<2>();
  compare_with_mesh<3>();
}

/// Two C3D8 of CalculiX 2.20 (cantilever.inp): its own frequencies and its static answer to 1 N on
/// each node of the end, as it prints them, with 7 digits.
class CalculixFiles : public testing::Test {
 protected:
  CalculixFiles() {
    for (const char* ending : {".sti", ".mas", ".dof"}) {
      const std::string name = std::string("cantilever") + ending;
      std::filesystem::copy_file(std::string(CALCULIX_FILES) + "/" + name, scene_.path(name));
    }
    scene_.write("nodes.csv",
                 "5,0,0,0.5\n6,0.1,0,0.5\n7,0,0.2,0.5\n8,0.1,0.2,0.5\n"
                 "9,0,0,1\n10,0.1,0,1\n11,0,0.2,1\n12,0.1,0.2,1\n");
    scene_.write("end.csv", "9,10,12,11\n");
    scene_.json = {{"dimension", 3},
                   {"analysis", "static"},
                   {"matrices",
                    {{"stiffness", "cantilever.sti"},
                     {"mass", "cantilever.mas"},
                     {"unknowns", "cantilever.dof"},
                     {"nodes", "nodes.csv"}}},
                   {"interfaces", {{{"name", "end"}, {"facets", "end.csv"}}}}};
  }
  MatrixScene scene_;
};

using matrices_CalculiX = CalculixFiles;

constexpr double half_a_digit = 5e-7;

TEST_F(matrices_CalculiX, its_frequencies_and_its_static_answer) {
  const auto solver = scene_.solver<3>();
  const fem::Modes modes = fem::lowest_modes(solver->structure().model, 3);
  const double frequencies[] = {5.160919, 5.827730, 13.81795};
  for (int k = 0; k < 3; ++k) {
    verify({.id = "matrices",
            .what = "frequency " + std::to_string(k + 1) + " of CalculiX's matrices",
            .exact = frequencies[k],
            .computed = std::sqrt(modes.omega2[k]) / (2 * std::numbers::pi),
            .bound = half_a_digit,
            .unit = "Hz"});
  }
  InterfaceValues sent;
  solver->solve_step({1, 0, 0, 1}, {{"end", {1, 0, 0, 1, 0, 0, 1, 0, 0, 1, 0, 0}}}, sent);
  verify({.id = "matrices",
          .what = "static answer of CalculiX's matrices",
          .exact = 7.405433e-4,
          .computed = sent.at("end")[0],
          .bound = half_a_digit,
          .unit = "m"});
  EXPECT_NEAR(sent.at("end")[2], 5.517159e-5, half_a_digit * 5.517159e-5);
}

/// Shape and frequency of the first mode of the plane cantilever.
fem::Modes first_mode(const fem::MatrixSolver<2>& solver) {
  return fem::lowest_modes(solver.structure().model, 1);
}

/// Error of the first mode's amplitude after 0.9 periods, with damping C = 2 delta M:
/// q = sin(omega_d t) exp(-delta t) / omega_d, omega_d^2 = omega^2 - delta^2, from q' = 1.
double mode_error(MatrixScene& scene, double damping_ratio, int steps_per_period) {
  const fem::Modes mode = first_mode(*scene.solver<2>());
  const double omega = std::sqrt(mode.omega2[0]), delta = damping_ratio * omega;
  if (delta > 0) scene.json["matrices"]["rayleigh"] = {{"mass", 2 * delta}};
  const auto solver = scene.solver<2>();
  const Eigen::VectorXd shape = mode.shapes.col(0);
  solver->set_motion(Eigen::VectorXd::Zero(shape.size()), shape);
  const double period = 2 * std::numbers::pi / omega;
  const int steps = steps_per_period * 9 / 10;
  run_steps(*solver, period / steps_per_period, steps);
  const double t = 0.9 * period, omega_d = std::sqrt(omega * omega - delta * delta);
  const double exact = std::sin(omega_d * t) * std::exp(-delta * t) / omega_d;
  return std::abs(shape.dot(solver->structure().model.M * solver->state().u) - exact) * omega;
}

TEST(matrices_Time, second_order_in_dt) {
  for (const double ratio : {0.0, 0.05}) {
    for (const Json& scheme : {trapezoid, bossak, generalized}) {
      Json json = cantilever<2>(scheme);
      json.erase("interfaces");
      MatrixScene scene = MatrixScene::of<2>(json);
      std::vector<double> sizes, errors;
      for (const int n : {40, 80, 160}) {
        sizes.push_back(1.0 / n);
        errors.push_back(mode_error(scene, ratio, n));
      }
      verify({.id = "matrices",
              .what = "order in dt, " + scheme["scheme"].get<std::string>() +
                      (ratio > 0 ? ", 5 % damping" : ", no damping"),
              .exact = 2,
              .computed = lowest_rate(sizes, errors),
              .measure = Measure::order,
              .bound = 1.9});
      EXPECT_LT(lowest_rate(sizes, errors), 2.2);
    }
  }
}

TEST(matrices_Energy, kept_by_the_trapezoidal_rule) {
  for (const bool reduced : {false, true}) {
    MatrixScene scene = MatrixScene::of<2>(cantilever<2>(trapezoid));
    if (reduced) scene.json["matrices"]["modes"] = 5;
    const auto solver = scene.solver<2>();
    history<2>(*solver, 1e-3, 20);
    const auto energy = [&] {
      return probe(*solver, "kinetic_energy") + probe(*solver, "elastic_energy");
    };
    const double start = energy();
    double drift = 0;
    for (int n = 21; n <= 200; ++n) {
      run_steps(*solver, 1e-3, 1, n);
      drift = std::max(drift, std::abs(energy() / start - 1));
    }
    verify_zero(std::string("largest energy drift in 180 steps, trapezoidal rule") +
                    (reduced ? ", 5 modes" : ""),
                drift, 1e-10);
  }
}

/// The cantilever with an interface at its end only: a static answer needs no mode, a dynamic one
/// comes closer with each.
TEST(matrices_CraigBampton, static_exact_and_dynamic_converges) {
  Json moving = cantilever<2>(trapezoid), at_rest = cantilever<2>(nullptr);
  at_rest["analysis"] = "static";
  for (Json* json : {&moving, &at_rest}) (*json)["interfaces"][0]["groups"] = {"top"};
  MatrixScene scene = MatrixScene::of<2>(moving), still = MatrixScene::of<2>(at_rest);
  const auto full = history<2>(*scene.solver<2>(), 1e-3, 60);
  const auto exact = history<2>(*still.solver<2>(), 1, 1);
  const int interior = scene.solver<2>()->structure().model.size() - 2 * 4;
  double before = 1;
  for (const int modes : {0, 1, 2, 4, 8, 16, interior}) {
    scene.json["matrices"]["modes"] = still.json["matrices"]["modes"] = modes;
    const std::string with = fmt::format(", {} of {} modes", modes, interior);
    verify_zero("static" + with, difference(history<2>(*still.solver<2>(), 1, 1), exact), 1e-10);
    const double error = difference(history<2>(*scene.solver<2>(), 1e-3, 60), full);
    verify_zero("60 steps" + with, error, modes == interior ? 1e-9 : before);
    before = error;
  }
}

/// LAPACK finds all modes at once, Krylov and Schur the lowest ones.
TEST(matrices_Modes, both_ways_agree) {
  Json json = cantilever<2>(trapezoid);
  json["mesh"] = box_2d({0.1, 1}, {4, 45});
  const auto model = MatrixScene::of<2>(json).solver<2>()->structure().model;
  ASSERT_GT(model.size(), 400);
  const fem::Modes few = fem::lowest_modes(model, 8), many = fem::lowest_modes(model, 180);
  double error = 0;
  for (int k = 0; k < 8; ++k) {
    error = std::max(error, std::abs(few.omega2[k] / many.omega2[k] - 1));
    EXPECT_NEAR(std::abs(few.shapes.col(k).dot(model.M * many.shapes.col(k))), 1, 1e-8);
  }
  verify_zero("omega^2 of 8 modes of 450 by Krylov and Schur against LAPACK", error, 1e-8);
  // Euler and Bernoulli in plane strain, 3.516 / L^2 sqrt(EI / rho A): shear and quad4 differ.
  const double EI_by_rhoA = 1e7 / (1 - 0.3 * 0.3) * 0.01 / 12 / 1000;
  verify({.id = "matrices",
          .what = "first frequency of a slender cantilever, 4 x 45 quad4",
          .exact = 3.516 * std::sqrt(EI_by_rhoA),
          .computed = std::sqrt(few.omega2[0]),
          .bound = 0.02,
          .unit = "1/s"});
}

}  // namespace
}  // namespace gabion::test
