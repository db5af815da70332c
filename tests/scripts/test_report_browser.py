#!/usr/bin/python3
# SPDX-License-Identifier: BSD-3-Clause
"""The page of scripts/report in a browser: no error in its console, verdict and curves in its document, working
controls.

Exit code 77, not run, where there is no chromium (scripts/setup: tests_of_optional).
"""

import html
import json
import re
import shutil
import subprocess
import sys
import unittest
from unittest import mock

import numpy as np
from made_up_results import KINDS, write_boulder, write_kind, write_rigid_walls, write_series, write_space_results
from script_case import ScriptCase

CHROMIUM = shutil.which("chromium")
# Uses the page as a reader does, and writes what it finds into the document.
READER = """
<script>
const found = {fetched: performance.getEntriesByType("resource").length};
const curves = (chart) => [...document.querySelectorAll(`#chart-${chart} path.curve`)];
const paths = (chart) => curves(chart).map((each) => each.getAttribute("d"));
found.force = paths("force").map((d) => d.length);
const slider = document.querySelector("#residuals input");
const step = () => document.getElementById("residuals-step").textContent;
if (slider) {
  found.longest = step();
  const before = paths("residual-displacement")[0];
  slider.value = 0;
  slider.dispatchEvent(new Event("input"));
  found.firstStep = step();
  found.otherCurve = paths("residual-displacement")[0] !== before;
  document.querySelectorAll("#residuals .controls button")[1].click();
  found.failedStep = step();
}
const button = document.querySelector("#chart-force .legend button");
if (button) {
  button.click();
  found.hidden = document.querySelectorAll("#chart-force path.curve").length;
  document.querySelector("#chart-force .legend button").click();
  const svg = document.querySelector("#chart-force svg");
  const box = svg.getBoundingClientRect();
  const at = (share) => ({clientX: box.left + share * box.width, clientY: box.top + 20, bubbles: true});
  const labels = () => [...svg.querySelectorAll("text")].map((text) => text.textContent).join();
  const whole = labels();
  svg.dispatchEvent(new PointerEvent("pointerdown", at(0.5)));
  svg.dispatchEvent(new PointerEvent("pointermove", at(0.6)));
  window.dispatchEvent(new PointerEvent("pointerup", at(0.6)));
  found.enlarged = labels() !== whole;
  svg.dispatchEvent(new Event("dblclick"));
  found.back = labels() === whole;
}
const canvas = document.querySelector("#scene canvas.flat");
const turning = document.getElementById("space");
found.lacking = (document.getElementById("space-lacking") || {textContent: ""}).textContent;
const answers = document.getElementById("answers");
found.cut = answers.scrollWidth - answers.clientWidth;
found.stacked = [...answers.querySelectorAll("td")].some((cell) => cell.offsetLeft <= answers.offsetLeft);
found.wide = document.documentElement.scrollWidth - window.innerWidth;
if (turning) {
  const shot = () => {  // as soon as it is drawn: later the browser may have cleared it
    document.querySelector("#scene input").dispatchEvent(new Event("input"));
    const copy = Object.assign(document.createElement("canvas"), {width: turning.width, height: turning.height});
    const pen = copy.getContext("2d");
    pen.drawImage(turning, 0, 0);
    return pen.getImageData(0, 0, copy.width, copy.height).data;
  };
  const differ = (one, other) => one.some((value, k) => value !== other[k]);
  const drag = (from, to, more) => {
    const event = (name, [clientX, clientY]) => turning.dispatchEvent(
      new PointerEvent(name, {clientX, clientY, pointerId: 1, buttons: 1, ...more}));
    event("pointerdown", from);
    event("pointermove", to);
    event("pointerup", to);
  };
  const first = shot();
  let count = 0;
  const colours = new Set();
  for (let k = 0; k < first.length; k += 4) {
    if (first[k + 3]) {
      ++count;
      colours.add(65536 * first[k] + 256 * first[k + 1] + first[k + 2]);
    }
  }
  const space = found.space = {painted: count / (first.length / 4), colours: colours.size, size: turning.clientWidth};
  const changes = (act) => {
    act();
    const changed = differ(shot(), first);
    document.getElementById("space-reset").click();
    return changed && !differ(shot(), first);
  };
  const colour = document.getElementById("colour-structure");
  const choose = (value) => {
    colour.value = value;
    colour.dispatchEvent(new Event("change"));
  };
  if (colour) {
    choose(-1);
    space.grey = differ(shot(), first);
    choose(0);
    space.coloured = !differ(shot(), first);
  }
  const key = (name, shiftKey) => turning.dispatchEvent(new KeyboardEvent("keydown", {key: name, shiftKey}));
  space.turned = changes(() => drag([10, 10], [60, 30]));
  space.panned = changes(() => drag([10, 10], [60, 30], {shiftKey: true}));
  space.zoomed = changes(() => turning.dispatchEvent(new WheelEvent("wheel", {deltaY: -200, cancelable: true})));
  space.keys = ["ArrowLeft", "ArrowUp", "+", "-"].every((name) => changes(() => key(name)))
    && changes(() => key("ArrowLeft", true));
  space.pinched = changes(() => {
    const touch = (name, pointerId, clientX) => turning.dispatchEvent(
      new PointerEvent(name, {pointerId, clientX, clientY: 50, pointerType: "touch"}));
    touch("pointerdown", 1, 50);
    touch("pointerdown", 2, 100);
    touch("pointermove", 2, 180);
    for (const id of [1, 2]) touch("pointerup", id, 50);
  });
  const time = document.querySelector("#scene input");
  time.value = 0;
  time.dispatchEvent(new Event("input"));
  space.moved = differ(shot(), first);
  space.frame = turning.dataset.drawn;
  time.value = time.max;
  time.dispatchEvent(new Event("input"));
  document.getElementById("space-toggle").click();
  space.hidden = turning.clientWidth === 0 && canvas.clientWidth > 0;
}
if (!document.getElementById("scene").hidden) {
  const {width, height} = canvas;
  const second = Object.assign(document.createElement("canvas"), {width, height});
  const copy = second.getContext("2d", {willReadFrequently: true});
  const pixels = () => {
    copy.clearRect(0, 0, width, height);
    copy.drawImage(canvas, 0, 0);
    return copy.getImageData(0, 0, width, height).data;
  };
  const painted = (data) => { let n = 0; for (let k = 3; k < data.length; k += 4) n += data[k] > 0; return n; };
  const last = pixels();
  found.painted = painted(last) / (width * height);
  found.red = last.reduce((n, r, k) => n + (k % 4 === 0 && r > 120 && last[k + 1] < 60 && last[k + 2] < 60), 0);
  const brown = (r, g, b) => r > 80 && r <= 141 && r > g && g > b && r - b <= 30;
  found.boulder = last.reduce((n, r, k) => n + (k % 4 === 0 && brown(r, last[k + 1], last[k + 2])), 0);
  const time = document.querySelector("#scene input");
  time.value = 0;
  time.dispatchEvent(new Event("input"));
  found.moved = pixels().some((value, k) => value !== last[k]);
  found.frame = canvas.dataset.drawn;
}
document.body.dataset.found = JSON.stringify(found);
</script>
</body>"""


class Browser(ScriptCase):
    def look(self, text: str, *options: str) -> tuple[str, list[str]]:
        """The document after its programs have run, and the lines of the console but those on the speed of WebGL."""
        file = self.write("page.html", text)
        done = subprocess.run(
            [CHROMIUM, "--headless", "--no-sandbox", "--disable-gpu", "--enable-unsafe-swiftshader",
             "--enable-logging=stderr", "--v=0", "--virtual-time-budget=5000", *options,
             f"--user-data-dir={self.folder / 'browser'}", "--dump-dom",
             f"file://{file}"],
            capture_output=True, text=True, timeout=600, check=False)
        self.assertEqual(done.returncode, 0, done.stderr[-2000:])
        return done.stdout, [line for line in done.stderr.splitlines()
                             if ":CONSOLE" in line and "GL Driver Message (OpenGL, Performance" not in line]

    def read(self, folder, *options: str, words: tuple = ()) -> tuple[str, dict]:
        """words: further ones of scripts/report; options: of the browser."""
        done = self.python_script("report", folder, "--out", self.folder / "report.html", *words)
        self.assertEqual(done.returncode, 0, done.stderr)
        text = (self.folder / "report.html").read_text(encoding="utf-8")
        dom, console = self.look(text.replace("</body>", READER), *options)
        self.assertEqual(console, [])
        self.assertIn('data-ready="yes"', dom)
        return dom, self.found_in(dom)

    @staticmethod
    def found_in(dom: str) -> dict:
        return json.loads(html.unescape(re.search(r'data-found="([^"]*)"', dom)[1]))

    def test_an_error_would_be_seen(self) -> None:
        _, console = self.look("<!DOCTYPE html><html><body><script>nothing.here();</script></body></html>")
        self.assertEqual(len(console), 1)
        self.assertIn("nothing is not defined", console[0])

    def test_each_kind(self) -> None:
        for kind in KINDS:
            with self.subTest(kind):
                dom, found = self.read(write_kind(self.folder / kind, kind))
                self.assertGreaterEqual(len(re.findall(r'<li class="(?:good|note|bad)"', dom)), 4)
                self.assertEqual(found["fetched"], 0)
                self.assertEqual(len(found["force"]), 2)
                self.assertGreater(min(found["force"]), 1000)
                self.assertEqual(found["hidden"], 1)
                self.assertIs(found["enlarged"] and found["back"], True)
                self.assertIn("5 iterations, converged", found["longest"])
                self.assertIn("step 1 from t = 0 s", found["firstStep"])
                self.assertIs(found["otherCurve"], True)
                self.assertIn("step 251" if kind == "cut" else "step 1 ", found["failedStep"])
                self.assertIn("diverged" if kind == "cut" else "converged", found["failedStep"])
                self.assertGreater(found["painted"], 0.1)
                self.assertIs(found["moved"], True)
                self.assertEqual(found["frame"], "0")

    def test_two_runs_beside_each_other(self) -> None:
        """On a phone the answers of both stand below each other, and nothing is cut off."""
        one = write_kind(self.folder / "a_run_with_a_long_name", "finished")
        other = write_kind(self.folder / "and_another_run_with_one", "cut")
        for options, stacked in (((), False), (("--window-size=400,800", "--force-device-scale-factor=2"), True)):
            with self.subTest(options):
                _, found = self.read(one, *options, words=("--compare", other))
                self.assertEqual((found["cut"], found["stacked"]), (0, stacked))
                self.assertLessEqual(found["wide"], 0)
                self.assertEqual(len(found["force"]), 4)

    def test_with_rigid_walls(self) -> None:
        _, found = self.read(write_rigid_walls(write_kind(self.folder / "walls", "finished")))
        self.assertLess(found["boulder"], 100)
        self.assertGreater(found["painted"], 0.1)
        self.assertIs(found["moved"], True)

    def test_in_space(self) -> None:
        folder = write_boulder(write_space_results(self.folder / "space"), 3)
        for options in ((), ("--window-size=400,800", "--force-device-scale-factor=2")):
            with self.subTest(options):
                _, found = self.read(folder, *options)
                self.expect_flat_view(found)
                self.assertGreater(found["boulder"], 1000)
                self.assertEqual((found["lacking"], found["fetched"]), ("", 0))
                self.assertLessEqual(found["wide"], 0)
                space = found["space"]
                self.assertGreater(found["red"], 50)
                self.assertGreater(space["painted"], 0.1)
                self.assertGreater(space["colours"], 100)
                for what in ("turned", "panned", "zoomed", "keys", "pinched", "moved", "hidden", "grey", "coloured"):
                    self.assertIs(space[what], True, what)
                self.assertEqual(space["frame"], "0")

    def test_in_space_without_webgl(self) -> None:
        _, found = self.read(write_boulder(write_space_results(self.folder / "space"), 3), "--disable-3d-apis")
        self.expect_flat_view(found)
        self.assertIn("needs WebGL, which this browser does not have; the flat view is shown.", found["lacking"])
        self.assertNotIn("space", found)

    def test_in_space_without_the_library(self) -> None:
        from plotting.results import Results  # noqa: PLC0415
        from reporting import library, page  # noqa: PLC0415
        folder = write_boulder(write_space_results(self.folder / "space"), 3)
        with mock.patch.object(library, "PLACES", ()):
            dom, console = self.look(page.page(Results(folder)).replace("</body>", READER))
        self.assertEqual(console, [])
        self.assertIn("libjs-three: install it and write this page once more.", self.found_in(dom)["lacking"])

    def test_ropes_in_space_without_soil(self) -> None:
        folder = write_space_results(self.folder / "ropes")
        for path in (folder / "mpm").glob("soil*"):
            path.unlink()
        ends = np.array([[0.0, 0, 0], [1, 0, 0.3], [1, 1, 0], [0, 1, 0.3]])
        cells = np.array([[0, 1], [1, 2], [2, 3], [3, 0]])
        write_series(folder / "fem", "structure", [(t, ends * (1 + t), cells, {"displacement": ends * t})
                                                   for t in (0.0, 0.5)])
        _, found = self.read(folder)
        self.assertEqual(found["frame"], "0")
        for what in ("turned", "panned", "zoomed", "keys", "pinched", "moved", "hidden"):
            self.assertIs(found["space"][what], True, what)

    def test_boulders_in_2d(self) -> None:
        folder = write_boulder(write_kind(self.folder / "flat", "finished"), 2)
        _, found = self.read(folder)
        self.expect_flat_view(found)
        self.assertGreater(found["boulder"], 1000)
        self.assertEqual(found["lacking"], "")

    def expect_flat_view(self, found: dict) -> None:
        self.assertGreater(found["painted"], 0.1)
        self.assertIs(found["moved"], True)
        self.assertEqual(found["frame"], "0")

    def test_a_run_that_has_just_begun(self) -> None:
        self.write("begun/resolved_config.json", json.dumps({"coupler.json": {"time": {"end": 1}}}))
        dom, found = self.read(self.folder / "begun")
        self.assertEqual(found["force"], [])
        for section in ("scene", "curves", "residuals"):
            self.assertRegex(dom, f'<section id="{section}" hidden')


if __name__ == "__main__":
    if not CHROMIUM:
        print("no chromium: not run")
        sys.exit(77)
    unittest.main()
