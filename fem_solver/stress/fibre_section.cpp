// SPDX-License-Identifier: BSD-3-Clause
#include "fem_solver/stress/fibre_section.hpp"

namespace gabion::fem {

FibreSection::Sums FibreSection::sum(const Triple<double>& strain) const {
  Sums sums;
  const std::vector<Fibre>& fibres = material_.beam->section.fibres;
  for (std::size_t k = 0; k < fibres.size(); ++k) {
    const auto& [y, z, area] = fibres[k];
    const Triple<double> share = {1, z, -y};
    const HistoryStep own = history_.part(k * fibre_width, fibre_width);
    const BarStress point = bar_stress(material_, dot(share, strain), own.accepted, own.trial);
    sums.energy += 0.5 * area * point.stress * point.elastic_strain;
    for (int i = 0; i < 3; ++i) {
      sums.force[i] += area * point.stress * share[i];
      for (int j = 0; j < 3; ++j) sums.tangent[i][j] += area * point.slope * share[i] * share[j];
    }
  }
  return sums;
}

}  // namespace gabion::fem
