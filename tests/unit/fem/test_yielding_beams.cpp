// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include <Eigen/Core>
#include <cmath>
#include <functional>

#include "fem_solver/stress/fibre_section.hpp"
#include "tests/support/check_tangent.hpp"
#include "tests/support/expect_error.hpp"
#include "tests/unit/fem/beam_scene.hpp"

namespace gabion::test::test_yielding_beams {
namespace {

using Parts = std::vector<std::string_view>;
using fem::Triple;

constexpr double E = 210e9, sigma = 250e6, b = 0.05, h = 0.1, L = 1;
constexpr double I = b * h * h * h / 12, M_e = sigma * b * h * h / 6, kappa_e = M_e / (E * I);

/// A section alone, with its history.
struct Section {
  fem::LineMaterial material;
  fem::BeamStiffness stiffness;
  std::vector<double> accepted, trial;

  explicit Section(fem::CrossSection section, double H_k = 0) {
    material.young_modulus = E;
    material.hardening = fem::Hardening::linear(sigma, 0);
    material.kinematic_modulus = H_k;
    material.beam = fem::BeamData{.section = std::move(section), .shear_modulus = E / 2};
    stiffness = material.beam->stiffness(E);
    accepted.assign(2 * material.beam->section.fibres.size(), 0.0);
    trial = accepted;
  }
  template <class S>
  fem::SectionAnswer<S> answer(const Triple<S>& gamma, const Triple<S>& kappa) {
    return fem::FibreSection(material, stiffness, {.accepted = accepted, .trial = trial})(gamma,
                                                                                          kappa);
  }
  /// Moment about axis 3, or about the axis at this angle from it.
  double moment(double kappa, double angle = 0) {
    const double s = std::sin(angle), c = std::cos(angle);
    const auto found = answer<double>({0, 0, 0}, {0, kappa * s, kappa * c});
    return found.forces.moment[1] * s + found.forces.moment[2] * c;
  }
  double plastic_work() const {
    double sum = 0;
    const auto& fibres = material.beam->section.fibres;
    for (std::size_t k = 0; k < fibres.size(); ++k) {
      sum += fibres[k].area * fem::plastic_work(material, std::span(trial).subspan(2 * k, 2));
    }
    return sum;
  }
};

Section rectangle_of(int dim, double H_k = 0) {
  return Section(fem::rectangle_section(h, b, 0, dim), H_k);
}

/// M = M_e [3 - (kappa_e / kappa)^2] / 2, the plastic moment b h^2 sigma / 4, unloading along E I.
TEST(FibreSection, moment_over_curvature_of_a_rectangle) {
  for (const int dim : {2, 3}) {
    Section section = rectangle_of(dim);
    EXPECT_NEAR(section.moment(0.5 * kappa_e), 0.5 * M_e, 1e-12 * M_e);
    // Two points of Gauss miss a kink in their interval by 0.0223 of its length squared at most.
    const int layers = dim == 2 ? 20 : 6;
    const double tolerance = 12 * 0.0223 / (layers * layers);
    for (const double ratio : {1.2, 1.5, 2.0, 4.0}) {
      EXPECT_NEAR(section.moment(ratio * kappa_e), 0.5 * M_e * (3 - 1 / (ratio * ratio)),
                  tolerance * M_e)
          << dim << " " << ratio;
    }
    const double last = section.moment(200 * kappa_e);
    EXPECT_NEAR(last, b * h * h * sigma / 4, 1e-12 * last);
    section.accepted = section.trial;
    EXPECT_NEAR(section.moment(199 * kappa_e), last - M_e, 1e-9 * M_e);
  }
}

/// The plastic moments of circle and pipe are (D^3 - d^3) sigma / 6, about any axis.
TEST(FibreSection, plastic_moment_of_circles) {
  constexpr double D = 0.3;
  for (const double d : {0.0, 0.28}) {
    Section section(fem::ring_section(D, d, 0.3));
    const double exact = (D * D * D - d * d * d) * sigma / 6;
    for (const double angle : {0.0, 0.4, 2.0}) {
      EXPECT_NEAR(section.moment(100, angle), exact, 2e-3 * exact) << d << " " << angle;
      const double elastic = E * section.material.beam->section.moments[0] * 1e-3;
      EXPECT_NEAR(section.moment(1e-3, angle), elastic, 1e-12 * elastic);
    }
  }
}

/// Area of fibres, and their moments, are those of the section.
TEST(FibreSection, elastic_properties) {
  for (const auto& section :
       {fem::rectangle_section(h, b, 0.3, 2), fem::rectangle_section(h, b, 0.3, 3),
        fem::ring_section(0.3, 0, 0.3), fem::ring_section(0.3, 0.28, 0.3)}) {
    double area = 0, first = 0, I_2 = 0, I_3 = 0;
    for (const auto& [y, z, own] : section.fibres) {
      area += own;
      first += own * (y + z);
      I_2 += own * z * z;
      I_3 += own * y * y;
    }
    EXPECT_NEAR(area, section.area, 1e-13 * area);
    EXPECT_NEAR(first, 0, 1e-13 * area * h);
    EXPECT_NEAR(I_3, section.moments[1], 1e-12 * I_3);
    if (I_2 > 0) {
      EXPECT_NEAR(I_2, section.moments[0], 1e-12 * I_2);
    }
  }
}

/// Derivative of the resultants with plastic history, against differences.
TEST(FibreSection, tangent) {
  Section section(fem::rectangle_section(h, b, 0.3, 3), 5e9);
  section.answer<double>({0.7e-3, 0, 0}, {0, 0.03, 0.05});
  section.accepted = section.trial;
  const Eigen::VectorXd strain =
      (Eigen::VectorXd(6) << 1.9e-3, 2e-4, -1e-4, 3e-4, 0.05, 0.09).finished();
  const auto resultants = [&](const Eigen::VectorXd& at) {
    const auto found = section.answer<double>({at[0], at[1], at[2]}, {at[3], at[4], at[5]}).forces;
    Eigen::VectorXd values(6);
    for (int c = 0; c < 3; ++c) {
      values[c] = found.force[c];
      values[3 + c] = found.moment[c];
    }
    return values;
  };
  using Six = fem::Dual<6>;
  Triple<Six> gamma, kappa;
  for (int c = 0; c < 3; ++c) {
    gamma[c] = fem::unknown<Six>(strain[c], c);
    kappa[c] = fem::unknown<Six>(strain[3 + c], 3 + c);
  }
  const auto found = section.answer<Six>(gamma, kappa).forces;
  Eigen::MatrixXd slopes(6, 6);
  for (int c = 0; c < 3; ++c) {
    for (int k = 0; k < 6; ++k) {
      slopes(c, k) = found.force[c].slope[k];
      slopes(3 + c, k) = found.moment[c].slope[k];
    }
  }
  EXPECT_LT(tangent_error(resultants, strain, slopes, 1e-9), 1e-6);
  EXPECT_LT(slopes(0, 0), 0.9 * section.stiffness.force[0]);  // some fibres flow
}

/// Elastic energy and plastic work are the work of moment on curvature, in a cycle too.
TEST(FibreSection, energy) {
  Section section = rectangle_of(2, 10e9);
  double work = 0, kappa = 0, last = 0;
  const auto go_to = [&](double end) {
    constexpr int steps = 4000;
    const double step = (end - kappa) / steps;
    for (int n = 0; n < steps; ++n) {
      section.accepted = section.trial;
      kappa += step;
      const double M = section.moment(kappa);
      work += 0.5 * (M + last) * step;
      last = M;
    }
  };
  for (const double end : {5.0, -3.0, 4.0}) go_to(end * kappa_e);
  const double stored = section.answer<double>({0, 0, 0}, {0, 0, kappa}).energy;
  EXPECT_NEAR(stored + section.plastic_work(), work, 1e-4 * work);
  EXPECT_GT(section.plastic_work(), 0.5 * work);
}

Json yielding(int dimension) {
  Json json = beam_material(E, 0, rectangle(h, b), 7850);
  if (dimension == 3) json["orientation"] = {0, 1, 0};
  json["yield_stress"] = sigma;
  return json;
}

/// Tip over that at first yield: (P_e / P)^2 [5 - (3 + P / P_e) sqrt(3 - 2 P / P_e)].
TEST(YieldingBeams, cantilever_beyond_yield) {
  for (const int dim : {2, 3}) {
    const TemporaryMesh mesh(chain(L, 20).file());
    Json json = cantilever_of_beams(dim, mesh.path(), yielding(dim), L);
    const double P_e = M_e / L, GA = E / 2 * 10.0 / 12 * h * b;
    json["loads"] = {{{"group", "high"},
                      {"force", dim == 2 ? Json{0, P_e} : Json{0, P_e, 0}},
                      {"table", {{0, 0}, {2, 2}}}}};
    const auto run = [&](Solver& solver) {
      const double tip_e = P_e * L * L * L / (3 * E * I);
      for (int n = 1; n <= 14; ++n) {
        advance(solver, n, 0.1);
        const double ratio = 0.1 * n;
        if (n != 12 && n != 14) continue;
        const double exact = tip_e / (ratio * ratio) * (5 - (3 + ratio) * std::sqrt(3 - 2 * ratio));
        const double bent = probe(solver, "tip.uy") - ratio * P_e * L / GA;
        EXPECT_NEAR(bent, exact, 0.015 * exact) << dim << " " << ratio;
      }
      EXPECT_GT(probe(solver, "plastic_strain"), 1e-4);
      EXPECT_EQ(probe(solver, "plastic_strain_rope"), probe(solver, "plastic_strain"));
      EXPECT_NEAR(probe(solver, "moment_low_z"), -1.4 * M_e, 1e-3 * M_e);
      const double spent = probe(solver, "elastic_energy") + probe(solver, "plastic_work");
      EXPECT_NEAR(spent, probe(solver, "external_work"), 5e-3 * spent);
    };
    if (dim == 2) {
      run(*fem_solver<2>(json));
    } else {
      run(*fem_solver<3>(json));
    }
  }
}

/// A tip moment that bends the beam for good and goes: no force is left at the end that would
/// measure the residual. Bent over the length: M - E I kappa of loading stays.
template <int dim>
void expect_unloaded() {
  const TemporaryMesh mesh(chain(L, 20).file());
  Json json = cantilever_of_beams(dim, mesh.path(), yielding(dim), L);
  const double M = 1.4 * M_e;
  json["loads"] = {{{"group", "high"},
                    {"force", dim == 2 ? Json{0, 0} : Json{0, 0, 0}},
                    {"moment", dim == 2 ? Json{M} : Json{0, 0, M}},
                    {"table", {{0, 0}, {1, 1}, {2, 0}}}}};
  const auto run = fem_solver<dim>(json);
  for (int n = 1; n <= 22; ++n) advance(*run, n, 0.1);  // no step is refused
  const double ratio = 1 / std::sqrt(3 - 2 * 1.4), kappa = (ratio - 1.4) * kappa_e;
  const double tip = (1 - std::cos(kappa * L)) / kappa;
  // Layers miss the moment as in moment_over_curvature_of_a_rectangle, and dM / dkappa ~ ratio^-3.
  const int layers = dim == 2 ? 20 : 6;
  const double missed = 12 * 0.0223 / (layers * layers) * std::pow(ratio, 3) / (ratio - 1.4);
  EXPECT_NEAR(probe(*run, "tip.uy"), tip, (missed + 0.005) * tip) << dim;
  EXPECT_NEAR(probe(*run, "moment_low_z"), 0, 1e-7 * M) << dim;
}

TEST(YieldingBeams, unloaded) {
  expect_unloaded<2>();
  expect_unloaded<3>();
}

/// A blow that makes a post yield: it keeps a bend; the energies add up, and a run that goes on
/// from a saved state has the same bits.
template <int dim>
void expect_blow() {
  const TemporaryMesh mesh(chain(L, 8).file());
  Json json = cantilever_of_beams(dim, mesh.path(), yielding(dim), L, "dynamic");
  const double P = 2.5 * M_e / L;
  json["loads"] = {{{"group", "high"},
                    {"force", dim == 2 ? Json{0, P} : Json{0, P, 0.1 * P}},
                    {"table", {{0, 0}, {0.002, 1}, {0.006, 1}, {0.008, 0}}}}};
  const auto run = fem_solver<dim>(json), restarted = fem_solver<dim>(json);
  for (int n = 1; n <= 60; ++n) advance(*run, n, 1e-4);
  EXPECT_GT(probe(*run, "plastic_work"), 0);
  restarted->load_state(run->save_state());
  EXPECT_EQ(restarted->probes(), run->probes());
  double mean = 0;
  for (int n = 61; n <= 400; ++n) {
    advance(*run, n, 1e-4);
    if (n <= 100) advance(*restarted, n, 1e-4);
    if (n == 100) {
      EXPECT_EQ(restarted->probes(), run->probes());
      EXPECT_EQ(restarted->save_state().reals, run->save_state().reals);
    }
    if (n > 200) mean += probe(*run, "tip.uy") / 200;
  }
  EXPECT_GT(mean, 0.3 * M_e * L * L / (3 * E * I)) << dim;  // bent for good
  const double spent =
      probe(*run, "kinetic_energy") + probe(*run, "elastic_energy") + probe(*run, "plastic_work");
  EXPECT_NEAR(spent, probe(*run, "external_work"), 0.01 * spent) << dim;
}

TEST(YieldingBeams, a_blow) {
  expect_blow<2>();
  expect_blow<3>();
}

/// A yield stress that nothing reaches leaves an elastic beam.
TEST(YieldingBeams, below_yield_as_elastic) {
  const TemporaryMesh mesh(chain(L, 4).file());
  Json json = cantilever_of_beams(3, mesh.path(), yielding(3), L);
  json["loads"] = {rising_load({0, 0.5 * M_e, 0.1 * M_e})};
  const auto fibres = fem_solver<3>(json);
  json["materials"][0].erase("yield_stress");
  const auto elastic = fem_solver<3>(json);
  for (int n = 1; n <= 2; ++n) {
    advance(*fibres, n, 0.5);
    advance(*elastic, n, 0.5);
  }
  for (const char* name : {"tip.uy", "tip.uz", "elastic_energy", "bending_max_rope"}) {
    const double x = probe(*elastic, name);
    EXPECT_NEAR(probe(*fibres, name), x, 1e-9 * std::abs(x)) << name;
  }
  EXPECT_EQ(probe(*fibres, "plastic_work"), 0);
}

void expect_refused(const std::function<void(Json&)>& change, const Parts& parts) {
  const TemporaryMesh mesh(chain(L, 4).file());
  Json json = cantilever_of_beams(2, mesh.path(), yielding(2), L);
  change(json["materials"][0]);
  expect_error<ConfigError>([&] { fem_solver<2>(json); }, parts);
}

TEST(YieldingBeams, refused) {
  expect_refused([](Json& beam) { beam["cross_section"] = general_section(1, 1, 1); },
                 {"/materials/0/yield_stress", "general"});
  expect_refused([](Json& beam) { beam["yield_stress"] = 0; }, {"/materials/0/yield_stress", "0"});
  expect_refused(
      [](Json& beam) {
        beam.erase("yield_stress");
        beam["kinematic_modulus"] = 1e9;
      },
      {"/materials/0/kinematic_modulus", "yield_stress"});
  expect_refused(
      [](Json& beam) {
        beam["yield_table"] = {{0, 1e6}};
      },
      {"/materials/0/yield_stress", "both"});
}

}  // namespace
}  // namespace gabion::test::test_yielding_beams
