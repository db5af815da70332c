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
