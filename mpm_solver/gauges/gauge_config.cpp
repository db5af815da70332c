// SPDX-License-Identifier: BSD-3-Clause
#include "mpm_solver/gauges/gauge_config.hpp"

#include <fmt/ranges.h>

#include "common/base/log.hpp"
#include "mpm_solver/config_checks.hpp"

namespace gabion::mpm {

namespace {

template <int dim>
Eigen::AlignedBox<double, dim> box_around(const typename Gauge<dim>::Corners& corners) {
  Eigen::AlignedBox<double, dim> box;
  for (const Vector<dim>& x : corners) box.extend(x);
  if constexpr (dim == 3) box.extend(corners[1] + corners[2] - corners[0]);
  return box;
}

template <int dim>
void warn_outside(const ConfigReader& in, const std::string& name,
                  const typename Gauge<dim>::Corners& corners,
                  const Eigen::AlignedBox<double, dim>& grid) {
  if (grid.intersects(box_around<dim>(corners))) return;
  const auto& low = grid.min();
  const auto& high = grid.max();
  log::warn(
      "{}: the gauge \"{}\" lies outside the background grid, from ({:.6g}) to ({:.6g}): soil "
      "never reaches it, and all of its columns stay zero",
      in.where("corners"), name, fmt::join(low, ", "), fmt::join(high, ", "));
}

template <int dim>
Gauge<dim> read_gauge(ConfigReader& in, const Eigen::AlignedBox<double, dim>& grid) {
  const std::string name = in.name("name");
  const auto rows = in.rows("corners", dim);
  if (rows.size() != dim) {
    in.fail("corners", fmt::format("found {} points, allowed: {}", rows.size(),
                                   dim == 2 ? "2, the foot and the top"
                                            : "3, both ends of the foot and the top above the "
                                              "first of them"));
  }
  typename Gauge<dim>::Corners corners;
  for (int k = 0; k < dim; ++k) corners[k] = Eigen::Map<const Vector<dim>>(rows[k].data());
  warn_outside<dim>(in, name, corners, grid);
  try {
    return Gauge<dim>(name, corners);
  } catch (const ConfigError& error) {
    in.fail("corners", error.what());
  }
}

}  // namespace

KeyTable gauge_keys() {
  return {"gauge",
          "A piece of a plane, at rest; the soil that passes through it is measured.",
          {key::plain_name("Unique name; columns of the tables start with it."),
           key::rows("corners", "m",
                     "2D: foot and top of a segment. 3D: both ends of the foot of a parallelogram, "
                     "then the top above the first of them. Flow counts positive to the right of "
                     "the line from foot to top, in 3D along the cross product of foot line and "
                     "that line.")
               .wide(2, 3)
               .not_empty(2)}};
}

template <int dim>
std::vector<Gauge<dim>> read_gauges(ConfigReader& in, const Eigen::AlignedBox<double, dim>& grid) {
  std::vector<Gauge<dim>> gauges;
  for (auto& item : in.objects("gauges")) {
    gauges.push_back(read_gauge<dim>(item, grid));
    item.finish();
    require_own_name(item, gauges);
  }
  return gauges;
}

template std::vector<Gauge<2>> read_gauges<2>(ConfigReader&, const Eigen::AlignedBox<double, 2>&);
template std::vector<Gauge<3>> read_gauges<3>(ConfigReader&, const Eigen::AlignedBox<double, 3>&);

}  // namespace gabion::mpm
