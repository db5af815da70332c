// SPDX-License-Identifier: BSD-3-Clause
#include "mpm_solver/checks/overlaps.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <memory>
#include <utility>

#include "common/base/log.hpp"
#include "common/base/require.hpp"
#include "common/mechanics/mesh/connected_parts.hpp"
#include "common/mechanics/mesh/mesh_box.hpp"
#include "common/mechanics/ranks/sum.hpp"
#include "mpm_solver/grid/cell_locator.hpp"

namespace gabion::mpm {

namespace {

// Share of the points of the smaller body that may lie in another one without an error.
constexpr double allowed_share = 0.01;

/// Volume and mass of material points, and the box around them.
template <int dim>
struct PointSum {
  double volume = 0;                   // [m^3]
  double mass = 0;                     // [kg]
  Eigen::AlignedBox<double, dim> box;  // [m]

  void add(const MaterialPoints<dim>& points, std::int32_t p, double share) {
    volume += share * points.V0[p] * points.J[p];
    mass += share * points.m[p];
    box.extend(points.x[p]);
  }
  /// Add what the other ranks have. @note Collective.
  void gather(MPI_Comm comm) {
    double sums[] = {volume, mass};
    sum_over_ranks(comm, std::span<double>(sums));
    volume = sums[0];
    mass = sums[1];
    for (int d = 0; d < dim; ++d) {
      box.min()[d] = -max_over_ranks(comm, -box.min()[d]);
      box.max()[d] = max_over_ranks(comm, box.max()[d]);
    }
  }
};

template <int dim>
class Overlaps {
 public:
  Overlaps(MPI_Comm comm, const MpmSettings<dim>& settings, const MaterialPoints<dim>& points)
      : comm_(comm), settings_(settings), points_(points), locators_(settings.layouts.size()) {
    for (const auto& layout : settings.layouts) boxes_.push_back(box_around(layout.mesh));
  }

  /// Sum over the points of one body that lie in cells of another.
  PointSum<dim> points_in(std::int32_t body, std::int32_t other) {
    const auto common = boxes_[body].intersection(boxes_[other]);
    PointSum<dim> sum;
    if (!(common.sizes().minCoeff() > 0)) return sum;  // on all ranks
    std::int32_t cell = -1;
    for_each_point(body, [&](std::int32_t p) {
      if (!common.contains(points_.x[p])) return;
      const std::int32_t found = locator(other).locate(points_.x[p], cell);
      if (found < 0) return;
      sum.add(points_, p, 1);
      cell = found;
    });
    sum.gather(comm_);
    return sum;
  }

  /// Sum over the points of one body in places that its cells hold more than once.
  PointSum<dim> points_in_itself(std::int32_t body) {
    PointSum<dim> sum;
    for_each_point(body, [&](std::int32_t p) {
      const auto count = static_cast<double>(locator(body).cells_at(points_.x[p]).size());
      if (count > 1) sum.add(points_, p, (count - 1) / count);
    });
    sum.gather(comm_);
    return sum;
  }

  PointSum<dim> all_of(std::int32_t body) const {
    PointSum<dim> sum;
    for_each_point(body, [&](std::int32_t p) { sum.add(points_, p, 1); });
    sum.gather(comm_);
    return sum;
  }

 private:
  template <class Visit>
  void for_each_point(std::int32_t body, const Visit& visit) const {
    for (std::int32_t p = points_.body_starts[body]; p < points_.body_starts[body + 1]; ++p) {
      visit(p);
    }
  }
  const CellLocator<dim>& locator(std::int32_t body) {
    auto& made = locators_[body];
    if (!made) made = std::make_unique<CellLocator<dim>>(settings_.layouts[body].mesh);
    return *made;
  }

  MPI_Comm comm_;
  const MpmSettings<dim>& settings_;
  const MaterialPoints<dim>& points_;
  std::vector<Eigen::AlignedBox<double, dim>> boxes_;        // around each body
  std::vector<std::unique_ptr<CellLocator<dim>>> locators_;  // null: not asked for yet
};

template <int dim>
std::string box_text(const Eigen::AlignedBox<double, dim>& box) {
  return fmt::format("({:.6g}) to ({:.6g})", fmt::join(box.min(), ", "),
                     fmt::join(box.max(), ", "));
}

/// @param share  of the points of the smaller body
void say(double share, const std::string& text) {
  require<ConfigError>(share <= allowed_share, "{}; allowed: bodies that fill space once", text);
  log::warn("{}", text);
}

template <int dim>
void check_pair(Overlaps<dim>& overlaps, const MpmSettings<dim>& settings, std::int32_t a,
                std::int32_t b) {
  const auto a_in_b = overlaps.points_in(a, b), b_in_a = overlaps.points_in(b, a);
  const auto& larger = a_in_b.volume >= b_in_a.volume ? a_in_b : b_in_a;
  if (!(larger.volume > 0)) return;
  const double of_a = overlaps.all_of(a).volume, of_b = overlaps.all_of(b).volume;
  say(of_a < of_b ? a_in_b.volume / of_a : b_in_a.volume / of_b,
      fmt::format("{}: found that \"{}\" and \"{}\" overlap: material points of {:.4g} m^3 at {} "
                  "lie in cells of the other body, so that the same room holds {:.6g} kg of \"{}\" "
                  "and {:.6g} kg of \"{}\"",
                  settings.bodies_where, settings.bodies[a].name, settings.bodies[b].name,
                  larger.volume, box_text<dim>(larger.box), a_in_b.mass, settings.bodies[a].name,
                  b_in_a.mass, settings.bodies[b].name));
}

template <int dim>
void check_itself(Overlaps<dim>& overlaps, const MpmSettings<dim>& settings, std::int32_t b) {
  const Mesh<dim>& mesh = settings.layouts[b].mesh;
  if (mesh.file.empty() || connection_of(mesh).parts.size() < 2) return;
  const auto doubled = overlaps.points_in_itself(b);
  if (!(doubled.volume > 0)) return;
  const auto all = overlaps.all_of(b);
  say(doubled.volume / all.volume,
      fmt::format("{}: found that parts of \"{}\" overlap at {}: its {:.6g} kg fill room for "
                  "{:.6g} kg, {:.4g} m^3 are held twice",
                  settings.bodies_where, settings.bodies[b].name, box_text<dim>(doubled.box),
                  all.mass, all.mass - doubled.mass, doubled.volume));
}

}  // namespace

template <int dim>
void check_overlaps(MPI_Comm comm, const MpmSettings<dim>& settings,
                    const MaterialPoints<dim>& points) {
  Overlaps<dim> overlaps(comm, settings, points);
  const auto count = static_cast<std::int32_t>(settings.bodies.size());
  for (std::int32_t b = 0; b < count; ++b) {
    check_itself(overlaps, settings, b);
    for (std::int32_t a = 0; a < b; ++a) check_pair(overlaps, settings, a, b);
  }
}

template void check_overlaps<2>(MPI_Comm, const MpmSettings<2>&, const MaterialPoints<2>&);
template void check_overlaps<3>(MPI_Comm, const MpmSettings<3>&, const MaterialPoints<3>&);

}  // namespace gabion::mpm
