// SPDX-License-Identifier: BSD-3-Clause
#include "protocol/participant/own_facets.hpp"

#include <fmt/ranges.h>

#include <utility>

#include "common/base/require.hpp"
#include "protocol/participant/usage_error.hpp"

namespace gabion {

void OwnFacets::let_change(const InterfaceMesh& surface) {
  require<UsageError>(surface.vertices_per_facet > 0,
                      "set_facets_may_change: found interface \"{}\" without facets, allowed: one "
                      "that has some at the beginning",
                      surface.name);
  facets_[surface.name] = surface.facets;
  sent_ = SentFacets(facets_);
}

std::vector<std::string> OwnFacets::names() const {
  std::vector<std::string> names;
  for (const auto& [name, facets] : facets_) names.push_back(name);
  return names;
}

void OwnFacets::write(const InterfaceMesh& surface, std::span<const std::int64_t> facets,
                      bool accepted) {
  require<UsageError>(facets_.contains(surface.name),
                      "write_facets: found interface \"{}\", allowed: those of "
                      "set_facets_may_change, {}",
                      surface.name, names());
  require<UsageError>(accepted || loaded_,
                      "write_facets: allowed after an accepted step, before is_coupling_ongoing, "
                      "and while a state is loaded");
  require<UsageError>(facets.size() % surface.vertices_per_facet == 0,
                      "write_facets: found {} vertices for \"{}\", allowed: num_facets x {}",
                      facets.size(), surface.name, surface.vertices_per_facet);
  for (const std::int64_t vertex : facets) {
    require<UsageError>(vertex >= 0 && vertex < surface.num_vertices(),
                        "write_facets: found vertex {} of \"{}\", allowed: 0 to {}", vertex,
                        surface.name, surface.num_vertices() - 1);
  }
  (loaded_ ? *loaded_ : facets_)[surface.name].assign(facets.begin(), facets.end());
}

void OwnFacets::while_loading(const std::function<void()>& load) {
  loaded_.emplace();
  load();
  for (const auto& [name, facets] : facets_) {
    require<UsageError>(loaded_->contains(name),
                        "load: no facets were written for \"{}\", allowed: a call of write_facets "
                        "in it, since they may change",
                        name);
  }
  facets_ = *std::exchange(loaded_, std::nullopt);
  sent_.forget();
}

}  // namespace gabion
