// SPDX-License-Identifier: BSD-3-Clause
#include "element_test/element_table.hpp"

#include <Eigen/Eigenvalues>
#include <cmath>

#include "common/mechanics/tensor_functions.hpp"

namespace gabion::element {

namespace {

std::vector<std::string> columns(const MaterialLaw<3>& law) {
  std::vector<std::string> names = {"stage", "time"};
  for (const auto& name : component_names) names.push_back("strain_" + name);
  for (const char* name : {"volume_strain", "shear_strain"}) names.emplace_back(name);
  for (const auto& name : component_names) names.push_back("stress_" + name);
  for (const char* name : {"pore_pressure", "p", "q", "deviator", "plastic_strain", "gap"}) {
    names.emplace_back(name);
  }
  std::visit(
      [&]<class Law>(const Law&) {
        if constexpr (RemembersInternal<Law>) {
          for (const char* name : Law::internal_names) names.emplace_back(name);
        }
      },
      law);
  for (const char* name : {"region", "iterations", "cuts"}) names.emplace_back(name);
  return names;
}

// sqrt(2/3) of the norm of the deviator of ln V.
double shear_strain(const Matrix<3>& F) {
  const Eigen::SelfAdjointEigenSolver<Matrix<3>> b(Matrix<3>(F * F.transpose()),
                                                   Eigen::EigenvaluesOnly);
  const Eigen::Vector3d strain = b.eigenvalues().array().log() / 2;
  return std::sqrt(2.0 / 3) * (strain.array() - strain.mean()).matrix().norm();
}

double von_mises(const Vector6& sigma) {
  Vector6 deviator = sigma;
  deviator.head<3>().array() -= sigma.head<3>().mean();
  return std::sqrt(1.5 * contract<3>(deviator, deviator));
}

}  // namespace

ElementTable::ElementTable(const std::string& path, const MaterialLaw<3>& law)
    : has_internal_(remembers_internal(law)), csv_(path, columns(law)) {}

void ElementTable::row(const std::string& stage, const ElementState& state, const Effort& effort) {
  std::vector<CsvValue> cells = {stage, state.time};
  const auto add_signed = [&](const Vector6& components) {  // compression positive, no -0
    for (int k = 0; k < num_components; ++k) {
      cells.emplace_back((k < 3 ? -components[k] : components[k]) + 0.0);
    }
  };
  const Vector6 total = state.stress(), effective = state.effective_stress();
  add_signed(state.strain);
  cells.emplace_back(-std::expm1(state.log_J - state.zero_log_J) + 0.0);
  cells.emplace_back(shear_strain(state.F));
  add_signed(total);
  cells.emplace_back(state.pore_pressure);
  cells.emplace_back(-effective.head<3>().mean() + 0.0);
  cells.emplace_back(von_mises(effective));
  cells.emplace_back((total[0] + total[2]) / 2 - total[1] + 0.0);
  cells.emplace_back(state.history.plastic_strain);
  cells.emplace_back(state.history.gap);
  if (has_internal_) {
    for (const double value : state.internal) cells.emplace_back(value);
  }
  cells.emplace_back(std::string(region_name(state.region)));
  cells.emplace_back(std::int64_t{effort.iterations});
  cells.emplace_back(std::int64_t{effort.cuts});
  csv_.row(cells);
}

}  // namespace gabion::element
