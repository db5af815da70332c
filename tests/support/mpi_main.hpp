// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <mpi.h>

namespace gabion::test {

/// All ranks of the running test program.
MPI_Comm comm();
int rank();
int size();

}  // namespace gabion::test
