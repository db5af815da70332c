// SPDX-License-Identifier: BSD-3-Clause
#include "fem_solver/motion_settings.hpp"

#include <algorithm>
#include <variant>

#include "common/base/log.hpp"
#include "fem_solver/nodal_settings.hpp"
#include "fem_solver/step/static_newton.hpp"

namespace gabion::fem {

namespace {

/// Parts of a structure whose stiffness jumps, lines and membranes that go slack and concrete whose
/// cracks close; and whether anything of it is damped.
struct Parts {
  bool slacken = false, crack = false, damped = false;
};

/// Scheme of the structure. The trapezoidal rule and Bossak's scheme create energy where a
/// stiffness jumps there and back; rho_inf 0 creates none.
NewmarkBossak read_scheme(ConfigReader in, Parts parts) {
  NewmarkBossak scheme;
  if (in.has("scheme")) {
    scheme = read_newmark_bossak(in);
  } else {
    const bool dissipates = (parts.slacken || parts.crack) && !parts.damped;
    in.choice_or("scheme", dissipates ? "generalized_alpha" : "newmark");
    if (!dissipates && in.has("rho_inf")) {
      in.fail("rho_inf", "allowed only with \"scheme\" \"generalized_alpha\"");
    }
    if (dissipates) scheme = NewmarkBossak::generalized_alpha(in.number_or("rho_inf", 0));
    in.finish();
  }
  if (parts.crack && scheme.alpha_m != -1) {
    log::warn(
        "{}: steps that are not short against the vibration of a cell make energy with this scheme "
        "where cracks of concrete close and open again; \"generalized_alpha\" with \"rho_inf\" 0 "
        "makes none",
        in.where("scheme"));
  }
  if (parts.slacken && scheme.alpha_m != -1) {
    log::warn(
        "{}: steps that are not short against the vibration of taut lines make energy with this "
        "scheme where cables, brakes or membranes go slack and taut again; \"generalized_alpha\" "
        "with \"rho_inf\" 0 makes none",
        in.where("scheme"));
  }
  return scheme;
}

template <int dim>
void read_motion_of(ConfigReader& in, Parts parts, MotionSettings<dim>& s) {
  s.dynamic = in.choice("analysis") == "dynamic";
  if (s.dynamic) {
    s.time_integration = read_scheme(in.object("time_integration"), parts);
    s.initial_velocity = read_vector<dim>(in, "initial_velocity");
  }
  for (const char* key : {"time_integration", "initial_velocity"}) {
    if (!s.dynamic && in.has(key)) in.fail(key, "has no meaning when \"analysis\" is \"static\"");
  }
  s.initial_equilibrium = in.boolean("initial_equilibrium");
  if (s.initial_equilibrium && !s.initial_velocity.isZero(0)) {
    in.fail("initial_velocity", "must be zero when \"initial_equilibrium\" is true");
  }
}

template <int dim>
Parts parts_of(const ConfigReader& in, const FemSettings<dim>& s) {
  const auto is_damped = [](const auto& material) { return !material.rayleigh.where.empty(); };
  const auto cracks = [](const auto& material) {
    return std::holds_alternative<Concrete<dim>>(material.law);
  };
  return {.slacken = may_slacken(s),
          .crack = std::ranges::any_of(s.materials, cracks),
          .damped = in.has("dashpots") || std::ranges::any_of(s.materials, is_damped)};
}

}  // namespace

template <int dim>
void read_motion(ConfigReader& in, MotionSettings<dim>& s) {
  read_motion_of(in, Parts{}, s);
}

template <int dim>
void read_motion_with_lines(ConfigReader& in, FemSettings<dim>& s) {
  read_motion_of<dim>(in, parts_of(in, s), s);
}

template void read_motion<2>(ConfigReader&, MotionSettings<2>&);
template void read_motion<3>(ConfigReader&, MotionSettings<3>&);
template void read_motion_with_lines<2>(ConfigReader&, FemSettings<2>&);
template void read_motion_with_lines<3>(ConfigReader&, FemSettings<3>&);

}  // namespace gabion::fem
