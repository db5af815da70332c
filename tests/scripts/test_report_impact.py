#!/usr/bin/python3
# SPDX-License-Identifier: BSD-3-Clause
"""scripts/report: impact coefficient, soil past a surface, sliding and overturning of footings, against closed forms.
"""

import json
import unittest

import numpy as np
from made_up_results import write_series, write_table
from script_case import ScriptCase

from plotting.results import Results
from reporting.answers import answers
from reporting.beyond import soil_past
from reporting.curves import charts
from reporting.footing import stability, underside_of
from reporting.incoming import gauges_of, impacts

RHO, V, H = 1500.0, 4.0, 0.5  # of the flow at its strongest
HEAD = ("passed_mass", "area", "depth", "section_flux", "normal_speed", "speed", "dynamic_pressure")
TIMES = (0.0, 1.0, 2.0, 3.0)


def flow(density: float, speed: float, depth: float, width: float = 1.0) -> list[float]:
    """Columns of a gauge, in the order of HEAD."""
    return [0.0, depth * width, depth, density * speed * depth * width, speed, abs(speed), density * speed**2]


def wall_frames(dim: int, turn: np.ndarray) -> list[tuple]:
    """A wall at x = 2 of height 1, thickness 0.25; in 3D y from 1 to 4. Faces to -x and +x, with soil on that to -x at
    the end. turn: dim x dim, of all places about the origin."""
    if dim == 2:
        points = np.array([[2.25, 0], [2.25, 1], [2, 1], [2, 0.0]])
        cells = np.array([[0, 1], [1, 2], [2, 3]])
        pressed = [0, 0, 1.0]
    else:
        points = np.array([[2, 1, 0], [2, 4, 0], [2, 4, 1], [2, 1, 1],
                           [2.25, 1, 0], [2.25, 4, 0], [2.25, 4, 1], [2.25, 1, 1.0]])
        cells = np.array([[0, 3, 2, 1], [4, 5, 6, 7]])
        pressed = [1.0, 0]
    points = np.pad(points @ turn.T, ((0, 0), (0, 3 - dim)))
    return [(time, points, cells, {"pressure": 100 * time * np.array(pressed)}) for time in TIMES]


def turned(dim: int, angle: float) -> np.ndarray:
    """Rotation in the plan, about the last axis; none in 2D."""
    c, s = np.cos(angle), np.sin(angle)
    return np.array([[c, -s, 0], [s, c, 0], [0, 0, 1]]) if dim == 3 else np.eye(2)


class Made(ScriptCase):
    def run_of(self, dim: int, gauges: dict[str, tuple[list, list[list[float]]]], force: list[float],
               angle: float = 0.0, **mpm: object) -> Results:
        """A wall with the force `force` along the flow at TIMES. gauges: name -> corners, columns at TIMES."""
        turn = turned(dim, angle)
        axes = "xyz"[:dim]
        vectors = np.outer(force, turn[:, 0])
        head = ["step", "time", "dt", *(f"f{a}" for a in axes), *(f"wall.f{a}" for a in axes),
                *(f"wall.m{a}" for a in ("z" if dim == 2 else "xyz"))]
        write_table(self.folder / "steps.csv", head, [
            [k, TIMES[k], 1.0, *vectors[k], *vectors[k], *[0.0] * (1 if dim == 2 else 3)]
            for k in range(1, len(TIMES))])
        columns = [f"soil.{name}.{leaf}" for name in gauges for leaf in HEAD]
        rows = [[time, 0.0, *[0.0] * (dim - 2), *(value for _, each in gauges.values() for value in each[k])]
                for k, time in enumerate(TIMES)]
        write_table(self.folder / "probes.csv", ["time", "structure.A.ux", *["structure.A.uz"][:dim - 2], *columns],
                    rows)
        write_series(self.folder / "mpm", "contact_wall", wall_frames(dim, turn))
        corners = {name: (np.array(each) @ turn.T).tolist() for name, (each, _) in gauges.items()}
        settings = {"dimension": dim, "gravity": [0, -10] if dim == 2 else [0, 0, -10],
                    "gauges": [{"name": name, "corners": each} for name, each in corners.items()], **mpm}
        self.write("mpm/resolved_config.json", json.dumps({"mpm.json": settings}))
        self.write("resolved_config.json", json.dumps({"coupler.json": {"interfaces": [{"name": "wall"}]}}))
        return Results(self.folder)


# The strongest flow at 1 s, a slower and deeper one behind it.
COURSE = [flow(RHO, 0, 0), flow(RHO, V, H), flow(RHO, 1.0, 2.0), flow(RHO, 0.5, 2.0)]
FORCE = [0.0, 6000.0, 30000.0, 12000.0]


class ImpactCoefficient(Made):
    def test_in_the_plane(self) -> None:
        run = self.run_of(2, {"toe": ([[1, 0], [1, 2]], COURSE)}, FORCE)
        (name, impact), = impacts(run)
        np.testing.assert_allclose(impact.coefficient, np.array(FORCE[1:]) / (RHO * V**2 * H))
        self.assertEqual(name, "wall")
        text = dict(answers(run))["impact coefficient of wall"]
        self.assertIn("2.5 at 2 s; at the end 1:", text)
        self.assertIn("gauge toe at 1 s", text)
        self.assertIn("rho 1500 kg/m³, v 4 m/s, h 0.5 m; Froude number 1.79", text)
        drawn = {each["name"]: each for each in charts(run)}
        self.assertEqual(drawn["impact-wall"]["curves"][0]["y"], [0.5, 2.5, 1])
        self.assertEqual([each["name"] for each in drawn["gauge-depth"]["curves"]], ["toe depth"])

    def test_a_gauge_that_looks_the_other_way(self) -> None:
        """Foot and top of the gauge exchanged: the flow counts negative, the coefficient is the same."""
        back = [[-value if leaf in ("section_flux", "normal_speed") else value for leaf, value in zip(HEAD, row)]
                for row in COURSE]
        (_, impact), = impacts(self.run_of(2, {"toe": ([[1, 2], [1, 0]], back)}, FORCE))
        np.testing.assert_allclose(impact.coefficient[1], 2.5)

    def test_the_nearest_gauge_in_front(self) -> None:
        slow = [flow(RHO, 0, 0), *[flow(RHO, V / 2, H)] * 3]
        gauges = {"far": ([[0, 0], [0, 2]], COURSE), "near": ([[1.5, 0], [1.5, 2]], slow),
                  "crest": ([[2.1, 1], [2.1, 2]], COURSE), "behind": ([[3, 0], [3, 2]], COURSE)}
        (_, impact), = impacts(self.run_of(2, gauges, FORCE))
        self.assertEqual(impact.flow.gauge.name, "near")
        np.testing.assert_allclose(impact.coefficient[1], 10.0)

    def test_why_there_is_none(self) -> None:
        dry = [flow(RHO, 0, 0)] * 4
        for gauges, words in (({}, "no gauge measures the flow"),
                              ({"toe": ([[1, 0], [1, 2]], dry)}, "none of the gauges (toe)"),
                              ({"behind": ([[3, 0], [3, 2]], COURSE)}, "none of the gauges (behind)")):
            with self.subTest(words):
                self.assertIn(words, dict(answers(self.run_of(2, gauges, FORCE)))["impact coefficient of wall"])

    def test_in_space_at_any_angle(self) -> None:
        """b is the width of the wall, 3 m, though the gauge is wider; one beside the wall is none."""
        course = [[*row] for row in (flow(RHO, *each, 6.0) for each in ((0, 0), (V, H), (1, 2), (0.5, 2)))]
        gauges = {"toe": ([[1, 0, 0], [1, 6, 0], [1, 0, 2]], course),
                  "beside": ([[1.5, 5, 0], [1.5, 9, 0], [1.5, 5, 2]], course)}
        for angle in (0.0, 0.7, -2.0):
            run = self.run_of(3, gauges, FORCE, angle)
            (_, impact), = impacts(run)
            self.assertEqual(impact.flow.gauge.name, "toe")
            np.testing.assert_allclose(impact.flow.direction, turned(3, angle)[:, 0], atol=1e-12)
            np.testing.assert_allclose(impact.width, 3)
            np.testing.assert_allclose(impact.coefficient, np.array(FORCE[1:]) / (RHO * V**2 * H * 3))
            self.assertIn("b 3 m (the surface across the flow)", dict(answers(run))["impact coefficient of wall"])

    def test_a_surface_that_nothing_reaches(self) -> None:
        found = dict(answers(self.run_of(2, {"toe": ([[1, 0], [1, 2]], COURSE)}, [0.0] * 4)))
        self.assertEqual(found["force on the structure"], "none until 3 s: nothing has touched it")
        self.assertEqual([each for each in found if "impact" in each or "past" in each], [])

    def test_normals_of_gauges(self) -> None:
        run = self.run_of(3, {"a": ([[0, 0, 0], [0, 5, 0], [-1, 0, 2]], [flow(1, 1, 1)] * 4)}, FORCE)
        gauge, = gauges_of(run)
        np.testing.assert_allclose(gauge.normal, np.array([2, 0, 1]) / np.sqrt(5), atol=1e-12)
        np.testing.assert_allclose(np.abs(gauge.across), [0, 1, 0], atol=1e-12)
        np.testing.assert_allclose(gauge.span[1] - gauge.span[0], 5)


class RigidBarrier(Made):
    def test_answers_of_a_rigid_wall_that_stands(self) -> None:
        """A rigid wall has force, moment, pressure as an interface has; a bed and terrain have none."""
        run = self.run_of(2, {"toe": ([[1, 0], [1, 2]], COURSE)}, FORCE,
                          rigid_walls=[{"name": "wall"}, {"name": "bed"}])
        (self.folder / "steps.csv").unlink()
        (self.folder / "resolved_config.json").unlink()
        names = (self.folder / "probes.csv").read_text().splitlines()[0].split(",")
        write_table(self.folder / "probes.csv",
                    [*names, *(f"soil.{name}.{leaf}" for name in ("wall", "bed") for leaf in ("fx", "fy", "mz"))],
                    [[time, 0.0, *COURSE[k], FORCE[k], 0.0, -FORCE[k] / 2, 0.0, -5.0, 1.0]
                     for k, time in enumerate(TIMES)])
        bed = np.array([[9, 0, 0], [-9, 0, 0.0]])
        write_series(self.folder / "mpm", "contact_bed",
                     [(time, bed, np.array([[0, 1]]), {"pressure": np.ones(1)}) for time in TIMES])
        found = dict(answers(run))
        self.assertEqual(found["force on wall, x"], "3e+04 N/m at 2 s; at the end 1.2e+04 N/m; impulse 4.8e+04 N s/m")
        self.assertIn("2.5 at 2 s", found["impact coefficient of wall"])
        self.assertIn("-1.5e+04 N m/m at 2 s", found["moment on wall about its foot, z"])
        self.assertIn("300 Pa at a height of 0.5 m", found["largest pressure on wall, side -x"])
        self.assertEqual([each for each in found if "bed" in each], [])


class SoilPast(Made):
    def soil(self, places: list[list[list[float]]], dim: int, angle: float = 0.0) -> None:
        """Points of 0.5 m^3 at rest that have opened to 0.6 m^3, at TIMES."""
        frames = []
        for time, points in zip(TIMES, places):
            turned_points = np.array(points, dtype=float).reshape(-1, dim) @ turned(dim, angle).T
            frames.append((time, np.pad(turned_points, ((0, 0), (0, 3 - dim))), None,
                           {"volume": np.full(len(points), 0.6), "volume_ratio": np.full(len(points), 1.2),
                            "velocity": np.zeros((len(points), 3))}))
        write_series(self.folder / "mpm", "soil", frames)

    def test_volume_at_rest_past_a_wall(self) -> None:
        run = self.run_of(2, {}, FORCE)
        self.soil([[[0, 0], [1, 0], [5, 0]], [[1, 0], [2.1, 1.2], [5, 0]], [[2.3, 2], [3, 0], [6, 0]],
                   [[2.2, 1.1], [3, 0], [6, 0]]], 2)
        past, = soil_past(run)
        np.testing.assert_allclose(past.volume, [0, 0, 1.0, 0.5])  # what lay behind it at the start does not count
        text = dict(answers(run))["volume past wall"]
        self.assertIn("0.5 m³/m at the end (0.333 of all soil), at most 1 m³/m at 2 s", text)
        self.assertNotIn("left the grid", text)

    def test_in_space_over_and_around(self) -> None:
        for angle in (0.0, 1.1):
            run = self.run_of(3, {}, FORCE, angle)
            self.soil([[[0, 2, 0]] * 3, [[1, 2, 0]] * 3, [[3, 2, 0], [1, 2, 0], [3, 5, 0]],
                       [[3, 2, 0], [3, 0.5, 0], [3, 5, 0]]], 3, angle)
            past, = soil_past(run)
            np.testing.assert_allclose(past.volume, [0, 0, 1.0, 1.5])
            np.testing.assert_allclose(past.behind, [0, 0, 0.5, 0.5])

    def test_none_and_what_left(self) -> None:
        run = self.run_of(2, {}, FORCE)
        self.soil([[[0, 0]]] * 4, 2)
        self.assertEqual(dict(answers(run))["volume past wall"], "none in 4 frames")
        table = (self.folder / "probes.csv").read_text().splitlines()
        rows = [table[0] + ",soil.removed_mass", *(f"{row},7" for row in table[1:])]
        self.write("probes.csv", "\n".join(rows) + "\n")
        self.assertIn("0 m³/m at the end", dict(answers(run))["volume past wall"])
        self.assertIn("7 kg/m that left the grid are not counted", dict(answers(run))["volume past wall"])
        self.soil([[], [], [], []], 2)
        self.assertNotIn("volume past wall", dict(answers(run)))


class Footings(ScriptCase):
    """A block on a held underside: the resultant of its reaction and the moment are known."""

    def structure(self, corners: list[list[float]], place: str = "fem", held_above: bool = False) -> None:
        """Nodes above the lowest turn, with held_above the lowest ones, so that the structure stretches from the first
        frame to the second."""
        points = np.array(corners, dtype=float)
        points = np.pad(points, ((0, 0), (0, 3 - points.shape[1])))
        cells = np.arange(len(points))[None]
        height = points[:, 1 if len(corners[0]) == 2 else 2]
        moves = (height == height.min()) == held_above
        later = points + 1e-3 * moves[:, None] * points[:, [1, 0, 2]]
        write_series(self.folder / place, "structure", [(time, each, cells, {"displacement": each - points})
                                                        for time, each in ((0.0, points), (1.0, later))])

    def plane(self, *rows: tuple[float, float, float, float]) -> Results:
        """rows: time, horizontal and vertical reaction, moment about the middle of the underside."""
        write_table(self.folder / "probes.csv", ["time", "structure.A.ux", "structure.reaction_foot_x",
                                                 "structure.reaction_foot_y", "structure.moment_foot_z"],
                    [[row[0], 0, *row[1:]] for row in rows])
        return Results(self.folder)

    def test_safety_in_the_plane(self) -> None:
        self.structure([[1, 2], [4, 2], [4, 3], [1, 3]])  # 3 m wide
        run = self.plane((0, 0, 100, 0), (1, -60, 120, 30), (2, -20, 80, -40))
        found = dict(stability(run, 0.75))
        self.assertIn("safety 1.5 with friction 0.75, 3 at the end; needs a friction coefficient of 0.5 at 1 s, 0.25",
                      found["sliding of structure.foot"])
        self.assertIn("safety 3 at 2 s, 3 at the end: resultant 0.5 m from the middle at 2 s",
                      found["overturning of structure.foot"])
        self.assertIn("underside of 3 m", found["overturning of structure.foot"])
        self.assertIn("--base-friction gives the safety", dict(stability(run))["sliding of structure.foot"])
        self.assertNotIn("uplift of structure.foot", found)

    def test_uplift_and_rest(self) -> None:
        self.structure([[1, 2], [4, 2], [4, 3], [1, 3]])
        run = self.plane((0, 0, 100, 0), (1, -60, -5, 30))
        found = dict(stability(run, 0.5))
        self.assertIn("first at 1 s", found["uplift of structure.foot"])
        self.assertIn("nothing pushes it", found["sliding of structure.foot"])
        self.assertIn("nothing turns it", found["overturning of structure.foot"])
        self.assertEqual([each for each, _ in stability(self.plane((0, 0, -1, 0)))], ["uplift of structure.foot"])

    def test_weight_that_is_round_off(self) -> None:
        """Posts without weight: 3e-12 N upward over 500 N across are no friction coefficient of 1.7e14."""
        self.structure([[1, 2], [4, 2], [4, 3], [1, 3]])
        found = dict(stability(self.plane((0, 0, 0, 0), (1, -500, 3e-12, 30), (2, -100, -1e-12, 20)), 0.5))
        self.assertEqual(list(found), ["weight on structure.foot"])
        self.assertIn("no weight on the footing, first at 1 s", found["weight on structure.foot"])
        found = dict(stability(self.plane((0, 0, 0, 0), (1, -500, 3e-12, 30), (2, -100, 400, 20)), 0.5))
        self.assertEqual(list(found), [f"{what} structure.foot" for what in ("weight on", "sliding of",
                                                                              "overturning of")])
        self.assertIn("coefficient of 0.25 at 2 s", found["sliding of structure.foot"])
        found = dict(stability(self.plane((0, 0, 0, 0), (1, -500, 600, 30)), 0.5))
        self.assertEqual(list(found), [f"{what} structure.foot" for what in ("sliding of", "overturning of")])

    def test_no_flat_underside(self) -> None:
        for slope, held_above in ((0.5, False), (0, True)):
            self.structure([[1, 2], [4, 2 + slope], [4, 3], [1, 3]], held_above=held_above)
            self.assertIn("no safety", dict(stability(self.plane((0, 9, 100, 7))))["overturning of structure.foot"])

    def test_several_structures_are_told_apart_by_their_folders(self) -> None:
        self.structure([[1, 2], [4, 2], [4, 3], [1, 3]])
        self.structure([[1, 2], [9, 2], [9, 3], [1, 3]], "soft")
        self.assertIn("no safety", dict(stability(self.plane((0, 9, 100, 50))))["overturning of structure.foot"])
        write_table(self.folder / "probes.csv", ["time", "soft.A.ux", "soft.reaction_foot_x", "soft.reaction_foot_y",
                                                 "soft.moment_foot_z"], [[0, 0, 9, 100, 50]])
        self.assertIn("safety 8 at 0 s", dict(stability(Results(self.folder)))["overturning of soft.foot"])

    def test_without_a_moment_there_is_sliding_alone_and_only_with_a_friction(self) -> None:
        write_table(self.folder / "probes.csv", ["time", "A.ux", "reaction_foot_x", "reaction_foot_y"],
                    [[0, 0, 30, 100]])
        self.assertEqual(stability(Results(self.folder)), [])
        (asked, text), = stability(Results(self.folder), 0.6)
        self.assertEqual(asked, "sliding of foot")
        self.assertIn("safety 2 with friction 0.6", text)

    def test_safety_in_space_at_any_angle(self) -> None:
        """A footing of 4 m by 2 m turned in the plan; resultant 0.5 m along its long side and 0.25 m along its short
        one, or along one of them: the nearer edge counts."""
        for angle in (0.0, 0.5, 2.4):
            turn = turned(3, angle)
            block = [[x, y, z] for z in (1, 2) for x, y in ((-2, -1), (2, -1), (2, 1), (-2, 1))]
            self.structure((np.array(block) @ turn.T + [7, 3, 0]).tolist())
            for place, safety in (([0.5, 0], 4), ([0, 0.25], 4), ([0.5, 0.5], 2), ([-1, 0.25], 2)):
                arm = turn @ np.array([*place, 0])
                force = np.array([30.0, 40.0, 100.0])
                moment = np.cross(arm, force)
                write_table(self.folder / "probes.csv",
                            ["time", "A.uz", *(f"{kind}_foot_{axis}" for kind in ("reaction", "moment")
                                               for axis in "xyz")], [[0, 0, *force, *moment]])
                self.write("fem/resolved_config.json", json.dumps({"fem.json": {"gravity": [0, 0, -9.81]}}))
                found = dict(stability(Results(self.folder), 1.0))
                self.assertIn("safety 2 with friction 1, 2 at the end", found["sliding of foot"])
                self.assertIn(f"safety {safety:g} at 0 s", found["overturning of foot"])

    def test_middle_of_an_underside_is_that_of_its_area(self) -> None:
        self.structure([[0, 0, 0], [3, 0, 0], [0, 3, 0], [0, 0, 5]])  # a triangle: its middle is at (1, 1)
        below = underside_of(Results(self.folder).structures[0], 2, 3)
        np.testing.assert_allclose(sorted(below.offsets), sorted([1, 1, 1 / np.sqrt(2)]))


class Option(ScriptCase):
    def test_friction_that_is_none(self) -> None:
        for value in ("-1", "nan"):
            done = self.script("report", self.folder, f"--base-friction={value}")
            self.assertEqual(done.returncode, 2)
            self.assertIn("--base-friction: found", done.stderr)


if __name__ == "__main__":
    unittest.main()
