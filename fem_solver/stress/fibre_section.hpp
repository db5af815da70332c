// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <span>

#include "fem_solver/beams/beam_forces.hpp"
#include "fem_solver/materials/line_material.hpp"
#include "fem_solver/stress/stress_integral.hpp"

namespace gabion::fem {

/// Section of a beam that yields: fibres along it with the law of bars, shear and torsion elastic.
/// The object refers to its arguments.
class FibreSection {
 public:
  static constexpr std::size_t fibre_width = 2;  ///< numbers that a fibre remembers

  /// @param history  of the fibres, one after the other
  FibreSection(const LineMaterial& material, const BeamStiffness& stiffness, HistoryStep history)
      : material_(material), stiffness_(stiffness), history_(history) {}

  /// The section's answer; it writes the trial history.
  template <class S>
  SectionAnswer<S> operator()(const Triple<S>& gamma, const Triple<S>& kappa) const {
    const Sums sums = sum({value_of(gamma[0]), value_of(kappa[1]), value_of(kappa[2])});
    const Triple<S> strain = {gamma[0], kappa[1], kappa[2]};
    const auto of = [&](int i) { return linear(sums.force[i], sums.tangent[i], strain); };
    const S V_2 = S(stiffness_.force[1]) * gamma[1], V_3 = S(stiffness_.force[2]) * gamma[2];
    const S T = S(stiffness_.moment[0]) * kappa[0];
    const S elastic = V_2 * gamma[1] + V_3 * gamma[2] + T * kappa[0];
    return {{{of(0), V_2, V_3}, {T, of(1), of(2)}}, S(sums.energy) + S(0.5) * elastic};
  }

 private:
  /// N, M_2, M_3, their derivatives by the strain of the axis and the curvatures, and the elastic
  /// energy per length.
  struct Sums {
    Triple<double> force{};
    std::array<Triple<double>, 3> tangent{};
    double energy = 0;
  };
  Sums sum(const Triple<double>& strain) const;

  static double linear(double value, const Triple<double>&, const Triple<double>&) { return value; }
  template <int n>
  static Dual<n> linear(double value, const Triple<double>& tangent,
                        const Triple<Dual<n>>& strain) {
    Dual<n> result(value);
    for (int k = 0; k < 3; ++k) {
      for (int i = 0; i < n; ++i) result.slope[i] += tangent[k] * strain[k].slope[i];
    }
    return result;
  }

  const LineMaterial& material_;
  const BeamStiffness& stiffness_;
  HistoryStep history_;
};

}  // namespace gabion::fem
