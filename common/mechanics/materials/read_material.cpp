// SPDX-License-Identifier: BSD-3-Clause
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <iterator>
#include <numbers>

#include "common/mechanics/materials/material.hpp"
#include "common/mechanics/materials/read_cam_clay.hpp"
#include "common/mechanics/materials/read_softening.hpp"
#include "common/mechanics/materials/read_umat.hpp"

namespace gabion {
namespace {

const std::vector<std::string> with_friction = {"mohr_coulomb", "drucker_prager"};

std::vector<Key> elasticity_keys(const std::vector<std::string>& laws) {
  const auto but = [&laws](const Key& all, const std::vector<std::string>& without) {
    std::vector<std::string> with = laws;
    std::size_t erased = 0;
    for (const std::string& law : without) erased += std::erase(with, law);
    return erased == 0 ? all : Key(all).when("law", with);
  };
  const Key modulus = key::number("young_modulus", "Pa", "Young's modulus.").in(positive());
  const Key ratio = key::number("poisson_ratio", "", "Poisson's ratio.").in(inside(-1, 0.5));
  return {key::number("density", "kg/m^3", "Mass per volume in the state free of stress.")
              .in(positive()),
          but(modulus, {"cam_clay", "newtonian", "umat"}), but(ratio, {"newtonian", "umat"})};
}

std::vector<Key> strength_keys() {
  const std::string angle = "an angle in degrees, 0 < friction_angle < 90";
  return {key::number("friction_angle", "deg",
                      "Angle of friction phi; soil without friction has the law `tresca`.")
              .in(in_words(inside(0, 90), angle + "; soil without friction is \"law\": \"tresca\""))
              .when("law", with_friction),
          key::number("dilation_angle", "deg", "Angle of dilation psi, at most `friction_angle`.")
              .in({.low = 0, .high = 90, .high_open = true, .allowed = angle})
              .or_else(0)
              .when("law", with_friction),
          key::number("cohesion", "Pa", "Cohesion c.")
              .in(non_negative())
              .or_else(0)
              .when("law", with_friction),
          key::number("cohesion", "Pa", "Undrained shear strength.")
              .in(positive())
              .when("law", {"tresca"}),
          key::choice("match", {"plane_strain", "compression", "extension"},
                      "State in which the cone has the strength of Mohr-Coulomb: plane strain, "
                      "triaxial compression or triaxial extension.")
              .or_else("plane_strain")
              .when("law", {"drucker_prager"}),
          key::number("tension_cutoff", "Pa",
                      "Limit of the principal Kirchhoff stresses, below the apex cohesion / "
                      "tan(friction_angle).")
              .in(non_negative())
              .or_none()
              .when("law", {"mohr_coulomb"}),
          key::number("tension_cutoff", "Pa", "Limit of the principal Kirchhoff stresses.")
              .in(non_negative())
              .or_none()
              .when("law", {"tresca"})};
}

std::vector<Key> flow_keys() {
  const std::vector<std::string> fluid = {"herschel_bulkley"};
  return {
      key::number("yield_stress", "Pa", "Shear stress above which the soil flows.")
          .in(non_negative())
          .when("law", fluid),
      key::number("consistency", "Pa s^n",
                  "Shear stress beyond `yield_stress` at a shear rate of 1/s; with `flow_index` "
                  "1 the viscosity.")
          .in(positive())
          .when("law", fluid),
      key::number("flow_index", "", "Power n of the shear rate; 1: Bingham.")
          .in(between(0.1, 2))
          .or_else(1)
          .when("law", fluid)};
}

std::vector<Key> newtonian_keys() {
  const std::vector<std::string> fluid = {"newtonian"};
  return {
      key::number("sound_speed", "m/s",
                  "Speed of sound c; the bulk modulus is rho c^2. Ten times the fastest flow keeps "
                  "the density within 1 %; a larger value makes steps shorter or harder to solve.")
          .in(positive())
          .when("law", fluid),
      key::number("viscosity", "Pa s", "Dynamic viscosity.").in(non_negative()).when("law", fluid),
      key::number("cavitation_pressure", "Pa",
                  "Tension at which the fluid tears; 0: it bears none, as water with a free "
                  "surface.")
          .in(non_negative())
          .or_else(0)
          .when("law", fluid)};
}

std::vector<Key> granular_keys() {
  const std::vector<std::string> grains = {"mu_i"};
  return {
      key::number("static_friction", "",
                  "mu_s, shear stress over pressure where flow begins: the tangent of the slope at "
                  "which a layer starts to flow.")
          .in(positive())
          .when("law", grains),
      key::number("limit_friction", "",
                  "mu_2 of fast flow, at least `static_friction`: the tangent of the steepest "
                  "slope on which flow is steady.")
          .in(positive())
          .when("law", grains),
      key::number("inertial_number", "",
                  "I_0, the inertial number at which the friction is half way between the two.")
          .in(positive())
          .when("law", grains),
      key::number("grain_size", "m", "Diameter of the grains.").in(positive()).when("law", grains),
      key::number("grain_density", "kg/m^3", "Density of the grains themselves, without pores.")
          .in(positive())
          .when("law", grains)};
}

std::vector<Key> apex_keys() {
  const std::vector<std::string> words = {"gap", "forget"};
  return {key::choice("apex_volume", words,
                      "What happens to volume that opens without stress. `gap`: it has to close "
                      "before pressure builds up; `forget`: recompression builds up pressure at "
                      "once.")
              .or_else("gap")
              .when("law", {"mohr_coulomb", "drucker_prager", "mu_i"}),
          key::choice("apex_volume", words,
                      "What happens to volume that opens while all three principal stresses are at "
                      "the cut-off. `gap`: it has to close before pressure builds up; `forget`: "
                      "recompression builds up pressure at once.")
              .or_else("gap")
              .when("law", {"tresca"})
              .with("tension_cutoff")};
}

std::vector<Key> softening_key() {
  const std::string sentence = "Strength that changes with shear; none: it is constant.";
  return {
      key::object("softening", softening_keys(true), sentence)
          .or_none()
          .when("law", {"mohr_coulomb"}),
      key::object("softening", softening_keys(false), sentence).or_none().when("law", {"tresca"})};
}

/// Whether the key has a meaning with one of these laws.
bool belongs_to(const Key& key, const std::vector<std::string>& laws) {
  return std::all_of(key.conditions.begin(), key.conditions.end(), [&](const Condition& condition) {
    return condition.words.empty() ||
           std::find_first_of(laws.begin(), laws.end(), condition.words.begin(),
                              condition.words.end()) != laws.end();
  });
}

struct LameConstants {
  double lambda, mu;
};

LameConstants read_elasticity(ConfigReader& in) {
  const double E = in.number("young_modulus");
  const double nu = in.number("poisson_ratio");
  return {E * nu / ((1 + nu) * (1 - 2 * nu)), E / (2 * (1 + nu))};
}

struct Friction {
  double friction_angle, dilation_angle, cohesion;  // [rad], [rad], [Pa]
};

Friction read_friction(ConfigReader& in) {
  constexpr double degree = std::numbers::pi / 180;
  const double phi = in.number("friction_angle");
  const double psi =
      in.number("dilation_angle",
                in_words(between(0, phi),
                         fmt::format("an angle in degrees from 0 to friction_angle = {}", phi)));
  return {phi * degree, psi * degree, in.number("cohesion")};
}

ApexVolume read_apex_volume(ConfigReader& in) {
  return in.choice("apex_volume") == "gap" ? ApexVolume::gap : ApexVolume::forget;
}

double read_tension_cutoff(ConfigReader& in, double apex) {
  if (!in.has("tension_cutoff")) return no_cutoff;
  if (apex == no_cutoff) return in.number("tension_cutoff");
  return in.number(
      "tension_cutoff",
      {.low = 0,
       .high = apex,
       .high_open = true,
       .allowed = fmt::format("0 <= tension_cutoff < cohesion / tan(friction_angle) = {}, the "
                              "apex; leave it out to keep the apex",
                              apex)});
}

template <int dim>
MaterialLaw<dim> read_mohr_coulomb(ConfigReader& in, const LameConstants& elastic) {
  const Friction friction = read_friction(in);
  const MohrCoulombParameters soil{.lambda = elastic.lambda,
                                   .mu = elastic.mu,
                                   .friction_angle = friction.friction_angle,
                                   .dilation_angle = friction.dilation_angle,
                                   .cohesion = friction.cohesion,
                                   .apex_volume = read_apex_volume(in),
                                   .tension_cutoff = read_tension_cutoff(
                                       in, friction.cohesion / std::tan(friction.friction_angle))};
  auto softening = in.optional_object("softening");
  if (!softening) return MohrCoulomb<dim>(soil);
  SofteningParameters softens{.lambda = soil.lambda,
                              .mu = soil.mu,
                              .friction_angle = soil.friction_angle,
                              .apex_volume = soil.apex_volume,
                              .tension_cutoff = soil.tension_cutoff};
  read_softening(std::move(*softening),
                 {soil.cohesion, in.number("friction_angle"), in.number("dilation_angle")},
                 softens);
  return SofteningSoil<dim>(softens);
}

template <int dim>
DruckerPrager<dim> read_drucker_prager(ConfigReader& in, const LameConstants& elastic) {
  const Friction friction = read_friction(in);
  const std::string match = in.choice("match");
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
MaterialLaw<dim> read_tresca(ConfigReader& in, const LameConstants& elastic) {
  const double cohesion = in.number("cohesion");
  const double cutoff = read_tension_cutoff(in, no_cutoff);
  const ApexVolume apex = cutoff == no_cutoff ? ApexVolume::gap : read_apex_volume(in);
  if (auto softening = in.optional_object("softening")) {
    SofteningParameters softens{.lambda = elastic.lambda,
                                .mu = elastic.mu,
                                .frictional = false,
                                .apex_volume = apex,
                                .tension_cutoff = cutoff};
    read_softening(std::move(*softening), {.cohesion = cohesion}, softens);
    return SofteningSoil<dim>(softens);
  }
  return Tresca<dim>({.lambda = elastic.lambda,
                      .mu = elastic.mu,
                      .cohesion = cohesion,
                      .tension_cutoff = cutoff,
                      .apex_volume = apex});
}

template <int dim>
HerschelBulkley<dim> read_herschel_bulkley(ConfigReader& in, const LameConstants& elastic) {
  return HerschelBulkley<dim>({.lambda = elastic.lambda,
                               .mu = elastic.mu,
                               .yield_stress = in.number("yield_stress"),
                               .consistency = in.number("consistency"),
                               .flow_index = in.number("flow_index")});
}

template <int dim>
Newtonian<dim> read_newtonian(ConfigReader& in, double density) {
  const double c = in.number("sound_speed");
  return Newtonian<dim>({.bulk_modulus = density * c * c,
                         .viscosity = in.number("viscosity"),
                         .cavitation_pressure = in.number("cavitation_pressure")});
}

template <int dim>
MuI<dim> read_mu_i(ConfigReader& in, const LameConstants& elastic) {
  const double static_friction = in.number("static_friction");
  const double limit_friction =
      in.number("limit_friction",
                in_words(at_least(static_friction),
                         fmt::format("a number from static_friction = {} on", static_friction)));
  return MuI<dim>({.lambda = elastic.lambda,
                   .mu = elastic.mu,
                   .static_friction = static_friction,
                   .limit_friction = limit_friction,
                   .inertial_number = in.number("inertial_number"),
                   .grain_size = in.number("grain_size"),
                   .grain_density = in.number("grain_density"),
                   .apex_volume = read_apex_volume(in)});
}

}  // namespace

const std::vector<std::string> elastic_laws = {"linear_elastic", "neo_hookean", "hencky_elastic"};
const std::vector<std::string> material_laws = {
    "linear_elastic",   "neo_hookean", "hencky_elastic", "mohr_coulomb", "tresca", "drucker_prager",
    "herschel_bulkley", "mu_i",        "cam_clay",       "newtonian",    "umat"};

KeyTable material_keys(const std::vector<std::string>& laws) {
  KeyTable table{"material", "Law of the stress and its constants.", {}};
  table.keys.push_back(key::choice("law", laws, "Law of the stress."));
  for (const auto& group :
       {elasticity_keys(laws), strength_keys(), flow_keys(), newtonian_keys(), granular_keys(),
        cam_clay_keys(), apex_keys(), softening_key(), umat_keys()}) {
    std::copy_if(group.begin(), group.end(), std::back_inserter(table.keys),
                 [&](const Key& key) { return belongs_to(key, laws); });
  }
  return table;
}

template <int dim>
Material<dim> read_material(ConfigReader in) {
  Material<dim> material;
  material.law_name = in.choice("law");
  material.density = in.number("density");
  if (material.law_name == "cam_clay") {
    material.law = CamClay<dim>(read_cam_clay(in));
    in.finish();
    return material;
  }
  if (material.law_name == "newtonian") {
    material.law = read_newtonian<dim>(in, material.density);
    in.finish();
    return material;
  }
  if (material.law_name == "umat") in.fail("law", "found \"umat\", allowed: in mpm.json");
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
  } else if (material.law_name == "herschel_bulkley") {
    material.law = read_herschel_bulkley<dim>(in, elastic);
  } else if (material.law_name == "mu_i") {
    material.law = read_mu_i<dim>(in, elastic);
  } else {
    material.law = read_mohr_coulomb<dim>(in, elastic);
  }
  in.finish();
  return material;
}

template Material<2> read_material<2>(ConfigReader in);
template Material<3> read_material<3>(ConfigReader in);

}  // namespace gabion
