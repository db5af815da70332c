/* SPDX-License-Identifier: BSD-3-Clause */
/* A foreign code in C99: a wall on two springs and dampers, c du/dt + k u = f (resultant over the
 * wall), implicit Euler.
 *
 *     spring_in_c tcp://host:port [keep]      "keep": forgets to go back after a step that was not
 * accepted */
#include <protocol/gabion_participant.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum { num_vertices = 3, num_values = 2 * num_vertices };

static gabion_participant* participant;

static void check(gabion_status status) {
  if (status == GABION_OK) return;
  fprintf(stderr, "[spring] error: %s\n", gabion_last_error(participant));
  exit((int)status);
}

static int is(gabion_status (*question)(gabion_participant*, int*)) {
  int answer = 0;
  check(question(participant, &answer));
  return answer;
}

static int write_nothing(double time, void* count) {
  if (time < 0) return 1;
  ++*(int*)count;
  return 0;
}

static int save_state(const void** data, size_t* size, void* u) {
  *data = u;
  *size = 2 * sizeof(double);
  return 0;
}

static int load_state(const void* data, size_t size, void* u) {
  if (size != 2 * sizeof(double)) return 1;
  memcpy(u, data, size);
  return gabion_write_probes(participant, 1, u) == GABION_OK ? 0 : 2;
}

int main(int argc, char** argv) {
  const double coordinates[num_values] = {0.26, 0, 0.26, 0.05, 0.25, 0.05};
  const int64_t facets[4] = {0, 1, 1, 2};
  const char* const probe = "ux";
  const double stiffness = 1e4, damping = 10; /* [N/m], [N s/m] per metre */
  const int keeps = argc > 2 && strcmp(argv[2], "keep") == 0;
  double u[2] = {0, 0}, saved[2] = {0, 0};
  int outputs = 0;
  if (argc < 2) return GABION_ERROR_USAGE;
  participant = gabion_create("structure", argv[1], 2, "force");
  if (participant == NULL) {
    fprintf(stderr, "[spring] error: %s\n", gabion_last_error(NULL));
    return GABION_ERROR_USAGE;
  }
  check(gabion_set_program(participant, "spring", "1"));
  check(gabion_set_interface(participant, "wall", num_vertices, coordinates, 2, 2, facets));
  check(gabion_set_probes(participant, 1, &probe, u));
  check(gabion_set_output(participant, write_nothing, &outputs));
  check(gabion_set_state(participant, save_state, load_state, u));
  check(gabion_initialize(participant));
  gabion_force_kind kind = GABION_END_OF_STEP;
  check(gabion_get_force_kind(participant, "wall", &kind));
  if (kind != GABION_STEP_MEAN) return GABION_ERROR; /* the check sends means of a step */
  while (is(gabion_is_coupling_ongoing)) {
    double dt = 0, values[num_values], force[2] = {0, 0};
    if (is(gabion_requires_writing_checkpoint)) memcpy(saved, u, sizeof u);
    check(gabion_get_max_time_step_size(participant, &dt));
    check(gabion_read_data(participant, "wall", values, num_values));
    for (int i = 0; i < num_values; ++i) force[i % 2] += values[i];
    for (int k = 0; k < 2; ++k)
      u[k] = (force[k] + damping / dt * u[k]) / (stiffness + damping / dt);
    for (int i = 0; i < num_values; ++i) values[i] = u[i % 2];
    check(gabion_write_data(participant, "wall", values, num_values));
    check(gabion_write_probes(participant, 1, u));
    check(gabion_advance(participant, dt));
    if (is(gabion_requires_reading_checkpoint) && !keeps) memcpy(u, saved, sizeof u);
  }
  check(gabion_finalize(participant));
  gabion_destroy(participant);
  printf("outputs: %d\n", outputs);
  return GABION_OK;
}
