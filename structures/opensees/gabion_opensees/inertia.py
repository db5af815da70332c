# SPDX-License-Identifier: BSD-3-Clause
"""The jump of the acceleration where the load of the structure jumps, M y = G' - G between two steps."""

import numpy as np

from .errors import SettingsError


class Inertia:
    """The mass matrix of a model, and which unknowns have none. Some nodes are loaded, any of the model may jump."""

    def __init__(self, answer: dict, loaded: list[int], constrained: set[int], limit: int) -> None:
        """answer: of model_process: mass. Raises SettingsError."""
        size = answer["size"]
        if size > limit:
            raise SettingsError(f"structure.json: at /max_unknowns: found a model of {size} unknowns, allowed: "
                                f"{limit}; its mass matrix would take {40 * size**2 / 1e9:.1f} GB")
        matrix = np.array(answer["matrix"]).reshape(size, size)
        massive = np.flatnonzero(matrix.any(axis=0))
        if not len(massive):
            raise SettingsError('structure.json: at /procedure: found "dynamic" and a model without mass, allowed: '
                                "static, or masses")
        unknowns = answer["unknowns"]
        row = {int(unknown): k for k, unknown in enumerate(massive)}
        self.inverse = np.linalg.inv(matrix[np.ix_(massive, massive)])
        width = max(len(unknowns[tag]) for tag in loaded)
        self.rows = np.full((len(loaded), width), -1)  # of the massive unknowns; -1: none
        for k, tag in enumerate(loaded):
            self.rows[k, :len(unknowns[tag])] = [row.get(unknown, -1) for unknown in unknowns[tag]]
        self.massive = self.rows >= 0
        self.nodes = [tag for tag, own in unknowns.items() if tag not in constrained and any(n in row for n in own)]
        self.of_nodes = [[row.get(unknown, -1) for unknown in unknowns[tag]] for tag in self.nodes]

    def jumps(self, difference: np.ndarray) -> list[tuple[int, list[float]]]:
        """Jumps of the velocity by node, from the difference of the loads of two steps, num_loaded x width."""
        total = np.zeros(len(self.inverse))
        np.add.at(total, self.rows[self.massive], difference[self.massive])
        if not total.any():
            return []
        y = np.append(self.inverse @ total, 0.0)
        return [(tag, y[own].tolist()) for tag, own in zip(self.nodes, self.of_nodes)]
