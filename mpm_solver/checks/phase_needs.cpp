// SPDX-License-Identifier: BSD-3-Clause
#include "mpm_solver/checks/phase_needs.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <string>
#include <variant>

#include "common/mechanics/materials/strength_reduction.hpp"
#include "mpm_solver/checks/seepage.hpp"

namespace gabion::mpm {

namespace {

// Refuse what explicit steps cannot do.
template <int dim>
void check_explicit_phases(const ConfigReader& in, const MpmSettings<dim>& settings) {
  for (const Phase& phase : settings.phases) {
    if (!phase.is_explicit()) continue;
    if (method_in(settings.small_cuts, settings.grid.basis, true) == SmallCutMethod::ghost) {
      in.fail("small_cuts", "found \"ghost\", allowed with explicit steps: none, mass_cutoff");
    }
    if (settings.tpic) {
      in.fail("transfer", "found \"tpic\", allowed with explicit steps: flip");
    }
    const auto require_facets = [&](const std::string& key, const ContactSettings<dim>& surface) {
      if (std::holds_alternative<FacetSettings>(surface.method)) return;
      in.fail(key, "found \"boundary_points\", allowed with explicit steps: facets");
    };
    for (std::size_t k = 0; k < settings.interfaces.size(); ++k) {
      require_facets(fmt::format("interfaces/{}/method", k), settings.interfaces[k]);
    }
    for (std::size_t k = 0; k < settings.rigid_walls.size(); ++k) {
      require_facets(fmt::format("rigid_walls/{}/method", k), settings.rigid_walls[k].boundary);
    }
  }
}

template <int dim>
void check_fluids(const ConfigReader& in, const MpmSettings<dim>& settings) {
  for (std::size_t b = 0; b < settings.bodies.size(); ++b) {
    const Body<dim>& body = settings.bodies[b];
    if (!std::holds_alternative<Newtonian<dim>>(body.material.law)) continue;
    const std::string where = fmt::format("bodies/{}/material/law", b);
    if (body.water) {
      in.fail(where, "found \"newtonian\" with \"water\", allowed: without; a fluid has no pores");
    }
    for (std::size_t k = 0; k < settings.phases.size(); ++k) {
      if (settings.phases[k].dynamic) continue;
      in.fail(where, fmt::format("found \"newtonian\" with phase {}, quasi-static, allowed: phases "
                                 "with inertia; nothing but inertia holds the shape of a fluid",
                                 k));
    }
    if (settings.small_cuts.method == SmallCutMethod::ghost) {
      in.fail("small_cuts/method",
              fmt::format("found \"ghost\" with the fluid \"{}\", allowed: auto, none, mass_cutoff",
                          body.name));
    }
  }
}

// Refuse laws whose strength cannot be reduced, elastic ones excepted, pore water that drains,
// interfaces, and wide bases.
template <int dim>
void check_strength_reduction(const ConfigReader& in, const MpmSettings<dim>& settings) {
  if (!any_reduces_strength(settings.phases)) return;
  for (std::size_t b = 0; b < settings.bodies.size(); ++b) {
    if (!drains(settings.bodies[b])) continue;
    in.fail(
        fmt::format("bodies/{}/water/permeability", b),
        "found together with \"strength_reduction\", allowed: none; the soil is dry, or its pore "
        "water stays where it is");
  }
  if (settings.grid.basis != Basis::linear) {
    in.fail("basis",
            fmt::format("found \"{}\" together with \"strength_reduction\", allowed: \"linear\"; "
                        "other basis functions hold soil beyond its surface and give factors some "
                        "5 % larger with ten cells over a slope",
                        basis_name(settings.grid.basis)));
  }
  if (!settings.interfaces.empty()) {
    in.fail("interfaces", "found together with \"strength_reduction\", allowed: rigid walls");
  }
  bool any = false;
  for (std::size_t b = 0; b < settings.bodies.size(); ++b) {
    const auto& material = settings.bodies[b].material;
    const bool reducible = with_reduced_strength<dim>(material.law, 1).has_value();
    any |= reducible;
    if (reducible || is_elastic<dim>(material.law)) continue;
    const bool softens = std::holds_alternative<SofteningSoil<dim>>(material.law);
    in.fail(fmt::format("bodies/{}/material/law", b),
            fmt::format("found \"{}\"{} together with \"strength_reduction\", allowed: "
                        "mohr_coulomb, drucker_prager, tresca, without \"softening\", and elastic "
                        "laws beside them",
                        material.law_name, softens ? " with \"softening\"" : ""));
  }
  if (!any) {
    in.fail("bodies",
            "found elastic laws alone together with \"strength_reduction\", allowed: at "
            "least one body of mohr_coulomb, drucker_prager or tresca");
  }
}

}  // namespace

template <int dim>
void check_phase_needs(const ConfigReader& in, const MpmSettings<dim>& settings) {
  check_explicit_phases(in, settings);
  check_fluids(in, settings);
  check_strength_reduction(in, settings);
}

template void check_phase_needs<2>(const ConfigReader&, const MpmSettings<2>&);
template void check_phase_needs<3>(const ConfigReader&, const MpmSettings<3>&);

}  // namespace gabion::mpm
