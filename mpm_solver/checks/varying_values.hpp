// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>

#include "mpm_solver/mpm_config.hpp"

namespace gabion::mpm {

/// Write the material points at the start of the bodies with constants that vary in space as a
/// table: number of the body, coordinates, and a column for each constant, empty where it does not
/// vary in the body.
/// @throws ConfigError  no body has any
template <int dim>
void write_varying(const std::string& path, const MpmSettings<dim>& settings);

/// One line a body and constant: least, mean and largest value over the points at the start.
template <int dim>
void log_varying(const MpmSettings<dim>& settings, const MaterialPoints<dim>& points,
                 MPI_Comm comm);

}  // namespace gabion::mpm
