// SPDX-License-Identifier: BSD-3-Clause
// Elastic blocks that slide on smooth walls of grids whose cells follow a bed.
#pragma once

#include <array>
#include <cmath>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "tests/unit/mpm/mpm_scene.hpp"

namespace gabion::test {

/// Place in the scene of a place of the flat box: along the bed, (across it,) above it [m].
template <int dim>
using BedMap = std::function<Vector<dim>(const Vector<dim>&)>;

/// A block on the bed, the last axis 0, of a box of cells; both are mapped.
template <int dim>
struct BentBed {
  BedMap<dim> map;
  std::vector<double> low, high;  // of the grid in flat coordinates [m]
  std::vector<double> block_low, block_high;
  double h = 0.1;
  double E = 1e7;
  std::string type = dim == 2 ? "quad4" : "hex8";
  std::array<double, dim> gravity = {};  // [m/s^2]
  Json integration = {{"scheme", "bossak"}, {"alpha", -0.1}};
  Json walls = {{{"group", "bottom"}, {"condition", "slip"}}};
  double split = NAN;  // from here along the bed on it is the group "rest"

  Json cells_in(const std::vector<double>& a, const std::vector<double>& b) const {
    std::vector<int> cells;
    for (int d = 0; d < dim; ++d) cells.push_back(static_cast<int>(std::lround((b[d] - a[d]) / h)));
    return box(a, b, cells, type);
  }
  std::unique_ptr<mpm::MpmSolver<dim>> solver() const {
    const int points = type == "tri3" ? 3 : type == "tet4" ? 4 : dim == 2 ? 4 : 8;
    auto settings = mpm_settings<dim>({{"dimension", dim},
                                       {"grid", cells_in(low, high)},
                                       {"basis", "linear"},
                                       {"gravity", gravity},
                                       {"walls", {{{"group", "bottom"}, {"condition", "slip"}}}},
                                       {"bodies",
                                        {body("block", cells_in(block_low, block_high), points,
                                              elastic_soil("neo_hookean", E, 0.2, 1000))}},
                                       {"time_integration", integration}});
    settings.grid = mpm::BackgroundGrid<dim>(grid());
    for (auto& x : settings.layouts[0].mesh.nodes) x = map(x);
    settings.phases[0].walls.clear();
    for (const auto& each : walls) {
      settings.phases[0].walls.push_back({.group = each["group"],
                                          .fixed = each["condition"] == "fixed",
                                          .where = "",
                                          .motion = {}});
    }
    return std::make_unique<mpm::MpmSolver<dim>>(comm(), std::move(settings), "");
  }

 private:
  Mesh<dim> grid() const {
    Vector<dim> a, b;
    Eigen::Matrix<int, dim, 1> n;
    for (int d = 0; d < dim; ++d) {
      a[d] = low[d];
      b[d] = high[d];
      n[d] = static_cast<int>(std::lround((high[d] - low[d]) / h));
    }
    const CellType cell = type == "tri3"    ? CellType::tri3
                          : type == "tet4"  ? CellType::tet4
                          : type == "quad4" ? CellType::quad4
                                            : CellType::hex8;
    Mesh<dim> mesh = box_mesh<dim>(a, b, n, cell);
    split_bed(mesh);
    for (auto& x : mesh.nodes) x = map(x);
    return mesh;
  }
  void split_bed(Mesh<dim>& mesh) const {
    if (std::isnan(split)) return;
    const auto width = static_cast<std::size_t>(num_nodes(facet_type(mesh.cell_type)));
    const auto all = mesh.facet_groups["bottom"];
    auto &first = mesh.facet_groups["bottom"], &rest = mesh.facet_groups["rest"];
    first.clear();
    for (std::size_t f = 0; f < all.size(); f += width) {
      double middle = 0;
      for (std::size_t k = f; k < f + width; ++k) middle += mesh.nodes[all[k]][0] / double(width);
      auto& part = middle < split ? first : rest;
      part.insert(part.end(), all.begin() + f, all.begin() + f + width);
    }
  }
};

/// A rigid body that turns about the origin in the plane of the first and the last axis: angle
/// from the lowest place and angular velocity, after a time from rest.
struct Pendulum {
  double angle = 0;  // [rad]
  double rate = 0;   // [rad/s]

  /// @param k  m g r_c / I [1/s^2], of a hill negative
  void swing(double k, double time) {
    const int steps = 2000;
    const double dt = time / steps;
    for (int n = 0; n < steps; ++n) {  // Stoermer and Verlet
      rate -= 0.5 * dt * k * std::sin(angle);
      angle += dt * rate;
      rate -= 0.5 * dt * k * std::sin(angle);
    }
  }
};

}  // namespace gabion::test
