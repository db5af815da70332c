// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "tests/unit/mpm/mpm_scene.hpp"

namespace gabion::test {

/// A column of soil that falls apart on a floor, or an elastic one that slides on it, out of the
/// parts of space that the ranks had at the start.
struct Collapse {
  std::string basis = "linear", cells = "quad4", locking = "none";
  bool with_plate = false;  ///< which the front runs into, met by facets
  std::string law = "mohr_coulomb";
  std::string small_cuts = "auto";
};

inline Json collapse_scene(const Collapse& given) {
  Json material = elastic_soil(given.law, 2e5, 0.3, 1500);
  if (given.law == "mohr_coulomb") material["friction_angle"] = 20;
  const Json walls = given.law == "mohr_coulomb"
                         ? Json{wall("bottom", "fixed"), wall("left", "slip")}
                         : Json{wall("bottom", "slip")};
  Json json = {{"dimension", 2},
               {"grid", box({0, 0}, {2.4, 1.2}, {12, 6}, given.cells)},
               {"basis", given.basis},
               {"locking", {{"method", given.locking}}},
               {"small_cuts", {{"method", given.small_cuts}}},
               {"walls", walls},
               {"gravity", {0, -9.81}},
               {"newton", exact_newton},
               {"linear_solver", {{"method", "mumps"}}},
               {"probes", {{{"name", "A"}, {"point", {0.5, 0.9}}}}},
               {"gauges", {{{"name", "foot"}, {"corners", {{0.701, 0.0}, {0.701, 1.0}}}}}},
               {"bodies",
                {body("soil", box({0, 0}, {0.6, 0.6}, {6, 6}, given.cells),
                      given.cells == "tri3" ? 3 : 4, material, {1.5, 0}),
                 body("top", box({0, 0.6}, {0.6, 1.0}, {6, 4}, given.cells),
                      given.cells == "tri3" ? 3 : 4, material, {1.5, 0})}}};
  if (given.with_plate) {
    json["interfaces"] = {{{"name", "plate"},
                           {"surface", {{"polyline", {{0.75, 0.8}, {0.75, 0}}}, {"spacing", 0.2}}},
                           {"method", "facets"},
                           {"friction", 0.3}}};
  }
  return json;
}

/// The soil of collapse_scene(), long and low, sliding over a floor of facets: the points in
/// contact go from rank to rank, with their elastic slip.
inline Json sliding_scene(const Collapse& given) {
  Json json = collapse_scene(given);
  json["walls"] = Json::array();
  json["probes"][0]["point"] = {0.7, 0.3};
  json["bodies"][0]["mesh"] = box({0.2, 0.2}, {0.8, 0.5}, {6, 3}, given.cells);
  json["bodies"][1]["mesh"] = box({0.8, 0.2}, {1.4, 0.5}, {6, 3}, given.cells);
  json["interfaces"] = {{{"name", "floor"},
                         {"surface", {{"polyline", {{2.3, 0.2}, {0.1, 0.2}}}, {"spacing", 0.1}}},
                         {"method", "facets"},
                         {"friction", 0.3}}};
  return json;
}

constexpr double collapse_dt = 0.004;

inline StepRequest collapse_step(int n) {
  return {n, 0, (n - 1) * collapse_dt, collapse_dt};
}

/// Steps `first` to `last`.
inline void run_collapse(Solver& solver, int first, int last) {
  InterfaceValues forces;
  for (int n = first; n <= last; ++n) {
    solver.solve_step(collapse_step(n), {}, forces);
    solver.accept_step(collapse_step(n), true);
  }
}

/// Each point of this rank has the values that it has alone, but for rounding; all are there.
template <int dim>
void expect_same_points(const mpm::MaterialPoints<dim>& shared,
                        const mpm::MaterialPoints<dim>& alone, double tolerance) {
  double count = static_cast<double>(shared.size());
  MPI_Allreduce(MPI_IN_PLACE, &count, 1, MPI_DOUBLE, MPI_SUM, comm());
  EXPECT_EQ(count, static_cast<double>(alone.size()));
  const auto close = [&](const char* name, const auto& a, const auto& b, double scale) {
    EXPECT_LE((a - b).norm(), tolerance * scale) << name;
  };
  for (std::int32_t p = 0; p < shared.size(); ++p) {
    const std::int32_t q = mpm::find_point(alone, shared.id[p]);
    ASSERT_GE(q, 0);
    SCOPED_TRACE("point " + std::to_string(shared.id[p]));
    EXPECT_EQ(shared.m[p], alone.m[q]);
    EXPECT_EQ(shared.V0[p], alone.V0[q]);
    EXPECT_EQ(shared.depth[p], alone.depth[q]);
    EXPECT_EQ(shared.cell[p], alone.cell[q]);
    close("x", shared.x[p], alone.x[q], 1);
    close("u", shared.u[p], alone.u[q], 1);
    close("v", shared.v[p], alone.v[q], 1);
    close("a", shared.a[p], alone.a[q], 1e3);
    close("tau", shared.tau[p], alone.tau[q], 1e5);
    close("e", shared.history[p].e, alone.history[q].e, 1);
    EXPECT_NEAR(shared.J[p], alone.J[q], tolerance);
    EXPECT_NEAR(shared.energy[p], alone.energy[q], 1e3 * tolerance);
    EXPECT_NEAR(shared.history[p].plastic_strain, alone.history[q].plastic_strain, tolerance);
    EXPECT_NEAR(shared.history[p].gap, alone.history[q].gap, tolerance);
    EXPECT_EQ(shared.half_length.empty(), alone.half_length.empty());
    if (!alone.half_length.empty()) {
      close("half_length", shared.half_length[p], alone.half_length[q], 1);
    }
    EXPECT_EQ(shared.has_gradients(), alone.has_gradients());
    if (!alone.has_gradients()) continue;
    close("grad_v", shared.grad_v[p], alone.grad_v[q], 1e2);
    close("grad_a", shared.grad_a[p], alone.grad_a[q], 1e5);
  }
}

inline void expect_same_probes(const Solver& shared, const Solver& alone, double tolerance) {
  const auto a = shared.probes(), b = alone.probes();
  const auto names = alone.probe_names();
  for (std::size_t k = 0; k < b.size(); ++k) {
    EXPECT_NEAR(a[k], b[k], tolerance * (1 + std::abs(b[k]))) << names[k];
  }
}

}  // namespace gabion::test
