// SPDX-License-Identifier: BSD-3-Clause
#include "mpm_solver/checks/soil_at_rest.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <vector>

#include "common/base/log.hpp"
#include "common/mechanics/materials/own_weight.hpp"
#include "common/mechanics/mesh/boundary.hpp"
#include "common/mechanics/mesh/mesh_box.hpp"

namespace gabion::mpm {

namespace {

/// Mean depth along a direction of length 1: volume over the area that it looks down on [m]. It is
/// that of the layer, however far the ground falls below it.
template <int dim>
double mean_depth(const Mesh<dim>& mesh, const Vector<dim>& direction) {
  if (mesh.file.empty()) {  // a box
    return 1 / direction.cwiseAbs().cwiseQuotient(box_around(mesh).sizes()).sum();
  }
  double volume = 0, area = 0;  // each column has a facet at the top and one at the bottom
  for (std::int32_t c = 0; c < mesh.num_cells(); ++c) volume += cell_volume(mesh, c);
  const auto facets = boundary_facets(mesh);
  for (const auto& vector :
       facet_area_vectors<dim>(mesh.nodes, facet_type(mesh.cell_type), facets)) {
    area += 0.5 * std::abs(vector.dot(direction));
  }
  return volume / area;
}

}  // namespace

template <int dim>
WeightedColumn column_of(const MpmSettings<dim>& settings, std::size_t b) {
  const Material<dim>& material = settings.bodies[b].material;
  const double g = settings.gravity.norm();
  WeightedColumn column;
  column.density = material.density;
  column.p_wave_modulus = undrained_modulus(settings.bodies[b]);
  column.gravity = g;
  if (g > 0) column.height = mean_depth<dim>(settings.layouts[b].mesh, settings.gravity / g);
  return column;
}

template <int dim>
std::string free_of_stress_text(const MpmSettings<dim>& settings) {
  const Phase& phase = settings.phases.front();
  if (!phase.dynamic || phase.gravity_ramp.at(0) == 0 || settings.gravity.isZero(0)) return "";
  std::vector<std::string> names;
  double period = 0;  // [s]
  for (std::size_t b = 0; b < settings.bodies.size(); ++b) {
    if (settings.initial_stress[b] || !settings.layouts[b].velocity.isZero(0)) continue;
    names.push_back(settings.bodies[b].name);
    period = std::max(period, column_of(settings, b).period());
  }
  if (names.empty()) return "";
  return fmt::format(
      "free of stress at the start, with its whole weight at once: {}. Such soil oscillates with a "
      "period of {:.2g} s: the force on its bed varies from almost none to twice the weight until "
      "friction and walls have damped it. To start at rest: \"initial_stress\" (level layers), a "
      "first phase with \"analysis\": \"quasi_static\" (slopes too), or a \"gravity_ramp\" of "
      "several periods (docs/guide.md)",
      fmt::join(names, ", "), period);
}

namespace {

// Missing share of a thrust between walls from which on a warning is given.
constexpr double notable_share = 0.05;

struct SoftContact {
  double share = 0;  // of the thrust that is missing
  std::size_t body = 0;
  double pressure = 0, depth = 0, width = 0;  // [Pa], [m], [m]
};

/// Part r of the thrust that a wall bears. The wall recedes by depth ~ sqrt(pressure), the soil
/// expands by pressure / M over its width: r + depth M / (p width) sqrt(r) = 1.
template <int dim>
SoftContact soft_contact(const MpmSettings<dim>& settings, std::size_t b, double factor,
                         double cell_size) {
  const WeightedColumn column = column_of(settings, b);
  const Vector<dim> sizes = box_around(settings.layouts[b].mesh).sizes();
  SoftContact soft{.body = b};
  for (int d = 0; d < dim; ++d) {  // the longest edge of the box as gravity sees it
    const double along = settings.gravity[d] / column.gravity;
    soft.width = std::max(soft.width, sizes[d] * std::sqrt(std::max(0.0, 1 - along * along)));
  }
  const double M = column.p_wave_modulus;
  soft.pressure = 0.5 * column.density * column.gravity * column.height;
  soft.depth = cell_size * std::sqrt(soft.pressure / (factor * M));
  const double ratio = soft.depth * M / (soft.pressure * soft.width);
  const double root = std::hypot(1, 0.5 * ratio) - 0.5 * ratio;
  soft.share = 1 - root * root;
  return soft;
}

}  // namespace

template <int dim>
std::string soft_interfaces_text(const MpmSettings<dim>& settings, double cell_size) {
  const Phase& phase = settings.phases.front();
  const bool takes_weight = !phase.dynamic || phase.gravity_ramp.runs(0);
  if (!takes_weight || settings.gravity.isZero(0)) return "";
  SoftContact softest;
  std::vector<std::string> names;
  for (const auto& interface : settings.interfaces) {
    const auto* facets = std::get_if<FacetSettings>(&interface.method);
    if (facets == nullptr || facets->resting_factor > 0) continue;
    names.push_back(interface.name);
    for (std::size_t b = 0; b < settings.bodies.size(); ++b) {
      if (settings.initial_stress[b]) continue;
      const auto soft = soft_contact(settings, b, facets->penalty_factor, cell_size);
      if (soft.share > softest.share) softest = soft;
    }
  }
  if (softest.share <= notable_share) return "";
  return fmt::format(
      "soft contact while soil takes its weight, at {}: at {:.3g} Pa, half the pressure under "
      "\"{}\", it yields by {:.2g} m. The thrust at rest over {:.3g} m of that soil would be some "
      "{:.0f} % too small. With \"resting_factor\": 12 of the interface it is at most 3 % too "
      "small; with \"initial_stress\" it is there from the start",
      fmt::join(names, ", "), softest.pressure, settings.bodies[softest.body].name, softest.depth,
      softest.width, 100 * softest.share);
}

namespace {

// Warn of weight that comes onto pore water: the skeleton is left without stress, and so without
// friction.
template <int dim>
void warn_of_weight_on_water(const MpmSettings<dim>& settings) {
  if (settings.gravity.isZero(0)) return;
  for (std::size_t b = 0; b < settings.bodies.size(); ++b) {
    const Body<dim>& body = settings.bodies[b];
    if (!body.water || body.water->drains() || settings.initial_stress[b]) continue;
    const double Q = body.water->modulus(), M = skeleton_modulus(body);
    log::warn(
        "{}/{}: found \"water\" without \"initial_stress\": the weight acts on undrained soil, and "
        "the water bears {:.3g} % of a confined load, so that the skeleton has almost no effective "
        "stress and no friction. For soil that was at rest before: \"initial_stress\" with "
        "\"water_table\"",
        settings.bodies_where, b, 100 * Q / (Q + M));
  }
}

}  // namespace

template <int dim>
void log_soil_at_rest(const MpmSettings<dim>& settings, double cell_size) {
  warn_of_weight_on_water(settings);
  for (std::size_t b = 0; b < settings.bodies.size(); ++b) {
    log_own_weight(fmt::format("{}/{}/material", settings.bodies_where, b), column_of(settings, b));
  }
  const std::string text = free_of_stress_text(settings);
  if (!text.empty()) log::info("{}", text);
  const std::string soft = soft_interfaces_text(settings, cell_size);
  if (!soft.empty()) log::warn("{}", soft);
}

namespace {

/// A body with initial stress on top of another.
template <int dim>
class StackedBodies {
 public:
  StackedBodies(const MpmSettings<dim>& settings, const Vector<dim>& gravity, std::size_t lower,
                std::size_t upper)
      : settings_(settings), gravity_(gravity), lower_(lower), upper_(upper) {
    const auto below = box_around(settings.layouts[lower].mesh);
    const auto above = box_around(settings.layouts[upper].mesh);
    height_ = below.max()[dim - 1];
    const double tolerance = 1e-6 * (below.sizes()[dim - 1] + above.sizes()[dim - 1]);
    meet_ = std::abs(above.min()[dim - 1] - height_) <= tolerance;
    for (int d = 0; d + 1 < dim; ++d) {
      meet_ = meet_ &&
              std::min(below.max()[d], above.max()[d]) > std::max(below.min()[d], above.min()[d]);
    }
  }

  /// The message; empty: they do not meet, or the stress does not jump.
  std::string text() const {
    if (!meet_) return "";
    const double from_above = pressure(upper_, settings_.initial_stress[upper_]->surface);
    const double from_below = pressure(lower_, settings_.initial_stress[lower_]->surface);
    constexpr double same = 1e-3;
    if (std::abs(from_above - from_below) <= same * std::max(from_above, from_below)) return "";
    const Body<dim>&above = settings_.bodies[upper_], &below = settings_.bodies[lower_];
    return fmt::format(
        "; where \"{}\" ({:g} kg/m^3) lies on \"{}\" ({:g} kg/m^3), at {:g}, the vertical stress "
        "jumps from {:.4g} to {:.4g} Pa: each layer has the stress of its own density up to its "
        "\"surface\". With \"surface\": {:.9g} of \"{}\" there is no jump",
        above.name, above.material.density, below.name, below.material.density, height_,
        -from_above, -from_below, balanced_surface(from_above), below.name);
  }

 private:
  /// Vertical stress where the bodies meet, of a body whose own density reaches up to `surface`
  /// [Pa].
  double pressure(std::size_t b, double surface) const {
    InitialStress stress = *settings_.initial_stress[b];
    stress.surface = surface;
    const BodyAtRest<dim> body{
        .body = settings_.bodies[b], .number = static_cast<std::int32_t>(b), .gravity = gravity_};
    return -initial_stress_at<dim>(stress, body, height_)[dim - 1];
  }

  // The `surface` at which the vertical stress is `wanted`: pressure is nearly proportional to
  // depth [m].
  double balanced_surface(double wanted) const {
    double depth = -wanted / (settings_.bodies[lower_].material.density * gravity_[dim - 1]);
    for (int k = 0; k < 50 && depth > 0; ++k) depth *= wanted / pressure(lower_, height_ + depth);
    return height_ + depth;
  }

  const MpmSettings<dim>& settings_;
  const Vector<dim>& gravity_;
  std::size_t lower_, upper_;
  double height_ = 0;  // where they meet [m]
  bool meet_ = false;
};

}  // namespace

template <int dim>
std::string stress_jump_text(const MpmSettings<dim>& settings, const Vector<dim>& gravity) {
  const std::size_t count = settings.bodies.size();
  for (std::size_t lower = 0; lower < count; ++lower) {
    for (std::size_t upper = 0; upper < count; ++upper) {
      if (lower == upper || !settings.initial_stress[lower] || !settings.initial_stress[upper]) {
        continue;
      }
      // What flowing water leaves to the grains is not known before the flow is.
      if (settings.initial_stress[lower]->steady_seepage ||
          settings.initial_stress[upper]->steady_seepage) {
        continue;
      }
      const std::string text = StackedBodies<dim>(settings, gravity, lower, upper).text();
      if (!text.empty()) return text;
    }
  }
  return "";
}

template WeightedColumn column_of(const MpmSettings<2>&, std::size_t);
template WeightedColumn column_of(const MpmSettings<3>&, std::size_t);
template std::string free_of_stress_text(const MpmSettings<2>&);
template std::string free_of_stress_text(const MpmSettings<3>&);
template std::string soft_interfaces_text(const MpmSettings<2>&, double);
template std::string soft_interfaces_text(const MpmSettings<3>&, double);
template void log_soil_at_rest(const MpmSettings<2>&, double);
template void log_soil_at_rest(const MpmSettings<3>&, double);
template std::string stress_jump_text<2>(const MpmSettings<2>&, const Vector<2>&);
template std::string stress_jump_text<3>(const MpmSettings<3>&, const Vector<3>&);

}  // namespace gabion::mpm
