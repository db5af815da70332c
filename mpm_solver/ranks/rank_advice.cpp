// SPDX-License-Identifier: BSD-3-Clause
#include "mpm_solver/ranks/rank_advice.hpp"

#include <fmt/format.h>

#include <algorithm>

#include "mpm_solver/checks/seepage.hpp"

namespace gabion::mpm {

namespace {

// Least number of points of a rank that was measured to pay.
constexpr std::int64_t points_of_a_rank = 10000;

template <int dim>
std::int64_t num_points(const MpmSettings<dim>& settings) {
  std::int64_t sum = 0;
  for (const PointLayout<dim>& layout : settings.layouts) sum += mpm::num_points(layout);
  return sum;
}

}  // namespace

template <int dim>
RankAdvice advise_ranks(const MpmSettings<dim>& settings, int cores) {
  const std::int64_t points = num_points(settings);
  const std::string what = fmt::format("{} points in {}", points, dim == 2 ? "the plane" : "space");
  const std::int64_t ranks = std::min<std::int64_t>(cores, points / points_of_a_rank);
  if (dim == 2) return {1, what + ": several ranks are not advised in the plane"};
  if (cores < 2) return {1, "one core"};
  if (ranks < 2) {
    return {1, fmt::format("{}, fewer than {} for two ranks", what, 2 * points_of_a_rank)};
  }
  const std::string& method = settings.linear_solver.method;
  if (method == "lu" || method == "mumps") return {1, "the linear solver " + method};
  if (std::ranges::any_of(settings.bodies, drains<dim>)) {
    return {1, "pore water that drains, whose matrix is factorised"};
  }
  return {static_cast<int>(ranks), fmt::format("{}, {} cores", what, cores)};
}

template RankAdvice advise_ranks<2>(const MpmSettings<2>&, int);
template RankAdvice advise_ranks<3>(const MpmSettings<3>&, int);

}  // namespace gabion::mpm
