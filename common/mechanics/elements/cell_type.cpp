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
    case CellType::line3:
      return "line3";
    case CellType::tri6:
      return "tri6";
    case CellType::quad8:
      return "quad8";
    case CellType::quad9:
      return "quad9";
    case CellType::tet10:
      return "tet10";
    case CellType::hex20:
      return "hex20";
    case CellType::hex27:
      return "hex27";
  }
  return "unknown";
}

}  // namespace gabion
