#!/usr/bin/python3
# SPDX-License-Identifier: BSD-3-Clause
"""scripts/report: its page is whole, says what the run was, and needs nothing from outside."""

import base64
import html
import json
import re
import unittest
from html.parser import HTMLParser

import numpy as np
from made_up_results import (AMPLITUDE, FORCE, KINDS, REASON, soil_frames, write_kind, write_results,
                             write_rigid_walls, write_series, write_space_results)
from script_case import ScriptCase

from plotting.results import Results
from reporting.surfaces import loaded_surfaces

VOID = {"meta", "link", "br", "hr", "img", "input"}


class Page(HTMLParser):
    """Checks that tags are nested; collects JSON blocks, list items and table rows."""

    def __init__(self, text: str) -> None:
        super().__init__()
        self.open: list[str] = []
        self.blocks: dict[str, dict] = {}
        self.items: list[tuple[dict, str]] = []
        self.ids: list[str] = []
        self._block = ""
        self.faults: list[str] = []
        self.feed(text)
        self.close()

    def handle_starttag(self, tag, attributes) -> None:
        named = dict(attributes)
        if "id" in named:
            self.ids.append(named["id"])
        if tag in VOID:
            return
        self.open.append(tag)
        if tag == "script" and named.get("type") == "application/json":
            self._block = named["id"]
        if tag == "li":
            self.items.append((named, ""))

    def handle_endtag(self, tag) -> None:
        if not self.open or self.open.pop() != tag:
            self.faults.append(f"</{tag}> at {self.getpos()}")
        self._block = ""

    def handle_data(self, data) -> None:
        if self._block:
            self.blocks[self._block] = json.loads(data)
        elif self.open and self.open[-1] == "li":
            self.items[-1] = (self.items[-1][0], self.items[-1][1] + data)


class ReportCase(ScriptCase):
    def report(self, folder=None) -> Page:
        done = self.python_script("report", folder or self.folder, "--out", self.folder / "page" / "report.html")
        self.assertEqual((done.returncode, done.stderr), (0, ""))
        self.text = (self.folder / "page" / "report.html").read_text(encoding="utf-8")
        page = Page(self.text)
        self.assertEqual((page.faults, page.open), ([], []))
        self.assertEqual(len(page.ids), len(set(page.ids)))
        return page

    def verdict(self, page: Page) -> list[tuple[str, str, str]]:
        return [(named["class"], named["data-topic"], text) for named, text in page.items]


class Pages(ReportCase):
    def test_each_kind_has_the_words_of_the_verdict(self) -> None:
        from plotting.live import Run  # noqa: PLC0415
        from plotting.verdict import headline, verdict  # noqa: PLC0415
        for kind in KINDS:
            with self.subTest(kind):
                folder = write_kind(self.folder / kind, kind)
                page = self.report(folder)
                run = Run(folder)
                run.read_on()
                self.assertEqual(self.verdict(page), [(each.kind, each.topic, each.text) for each in verdict(run)])
                self.assertGreaterEqual(len(page.items), 4)
                self.assertIn(f'<p id="headline" class="{run.state().value}">{headline(run)}</p>', self.text)
                self.assertEqual(set(page.blocks), {"charts-data", "residuals-data", "scene-data"})
                if kind == "failed":
                    self.assertIn(html.escape(REASON), self.text)
                    self.assertNotIn("<no>", self.text)

    def test_nothing_from_outside(self) -> None:
        write_kind(self.folder, "finished")
        self.report()
        self.assertEqual(re.findall(r"https?:|//[a-z0-9-]+\.[a-z]|@import|<link|url\(|<!--", self.text), [])
        self.assertEqual(re.findall(r"\bsrc=", self.text), [])
        self.assertLess(len(self.text), 1e6)

    def test_default_place(self) -> None:
        write_kind(self.folder, "finished")
        done = self.python_script("report", self.folder)
        self.assertEqual(done.stdout.strip(), str(self.folder / "report.html"))
        self.assertTrue((self.folder / "report.html").exists())

    def test_settings_versions_and_how_to_repeat(self) -> None:
        write_kind(self.folder, "stopped")
        files = json.loads((self.folder / "resolved_config.json").read_text())
        files["coupler.json"]["participants"] = {"structure": {"command": ["/bin/wall", "<stiff>"]}}
        (self.folder / "resolved_config.json").write_text(json.dumps(files))
        self.write("mpm/resolved_config.json", json.dumps({"mpm.json": {
            "basis": "gimp", "grid": {"box": {"low": [0, 0], "high": [1, 1], "cells": [4, 5], "type": "quad4"}},
            "bodies": [{"name": "sand", "mesh": {"file": "heap.msh"}, "points_per_cell": 4,
                        "material": {"law": "mohr_coulomb", "friction_angle": 33}}]}}))
        self.write("fem/resolved_config.json", json.dumps({"fem.json": {
            "mesh": {"file": "net.msh"}, "materials": [{"group": "posts", "law": "beam", "density": 7850},
                                                       {"group": "net", "law": "cable", "density": 7800}]}}))
        self.report()
        for words in ("dt 0.001 s", "wall: soil and structure",
                      "“posts” beam: density 7850; “net” cable: density 7800, mesh net.msh",
                      "mohr coulomb: friction angle 33, mesh heap.msh, 4 points a cell", "4 × 5 quad4, basis gimp",
                      "save coupler.json fem.json mpm.json from this page",
                      "It also needs: heap.msh; net.msh; /bin/wall &lt;stiff&gt;.", "--restart", '<th>Gabion</th>'):
            self.assertIn(words, self.text)
        shown = re.search(r'data-file="mpm.json".*?<pre>(.*?)</pre>', self.text, re.DOTALL)[1]
        self.assertEqual(json.loads(html.unescape(shown))["bodies"][0]["name"], "sand")

    def test_what_is_missing_or_broken_is_left_out(self) -> None:
        write_kind(self.folder, "failed")
        for name in ("probes.csv", "iterations.csv"):
            (self.folder / name).unlink()
        (self.folder / "mpm" / "soil.xdmf").write_text("<Xdmf><Domain>")
        page = self.report()
        self.assertEqual(set(page.blocks), {"charts-data"})
        self.assertNotIn("displacement", [chart["name"] for chart in page.blocks["charts-data"]])
        self.assertIn(("note", "page"), [item[:2] for item in self.verdict(page)])
        self.assertIn("soil.xdmf: not a complete XDMF file", self.text)

    def test_tables_that_are_being_written(self) -> None:
        """Half a number at the end of each, whose column is one of numbers all the same; frames not yet indexed."""
        write_kind(self.folder, "unfinished")
        for name in ("steps.csv", "iterations.csv", "probes.csv"):
            lines = (self.folder / name).read_text().splitlines(keepends=True)
            (self.folder / name).write_text("".join(lines[:300]) + lines[300].strip() + "e-")
        (self.folder / "fem" / "structure_000002.h5").write_bytes(b"half")
        page = self.report()
        self.assertEqual(set(page.blocks), {"charts-data", "residuals-data"})
        self.assertEqual(len(page.blocks["charts-data"][0]["curves"][0]["x"]), 299)
        self.assertIn(("note", "page"), [item[:2] for item in self.verdict(page)])

    def test_a_run_before_its_first_step(self) -> None:
        write_kind(self.folder, "unfinished")
        for name in ("steps.csv", "iterations.csv", "probes.csv"):
            lines = (self.folder / name).read_text().splitlines(keepends=True)
            (self.folder / name).write_text("".join(lines[:1 + (name == "probes.csv")]))
        page = self.report()
        self.assertEqual(set(page.blocks), {"scene-data"})

    def test_a_run_that_has_just_begun(self) -> None:
        self.write("resolved_config.json", json.dumps({"coupler.json": {"time": {"end": 1}}}))
        page = self.report()
        self.assertEqual(page.blocks, {})
        self.assertIn("Running: 0 steps to t = 0 s of 1 s (0 %)", self.text)

    def test_nothing_there(self) -> None:
        empty = self.python_script("report", self.folder)
        self.assertEqual(empty.returncode, 2)
        self.assertIn("nothing of a run here", empty.stderr)
        self.assertEqual(list(self.folder.iterdir()), [])
        self.assertIn("no such results folder", self.python_script("report", self.folder / "none").stderr)

    def test_a_full_disk(self) -> None:
        """The page is whole or it is that of before."""
        write_results(self.folder)
        page = self.write("report.html", "an earlier page")
        before = sorted(self.folder.iterdir())
        with self.full_disk(5000):
            done = self.python_script("report", self.folder)
        self.assertEqual((done.returncode, done.stderr), (2, f"scripts/report: [Errno 27] File too large: '{page}'\n"))
        self.assertEqual(page.read_text(), "an earlier page")
        self.assertEqual(sorted(self.folder.iterdir()), before)


class Data(ReportCase):
    def test_curves(self) -> None:
        write_results(self.folder)
        charts = {chart["name"]: chart for chart in self.report().blocks["charts-data"]}
        force = {curve["name"]: curve for curve in charts["force"]["curves"]}
        self.assertEqual(max(force["fx"]["y"]), FORCE)
        self.assertIn("[N/m]", charts["force"]["title"])
        moved = {curve["name"]: curve for curve in charts["displacement"]["curves"]}
        self.assertEqual(set(moved), {"structure.A.ux", "structure.A.uy"})
        self.assertAlmostEqual(max(moved["structure.A.ux"]["y"]), 2 * AMPLITUDE, delta=1e-5)
        self.assertEqual([curve["name"] for curve in charts["iterations"]["curves"]],
                         ["coupling", "Newton, soil", "Newton, structure"])
        self.assertIn("whole", [curve["name"] for curve in charts["wall"]["curves"]])

    def test_thin_curves_keep_their_peaks(self) -> None:
        from reporting.curves import BINS, curve  # noqa: PLC0415
        x = np.linspace(0, 1, 100_001)
        y = np.sin(40 * x)
        y[[33_333, 44_444, 55_555]] = 7, -9, np.nan
        kept = curve("", x, y)
        self.assertLessEqual(len(kept["x"]), 4 * BINS)
        known = [value for value in kept["y"] if value is not None]
        self.assertEqual((max(known), min(known)), (7, -9))
        self.assertEqual((kept["x"][0], kept["x"][-1]), (0, 1))
        self.assertEqual(kept["x"][kept["y"].index(7)], 0.33333)

    def test_residuals(self) -> None:
        write_kind(self.folder, "cut")
        data = self.report().blocks["residuals-data"]
        at = {name: k for k, name in enumerate(data["columns"])}
        tries = [row for row in data["tries"] if row[at["step"]] == 251]
        self.assertEqual([row[at["status"]] for row in tries], ["diverged"] * 3 + ["converged"])
        self.assertEqual(tries[-1][at["displacement_residual"]], [10.0**-k for k in range(4, 9)])
        self.assertEqual(tries[-1][at["force_residual"]], [None, *(10.0**-k for k in range(1, 5))])
        self.assertEqual(tries[0][at["displacement_limit"]], [2e-8] * 2)
        self.assertEqual(data["all"], len(data["tries"]))

    def test_many_residuals(self) -> None:
        """Tries that failed and the longest ones are kept, and the rest thinned out."""
        from reporting import curves  # noqa: PLC0415
        write_kind(self.folder, "cut")
        allowed, curves.MAX_ROWS = curves.MAX_ROWS, 800
        self.addCleanup(setattr, curves, "MAX_ROWS", allowed)
        data = self.report().blocks["residuals-data"]
        self.assertLess(len(data["tries"]), data["all"])
        self.assertEqual([row[3] for row in data["tries"] if row[0] == 251].count("diverged"), 3)
        self.assertEqual([row[0] for row in data["tries"]], sorted(row[0] for row in data["tries"]))

    def test_frames(self) -> None:
        """Positions to 16 bits of the window, values to 8 bits of their range."""
        write_results(self.folder)
        scene = self.report().blocks["scene-data"]
        low, high = np.array(scene["low"]), np.array(scene["high"])
        for packed, (time, points, _, fields) in zip(scene["soil"], soil_frames()):
            places = np.frombuffer(base64.b64decode(packed["points"]), "<u2").reshape(-1, 2)
            self.assertLess(np.abs(low + places / 65535 * (high - low) - points).max(), (high - low).max() / 65535)
            field = scene["fields"][0]
            self.assertEqual(field["label"], "size of displacement [m]")
            values = np.frombuffer(base64.b64decode(packed["values"][0]), "u1") / 255 * (field["high"] - field["low"])
            exact = np.minimum(fields["displacement"][:, 0], field["high"])
            self.assertLess(np.abs(values - exact).max(), (field["high"] - field["low"]) / 255, time)
        wall, = scene["structures"]
        self.assertEqual((wall["corners"], len(wall["frames"])), (4, len(scene["times"])))
        faces = np.frombuffer(base64.b64decode(wall["faces"]), "<u4")
        self.assertEqual((len(faces), faces.max()), (20 * 4, 32))

    def test_wall_that_only_a_pool_presses_on(self) -> None:
        """Frames of its surface have no pressure, its force is in the tables: an upright wall counts, a bed not."""
        folder = write_rigid_walls(write_results(self.folder))
        config = folder / "mpm" / "resolved_config.json"
        settings = json.loads(config.read_text())
        settings["mpm.json"]["rigid_walls"].append({"name": "gate"})
        upright = np.array([[0.1, 0.3, 0], [0.1, 0.2, 0], [0.1, 0.0, 0]])
        write_series(folder / "mpm", "contact_gate", [(time, upright, np.array([[0, 1], [1, 2]]), {
            "pressure": np.zeros(2)}) for time in np.linspace(0, 0.5, 6)])
        for pools, found in (([], set()), ([{"level": 0.2}], {"gate"})):
            settings["mpm.json"]["pools"] = pools
            config.write_text(json.dumps(settings))
            results = Results(folder)
            self.assertEqual(set(loaded_surfaces(results)) & {"bed", "lid", "gate"}, found)

    def test_rigid_walls(self) -> None:
        """One at rest is there once, one that moves for each frame in which it acts."""
        scene = self.report(write_rigid_walls(write_results(self.folder))).blocks["scene-data"]
        self.assertEqual(scene["standing"], [[0, 1], [0, 2], [0, 3], [0], [0], [0]])
        lines = [np.frombuffer(base64.b64decode(wall["line"]), "<f4").reshape(-1, 2, 2) for wall in scene["walls"]]
        for line, height in zip(lines, (0, 0.2, 0.19, 0.18), strict=True):
            np.testing.assert_allclose(line[..., 1], height, rtol=1e-6)
        behind = np.frombuffer(base64.b64decode(scene["walls"][1]["strokes"]), "<f4").reshape(-1, 2, 2)
        self.assertTrue((behind[:, 1, 1] > behind[:, 0, 1]).all())

    def test_frames_in_space_and_of_few_bytes(self) -> None:
        from reporting import frames  # noqa: PLC0415
        write_space_results(self.folder)
        allowed, frames.MAX_BYTES = frames.MAX_BYTES, 60_000
        self.addCleanup(setattr, frames, "MAX_BYTES", allowed)
        scene = self.report().blocks["scene-data"]
        self.assertEqual(scene["labels"], ["x [m]", "z [m]"])
        self.assertEqual((scene["points"], scene["shown"]), (6400, 1000))
        self.assertEqual(len(scene["times"]), 6)
        self.assertLess(len(json.dumps(scene)), 1.2 * 60_000 * 4 / 3)


if __name__ == "__main__":
    unittest.main()
