// SPDX-License-Identifier: BSD-3-Clause
#include "mpm_solver/points/rain.hpp"

#include <fmt/format.h>

namespace gabion::mpm {

KeyTable rain_keys() {
  return {
      "rain",
      "Rain on the free surface, along gravity. Soil takes in as much as keeps the water pressure "
      "at its surface at 0 or below; the rest runs off.",
      {key::number("rate", "m/s",
                   "Constant rate, volume per time and horizontal area; 1 mm/h is 2.8e-7.")
           .in({.low = 0, .high = most_rain, .allowed = "a number in [0, 0.01]"})
           .or_none(),
       time_table_key("m/s", fmt::format("Rows [t, rate], t increasing, the rate 0 to {:g}, linear "
                                         "between rows and constant before and after.",
                                         most_rain))},
      {"rate", "table"}};
}

TimeFunction read_rain(ConfigReader in) {
  if (in.has("rate") == in.has("table")) {
    in.fail("rate", "allowed: exactly one of \"rate\" and \"table\"");
  }
  TimeFunction rain =
      in.has("rate") ? TimeFunction::constant(in.number("rate")) : read_time_table(in);
  if (in.has("table")) {
    const auto rows = in.rows("table", 2);
    for (std::size_t k = 0; k < rows.size(); ++k) {
      if (rows[k][1] >= 0 && rows[k][1] <= most_rain) continue;
      in.fail(fmt::format("table/{}", k),
              fmt::format("found {:g} m/s, allowed: 0 to {:g} m/s; 1 mm/h is 2.8e-7 m/s",
                          rows[k][1], most_rain));
    }
  }
  in.finish();
  return rain;
}

}  // namespace gabion::mpm
