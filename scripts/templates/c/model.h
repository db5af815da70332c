/* SPDX-License-Identifier: BSD-3-Clause */
#ifndef MODEL_H
#define MODEL_H

/* The structure: a rigid plate on a spring and a damper in each direction, m a + c v + k u = F. */

#include <stdint.h>

enum {
  dimension = __DIMENSION__,
  vertices_per_facet = dimension == 2 ? 2 : 4,
  segments = 10,             /* of the plate's height; in 3D of its width too */
  line = 2 * (segments + 1), /* points in the plane */
  num_points = line * (dimension == 2 ? 1 : segments + 1),
  num_facets = (line - 1) * (dimension == 2 ? 1 : segments),
  num_values = num_points * dimension
};

/* In 2D per metre of width. */
#define MASS 0.6      /* [kg] */
#define DAMPING 10.0  /* [N s/m] */
#define STIFFNESS 5e3 /* [N/m] */

/* All that later steps depend on: displacement [m] and velocity [m/s] of the plate. */
typedef struct model_state {
  double u[dimension], v[dimension];
} model_state;

/* The surface that the soil can reach, at the start [m]. Up the right side, over the top, down the
 * left side: the soil is on the right of the line. In 3D this line is drawn along z. */
void model_surface(double points[num_values], int64_t facets[num_facets * vertices_per_facet]);

/* The state after dt [s], by implicit Euler. force: of the soil on each point [N]. */
model_state model_step(model_state state, double dt, const double force[num_values]);

/* [m] of each point, total: from where it was at the start. */
void model_displacement(model_state state, double values[num_values]);

#endif
