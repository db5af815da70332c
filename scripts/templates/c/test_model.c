/* SPDX-License-Identifier: BSD-3-Clause */
/* The model alone, without a coupler. */
#include <math.h>
#include <stdio.h>

#include "model.h"

static double force[num_values];                            /* 2 N on each point along x */
static const double at_rest = 2.0 * num_points / STIFFNESS; /* k u = F */
static int failures = 0;

/* Of a sudden load after 0.1 s, by the closed form of the damped oscillator. */
static double error_with(int steps) {
  const double end = 0.1, decay = DAMPING / (2 * MASS);
  const double omega = sqrt(STIFFNESS / MASS - decay * decay);
  const double swing = cos(omega * end) + decay / omega * sin(omega * end);
  model_state state = {{0}, {0}};
  for (int n = 0; n < steps; ++n) state = model_step(state, end / steps, force);
  return fabs(state.u[0] - at_rest * (1 - exp(-decay * end) * swing));
}

static void expect_near(const char* what, double found, double expected, double tolerance) {
  if (fabs(found - expected) <= tolerance) return;
  printf("%s: found %.9g, expected %.9g within %g\n", what, found, expected, tolerance);
  ++failures;
}

int main(void) {
  model_state state = {{0}, {0}};
  for (int i = 0; i < num_values; i += dimension) force[i] = 2;
  state = model_step(state, 1e9, force);
  expect_near("rest", state.u[0] / at_rest, 1, 1e-9);
  expect_near("rest across", state.u[1], 0, 0);
  /* Implicit Euler is of first order: half the step, half the error. */
  expect_near("order", log2(error_with(2000) / error_with(4000)), 1, 0.05);
  return failures;
}
