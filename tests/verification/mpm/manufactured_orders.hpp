// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <fmt/format.h>

#include <optional>

#include "tests/support/convergence_rate.hpp"
#include "tests/support/verification_row.hpp"
#include "tests/verification/mpm/manufactured.hpp"

namespace gabion::test {

/// One basis on one manufactured solution.
template <int dim>
struct OrderStudy {
  std::string id;
  std::string what;  ///< solution and amplitude
  Manufactured<dim> exact;
  std::function<ManufacturedBox(int cells)> shape;
  std::string basis = "linear";
};

/// Bounds of one basis: largest error, lowest order (none where the error does not fall with h),
/// and what excuses them.
struct Expected {
  std::string basis;
  double error = 0;
  std::optional<double> order = {};
  std::string limitation = {};
};

inline const std::string cells_are_crossed =
    "once points cross cells, the jumps of the linear gradient let the error grow with refinement";

inline const std::string points_are_uneven =
    "the error of splines stalls at this amplitude, where that of gimp continues to fall: points "
    "that moved integrate the splines' gradients unevenly";

inline const std::string shear_is_large =
    "at shears of up to 3 within half a unit no basis converges on these grids: with linear "
    "basis functions cells are crossed, domains of gimp stay boxes, points lie in uneven rows";

/// Errors over the cell size, at a step so small that it does not count: a row with the error on
/// the finest grid, and unless `expected` has none one with the last order.
/// @param cells  rising
template <int dim>
void order_in_h(const OrderStudy<dim>& study, const std::vector<int>& cells, int steps,
                const Expected& expected) {
  std::vector<double> sizes, errors;
  for (const int n : cells) {
    ManufacturedBox shape = study.shape(n);
    shape.basis = study.basis;
    sizes.push_back((shape.high[0] - shape.low[0]) / n);
    errors.push_back(largest_error<dim>(study.exact, shape, steps));
  }
  draw_curve({.id = study.id,
              .figure = "error over h",
              .x_label = "h [m]",
              .y_label = "largest rms displacement error by amplitude",
              .label = study.basis + ", " + study.what},
             sizes, errors);
  const std::string what = fmt::format("{}, MPM {}", study.what, study.basis);
  verify({.id = study.id,
          .what = fmt::format("{}: displacement error, {} cells", what, cells.back()),
          .exact = 0,
          .computed = errors.back(),
          .measure = Measure::absolute_error,
          .bound = expected.error,
          .limitation = expected.limitation});
  if (!expected.order) return;
  verify({.id = study.id,
          .what = what + ": order in h",
          .exact = 2,
          .computed = last_rate(sizes, errors),
          .measure = Measure::order,
          .bound = *expected.order,
          .limitation = expected.limitation});
}

/// Difference of the displacements after 3/4 of the time to those of a run with an eighth of the
/// smallest step on the same grid. The grid must be fine: the transfer adds a damping of first
/// order in dt that falls with h^2 (see V7).
/// @param steps  rising
template <int dim>
void order_in_dt(const OrderStudy<dim>& study, int cells, const std::vector<int>& steps,
                 double order_bound) {
  ManufacturedBox shape = study.shape(cells);
  shape.basis = study.basis;
  Manufactured<dim> exact = study.exact;
  exact.end *= 0.75;
  const auto reference = final_displacements<dim>(exact, shape, 8 * steps.back());
  std::vector<double> sizes, errors;
  for (const int n : steps) {
    const auto u = final_displacements<dim>(exact, shape, n);
    double sum = 0;
    for (std::size_t p = 0; p < u.size(); ++p) sum += (u[p] - reference[p]).squaredNorm();
    sizes.push_back(exact.end / n);
    errors.push_back(std::sqrt(sum / static_cast<double>(u.size())) / study.exact.size);
  }
  draw_curve({.id = study.id,
              .figure = "error over dt",
              .x_label = "dt [s]",
              .y_label = "rms displacement error by amplitude, same grid",
              .label = study.basis + ", " + study.what},
             sizes, errors);
  verify({.id = study.id,
          .what = fmt::format("{}, MPM {}: order in dt", study.what, study.basis),
          .exact = 2,
          .computed = last_rate(sizes, errors),
          .measure = Measure::order,
          .bound = order_bound});
}

}  // namespace gabion::test
