// SPDX-License-Identifier: BSD-3-Clause
#include "fem_solver/materials/concrete.hpp"

#include <algorithm>
#include <cmath>
#include <functional>

#include "fem_solver/materials/log_law.hpp"

namespace gabion::fem {

namespace {

/// Elastic stress s on its axes, split into two parts that do no work on each other's strain: s- is
/// the stress without tension that is nearest to s in the norm of C^-1, so that the strain C^-1 s+
/// of the rest opens all of its axes. With e_i the opening strains and p = lambda sum e_i,
///
///     s_i = p + 2 mu e_i + s-_i ,   e_i = max(s_i - p, 0) / (2 mu) ,   s-_i = min(s_i - p, 0)
template <int dim>
struct ElasticStress {
  Eigenpairs<dim> pairs;
  double shift = 0;                     // p [Pa]
  int opened = 0;                       // number of axes that open
  Symmetric<dim> tensile, compressive;  // s+, s-
  std::array<double, 3> negative;       // values of s-
  int first = 0, last = 0;              // axes of the largest and the least stress

  ElasticStress(const Symmetric<dim>& s, double lambda, double mu) : pairs(eigenpairs<dim>(s)) {
    std::array<double, 3> falling = pairs.value;
    std::ranges::sort(falling, std::greater<>());
    for (double sum = 0; opened < 3 && falling[opened] > shift;) {
      sum += falling[opened++];
      shift = lambda * sum / (2 * mu + opened * lambda);
    }
    std::array<double, 3> positive;
    for (int i = 0; i < 3; ++i) {
      positive[i] = shift + std::max(pairs.value[i] - shift, 0.0);
      negative[i] = std::min(pairs.value[i] - shift, 0.0);
      if (pairs.value[i] > pairs.value[first]) first = i;
      if (pairs.value[i] < pairs.value[last]) last = i;
    }
    tensile = compose<dim>(positive, pairs.n);
    compressive = compose<dim>(negative, pairs.n);  // s - s+ would leave its round-off
  }
  bool opens(int i) const { return pairs.value[i] > shift; }
  double largest() const { return pairs.value[first]; }
  /// 2 mu times the largest of the opening strains.
  double opening() const { return std::max(largest() - shift, 0.0); }

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

/// Derivatives of the split by the strain, of the components on the dim axes.
template <int dim>
struct SplitSlopes {
  StrainVector<dim> unit = StrainVector<dim>::Zero();     // 1
  StrainVector<dim> sum = StrainVector<dim>::Zero();      // of sum e_i
  StrainMatrix<dim> tensile = StrainMatrix<dim>::Zero();  // of s+, symmetric

  SplitSlopes(const ElasticStress<dim>& s, double lambda, double mu) {
    unit.template head<dim>().setOnes();
    StrainVector<dim> N = StrainVector<dim>::Zero();  // sum of n_i (x) n_i of the axes that open
    for (int i = 0; i < dim; ++i) {
      if (s.opens(i)) {
        const StrainVector<dim> m = strain_vector<dim>(s.along(i));
        tensile += m * m.transpose();
        N += m;
      }
      for (int j = i + 1; j < dim; ++j) add_pair(s, i, j);
    }
    const double axes = s.opened * lambda, modulus = 2 * mu + axes;
    sum = (2 * mu * N + axes * unit) / modulus;
    tensile *= 2 * mu;
    tensile += lambda * (unit * sum.transpose());
    tensile += 2 * mu * lambda / modulus * N * (unit - N).transpose();
  }

  /// Turn of two axes against each other.
  void add_pair(const ElasticStress<dim>& s, int i, int j) {
    const double s_i = s.pairs.value[i], s_j = s.pairs.value[j];
    const double open_i = std::max(s_i - s.shift, 0.0), open_j = std::max(s_j - s.shift, 0.0);
    const double share = s_i == s_j ? (s.opens(i) ? 1 : 0) : (open_i - open_j) / (s_i - s_j);
    const Matrix<dim> pair = dyad(s.pairs.n, i, j);
    const StrainVector<dim> m =
        strain_vector<dim>(Matrix<dim>(pair + pair.transpose())) * std::sqrt(0.5);
    tensile += share * m * m.transpose();
  }
};

/// Equivalent stress of one sign, and its derivative by the values of a stress on its axes.
struct Equivalent {
  double value = 0;
  std::array<double, 3> slope{};
};

/// Q = alpha I_1 + sqrt(3 J_2) of a stress by its values.
Equivalent drucker_prager(const std::array<double, 3>& s, double alpha) {
  const double I_1 = s[0] + s[1] + s[2];
  double square = 0;  // 2 J_2
  for (const double s_i : s) square += (s_i - I_1 / 3) * (s_i - I_1 / 3);
  const double root = std::sqrt(1.5 * square);
  Equivalent Q{.value = alpha * I_1 + root};
  for (int i = 0; i < 3; ++i) {
    Q.slope[i] = alpha + (root > 0 ? 1.5 * (s[i] - I_1 / 3) / root : 0);
  }
  return Q;
}

/// Both equivalent stresses: in uniaxial tension or compression they are the stress itself. The
/// slope of the tensile one is by s, that of the compressive one by s-.
template <int dim>
struct Equivalents {
  Equivalent tensile, compressive;

  Equivalents(const Concrete<dim>& law, const ElasticStress<dim>& s) {
    const double alpha = (law.biaxial_ratio - 1) / (2 * law.biaxial_ratio - 1);
    compressive = drucker_prager(s.negative, alpha);
    compressive.value /= 1 - alpha;
    for (int i = 0; i < 3; ++i) {
      if (s.opens(i)) compressive.slope[i] = 0;
      compressive.slope[i] /= 1 - alpha;
    }
    if (!(s.largest() > 0)) return;
    std::array<double, 3> one_tension;
    for (int i = 0; i < 3; ++i) one_tension[i] = std::min(s.pairs.value[i], 0.0);
    one_tension[s.first] = s.largest();
    const double share = law.tension.strength / (law.crushing.strength * (1 - alpha));
    tensile = drucker_prager(one_tension, alpha);
    tensile.value = share * tensile.value + (1 - share * (1 + alpha)) * s.largest();
    for (int i = 0; i < 3; ++i) {
      if (i != s.first && s.pairs.value[i] > 0) tensile.slope[i] = 0;
      tensile.slope[i] *= share;
    }
    tensile.slope[s.first] += 1 - share * (1 + alpha);
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

/// dT/dE; it is symmetric where no damage grows.
template <int dim>
StrainMatrix<dim> tangent(const Concrete<dim>& law, const ElasticStress<dim>& s,
                          const Equivalents<dim>& equivalents, const Damages& damages) {
  const double d_plus = damages.plus.damage.value, d_minus = damages.minus.damage.value;
  const double lambda = law.lambda, mu = law.mu;
  const SplitSlopes<dim> split(s, lambda, mu);
  StrainMatrix<dim> D = 2 * mu * (1 - d_minus) * StrainMatrix<dim>::Identity();
  D.template topLeftCorner<dim, dim>().array() += lambda * (1 - d_minus);
  if (d_plus != d_minus) D += (d_minus - d_plus) * split.tensile;
  // Derivative by the strain of a function of a stress 2 mu E + trace 1 with the slope given.
  const auto by_strain = [&](const Equivalent& t, const StrainVector<dim>& trace) {
    StrainVector<dim> v =
        2 * mu * strain_vector<dim>(in_plane<dim>(compose<dim>(t.slope, s.pairs.n)));
    v += lambda * (t.slope[0] + t.slope[1] + t.slope[2]) * trace;
    return v;
  };
  if (damages.plus.grows) {
    D -= damages.plus.damage.slope * strain_vector<dim>(in_plane<dim>(s.tensile)) *
         by_strain(equivalents.tensile, split.unit).transpose();
  }
  if (damages.minus.grows) {
    D -= damages.minus.damage.slope * strain_vector<dim>(in_plane<dim>(s.compressive)) *
         by_strain(equivalents.compressive, split.unit - split.sum).transpose();
  }
  return D;
}

}  // namespace

template <int dim>
void ConcreteOfCell<dim>::log_stress(const Symmetric<dim>& E, std::span<const double> history_n,
                                     std::span<double> history, LogStress<dim>& out) const {
  std::ranges::copy(history_n, history.begin());
  const double lambda = law.lambda, mu = law.mu;
  Symmetric<dim> stress = 2 * mu * E;
  stress.template head<3>().array() += lambda * trace<dim>(E);
  const ElasticStress<dim> s(stress, lambda, mu);
  const Equivalents<dim> equivalents(law, s);
  const Damages damages = find_damages(*this, s, equivalents, E, history);
  const double d_plus = damages.plus.damage.value, d_minus = damages.minus.damage.value;
  out.T = (1 - d_plus) * s.tensile + (1 - d_minus) * s.compressive;
  out.energy = 0.5 * contract<dim>(out.T, E);
  out.D = tangent(law, s, equivalents, damages);
  history[4] = history[2] * d_plus * s.opening() / (2 * mu);
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
