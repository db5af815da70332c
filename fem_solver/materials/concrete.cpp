// SPDX-License-Identifier: BSD-3-Clause
#include "fem_solver/materials/concrete.hpp"

#include <algorithm>
#include <cmath>

#include "fem_solver/materials/log_law.hpp"

namespace gabion::fem {

namespace {

/// Elastic stress on its axes, split by sign.
template <int dim>
struct ElasticStress {
  Eigenpairs<dim> pairs;
  Symmetric<dim> tensile, compressive;  // s+, s-
  int first = 0, last = 0;              // axes of the largest and the least stress

  explicit ElasticStress(const Symmetric<dim>& s) : pairs(eigenpairs<dim>(s)) {
    std::array<double, 3> positive, negative;
    for (int i = 0; i < 3; ++i) {
      positive[i] = std::max(pairs.value[i], 0.0);
      negative[i] = std::min(pairs.value[i], 0.0);
      if (pairs.value[i] > pairs.value[first]) first = i;
      if (pairs.value[i] < pairs.value[last]) last = i;
    }
    tensile = compose<dim>(positive, pairs.n);
    compressive = compose<dim>(negative, pairs.n);  // s - s+ would leave its round-off
  }
  double largest() const { return pairs.value[first]; }
  double least() const { return pairs.value[last]; }

  /// n_i (x) n_i; of the axis out of the plane, zero.
  Matrix<dim> along(int i) const {
    return i < dim ? dyad(pairs.n, i, i) : Matrix<dim>(Matrix<dim>::Zero());
  }
  /// Direction of an axis, of either sign; out of the plane, zero.
  Vector<dim> axis(int i) const {
    const Matrix<dim> m = along(i);
    int column = 0;
    for (int k = 1; k < dim; ++k) {
      if (m(k, k) > m(column, column)) column = k;
    }
    return m.col(column) / std::sqrt(std::max(m(column, column), 1e-300));
  }
};

/// Derivative of s+ by s of the components on the dim axes, symmetric.
template <int dim>
StrainMatrix<dim> tensile_projector(const ElasticStress<dim>& s) {
  StrainMatrix<dim> P = StrainMatrix<dim>::Zero();
  for (int i = 0; i < dim; ++i) {
    const double s_i = s.pairs.value[i];
    if (s_i > 0) {
      const StrainVector<dim> m = strain_vector<dim>(s.along(i));
      P += m * m.transpose();
    }
    for (int j = i + 1; j < dim; ++j) {
      const double s_j = s.pairs.value[j], positive = s_i > 0 ? 1 : 0;
      const double share =
          s_i == s_j ? positive : (std::max(s_i, 0.0) - std::max(s_j, 0.0)) / (s_i - s_j);
      const Matrix<dim> pair = dyad(s.pairs.n, i, j);
      const StrainVector<dim> m =
          strain_vector<dim>(Matrix<dim>(pair + pair.transpose())) * std::sqrt(0.5);
      P += share * m * m.transpose();
    }
  }
  return P;
}

/// Equivalent stress of one sign, and its derivative by the elastic stress.
template <int dim>
struct Equivalent {
  double value = 0;
  Symmetric<dim> slope = Symmetric<dim>::Zero();
};

/// Both equivalent stresses: in uniaxial tension or compression they are the stress itself.
template <int dim>
struct Equivalents {
  Equivalent<dim> tensile, compressive;

  Equivalents(const Concrete<dim>& law, const Symmetric<dim>& stress, const ElasticStress<dim>& s) {
    const double alpha = (law.biaxial_ratio - 1) / (2 * law.biaxial_ratio - 1);
    const double f_t = law.tension.strength, f_c = law.crushing.strength;
    const double beta = f_c / f_t * (1 - alpha) - (1 + alpha);
    const double I_1 = trace<dim>(stress);
    Symmetric<dim> deviator = stress;
    deviator.template head<3>().array() -= I_1 / 3;
    const double root = std::sqrt(1.5 * contract<dim>(deviator, deviator));  // sqrt(3 J_2)
    const double Q = alpha * I_1 + root;
    Symmetric<dim> slope = Symmetric<dim>::Zero();
    slope.template head<3>().setConstant(alpha);
    if (root > 0) slope += 1.5 / root * deviator;
    if (s.least() < 0) {
      compressive.value = Q / (1 - alpha);
      compressive.slope = slope / (1 - alpha);
    }
    if (!(s.largest() > 0)) return;
    const double scale = f_t / (f_c * (1 - alpha));
    tensile.value = scale * (Q + beta * s.largest());
    std::array<double, 3> first{};
    first[s.first] = 1;
    tensile.slope = scale * (slope + beta * compose<dim>(first, s.pairs.n));
  }
};

/// One of the two damages at the end of a step.
struct Part {
  Damage damage;
  bool grows = false;
};

/// Data of a part in a step.
struct Growth {
  double limit = 0;       // of elasticity [Pa]
  double equivalent = 0;  // stress [Pa]
  double energy = 0;      // density of the part, without damage [J/m^3]
  double new_band = 0;    // that it gets where it has none [m]
};

/// Memory of the point for a part.
struct Memory {
  double& r;
  double& band;
  double& dissipated;
};

/// Raise r to the equivalent stress where that is larger, with the band that it has or now gets,
/// and add the energy that the damage takes, on a path in proportion to r.
template <class Curve>
Part grow(const Curve& curve, const Growth& growth, Memory memory) {
  Part part;
  const double r_n = std::max(memory.r, growth.limit);
  part.grows = growth.equivalent > r_n;
  if (!part.grows && memory.r == 0) return part;
  if (memory.band == 0) memory.band = growth.new_band;
  memory.r = std::max(r_n, growth.equivalent);
  part.damage = damage_at(curve.at(memory.r, memory.band), memory.r, curve.modulus);
  if (!part.grows) return part;
  const double before = damage_at(curve.at(r_n, memory.band), r_n, curve.modulus).dissipated;
  const double of_bar = 0.5 * memory.r * memory.r / curve.modulus;
  memory.dissipated += growth.energy / of_bar * (part.damage.dissipated - before);
  return part;
}

/// Both damages of a point at the end of a step.
struct Damages {
  Part plus, minus;
};

template <int dim>
Damages find_damages(const ConcreteOfCell<dim>& cell, const ElasticStress<dim>& s,
                     const Equivalents<dim>& equivalents, const Symmetric<dim>& E,
                     std::span<double> history) {
  const auto& [law, band] = cell;
  const Growth crack{.limit = law.tension.strength,
                     .equivalent = equivalents.tensile.value,
                     .energy = 0.5 * contract<dim>(s.tensile, E),
                     .new_band = std::min(band.width(s.axis(s.first)), law.crack_spacing)};
  const Growth crush{.limit = law.crushing.elastic_limit,
                     .equivalent = equivalents.compressive.value,
                     .energy = 0.5 * contract<dim>(s.compressive, E),
                     .new_band = band.width(s.axis(s.last))};
  const Part plus = grow(law.tension, crack, {history[0], history[2], history[5]});
  const Part minus = grow(law.crushing, crush, {history[1], history[3], history[5]});
  return {plus, minus};
}

/// dT/dE
template <int dim>
StrainMatrix<dim> tangent(const Concrete<dim>& law, const ElasticStress<dim>& s,
                          const Equivalents<dim>& equivalents, const Damages& damages) {
  const double d_plus = damages.plus.damage.value, d_minus = damages.minus.damage.value;
  const StrainMatrix<dim> unit = StrainMatrix<dim>::Identity();
  const auto elastic = [&law](const Symmetric<dim>& g) {  // C : g on the dim axes
    StrainVector<dim> v = 2 * law.mu * strain_vector<dim>(in_plane<dim>(g));
    v.template head<dim>().array() += law.lambda * trace<dim>(g);
    return v;
  };
  StrainMatrix<dim> C = 2 * law.mu * unit;
  C.template topLeftCorner<dim, dim>().array() += law.lambda;
  StrainMatrix<dim> D;
  if (d_plus == d_minus) {
    D = (1 - d_plus) * C;
  } else {
    D = ((d_minus - d_plus) * tensile_projector<dim>(s) + (1 - d_minus) * unit) * C;
  }
  if (damages.plus.grows) {
    D -= damages.plus.damage.slope * strain_vector<dim>(in_plane<dim>(s.tensile)) *
         elastic(equivalents.tensile.slope).transpose();
  }
  if (damages.minus.grows) {
    D -= damages.minus.damage.slope * strain_vector<dim>(in_plane<dim>(s.compressive)) *
         elastic(equivalents.compressive.slope).transpose();
  }
  return D;
}

/// Strain across the crack times its band, less the elastic strain of the stress there.
template <int dim>
double crack_opening(const ElasticStress<dim>& s, double d_plus, double d_minus, double modulus,
                     double poisson) {
  double strain = 0;
  for (int i = 0; i < 3; ++i) {
    const double s_i = s.pairs.value[i];
    const double lost = (s_i > 0 ? d_plus : d_minus) * s_i;
    strain += (i == s.first ? 1 : -poisson) * lost / modulus;
  }
  return std::max(strain, 0.0);
}

}  // namespace

template <int dim>
void ConcreteOfCell<dim>::log_stress(const Symmetric<dim>& E, std::span<const double> history_n,
                                     std::span<double> history, LogStress<dim>& out) const {
  std::ranges::copy(history_n, history.begin());
  const double lambda = law.lambda, mu = law.mu;
  Symmetric<dim> stress = 2 * mu * E;
  stress.template head<3>().array() += lambda * trace<dim>(E);
  const ElasticStress<dim> s(stress);
  const Equivalents<dim> equivalents(law, stress, s);
  const Damages damages = find_damages(*this, s, equivalents, E, history);
  const double d_plus = damages.plus.damage.value, d_minus = damages.minus.damage.value;
  out.T = (1 - d_plus) * s.tensile + (1 - d_minus) * s.compressive;
  out.energy = 0.5 * contract<dim>(out.T, E);
  out.D = tangent(law, s, equivalents, damages);
  const double poisson = lambda / (2 * (lambda + mu));
  history[4] = d_plus > 0 && s.largest() > 0
                   ? history[2] * crack_opening(s, d_plus, d_minus, law.tension.modulus, poisson)
                   : 0;
}

template <int dim>
bool ConcreteOfCell<dim>::update(const Matrix<dim>& H, std::span<const double> history_n,
                                 std::span<double> history, StressUpdate<dim>& out,
                                 Tangent<dim>* A) const {
  return update_by_log_stress<dim>(
      H,
      [&](const Symmetric<dim>& E, LogStress<dim>& stress) {
        log_stress(E, history_n, history, stress);
      },
      out, A);
}

template <int dim>
double Concrete<dim>::tensile_damage(std::span<const double> history) const {
  if (history[0] == 0) return 0;
  return damage_at(tension.at(history[0], history[2]), history[0], tension.modulus).value;
}

template <int dim>
double Concrete<dim>::compressive_damage(std::span<const double> history) const {
  if (history[1] == 0) return 0;
  return damage_at(crushing.at(history[1], history[3]), history[1], crushing.modulus).value;
}

template struct Concrete<2>;
template struct Concrete<3>;
template struct ConcreteOfCell<2>;
template struct ConcreteOfCell<3>;

}  // namespace gabion::fem
