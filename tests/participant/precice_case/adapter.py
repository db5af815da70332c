# SPDX-License-Identifier: BSD-3-Clause
"""An adapter as one writes it for preCICE, and knows nothing else: a wall whose vertices are masses on springs.

    adapter.py CONFIG SOLVER_DT

m a + k u = F(t) at each vertex, trapezoidal rule, in steps of its own of at most SOLVER_DT.
"""

import argparse

import numpy as np
import precice

MASS, STIFFNESS = 2.0, 1e4  # of each vertex [kg], [N/m]
VERTICES = np.array([[0.26, 0.0], [0.26, 0.05], [0.25, 0.05], [0.25, 0.0]])


def step(state, dt, before, after):
    """Displacement and velocity after dt; the force goes from `before` to `after`.

    u' = u + dt (v + v') / 2 and M (v' - v) = dt (F + F') / 2 - dt K (u + u') / 2
    """
    u, v = state
    v_new = ((MASS - STIFFNESS * dt**2 / 4) * v + dt * ((before + after) / 2 - STIFFNESS * u)) / (
        MASS + STIFFNESS * dt**2 / 4)
    return u + dt / 2 * (v + v_new), v_new


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("config")
    parser.add_argument("solver_dt", type=float)
    arguments = parser.parse_args()

    participant = precice.Participant("Solid", arguments.config, 0, 1)
    mesh = "Wall-Mesh"
    assert participant.get_mesh_dimensions(mesh) == 2
    ids = participant.set_mesh_vertices(mesh, VERTICES)
    if participant.requires_mesh_connectivity_for(mesh):
        participant.set_mesh_edges(mesh, np.stack([ids[:-1], ids[1:]], axis=1))
    if participant.requires_initial_data():
        participant.write_data(mesh, "Displacement", ids, np.zeros_like(VERTICES))
    participant.initialize()

    state = np.zeros_like(VERTICES), np.zeros_like(VERTICES)
    time = 0.0
    while participant.is_coupling_ongoing():
        if participant.requires_writing_checkpoint():
            checkpoint = time, state
        dt = min(arguments.solver_dt, participant.get_max_time_step_size())
        before = participant.read_data(mesh, "Force", ids, 0.0)
        after = participant.read_data(mesh, "Force", ids, dt)
        state = step(state, dt, before, after)
        time += dt
        participant.write_data(mesh, "Displacement", ids, state[0])
        participant.advance(dt)
        if participant.requires_reading_checkpoint():
            time, state = checkpoint
        elif participant.is_time_window_complete():
            print(f"{time:.6f} {state[0][2, 0]:.17g}")
    participant.finalize()


if __name__ == "__main__":
    main()
