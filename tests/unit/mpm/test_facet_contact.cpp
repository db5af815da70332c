// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include <cmath>

#include "mpm_solver/contact/contact.hpp"
#include "tests/unit/mpm/soil_patch.hpp"

namespace gabion::test::test_facet_contact {
namespace {

using mpm::ContactMode;
using mpm::ContactSettings;
using mpm::FacetSettings;

constexpr double modulus = 1e4;

const FacetSettings method{.penalty_factor = 50, .resting_factor = 12, .tangential_factor = 0.5};

/// A surface below soil that fills the unit box from `level` upwards: two facets, bent.
template <int dim>
ContactSettings<dim> floor_below(double level, double friction) {
  ContactSettings<dim> settings;
  settings.name = "floor";
  settings.friction = friction;
  settings.method = method;
  if constexpr (dim == 2) {
    settings.surface.vertices = {{1.2, level}, {0.45, level + 0.01}, {-0.2, level}};
    settings.surface.facets = {0, 1, 1, 2};
  } else {
    settings.surface.facet_type = CellType::tri3;
    settings.surface.vertices = {{-0.2, -0.2, level},
                                 {1.2, -0.2, level + 0.01},
                                 {1.2, 1.2, level},
                                 {-0.2, 1.2, level + 0.01}};
    settings.surface.facets = {0, 1, 2, 0, 2, 3};
  }
  return settings;
}

/// Soil whose lowest layer meets the surface.
template <int dim>
struct Met {
  SoilPatch<dim> soil;
  std::unique_ptr<mpm::Contact<dim>> contact;
  std::vector<char> elastic;
  std::vector<double> moduli{modulus};
  std::vector<double> weights{100};

  /// @param takes_weight  of the step, of 100 Pa
  Met(const ContactSettings<dim>& settings, CellType type, mpm::Basis basis, bool is_elastic,
      bool takes_weight = false)
      : soil(type, 3, basis), contact(make_contact(settings)), elastic{is_elastic} {
    soil.fill(type == CellType::tri3 ? 3 : dim == 2 || type == CellType::tet4 ? 4 : 8);
    soil.to_grid();
    contact->begin_step({.grid = soil.grid,
                         .nodes = soil.nodes,
                         .points = soil.points,
                         .weights = soil.weights,
                         .cell_size = 1.0 / 3,
                         .dt = 1e-3,
                         .step_force_weight = 1.7,
                         .elastic = elastic,
                         .moduli = moduli,
                         .takes_weight = takes_weight,
                         .weights_of = weights});
    contact->set_displacement(std::vector<double>(settings.surface.vertices.size() * dim, 0.0));
  }
};

/// K is -dr/du, by central differences.
template <int dim>
void check_stiffness(Met<dim>& met, const std::vector<double>& du) {
  const std::size_t n = met.soil.num_dofs();
  BlockMatrix<dim> K;
  std::vector<std::int32_t> offsets{0}, nodes;
  for (std::int32_t i = 0; i < met.soil.nodes.size(); ++i) nodes.push_back(i);
  offsets.push_back(met.soil.nodes.size());
  K.set_pattern(met.soil.nodes.size(), offsets, nodes);
  K.set_zero();
  std::vector<double> r(n, 0.0), plus(n), minus(n), column(n), unit(n, 0.0);
  met.contact->assembly().add_forces(du, r, &K);
  double largest = 0, worst = 0;
  for (std::size_t k = 0; k < n; ++k) {
    std::vector<double> shifted = du;
    constexpr double step = 1e-7;
    shifted[k] += step;
    std::fill(plus.begin(), plus.end(), 0.0);
    met.contact->assembly().add_forces(shifted, plus, nullptr);
    shifted[k] -= 2 * step;
    std::fill(minus.begin(), minus.end(), 0.0);
    met.contact->assembly().add_forces(shifted, minus, nullptr);
    std::fill(column.begin(), column.end(), 0.0);
    unit[k] = 1;
    K.multiply(unit, column);
    unit[k] = 0;
    for (std::size_t i = 0; i < n; ++i) {
      largest = std::max(largest, std::abs(column[i]));
      worst = std::max(worst, std::abs(column[i] + (plus[i] - minus[i]) / (2 * step)));
    }
  }
  EXPECT_GT(largest, 10);
  EXPECT_LT(worst, 1e-5 * largest);
}

template <int dim>
std::vector<double> pressed_down(Met<dim>& met, double along) {
  std::vector<double> du;
  for (std::int32_t i = 0; i < met.soil.nodes.size(); ++i) {
    Vector<dim> move = 1e-3 * met.soil.random.template vector<dim>();
    move[0] += along;
    move[dim - 1] -= 0.02;
    du.insert(du.end(), move.data(), move.data() + dim);
  }
  return du;
}

TEST(FacetContact, stiffness_is_the_derivative_of_the_force) {
  for_each_basis([]<int dim>(CellType type, mpm::Basis basis) {
    for (const bool elastic : {false, true}) {
      for (const double friction : {-1.0, 0.3}) {
        for (const double along : {1e-4, 0.05}) {
          Met<dim> met(floor_below<dim>(-0.005, friction), type, basis, elastic);
          const auto du = pressed_down(met, along);
          check_stiffness(met, du);
          EXPECT_GT(met.contact->results().counts().closed, 3);
          if (friction > 0 && along > 0.01) {
            EXPECT_GT(met.contact->results().counts().sliding, 0);
          }
        }
      }
    }
  });
}

TEST(FacetContact, stiffness_of_friction_that_falls_with_the_speed) {
  for_each_basis([]<int dim>(CellType type, mpm::Basis basis) {
    for (const double drag : {0.0, 0.3}) {
      ContactSettings<dim> settings = floor_below<dim>(-0.005, 0.3);
      settings.weakening = {.fall = 0.25, .speed = 40};
      settings.drag = drag;
      Met<dim> met(settings, type, basis, false);
      check_stiffness(met, pressed_down(met, 0.05));
      EXPECT_GT(met.contact->results().counts().sliding, 0);
    }
  });
}

/// At the pressure of the weight, 100 Pa, the law goes over into its tangent: at a depth of
/// 2 h 100 / (12 M) = 5.6e-4 m, far less than here.
TEST(FacetContact, stiffness_of_soil_that_took_its_weight) {
  for_each_basis([]<int dim>(CellType type, mpm::Basis basis) {
    for (const double friction : {-1.0, 0.3}) {
      Met<dim> met(floor_below<dim>(-0.005, friction), type, basis, false, true);
      check_stiffness(met, pressed_down(met, 0.05));
      EXPECT_GT(met.contact->results().counts().closed, 3);
    }
  });
}

/// Both sides get opposite forces; without friction opposite moments too, at the places where soil
/// and facets meet. The grid's nodes move with the step.
TEST(FacetContact, action_is_reaction) {
  for_each_basis([]<int dim>(CellType type, mpm::Basis basis) {
    Met<dim> met(floor_below<dim>(-0.005, 0.3), type, basis, true);
    const auto du = pressed_down(met, 0.05);
    std::vector<double> r(met.soil.num_dofs(), 0.0);
    met.contact->assembly().add_forces(du, r, nullptr);
    ForceAndMoment<dim> on_soil, on_structure;
    for (std::int32_t i = 0; i < met.soil.nodes.size(); ++i) {
      on_soil.add(met.soil.node(i), Eigen::Map<const Vector<dim>>(r.data() + i * dim) / 1.7);
    }
    const auto forces = met.contact->results().forces_on_structure();
    for (std::size_t k = 0; k < forces.size(); k += dim) {
      on_structure.force += Eigen::Map<const Vector<dim>>(forces.data() + k);
    }
    EXPECT_GT(on_soil.size, 1);
    EXPECT_LT((on_soil.force + on_structure.force).norm(), 1e-12 * on_soil.size);
    EXPECT_LT((met.contact->results().resultant().force - on_structure.force).norm(),
              1e-12 * on_soil.size);
  });
}

/// A gap is a distance: nothing acts before soil has come down by it, whatever the grid, then 50 M
/// times the square of the rest over the cell size, on the whole area.
TEST(FacetContact, force_begins_where_soil_touches) {
  for (const double gap : {0.0, 0.02, 0.11}) {
    ContactSettings<2> settings = floor_below<2>(-gap, -1);
    settings.surface.vertices[1][1] = -gap;
    for (const mpm::Basis basis : {mpm::Basis::linear, mpm::Basis::gimp, mpm::Basis::bspline}) {
      Met<2> met(settings, CellType::quad4, basis, true);
      for (const double deep : {-0.001, 0.001, 0.004}) {
        std::vector<double> du;
        for (std::int32_t i = 0; i < met.soil.nodes.size(); ++i) {
          du.insert(du.end(), {0, -gap - deep});
        }
        std::vector<double> r(met.soil.num_dofs(), 0.0);
        met.contact->assembly().add_forces(du, r, nullptr);
        // Points lie as deep as their rule says; their areas add up to V / (2 R).
        double area = 0;
        for (std::int32_t p = 0; p < met.soil.points.size(); ++p) {
          const double depth = met.soil.points.depth[p];
          if (met.soil.points.x[p][1] < 1.1 * depth) area += met.soil.points.V0[p] / (2 * depth);
        }
        const double depth = 3 * std::max(0.0, deep);
        EXPECT_NEAR(met.contact->results().resultant().force[1],
                    -50 * modulus * depth * depth * area, 1e-9)
            << gap << " " << deep;
      }
    }
  }
}

/// Soil in the corner of two facets that meet at an angle; turned by less than a degree they push
/// as one facet does, whatever soil is deeper in.
TEST(FacetContact, inside_corners_push_by_the_shortest_way_out) {
  for (const double turn : {1e-6, 1e-3, 0.3, M_PI / 2}) {
    ContactSettings<2> settings;
    settings.name = "corner";
    settings.friction = 0.2;
    settings.method = method;
    // Through (0.08, 0): a floor to the right of it, to the left one that rises by `turn`.
    const Vector<2> corner(0.08, 0), left = corner + Vector<2>(-std::cos(turn), std::sin(turn));
    settings.surface.vertices = {{1.2, 0}, corner, left};
    settings.surface.facets = {0, 1, 1, 2};
    Met<2> met(settings, CellType::quad4, mpm::Basis::linear, false);
    double before = 0, largest = 0, jump = 0;
    for (int k = 0; k <= 4000; ++k) {
      std::vector<double> du;
      for (std::int32_t i = 0; i < met.soil.nodes.size(); ++i) {
        du.insert(du.end(), {-0.01 + 5e-6 * k, -0.01});
      }
      std::vector<double> r(met.soil.num_dofs(), 0.0);
      met.contact->assembly().add_forces(du, r, nullptr);
      const double force = met.contact->results().resultant().force.norm();
      if (k > 0) jump = std::max(jump, std::abs(force - before));
      largest = std::max(largest, force);
      before = force;
    }
    EXPECT_GT(largest, 10) << turn;
    EXPECT_LT(jump, 5e-3 * largest) << turn;
    Met<2> again(settings, CellType::quad4, mpm::Basis::linear, true);
    check_stiffness(again, pressed_down(again, 0.01));
    Met<2> at_rest(settings, CellType::quad4, mpm::Basis::linear, true, true);
    check_stiffness(at_rest, pressed_down(at_rest, 0.01));
  }
}

/// Largest change of the contact force on the grid between places of a sheared block that is drawn
/// over an inward bend.
double largest_change(const ContactSettings<2>& settings, mpm::Basis basis, bool elastic,
                      int num_places) {
  Met<2> met(settings, CellType::quad4, basis, elastic);
  const Matrix<2> H = (Matrix<2>() << 0.02, 0.05, -0.03, 0.04).finished();
  std::vector<double> before, force;
  double largest = 0;
  for (int k = 0; k <= num_places; ++k) {
    std::vector<double> du;
    for (std::int32_t i = 0; i < met.soil.nodes.size(); ++i) {
      const Vector<2> move = H * met.soil.node(i) + Vector<2>(0.4 * k / num_places, -0.02);
      du.insert(du.end(), move.data(), move.data() + 2);
    }
    force.assign(du.size(), 0.0);
    met.contact->assembly().add_forces(du, force, nullptr);
    for (std::size_t i = 0; k > 0 && i < force.size(); ++i) {
      largest = std::max(largest, std::abs(force[i] - before[i]));
    }
    std::swap(before, force);
  }
  return largest;
}

TEST(FacetContact, force_is_continuous_over_an_inward_bend) {
  for (const double friction : {-1.0, 0.3}) {
    ContactSettings<2> settings = floor_below<2>(0.02, friction);
    settings.surface.vertices = {{2, 0.02}, {0.45, 0.01}, {-0.2, 0.02}};
    for (const mpm::Basis basis : {mpm::Basis::linear, mpm::Basis::gimp, mpm::Basis::bspline}) {
      for (const bool elastic : {false, true}) {
        const double coarse = largest_change(settings, basis, elastic, 500);
        EXPECT_GT(coarse, 0.01);
        EXPECT_LT(largest_change(settings, basis, elastic, 8000), coarse / 8)
            << static_cast<int>(basis) << elastic << friction;
      }
    }
  }
}

/// Tension does not exist, and nothing of the force is left when the surface goes away.
TEST(FacetContact, a_plate_that_is_pulled_off_leaves_no_force) {
  ContactSettings<2> settings = floor_below<2>(0, 0.3);
  Met<2> met(settings, CellType::quad4, mpm::Basis::linear, true);
  const std::vector<double> du(met.soil.num_dofs(), 0.0);
  std::vector<double> r(met.soil.num_dofs(), 0.0);
  met.contact->set_displacement({{0, 0.01, 0, 0.01, 0, 0.01}});
  met.contact->assembly().add_forces(du, r, nullptr);
  EXPECT_LT(met.contact->results().resultant().force[1], -1);
  met.contact->set_displacement({{0, -0.02, 0, -0.02, 0, -0.02}});
  met.contact->assembly().add_forces(du, r, nullptr);
  EXPECT_EQ(met.contact->results().resultant().force, (Vector<2>::Zero()));
  EXPECT_EQ(met.contact->results().counts().closed, 0);
}

}  // namespace
}  // namespace gabion::test::test_facet_contact
