// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <span>

#include "common/mechanics/materials/material.hpp"

namespace gabion::mpm {

/// Law of each point whose constants vary in space. Null: the point has the law of its body; empty:
/// all points have.
template <int dim>
using LawsOfPoints = std::span<const MaterialLaw<dim>* const>;

/// @param own  law of the body of the point
template <int dim>
const MaterialLaw<dim>& law_of(LawsOfPoints<dim> laws, std::int32_t p,
                               const MaterialLaw<dim>& own) {
  return laws.empty() || laws[p] == nullptr ? own : *laws[p];
}

}  // namespace gabion::mpm
