// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>
#include <unistd.h>

#include <cmath>
#include <filesystem>
#include <fstream>

#include "coupler/coupling_loop.hpp"
#include "tests/support/verification_row.hpp"
#include "tests/unit/coupler/mass_springs.hpp"

namespace gabion {
namespace {

namespace fs = std::filesystem;
using test::Measure;
using test::verify;

/// Two masses and springs that share a displacement, from rest under a load that grows smoothly, so
/// that no acceleration is missing at t = 0:
///
///     m u'' + k u = F (1 - cos(p t)),   m = m1 + m2, k = k1 + k2, w^2 = k / m
///     u = F / k (1 - cos(w t)) - F / (m (w^2 - p^2)) (cos(p t) - cos(w t))
///
/// m1 = 2 kg, k1 = 10 N/m on the soil's side, m2 = 1 kg, k2 = 100 N/m on the structure's, F = 5 N,
/// p = 2/s. Both sides integrate with Newmark's trapezoidal rule, which makes no energy.
struct Oscillation {
  double error = 0;  // largest of u, over F / k
  double drift = 0;  // largest |work of both sides| over the largest energy of the structure
};

Oscillation oscillate(double dt, Scheme scheme) {
  const fs::path folder =
      fs::temp_directory_path() / ("gabion_oscillator_" + std::to_string(getpid()));
  fs::remove_all(folder);
  test::SoilSprings soil(2, 2, 10);
  test::StructureSprings structure(2, 1, 100);
  soil.scatter = structure.scatter = 0;
  const double end = 1.28, m = 3, k = 110, w = std::sqrt(k / m), F = 5, p = 2;
  soil.load = [&](double t) { return F * (1 - std::cos(p * t)); };
  CouplerSettings s;
  s.time = {end, dt, dt};
  s.output_interval = end;
  s.participants = {{"soil", true}, {"structure", false}};
  s.interfaces = {{"wall", "soil", "structure"}};
  s.coupling.scheme = scheme;
  s.coupling.convergence.displacement = {1e-13, {}, 0, {}};
  s.coupling.convergence.force = {1e-10, {}, 0, {}};
  s.coupling.mapping.tolerance = 1e-9;
  {
    RunRecord files(folder.string(), "coupler");
    CouplingLoop loop(s, {{"soil", soil}, {"structure", structure}}, files);
    loop.run();
  }
  const auto exact = [&](double t) {
    return F / k * (1 - std::cos(w * t)) -
           F / (m * (w * w - p * p)) * (std::cos(p * t) - std::cos(w * t));
  };
  Oscillation result;
  std::ifstream probes(folder / "probes.csv");
  std::string line;
  std::getline(probes, line);
  double largest_energy = 0;
  while (std::getline(probes, line)) {
    double t, u_soil, e_soil, u, energy;
    char comma;
    std::stringstream(line) >> t >> comma >> u_soil >> comma >> e_soil >> comma >> u >> comma >>
        energy;
    result.error = std::max(result.error, std::abs(u - exact(t)) / (F / k));
    largest_energy = std::max(largest_energy, energy);
  }
  std::ifstream steps(folder / "steps.csv");
  std::getline(steps, line);
  std::vector<std::string> head;
  std::stringstream names(line);
  for (std::string name; std::getline(names, name, ',');) head.push_back(name);
  const auto at = std::find(head.begin(), head.end(), "work_sum") - head.begin();
  double work = 0;
  while (std::getline(steps, line)) {
    std::stringstream cells(line);
    std::string cell;
    for (std::ptrdiff_t i = 0; i <= at; ++i) std::getline(cells, cell, ',');
    work += std::stod(cell);
    result.drift = std::max(result.drift, std::abs(work) / largest_energy);
  }
  fs::remove_all(folder);
  return result;
}

void verify_order(Scheme scheme, double least_order) {
  const Oscillation coarse = oscillate(0.02, scheme);
  const Oscillation fine = oscillate(0.01, scheme);
  verify({.id = "C2",
          .what = "order in time of u, " + name(scheme),
          .exact = 2,
          .computed = std::log2(coarse.error / fine.error),
          .measure = Measure::order,
          .bound = least_order});
  verify({.id = "C2",
          .what = "energy created by the coupling, " + name(scheme) + ", dt 0.01",
          .exact = 0,
          .computed = fine.drift,
          .measure = Measure::absolute_error,
          .bound = 1e-9,
          .unit = "of the largest energy"});
}

TEST(C2_Oscillator, the_coupled_scheme_has_the_order_of_its_integrators) {
  verify_order(Scheme::serial_implicit, 1.95);
  verify_order(Scheme::parallel_implicit, 1.95);
}

}  // namespace
}  // namespace gabion
