// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include <optional>

#include "mpm_solver/step/equilibrium.hpp"
#include "tests/support/check_tangent.hpp"
#include "tests/unit/mpm/soil_patch.hpp"

namespace gabion::test::test_equilibrium {
namespace {

/// One balance of momentum with everything it refers to.
template <int dim>
struct Balance {
  SoilPatch<dim> soil;
  mpm::Contacts<dim> contacts;
  mpm::TrialPoints<dim> trial;
  NewmarkBossak scheme = NewmarkBossak::bossak(-0.1);
  std::optional<mpm::WallConditions<dim>> walls;
  std::optional<mpm::Equilibrium<dim>> equilibrium;
  std::optional<mpm::GhostStiffness<dim>> ghost;
  BlockMatrix<dim> K;

  Balance(CellType type, int cells, int points_per_cell, const MaterialLaw<dim>& law,
          mpm::Basis basis = mpm::Basis::linear)
      : soil(type, cells, basis) {
    soil.fill(points_per_cell, 0.5);
    soil.bodies = {{"soil", {"", 0.5, law}}};
    if (basis != mpm::Basis::linear) {  // so that domains reach beyond the cell
      for (auto& x : soil.points.x) x += 0.15 / cells * soil.random.template vector<dim>();
    }
    for (auto& v : soil.points.v) v = 0.1 * soil.random.template vector<dim>();
    for (auto& a : soil.points.a) a = soil.random.template vector<dim>();
  }
  /// All points start under the pressure that b = 1 - squeeze gives.
  void squeeze(double squeeze) {
    for (auto& history : soil.points.history) history.e.template head<3>().setConstant(-squeeze);
  }
  bool with_inertia = true;
  double same_strain = 0;  ///< 0: every evaluation computes the stresses anew
  void start(const std::vector<mpm::WallSettings>& wall_settings = {}) {
    soil.to_grid();
    walls.emplace(soil.grid, wall_settings);
    walls->select(soil.nodes);
    const auto occupied = soil.occupied();
    for (const auto& contact : contacts) {
      contact->begin_step({.grid = soil.grid,
                           .nodes = soil.nodes,
                           .points = soil.points,
                           .weights = soil.weights,
                           .occupied = &occupied});
    }
    if (ghost) {
      ghost->find_facets(soil.owners(), soil.points, soil.weights);
      ghost->begin_step(soil.nodes);
    }
    const Vector<dim> gravity = Vector<dim>::Constant(-3.0);
    const typename mpm::Equilibrium<dim>::Parts parts{.comm = comm(),
                                                      .grid = soil.grid,
                                                      .bodies = soil.bodies,
                                                      .points = soil.points,
                                                      .weights = soil.weights,
                                                      .nodes = soil.nodes,
                                                      .walls = *walls,
                                                      .contacts = contacts,
                                                      .trial = trial,
                                                      .scheme = scheme,
                                                      .gravity = gravity,
                                                      .gravity_start = gravity,
                                                      .cell_size = 1.0 / 3,
                                                      .same_strain = same_strain,
                                                      .dt = 0.1,
                                                      .with_inertia = with_inertia,
                                                      .ghost = ghost ? &*ghost : nullptr};
    equilibrium.emplace(parts);
    std::vector<std::int32_t> offsets, nodes;
    equilibrium->pattern(offsets, nodes);
    K.set_pattern(soil.nodes.size(), offsets, nodes);
  }
  Eigen::VectorXd residual(Eigen::VectorXd du, BlockMatrix<dim>* matrix = nullptr) {
    const std::span<double> span(du.data(), static_cast<std::size_t>(du.size()));
    walls->project(span);
    Eigen::VectorXd r(du.size());
    const auto result =
        equilibrium->evaluate(span, {r.data(), static_cast<std::size_t>(r.size())}, matrix);
    EXPECT_TRUE(result.admissible) << result.reason;
    return r;
  }
  Eigen::VectorXd random_du(double size) {
    const auto values = soil.random.values(soil.num_dofs(), size);
    return Eigen::Map<const Eigen::VectorXd>(values.data(),
                                             static_cast<Eigen::Index>(values.size()));
  }
  /// Error of K against differences of the residual, over the directions that the walls leave free.
  double error(const Eigen::VectorXd& du, double h) {
    residual(du, &K);
    const Eigen::Index n = du.size();
    Eigen::MatrixXd tangent(n, n);
    for (Eigen::Index k = 0; k < n; ++k) {
      Eigen::VectorXd unit = Eigen::VectorXd::Unit(n, k), column(n);
      walls->project({unit.data(), static_cast<std::size_t>(n)});
      K.multiply({unit.data(), static_cast<std::size_t>(n)},
                 {column.data(), static_cast<std::size_t>(n)});
      tangent.col(k) = column;
    }
    return tangent_error([&](const Eigen::VectorXd& x) { return Eigen::VectorXd(-residual(x)); },
                         du, tangent, h);
  }
};

const NeoHookean<2> neo_hookean_2d{4e3, 3e3};
const NeoHookean<3> neo_hookean_3d{4e3, 3e3};

int regular_points(CellType type) {
  return type == CellType::tri3 ? 3 : type == CellType::hex8 ? 8 : 4;
}

TEST(EquilibriumTangent, neo_hookean) {
  for_each_basis([]<int dim>(CellType type, mpm::Basis basis) {
    Balance<dim> balance(type, dim == 2 ? 3 : 2, regular_points(type), NeoHookean<dim>{4e3, 3e3},
                         basis);
    balance.squeeze(0.05);
    balance.start();
    EXPECT_LT(balance.error(balance.random_du(0.02), 1e-4), 1e-8) << name(type);
  });
}

/// The share of old forces is constant in the step, but it changes the weight of the inertia.
TEST(EquilibriumTangent, averaged_forces) {
  for_each_cell_type([]<int dim>(CellType type) {
    Balance<dim> balance(type, 2, regular_points(type), NeoHookean<dim>{4e3, 3e3});
    balance.scheme = NewmarkBossak::generalized_alpha(0.7);
    balance.squeeze(0.05);
    balance.start();
    EXPECT_LT(balance.error(balance.random_du(0.02), 1e-4), 1e-8) << name(type);
  });
}

/// Forces of the accepted stresses are those that a step without motion evaluates.
TEST(InternalForces, start_forces_are_those_of_no_motion) {
  for_each_cell_type([]<int dim>(CellType type) {
    Balance<dim> balance(type, dim == 2 ? 3 : 2, regular_points(type), NeoHookean<dim>{4e3, 3e3});
    for (auto& history : balance.soil.points.history) {
      history.e = 0.05 * Symmetric<dim>::NullaryExpr([&] { return balance.soil.random(); });
    }
    balance.start();
    balance.residual(Eigen::VectorXd::Zero(static_cast<Eigen::Index>(balance.soil.num_dofs())));
    const auto& weights = balance.soil.weights;
    for (std::size_t e = 0; e < weights.point.size(); ++e) {
      balance.soil.points.tau[weights.point[e]] = balance.trial.tau[e];
    }
    const auto& at_rest = balance.equilibrium->internal_forces().forces();
    const auto start = balance.equilibrium->internal_forces().start_forces();
    double error = 0, size = 0;
    for (std::size_t k = 0; k < start.size(); ++k) {
      error = std::max(error, std::abs(start[k] - at_rest[k]));
      size = std::max(size, std::abs(start[k]));
    }
    EXPECT_LT(error, 1e-13 * size) << name(type);
    EXPECT_GT(size, 1);
  });
}

TEST(EquilibriumTangent, mohr_coulomb_while_yielding) {
  for_each_basis([]<int dim>(CellType type, mpm::Basis basis) {
    Balance<dim> balance(type, dim == 2 ? 3 : 2, regular_points(type),
                         MohrCoulomb<dim>{4e3, 3e3, 0.3, 0.1, 0.0}, basis);
    balance.squeeze(0.04);
    balance.start();
    const Eigen::VectorXd du = balance.random_du(0.012);
    EXPECT_LT(balance.error(du, 1e-7), 1e-6) << name(type);
    balance.residual(du);
    int yielding = 0;
    for (const auto& history : balance.trial.history) yielding += history.plastic_strain > 0;
    EXPECT_GT(yielding, 0.25 * balance.soil.points.size()) << name(type);
  });
}

/// A small change of du: the stresses that are not evaluated again follow from their tangent, with
/// an error of second order; finish() brings the points to exactly the accepted du.
TEST(InternalForces, known_stresses_are_bridged_by_their_tangent) {
  for_each_cell_type([]<int dim>(CellType type) {
    const auto make = [&] {
      return Balance<dim>(type, dim == 2 ? 3 : 2, regular_points(type), NeoHookean<dim>{4e3, 3e3});
    };
    Balance<dim> bridged = make(), anew = make();
    bridged.same_strain = 1e-4;
    bridged.start();
    anew.start();
    const Eigen::VectorXd du = bridged.random_du(0.02);
    const Eigen::VectorXd change = Eigen::VectorXd::LinSpaced(du.size(), -1, 1);
    bridged.residual(du, &bridged.K);
    std::vector<double> errors;
    for (const double size : {4e-6, 2e-6}) {
      const Eigen::VectorXd near = du + size * change;
      errors.push_back((bridged.residual(near) - anew.residual(near)).norm());
    }
    if (type == CellType::tri3 || type == CellType::tet4) {
      EXPECT_GT(errors[0], 0) << name(type);  // they were not evaluated again
      EXPECT_NEAR(errors[0] / errors[1], 4, 0.2) << name(type);
    } else {
      EXPECT_EQ(errors[0], 0) << name(type);
    }
    const Eigen::VectorXd last = du + 2e-6 * change;
    bridged.equilibrium->internal_forces().finish(
        {last.data(), static_cast<std::size_t>(last.size())});
    for (std::size_t e = 0; e < anew.trial.tau.size(); ++e) {
      EXPECT_EQ(bridged.trial.tau[e], anew.trial.tau[e]) << name(type) << " entry " << e;
    }
  });
}

TEST(EquilibriumTangent, ghost_stiffness_of_half_filled_cells) {
  for_each_cell_type([]<int dim>(CellType type) {
    Balance<dim> balance(type, 2, regular_points(type), NeoHookean<dim>{4e3, 3e3});
    for (double& V0 : balance.soil.points.V0) V0 *= 0.5;
    balance.ghost.emplace(balance.soil.grid, balance.soil.bodies, 0.3);
    balance.start({{"bottom", true, "here", {}}});
    EXPECT_GT(balance.ghost->num_facets(), 1);
    EXPECT_LT(balance.error(balance.random_du(0.02), 1e-4), 1e-8) << name(type);
  });
}

TEST(EquilibriumTangent, fixed_walls_and_slip_walls) {
  for_each_basis([]<int dim>(CellType type, mpm::Basis basis) {
    Balance<dim> balance(type, 2, regular_points(type), NeoHookean<dim>{4e3, 3e3}, basis);
    balance.start(
        {{"bottom", true, "here", {}}, {"left", false, "here", {}}, {"right", false, "here", {}}});
    const Eigen::VectorXd du = balance.random_du(0.01);
    EXPECT_LT(balance.error(du, 1e-4), 1e-8) << name(type);
    // The constrained directions carry no force and do not make the matrix singular.
    Eigen::VectorXd r = balance.residual(du, &balance.K);
    for (std::int32_t i = 0; i < balance.soil.nodes.size(); ++i) {
      const Vector<dim> f = r.segment<dim>(i * dim);
      const bool fixed = balance.soil.node(i)[dim - 1] == 0;
      const bool beside = balance.soil.node(i)[0] == 0 || balance.soil.node(i)[0] == 1;
      if (!fixed && !beside) continue;
      EXPECT_EQ(f[0], 0);
      if (fixed) {
        EXPECT_EQ(f, (Vector<dim>::Zero()));
      }
      const int blocked = fixed ? dim - 1 : 0;
      Eigen::VectorXd unit = Eigen::VectorXd::Unit(r.size(), i * dim + blocked), column(r.size());
      balance.K.multiply({unit.data(), static_cast<std::size_t>(r.size())},
                         {column.data(), static_cast<std::size_t>(r.size())});
      EXPECT_GT(column[i * dim + blocked], 0);
      column[i * dim + blocked] = 0;
      EXPECT_EQ(column.norm(), 0);
    }
  });
}

/// Without inertia the residual is weight minus internal force, whatever the points' motion is.
TEST(EquilibriumTangent, quasi_static) {
  for_each_cell_type([]<int dim>(CellType type) {
    Balance<dim> balance(type, 2, regular_points(type), NeoHookean<dim>{4e3, 3e3});
    balance.squeeze(0.05);
    balance.with_inertia = false;
    balance.start({{"bottom", true, "here", {}}});
    const Eigen::VectorXd du = balance.random_du(0.01);
    EXPECT_LT(balance.error(du, 1e-4), 1e-8) << name(type);
    const Eigen::VectorXd moving = balance.residual(du);
    for (auto& v : balance.soil.points.v) v.setZero();
    for (auto& a : balance.soil.points.a) a.setZero();
    balance.start({{"bottom", true, "here", {}}});
    EXPECT_EQ(moving, balance.residual(du)) << name(type);
  });
}

/// A slope of 30 degrees: the grid's lower wall is turned with it.
TEST(EquilibriumTangent, inclined_slip_wall) {
  Balance<2> balance(CellType::quad4, 3, 4, neo_hookean_2d);
  const double angle = M_PI / 6;
  Matrix<2> turn;
  turn << std::cos(angle), -std::sin(angle), std::sin(angle), std::cos(angle);
  Mesh<2> mesh = balance.soil.mesh;
  for (auto& x : mesh.nodes) x = turn * x;
  const mpm::WallConditions<2> walls(mpm::BackgroundGrid<2>(mesh),
                                     {{"bottom", false, "here", {}}, {"left", false, "here", {}}});
  balance.start();
  balance.walls.emplace(walls);
  balance.walls->select(balance.soil.nodes);
  EXPECT_LT(balance.error(balance.random_du(0.01), 1e-4), 1e-8);
  const Eigen::VectorXd r = balance.residual(balance.random_du(0.01));
  for (std::int32_t i = 0; i < balance.soil.nodes.size(); ++i) {
    const Vector<2> f = turn.transpose() * r.segment<2>(2 * i);  // along the slope, across it
    const auto& x = balance.soil.node(i);
    const bool below = x[1] == 0, beside = x[0] == 0;
    EXPECT_EQ(std::abs(f[1]) < 1e-12 * r.norm(), below) << x.transpose();
    EXPECT_EQ(std::abs(f[0]) < 1e-12 * r.norm(), beside) << x.transpose();
  }
}

/// A surface across the soil that looks upwards and was pushed up by `push`.
template <int dim>
mpm::ContactSettings<dim> level_surface(double height) {
  mpm::ContactSettings<dim> settings;
  settings.name = "plate";
  settings.method = mpm::BoundaryPointSettings{.penalty = 1e5};
  if constexpr (dim == 2) {
    settings.surface.facet_type = CellType::line2;
    settings.surface.vertices = {{0.9, height}, {0.5, height + 0.1}, {0.1, height}};
    settings.surface.facets = {0, 1, 1, 2};
  } else {
    settings.surface.facet_type = CellType::quad4;
    settings.surface.vertices = {
        {0.1, 0.2, height}, {0.9, 0.2, height + 0.1}, {0.9, 0.8, height + 0.1}, {0.1, 0.8, height}};
    settings.surface.facets = {0, 1, 2, 3};
    settings.method = mpm::BoundaryPointSettings{.penalty = 1e5, .points_per_facet = 4};
  }
  return settings;
}

template <int dim>
void check_contact(mpm::ContactMode mode, double friction, double sideways, int sliding) {
  const CellType type = dim == 2 ? CellType::quad4 : CellType::hex8;
  Balance<dim> balance(type, 2, regular_points(type), NeoHookean<dim>{4e3, 3e3});
  auto settings = level_surface<dim>(0.35);
  settings.mode = mode;
  settings.friction = friction;
  balance.contacts.push_back(make_contact(settings));
  balance.start();
  Vector<dim> push = Vector<dim>::Zero();
  push[dim - 1] = 0.02;
  push[0] = sideways;
  std::vector<double> displacement;
  for (std::size_t v = 0; v < settings.surface.vertices.size(); ++v) {
    displacement.insert(displacement.end(), push.data(), push.data() + dim);
  }
  auto& contact = *balance.contacts.front();
  contact.set_displacement(displacement);
  const Eigen::VectorXd du = balance.random_du(0.004);
  EXPECT_LT(balance.error(du, 2e-6), 1e-7);
  balance.residual(du);
  EXPECT_EQ(contact.results().counts().closed, 4);
  EXPECT_EQ(contact.results().counts().sliding, sliding);
}

TEST(EquilibriumTangent, contact_that_sticks_slides_slips_or_holds) {
  using mpm::ContactMode;
  check_contact<2>(ContactMode::contact, -1, 0.02, 0);
  check_contact<3>(ContactMode::contact, -1, 0.02, 0);
  check_contact<2>(ContactMode::contact, 0.3, 0.03, 4);
  check_contact<3>(ContactMode::contact, 0.3, 0.03, 4);
  check_contact<2>(ContactMode::contact, 5, 0.0, 0);
  check_contact<3>(ContactMode::contact, 5, 0.0, 0);
  check_contact<2>(ContactMode::contact, 0, 0.03, 4);
  check_contact<2>(ContactMode::slip, -1, 0.03, 4);
  check_contact<3>(ContactMode::slip, -1, 0.03, 4);
  check_contact<2>(ContactMode::fixed, -1, 0.03, 0);
  check_contact<3>(ContactMode::fixed, -1, 0.03, 0);
}

TEST(Equilibrium, rigid_motion_leaves_inertia_and_weight_only) {
  for_each_basis([]<int dim>(CellType type, mpm::Basis basis) {
    Balance<dim> balance(type, 2, regular_points(type), NeoHookean<dim>{4e3, 3e3}, basis);
    balance.start();
    Eigen::VectorXd du(static_cast<Eigen::Index>(balance.soil.num_dofs()));
    for (Eigen::Index k = 0; k < du.size(); ++k) du[k] = 0.1 * static_cast<double>(k % dim + 1);
    const Eigen::VectorXd r = balance.residual(du);
    const auto& nodes = balance.soil.nodes;
    for (std::int32_t i = 0; i < nodes.size(); ++i) {
      for (int d = 0; d < dim; ++d) {
        const double a =
            balance.scheme.acceleration(du[i * dim + d], nodes.v[i][d], nodes.a[i][d], 0.1);
        const double expected = nodes.m[i] * (-3.0 - balance.scheme.inertia(a, nodes.a[i][d]));
        EXPECT_NEAR(r[i * dim + d], expected, 1e-10);
      }
    }
  });
}

/// No external force and free sides: the internal forces add up to nothing, moments included in
/// the deformed positions.
TEST(Equilibrium, internal_forces_balance_each_other) {
  for_each_basis([]<int dim>(CellType type, mpm::Basis basis) {
    Balance<dim> balance(type, 2, regular_points(type), NeoHookean<dim>{4e3, 3e3}, basis);
    balance.squeeze(0.03);
    balance.start();
    const Eigen::VectorXd du = balance.random_du(0.01);
    const Eigen::VectorXd r = balance.residual(du);
    ForceAndMoment<dim> sum;
    const auto& nodes = balance.soil.nodes;
    for (std::int32_t i = 0; i < nodes.size(); ++i) {
      Vector<dim> f = r.segment<dim>(i * dim);
      for (int d = 0; d < dim; ++d) {
        const double a =
            balance.scheme.acceleration(du[i * dim + d], nodes.v[i][d], nodes.a[i][d], 0.1);
        f[d] += nodes.m[i] * (3.0 + balance.scheme.inertia(a, nodes.a[i][d]));
      }
      sum.add(balance.soil.node(i) + du.segment<dim>(i * dim), f);
    }
    EXPECT_GT(sum.size, 10);
    EXPECT_LT(sum.force.norm(), 1e-12 * sum.size);
    EXPECT_LT(sum.moment.norm(), 1e-12 * sum.size);
  });
}

TEST(Equilibrium, squeezing_a_point_flat_is_inadmissible) {
  Balance<2> balance(CellType::quad4, 1, 1, neo_hookean_2d);
  balance.start();
  std::vector<double> du(8, 0.0), r(8);
  du[5] = du[7] = -0.95;  // the upper nodes
  const Evaluation result = balance.equilibrium->evaluate(du, r, nullptr);
  EXPECT_FALSE(result.admissible);
  EXPECT_NE(result.reason.find("material point 0"), std::string::npos) << result.reason;
  du[5] = du[7] = -0.85;
  EXPECT_TRUE(balance.equilibrium->evaluate(du, r, nullptr).admissible);
}

/// Soil pulled apart to its apex: the regularisation adds `share` of the stiffness of linear
/// elasticity.
template <int dim>
void expect_elastic_brace(CellType type, int points_per_cell, mpm::Basis basis) {
  SCOPED_TRACE(static_cast<int>(type));
  const double lambda = 4e3, mu = 3e3, share = 0.3;
  Balance<dim> loose(type, 2, points_per_cell, MohrCoulomb<dim>{lambda, mu, 0.5, 0, 0}, basis);
  Balance<dim> elastic(type, 2, points_per_cell, LinearElastic<dim>{lambda, mu}, basis);
  elastic.with_inertia = false;
  loose.start();
  elastic.start();
  EXPECT_FALSE(loose.equilibrium->regularise(0));
  Eigen::VectorXd du(static_cast<Eigen::Index>(loose.soil.num_dofs()));
  for (Eigen::Index k = 0; k < du.size(); ++k) {
    du[k] = 0.01 * loose.soil.node(static_cast<std::int32_t>(k / dim))[k % dim];
  }
  const Eigen::VectorXd direction = loose.random_du(1);
  const auto times_K = [&](Balance<dim>& balance) {
    Eigen::VectorXd product = Eigen::VectorXd::Zero(du.size());
    balance.residual(du, &balance.K);
    balance.K.multiply({direction.data(), static_cast<std::size_t>(du.size())},
                       {product.data(), static_cast<std::size_t>(du.size())});
    return product;
  };
  const Eigen::VectorXd plain = times_K(loose), stiffness = times_K(elastic);
  EXPECT_TRUE(loose.equilibrium->regularise(share));
  const Eigen::VectorXd regularised = times_K(loose);
  EXPECT_LT((regularised - plain - share * stiffness).norm(), 1e-12 * stiffness.norm());
  EXPECT_TRUE(loose.equilibrium->regularise(0));
  EXPECT_LT((times_K(loose) - plain).norm(), 1e-14 * plain.norm());
  EXPECT_FALSE(elastic.equilibrium->regularise(share));
}

TEST(Regularisation, is_a_share_of_the_elastic_stiffness_where_soil_yields) {
  expect_elastic_brace<2>(CellType::tri3, 3, mpm::Basis::linear);
  expect_elastic_brace<2>(CellType::quad4, 4, mpm::Basis::linear);
  expect_elastic_brace<2>(CellType::quad4, 4, mpm::Basis::gimp);
  expect_elastic_brace<3>(CellType::tet4, 1, mpm::Basis::linear);
  expect_elastic_brace<3>(CellType::hex8, 8, mpm::Basis::linear);
}

}  // namespace
}  // namespace gabion::test::test_equilibrium
