/* SPDX-License-Identifier: BSD-3-Clause */
/* The structure of model.h in a time loop of its own.
 *
 *     structure --coupler tcp://host:port */
#include <protocol/gabion_participant.h>
#include <signal.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "model.h"

static gabion_participant* participant;

static void check(gabion_status status) {
  if (status == GABION_OK) return;
  fprintf(stderr, "[__NAME__] error: %s\n", gabion_last_error(participant));
  exit((int)status);
}

static int is(gabion_status (*question)(gabion_participant*, int*)) {
  int answer = 0;
  check(question(participant, &answer));
  return answer;
}

static int save(const void** data, size_t* size, void* state) {
  *data = state;
  *size = sizeof(model_state);
  return 0;
}

static int load(const void* data, size_t size, void* state) {
  if (size != sizeof(model_state)) return 1;
  memcpy(state, data, size);
  return gabion_write_probes(participant, dimension, ((model_state*)state)->u) != GABION_OK;
}

static void introduce(const char* endpoint, model_state* state) {
  static const char* const probes[3] = {"plate.ux", "plate.uy", "plate.uz"};
  static double points[num_values];
  static int64_t facets[num_facets * vertices_per_facet];
  gabion_force_kind kind;
  model_surface(points, facets);
  participant = gabion_create("__NAME__", endpoint, dimension, "force");
  if (participant == NULL) check(GABION_ERROR_USAGE);
  check(gabion_set_program(participant, "structure", "1"));
  check(gabion_set_interface(participant, "wall", num_points, points, vertices_per_facet,
                             num_facets, facets));
  check(gabion_set_probes(participant, dimension, probes, state->u));
  check(gabion_set_state(participant, save, load, state));
  check(gabion_initialize(participant));
  /* Either kind is right: implicit Euler adds dt F of momentum, be F the mean of the step or the
   * force at its end. To ask says that we know. */
  check(gabion_get_force_kind(participant, "wall", &kind));
}

int main(int argc, char** argv) {
  model_state state = {{0}, {0}}, saved;
  static double force[num_values], displacement[num_values];
  if (argc != 3 || strcmp(argv[1], "--coupler") != 0) {
    fputs("usage: structure --coupler tcp://host:port\n", stderr);
    return GABION_ERROR_USAGE;
  }
  signal(SIGTERM, SIG_IGN); /* a signal ends the run, with a checkpoint, not this program */
  signal(SIGINT, SIG_IGN);
  introduce(argv[2], &state);
  saved = state;
  while (is(gabion_is_coupling_ongoing)) {
    double dt = 0;
    if (is(gabion_requires_writing_checkpoint)) saved = state;
    check(gabion_get_max_time_step_size(participant, &dt));
    check(gabion_read_data(participant, "wall", force, num_values));
    state = model_step(state, dt, force);
    model_displacement(state, displacement);
    check(gabion_write_data(participant, "wall", displacement, num_values));
    check(gabion_write_probes(participant, dimension, state.u));
    check(gabion_advance(participant,
                         dt)); /* or gabion_fail_step: no solution, a smaller dt follows */
    if (is(gabion_requires_reading_checkpoint)) state = saved;
  }
  check(gabion_finalize(participant));
  gabion_destroy(participant);
  return GABION_OK;
}
