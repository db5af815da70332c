// SPDX-License-Identifier: BSD-3-Clause
#include "fem_solver/nodal_settings.hpp"

#include <set>
#include <string>

namespace gabion::fem {

TimeFunction read_factor(ConfigReader& in) {
  return in.has("table") ? read_time_table(in) : TimeFunction::constant(1);
}

namespace {

/// Read the place at which a load, mass or spring acts.
template <int dim, class Settings>
void read_place(ConfigReader& in, Settings& s) {
  if (in.has("point") == in.has("group")) {
    in.fail("point", "allowed: either \"point\" (coordinates of a node) or \"group\"");
  }
  if (in.has("point")) {
    s.point = read_vector<dim>(in, "point");
    s.where = in.where("point");
  } else {
    s.group = in.text("group");
    s.where = in.where("group");
  }
}

}  // namespace

template <int dim>
PointMassSettings<dim> read_point_mass(ConfigReader in) {
  PointMassSettings<dim> s;
  read_place<dim>(in, s);
  s.mass = in.number("mass");
  in.finish();
  return s;
}

template <int dim>
SpringSettings<dim> read_spring(ConfigReader in) {
  SpringSettings<dim> s;
  read_place<dim>(in, s);
  s.stiffness = read_vector<dim>(in, "stiffness");
  if (s.stiffness.isZero(0)) in.fail("stiffness", "found zero in all directions, allowed: > 0");
  in.finish();
  return s;
}

template <int dim>
DashpotSettings<dim> read_dashpot(ConfigReader in) {
  DashpotSettings<dim> s;
  read_place<dim>(in, s);
  s.damping = read_vector<dim>(in, "damping");
  if (s.damping.isZero(0)) in.fail("damping", "found zero in all directions, allowed: > 0");
  in.finish();
  return s;
}

template <int dim>
LoadSettings<dim> read_load(ConfigReader in) {
  LoadSettings<dim> load;
  read_place<dim>(in, load);
  load.force = read_vector<dim>(in, "force");
  if (in.has("moment")) {
    const auto moment = in.vector("moment", dim == 2 ? 1 : 3);
    for (std::size_t k = 0; k < moment.size(); ++k) load.moment[dim == 2 ? 2 : k] = moment[k];
  }
  load.factor = read_factor(in);
  in.finish();
  return load;
}

RigidLinkSettings read_rigid_link(ConfigReader in) {
  RigidLinkSettings s;
  s.beam = in.text("beam");
  s.group = in.text("group");
  s.where = in.where("group");
  in.finish();
  return s;
}

BeamSurfaceSettings read_beam_surface(ConfigReader in) {
  BeamSurfaceSettings s;
  s.name = in.name("name");
  for (const char* other : {"groups", "facets"}) {
    if (in.has(other)) in.fail(other, "found beside \"beams\", allowed: one of them");
  }
  if (in.has("behind")) in.fail("behind", "found beside \"beams\", whose surface stays");
  s.where = in.where("beams");
  s.groups = in.texts("beams");
  if (std::set<std::string>(s.groups.begin(), s.groups.end()).size() < s.groups.size()) {
    in.fail("beams", "found a group a second time, allowed: each once");
  }
  in.finish();
  return s;
}

template PointMassSettings<2> read_point_mass<2>(ConfigReader);
template PointMassSettings<3> read_point_mass<3>(ConfigReader);
template SpringSettings<2> read_spring<2>(ConfigReader);
template SpringSettings<3> read_spring<3>(ConfigReader);
template DashpotSettings<2> read_dashpot<2>(ConfigReader);
template DashpotSettings<3> read_dashpot<3>(ConfigReader);
template LoadSettings<2> read_load<2>(ConfigReader);
template LoadSettings<3> read_load<3>(ConfigReader);

}  // namespace gabion::fem
