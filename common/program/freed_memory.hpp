// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <malloc.h>

namespace gabion {

/// Keep freed memory in the process; programs call this at their start. Otherwise the vectors of
/// each large message come from the system and go back to it, a page fault every 4 KiB.
inline void keep_freed_memory() {
  mallopt(M_MMAP_THRESHOLD, 32 << 20);  // [bytes], the most that is allowed
  mallopt(M_TRIM_THRESHOLD, 256 << 20);
}

}  // namespace gabion
