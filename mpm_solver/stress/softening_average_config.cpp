// SPDX-License-Identifier: BSD-3-Clause
#include "mpm_solver/stress/softening_average_config.hpp"

#include <fmt/format.h>

#include <algorithm>

#include "common/base/require.hpp"

namespace gabion::mpm {

namespace {

// Least length over the extent of a cell along an axis: below it the mapping between points and
// grid decides the width.
constexpr double least_length = 1.5;

template <int dim>
double extent(const BackgroundGrid<dim>& grid, std::int32_t cell) {
  Vector<dim> x[max_cell_nodes];
  grid.corners(cell, x);
  Vector<dim> low = x[0], high = x[0];
  for (int i = 1; i < grid.nodes_per_cell(); ++i) {
    low = low.cwiseMin(x[i]);
    high = high.cwiseMax(x[i]);
  }
  return (high - low).maxCoeff();
}

}  // namespace

KeyTable softening_average_keys() {
  return {
      "softening_average",
      "Over-nonlocal softening, for studies of grids: shear bands are 4.71 `length` wide with "
      "`weight` 2, whatever the direction of the grid.",
      {key::number("length", "m",
                   "Internal length; at least 1.5 times the extent of a cell along an axis.")
           .in(positive()),
       key::number("weight", "", "Weight m of the mean; the strain of the point itself has 1 - m.")
           .in(in_words({.low = 1, .high = 4, .low_open = true}, "above 1, at most 4"))
           .or_else(2)}};
}

template <int dim>
SofteningAverage read_softening_average(ConfigReader in, const MaterialLaw<dim>& law) {
  const auto* soil = std::get_if<SofteningSoil<dim>>(&law);
  if (soil == nullptr) {
    in.fail("length",
            "found with a law that does not soften, allowed: with the \"softening\" of "
            "mohr_coulomb or tresca");
  }
  if (!soil->parameters().by_slip) {
    in.fail("length",
            "found with a softening by the strain, allowed: with one by \"slip\" or \"table\"; "
            "the average turns the strain into the slip of a surface");
  }
  SofteningAverage average{.length = in.number("length"), .weight = in.number("weight")};
  in.finish();
  return average;
}

template <int dim>
void require_resolved(const SofteningAverage& average, const BackgroundGrid<dim>& grid,
                      const std::string& where) {
  double widest = 0;
  for (std::int32_t c = 0; c < grid.num_cells(); ++c) {
    widest = std::max(widest, extent(grid, c));
  }
  require<ConfigError>(average.length >= least_length * widest * (1 - 1e-9), [&] {
    return fmt::format(
        "{}/softening_average/length: found {:.6g} m with cells up to {:.4g} m wide, allowed: at "
        "least {:.4g} m, {} times that, or smaller cells: below that the cells set the width of "
        "shear bands",
        where, average.length, widest, least_length * widest, least_length);
  });
}

void require_falling(const StrengthCurve& curve, const std::function<std::string()>& where) {
  Strength before = curve.at(0).value;
  for (const double x : curve.samples()) {
    const Strength now = curve.at(x).value;
    const bool rises = now.cohesion > before.cohesion * (1 + 1e-12) ||
                       now.sin_friction > before.sin_friction * (1 + 1e-12);
    require<ConfigError>(!rises, [&] {
      return fmt::format(
          "{}: found a strength that rises with the slip, at {:.4g} m, with a softening_average, "
          "allowed: cohesion and friction that only fall; in soil that hardens first, points would "
          "soften one by one",
          where(), x);
    });
    before = now;
  }
}

template SofteningAverage read_softening_average<2>(ConfigReader, const MaterialLaw<2>&);
template SofteningAverage read_softening_average<3>(ConfigReader, const MaterialLaw<3>&);
template void require_resolved<2>(const SofteningAverage&, const BackgroundGrid<2>&,
                                  const std::string&);
template void require_resolved<3>(const SofteningAverage&, const BackgroundGrid<3>&,
                                  const std::string&);

}  // namespace gabion::mpm
