// SPDX-License-Identifier: BSD-3-Clause
#pragma once

namespace gabion {

/// A state counts as elastic up to f = yield_tolerance times the size of the terms in f: some
/// hundred roundings, so that a returned state which is not strained again stays as it is.
inline constexpr double yield_tolerance = 1e-13;

}  // namespace gabion
