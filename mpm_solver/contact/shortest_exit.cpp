// SPDX-License-Identifier: BSD-3-Clause
#include "mpm_solver/contact/shortest_exit.hpp"

#include <Eigen/LU>
#include <limits>

namespace gabion::mpm {

namespace {

// A displacement leads out of a plane if it lacks less than this share of the depth.
constexpr double negligible = 1e-9;

/// Looks through the sets of at most dim planes for the one whose displacement leads out of all.
template <int dim>
class Search {
 public:
  Search(std::span<const Vector<dim>> normals, std::span<const double> deltas)
      : normals_(normals), deltas_(deltas) {}

  ShortestExit<dim> run() {
    for (int size = 1; size <= dim && lacking_ > negligible; ++size) {
      ShortestExit<dim> set;
      set.size = size;
      choose(set, 0, 0);
    }
    return best_;
  }

 private:
  void choose(ShortestExit<dim>& set, int chosen, int first) {
    if (chosen == set.size) return try_set(set);
    for (int plane = first; plane < static_cast<int>(normals_.size()); ++plane) {
      set.planes[chosen] = plane;
      choose(set, chosen + 1, plane + 1);
    }
  }

  void try_set(ShortestExit<dim>& set) {
    Matrix<dim> G = Matrix<dim>::Identity();  // beyond `size` not used
    for (int k = 0; k < set.size; ++k) {
      for (int l = 0; l < set.size; ++l) {
        G(k, l) = normals_[set.planes[k]].dot(normals_[set.planes[l]]);
      }
    }
    set.inverse = G.inverse();
    Vector<dim> u = Vector<dim>::Zero();
    for (int k = 0; k < set.size; ++k) {
      set.depths[k] = 0;
      for (int l = 0; l < set.size; ++l) {
        set.depths[k] += set.inverse(k, l) * deltas_[set.planes[l]];
      }
      if (!(set.depths[k] > 0)) return;  // also of planes that are parallel
      u += set.depths[k] * normals_[set.planes[k]];
    }
    set.length = u.norm();
    double lacking = 0;
    for (std::size_t l = 0; l < normals_.size(); ++l) {
      lacking = std::max(lacking, 1 - normals_[l].dot(u) / deltas_[l]);
    }
    if (lacking >= lacking_) return;
    lacking_ = lacking;
    best_ = set;
  }

  std::span<const Vector<dim>> normals_;
  std::span<const double> deltas_;
  ShortestExit<dim> best_;
  double lacking_ = std::numeric_limits<double>::infinity();
};

}  // namespace

template <int dim>
ShortestExit<dim> shortest_exit(std::span<const Vector<dim>> normals,
                                std::span<const double> deltas) {
  return Search<dim>(normals, deltas).run();
}

template ShortestExit<2> shortest_exit<2>(std::span<const Vector<2>>, std::span<const double>);
template ShortestExit<3> shortest_exit<3>(std::span<const Vector<3>>, std::span<const double>);

}  // namespace gabion::mpm
