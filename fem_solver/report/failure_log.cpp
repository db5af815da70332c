// SPDX-License-Identifier: BSD-3-Clause
#include "fem_solver/report/failure_log.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cstdint>
#include <string>
#include <vector>

#include "common/base/log.hpp"
#include "common/mechanics/ranks/gather.hpp"

namespace gabion::fem {

namespace {

/// Whether a cell of this rank has a facet of an interface that stays without it, or a line is a
/// beam of one.
template <int dim>
bool is_wet(const FemSettings<dim>& settings, const ChangingSurfaces<dim>& changing,
            std::int32_t element) {
  const Mesh<dim>& mesh = settings.mesh;
  const std::int32_t line = element - mesh.num_cells();
  if (line >= 0) {
    return std::ranges::any_of(settings.beam_surfaces, [&](const BeamSurfaceSettings& surface) {
      return std::ranges::any_of(surface.groups, [&](const std::string& group) {
        const auto found = mesh.line_groups.find(group);
        return found != mesh.line_groups.end() &&
               std::ranges::find(found->second, line) != found->second.end();
      });
    });
  }
  if (changing.has(element)) return false;
  const auto nodes = mesh.element(element);
  const auto is_own = [&](std::int32_t i) { return std::ranges::find(nodes, i) != nodes.end(); };
  const std::size_t n = num_nodes(facet_type(mesh.cell_type));
  for (const WetSurfaceSettings& surface : settings.interfaces) {
    for (const std::string& group : surface.groups) {
      const std::span<const std::int32_t> facets = mesh.facets(group, surface.where);
      for (std::size_t f = 0; f < facets.size(); f += n) {
        if (std::ranges::all_of(facets.subspan(f, n), is_own)) return true;
      }
    }
  }
  return false;
}

/// Texts of all ranks, one after the other, on the first one.
std::string gather_text(MPI_Comm comm, const std::string& own) {
  const std::vector<std::uint8_t> bytes(own.begin(), own.end());
  const auto all = gather<std::uint8_t>(comm, bytes);
  return {all.begin(), all.end()};
}

}  // namespace

template <int dim>
void log_failures(const FemSettings<dim>& settings, const ChangingSurfaces<dim>& changing,
                  std::span<const Failure> failures, double time, bool& warned) {
  const SharedNodes& shared = settings.ranks.shared();
  if (shared.total(static_cast<double>(failures.size())) == 0) return;
  std::string text, wet;
  for (const Failure& failure : failures) {
    const std::string sentence = describe(failure, settings.mesh, settings.ranks);
    text += fmt::format("t = {:.6g} s: {}\n", time, sentence);
    if (!warned && wet.empty() && is_wet(settings, changing, failure.element)) wet = sentence;
  }
  text = gather_text(settings.ranks.comm(), text);
  for (std::size_t first = 0; first < text.size();) {
    const std::size_t end = text.find('\n', first);
    log::info("{}", text.substr(first, end - first));
    first = end + 1;
  }
  if (warned) return;
  wet = shared.first_text(wet);
  if (wet.empty()) return;
  warned = true;
  log::warn(
      "{}; it has facets of an interface: they stay in the wet surface, and the soil still pushes "
      "them (\"behind\" of the interface removes them)",
      wet);
}

template void log_failures(const FemSettings<2>&, const ChangingSurfaces<2>&,
                           std::span<const Failure>, double, bool&);
template void log_failures(const FemSettings<3>&, const ChangingSurfaces<3>&,
                           std::span<const Failure>, double, bool&);

}  // namespace gabion::fem
