// SPDX-License-Identifier: BSD-3-Clause
#include "mpm_solver/gauges/gauge_config.hpp"

#include <algorithm>

#include "mpm_solver/config_checks.hpp"

namespace gabion::mpm {

namespace {

template <int dim>
Gauge<dim> read_gauge(ConfigReader& in) {
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
  try {
    return Gauge<dim>(name, corners);
  } catch (const ConfigError& error) {
    in.fail("corners", error.what());
  }
}

}  // namespace

KeyTable gauge_keys() {
  return {"gauge",
          "A piece of a plane, at rest, through which soil is watched.",
          {key::plain_name("Its own; columns of the tables start with it."),
           key::rows("corners", "m",
                     "2D: foot and top of a segment; 3D: both ends of the foot of a parallelogram, "
                     "then the top above the first of them. Flow counts positive to the right of "
                     "the way up, in 3D along foot x way up.")
               .wide(2, 3)
               .not_empty(2)}};
}

template <int dim>
std::vector<Gauge<dim>> read_gauges(ConfigReader& in) {
  std::vector<Gauge<dim>> gauges;
  for (auto& item : in.objects("gauges")) {
    gauges.push_back(read_gauge<dim>(item));
    item.finish();
    require_own_name(item, gauges);
  }
  return gauges;
}

template std::vector<Gauge<2>> read_gauges<2>(ConfigReader&);
template std::vector<Gauge<3>> read_gauges<3>(ConfigReader&);

}  // namespace gabion::mpm
