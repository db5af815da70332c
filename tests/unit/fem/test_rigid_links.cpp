// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <cmath>
#include <functional>
#include <random>

#include "fem_solver/stress/rigid_links.hpp"
#include "tests/support/check_tangent.hpp"
#include "tests/support/expect_error.hpp"
#include "tests/unit/fem/beam_scene.hpp"

namespace gabion::test::test_rigid_links {
namespace {

using Eigen::MatrixXd;
using Eigen::VectorXd;
using Parts = std::vector<std::string_view>;

constexpr double length = 0.7;  // of the rotations' unknowns

/// Three nodes that move with node 3; node 4 has its rotation.
template <int dim>
struct OneLink {
  std::vector<Vector<dim>> arms;
  fem::RigidLinks<dim> links;
  std::vector<double> history = std::vector<double>(14, 0.0);

  OneLink() {
    fem::RigidLink<dim> link;
    link.place = 3;
    link.rotation = 4;
    link.stiffness = 50;
    link.end = 1;
    for (int k = 0; k < 3; ++k) {
      arms.push_back(dim * Vector<dim>::Unit(k % dim) + 0.3 * k * Vector<dim>::Ones());
      link.arms.push_back({k, arms.back()});
    }
    links = fem::RigidLinks<dim>({link}, length);
  }
  VectorXd forces(const VectorXd& u, double* energy = nullptr, BlockMatrix<dim>* K = nullptr) {
    VectorXd f = VectorXd::Zero(u.size());
    const std::span<const double> own = history;
    const auto n = static_cast<std::size_t>(u.size());
    const double sum = links.add_internal({u.data(), n}, {f.data(), n}, K, 0, {&own, 1});
    if (energy) *energy = sum;
    return f;
  }
  MatrixXd stiffness(const VectorXd& u) {
    BlockMatrix<dim> K;
    const std::vector<std::int32_t> offsets = {0, 3, 6, 9};
    K.set_pattern(5, offsets, links.nodes());
    K.set_zero();
    forces(u, nullptr, &K);
    MatrixXd dense(u.size(), u.size());
    for (Eigen::Index i = 0; i < u.size(); ++i) {
      VectorXd x = VectorXd::Unit(u.size(), i), y = x;
      K.multiply({x.data(), static_cast<std::size_t>(x.size())},
                 {y.data(), static_cast<std::size_t>(y.size())});
      dense.col(i) = y;
    }
    return dense;
  }
};

VectorXd random_vector(Eigen::Index n, int seed) {
  std::mt19937 random(seed);
  std::uniform_real_distribution<double> any(-0.5, 0.5);
  VectorXd x(n);
  for (double& value : x) value = any(random);
  return x;
}

/// A rotation that was accepted, at the unknowns from which it goes on.
void turn_before(OneLink<3>& link, const VectorXd& unknowns) {
  const Eigen::Quaterniond q(Eigen::AngleAxisd(1.3, Vector<3>(1, -2, 0.5).normalized()));
  const double values[] = {q.w() - 1, q.x(), q.y(), q.z()};
  for (int c = 0; c < 4; ++c) link.history[4 + c] = values[c];
  for (int c = 0; c < 3; ++c) link.history[11 + c] = unknowns[12 + c];
}

template <int dim>
void expect_slopes() {
  OneLink<dim> link;
  const VectorXd u = random_vector(5 * dim, 3);
  if constexpr (dim == 3) turn_before(link, random_vector(15, 4));
  const auto force = [&](const VectorXd& at) { return link.forces(at); };
  EXPECT_LT(tangent_error(force, u, link.stiffness(u), 1e-3), 1e-9) << dim;
  // In space the force is the derivative of the energy at the start of a step, with moments on
  // spins.
  if constexpr (dim == 3) turn_before(link, u);
  const auto energy = [&](const VectorXd& at) {
    double sum = 0;
    link.forces(at, &sum);
    return VectorXd(VectorXd::Constant(1, sum));
  };
  const VectorXd f = link.forces(u);
  const MatrixXd slope = difference_tangent(energy, u, 1e-3);
  EXPECT_LT((slope.row(0).transpose() - f).cwiseAbs().maxCoeff(), 1e-9 * f.cwiseAbs().maxCoeff());
}

TEST(RigidLinks, slopes) {
  expect_slopes<2>();
  expect_slopes<3>();
}

/// Forces and moments of a link balance in any state.
TEST(RigidLinks, balance) {
  OneLink<3> link;
  turn_before(link, random_vector(15, 4));
  const VectorXd u = random_vector(15, 5), f = link.forces(u);
  Vector<3> force = Vector<3>::Zero(), moment = length * f.segment<3>(12);
  for (int i = 0; i < 4; ++i) {
    const Vector<3> x = (i < 3 ? link.arms[i] : Vector<3>::Zero()) + u.segment<3>(3 * i);
    force += f.segment<3>(3 * i);
    moment += x.cross(Vector<3>(f.segment<3>(3 * i)));
  }
  EXPECT_GT(f.norm(), 10);
  EXPECT_LT(force.norm(), 1e-14 * f.norm());
  EXPECT_LT(moment.norm(), 1e-13 * f.norm());
}

TEST(RigidLinks, a_rigid_motion_is_without_force) {
  OneLink<3> link;
  const Vector<3> turn(0.7, 1.9, -0.4), shift(3, -1, 2);
  const Matrix<3> R = Eigen::AngleAxisd(turn.norm(), turn.normalized()).toRotationMatrix();
  VectorXd u(15);
  for (int i = 0; i < 4; ++i) {
    const Vector<3> d = i < 3 ? link.arms[i] : Vector<3>::Zero();
    u.segment<3>(3 * i) = shift + R * d - d;
  }
  u.segment<3>(12) = length * turn;
  EXPECT_LT(link.forces(u).norm(), 1e-14 * 50 * u.norm());
}

constexpr double E = 2e8, side = 0.1, L = 1, h = 0.2;

/// A cube with a post on the middle of its top; "plate" are the corners there. Turned about the
/// origin by a rotation.
GmshText cube_with_post(const Matrix<3>& R = Matrix<3>::Identity(), int beams = 4) {
  GmshText file{.groups = {{3, 1, "body"}, {2, 2, "base"}, {2, 3, "plate"}},
                .entities = {{3, 1, {1}}, {2, 2, {2}}, {2, 3, {3}}},
                .nodes = {},
                .blocks = {{3, 1, 5, {{1, 2, 3, 4, 5, 6, 7, 8}}},
                           {2, 2, 3, {{1, 2, 3, 4}}},
                           {2, 3, 3, {{5, 6, 7, 8}}}}};
  std::vector<Vector<3>> places;
  for (const double z : {-2 * h, 0.0}) {
    places.insert(places.end(), {{-h, -h, z}, {h, -h, z}, {h, h, z}, {-h, h, z}});
  }
  LineText post{
      .nodes = {}, .lines = {{"rope", {}}}, .points = {{"foot", {9}}, {"high", {9 + beams}}}};
  for (int i = 0; i <= beams; ++i) {
    places.emplace_back(0, 0, L * i / beams);
    if (i > 0) post.lines[0].second.push_back({8 + i, 9 + i});
  }
  for (const Vector<3>& x : places) {
    const Vector<3> y = R * x;
    file.nodes.push_back({y[0], y[1], y[2]});
  }
  post.add_to(file, 4);
  return file;
}

std::vector<double> list(const Vector<3>& x) {
  return {x[0], x[1], x[2]};
}

Json scene_of_post(const std::string& file, const Matrix<3>& R = Matrix<3>::Identity()) {
  Json post = beam_material(E, 0.25, rectangle(side, side), 1000);
  post["orientation"] = list(R * Vector<3>(1, 0, 0));
  Json json = line_scene(3, file, post);
  Json body = elastic("neo_hookean", 1e3 * E, 0.25, 1000);
  body["group"] = "body";
  json["materials"].push_back(body);
  json["analysis"] = "static";
  json["supports"] = {{{"group", "base"}, {"report_reaction", true}, {"report_moment", true}}};
  json["rigid_links"] = {{{"beam", "foot"}, {"group", "plate"}}};
  json["probes"] = {{{"name", "tip"}, {"point", list(R * Vector<3>(0, 0, L))}}};
  json["loads"] = {rising_load(list(R * Vector<3>(100, 30, 0)))};
  return json;
}

Vector<3> tip_of(const Solver& solver) {
  return {probe(solver, "tip.ux"), probe(solver, "tip.uy"), probe(solver, "tip.uz")};
}

std::unique_ptr<fem::FemSolver<3>> loaded(const Json& json) {
  auto solver = fem_solver<3>(json);
  for (int n = 1; n <= 4; ++n) advance(*solver, n, 0.25);
  return solver;
}

/// A post on a stiff cube is a cantilever: its foot turns with the cube.
TEST(RigidLinks, a_post_on_a_stiff_block_is_clamped) {
  const TemporaryMesh mesh(cube_with_post());
  Json json = scene_of_post(mesh.path());
  json["sections"] = {{{"name", "joint"}, {"point", {0, 0, 0}}, {"normal", {0, 0, 1}}},
                      {{"name", "back"}, {"point", {0, 0, 0}}, {"normal", {0, 0, -1}}}};
  const auto linked = loaded(json);
  Json clamped = scene_of_post(mesh.path());
  clamped.erase("rigid_links");
  clamped["supports"].push_back(clamp(3, "foot"));
  const auto reference = loaded(clamped);
  const Vector<3> tip = tip_of(*linked), exact = tip_of(*reference);
  EXPECT_GT(exact.norm(), 0.01 * L);
  EXPECT_LT((tip - exact).norm(), 2e-4 * exact.norm());
  // 100 N and 30 N at L: reactions of the cube and the section between cube and post.
  EXPECT_NEAR(probe(*linked, "reaction_base_x"), -100, 1e-6);
  EXPECT_NEAR(probe(*linked, "moment_base_x"), 30 * (L + 2 * h + tip[2]) - 0 * tip[1], 1e-5);
  const double M_y = 100 * (L + tip[2]), M_x = -30 * (L + tip[2]);
  for (const char* name : {"joint", "back"}) {
    const double sign = name[0] == 'j' ? 1 : -1;
    EXPECT_NEAR(probe(*linked, std::string(name) + ".V_x"), sign * 100, 1e-6) << name;
    EXPECT_NEAR(probe(*linked, std::string(name) + ".V_y"), sign * 30, 1e-6) << name;
    EXPECT_NEAR(probe(*linked, std::string(name) + ".M_y"), sign * M_y, 1e-4) << name;
    EXPECT_NEAR(probe(*linked, std::string(name) + ".M_x"), sign * M_x, 1e-4) << name;
  }
}

/// The foot of the post lies in a node of the cube that the link moves, or in one that it
/// does not take along.
TEST(RigidLinks, nodes_that_a_link_joins_are_not_said_to_be_apart) {
  for (const bool is_linked : {true, false}) {
    GmshText file = cube_with_post();
    file.nodes[8] = file.nodes[is_linked ? 4 : 0];
    const TemporaryMesh mesh(file);
    testing::internal::CaptureStderr();
    fem_solver<3>(scene_of_post(mesh.path()));
    const std::string text = testing::internal::GetCapturedStderr();
    EXPECT_EQ(text.find("not joined") == std::string::npos, is_linked) << text;
  }
}

TEST(RigidLinks, turned_by_an_angle) {
  const Vector<3> turn(0.8, -0.5, 1.1);
  const Matrix<3> R = Eigen::AngleAxisd(turn.norm(), turn.normalized()).toRotationMatrix();
  const TemporaryMesh mesh(cube_with_post()), other(cube_with_post(R), 1);
  const Vector<3> tip = tip_of(*loaded(scene_of_post(mesh.path())));
  const Vector<3> turned = tip_of(*loaded(scene_of_post(other.path(), R)));
  EXPECT_LT((turned - R * tip).norm(), 1e-7 * tip.norm());
}

/// A block hangs on a slender post: the springs of the link move far with its end.
TEST(RigidLinks, a_block_at_the_end_of_a_slender_post) {
  const Vector<3> turn(0.8, -0.5, 1.1);
  const Matrix<3> turned = Eigen::AngleAxisd(turn.norm(), turn.normalized()).toRotationMatrix();
  for (const double width : {0.1, 0.03, 0.02}) {
    for (const Matrix<3>& R : {Matrix<3>(Matrix<3>::Identity()), turned}) {
      SCOPED_TRACE(width);
      const TemporaryMesh mesh(cube_with_post(R, 16));
      Json json = scene_of_post(mesh.path(), R);
      json["materials"][0]["cross_section"] = rectangle(width, width);
      json["materials"][1]["young_modulus"] = E;
      json["supports"] = {clamp(3, "high")};
      const double EI = E * std::pow(width, 4) / 12, F = 1e-3 * EI;
      json["loads"] = {rising_load(list(R * Vector<3>(F, 0, 0)))};
      json["loads"][0]["group"] = "plate";
      json["probes"][0]["point"] = list(Vector<3>::Zero());
      const auto solver = loaded(json);
      const Vector<3> expected = R * Vector<3>(F * L * L * L / 3 / EI, 0, 0);
      EXPECT_LT((tip_of(*solver) - expected).norm(), 0.02 * expected.norm());
    }
  }
}

/// A post that holds nothing else up and is thrown: no force acts between it and its cube.
TEST(RigidLinks, momentum_and_energy_of_a_free_structure) {
  const TemporaryMesh mesh(cube_with_post());
  Json json = scene_of_post(mesh.path());
  json.erase("supports");
  json["analysis"] = "dynamic";
  json["materials"][1]["young_modulus"] = E;
  json["loads"] = {
      {{"group", "high"}, {"force", {100, 30, 0}}, {"table", {{0, 1}, {0.05, 1}, {0.0501, 0}}}}};
  const auto solver = fem_solver<3>(json);
  for (int n = 1; n <= 50; ++n) advance(*solver, n, 0.001);
  const double impulse = probe(*solver, "momentum_x");
  for (int n = 51; n <= 150; ++n) advance(*solver, n, 0.001);
  EXPECT_NEAR(impulse, 100 * 0.05, 0.01 * impulse);
  EXPECT_NEAR(probe(*solver, "momentum_x"), impulse, 0.011 * impulse);
  const double stored = probe(*solver, "kinetic_energy") + probe(*solver, "elastic_energy");
  EXPECT_NEAR(stored, probe(*solver, "external_work"), 1e-3 * stored);
}

TEST(RigidLinks, restart_gives_the_same_bits) {
  const TemporaryMesh mesh(cube_with_post());
  Json json = scene_of_post(mesh.path());
  json["analysis"] = "dynamic";
  const auto run = fem_solver<3>(json), restarted = fem_solver<3>(json);
  for (int n = 1; n <= 10; ++n) advance(*run, n, 0.02);
  restarted->load_state(run->save_state());
  for (int n = 11; n <= 20; ++n) {
    advance(*run, n, 0.02);
    advance(*restarted, n, 0.02);
    EXPECT_EQ(restarted->probes(), run->probes()) << n;
  }
}

void expect_refused(const std::function<void(Json&)>& change, const Parts& parts) {
  const TemporaryMesh mesh(cube_with_post());
  Json json = scene_of_post(mesh.path());
  change(json);
  expect_error<ConfigError>([&] { fem_solver<3>(json); }, parts);
}

TEST(RigidLinks, refused) {
  const auto link = [](const Json& value) {
    return [value](Json& json) { json["rigid_links"] = value; };
  };
  expect_refused(link({{{"beam", "plate"}, {"group", "base"}}}),
                 {"/rigid_links/0/group", "\"plate\"", "4 nodes", "one node"});
  expect_refused(link({{{"beam", "foot"}, {"group", "nowhere"}}}),
                 {"/rigid_links/0/group", "\"nowhere\""});
  expect_refused(link({{{"beam", "foot"}, {"group", "foot"}}}),
                 {"/rigid_links/0/group", "\"foot\"", "without nodes"});
  expect_refused(
      link({{{"beam", "foot"}, {"group", "plate"}}, {{"beam", "high"}, {"group", "plate"}}}),
      {"/rigid_links/1/group", "\"plate\"", "another link"});
  expect_refused(
      link({{{"beam", "foot"}, {"group", "plate"}}, {{"beam", "high"}, {"group", "foot"}}}),
      {"/rigid_links/0/group", "\"foot\"", "chains"});
  expect_refused(link({{{"beam", "foot"}}}), {"/rigid_links/0", "group"});
  // Without the link nothing holds the post.
  expect_refused([](Json& json) { json.erase("rigid_links"); }, {"/mesh", "held by nothing"});
}

}  // namespace
}  // namespace gabion::test::test_rigid_links
