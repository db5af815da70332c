// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <map>
#include <span>
#include <vector>

#include "common/mechanics/petsc/block_matrix.hpp"
#include "common/mechanics/tensor.hpp"

namespace gabion::mpm {

/// A contact pressure that the grid resolves. The gaps g_k of the places k where soil touches are
/// averaged at each node i with the basis functions, the penalty acts on the averages, and the
/// pressure at a place is interpolated from the nodes:
///
///     gm_i = sum_k N_ik W_k g_k / m_i ,  m_i = sum_k N_ik W_k ,  q_i = penalty <-gm_i> ,
///     p_k = sum_i N_ik q_i
///
/// W_k is the area of the place. The forces W_k p_k derive from sum_i penalty m_i <-gm_i>^2 / 2. A
/// node has one average for each of the sides (directions of the axes) that normals look to: soil
/// on both sides of a thin structure, or in an inside corner, does not mix.
template <int dim>
class NodalPressure {
 public:
  struct Place {
    std::span<const std::int32_t> nodes;  ///< active ones
    std::span<const double> N;            ///< basis functions there
    Vector<dim> normal = Vector<dim>::Zero();
    double area = 0;  ///< [m^2] (2D: m)
    double gap = 0;   ///< [m]
  };

  explicit NodalPressure(double penalty) : penalty_(penalty) {}

  void clear();
  /// @returns number of the place
  int add(const Place& place);
  /// Find the pressures. @pre all places are there
  void balance();

  double pressure(int place) const;  ///< [Pa]
  double stored_energy() const;      ///< [J]
  double penetration() const;        ///< largest average [m]
  /// Equal sets of nodes with pressure have equal names.
  std::uint64_t active_set() const;

  /// Motion of a place by its nodes' and force by its pressure: -df/du of the pressures.
  struct Slope {
    std::span<const double> w;  ///< of the place's nodes: its motion is sum w_i du_i
    Vector<dim> by_pressure;    ///< derivative of the traction by the pressure
  };
  /// Add factor times the derivative of sum W_k by_pressure_k p_k to K.
  /// @param slopes  of all places
  void add_stiffness(double factor, std::span<const Slope> slopes, BlockMatrix<dim>& K) const;

 private:
  struct Average {
    std::int32_t node = 0;
    double area = 0, gap = 0, pressure = 0;
    std::vector<std::pair<std::int32_t, double>> places;  // and N there
  };
  static int side_of(const Vector<dim>& normal);

  double penalty_;
  std::vector<Place> places_;
  std::vector<Average> averages_;
  std::vector<std::int32_t> average_of_;  // of each node of each place
  std::vector<std::size_t> first_;        // of each place in average_of_
  std::map<std::pair<std::int32_t, int>, std::int32_t> index_;
};

}  // namespace gabion::mpm
