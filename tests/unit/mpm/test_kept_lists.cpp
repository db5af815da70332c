// SPDX-License-Identifier: BSD-3-Clause
// Lists that contact by facets keeps of nearby simplices, against lists that are made anew.
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "common/run/state.hpp"
#include "mpm_solver/contact/contact.hpp"
#include "mpm_solver/contact/facet_search.hpp"
#include "mpm_solver/contact/front_features.hpp"
#include "mpm_solver/contact/thin_pairs.hpp"
#include "tests/unit/mpm/soil_patch.hpp"

namespace gabion::test::test_kept_lists {
namespace {

using mpm::ContactSettings;
using mpm::ContactSurface;
using mpm::FacetSettings;
using mpm::Simplex;
using mpm::SurfaceFeature;

/// Rough ground over more than the unit box, with a step and ends inside of it.
template <int dim>
ContactSurface<dim> ground(int n, double height, double roughness, Random& random) {
  ContactSurface<dim> surface;
  const auto level = [&](double x) { return height + (x > 0.5 ? 0.1 : 0) + roughness * random(); };
  const auto at = [n](int i) { return -0.2 + 1.1 * i / n; };
  if constexpr (dim == 2) {
    for (int i = 0; i <= n; ++i) surface.vertices.emplace_back(at(i), level(at(i)));
    for (std::int32_t i = n; i > 0; --i) {
      surface.facets.insert(surface.facets.end(), {i, i - 1});
    }
  } else {
    surface.facet_type = CellType::tri3;
    for (int j = 0; j <= n; ++j) {
      for (int i = 0; i <= n; ++i) surface.vertices.emplace_back(at(i), at(j), level(at(i)));
    }
    for (std::int32_t j = 0; j < n; ++j) {
      for (std::int32_t i = 0; i < n; ++i) {
        const std::int32_t v = j * (n + 1) + i;
        for (const std::int32_t k : {v, v + 1, v + n + 2, v, v + n + 2, v + n + 1}) {
          surface.facets.push_back(k);
        }
      }
    }
  }
  return surface;
}

template <int dim>
double distance_to(const std::vector<Simplex<dim>>& simplices,
                   const std::vector<Vector<dim>>& vertices, std::int32_t s, const Vector<dim>& x) {
  const auto corners = mpm::corners_of<dim>(simplices[static_cast<std::size_t>(s)], vertices);
  return (mpm::closest_place<dim>(corners, x).x - x).norm();
}

/// An inclined facet of kilometres through the unit box, beside the others.
template <int dim>
void add_large_facet(ContactSurface<dim>& surface) {
  const auto first = static_cast<std::int32_t>(surface.vertices.size());
  if constexpr (dim == 2) {
    surface.vertices.insert(surface.vertices.end(), {{-5e3, -3e3}, {5e3, 3.0007e3}});
  } else {
    surface.vertices.insert(surface.vertices.end(),
                            {{-5e3, -5e3, -3e3}, {5e3, -5e3, 3e3}, {1, 6e3, 1.3}});
  }
  for (int k = 0; k < dim; ++k) surface.facets.push_back(first + k);
}

// Lists made at any time, while the surface goes on, have all simplices that are near.
template <int dim>
void check_lists(bool with_large) {
  Random random;
  auto surface = ground<dim>(dim == 2 ? 40 : 12, 0.3, 0.03, random);
  if (with_large) add_large_facet<dim>(surface);
  const double rounding = with_large ? 1e-9 : 1e-12;  // [m]
  const auto simplices = mpm::simplices(surface);
  auto vertices = surface.vertices;
  mpm::FacetSearch<dim> search;
  search.add_member(simplices.size());
  std::vector<std::int32_t> room;
  int kept = 0;
  for (int step = 0; step < 12; ++step) {
    search.begin_step(simplices, vertices, 0.1);
    search.make_ready();
    for (int k = 0; k < 200; ++k) {
      const Vector<dim> x = 0.5 * (random.vector<dim>() + Vector<dim>::Ones());
      const double within = search.reach() * (1 + random());
      const auto list = search.near(x, within, room);
      ASSERT_TRUE(std::is_sorted(list.begin(), list.end()));
      kept += within <= search.reach() ? 1 : 0;
      double nearest = std::numeric_limits<double>::infinity();
      for (std::int32_t s = 0; s < std::ssize(simplices); ++s) {
        const double distance = distance_to<dim>(simplices, vertices, s, x);
        nearest = std::min(nearest, distance);
        if (distance > within) continue;
        ASSERT_TRUE(std::binary_search(list.begin(), list.end(), s)) << "step " << step;
      }
      const Vector<dim> half = 0.02 * (random.vector<dim>() + Vector<dim>::Ones());
      const Vector<dim> middle = x + half.cwiseProduct(random.vector<dim>());
      ASSERT_LE(search.at_least(middle, half), nearest + rounding);
      ASSERT_LE(search.far_at_least(middle, half), nearest + rounding);
    }
    double path = 0;
    for (auto& x : vertices) {
      const Vector<dim> move = (step % 3 == 0 ? 0.0 : 0.003) * random.vector<dim>();
      x += move;
      path = std::max(path, move.norm());
    }
    search.add_motion(0, path);
  }
  EXPECT_GT(kept, 500);
}

TEST(kept_lists, have_all_that_is_near) {
  check_lists<2>(false);
  check_lists<3>(false);
}

/// A slope of few facets takes no memory for the space that it spans.
TEST(kept_lists, have_facets_of_kilometres) {
  check_lists<2>(true);
  check_lists<3>(true);
}

/// Rough ground, the same from below a little lower, and a facet that stands upright on it.
template <int dim>
std::vector<ContactSettings<dim>> slab_and_wall(double roughness, Random& random) {
  std::vector<ContactSettings<dim>> pieces(3);
  pieces[0].surface = ground<dim>(dim == 2 ? 12 : 8, 0.3, roughness, random);
  pieces[1].surface = pieces[0].surface;
  for (auto& x : pieces[1].surface.vertices) x[dim - 1] -= 0.1;
  auto& facets = pieces[1].surface.facets;
  for (std::size_t k = 0; k < facets.size(); k += dim) std::swap(facets[k], facets[k + 1]);
  auto& wall = pieces[2].surface;
  wall.facet_type = pieces[0].surface.facet_type;
  for (int k = 0; k < dim; ++k) {
    wall.vertices.push_back(Vector<dim>::Constant(0.3) + 0.4 * Vector<dim>::Unit((k + 1) % dim));
    wall.facets.push_back(k);
  }
  return pieces;
}

// Whether a face is behind another one along its normal.
template <int dim>
bool is_behind(const mpm::Faces<dim>& faces, std::size_t front, std::int32_t back) {
  const Vector<dim> through =
      faces.bounds[front].centre - faces.closest(back, faces.bounds[front].centre);
  return through.dot(faces.bounds[front].normal) >= 0.9 * through.norm();
}

// Faces whose normals tell that none looks away from them are passed over: pairs are those of all
// faces with each other, besides those of inner corners, where the one is not behind the other.
template <int dim>
void check_pairs(double roughness, std::size_t num_pieces) {
  Random random;
  const auto pieces = slab_and_wall<dim>(roughness, random);
  std::vector<mpm::StartSurface<dim>> surfaces;
  for (std::size_t k = 0; k < num_pieces; ++k) {
    surfaces.push_back({pieces[k], pieces[k].surface.vertices, true});
  }
  const mpm::Faces<dim> faces(surfaces);
  const double cell = 0.1;
  std::vector<std::array<std::int32_t, 2>> expected, found;
  for (std::int32_t s = 0; s < std::ssize(faces.simplices); ++s) {
    for (std::int32_t t = 0; t < std::ssize(faces.simplices); ++t) {
      const auto& front = faces.bounds[static_cast<std::size_t>(s)];
      if (front.normal.dot(faces.bounds[static_cast<std::size_t>(t)].normal) > -0.9) continue;
      const Vector<dim> through = front.centre - faces.closest(t, front.centre);
      if (!is_behind<dim>(faces, static_cast<std::size_t>(s), t)) continue;
      if (through.norm() < (1 - 1e-6) * 2 * cell) expected.push_back({s, t});
    }
  }
  for (const auto& pair : mpm::thin_pairs<dim>(faces, cell)) {
    if (!is_behind<dim>(faces, static_cast<std::size_t>(pair.front), pair.back)) continue;
    found.push_back({pair.front, pair.back});
  }
  std::ranges::sort(found);
  EXPECT_EQ(found, expected);
  EXPECT_EQ(found.empty(), num_pieces == 1);
}

TEST(kept_lists, pairs_of_faces_are_those_of_all) {
  for (const double roughness : {0.0, 0.01, 0.04}) {
    for (const std::size_t num_pieces : {1, 2, 3}) {
      check_pairs<2>(roughness, num_pieces);
      check_pairs<3>(roughness, num_pieces);
    }
  }
}

/// Ground that moves by a random displacement of this size [m].
template <int dim>
struct Ground {
  std::vector<Simplex<dim>> simplices;
  std::vector<Vector<dim>> start, end;
  std::vector<char> rim, at_rest;
  std::vector<mpm::Neighbours<dim>> neighbours;
  std::vector<mpm::SimplexBounds<dim>> bounds;
  double motion = 0, size = 0;

  Ground(double roughness, double moved, Random& random) {
    const auto surface = ground<dim>(dim == 2 ? 40 : 12, 0.3, roughness, random);
    simplices = mpm::simplices(surface);
    start = end = surface.vertices;
    for (auto& x : end) {
      const Vector<dim> move = moved * random.vector<dim>();
      x += move;
      motion = std::max(motion, move.norm());
    }
    rim = mpm::rim_vertices<dim>(simplices, start.size());
    at_rest = {moved == 0};
    neighbours = mpm::neighbours_of<dim>(simplices);
    bounds = mpm::bounds_of<dim>(simplices, start);
    for (const auto& of : bounds) size = std::max(size, 2 * of.radius);
  }
  mpm::FacingSurface<dim> faced(const std::vector<mpm::FacingSimplex>& facing) const {
    return {.simplices = simplices,
            .start = start,
            .end = end,
            .facing = facing,
            .rim = rim,
            .motion = motion,
            .size = size,
            .seam = 1e-4};
  }
};

/// A point that goes from x to y, with or without a contact before.
template <int dim>
struct Going {
  Vector<dim> x, y;
  std::vector<mpm::KnownContact<dim>> known;
  std::vector<mpm::FacingSimplex> facing;
  bool in_front = true;  // of the nearest simplex that it had contact with

  Going(const Ground<dim>& ground, Random& random) {
    x = 0.5 * (random.vector<dim>() + Vector<dim>::Ones());
    x[dim - 1] = 0.42 + 0.14 * random();
    y = x + 0.03 * random.vector<dim>();
    if (random() > 0) {
      known.push_back({0, (Vector<dim>::Unit(dim - 1) + 0.3 * random.vector<dim>()).normalized()});
    }
    double nearest = std::numeric_limits<double>::infinity();
    for (std::int32_t s = 0; s < std::ssize(ground.simplices); ++s) {
      const auto k = static_cast<std::size_t>(s);
      const Vector<dim>& n = ground.bounds[k].normal;
      const double height = (x - ground.start[ground.simplices[k][0]]).dot(n);
      const bool touched = !known.empty() && known[0].normal.dot(n) > mpm::same_normal;
      const double distance = distance_to<dim>(ground.simplices, ground.start, s, x);
      if (touched && distance < nearest) {
        nearest = distance;
        in_front = height > 0;
      }
      if (height > 0 || touched) facing.push_back({s, touched, height, distance});
    }
  }
};

template <int dim>
void expect_same(const std::vector<SurfaceFeature<dim>>& got,
                 const std::vector<SurfaceFeature<dim>>& expected) {
  ASSERT_EQ(got.size(), expected.size());
  for (std::size_t f = 0; f < got.size(); ++f) {
    EXPECT_EQ(got[f].simplex, expected[f].simplex);
    EXPECT_EQ(got[f].weights, expected[f].weights);
    EXPECT_EQ(got[f].x, expected[f].x);
    EXPECT_EQ(got[f].normal, expected[f].normal);
    EXPECT_EQ(got[f].distance, expected[f].distance);
  }
}

// A point looks at all simplices, or at those that are near: the same features to the bit.
template <int dim>
void check_features(double roughness, double moved) {
  Random random;
  const Ground<dim> ground(roughness, moved, random);
  int told = 0;
  std::size_t found = 0;
  for (int k = 0; k < 3000; ++k) {
    const Going<dim> point(ground, random);
    if (!point.in_front) continue;
    const auto all = ground.faced(point.facing);
    const mpm::FeatureReach reach{0.1 + 0.02 * random(), 0.06};
    const double path = (point.y - point.x).norm();
    // Listed around a place that the point was at before.
    const Vector<dim> place = point.y + 0.02 * random() * random.vector<dim>();
    const double nearer = (point.y - place).norm() + ground.motion;
    const double within = mpm::front_reach<dim>(all, reach, path) + nearer;
    std::vector<std::int32_t> near;
    for (std::int32_t s = 0; s < std::ssize(ground.simplices); ++s) {
      if (distance_to<dim>(ground.simplices, ground.start, s, place) <= within) near.push_back(s);
    }
    auto surface = all;
    const mpm::FrontView<dim> view{.surface = surface,
                                   .bounds = ground.bounds,
                                   .neighbours = ground.neighbours,
                                   .at_rest = ground.at_rest,
                                   .touched = point.known,
                                   .nearer = nearer,
                                   .margin = 10};
    std::vector<mpm::FacingSimplex> list;
    mpm::faced_near<dim>(view, point.x, {place, within, near}, list);
    surface.facing = list;
    std::vector<SurfaceFeature<dim>> expected, got;
    mpm::find_features<dim>(all, point.x, point.y, reach, expected);
    if (!mpm::features_in_front<dim>(view, point.x, point.y, reach, got)) continue;
    ++told;
    found += got.size();
    expect_same<dim>(got, expected);
    if (testing::Test::HasFailure()) return;
  }
  EXPECT_GT(told, 1000);
  EXPECT_GT(found, 1000U);
}

TEST(kept_lists, near_simplices_give_the_same_features) {
  for (const double roughness : {0.0, 0.01, 0.04}) {
    for (const double moved : {0.0, 0.002}) {
      check_features<2>(roughness, moved);
      check_features<3>(roughness, moved);
    }
  }
}

/// Soil that falls on ground, drawn along it and lifted, and on a plate that moves.
template <int dim>
class Falling {
 public:
  Falling(mpm::Basis basis, bool elastic)
      : soil_(dim == 2 ? CellType::quad4 : CellType::hex8, 6, basis), elastic_{elastic} {
    Random random;
    for (const double height : {0.02, 0.05}) {
      ContactSettings<dim>& settings = pieces_.emplace_back();
      settings.friction = 0.3;
      settings.method = FacetSettings{.penalty_factor = 50, .tangential_factor = 0.5};
      settings.surface = ground<dim>(dim == 2 ? 30 : 10, height, 0.01, random);
    }
    for (auto& x : pieces_[1].surface.vertices) x[0] = 0.3 * x[0] + 0.7;
    soil_.fill(dim == 2 ? 4 : 8);
    contact_ = fresh();
  }

  std::unique_ptr<mpm::Contact<dim>> fresh() const {
    return mpm::make_joint_contact<dim>({&pieces_[0], &pieces_[1]});
  }
  mpm::Contact<dim>& contact() { return *contact_; }

  void begin(mpm::Contact<dim>& contact) {
    soil_.to_grid();
    contact.begin_step({.grid = soil_.grid,
                        .nodes = soil_.nodes,
                        .points = soil_.points,
                        .weights = soil_.weights,
                        .cell_size = 1.0 / 6,
                        .dt = 1e-2,
                        .step_force_weight = 1,
                        .elastic = elastic_,
                        .moduli = moduli_});
  }
  // Nodal forces, then those on the surfaces.
  std::vector<double> forces(mpm::Contact<dim>& contact, double plate, const Vector<dim>& move) {
    for (std::size_t m = 0; m < 2; ++m) {
      std::vector<double> u(pieces_[m].surface.vertices.size() * dim, 0.0);
      for (std::size_t k = dim - 1; m == 1 && k < u.size(); k += dim) u[k] = plate;
      contact.set_displacement(u, m);
    }
    std::vector<double> r(soil_.num_dofs(), 0.0);
    contact.assembly().add_forces(displacement(move), r, nullptr);
    for (std::size_t m = 0; m < 2; ++m) {
      const auto on_surface = contact.results().forces_on_structure(m);
      r.insert(r.end(), on_surface.begin(), on_surface.end());
      r.push_back(contact.can_touch(m) ? 1 : 0);
    }
    r.push_back(contact.approach_step(1e-2, 0.01));
    return r;
  }
  void move_points(const Vector<dim>& move) {
    for (std::size_t p = 0; p < soil_.points.x.size(); ++p) soil_.points.x[p] += move;
  }

 private:
  std::vector<double> displacement(const Vector<dim>& move) const {
    std::vector<double> du;
    for (std::int32_t i = 0; i < soil_.nodes.size(); ++i) {
      Vector<dim> u = move;
      u[0] += 0.01 * soil_.node(i)[dim - 1];
      du.insert(du.end(), u.data(), u.data() + dim);
    }
    return du;
  }

  SoilPatch<dim> soil_;
  std::vector<char> elastic_;
  std::vector<double> moduli_{1e4};
  std::vector<ContactSettings<dim>> pieces_;
  std::unique_ptr<mpm::Contact<dim>> contact_;
};

/// How far plate and soil go in a step [m].
template <int dim>
struct Path {
  double plate;
  Vector<dim> move;
};

// Lists of a step that were made at other places, for soil that was farther or that outran them,
// give the same forces.
template <int dim>
void check_order(Falling<dim>& scene, const State& state, const std::vector<double>& first,
                 const Path<dim>& path) {
  const auto other = scene.fresh();
  StateReader reader(state);
  other->state().visit_state(reader, "contact.");
  scene.begin(*other);
  for (const double share : {4.0, 9.0}) {
    EXPECT_EQ(scene.forces(*other, path.plate, share * path.move),
              scene.forces(scene.contact(), path.plate, share * path.move));
    EXPECT_EQ(scene.forces(*other, path.plate, 0.5 * path.move), first);
  }
}

// A contact that keeps its lists through steps in which points and a plate move, against one that
// is made anew from its state at the start of each step.
template <int dim>
void check_steps(mpm::Basis basis, bool elastic) {
  Falling<dim> scene(basis, elastic);
  std::size_t loaded = 0;
  for (int step = 0; step < 16; ++step) {
    State state;
    StateWriter writer(state);
    scene.contact().state().visit_state(writer, "contact.");
    const auto anew = scene.fresh();
    StateReader reader(state);
    anew->state().visit_state(reader, "contact.");
    scene.begin(scene.contact());
    scene.begin(*anew);
    Vector<dim> move = Vector<dim>::Zero();
    move[0] = (step % 4 < 2 ? 0.012 : -0.012);
    move[dim - 1] = (step / 4 % 2 == 0 ? -0.007 : 0.007);
    const double plate = 0.004 * step;
    const auto first = scene.forces(scene.contact(), plate, 0.5 * move);
    check_order(scene, state, first, {plate, move});
    EXPECT_EQ(first, scene.forces(*anew, plate, 0.5 * move)) << "step " << step;
    const auto second = scene.forces(scene.contact(), 1.1 * plate, move);
    EXPECT_EQ(second, scene.forces(*anew, 1.1 * plate, move)) << "step " << step;
    EXPECT_EQ(first, scene.forces(scene.contact(), plate, 0.5 * move)) << "step " << step;
    EXPECT_EQ(second, scene.forces(scene.contact(), 1.1 * plate, move)) << "step " << step;
    loaded += static_cast<std::size_t>(
        std::ranges::count_if(first, [](double f) { return f != 0 && std::isfinite(f); }));
    scene.contact().accept();
    scene.move_points(move);
  }
  EXPECT_GT(loaded, 500U);
}

TEST(kept_lists, a_contact_made_anew_gives_the_same_bits) {
  for (const bool elastic : {false, true}) {
    for (const auto basis : {mpm::Basis::linear, mpm::Basis::gimp, mpm::Basis::bspline}) {
      check_steps<2>(basis, elastic);
    }
    check_steps<3>(mpm::Basis::gimp, elastic);
  }
}

}  // namespace
}  // namespace gabion::test::test_kept_lists
