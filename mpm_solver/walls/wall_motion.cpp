// SPDX-License-Identifier: BSD-3-Clause
#include "mpm_solver/walls/wall_motion.hpp"

#include <fmt/format.h>

#include <algorithm>

namespace gabion::mpm {

template <int dim>
Vector<dim> WallMotion::displacement(double time) const {
  if (!velocity.empty()) return time * Eigen::Map<const Vector<dim>>(velocity.data());
  if (table.empty()) return Vector<dim>::Zero();
  const auto value = [](const std::vector<double>& row) {
    return Vector<dim>(Eigen::Map<const Vector<dim>>(row.data() + 1));
  };
  if (time <= table.front()[0]) return value(table.front());
  if (time >= table.back()[0]) return value(table.back());
  const auto after = std::upper_bound(table.begin(), table.end(), time,
                                      [](double t, const auto& row) { return t < row[0]; });
  const auto& before = *(after - 1);
  const double s = (time - before[0]) / ((*after)[0] - before[0]);
  return (1 - s) * value(before) + s * value(*after);
}

template Vector<2> WallMotion::displacement<2>(double) const;
template Vector<3> WallMotion::displacement<3>(double) const;

KeyTable wall_motion_keys() {
  return {
      "wall_motion",
      "Displacement of a wall; its facets stay where the grid has them.",
      {key::vector("velocity", "m/s", "The displacement is this times t.").or_none(),
       key::rows("table", "s, m",
                 "Rows [t, ux, uy(, uz)], t increasing, linear between rows and constant before "
                 "and after.")
           .wide(3, 4)
           .not_empty()
           .or_none()},
      {"velocity", "table"}};
}

WallMotion read_wall_motion(ConfigReader in, int dim) {
  WallMotion motion;
  if (in.has("velocity") == in.has("table")) {
    in.fail("velocity", "allowed: exactly one of \"velocity\" and \"table\"");
  }
  if (in.has("velocity")) {
    motion.velocity = in.vector("velocity", dim);
  } else {
    motion.table = in.rows("table", dim + 1);
    for (std::size_t k = 1; k < motion.table.size(); ++k) {
      if (motion.table[k][0] > motion.table[k - 1][0]) continue;
      in.fail(fmt::format("table/{}", k),
              fmt::format("found time {} after {}, allowed: increasing times", motion.table[k][0],
                          motion.table[k - 1][0]));
    }
  }
  in.finish();
  return motion;
}

}  // namespace gabion::mpm
