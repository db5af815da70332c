# SPDX-License-Identifier: BSD-3-Clause
"""The two posts: equal forces, displacements by their stiffness, sliding block."""

import numpy as np

from plotting.results import RESOLVED, object_of
from studies.balances import Row, ledger_rows
from studies.measures import Curve, Measured
from studies.slope_checks import sliding_rows

SCENE = "two_posts"
LAST = 0.2  # [s] that the end is the mean of


class Post:
    """A post at the end of a run. force [N] and head [m] along x, head from the rest under its own weight on; height of
    the force above the foot [m]; young: its modulus [Pa]."""

    def __init__(self, run: Measured, interface: str, participant: str, folder: str):
        steps, probes = run.table("steps.csv"), run.table("probes.csv")

        def of_step(column: str) -> float:
            return Curve(steps["time"], steps[f"{interface}.{column}"]).mean_of_last(LAST)

        settings = object_of(run.results.folder / folder / RESOLVED)["fem.json"]
        low, high = (np.array(settings["mesh"]["box"][corner]) for corner in ("low", "high"))
        moved = Curve(probes["time"], probes[f"{participant}.head.ux"])
        self.young = settings["material"]["young_modulus"]
        self.force = of_step("fx")
        self.height = height_of_force(self.force, of_step("fz"), of_step("my"), (low[0] + high[0]) / 2) - low[2]
        self.head = moved.mean_of_last(LAST) - float(moved.values[0])


def height_of_force(along: float, up: float, moment: float, place: float) -> float:
    """Height at which a force has this moment about an upright axis [m]. @param moment  about y at the origin [N m];
    place: x of the axis [m]"""
    return (moment + place * up) / along


def posts_rows(run: Measured) -> list[Row]:
    """Posts of the same shape under forces at the same height move by force over modulus."""
    stiff, soft = Post(run, "stiff", "structure", "fem"), Post(run, "soft", "soft", "soft")
    friction = run.results.settings("mpm.json")["rigid_walls"][0]["friction"]
    return [["force on the soft post at the end [N]: that on the stiff post", stiff.force, soft.force],
            ["height of that force [mm]: that on the stiff post", 1e3 * stiff.height, 1e3 * soft.height],
            ["displacement of the heads, soft over stiff: forces over moduli",
             soft.force / stiff.force * stiff.young / soft.young, soft.head / stiff.head],
            *sliding_rows(run, "bed", friction), *ledger_rows(run, 1, "J")]
