/* SPDX-License-Identifier: BSD-3-Clause */
#pragma once

/* The participant's side of the contract in C99: the calls of participant.hpp, which says more.
 *
 *     gabion_participant *p = gabion_create("structure", "tcp://127.0.0.1:5555", 2, "force");
 *     if (!p) die(gabion_last_error(NULL));
 *     CHECK(gabion_set_interface(p, "wall", num_vertices, coordinates, 2, num_facets, facets));
 *     CHECK(gabion_initialize(p));
 *     while (gabion_is_coupling_ongoing(p, &ongoing) == GABION_OK && ongoing) {
 *       CHECK(gabion_requires_writing_checkpoint(p, &answer));
 *       if (answer) save();
 *       CHECK(gabion_get_max_time_step_size(p, &dt));
 *       CHECK(gabion_read_data(p, "wall", force, num_values));
 *       solve(dt, force, displacement);
 *       CHECK(gabion_write_data(p, "wall", displacement, num_values));
 *       CHECK(gabion_advance(p, dt));
 *       CHECK(gabion_requires_reading_checkpoint(p, &answer));
 *       if (answer) restore();
 *     }
 *     CHECK(gabion_finalize(p));
 *     gabion_destroy(p);
 *
 * Functions return a gabion_status; gabion_last_error has the text. No exception crosses this
 * boundary. A participant is used by one thread at a time. Answers are 1 or 0. */

#include <stddef.h>
#include <stdint.h>

#ifdef __cplusplus
extern "C" {
#endif

typedef enum gabion_status {
  GABION_OK = 0,
  GABION_ERROR = 1,         /* anything else, such as no memory */
  GABION_ERROR_USAGE = 2,   /* wrong order of calls, or values that do not fit */
  GABION_ERROR_PROTOCOL = 4 /* refused, coupler lost, run ended by the coupler: final */
} gabion_status;

/* What interface forces say of a step: the force at its end, or the mean force, which is to act as
 * a constant load over the step. */
typedef enum gabion_force_kind { GABION_END_OF_STEP = 0, GABION_STEP_MEAN = 1 } gabion_force_kind;

typedef struct gabion_participant gabion_participant;

/* A participant that is not connected yet; NULL on failure.
 *   name       of the participant in coupler.json
 *   endpoint   of the coupler, such as "tcp://127.0.0.1:5555"
 *   dimension  2 or 3
 *   receives   "force" for a structure, which sends displacement; "displacement" for a soil */
gabion_participant* gabion_create(const char* name, const char* endpoint, int dimension,
                                  const char* receives);

/* Before the calls below. The foreign code and its version, for messages; [s] > 0 until the coupler
 * must have answered (30). */
gabion_status gabion_set_program(gabion_participant* p, const char* program, const char* version);
gabion_status gabion_set_connect_deadline(gabion_participant* p, double seconds);
/* Where the coupler asks for keys: file of the own secret key, file of the coupler's public key.
 * Without this call GABION_KEY_FILE and GABION_COUPLER_KEY_FILE of the environment hold. */
gabion_status gabion_set_keys(gabion_participant* p, const char* key_file,
                              const char* coupler_key_file);

/* A coupled surface in its reference configuration.
 *   coordinates         [m], num_vertices x dimension, row by row
 *   vertices_per_facet  2, 3, 4; 0 for bare points
 *   facets              vertex numbers from 0, num_facets x vertices_per_facet; normals out of
 *                       the structure: in 2D to the right of the segment from its first vertex */
gabion_status gabion_set_interface(gabion_participant* p, const char* name, size_t num_vertices,
                                   const double* coordinates, int vertices_per_facet,
                                   size_t num_facets, const int64_t* facets);

/* Of a soil: which force it sends on this interface; GABION_END_OF_STEP where nothing is said.
 * After gabion_set_interface, before gabion_initialize. */
gabion_status gabion_set_force_kind(gabion_participant* p, const char* interface_name,
                                    gabion_force_kind kind);

/* Of a structure: displacements [m] of an interface in the initial state, which is displaced; count
 * is num_vertices x dimension. After gabion_set_interface, before gabion_initialize. */
gabion_status gabion_set_start_displacement(gabion_participant* p, const char* interface_name,
                                            const double* values, size_t count);

/* Of a soil, before gabion_initialize, which calls take(interface name, displacements [m], count,
 * user) for each interface where a structure begins displaced; not in a restart. It calls
 * gabion_write_probes where they change, and returns 0, or anything else to end the run. What
 * gabion_read_data gives remains total, from the reference. */
gabion_status gabion_on_set_start(gabion_participant* p,
                                  int (*take)(const char* interface_name, const double* values,
                                              size_t count, void* user),
                                  void* user);

/* Of a structure: facets of this interface may leave it, or come, where cells fail. Its vertices are
 * all that a facet may ever have. After gabion_set_interface, before gabion_initialize. */
gabion_status gabion_set_facets_may_change(gabion_participant* p, const char* interface_name);

/* All facets that such an interface has from the step on that was just accepted: when
 * gabion_is_time_window_complete, before the next gabion_is_coupling_ongoing, where they change; and
 * within load of gabion_set_state, for each of these interfaces. */
gabion_status gabion_write_facets(gabion_participant* p, const char* interface_name,
                                  size_t num_facets, const int64_t* facets);

/* Of a soil, before gabion_initialize: take(interface name, num_facets, facets, user) is called
 * between two steps for each interface that has other facets from now on, of the same vertices; a
 * saved state has them. It returns 0, or anything else to end the run. */
gabion_status gabion_on_set_facets(gabion_participant* p,
                                   int (*take)(const char* interface_name, size_t num_facets,
                                               const int64_t* facets, void* user),
                                   void* user);

/* Numbers that the run shall record: names, and values in the initial state; later values at the
 * end of a step. */
gabion_status gabion_set_probes(gabion_participant* p, size_t count, const char* const* names,
                                const double* values);
gabion_status gabion_write_probes(gabion_participant* p, size_t count, const double* values);

/* write(time [s], user) is called when the coupler wants the accepted state on disk. It returns 0,
 * or anything else to end the run. */
gabion_status gabion_set_output(gabion_participant* p, int (*write)(double time, void* user),
                                void* user);

/* Optional, so that a run with this code can be restarted. Both return 0, or anything else to end
 * the run.
 *
 * save points *data at *size bytes: all of the accepted state that later steps depend on, which
 * then is the code's current state. They are copied before anything else is called.
 *
 * load goes on from such bytes, of an earlier run perhaps, and calls gabion_write_probes, and
 * gabion_write_facets of each interface whose facets may change. It is
 * called by gabion_initialize already, or between two steps. */
gabion_status gabion_set_state(gabion_participant* p,
                               int (*save)(const void** data, size_t* size, void* user),
                               int (*load)(const void* data, size_t size, void* user), void* user);

/* Connect, introduce, and wait for the first step. */
gabion_status gabion_initialize(gabion_participant* p);

gabion_status gabion_is_coupling_ongoing(gabion_participant* p, int* answer);
gabion_status gabion_is_time_window_complete(gabion_participant* p, int* answer);
gabion_status gabion_get_max_time_step_size(gabion_participant* p, double* seconds);
gabion_status gabion_get_time(gabion_participant* p, double* seconds);
gabion_status gabion_requires_writing_checkpoint(gabion_participant* p, int* answer);
gabion_status gabion_requires_reading_checkpoint(gabion_participant* p, int* answer);

/* Which force gabion_read_data gives on this interface, the same in all steps. */
gabion_status gabion_get_force_kind(gabion_participant* p, const char* interface_name,
                                    gabion_force_kind* kind);

/* count must be num_vertices x dimension. */
gabion_status gabion_read_data(gabion_participant* p, const char* interface_name, double* values,
                               size_t count);
gabion_status gabion_write_data(gabion_participant* p, const char* interface_name,
                                const double* values, size_t count);

/* The code has gone on by dt [s]; or the open step has no solution, and the coupler shall try a
 * smaller one. */
gabion_status gabion_advance(gabion_participant* p, double dt);
gabion_status gabion_fail_step(gabion_participant* p, const char* reason);

/* Close. Before the end of the coupling: tell the coupler that this participant gives up. */
gabion_status gabion_finalize(gabion_participant* p);

/* Text of the last failure of this participant, valid until its next call; of the last
 * gabion_create of this thread when p is NULL. Never NULL. */
const char* gabion_last_error(const gabion_participant* p);
void gabion_destroy(gabion_participant* p);

#ifdef __cplusplus
}
#endif
