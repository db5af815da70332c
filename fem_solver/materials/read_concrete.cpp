// SPDX-License-Identifier: BSD-3-Clause
#include "fem_solver/materials/read_concrete.hpp"

#include <fmt/format.h>

#include <limits>
#include <string>

#include "common/base/log.hpp"

namespace gabion::fem {

std::vector<Key> concrete_keys() {
  const std::vector<std::string> law = {"concrete"};
  return {
      key::number("tensile_strength", "Pa",
                  "Strength in uniaxial tension; below the compressive strength.")
          .in(positive())
          .when("law", law),
      key::number("fracture_energy", "J/m^2",
                  "Energy per area that opens a crack fully. Cells must be narrower than 2 E times "
                  "it over the square of the tensile strength.")
          .in(positive())
          .when("law", law),
      key::number("compressive_strength", "Pa", "Strength in uniaxial compression, positive.")
          .in(positive())
          .when("law", law),
      key::number("crushing_energy", "J/m^2",
                  "Energy per area of crushing beyond the compressive strength. Cells must be "
                  "narrower than E times it over the square of that strength.")
          .in(positive())
          .when("law", law),
      key::number("elastic_limit_ratio", "",
                  "Compressive stress up to which the concrete is elastic, over the compressive "
                  "strength.")
          .in(inside(0, 1))
          .or_else(0.4)
          .when("law", law),
      key::number("strain_at_strength", "",
                  "Strain at the compressive strength, positive. From the elastic limit up to it "
                  "the stress follows a parabola, which must not begin steeper than Young's "
                  "modulus.")
          .in(positive())
          .or_else(2.2e-3)
          .when("law", law),
      key::number("biaxial_ratio", "",
                  "Strength in equal biaxial compression over that in uniaxial compression.")
          .in(in_words({.low = 1, .high = 2, .high_open = true}, "1 <= value < 2"))
          .or_else(1.16)
          .when("law", law),
      key::number("crack_spacing", "m",
                  "Distance between cracks of reinforced concrete. A wider cell has several "
                  "cracks, each of which takes the fracture energy.")
          .in(positive())
          .or_none()
          .when("law", law)};
}

namespace {

void warn_of_units(const ConfigReader& in, const TensionCurve& tension,
                   const CrushingCurve& crushing) {
  const double E = crushing.modulus;
  if (tension.strength > 1e-3 * E || tension.strength < 1e-6 * E) {
    log::warn(
        "{}: found {} Pa with young_modulus = {} Pa: concrete cracks at a strain of some 1e-4; "
        "units?",
        in.where("tensile_strength"), tension.strength, E);
  }
  if (tension.fracture_energy < 1 || tension.fracture_energy > 1e4) {
    log::warn("{}: found {} J/m^2; concrete takes some 100; units?", in.where("fracture_energy"),
              tension.fracture_energy);
  }
  if (crushing.strain_at_strength > 0.02) {
    log::warn("{}: found {}; concrete has its strength at some 0.002; per mille?",
              in.where("strain_at_strength"), crushing.strain_at_strength);
  }
  if (crushing.crushing_energy < tension.fracture_energy) {
    log::warn("{}: found {} J/m^2, below fracture_energy = {} J/m^2; units?",
              in.where("crushing_energy"), crushing.crushing_energy, tension.fracture_energy);
  }
}

}  // namespace

template <int dim>
Concrete<dim> read_concrete(ConfigReader& in, double lambda, double mu) {
  const double E = mu * (3 * lambda + 2 * mu) / (lambda + mu);
  Concrete<dim> law;
  law.lambda = lambda;
  law.mu = mu;
  law.tension = {.modulus = law.p_wave_modulus(),
                 .strength = in.number("tensile_strength"),
                 .fracture_energy = in.number("fracture_energy")};
  CrushingCurve& crushing = law.crushing;
  crushing.modulus = E;
  crushing.strength = in.number("compressive_strength");
  crushing.elastic_limit = in.number("elastic_limit_ratio") * crushing.strength;
  crushing.strain_at_strength = in.number("strain_at_strength");
  crushing.crushing_energy = in.number("crushing_energy");
  law.biaxial_ratio = in.number("biaxial_ratio");
  if (in.has("crack_spacing")) law.crack_spacing = in.number("crack_spacing");
  law.where_fracture = in.where("fracture_energy");
  law.where_crushing = in.where("crushing_energy");
  if (!(law.tension.strength < crushing.strength)) {
    in.fail("tensile_strength",
            fmt::format("found {} Pa, allowed: below compressive_strength = {} Pa",
                        law.tension.strength, crushing.strength));
  }
  if (crushing.strain_at_strength < crushing.least_strain()) {
    in.fail("strain_at_strength",
            fmt::format("found {:.6g}, allowed: at least {:.6g} with this young_modulus: stress "
                        "rises no faster than in elasticity",
                        crushing.strain_at_strength, crushing.least_strain()));
  }
  warn_of_units(in, law.tension, crushing);
  return law;
}

template Concrete<2> read_concrete<2>(ConfigReader&, double, double);
template Concrete<3> read_concrete<3>(ConfigReader&, double, double);

}  // namespace gabion::fem
