// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <cmath>
#include <functional>
#include <random>

#include "fem_solver/interface/beam_surfaces.hpp"
#include "tests/support/expect_error.hpp"
#include "tests/unit/fem/beam_scene.hpp"

namespace gabion::test::test_beam_surfaces {
namespace {

using Eigen::VectorXd;
using Parts = std::vector<std::string_view>;

constexpr double L = 2, h = 0.2, b = 0.1;

Json post(int dimension, const std::string& file, const Json& section = rectangle(h, b)) {
  Json material = beam_material(1e7, 0.2, section, 1000);
  if (dimension == 3) material["orientation"] = {0, 1, 0};
  Json json = cantilever_of_beams(dimension, file, material, L, "dynamic");
  json["interfaces"] = {{{"name", "wet"}, {"beams", {"rope"}}}};
  return json;
}

template <int dim>
fem::FemSettings<dim> post_settings(const Json& section = rectangle(h, b)) {
  LineText text = chain(L, 4);
  text.nodes[2][1] = 0.1;  // bent
  const TemporaryMesh mesh(text.file());
  return fem_settings<dim>(post(dim, mesh.path(), section));
}

double signed_volume(const InterfaceMesh& mesh, const std::vector<double>& moved = {}) {
  std::vector<double> x = mesh.coordinates;
  for (std::size_t i = 0; i < moved.size(); ++i) x[i] += moved[i];
  double sum = 0;
  const auto point = [&](std::int64_t i) -> Vector<3> {
    if (mesh.dim == 2) return {x[2 * i], x[2 * i + 1], 0};
    return {x[3 * i], x[3 * i + 1], x[3 * i + 2]};
  };
  const auto width = static_cast<std::size_t>(mesh.vertices_per_facet);
  for (std::size_t f = 0; f < mesh.facets.size(); f += width) {
    const Vector<3> a = point(mesh.facets[f]), c = point(mesh.facets[f + 1]);
    if (mesh.dim == 2) {
      sum += 0.5 * a.cross(c)[2];
      continue;
    }
    const Vector<3> d = point(mesh.facets[f + 2]), e = point(mesh.facets[f + 3]);
    sum += a.dot(c.cross(d)) / 6 + a.dot(d.cross(e)) / 6;
  }
  return sum;
}

/// The surface is closed with normals outward: it holds section times length.
TEST(BeamSurfaces, outline) {
  const TemporaryMesh mesh(chain(L, 4).file());
  const auto plane = fem_settings<2>(post(2, mesh.path()));
  const auto space = fem_settings<3>(post(3, mesh.path()));
  const auto round =
      fem_settings<3>(post(3, mesh.path(), {{"shape", "pipe"}, {"diameter", h}, {"wall", 0.01}}));
  const InterfaceMesh strip = fem::BeamSurfaces<2>(plane).meshes()[0];
  EXPECT_EQ(strip.name, "wet");
  EXPECT_EQ(strip.num_vertices(), 10);
  EXPECT_EQ(strip.facets.size(), 2 * 10);
  EXPECT_NEAR(signed_volume(strip), h * L, 1e-14);
  const InterfaceMesh box = fem::BeamSurfaces<3>(space).meshes()[0];
  EXPECT_EQ(box.num_vertices(), 20);
  EXPECT_EQ(box.facets.size(), 4 * (16 + 2));
  EXPECT_NEAR(signed_volume(box), h * b * L, 1e-14);
  const InterfaceMesh tube = fem::BeamSurfaces<3>(round).meshes()[0];
  EXPECT_EQ(tube.facets.size(), 4 * (32 + 6));
  EXPECT_NEAR(signed_volume(tube), std::sqrt(8) * h * h / 4 * L, 1e-14);
}

/// Random forces on the surface in a turned state: force, moment about the origin and virtual work
/// are those of the nodes.
template <int dim>
void expect_same_work(const fem::FemSettings<dim>& settings) {
  const fem::BeamSurfaces<dim> surfaces(settings);
  const InterfaceMesh& mesh = surfaces.meshes()[0];
  std::mt19937 random(5);
  std::uniform_real_distribution<double> any(-1, 1);
  const auto places = static_cast<std::size_t>(settings.num_places());
  std::vector<Matrix<dim>> turns;
  std::vector<double> u(settings.mesh.nodes.size() * dim), v(u.size());
  for (double& x : u) x = any(random);
  for (double& x : v) x = any(random);
  for (std::size_t k = 0; k < settings.mesh.nodes.size() - places; ++k) {
    if constexpr (dim == 2) {
      turns.push_back(Eigen::Rotation2Dd(any(random)).toRotationMatrix());
    } else {
      const Vector<3> axis(any(random), any(random), any(random));
      turns.push_back(Eigen::AngleAxisd(axis.norm(), axis.normalized()).toRotationMatrix());
    }
  }
  std::vector<double> f(mesh.coordinates.size());
  for (double& x : f) x = any(random);
  fem::ExternalForces forces;
  surfaces.add_forces({{"wet", f}}, turns, forces);
  InterfaceValues moved;
  surfaces.add_displacements(u, turns, moved);
  Vector<3> force = Vector<3>::Zero(), moment = force;
  const auto add = [&](const Vector<dim>& x, const Vector<dim>& own, double sign) {
    Vector<3> arm = Vector<3>::Zero(), f_3 = arm;
    arm.template head<dim>() = x;
    f_3.template head<dim>() = own;
    force += sign * f_3;
    moment += sign * arm.cross(f_3);
  };
  const auto at = [](const std::vector<double>& values, std::size_t i) {
    return Vector<dim>(Eigen::Map<const Vector<dim>>(&values[i * dim]));
  };
  for (std::size_t k = 0; k < f.size() / dim; ++k) {
    add(at(mesh.coordinates, k) + at(moved.at("wet"), k), at(f, k), 1);
  }
  for (std::size_t i = 0; i < places; ++i) {
    add(settings.mesh.nodes[i] + at(u, i), at(forces.end, i), -1);
    const auto turn = settings.beam_nodes().of(static_cast<std::int32_t>(i));
    moment -= fem::moment_of<dim>(forces.end, turn, settings.rotation_length);
  }
  EXPECT_LT(force.norm(), 1e-13);
  EXPECT_LT(moment.norm(), 1e-13);

  // Work in the velocities of the points, by central differences of their places.
  constexpr double dt = 1e-4;
  const auto places_after = [&](double time) {
    auto later = turns;
    fem::turn_on<dim>(settings, v, time, later);
    std::vector<double> x = u;
    for (std::size_t i = 0; i < places * dim; ++i) x[i] += time * v[i];
    InterfaceValues there;
    surfaces.add_displacements(x, later, there);
    return Eigen::Map<const VectorXd>(there.at("wet").data(), f.size()).eval();
  };
  const Eigen::Map<const VectorXd> f_all(f.data(), f.size());
  const double of_points = f_all.dot(8 * (places_after(dt) - places_after(-dt)) -
                                     (places_after(2 * dt) - places_after(-2 * dt))) /
                           (12 * dt);
  double of_nodes = 0;
  for (std::size_t i = 0; i < v.size(); ++i) of_nodes += forces.end[i] * v[i];
  EXPECT_NEAR(of_points, of_nodes, 1e-10 * std::abs(of_nodes));
}

TEST(BeamSurfaces, forces_moments_and_work_of_nodes_and_points) {
  expect_same_work<2>(post_settings<2>());
  expect_same_work<3>(post_settings<3>());
  expect_same_work<3>(post_settings<3>({{"shape", "circle"}, {"diameter", h}}));
}

/// Torque by friction on the sides of a post: G J theta / L.
TEST(BeamSurfaces, friction_twists) {
  const TemporaryMesh mesh(chain(L, 4).file());
  Json json = post(3, mesh.path());
  json["analysis"] = "static";
  const auto solver = fem_solver<3>(json);
  const InterfaceMesh wet = solver->interfaces()[0];
  InterfaceValues f, sent;
  f["wet"].assign(wet.coordinates.size(), 0.0);
  const std::size_t last = wet.num_vertices() - 4;  // the section at the end
  constexpr double P = 3;
  f["wet"][last * 3 + 2] = P;         // at (h / 2, b / 2)
  f["wet"][(last + 1) * 3 + 2] = -P;  // at (-h / 2, b / 2)
  solver->solve_step({1, 0, 0, 1}, f, sent);
  solver->accept_step({1, 0, 0, 1}, true);
  const double torque = P * h;
  EXPECT_NEAR(probe(*solver, "torsion_max_rope"), torque, 1e-9);
  EXPECT_NEAR(probe(*solver, "moment_low_x"), -torque, 1e-9);
  const double J = h * b * b * b * (1.0 / 3 - 0.21 * 0.5 * (1 - std::pow(0.5, 4) / 12));
  const double angle = torque * L / (1e7 / 2.4 * J);
  // Corner (h / 2, b / 2) turns about x.
  EXPECT_NEAR(sent.at("wet")[last * 3 + 1], h / 2 * (std::cos(angle) - 1) - b / 2 * std::sin(angle),
              1e-9);
  EXPECT_NEAR(sent.at("wet")[last * 3 + 2], h / 2 * std::sin(angle) + b / 2 * (std::cos(angle) - 1),
              1e-9);
}

void expect_refused(const LineText& text, const std::function<void(Json&)>& change,
                    const Parts& parts) {
  const TemporaryMesh mesh(text.file());
  Json json = post(3, mesh.path());
  change(json);
  expect_error<ConfigError>([&] { fem_solver<3>(json); }, parts);
}

TEST(BeamSurfaces, refused) {
  const auto nothing = [](Json&) {};
  LineText fork = chain(L, 2);
  fork.nodes.push_back({1, 1, 0});
  fork.lines[0].second.push_back({2, 4});
  expect_refused(fork, nothing, {"/interfaces/0/beams", "node 1", "two beams begin"});
  LineText against = chain(L, 2);
  against.lines[0].second[1] = {3, 2};
  expect_refused(against, nothing, {"/interfaces/0/beams", "two beams end"});
  expect_refused(chain(L, 2), [](Json& json) { json["interfaces"][0]["beams"] = {"posts"}; },
                 {"/interfaces/0/beams", "\"posts\"", "rope"});
  expect_refused(
      chain(L, 2),
      [](Json& json) { json["materials"][0]["cross_section"] = general_section(1, 1, 1); },
      {"/interfaces/0/beams", "general"});
  expect_refused(chain(L, 2), [](Json& json) { json["interfaces"][0]["groups"] = {"rope"}; },
                 {"/interfaces/0", "groups"});
  expect_refused(chain(L, 2),
                 [](Json& json) { json["interfaces"].push_back(json["interfaces"][0]); },
                 {"/interfaces", "\"wet\"", "second time"});
}

}  // namespace
}  // namespace gabion::test::test_beam_surfaces
