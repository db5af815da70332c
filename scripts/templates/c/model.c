/* SPDX-License-Identifier: BSD-3-Clause */
#include "model.h"

#define LEFT 0.16 /* the plate from y = 0 up [m] */
#define RIGHT 0.17
#define TOP 0.05
#define WIDTH 0.1 /* in z, in 3D [m] */

void model_surface(double points[num_values], int64_t facets[num_facets * vertices_per_facet]) {
  for (int i = 0; i < num_points; ++i) {
    const int layer = i / line, k = i % line;
    const int height = k <= segments ? k : line - 1 - k;
    const double place[3] = {k <= segments ? RIGHT : LEFT, TOP * height / segments,
                             WIDTH * layer / segments};
    for (int axis = 0; axis < dimension; ++axis) points[dimension * i + axis] = place[axis];
  }
  for (int f = 0; f < num_facets; ++f) {
    const int64_t first = f / (line - 1) * line + f % (line - 1);
    const int64_t corners[4] = {first, first + 1, first + 1 + line, first + line};
    for (int n = 0; n < vertices_per_facet; ++n) facets[vertices_per_facet * f + n] = corners[n];
  }
}

model_state model_step(model_state state, double dt, const double force[num_values]) {
  double sum[dimension] = {0};
  model_state next;
  for (int i = 0; i < num_values; ++i) sum[i % dimension] += force[i];
  for (int i = 0; i < dimension; ++i) {
    next.v[i] = (sum[i] + MASS / dt * state.v[i] - STIFFNESS * state.u[i]) /
                (MASS / dt + DAMPING + STIFFNESS * dt);
    next.u[i] = state.u[i] + dt * next.v[i];
  }
  return next;
}

void model_displacement(model_state state, double values[num_values]) {
  for (int i = 0; i < num_values; ++i) values[i] = state.u[i % dimension];
}
