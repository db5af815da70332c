// SPDX-License-Identifier: BSD-3-Clause
#include "mpm_solver/points/pool.hpp"

#include <fmt/format.h>

#include <cmath>

namespace gabion::mpm {

KeyTable pool_keys() {
  return {
      "pool",
      "Free water at rest beside and over soil whose pore water drains: it presses on all that is "
      "below its level, and feeds the free surface of the soil there. Between pools the level is "
      "interpolated along x; a dry side is a pool whose level is below the soil. A wall between "
      "pools of unequal levels has to be upright or slope outward: water below a face that leans "
      "over it has the level of its own x.",
      {key::number("level", "m", "Height of its surface, constant.").or_none(),
       time_table_key("m",
                      "Rows [t, level], t increasing, linear between rows and constant before and "
                      "after."),
       key::number("from", "m",
                   "x where the pool begins; the first pool may leave it out and has no end there.")
           .or_none(),
       key::number("to", "m",
                   "x where the pool ends; the last pool may leave it out and has no end there.")
           .or_none()},
      {"level", "table"}};
}

namespace {

Pool read_pool(ConfigReader in) {
  Pool pool;
  if (in.has("level") == in.has("table")) {
    in.fail("level", "allowed: exactly one of \"level\" and \"table\"");
  }
  pool.level = in.has("level") ? TimeFunction::constant(in.number("level")) : read_time_table(in);
  pool.from = in.optional_number("from").value_or(pool.from);
  pool.to = in.optional_number("to").value_or(pool.to);
  if (!(pool.from < pool.to)) {
    in.fail("to", fmt::format("found {:g}, allowed: more than \"from\", {:g}", pool.to, pool.from));
  }
  in.finish();
  return pool;
}

}  // namespace

std::vector<Pool> read_pools(ConfigReader& in) {
  std::vector<Pool> pools;
  for (auto& item : in.objects("pools")) pools.push_back(read_pool(std::move(item)));
  for (std::size_t k = 0; k < pools.size(); ++k) {
    const bool first = k == 0, last = k + 1 == pools.size();
    if (std::isfinite(pools[k].from) == first) {
      in.fail(fmt::format("pools/{}/from", k),
              first ? fmt::format("found {:g}, allowed of the first pool: none; a dry side is a "
                                  "pool whose level is below the soil",
                                  pools[k].from)
                    : "found none, allowed of all but the first pool: the x where it begins");
    }
    if (std::isfinite(pools[k].to) == last) {
      in.fail(fmt::format("pools/{}/to", k),
              last ? fmt::format("found {:g}, allowed of the last pool: none; a dry side is a pool "
                                 "whose level is below the soil",
                                 pools[k].to)
                   : "found none, allowed of all but the last pool: the x where it ends");
    }
    if (first || pools[k].from > pools[k - 1].to) continue;
    in.fail(fmt::format("pools/{}/from", k),
            fmt::format("found {:g}, allowed: more than {:g}, where the pool before ends; between "
                        "them the level is interpolated",
                        pools[k].from, pools[k - 1].to));
  }
  return pools;
}

PoolLevels::PoolLevels(std::span<const Pool> pools, double time, double specific_weight)
    : weight_(specific_weight) {
  for (const Pool& pool : pools) ranges_.push_back({pool.from, pool.to, pool.level.at(time)});
  for (std::size_t k = 1; k < ranges_.size(); ++k) {
    bends_.push_back(ranges_[k - 1].to);
    bends_.push_back(ranges_[k].from);
  }
}

std::size_t PoolLevels::range_of(double x) const {
  std::size_t k = 0;
  while (k + 1 < ranges_.size() && x >= ranges_[k + 1].from) ++k;
  return k;
}

double PoolLevels::level(double x) const {
  const std::size_t k = range_of(x);
  if (x <= ranges_[k].to) return ranges_[k].level;
  const double s = (x - ranges_[k].to) / (ranges_[k + 1].from - ranges_[k].to);
  return (1 - s) * ranges_[k].level + s * ranges_[k + 1].level;
}

double PoolLevels::slope(double x) const {
  const std::size_t k = range_of(x);
  if (x <= ranges_[k].to) return 0;
  return (ranges_[k + 1].level - ranges_[k].level) / (ranges_[k + 1].from - ranges_[k].to);
}

}  // namespace gabion::mpm
