// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "common/settings/config_reader.hpp"

namespace gabion::test {

/// A coupler.json that holds what it must, and the criteria of both fields.
inline Json good_coupler() {
  return Json::parse(R"({
    "time": {"end": 0.5, "dt": 2e-4, "dt_min": 1e-6},
    "output": {"interval": 0.01},
    "participants": {"soil": {"sends": "force"}, "structure": {"sends": "displacement"}},
    "interfaces": [{"name": "wall", "soil": "soil", "structure": "structure"}],
    "coupling": {
      "convergence": {
        "displacement": {"absolute": 1e-6, "relative": 1e-5, "floor": 1e-9},
        "force": {"absolute": 1e-2, "relative": 1e-5, "floor": 1e-7}
      },
      "mapping": {"tolerance": 1e-6}
    }
  })");
}

}  // namespace gabion::test
