// SPDX-License-Identifier: BSD-3-Clause
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>

#include "tests/support/convergence_rate.hpp"
#include "tests/support/verification_row.hpp"
#include "tests/unit/mpm/mpm_scene.hpp"

namespace gabion::test {
namespace {

constexpr double L = 30, E = 100, density = 1, h = 1;  // c = 10 m/s
const double c = std::sqrt(E / density);

/// Substeps as long as the step, up to twice the stable one.
const Json one_substep = {{"scheme", "explicit"}, {"courant", 2}};

/// A row of square cells between smooth walls, held at both ends.
template <int dim>
std::unique_ptr<mpm::MpmSolver<dim>> bar(const Json& scheme, const std::string& basis = "linear") {
  std::vector<double> low(dim, 0.0), high(dim, h);
  std::vector<int> count(dim, 1);
  high[0] = L;
  count[0] = static_cast<int>(L / h);
  const std::string type = dim == 2 ? "quad4" : "hex8";
  Json walls = {wall("left", "fixed"), wall("right", "fixed"), wall("bottom", "slip"),
                wall("top", "slip")};
  if (dim == 3) {
    walls.push_back(wall("front", "slip"));
    walls.push_back(wall("back", "slip"));
  }
  return mpm_solver<dim>({{"dimension", dim},
                          {"grid", box(low, high, count, type)},
                          {"basis", basis},
                          {"walls", walls},
                          {"bodies",
                           {body("bar", box(low, high, count, type), dim == 2 ? 4 : 8,
                                 elastic_soil("linear_elastic", E, 0, density))}},
                          {"time_integration", scheme}});
}

template <int dim, class Velocity>
void start_with(mpm::MpmSolver<dim>& solver, const Velocity& v_at) {
  std::vector<Vector<dim>> v;
  for (const auto& x : solver.points().x) v.push_back(v_at(x));
  solver.set_motion(v, std::vector<Vector<dim>>(v.size(), Vector<dim>::Zero()));
}

double energy(const Solver& solver) {
  return probe(solver, "kinetic_energy") + probe(solver, "elastic_energy");
}

double growth_of(Solver& solver, double before, double dt, int steps) {
  try {
    run_steps(solver, dt, steps);
  } catch (const ConvergenceError&) {
    return 1e30;
  }
  return energy(solver) / before;
}

/// Linear functions, two Gauss points a cell and direction: with s = sin^2(k h / 2) the frequencies
/// of mapped motion are omega^2 = 4 (c / h)^2 s (1 - 2 s / 3), the highest at s = 3/4.
template <int dim>
void check_limit() {
  const double limit = 2 / std::sqrt(1.5) * h / c, k = 2 * M_PI / 3 / h;
  const auto growth = [&](double share) {
    const auto solver = bar<dim>(one_substep);
    start_with<dim>(*solver, [&](const Vector<dim>& x) {
      return Vector<dim>(1e-6 * std::sin(k * x[0]) * Vector<dim>::Unit(0));
    });
    const double before = energy(*solver);
    return growth_of(*solver, before, share * limit, 40);
  };
  EXPECT_LT(growth(0.95), 100);
  EXPECT_GT(growth(1.05), 1e12);
  double stable = 0.9, unstable = 1.1;
  for (int halving = 0; halving < 3; ++halving) {
    const double share = 0.5 * (stable + unstable);
    (growth(share) < 100 ? stable : unstable) = share;
  }
  verify({.id = "V7",
          .what = fmt::format("explicit, largest stable step of a row of cells, MPM {}D", dim),
          .exact = limit,
          .computed = 0.5 * (stable + unstable) * limit,
          .bound = 0.05,
          .unit = "s"});
}
TEST(Explicit, limit_of_a_bar_2d) {
  check_limit<2>();
}
TEST(Explicit, limit_of_a_bar_3d) {
  check_limit<3>();
}

/// A bar that flies freely and swings in its first mode of free ends.
double free_mode(double end, int steps, const std::string& basis) {
  const auto solver = mpm_solver<2>({{"dimension", 2},
                                     {"grid", box({-2, 0}, {L + 2, h}, {34, 1}, "quad4")},
                                     {"basis", basis},
                                     {"walls", {wall("bottom", "slip"), wall("top", "slip")}},
                                     {"bodies",
                                      {body("bar", box({0.3, 0}, {L + 0.3, h}, {30, 1}, "quad4"), 4,
                                            elastic_soil("linear_elastic", E, 0, density))}},
                                     {"time_integration", one_substep}});
  start_with<2>(*solver, [&](const Vector<2>& x) {
    return Vector<2>(1e-3 * std::cos(M_PI * (x[0] - 0.3) / L) * Vector<2>::Unit(0));
  });
  run_steps(*solver, end / steps, steps);
  return solver->points().u[2][0];
}

TEST(V7_VibratingBar, explicit_second_order_in_the_time_step) {
  constexpr double end = 4;
  for (const std::string basis : {"linear", "gimp", "bspline"}) {
    const double reference = free_mode(end, 1280, basis);
    std::vector<double> sizes, errors;
    for (const int steps : {40, 80, 160}) {
      sizes.push_back(end / steps);
      errors.push_back(std::abs(free_mode(end, steps, basis) - reference));
    }
    verify({.id = "V7",
            .what = "order in dt, explicit, bar with free ends, MPM quad4 " + basis,
            .exact = 2,
            .computed = lowest_rate(sizes, errors),
            .measure = Measure::order,
            .bound = 1.9});
  }
}

/// d'Alembert: a bump of velocity splits into two halves that run apart.
template <int dim>
void check_wave(const std::string& basis) {
  const auto solver = bar<dim>({{"scheme", "explicit"}}, basis);
  const double v0 = 1e-3, width = 5 * h, end = 0.6;
  const auto bump = [&](double x) { return std::exp(-x * x / (width * width)); };
  start_with<dim>(*solver, [&](const Vector<dim>& x) {
    return Vector<dim>(v0 * bump(x[0] - L / 2) * Vector<dim>::Unit(0));
  });
  run_steps(*solver, end / 3, 3);
  double difference = 0, size = 0;
  const auto& points = solver->points();
  for (std::int32_t p = 0; p < points.size(); ++p) {
    const double x = points.x[p][0] - L / 2;
    const double exact = v0 / 2 * (bump(x - c * end) + bump(x + c * end));
    difference += std::pow(points.v[p][0] - exact, 2);
    size += exact * exact;
  }
  verify({.id = "V7",
          .what = fmt::format("explicit, a wave after 6 cells, 5 cells wide: velocity, rms error "
                              "over rms, MPM {} {}D",
                              basis, dim),
          .exact = 0,
          .computed = std::sqrt(difference / size),
          .measure = Measure::absolute_error,
          .bound = 0.05});
}
TEST(V7_VibratingBar, explicit_wave) {
  for (const std::string basis : {"linear", "gimp", "bspline"}) {
    check_wave<2>(basis);
    check_wave<3>(basis);
  }
}

/// A block of cells, `shift` cells beside those of the grid, whose points get small random
/// velocities.
struct Noise {
  std::string type, basis = "linear";
  int points_per_cell;
  double nu, shift;
};

/// Highest stable share of StableStep's limit, by halving.
template <int dim>
double stable_courant(const Noise& noise) {
  const int n = dim == 2 ? 10 : 5;
  const std::vector<double> low(dim, 0.0), high(dim, n), start(dim, 1 + noise.shift),
      end(dim, n - 2 + noise.shift);
  const Json mesh = box(start, end, std::vector<int>(dim, n - 3), noise.type);
  const Json soil = elastic_soil("linear_elastic", E, noise.nu, density);
  const double wave = std::sqrt(E * (1 - noise.nu) / (1 + noise.nu) / (1 - 2 * noise.nu) / density);
  const std::map<std::string, double> size = {
      {"quad4", h}, {"hex8", h}, {"tri3", 2. / 3 * h}, {"tet4", 0.5 * h}};
  double stable = 0.5, unstable = 2;
  for (int k = 0; k < 5; ++k) {
    const double courant = 0.5 * (stable + unstable);
    const auto solver =
        mpm_solver<dim>({{"dimension", dim},
                         {"grid", box(low, high, std::vector<int>(dim, n), noise.type)},
                         {"basis", noise.basis},
                         {"bodies", {body("block", mesh, noise.points_per_cell, soil)}},
                         {"locking", {{"method", "none"}}},
                         {"time_integration", {{"scheme", "explicit"}, {"courant", 2}}}});
    std::mt19937 random(1);
    std::uniform_real_distribution<double> any(-1e-9, 1e-9);
    start_with<dim>(*solver, [&](const Vector<dim>&) {
      Vector<dim> v;
      for (int d = 0; d < dim; ++d) v[d] = any(random);
      return v;
    });
    const double before = energy(*solver);
    const double growth = growth_of(*solver, before, courant * size.at(noise.type) * h / wave, 120);
    (growth < 100 ? stable : unstable) = courant;
  }
  return stable;
}

/// The default, 0.9, is stable for all bases, cells and cuts, nu up to 0.45.
TEST(Explicit, margin_of_the_stable_step) {
  double least_2d = 2, least_3d = 2;
  for (const double shift : {0.0, 0.5, 0.9, 0.99999}) {
    for (const std::string basis : {"linear", "gimp", "bspline"}) {
      least_2d = std::min(least_2d, stable_courant<2>({"quad4", basis, 4, 0.45, shift}));
    }
    for (const int ppc : {1, 3}) {
      least_2d = std::min(least_2d, stable_courant<2>({"tri3", "linear", ppc, 0.3, shift}));
    }
  }
  for (const double shift : {0.0, 0.99999}) {
    for (const std::string basis : {"linear", "gimp", "bspline"}) {
      least_3d = std::min(least_3d, stable_courant<3>({"hex8", basis, 8, 0.3, shift}));
    }
    least_3d = std::min(least_3d, stable_courant<3>({"tet4", "linear", 4, 0.3, shift}));
  }
  const auto check = [](const char* of, double least, double wanted) {
    verify({.id = "V7",
            .what = fmt::format("explicit, largest stable step over h_eff / c, least of all bases "
                                "and cuts, MPM {}: below {}",
                                of, wanted),
            .exact = 0,
            .computed = std::max(0.0, wanted - least),
            .measure = Measure::absolute_error,
            .bound = 0});
  };
  check("2D", least_2d, 1.3);
  check("3D", least_3d, 1.2);
}

/// A block that flies without rotation and swings: what it has it keeps.
template <int dim>
void check_free_flight(const std::string& basis, const Json& locking) {
  std::vector<double> low(dim, 0.0), high(dim, 8.0), start(dim, 2.3), end(dim, 5.3);
  const auto solver = mpm_solver<dim>(
      {{"dimension", dim},
       {"grid", box(low, high, std::vector<int>(dim, 8), dim == 2 ? "quad4" : "hex8")},
       {"basis", basis},
       {"locking", locking},
       {"gravity", std::vector<double>(dim, 0.1)},
       {"bodies",
        {body("block", box(start, end, std::vector<int>(dim, 3), dim == 2 ? "quad4" : "hex8"),
              dim == 2 ? 4 : 8, elastic_soil("neo_hookean", E, 0.3, density))}},
       {"time_integration", {{"scheme", "explicit"}}}});
  start_with<dim>(*solver, [&](const Vector<dim>& x) {
    return Vector<dim>(Vector<dim>::Constant(0.5) + 0.1 * (x - Vector<dim>::Constant(3.8)));
  });
  const double mass = probe(*solver, "mass"), before = energy(*solver);
  run_steps(*solver, 0.5, 4);
  for (const std::string axis : {"x", "y"}) {
    EXPECT_LT(std::abs(probe(*solver, "momentum_error_" + axis)), 1e-13 * mass) << basis;
    EXPECT_NEAR(probe(*solver, "momentum_" + axis), (0.5 + 2 * 0.1) * mass, 1e-12 * mass) << basis;
  }
  verify(
      {.id = "V18",
       .what = fmt::format("explicit, block in free flight: error of the energy balance over the "
                           "energy, MPM {} {}D{}",
                           basis, dim, locking["method"] == "fbar" ? ", F-bar" : ""),
       .exact = 0,
       .computed = probe(*solver, "energy_balance") / before,
       .measure = Measure::absolute_error,
       .bound = 1e-3});
  // F-bar takes elastic energy when it shares volumes; the transfer takes none.
  if (locking["method"] == "fbar") return;
  EXPECT_LT(std::abs(probe(*solver, "transfer_loss")), 1e-13 * before) << basis;
}
TEST(Explicit, free_flight) {
  const Json none = {{"method", "none"}}, fbar = {{"method", "fbar"}};
  for (const std::string basis : {"linear", "gimp", "bspline"}) {
    for (const Json& locking : {none, fbar}) {
      check_free_flight<2>(basis, locking);
      check_free_flight<3>(basis, locking);
    }
  }
}

}  // namespace
}  // namespace gabion::test
