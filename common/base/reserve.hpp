// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <vector>

namespace gabion {

/// Make room for `size` values; where there is too little, the room becomes an eighth more than
/// that. A vector that grows by itself doubles, so that half of a large one may stay empty.
template <class Value>
void reserve_tightly(std::vector<Value>& values, std::size_t size) {
  if (size > values.capacity()) values.reserve(size + size / 8);
}

}  // namespace gabion
