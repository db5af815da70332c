// SPDX-License-Identifier: BSD-3-Clause
#include "fem_solver/beams/beam_axes.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <Eigen/Geometry>

#include "common/base/require.hpp"

namespace gabion::fem {

namespace {

constexpr double least_sine = 1e-3;  // of the angle between orientation and beam

}  // namespace

Matrix<3> beam_axes(const BeamData& beam, const Vector<3>& chord, const std::string& where) {
  const Vector<3> e_1 = chord.normalized();
  Vector<3> o = Vector<3>::Zero();
  int least = 0;
  e_1.cwiseAbs().minCoeff(&least);
  o[least] = 1;
  if (beam.orientation) o = beam.orientation->normalized();
  const Vector<3> across = o - o.dot(e_1) * e_1;
  require<ConfigError>(
      across.norm() > least_sine,
      "{}: found the orientation ({:.6g}) along a beam in the direction ({:.6g}), allowed: another "
      "direction for axis 2 of its section",
      where, fmt::join(o.data(), o.data() + 3, ", "), fmt::join(e_1.data(), e_1.data() + 3, ", "));
  Matrix<3> axes;
  axes << e_1, across.normalized(), e_1.cross(across.normalized());
  return axes;
}

}  // namespace gabion::fem
