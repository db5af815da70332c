// SPDX-License-Identifier: BSD-3-Clause
#include "mpm_solver/contact/rigid_motion.hpp"

#include <fmt/format.h>

#include <Eigen/Geometry>
#include <algorithm>

namespace gabion::mpm {

template <int dim>
Vector<dim> RigidMotion<dim>::translation(double time) const {
  if (times.empty()) return velocity * time;
  if (time >= times.back()) return places.back();
  const auto next = std::upper_bound(times.begin(), times.end(), time) - times.begin();
  const double share = (time - times[next - 1]) / (times[next] - times[next - 1]);
  return places[next - 1] + share * (places[next] - places[next - 1]);
}

template <int dim>
std::vector<double> RigidMotion<dim>::displacement(const std::vector<Vector<dim>>& vertices,
                                                   double time) const {
  const Vector<dim> move = translation(time);
  const Matrix<3> turn = Eigen::AngleAxisd(rate * time, axis).toRotationMatrix();
  std::vector<double> values;
  values.reserve(vertices.size() * dim);
  for (const Vector<dim>& X : vertices) {
    Vector<dim> u = move;
    if (rate != 0) {
      const Vector<dim> arm = X - centre;
      u += turn.template topLeftCorner<dim, dim>() * arm - arm;
    }
    values.insert(values.end(), u.data(), u.data() + dim);
  }
  return values;
}

namespace {

template <int dim>
void read_table(ConfigReader& in, RigidMotion<dim>& motion) {
  const auto rows = in.rows("table", dim + 1);
  for (const auto& row : rows) {
    const bool first = motion.times.empty();
    if (first ? row[0] != 0 : !(row[0] > motion.times.back())) {
      const std::string after = first ? "" : fmt::format(" after {}", motion.times.back());
      in.fail(fmt::format("table/{}", motion.times.size()),
              fmt::format("found time {}{}, allowed: times that start with 0 and ascend", row[0],
                          after));
    }
    motion.times.push_back(row[0]);
    motion.places.push_back(Eigen::Map<const Vector<dim>>(row.data() + 1));
  }
  if (!motion.places.front().isZero(0)) {
    in.fail("table", "found a displacement at the time 0, allowed: 0 there");
  }
}

template <int dim>
void read_rotation(ConfigReader in, RigidMotion<dim>& motion) {
  const auto centre = in.vector("centre", dim);
  motion.centre = Eigen::Map<const Vector<dim>>(centre.data());
  motion.rate = in.number("rate");
  if constexpr (dim == 3) {
    const auto axis = in.vector("axis", 3);
    motion.axis = Eigen::Map<const Vector<3>>(axis.data());
    if (!(motion.axis.norm() > 0)) in.fail("axis", "found length 0, allowed: a direction");
    motion.axis.normalize();
  }
  in.finish();
}

KeyTable rotation_keys() {
  return {"rotation",
          "Rotation about a centre that moves with the translation.",
          {key::vector("centre", "m", "Centre at time 0."),
           key::number("rate", "rad/s",
                       "Angular velocity, in 3D by the right-hand rule, in 2D positive from x to "
                       "y."),
           key::vector("axis", "", "Direction of the axis; its length does not count.")
               .wide(3, 3)
               .only("in 3D")}};
}

}  // namespace

KeyTable rigid_motion_keys() {
  return {
      "rigid_motion",
      "Given motion of a rigid surface.",
      {key::vector("velocity", "m/s", "Constant velocity: the translation is this times t.")
           .or_else(0)
           .without("table"),
       key::rows("table", "s, m",
                 "Rows [t, ux, uy(, uz)] of the translation, the first one 0, t ascending, linear "
                 "between rows and at rest after the last.")
           .wide(3, 4)
           .not_empty()
           .or_none(),
       key::object("rotation", rotation_keys(), "Rotation in addition to the translation.")
           .or_none()}};
}

template <int dim>
RigidMotion<dim> read_rigid_motion(ConfigReader in) {
  RigidMotion<dim> motion;
  if (in.has("table")) {
    if (in.has("velocity")) in.fail("table", "allowed: one of \"velocity\" and \"table\"");
    read_table(in, motion);
  } else {
    const auto velocity = in.vector("velocity", dim);
    motion.velocity = Eigen::Map<const Vector<dim>>(velocity.data());
  }
  if (auto item = in.optional_object("rotation")) read_rotation(*item, motion);
  in.finish();
  return motion;
}

template struct RigidMotion<2>;
template struct RigidMotion<3>;
template RigidMotion<2> read_rigid_motion<2>(ConfigReader);
template RigidMotion<3> read_rigid_motion<3>(ConfigReader);

}  // namespace gabion::mpm
