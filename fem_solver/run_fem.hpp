// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "common/program/mpi_session.hpp"
#include "common/program/program.hpp"

namespace gabion {

/// The program fem_solver: reads fem.json of the scene, then follows the coupler, or runs alone
/// when the scene has no coupler.json. @note Collective over session.comm().
void run_fem(const ProgramOptions& options, const MpiSession& session);

}  // namespace gabion
