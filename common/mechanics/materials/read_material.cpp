// SPDX-License-Identifier: BSD-3-Clause
#include <fmt/format.h>

#include <numbers>

#include "common/mechanics/materials/material.hpp"

namespace gabion {
namespace {

Range inside(double low, double high) {
  return {[=](double x) { return low < x && x < high; },
          fmt::format("a number between {} and {}, both excluded", low, high)};
}

struct LameConstants {
  double lambda, mu;
};

LameConstants read_elasticity(ConfigReader& in) {
  const double E = in.number("young_modulus", positive());
  const double nu = in.number("poisson_ratio", inside(-1, 0.5));
  return {E * nu / ((1 + nu) * (1 - 2 * nu)), E / (2 * (1 + nu))};
}

struct Friction {
  double friction_angle, dilation_angle, cohesion;  // [rad], [rad], [Pa]
};

Friction read_friction(ConfigReader& in) {
  constexpr double degree = std::numbers::pi / 180;
  const Range friction_range = {[](double x) { return 0 <= x && x < 90; },
                                "an angle in degrees, 0 < friction_angle < 90"};
  const double phi = in.number("friction_angle", friction_range);
  if (phi == 0) {
    in.fail("friction_angle",
            "found 0, allowed: an angle in degrees, 0 < friction_angle < 90; soil without friction "
            "is \"law\": \"tresca\"");
  }
  const Range dilation_range = {
      [phi](double x) { return 0 <= x && x <= phi; },
      fmt::format("an angle in degrees from 0 to friction_angle = {}", phi)};
  const double psi = in.number_or("dilation_angle", 0, dilation_range);
  return {phi * degree, psi * degree, in.number_or("cohesion", 0, non_negative())};
}

ApexVolume read_apex_volume(ConfigReader& in) {
  const std::string word = in.choice_or("apex_volume", {"gap", "forget"}, "gap");
  return word == "gap" ? ApexVolume::gap : ApexVolume::forget;
}

template <int dim>
MohrCoulomb<dim> read_mohr_coulomb(ConfigReader& in, const LameConstants& elastic) {
  const Friction friction = read_friction(in);
  return MohrCoulomb<dim>({.lambda = elastic.lambda,
                           .mu = elastic.mu,
                           .friction_angle = friction.friction_angle,
                           .dilation_angle = friction.dilation_angle,
                           .cohesion = friction.cohesion,
                           .apex_volume = read_apex_volume(in)});
}

template <int dim>
DruckerPrager<dim> read_drucker_prager(ConfigReader& in, const LameConstants& elastic) {
  const Friction friction = read_friction(in);
  const std::string match =
      in.choice_or("match", {"plane_strain", "compression", "extension"}, "plane_strain");
  return DruckerPrager<dim>({.lambda = elastic.lambda,
                             .mu = elastic.mu,
                             .friction_angle = friction.friction_angle,
                             .dilation_angle = friction.dilation_angle,
                             .cohesion = friction.cohesion,
                             .match = match == "plane_strain"  ? ConeMatch::plane_strain
                                      : match == "compression" ? ConeMatch::compression
                                                               : ConeMatch::extension,
                             .apex_volume = read_apex_volume(in)});
}

template <int dim>
Tresca<dim> read_tresca(ConfigReader& in, const LameConstants& elastic) {
  return Tresca<dim>({elastic.lambda, elastic.mu, in.number("cohesion", positive())});
}

}  // namespace

template <int dim>
Material<dim> read_material(ConfigReader in) {
  Material<dim> material;
  material.law_name = in.choice("law", {"linear_elastic", "neo_hookean", "hencky_elastic",
                                        "mohr_coulomb", "tresca", "drucker_prager"});
  material.density = in.number("density", positive());
  const auto elastic = read_elasticity(in);
  if (material.law_name == "linear_elastic") {
    material.law = LinearElastic<dim>{elastic.lambda, elastic.mu};
  } else if (material.law_name == "neo_hookean") {
    material.law = NeoHookean<dim>{elastic.lambda, elastic.mu};
  } else if (material.law_name == "hencky_elastic") {
    material.law = HenckyElastic<dim>{elastic.lambda, elastic.mu};
  } else if (material.law_name == "tresca") {
    material.law = read_tresca<dim>(in, elastic);
  } else if (material.law_name == "drucker_prager") {
    material.law = read_drucker_prager<dim>(in, elastic);
  } else {
    material.law = read_mohr_coulomb<dim>(in, elastic);
  }
  in.finish();
  return material;
}

template Material<2> read_material<2>(ConfigReader in);
template Material<3> read_material<3>(ConfigReader in);

}  // namespace gabion
