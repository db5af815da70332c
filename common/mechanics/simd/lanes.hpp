// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cmath>
#include <cstring>
#ifdef __AVX__
#include <immintrin.h>
#endif

// Vectors are passed in memory where there are no registers of this size: no call crosses to code
// that was compiled otherwise.
#pragma GCC diagnostic ignored "-Wpsabi"

namespace gabion {

/// Four doubles, one of each of four points, which the compiler spreads over what registers there
/// are. Operators act on each; a comparison gives a mask, which `select` takes.
using Lanes = double __attribute__((vector_size(32)));
using LaneMask = decltype(Lanes{} < Lanes{});
inline constexpr int num_lanes = 4;

inline Lanes lanes(double x) {
  return Lanes{x, x, x, x};
}

inline Lanes load_lanes(const double* x) {
  Lanes r;
  std::memcpy(&r, x, sizeof r);
  return r;
}
inline void store_lanes(const Lanes& x, double* to) {
  std::memcpy(to, &x, sizeof x);
}

inline bool any(const LaneMask& mask) {
#ifdef __AVX__
  return !_mm256_testz_si256(reinterpret_cast<__m256i>(mask), reinterpret_cast<__m256i>(mask));
#else
  return (mask[0] | mask[1] | mask[2] | mask[3]) != 0;
#endif
}

/// a where the mask is set, otherwise b: `mask ? a : b` without testing the mask again.
inline Lanes select(const LaneMask& mask, const Lanes& a, const Lanes& b) {
#ifdef __AVX__
  return _mm256_blendv_pd(b, a, reinterpret_cast<__m256d>(mask));
#else
  return mask ? a : b;
#endif
}

inline Lanes sqrt(const Lanes& x) {
#ifdef __AVX__
  return _mm256_sqrt_pd(x);
#else
  return Lanes{std::sqrt(x[0]), std::sqrt(x[1]), std::sqrt(x[2]), std::sqrt(x[3])};
#endif
}

inline Lanes abs(const Lanes& x) {
  return x < 0 ? -x : x;
}

/// A function of doubles, lane by lane.
template <class Function>
Lanes each(const Function& function, const Lanes& x) {
  return Lanes{function(x[0]), function(x[1]), function(x[2]), function(x[3])};
}

/// x(k)[l] <-> x(l)[k]
inline void transpose(Lanes (&x)[num_lanes]) {
  using Order = LaneMask;
  const Lanes a = __builtin_shuffle(x[0], x[1], Order{0, 4, 2, 6});
  const Lanes b = __builtin_shuffle(x[0], x[1], Order{1, 5, 3, 7});
  const Lanes c = __builtin_shuffle(x[2], x[3], Order{0, 4, 2, 6});
  const Lanes d = __builtin_shuffle(x[2], x[3], Order{1, 5, 3, 7});
  x[0] = __builtin_shuffle(a, c, Order{0, 1, 4, 5});
  x[1] = __builtin_shuffle(b, d, Order{0, 1, 4, 5});
  x[2] = __builtin_shuffle(a, c, Order{2, 3, 6, 7});
  x[3] = __builtin_shuffle(b, d, Order{2, 3, 6, 7});
}

/// Four numbers in a row from each of four places: component k of point l is result(k)[l].
struct LaneBlock {
  Lanes x[num_lanes];

  Lanes& operator[](int k) { return x[k]; }
  const Lanes& operator[](int k) const { return x[k]; }
  void load(const double* first, const double* second, const double* third, const double* fourth) {
    x[0] = load_lanes(first);
    x[1] = load_lanes(second);
    x[2] = load_lanes(third);
    x[3] = load_lanes(fourth);
    transpose(x);
  }
  void store(double* first, double* second, double* third, double* fourth) const {
    Lanes rows[num_lanes] = {x[0], x[1], x[2], x[3]};
    transpose(rows);
    store_lanes(rows[0], first);
    store_lanes(rows[1], second);
    store_lanes(rows[2], third);
    store_lanes(rows[3], fourth);
  }
};

}  // namespace gabion
