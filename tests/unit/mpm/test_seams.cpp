// SPDX-License-Identifier: BSD-3-Clause
// Surfaces that meet, for contact by facets.
#include <algorithm>
#include <cmath>
#include <numbers>

#include "mpm_solver/contact/contact.hpp"
#include "tests/unit/mpm/mpm_scene.hpp"
#include "tests/unit/mpm/soil_patch.hpp"

namespace gabion::test::test_seams {
namespace {

using mpm::ContactSettings;
using mpm::FacetSettings;

constexpr double modulus = 1e4;

template <int dim>
using Pieces = std::vector<ContactSettings<dim>>;

ContactSettings<2> piece(const std::vector<Vector<2>>& line, double friction = 0.3) {
  ContactSettings<2> settings;
  settings.friction = friction;
  settings.method = FacetSettings{.penalty_factor = 50, .tangential_factor = 0.5};
  settings.surface.vertices = line;
  for (std::int32_t k = 0; k + 1 < std::ssize(line); ++k) {
    settings.surface.facets.insert(settings.surface.facets.end(), {k, k + 1});
  }
  return settings;
}

/// Triangles over a grid of stations in two directions.
ContactSettings<3> sheet(const std::vector<Vector<3>>& along, const std::vector<double>& across,
                         double friction = 0.3) {
  ContactSettings<3> settings;
  settings.friction = friction;
  settings.method = FacetSettings{.penalty_factor = 50, .tangential_factor = 0.5};
  settings.surface.facet_type = CellType::tri3;
  const auto m = static_cast<std::int32_t>(across.size());
  for (const Vector<3>& x : along) {
    for (const double y : across) settings.surface.vertices.push_back(x + Vector<3>(0, y, 0));
  }
  for (std::int32_t i = 0; i + 1 < std::ssize(along); ++i) {
    for (std::int32_t j = 0; j + 1 < m; ++j) {
      const std::int32_t v = i * m + j;
      for (const std::int32_t k : {v, v + 1, v + m + 1, v, v + m + 1, v + m}) {
        settings.surface.facets.push_back(k);
      }
    }
  }
  return settings;
}

/// Soil in the unit box, sheared, is drawn over surfaces that are at rest.
template <int dim>
class Drawn {
 public:
  explicit Drawn(const Pieces<dim>& pieces, bool elastic = false)
      : soil_(dim == 2 ? CellType::quad4 : CellType::hex8, 3), elastic_{elastic} {
    std::vector<const ContactSettings<dim>*> members;
    for (const auto& of : pieces) members.push_back(&of);
    contact_ = make_joint_contact<dim>(members);
    soil_.fill(dim == 2 ? 4 : 8);
    soil_.to_grid();
    contact_->begin_step({.grid = soil_.grid,
                          .nodes = soil_.nodes,
                          .points = soil_.points,
                          .weights = soil_.weights,
                          .cell_size = 1.0 / 3,
                          .dt = 1e-3,
                          .step_force_weight = 1,
                          .elastic = elastic_,
                          .moduli = moduli_});
    for (std::size_t k = 0; k < pieces.size(); ++k) {
      contact_->set_displacement(std::vector<double>(pieces[k].surface.vertices.size() * dim), k);
    }
  }

  /// Forces on the nodes when soil has moved so.
  std::vector<double> forces(const Vector<dim>& move) {
    Matrix<dim> H = Matrix<dim>::Zero();
    H(0, dim - 1) = 0.05;
    H(dim - 1, 0) = -0.03;
    std::vector<double> du;
    for (std::int32_t i = 0; i < soil_.nodes.size(); ++i) {
      const Vector<dim> u = H * soil_.node(i) + move;
      du.insert(du.end(), u.data(), u.data() + dim);
    }
    std::vector<double> r(du.size(), 0.0);
    contact_->assembly().add_forces(du, r, nullptr);
    return r;
  }
  mpm::Contact<dim>& contact() { return *contact_; }

 private:
  SoilPatch<dim> soil_;
  std::vector<char> elastic_;
  std::vector<double> moduli_{modulus};
  std::unique_ptr<mpm::Contact<dim>> contact_;
};

/// The largest difference of forces between surfaces that are cut in different ways, over their
/// largest force, on a path along x.
template <int dim>
double difference(const Pieces<dim>& one, const Pieces<dim>& other, double down) {
  Drawn<dim> a(one), b(other);
  double largest = 0, worst = 0;
  for (int k = 0; k <= (dim == 2 ? 400 : 60); ++k) {
    Vector<dim> move = down * Vector<dim>::Unit(dim - 1);
    move[0] = -0.2 + 0.4 * k / (dim == 2 ? 400 : 60);
    const auto f = a.forces(move), g = b.forces(move);
    for (std::size_t i = 0; i < f.size(); ++i) {
      largest = std::max(largest, std::abs(f[i]));
      worst = std::max(worst, std::abs(f[i] - g[i]));
    }
  }
  EXPECT_GT(largest, 1);
  return worst / largest;
}

/// A floor that bends by an angle at `at`, upwards to the left where it is positive.
struct Bend {
  Vector<2> at{0.12, 0.005};
  double angle = 0;

  Vector<2> right(double s) const { return at + Vector<2>(s, 0); }
  Vector<2> left(double s) const { return at + s * Vector<2>(-std::cos(angle), std::sin(angle)); }
};

/// The largest difference of forces between surfaces in one contact and in one for each of them,
/// over their largest force.
template <int dim>
double difference_from_apart(const Pieces<dim>& pieces, double down) {
  Drawn<dim> joint(pieces);
  std::vector<std::unique_ptr<Drawn<dim>>> apart;
  for (const auto& of : pieces) apart.push_back(std::make_unique<Drawn<dim>>(Pieces<dim>{of}));
  double largest = 0, worst = 0;
  for (int k = 0; k <= 40; ++k) {
    Vector<dim> move = down * Vector<dim>::Unit(dim - 1);
    move[0] = -0.2 + 0.01 * k;
    const auto f = joint.forces(move);
    std::vector<double> g(f.size());
    for (const auto& of : apart) {
      const auto own = of->forces(move);
      for (std::size_t i = 0; i < f.size(); ++i) g[i] += own[i];
    }
    for (std::size_t i = 0; i < f.size(); ++i) {
      largest = std::max(largest, std::abs(f[i]));
      worst = std::max(worst, std::abs(f[i] - g[i]));
    }
  }
  EXPECT_GT(largest, 1);
  return worst / largest;
}

TEST(Seams, in_the_plane_equal_one_surface) {
  for (const double degrees : {0.0, 1.0, 20.0, 45.0, -1.0, -20.0, -45.0, -90.0}) {
    const Bend bend{.angle = degrees * std::numbers::pi / 180};
    const Pieces<2> one = {piece({bend.right(1), bend.at, bend.left(1)})};
    const Pieces<2> two = {piece({bend.right(1), bend.at}), piece({bend.at, bend.left(1)})};
    EXPECT_LT(difference<2>(one, two, -0.02), 1e-12) << degrees;
    const Pieces<2> turned = {two[1], two[0]};
    EXPECT_LT(difference<2>(one, turned, -0.02), 1e-12) << degrees;
  }
}

TEST(Seams, in_the_plane_with_other_vertices_gaps_and_overlaps) {
  constexpr double cell = 1.0 / 3;
  for (const double degrees : {0.0, 45.0, -45.0}) {
    const Bend bend{.angle = degrees * std::numbers::pi / 180};
    const Pieces<2> one = {piece({bend.right(1), bend.at, bend.left(1)})};
    for (const double gap : {1e-9 * cell, 1e-6 * cell, -1e-9 * cell, -1e-6 * cell}) {
      const Pieces<2> apart = {piece({bend.right(1), bend.right(0.21), bend.right(gap)}),
                               piece({bend.at, bend.left(0.13), bend.left(1)})};
      EXPECT_LT(difference<2>(one, apart, -0.02), 300 * std::abs(gap)) << degrees << " " << gap;
    }
  }
  const auto flat = [](std::vector<double> stations) {
    std::vector<Vector<2>> line;
    for (const double x : stations) line.emplace_back(x, 0.005);
    return piece(line);
  };
  const Pieces<2> one = {flat({1.4, -0.4})};
  const Pieces<2> many = {flat({1.4, 0.9}), flat({0.9, 0.7, 0.65}), flat({0.65, 0.3}),
                          flat({0.3, 0.25}), flat({0.25, -0.4})};
  EXPECT_LT(difference<2>(one, many, -0.02), 1e-12);
  EXPECT_LT(difference<2>(one, {flat({1.4, 0.3}), flat({0.6, -0.4})}, -0.02), 1e-12);  // overlap
}

/// The rim of a slope on the middle of a floor, and a surface that ends where it began.
TEST(Seams, of_a_rim_on_a_face_and_of_a_closed_line) {
  const Bend bend{.angle = 0.35};
  const Pieces<2> one = {piece({bend.right(1), bend.at, bend.left(1)})};
  const Pieces<2> on_face = {piece({bend.right(1), bend.right(-0.6)}),
                             piece({bend.at, bend.left(1)})};
  EXPECT_LT(difference<2>(one, on_face, -0.02), 1e-12);
  const Vector<2> a(0.45, 0.005), b(-0.4, 0.005), c(-0.4, -1), d(1.4, -1), e(1.4, 0.005);
  EXPECT_LT(difference<2>({piece({e, a, b, c, d, e})}, {piece({a, b, c, d, e, a})}, -0.02), 1e-12);
}

/// In a corner that the soil lies in, each of two surfaces pushes as if it were alone.
TEST(Seams, of_a_corner_are_none) {
  const auto place = [](const Vector<2>& x) { return Vector<3>(x[0], 0, x[1]); };
  for (const double degrees : {60.0, 80.0, 90.0}) {
    const Bend bend{.angle = degrees * std::numbers::pi / 180};
    const auto floor = piece({bend.right(1), bend.at}), wall = piece({bend.at, bend.left(1)});
    EXPECT_LT(difference_from_apart<2>({floor, wall}, -0.02), 1e-12) << degrees;
    const auto under = piece({bend.right(1), bend.right(-0.4)});
    EXPECT_LT(difference_from_apart<2>({under, wall}, -0.02), 1e-12) << degrees;
    const auto below = piece({bend.left(-0.2), bend.left(0.6), bend.left(1)});
    EXPECT_LT(difference_from_apart<2>({floor, below}, -0.02), 1e-12) << degrees;
    const std::vector<double> rows = {-0.3, 0.2, 0.55, 1.3};
    const auto right = place(bend.right(1)), middle = place(bend.at), left = place(bend.left(1));
    EXPECT_LT(difference_from_apart<3>({sheet({right, middle}, rows), sheet({middle, left}, rows)},
                                       -0.02),
              1e-12)
        << degrees;
  }
}

TEST(Seams, in_space_equal_one_surface) {
  const std::vector<double> rows = {-0.3, 0.2, 0.55, 1.3}, others = {-0.3, 0.4, 1.3};
  for (const double degrees : {0.0, 1.0, 45.0, -45.0, -90.0}) {
    const Bend bend{.angle = degrees * std::numbers::pi / 180};
    const auto place = [](const Vector<2>& x) { return Vector<3>(x[0], 0, x[1]); };
    const auto right = place(bend.right(1)), middle = place(bend.at), left = place(bend.left(1));
    const Pieces<3> one = {sheet({right, middle, left}, rows)};
    const Pieces<3> same = {sheet({right, middle}, rows), sheet({middle, left}, rows)};
    EXPECT_LT(difference<3>(one, same, -0.02), 1e-12) << degrees;
    const Pieces<3> split = {sheet({right, middle}, rows), sheet({middle, left}, others)};
    EXPECT_LT(difference<3>(one, split, -0.02), 1e-9) << degrees;
  }
}

/// A step comes up at a seam: its edge pushes more and more, without a jump.
TEST(Seams, open_without_a_jump) {
  for (const double sign : {1.0, -1.0}) {
    const Pieces<2> pieces = {piece({{1.4, 0.005}, {0.45, 0.005}}),
                              piece({{0.45, 0.005}, {-0.4, 0.005}})};
    Drawn<2> soil(pieces);
    double before = 0, largest = 0, jump = 0;
    for (int k = 0; k <= 2000; ++k) {
      const double up = sign * 2e-5 * k;
      soil.contact().set_displacement(std::vector<double>{0, up, 0, up}, 1);
      const auto f = soil.forces({0.04, -0.02});
      double size = 0;
      for (std::size_t i = 0; i < f.size(); i += 2) size += f[i];
      if (k > 0) jump = std::max(jump, std::abs(size - before));
      largest = std::max(largest, std::abs(size));
      before = size;
    }
    EXPECT_GT(largest, 0.5);
    EXPECT_LT(jump, 0.01 * largest) << sign;
  }
}

/// Each facet keeps its friction, and the force on it.
TEST(Seams, each_side_has_its_own_friction) {
  const Pieces<2> pieces = {piece({{1.4, 0.005}, {0.45, 0.005}}, 0.2),
                            piece({{0.45, 0.005}, {-0.4, 0.005}}, 0)};
  Drawn<2> soil(pieces);
  soil.forces({0.3, -0.02});
  const auto rough = soil.contact().results().resultant(0).force,
             smooth = soil.contact().results().resultant(1).force;
  EXPECT_LT(rough[1], -1);
  EXPECT_LT(smooth[1], -1);
  EXPECT_NEAR(rough[0], -0.2 * rough[1], 1e-9);
  EXPECT_NEAR(smooth[0], 0, 1e-9);
  EXPECT_EQ(soil.contact().results().forces_on_structure(0).size(), 4u);
  EXPECT_GT(soil.contact().results().counts(0).sliding, 0);
}

/// Members with the soil between them push each for itself, as jaws.
TEST(Seams, jaws_push_each_for_itself) {
  const auto lower = piece({{1.4, 0.005}, {-0.4, 0.005}}, 0);
  const auto upper = piece({{-0.4, 0.17}, {1.4, 0.17}}, 0);
  const Vector<2> move(0.01, -0.02);
  Drawn<2> below({lower}), above({upper}), both({lower, upper});
  const auto f = below.forces(move), g = above.forces(move), h = both.forces(move);
  double largest = 0;
  for (std::size_t i = 0; i < h.size(); ++i) {
    largest = std::max(largest, std::abs(h[i]));
    EXPECT_NEAR(h[i], f[i] + g[i], 1e-12);
  }
  EXPECT_GT(largest, 1);
}

Json sand_on(const std::vector<std::vector<std::vector<double>>>& lines) {
  Json sand = elastic_soil("mohr_coulomb", 2e6, 0.3, 1500);
  sand["friction_angle"] = 30;
  Json json = {
      {"dimension", 2},
      {"grid", box({-0.1, -0.1}, {1.4, 0.5}, {30, 12}, "quad4")},
      {"gravity", {0, -9.81}},
      {"time_integration", {{"scheme", "explicit"}}},
      {"bodies", {body("sand", box({0.1, 0}, {0.4, 0.15}, {6, 3}, "quad4"), 4, sand, {2, 0})}}};
  for (std::size_t k = 0; k < lines.size(); ++k) {
    json["rigid_walls"].push_back({{"name", "floor_" + std::to_string(k)},
                                   {"mode", "slip"},
                                   {"surface", {{"polyline", lines[k]}, {"spacing", 0.05}}}});
  }
  return json;
}

/// Mean speed after 0.3 s: the sand has crossed x = 0.5 m.
double speed_over(const std::vector<std::vector<std::vector<double>>>& lines) {
  const auto solver = make_mpm(sand_on(lines));
  run_steps(*solver, 0.005, 60);
  return probe(*solver, "momentum_x") / probe(*solver, "mass");
}

TEST(Seams, sand_keeps_its_speed_on_a_floor_in_pieces) {
  const double whole = speed_over({{{1.4, 0}, {-0.1, 0}}});
  EXPECT_NEAR(whole, 2, 1e-9);
  EXPECT_NEAR(speed_over({{{1.4, 0}, {0.5, 0}}, {{0.5, 0}, {-0.1, 0}}}), 2, 1e-9);
  EXPECT_NEAR(
      speed_over({{{1.4, 0}, {0.713, 0}}, {{0.713, 0}, {0.481, 0}}, {{0.481, 0}, {-0.1, 0}}}), 2,
      1e-9);
}

/// Sand is thrown into the corner between a floor and a wall. The floor is in one piece or in two.
TEST(Seams, sand_in_a_corner_gains_no_energy) {
  using Lines = std::vector<std::vector<std::vector<double>>>;
  const std::vector<std::vector<double>> wall = {{0.63, 0.45}, {0.63, 0}};
  std::vector<double> speeds;
  for (const Lines& lines : {Lines{{{0.63, 0}, {-0.1, 0}}, wall},
                             Lines{{{0.63, 0}, {0.55, 0}}, {{0.55, 0}, {-0.1, 0}}, wall}}) {
    Json json = sand_on(lines);
    for (auto& of : json["rigid_walls"]) {
      of["mode"] = "contact";
      of["friction"] = 0.3;
    }
    json.erase("time_integration");
    const auto solver = make_mpm(json);
    const double start = probe(*solver, "kinetic_energy");
    run_steps(*solver, 0.002, 75);
    EXPECT_LT(probe(*solver, "contact_created"), 1e-9 * start);
    EXPECT_GT(probe(*solver, "contact_loss"), 1e-3 * start);  // it hit the wall
    speeds.push_back(probe(*solver, "momentum_x") / probe(*solver, "mass"));
  }
  EXPECT_NEAR(speeds[0], speeds[1], 1e-6);
}

/// The middle of the floor is a structure that does not move; its forces are its own.
TEST(Seams, sand_slides_over_a_structure_flush_in_a_floor) {
  Json json = sand_on({{{1.4, 0}, {0.9, 0}}, {{0.5, 0}, {-0.1, 0}}});
  json["interfaces"] = {{{"name", "slab"},
                         {"mode", "slip"},
                         {"surface", {{"polyline", {{0.9, 0}, {0.5, 0}}}, {"spacing", 0.07}}}}};
  const auto solver = make_mpm(json);
  double largest = 0;
  for (int n = 1; n <= 60; ++n) {
    const StepRequest request{n, 0, (n - 1) * 0.005, 0.005};
    InterfaceValues sent;
    solver->solve_step(request, {}, sent);
    solver->accept_step(request, true);
    for (const double f : sent.at("slab")) largest = std::max(largest, std::abs(f));
  }
  EXPECT_NEAR(probe(*solver, "momentum_x") / probe(*solver, "mass"), 2, 1e-9);
  EXPECT_GT(largest, 10);
}

}  // namespace
}  // namespace gabion::test::test_seams
