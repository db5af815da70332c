// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "common/mechanics/materials/lanes.hpp"

namespace gabion {

/// a where the mask is set, otherwise b: `mask ? a : b` without testing the mask again.
inline Lanes select(const LaneMask& mask, const Lanes& a, const Lanes& b) {
#ifdef __AVX__
  return _mm256_blendv_pd(b, a, reinterpret_cast<__m256d>(mask));
#else
  return mask ? a : b;
#endif
}

}  // namespace gabion
