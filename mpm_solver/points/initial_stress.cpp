// SPDX-License-Identifier: BSD-3-Clause
#include "mpm_solver/points/initial_stress.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <cmath>
#include <variant>

#include "common/base/require.hpp"
#include "common/mechanics/materials/spectral.hpp"
#include "common/mechanics/ranks/sum.hpp"

namespace gabion::mpm {

namespace {

// The law has to give the stress back that the strains were made for, up to this share.
constexpr double same_stress = 1e-9;

template <int dim>
double shear_modulus(const MaterialLaw<dim>& law) {
  return std::visit([](const auto& model) { return model.shear_modulus(); }, law);
}

template <int dim>
double first_lame_constant(const MaterialLaw<dim>& law) {
  const double M = std::visit([](const auto& model) { return model.p_wave_modulus(); }, law);
  return M - 2 * shear_modulus(law);
}

template <int dim>
double normally_consolidated(ConfigReader& in, const Material<dim>& material, double elastic) {
  if (!in.is_text("k0")) return in.number("k0");
  if (in.choice("k0") == "elastic") return elastic;
  const double angle = std::visit(
      [](const auto& model) {
        if constexpr (requires { model.parameters().friction_angle; }) {
          return model.parameters().friction_angle;
        } else {
          return 0.0;
        }
      },
      material.law);
  if (angle <= 0) {
    in.fail("k0",
            fmt::format("found \"jaky\" with the law {}, allowed: a law with a friction angle",
                        material.law_name));
  }
  return 1 - std::sin(angle);
}

// Coefficients at rest that the law bears under the vertical stress -s, in words.
template <int dim>
std::string borne(const MaterialLaw<dim>& law, double s) {
  return std::visit(
      [s]<class Law>(const Law& soil) -> std::string {
        if constexpr (requires { soil.principal(); }) {
          const PrincipalMohrCoulomb& surface = soil.principal();
          const double k = surface.k, strength = surface.strength / s;
          return fmt::format("k0 in [{:.6g}, {:.6g}]", (1 - strength) / k, k + strength);
        } else {
          return "a stress that the law bears";
        }
      },
      law);
}

/// State of one point at depth d.
template <int dim>
struct Geostatic {
  double s = 0;  // -tau_v [Pa]
  double J = 1;
  MaterialState<dim> state;
  Symmetric<dim> tau = Symmetric<dim>::Zero();
};

template <int dim>
Geostatic<dim> geostatic(const MaterialLaw<dim>& law, double k0, double weight, double d) {
  const double lambda = first_lame_constant(law), mu = shear_modulus(law);
  const double C = (3 * lambda + 2 * mu) / (1 + 2 * k0);
  const bool small_strain = std::holds_alternative<LinearElastic<dim>>(law);
  Geostatic<dim> result;
  const double load = weight * d;
  result.s = small_strain ? load : 2 * load / (1 + std::sqrt(1 + 2 * load / C));
  const double volumetric = -result.s / C;
  for (int i = 0; i < 3; ++i) {
    const bool vertical = i == dim - 1;
    result.tau[i] = vertical ? -result.s : -k0 * result.s;
    const double epsilon = (result.tau[i] - lambda * volumetric) / (2 * mu);
    result.state.e[i] = small_strain ? epsilon : strain_from_hencky(epsilon);
  }
  if (!small_strain) result.J = std::exp(volumetric);
  return result;
}

}  // namespace

KeyTable initial_stress_keys() {
  return {
      "initial_stress",
      "Geostatic stress below a level surface. Needs gravity against the last axis, present from "
      "the start, a law other than neo_hookean, and balance: the soil may not yield.",
      {key::number("k0", "", "Horizontal over vertical stress, normally consolidated.")
           .in(non_negative()),
       key::choice("k0", {"elastic", "jaky"},
                   "`elastic`: nu / (1 - nu); `jaky`: 1 - sin(phi), with a law that has phi."),
       key::number(
           "surface", "m",
           "Height of the surface; no point lies above it. Of a layer under layers of other "
           "densities: the height up to which its own density would weigh as much as they "
           "do."),
       key::number("ocr", "",
                   "Over-consolidation ratio; unloading is elastic: K0 = ocr k0 - (ocr - 1) nu / "
                   "(1 - nu).")
           .in(at_least(1))
           .or_else(1),
       key::number("max_displacement", "",
                   "Largest initial displacement that is accepted, the one that would balance the "
                   "initial stress, over the mean cell size.")
           .in(positive())
           .or_else(InitialStress{}.max_displacement)}};
}

template <int dim>
InitialStress read_initial_stress(ConfigReader in, const Material<dim>& material) {
  if (std::holds_alternative<NeoHookean<dim>>(material.law)) {
    in.fail("k0", fmt::format("found with the law {}, allowed: linear_elastic or a law with "
                              "Hencky's elasticity",
                              material.law_name));
  }
  InitialStress stress;
  const double lambda = first_lame_constant(material.law), mu = shear_modulus(material.law);
  const double elastic = lambda / (lambda + 2 * mu);
  stress.where = in.where("k0");
  stress.where_surface = in.where("surface");
  stress.k0 = normally_consolidated(in, material, elastic);
  const double ocr = in.number("ocr");
  stress.k0 = ocr * stress.k0 - (ocr - 1) * elastic;
  stress.surface = in.number("surface");
  stress.max_displacement = in.number("max_displacement");
  in.finish();
  return stress;
}

template <int dim>
void set_initial_stress(MPI_Comm comm, const InitialStress& stress, const BodyAtRest<dim>& at_rest,
                        MaterialPoints<dim>& points) {
  const Body<dim>& body = at_rest.body;
  const Vector<dim>& gravity = at_rest.gravity;
  require<ConfigError>(
      gravity[dim - 1] < 0 && gravity.template head<dim - 1>().isZero(0),
      "{}: found gravity ({:.4g}), allowed: gravity against the last axis, present from the start",
      stress.where, fmt::join(gravity.data(), gravity.data() + dim, ", "));
  const double weight = -body.material.density * gravity[dim - 1];
  std::string problem;
  for (std::int32_t p = points.body_starts[at_rest.number];
       p < points.body_starts[at_rest.number + 1]; ++p) {
    const double d = stress.surface - points.x[p][dim - 1];
    const auto soil = geostatic<dim>(body.material.law, stress.k0, weight, d);
    StressUpdate<dim> now;
    const bool borne_by_law =
        d >= 0 && update<dim>(body.material.law, Matrix<dim>::Zero(), soil.state, now, nullptr) &&
        (now.tau - soil.tau).norm() <= same_stress * soil.tau.norm();
    if (!borne_by_law) {
      const std::string place =
          fmt::format("material point {} at ({:.4g})", points.id[p],
                      fmt::join(points.x[p].data(), points.x[p].data() + dim, ", "));
      problem = d < 0 ? fmt::format("{}: found {}, but {} lies above it", stress.where_surface,
                                    stress.surface, place)
                      : fmt::format(
                            "{}: found k0 = {:.6g}, under which {} would yield, allowed: {}",
                            stress.where, stress.k0, place, borne<dim>(body.material.law, soil.s));
      break;
    }
    points.V0[p] /= soil.J;
    points.m[p] /= soil.J;
    points.J[p] = soil.J;
    points.history[p] = soil.state;
    points.tau[p] = soil.tau;
    points.energy[p] = now.energy;
    points.a[p].setZero();
  }
  require<ConfigError>(max_over_ranks(comm, problem.empty() ? 0 : 1) == 0, "{}",
                       problem.empty() ? stress.where + ": refused on another rank" : problem);
}

template <int dim>
Vector<dim> initial_stress_at(const InitialStress& stress, const BodyAtRest<dim>& at_rest,
                              double height) {
  const double d = stress.surface - height;
  if (d <= 0) return Vector<dim>::Zero();
  const Material<dim>& material = at_rest.body.material;
  const double weight = -material.density * at_rest.gravity[dim - 1];
  const auto soil = geostatic<dim>(material.law, stress.k0, weight, d);
  return soil.tau.template head<dim>() / soil.J;
}

template InitialStress read_initial_stress<2>(ConfigReader, const Material<2>&);
template InitialStress read_initial_stress<3>(ConfigReader, const Material<3>&);
template void set_initial_stress<2>(MPI_Comm, const InitialStress&, const BodyAtRest<2>&,
                                    MaterialPoints<2>&);
template void set_initial_stress<3>(MPI_Comm, const InitialStress&, const BodyAtRest<3>&,
                                    MaterialPoints<3>&);
template Vector<2> initial_stress_at<2>(const InitialStress&, const BodyAtRest<2>&, double);
template Vector<3> initial_stress_at<3>(const InitialStress&, const BodyAtRest<3>&, double);

}  // namespace gabion::mpm
