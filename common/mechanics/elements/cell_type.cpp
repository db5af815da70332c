// SPDX-License-Identifier: BSD-3-Clause
#include "common/mechanics/elements/cell_type.hpp"

namespace gabion {

std::string name(CellType type) {
  switch (type) {
    case CellType::point1:
      return "point1";
    case CellType::line2:
      return "line2";
    case CellType::tri3:
      return "tri3";
    case CellType::quad4:
      return "quad4";
    case CellType::tet4:
      return "tet4";
    case CellType::hex8:
      return "hex8";
  }
  return "unknown";
}

}  // namespace gabion
