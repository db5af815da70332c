// SPDX-License-Identifier: BSD-3-Clause
#include "coupler/step/start.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <string>

#include "common/base/log.hpp"
#include "common/run/start.hpp"

namespace gabion {

namespace {

/// `"wall" by up to 0.094 m, "roof" by up to 1e-06 m`
std::string text_of(const InterfaceValues& start, const std::vector<InterfaceMesh>& meshes) {
  std::string text;
  for (const InterfaceMesh& mesh : meshes) {
    const std::vector<double>& u = start.at(mesh.name);
    double largest = 0;
    for (std::size_t v = 0; v < u.size(); v += mesh.dim) {
      double square = 0;
      for (int c = 0; c < mesh.dim; ++c) square += u[v + c] * u[v + c];
      largest = std::max(largest, std::sqrt(square));
    }
    if (largest == 0) continue;
    text += fmt::format("{}\"{}\" by up to {:.3g} m", text.empty() ? "" : ", ", mesh.name, largest);
  }
  return text;
}

}  // namespace

void put_start(const Solver& structure, const InterfaceLayout& layout, Eigen::VectorXd& x) {
  InterfaceValues values = layout.values_in(x);
  for (auto& [name, start] : start_displacements(structure)) values[name] = std::move(start);
  layout.put(values, x);
}

void tell_start(Solver& soil, const InterfaceLayout& layout, const Eigen::VectorXd& u) {
  if (layout.is_zero_in(u)) return;
  const InterfaceValues start = layout.values_in(u);
  const std::string text = text_of(start, soil.interfaces());
  if (takes_start(soil)) {
    log::info("interfaces of {} start displaced: {}", layout.participant(), text);
    return set_start(soil, start);
  }
  log::warn(
      "participant \"{}\" does not take displacements of the start: for it, interfaces that start "
      "displaced ({}) move by all of that in the first step",
      layout.participant(), text);
}

}  // namespace gabion
