// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cmath>
#include <functional>
#include <numbers>

#include "tests/unit/mpm/mpm_scene.hpp"
#include "tests/verification/elastic_laws.hpp"

namespace gabion::test {

/// A motion u(X, t) that starts from u = 0 and the body acceleration that makes it a solution,
/// rho0 u_tt = Div P(F) + rho0 b, for neo-Hookean material.
template <int dim>
struct Manufactured {
  using Field = std::function<Vector<dim>(const Vector<dim>& X, double t)>;
  Field u;  ///< [m]
  Field v;  ///< [m/s]
  Field b;  ///< [m/s^2]
  double E = 0, nu = 0, density = 0;
  double size = 0;  ///< largest |u| [m]
  double end = 0;   ///< [s]
};

/// Standing wave along x, one wave length on the bar 0 < X < 1, nu = 0, amplitude A,
///
///     u = A sin(2 pi X) sin(pi c t) ,  P = E / 2 (F - 1 / F) ,  b = pi^2 c^2 u (1 + 2 / F^2)
///
/// since u_tt = -pi^2 c^2 u and dP/dX = E / 2 (1 + 1 / F^2) u'' with u'' = -4 pi^2 u, E = rho c^2.
template <int dim>
Manufactured<dim> standing_wave(double A) {
  using std::numbers::pi;
  constexpr double c = 100;
  const auto along_x = [](double value) -> Vector<dim> { return Vector<dim>::Unit(0) * value; };
  const auto u = [=](double X, double t) {
    return A * std::sin(2 * pi * X) * std::sin(pi * c * t);
  };
  return {.u = [=](const Vector<dim>& X, double t) { return along_x(u(X[0], t)); },
          .v =
              [=](const Vector<dim>& X, double t) {
                return along_x(A * pi * c * std::sin(2 * pi * X[0]) * std::cos(pi * c * t));
              },
          .b =
              [=](const Vector<dim>& X, double t) {
                const double F = 1 + 2 * pi * A * std::cos(2 * pi * X[0]) * std::sin(pi * c * t);
                return along_x(pi * pi * c * c * u(X[0], t) * (1 + 2 / (F * F)));
              },
          .E = 1e7,
          .nu = 0,
          .density = 1e3,
          .size = A,
          .end = 1 / c};
}

/// Axis-aligned waves in the unit square (3D: without motion along z), amplitude A,
///
///     u_x = A sin(2 pi X) sin(pi c t) ,  u_y = -A sin(2 pi Y) sin(pi c t) ,  c^2 = E / rho
///     P_ii = mu (F_ii - 1 / F_ii) + lambda ln(J) / F_ii
///     b_i = pi^2 u_i [4 mu / rho - c^2 - 4 (lambda (ln(J) - 1) - mu) / (rho F_ii^2)]
///
/// since dP_ii/dX_i = [mu (1 + 1 / F_ii^2) + lambda (1 - ln(J)) / F_ii^2] u_i,ii with u_i,ii = -4
/// pi^2 u_i. Form of Wallstedt and Guilkey (2008).
template <int dim>
Manufactured<dim> axis_aligned_waves(double A) {
  using std::numbers::pi;
  constexpr double E = 1e7, nu = 0.3, density = 1e3;
  const double c = std::sqrt(E / density);
  const Lame lame(E, nu);
  const auto fields = [=](const Vector<dim>& X, double of_time) {
    Vector<dim> u = Vector<dim>::Zero();
    u[0] = A * std::sin(2 * pi * X[0]) * of_time;
    u[1] = -A * std::sin(2 * pi * X[1]) * of_time;
    return u;
  };
  return {
      .u = [=](const Vector<dim>& X, double t) { return fields(X, std::sin(pi * c * t)); },
      .v = [=](const Vector<dim>& X, double t) { return fields(X, pi * c * std::cos(pi * c * t)); },
      .b =
          [=](const Vector<dim>& X, double t) {
            Vector<dim> b = fields(X, std::sin(pi * c * t));
            const double slope = 2 * pi * A * std::sin(pi * c * t);
            const double F[] = {1 + slope * std::cos(2 * pi * X[0]),
                                1 - slope * std::cos(2 * pi * X[1])};
            for (int i = 0; i < 2; ++i) {
              const double elastic = lame.lambda * (std::log(F[0] * F[1]) - 1) - lame.mu;
              b[i] *=
                  pi * pi * (4 * lame.mu / density - c * c - 4 * elastic / (density * F[i] * F[i]));
            }
            return b;
          },
      .E = E,
      .nu = nu,
      .density = density,
      .size = A,
      .end = 1 / c};
}

/// Generalized vortex: circles of the ring 0.75 < R < 1.25 turn by alpha(R, t) = G sin(pi t / T)
/// h(R), h = 1 - 8 s^2 + 16 s^4, s = (R - 1) / 0.5; outside nothing moves. In the directions e_r,
/// e_theta at the current angle F = [1 0; R alpha' 1], J = 1, sigma = mu [0 g; g g^2] with g = R
/// alpha', so that div sigma = mu (-g^2 / R, 3 alpha' + R alpha'') and
///
///     b_r = (mu / rho) R alpha'^2 - R alpha_t^2
///     b_theta = R alpha_tt - (mu / rho) (3 alpha' + R alpha'')
///
/// Problem of Kamojjala, Brannon, Sadeghirad, Guilkey (2015).
template <int dim>
Manufactured<dim> vortex(double G) {
  using std::numbers::pi;
  constexpr double E = 1e3, nu = 0.3, density = 1e3, T = 1;
  const double diffusivity = Lame(E, nu).mu / density;
  struct Polar {
    double R, angle, h, h1, h2;  // h and its derivatives by R
    explicit Polar(const Vector<dim>& X)
        : R(std::hypot(X[0], X[1])), angle(std::atan2(X[1], X[0])), h(0), h1(0), h2(0) {
      const double s = 2 * (R - 1);
      if (std::abs(s) >= 0.5) return;
      h = 1 - 8 * s * s + 16 * s * s * s * s;
      h1 = 2 * (-16 * s + 64 * s * s * s);
      h2 = 4 * (-16 + 192 * s * s);
    }
    // components along e_r and e_theta at the angle turned by alpha
    Vector<dim> vector(double alpha, double radial, double tangential) const {
      Vector<dim> w = Vector<dim>::Zero();
      const double cosine = std::cos(angle + alpha), sine = std::sin(angle + alpha);
      w[0] = radial * cosine - tangential * sine;
      w[1] = radial * sine + tangential * cosine;
      return w;
    }
  };
  return {.u = [=](const Vector<dim>& X, double t) -> Vector<dim> {
            const Polar at(X);
            const double alpha = G * std::sin(pi * t / T) * at.h;
            return at.vector(alpha, at.R, 0) - at.vector(0, at.R, 0);
          },
          .v =
              [=](const Vector<dim>& X, double t) {
                const Polar at(X);
                const double alpha_t = G * pi / T * std::cos(pi * t / T) * at.h;
                return at.vector(G * std::sin(pi * t / T) * at.h, 0, at.R * alpha_t);
              },
          .b =
              [=](const Vector<dim>& X, double t) {
                const Polar at(X);
                const double sine = G * std::sin(pi * t / T);
                const double alpha_t = G * pi / T * std::cos(pi * t / T) * at.h;
                const double alpha_tt = -pi * pi / (T * T) * sine * at.h;
                const double slope = sine * at.h1, curvature = sine * at.h2;
                return at.vector(sine * at.h,
                                 diffusivity * at.R * slope * slope - at.R * alpha_t * alpha_t,
                                 at.R * alpha_tt - diffusivity * (3 * slope + at.R * curvature));
              },
          .E = E,
          .nu = nu,
          .density = density,
          .size = G,
          .end = T};
}

/// A box of material that fills its grid between walls.
struct ManufacturedBox {
  std::vector<double> low, high;
  std::vector<int> cells;
  std::string type;  ///< of grid and body cells
  int points_per_cell = 4;
  std::string wall = "slip";  ///< condition of all sides
  std::string basis = "linear";
};

template <int dim>
std::unique_ptr<mpm::MpmSolver<dim>> start(const Manufactured<dim>& exact,
                                           const ManufacturedBox& shape) {
  Json walls = Json::array();
  for (const char* side : {"left", "right", "bottom", "top", "front", "back"}) {
    if (dim == 3 || (side[0] != 'f' && side != std::string("back"))) {
      walls.push_back(wall(side, shape.wall));
    }
  }
  const Json mesh = box(shape.low, shape.high, shape.cells, shape.type);
  Json json = {{"dimension", dim},
               {"grid", mesh},
               {"basis", "linear"},
               {"walls", walls},
               {"bodies",
                {body("body", mesh, shape.points_per_cell,
                      elastic_soil("neo_hookean", exact.E, exact.nu, exact.density))}},
               {"time_integration", trapezoid},
               {"newton", {{"residual_tolerance", 1e-9}}}};
  if (shape.basis != "linear") json["basis"] = shape.basis;
  auto settings = mpm_settings<dim>(json);
  settings.body_acceleration = exact.b;
  auto solver = std::make_unique<mpm::MpmSolver<dim>>(comm(), std::move(settings), "");
  std::vector<Vector<dim>> v, a;
  for (const auto& x : solver->points().x) {
    v.push_back(exact.v(x, 0));
    a.push_back(Vector<dim>::Zero());  // every motion above has u_tt = 0 where u = 0
  }
  solver->set_motion(std::move(v), std::move(a));
  return solver;
}

/// sqrt(sum V0 |u - exact|^2 / sum V0) of the points at time t.
template <int dim>
double displacement_error(const mpm::MaterialPoints<dim>& points, const Manufactured<dim>& exact,
                          double t) {
  double sum = 0, volume = 0;
  for (std::int32_t p = 0; p < points.size(); ++p) {
    sum += points.V0[p] * (points.u[p] - exact.u(points.x[p] - points.u[p], t)).squaredNorm();
    volume += points.V0[p];
  }
  return std::sqrt(sum / volume);
}

/// Displacements of the points at `end`.
template <int dim>
std::vector<Vector<dim>> final_displacements(const Manufactured<dim>& exact,
                                             const ManufacturedBox& shape, int steps) {
  const auto solver = start<dim>(exact, shape);
  run_steps(*solver, exact.end / steps, steps);
  return solver->points().u;
}

/// Largest displacement error of any step until `end`, by the size of the solution.
template <int dim>
double largest_error(const Manufactured<dim>& exact, const ManufacturedBox& shape, int steps) {
  const auto solver = start<dim>(exact, shape);
  const double dt = exact.end / steps;
  double error = 0;
  for (int n = 1; n <= steps; ++n) {
    run_steps(*solver, dt, 1, n);
    error = std::max(error, displacement_error<dim>(solver->points(), exact, n * dt));
  }
  return error / exact.size;
}

}  // namespace gabion::test
