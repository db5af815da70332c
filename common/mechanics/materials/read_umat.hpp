// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>
#include <vector>

#include "common/mechanics/materials/material.hpp"

namespace gabion {

/// Keys of a material with the law umat, besides density.
std::vector<Key> umat_keys();

/// Read a material as read_material() does, or one with the law umat.
/// @param folder  of the file, from which the path of a library counts
template <int dim>
Material<dim> read_material_in(const std::string& folder, ConfigReader in);

}  // namespace gabion
