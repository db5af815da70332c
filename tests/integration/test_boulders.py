#!/usr/bin/python3
# SPDX-License-Identifier: BSD-3-Clause
"""A boulder against a wall of finite elements, soil far from both."""

import math

import launch
from launch import IntegrationCase, meeting, read_table

RADIUS, DENSITY, SPEED, GRAVITY = 0.032, 2650, 0.5, 9.81


def stone_meets_wall(scheme: str) -> dict[str, dict]:
    files = meeting()
    files["coupler"]["time"].update(end=0.035, dt=2.5e-4)
    soil = files["mpm"]
    soil["time_integration"] = {"scheme": scheme}
    soil["bodies"][0]["mesh"]["box"].update(low=[0, 0], high=[0.04, 0.04], cells=[2, 2])
    soil["bodies"][0]["velocity"] = [0, 0]
    soil["walls"].append({"group": "right", "condition": "slip"})
    del soil["interfaces"][0]["method"], soil["interfaces"][0]["penalty"]
    soil["boulders"] = [{"name": "stone", "shape": {"radius": RADIUS}, "density": DENSITY, "friction": 0.3,
                         "stiffness": 1e8, "centre": [0.25 - RADIUS - 0.004, 0.035], "velocity": [SPEED, 0]}]
    return files


class StoneMeetsWall(IntegrationCase):
    """The momentum that the wall receives is what the stone loses; the stone never gains."""

    def run_with(self, scheme: str) -> None:
        self.write_scene(stone_meets_wall(scheme))
        self.run_launch(code=0)
        steps, probes = (read_table(self.out / f"{name}.csv") for name in ("steps", "probes"))
        mass = math.pi * RADIUS**2 * DENSITY
        before = {name: float(value) for name, value in probes[0].items()}
        energy = [float(row["soil.stone.kinetic_energy"]) + mass * GRAVITY * float(row["soil.stone.y"])
                  for row in probes]
        work = impulse = 0.0
        for row, after, now, last in zip(steps, probes[1:], energy[1:], energy[:-1], strict=True):
            force = [float(row["fx"]), float(row["fy"])]
            for axis, weight, own in (("x", 0, force[0]), ("y", mass * GRAVITY, force[1])):
                change = float(after[f"soil.stone.v{axis}"]) - before[f"soil.stone.v{axis}"]
                self.assertAlmostEqual(mass * change, -float(row["dt"]) * (weight + own), delta=1e-9 * mass * SPEED)
            before = {name: float(value) for name, value in after.items()}
            impulse += float(row["dt"]) * force[0]
            self.assertAlmostEqual(float(after["soil.wall.boulders_fx"]), force[0], delta=1e-3 * abs(force[0]) + 1e-6)
            work += float(row["structure_work"])
            self.assertLess(now - last, -float(row["structure_work"]) + 0.01 * energy[0])
        self.assertGreater(impulse, 0.4 * mass * SPEED)  # the wall still moves
        self.assertGreater(work, 0)
        self.assertLess(energy[-1] + work, energy[0] * (1 + 1e-9))
        last = {name: float(probes[-1][f"soil.{name}"]) for name in (
            "boulders_kinetic_energy", "boulders_gravity_work", "boulders_soil_work", "boulders_surface_work",
            "boulders_contact_loss", "boulder_contact_energy")}
        self.assertAlmostEqual(last["boulders_surface_work"], work, delta=1e-3 * work)
        self.assertGreater(last["boulders_contact_loss"], 0)
        self.assertEqual(last["boulders_soil_work"], 0)
        gained = last["boulders_gravity_work"] - sum(last[f"{name}"] for name in (
            "boulders_surface_work", "boulders_contact_loss", "boulder_contact_energy"))
        self.assertAlmostEqual(last["boulders_kinetic_energy"] - float(probes[0]["soil.boulders_kinetic_energy"]),
                               gained, delta=1e-9 * energy[0])
        self.assertGreater(sum(row["status"] == "converged" for row in steps), 5)

    def test_explicit_steps(self) -> None:
        self.run_with("explicit")

    def test_implicit_steps(self) -> None:
        self.run_with("newmark")

    def test_impact_within_few_steps(self) -> None:
        """A stiff wall throws the stone back within six steps: the peak depends on the step, which is said."""
        files = stone_meets_wall("explicit")
        files["fem"]["material"]["young_modulus"] = 1e9
        files["coupler"]["time"].update(end=0.06, dt=4e-3)
        self.write_scene(files)
        self.assert_says(self.run_launch(code=0).text, "boulders pressed on \"wall\"", "the mean force of each step")


def ellipsoid_meets_block(dim: int, height: float) -> dict[str, dict]:
    """An ellipsoid comes tilted to a block that nothing holds; nothing has weight. At `height` 0.05 it meets the upper
    edge or corner."""
    files = meeting()
    files["coupler"]["time"].update(end=0.03, dt=2.5e-4)
    wide = [] if dim == 2 else [0.0]
    low, high = [0.25, 0.0, *wide], [0.31, 0.05, *[0.04] * len(wide)]
    block = {"box": {"low": low, "high": high, "cells": [3, 5, *[2] * len(wide)],
                     "type": "quad4" if dim == 2 else "hex8"}}
    files["fem"] = {"dimension": dim, "mesh": block,
                    "material": {"law": "neo_hookean", "density": 2000, "young_modulus": 1e7, "poisson_ratio": 0.2},
                    "interfaces": [{"name": "wall", "groups": ["left", "top", "right"]}]}
    soil = files["mpm"]
    soil.update(dimension=dim, gravity=[0] * dim, walls=[], time_integration={"scheme": "explicit"},
                grid={"box": {"low": [0, -0.04, *[-0.06] * len(wide)], "high": [0.4, 0.16, *[0.1] * len(wide)],
                              "cells": [20, 10, *[8] * len(wide)], "type": "quad4" if dim == 2 else "hex8"}},
                interfaces=[{"name": "wall", "surface": {"mesh": block, "groups": ["left", "top", "right"]}}])
    soil["bodies"][0].update(velocity=[0] * dim, points_per_cell=4 if dim == 2 else 8, mesh={"box": {
        "low": [0.0, 0.0, *wide], "high": [0.04, 0.04, *[0.04] * len(wide)], "cells": [2, 2, *[2] * len(wide)],
        "type": "quad4" if dim == 2 else "hex8"}})
    turn = [0.6] if dim == 2 else [0.95, 0.1, 0.05, 0.28]
    soil["boulders"] = [{"name": "stone", "shape": {"ellipsoid": [0.045, 0.032, *[0.036] * len(wide)]},
                         "density": DENSITY, "friction": 0.3, "restitution": 0.5, "stiffness": 1e8, "orientation": turn,
                         "centre": [0.2, height, *[0.02] * len(wide)], "velocity": [2 * SPEED, 0, *wide]}]
    return files


class EllipsoidMeetsBlock(IntegrationCase):
    """Momentum of stone and block stays, their energy is never gained: on a face, an edge, a corner."""

    def run_with(self, dim: int, height: float) -> None:
        self.write_scene(ellipsoid_meets_block(dim, height))
        self.run_launch(code=0)
        probes = read_table(self.out / "probes.csv")
        both = [[float(row[f"soil.boulders_momentum_{axis}"]) + float(row[f"structure.momentum_{axis}"])
                 for row in probes] for axis in "xyz"[:dim]]
        thrown = both[0][0]
        for axis in both:
            self.assertLess(max(abs(value - axis[0]) for value in axis), 1e-6 * thrown)
        self.assertGreater(float(probes[-1]["structure.momentum_x"]), 0.1 * thrown)
        energy = [sum(float(row[name]) for name in (
            "soil.boulders_kinetic_energy", "soil.boulder_contact_energy", "structure.kinetic_energy",
            "structure.elastic_energy")) for row in probes]
        self.assertLess(max(now - last for now, last in zip(energy[1:], energy[:-1])), 2e-3 * energy[0])
        self.assertLess(energy[-1], 0.95 * energy[0])
        spin = float(probes[-1]["soil.stone.wz"])
        self.assertGreater(abs(spin), 0.02)

    def test_on_a_face(self) -> None:
        self.run_with(2, 0.02)

    def test_on_a_corner(self) -> None:
        self.run_with(2, 0.065)

    def test_on_a_face_in_space(self) -> None:
        self.run_with(3, 0.02)

    def test_on_an_edge_in_space(self) -> None:
        self.run_with(3, 0.065)


class ManyStones(IntegrationCase):
    """What the start says of them is a line each up to ten, and two lines beyond."""

    def start_of(self, count: int) -> str:
        files = stone_meets_wall("explicit")
        soil = files["mpm"]
        soil["grid"]["box"].update(high=[1.2, 0.4], cells=[60, 20])
        (stone,) = soil["boulders"]
        soil["boulders"] = [stone | {"name": f"stone_{k}", "centre": [0.1 + 0.08 * k, 0.2 + 0.01 * k]}
                            for k in range(count)]
        self.write_scene(files)
        return self.run_launch("--check", code=0).text

    def test_ten(self) -> None:
        said = self.start_of(10)
        for k in range(10):
            self.assert_says(said, f"stone_{k}: smallest gap to the soil ")
        self.assertNotIn("10 boulders", said)

    def test_twelve(self) -> None:
        said = self.start_of(12)
        mass = math.pi * RADIUS**2 * DENSITY
        self.assert_says(said, f"/boulders: 12 boulders of {2 * RADIUS:.4g} to {2 * RADIUS:.4g} m, {mass:.4g} to "
                               f"{mass:.4g} kg/m, together {12 * mass:.6g} kg/m")
        self.assert_says(said, '12 boulders, nearest "stone_0": smallest gap to the soil ')
        self.assertNotIn("stone_0: ", said)


if __name__ == "__main__":
    launch.main()
