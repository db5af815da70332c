#!/usr/bin/python3
# SPDX-License-Identifier: BSD-3-Clause
"""scripts/report: its answers, the moment of each surface about its own foot, pressure over the height of faces."""

import csv
import json
import unittest
from pathlib import Path
from unittest import mock

import numpy as np
from made_up_results import AMPLITUDE, CONTACT, END, FORCE, write_contact, write_results, write_table
from script_case import ScriptCase

from plotting.results import Frame, Results
from reporting.answers import answers, residual
from reporting.curves import chart, charts, compared
from reporting.surfaces import Loads, faces_of, foot_of, moments


class Frames:
    """Frames of a surface that never was."""

    def __init__(self, points: list, cells: list, pressure: list) -> None:
        padded = np.column_stack([np.array(points, dtype=float), np.zeros((len(points), 3 - len(points[0])))])
        self.frames = [Frame(k, padded, np.array(cells), {"pressure": np.array(each, dtype=float)})
                       for k, each in enumerate(pressure)]
        self.times = np.arange(len(pressure), dtype=float)

    def __len__(self) -> int:
        return len(self.frames)

    def frame(self, k: int) -> Frame:
        return self.frames[k]

    def nearest(self, time: float) -> int:
        return int(np.argmin(np.abs(self.times - time)))


# Wall of 0.5 m by 2 m at x = 3, its corners in the order that has the soil to the right.
WALL = [[3.5, 1], [3.5, 3], [3, 3], [3, 2], [3, 1]], [[0, 1], [1, 2], [2, 3], [3, 4]]


def by_question(results: Results) -> dict[str, str]:
    return dict(answers(results))


class Surfaces(ScriptCase):
    def test_moment_moves_with_the_force(self) -> None:
        force, at = np.array([[2.0, -3.0]]), np.array([7.0, 5.0])
        for about in (np.zeros(2), np.array([-4.0, 11.0])):
            moment = np.array([[(at - about)[0] * -3.0 - (at - about)[1] * 2.0]])
            moved = Loads("a", np.zeros(1), force, moment, about).moment_about(np.array([3.25, 1.0]))
            self.assertAlmostEqual(moved[0, 0], 3.75 * -3.0 - 4.0 * 2.0)
        force, at, about = np.array([[2.0, -3.0, 5.0]]), np.array([7.0, 5.0, 1.0]), np.array([1.0, 2.0, 3.0])
        moved = Loads("a", np.zeros(1), force, np.cross(at - about, force),
                      about).moment_about(np.array([4.0, 4.0, 0.5]))
        np.testing.assert_allclose(moved, np.cross([3.0, 1.0, 0.5], force))

    def test_foot_is_the_middle_of_what_is_lowest(self) -> None:
        np.testing.assert_allclose(foot_of(Frames(*WALL, [[0] * 4]).frame(0), 1, 2), [3.25, 1])

    def test_faces_of_a_line(self) -> None:
        left, right = sorted(faces_of("wall", Frames(*WALL, [[0, 0, 0, 0], [1, 9, 3, 5]]), 2, 1),
                             key=lambda face: face.side,
                             reverse=True)
        self.assertEqual((left.side, right.side), ("-x", "+x"))
        np.testing.assert_allclose(left.height, [0.5, 1.5])
        np.testing.assert_allclose(left.pressure, [[0, 0], [5, 3]])
        np.testing.assert_allclose(right.pressure, [[0], [1]])

    def test_faces_in_space(self) -> None:
        points = [[0, 0, 0], [0, 1, 0], [0, 3, 0], [0, 0, 1], [0, 1, 1], [0, 3, 1]]
        cells = [[0, 3, 4, 1], [1, 4, 5, 2]]  # look to -x; one and two square metres at one height
        face, = faces_of("wall", Frames(points, cells, [[3, 6]]), 3, 2)
        self.assertEqual(face.side, "-x")
        np.testing.assert_allclose(face.pressure, [[5]])  # by area


class Answers(ScriptCase):
    def with_moments(self) -> Path:
        """Force FORCE along x on the surface `wall`, at a height of 1.5 m above its foot at (3.25, 1)."""
        folder = write_results(self.folder / "run")
        rows = list(csv.DictReader((folder / "steps.csv").read_text(encoding="utf-8").splitlines()))
        for row in rows:
            row |= {"wall.fx": row["fx"], "wall.fy": 0.0, "wall.mz": -2.5 * float(row["fx"])}
        with (folder / "steps.csv").open("w", newline="", encoding="utf-8") as file:
            writer = csv.DictWriter(file, list(rows[0]))
            writer.writeheader()
            writer.writerows(rows)
        resolved = json.loads((folder / "resolved_config.json").read_text(encoding="utf-8")) if (
            folder / "resolved_config.json").exists() else {}
        resolved.setdefault("coupler.json",
                            {})["interfaces"] = [{"name": "wall", "soil": "soil", "structure": "structure"}]
        (folder / "resolved_config.json").write_text(json.dumps(resolved), encoding="utf-8")
        return folder

    def test_peaks_residuals_and_impulse(self) -> None:
        found = by_question(Results(write_results(self.folder / "run")))
        force = found["force on the structure, x"]
        self.assertIn(f"{FORCE:g} N/m at 0.151 s; at the end {FORCE:g} N/m", force)
        self.assertIn(f"in the last tenth {FORCE:g} N/m on average, within 0 N/m", force)
        self.assertIn(f"impulse {FORCE * (END - CONTACT):.4g} N s/m", force)
        self.assertIn(f"{2 * AMPLITUDE:.4g} m", found["displacement structure.A.ux"])
        self.assertNotIn("force on the structure, y", found)  # zero

    def test_residual_of_a_vibration(self) -> None:
        """Ten whole periods about 0.5 in the last tenth, in steps of two sizes; what was before does not matter."""
        time = np.unique(np.concatenate([np.linspace(0, 9.5, 950), np.linspace(9, 10, 3001)]))
        values = np.where(time < 8.9, 70, 0.5 + 0.25 * np.sin(20 * np.pi * time))
        self.assertEqual(residual(time, values, "m"), "; in the last tenth 0.5 m on average, within 0.25 m")
        self.assertEqual(residual(time[:1], values[:1], "m"), "")

    def test_moments_are_about_the_foot(self) -> None:
        results = Results(self.with_moments())
        (results.folder / "mpm" / "soil.xdmf").unlink()  # its frames have no volumes
        with mock.patch.object(Results, "contacts", {"wall": Frames(*WALL, [[0] * 4, [1, 0, 2, 8e3]])}):
            (name, _, moment, foot), = moments(results)
            found = by_question(results)
            drawn = {each["name"]: each for each in charts(results)}
        self.assertEqual(name, "wall")
        np.testing.assert_allclose(foot, [3.25, 1])
        np.testing.assert_allclose(moment[-1], -1.5 * FORCE)
        self.assertIn(f"{-1.5 * FORCE:g} N m/m", found["moment on wall about its foot, z"])
        self.assertIn("8000 Pa at a height of 0.5 m above its foot at 1 s (of 2 frames)",
                      found["largest pressure on wall, side -x"])
        self.assertEqual(found["run-up on wall, side -x"], "1.5 m above its foot, first at 1 s: the highest facets "
                         "that soil pressed on, up to its crest")
        self.assertIn("no gauge measures the flow", found["impact coefficient of wall"])
        self.assertEqual(drawn["pressure-time-wall-x"]["curves"][0]["y"], [1, 1])
        self.assertEqual(drawn["pressure-wall-x"]["label"], "height above its foot [m]")
        self.assertEqual(drawn["pressure-wall-x"]["curves"][0]["y"], [8000, 2])
        self.assertAlmostEqual(drawn["moment-wall"]["curves"][0]["y"][-1], -1.5 * FORCE)

    def test_answers_of_files_that_can_be_read(self) -> None:
        """Frames of the soil without volumes: the volume past the wall is left out, the rest is not."""
        folder = self.with_moments()
        write_contact(folder)
        done = self.python_script("report", folder)
        self.assertEqual((done.returncode, done.stderr), (0, ""))
        text = (folder / "report.html").read_text(encoding="utf-8")
        self.assertIn("soil.xdmf: its points have no volume", text)
        self.assertEqual(text.count("Left out"), 1)
        for words in ("force on the structure, x", "moment on wall", "largest pressure on wall"):
            self.assertIn(f"<th>{words}", text)

    def test_boulders_are_a_part_of_the_force_and_no_surface(self) -> None:
        names = ["time", "soil.rock_1.qw", "soil.bed.fx", "soil.bed.mz", "soil.bed.boulders_fx",
                 "soil.wall.boulders_fx", "soil.wall.boulders_fy"]
        write_table(self.folder / "probes.csv", names, [[0, 1, 0, 0, 0, 0, 0], [0.5, 1, 0, 0, 7, 8, 0],
                                                        [0.75, 1, 0, 0, 7, 4, 0]])
        run = Results(self.folder)
        frames = Frames(*WALL, [[0] * 4, [1, 0, 2, 8e3]])
        with mock.patch.object(Results, "contacts", {"wall": frames, "rock_1": frames, "stone": frames}), \
                mock.patch.object(Results, "settings", return_value={"boulders": [{"name": "stone"}],
                                                                     "random_boulders": [{"name": "rock"}]}):
            found = by_question(run)
        self.assertEqual([each for each in found if "boulders" in each], ["force of boulders on wall, x"])
        self.assertEqual(found["force of boulders on wall, x"], "8 N/m at 0.5 s; at the end 4 N/m; impulse 5 N s/m")
        self.assertEqual([each for each in found if "pressure" in each],
                         ["largest pressure on wall, side +x", "largest pressure on wall, side -x"])

    def test_members(self) -> None:
        names = ["time", "wall.foot.N", "wall.foot.M_z", "wall.plastic_strain", "wall.plastic_strain_posts",
                 "net.axial_max_top_rope", "net.axial_min_top_rope", "net.axial_min_posts", "net.brake_run_top_rope"]
        write_table(self.folder / "probes.csv", names, [[0] * 9, [1, -2, 30, 0.01, 0.01, 5e4, 7, -3e3, 0.25],
                                                        [2, 1, 10, 0.01, 0, 1e4, 2, -1e3, 0.25]])
        self.assertEqual(by_question(Results(self.folder)), {
            "force in section wall.foot, N": "-2 N/m at 1 s; at the end 1 N/m",
            "moment in section wall.foot, M_z": "30 N m/m at 1 s; at the end 10 N m/m",
            "largest plastic strain of wall": "0.01 at 1 s; at the end 0.01",
            "largest plastic strain of wall.posts": "0.01 at 1 s; at the end 0",
            "largest axial force in the lines of net.top_rope": "5e+04 N/m at 1 s; at the end 1e+04 N/m",
            "least axial force in the lines of net.posts": "-3000 N/m at 1 s; at the end -1000 N/m",
            "largest run of a brake of net.top_rope": "0.25 m at 1 s; at the end 0.25 m"})

    def members_of(self, **columns: list[float]) -> dict[str, str]:
        """Answers of a run with these columns, __ in their names being a dot, at 0 s, 1 s ..."""
        rows = [[float(k), *row] for k, row in enumerate(zip(*columns.values()))]
        write_table(self.folder / "probes.csv", ["time", *(name.replace("__", ".") for name in columns)], rows)
        found = answers(Results(self.folder))
        self.assertEqual(len(dict(found)), len(found))
        return dict(found)

    def test_least_and_largest_are_no_sizes(self) -> None:
        found = self.members_of(s__axial_max_brace=[0, -100, -5000], s__axial_min_brace=[0, -200, -6000],
                                s__axial_min_rope=[0, 3, 4])
        self.assertEqual(found, {
            "largest axial force in the lines of brace": "0 N/m at 0 s; at the end -5000 N/m",
            "least axial force in the lines of brace": "-6000 N/m at 2 s; at the end -6000 N/m"})
        found = self.members_of(axial_min_brace=[0, -200, -6000, 8000], stress_max_brace=[0, -1e6, -9e6, 2e6],
                                stress_min_brace=[0, -1e6, -3e6, 7e6])
        self.assertEqual(found, {
            "least axial force in the lines of brace": "-6000 N/m at 2 s; at the end 8000 N/m",
            "largest stress in the bars of brace": "2e+06 Pa at 3 s; at the end 2e+06 Pa",
            "least stress in the bars of brace": "-3e+06 Pa at 2 s; at the end 7e+06 Pa"})

    def test_beams(self) -> None:
        self.assertEqual(self.members_of(s__shear_max_post=[0, 5, 3], s__bending_max_post=[0, 8, 2],
                                         s__torsion_max_post=[0, 0, 0]), {
            "largest shear force in the beams of post": "5 N/m at 1 s; at the end 3 N/m",
            "largest bending moment in the beams of post": "8 N m/m at 1 s; at the end 2 N m/m"})
        found = self.members_of(torsion_max_post=[0, -4])
        self.assertEqual(list(found), ["largest torsional moment in the beams of post"])

    def test_units_in_space(self) -> None:
        with mock.patch.object(Results, "per_metre", ""):
            found = self.members_of(s__axial_max_a=[0, 2], s__damage_work=[0, 3])
        self.assertEqual([*found.values()], ["2 N at 1 s; at the end 2 N", "3 J at 1 s; at the end 3 J"])

    def test_concrete_that_cracks(self) -> None:
        self.assertEqual(self.members_of(s__damage_work=[0, 5], s__crack_width=[0, 1e-3], s__crack_width_s=[0, 5e-4]), {
            "work of cracks and crushing of s": "5 J/m at 1 s; at the end 5 J/m",
            "widest crack of s": "0.001 m at 1 s; at the end 0.001 m",
            "widest crack of s.s": "0.0005 m at 1 s; at the end 0.0005 m"})

    def test_groups_of_several_structures_and_with_a_dot(self) -> None:
        found = self.members_of(one__axial_max_bars=[0, 7], two__axial_max_bars=[0, 9], two__axial_max_a__b=[0, 5])
        self.assertEqual([each.rpartition(" ")[2] for each in found], ["one.bars", "two.bars", "two.a.b"])
        for name in ("s__axial_max_a__b", "axial_max_a__b", "s__axial_max_a__N"):
            self.assertEqual([*self.members_of(**{name: [0, 7]})],
                             [f"largest axial force in the lines of a.{name[-1]}"])

    def test_energies_without_those_at_zero(self) -> None:
        results = Results(write_results(self.folder / "run"))
        table = results.table("steps.csv")
        with mock.patch("reporting.curves.history.energy_curves",
                        return_value=[(table, "soil.kinetic_energy"), (table, "dt")]):
            energy = next(each for each in charts(results) if each["name"] == "energy")
        self.assertEqual([each["name"] for each in energy["curves"]], ["soil.kinetic energy"])
        self.assertIn("dt", energy["hint"])


class Compared(ScriptCase):
    def test_curves_and_answers_of_another_run(self) -> None:
        write_results(self.folder / "one")
        write_results(self.folder / "two", scale=2.0)
        done = self.python_script("report", self.folder / "one", "--compare", self.folder / "two",
                                  "--out", self.folder / "page.html")
        self.assertEqual((done.returncode, done.stderr), (0, ""))
        text = (self.folder / "page.html").read_text(encoding="utf-8")
        row = text[text.index("<th>force on the structure, x</th>"):]
        row = row[:row.index("</tr>")]
        self.assertIn(f'<td data-run="one">{FORCE:g} N/m', row)
        self.assertIn(f'<td data-run="two">{2 * FORCE:g} N/m', row)
        self.assertIn('"name":"fx, two"', text)
        self.assertLess(text.index('id="answers"'), text.index('id="verdict"'))

    def test_chart_that_the_other_run_lacks(self) -> None:
        own = [chart("a", "a", [("f", np.arange(3), np.arange(3))])]
        self.assertEqual(compared(own, [], "b"), own)

    def test_folder_that_is_none(self) -> None:
        done = self.python_script("report", write_results(self.folder / "one"), "--compare", self.folder / "nowhere")
        self.assertEqual(done.returncode, 2)
        self.assertIn("nowhere", done.stderr)


if __name__ == "__main__":
    unittest.main()
