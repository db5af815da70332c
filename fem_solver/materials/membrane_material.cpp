// SPDX-License-Identifier: BSD-3-Clause
#include "fem_solver/materials/membrane_material.hpp"

#include <fmt/format.h>

#include <cmath>
#include <numbers>

#include "common/base/log.hpp"

namespace gabion::fem {

namespace {

constexpr double largest_plausible_prestrain = 0.1;

/// Modulus over 1 - nu^2 [Pa].
double plane_modulus(const MembraneMaterial& material) {
  return material.young_modulus / (1 - material.poisson_ratio * material.poisson_ratio);
}

MembraneResponse respond_taut(const MembraneMaterial& material, const StrainVector<2>& strain) {
  const double c = plane_modulus(material), nu = material.poisson_ratio;
  MembraneResponse response;
  response.stress.D << c, nu * c, 0, nu * c, c, 0, 0, 0, (1 - nu) * c;
  response.stress.S = response.stress.D * strain;
  response.energy = 0.5 * response.stress.S.dot(strain);
  return response;
}

}  // namespace

double MembraneMaterial::stretch() const {
  return std::sqrt(1 + 2 * prestress * (1 - poisson_ratio) / young_modulus);
}

double MembraneMaterial::wave_speed() const {
  return std::sqrt(plane_modulus(*this) / density);
}

MembraneResponse respond(const MembraneMaterial& material, const StrainVector<2>& strain) {
  if (!material.tension_only) return respond_taut(material, strain);
  const double half = 0.5 * (strain[0] - strain[1]), shear = strain[2] / std::numbers::sqrt2;
  const double mean = 0.5 * (strain[0] + strain[1]), radius = std::hypot(half, shear);
  const double first = mean + radius, second = mean - radius, E = material.young_modulus;
  if (second + material.poisson_ratio * first >= 0) return respond_taut(material, strain);
  MembraneResponse response;
  response.stress.S.setZero();
  response.stress.D.setZero();
  response.state = MembraneState::slack;
  if (first <= 0) return response;
  // Uniaxial tension along the first axis n of the strain: S = E E_1 n (x) n, and n turns by dE_12
  // / (E_1 - E_2).
  const double cosine = half / radius, sine = shear / radius;  // of twice its angle
  const StrainVector<2> along(0.5 * (1 + cosine), 0.5 * (1 - cosine), sine / std::numbers::sqrt2);
  const StrainVector<2> across(-sine / std::numbers::sqrt2, sine / std::numbers::sqrt2, cosine);
  response.state = MembraneState::wrinkled;
  response.stress.S = E * first * along;
  response.stress.D =
      E * along * along.transpose() + E * first / (first - second) * across * across.transpose();
  response.energy = 0.5 * E * first * first;
  return response;
}

std::vector<Key> membrane_keys() {
  const std::vector<std::string> membrane = {"membrane"};
  return {key::number("thickness", "m", "Thickness of a membrane without stress.")
              .in(positive())
              .when("formulation", membrane),
          key::number("prestress", "Pa",
                      "Stress of a membrane in the mesh, the same in all directions: force over "
                      "length and `thickness`.")
              .in(non_negative())
              .or_else(0)
              .when("formulation", membrane),
          key::boolean("tension_only",
                       "Whether a membrane wrinkles, without stress across the wrinkles, where it "
                       "would be compressed.")
              .or_else(false)
              .when("formulation", membrane)};
}

MembraneMaterial read_membrane_material(ConfigReader in, int dim) {
  if (dim == 2) {
    in.fail("formulation",
            "found \"membrane\" in 2D, allowed: in 3D; in the plane a \"truss\" or \"cable\" with "
            "the thickness as its \"area\" and young_modulus / (1 - poisson_ratio^2)");
  }
  MembraneMaterial material;
  material.where = in.where("group");
  material.group = in.text("group");
  if (const std::string law = in.choice("law"); law != "linear_elastic") {
    in.fail("law", fmt::format("found \"{}\" with \"formulation\" \"membrane\", allowed: "
                               "\"linear_elastic\", linear in the Green strain",
                               law));
  }
  in.choice("formulation");
  material.density = in.number("density");
  material.young_modulus = in.number("young_modulus");
  material.poisson_ratio = in.number("poisson_ratio");
  material.thickness = in.number("thickness");
  material.prestress = in.number("prestress");
  material.tension_only = in.boolean("tension_only");
  if (in.has("rayleigh")) {
    in.fail("rayleigh", "found with \"formulation\" \"membrane\", allowed: with solid cells");
  }
  if (material.stretch() - 1 > largest_plausible_prestrain) {
    log::warn("{}: strains the membrane by {:.3g}; units?", in.where("prestress"),
              material.stretch() - 1);
  }
  in.finish();
  return material;
}

}  // namespace gabion::fem
