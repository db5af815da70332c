// SPDX-License-Identifier: BSD-3-Clause
// Checks that several readers of mpm.json share.
#pragma once

#include <fmt/format.h>

#include <string>

#include "common/mechanics/elements/shape_functions.hpp"
#include "common/settings/config_reader.hpp"

namespace gabion::mpm {

/// Refuse a count of points that no rule offers, at the key that asks for it.
template <int dim>
void check_point_rule(const ConfigReader& in, const std::string& key, CellType type, int count) {
  try {
    point_rule<dim>(type, count);
  } catch (const ConfigError& error) {
    in.fail(key, error.what());
  }
}

/// Refuse the last of the items when an earlier one has its name.
template <class Items>
void require_own_name(const ConfigReader& in, const Items& items) {
  for (std::size_t k = 0; k + 1 < items.size(); ++k) {
    if (items[k].name != items.back().name) continue;
    in.fail("name", fmt::format("found \"{}\" a second time, allowed: a name of its own",
                                items.back().name));
  }
}

}  // namespace gabion::mpm
