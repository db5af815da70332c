#!/usr/bin/python3
# SPDX-License-Identifier: BSD-3-Clause
"""The package gabion: scenes by path, keys of the programs, results as arrays.

Runs are in integration/test_python.py.
"""

import json
import os
import re
import shutil
import subprocess
import sys
import unittest
from pathlib import Path
from unittest import mock

import numpy as np
from script_case import ROOT, ScriptCase

import made_up_results as made_up

sys.path.insert(0, str(ROOT))
import gabion  # noqa: E402
from gabion import schema  # noqa: E402

MATERIAL = "mpm.json:/bodies/0/material"


class Scenes(ScriptCase):
    def setUp(self) -> None:
        super().setUp()
        self.scene = gabion.Scene(ROOT / "configs" / "granular_obstacle")

    def expect(self, path: str, value: object, *words: str) -> None:
        before = self.scene.options
        with self.assertRaises(gabion.SettingError) as raised:
            self.scene[path] = value
        for word in (path, *words):
            self.assertIn(word, str(raised.exception))
        self.assertEqual(self.scene.options, before)

    def test_values_are_read_and_set(self) -> None:
        self.assertEqual(self.scene[f"{MATERIAL}/density"], 2650)
        self.scene[f"{MATERIAL}/density"] = np.float64(1800)
        self.scene["fem.json:/gravity"] = np.array([0, -1])
        self.assertEqual(self.scene[f"{MATERIAL}/density"], 1800)
        self.assertEqual(self.scene.options, [f"{MATERIAL}/density=1800.0", "fem.json:/gravity=[0, -1]"])
        self.assertEqual(self.scene.settings["fem.json"]["gravity"], [0, -1])

    def test_a_copy_is_read(self) -> None:
        self.scene["fem.json:/gravity"][1] = 7
        self.assertNotEqual(self.scene["fem.json:/gravity"][1], 7)

    def test_a_later_change_counts(self) -> None:
        self.scene[f"{MATERIAL}/density"] = 1
        self.scene[MATERIAL] = {"law": "neo_hookean", "density": 2, "young_modulus": 1e6, "poisson_ratio": 0.3}
        self.scene[f"{MATERIAL}/density"] = 3
        self.assertEqual([option.partition("=")[0] for option in self.scene.options], [MATERIAL, f"{MATERIAL}/density"])
        self.assertEqual(self.scene[f"{MATERIAL}/density"], 3)

    def test_missing_objects_are_made(self) -> None:
        self.scene["mpm.json:/step_control/advective"] = 0.2
        self.assertEqual(self.scene.settings["mpm.json"]["step_control"]["advective"], 0.2)

    def test_unknown_keys_are_refused_with_the_known_ones(self) -> None:
        self.expect(f"{MATERIAL}/densty", 1, 'did you mean "density"?', "young_modulus")
        self.expect("mpm.jsn:/time/end", 1, 'did you mean "mpm.json"?')
        self.expect("time/end", 1, "allowed: FILE:/key/key")
        self.expect("mpm.json:/time/end/x", 1, "no key, it is a value")
        self.expect("mpm.json:/bodies/soil", 1, "the number of an entry")
        self.expect("mpm.json:/", {}, "allowed: FILE:/key")
        self.expect("mpm.json://end", 1, "an empty key")

    def test_values_that_are_not_allowed(self) -> None:
        self.expect(f"{MATERIAL}/density", -1, "found -1, allowed: > 0")
        self.expect(f"{MATERIAL}/density", "heavy", 'found "heavy", allowed: number')
        self.expect(f"{MATERIAL}/density", float("nan"), "finite numbers")
        self.expect(f"{MATERIAL}/density", None, "found null")
        self.expect(f"{MATERIAL}/cohesion", -1, "found -1, allowed: >= 0")
        self.expect("mpm.json:/basis", "gimpp", "one of linear, gimp, bspline")
        self.expect("coupler.json:/coupling/acceleration/filter", 3, "allowed: < 1")
        self.expect("mpm.json:/bodies/9/points_per_cell", 4, "found entry 9, allowed: 0 to 0")

    def test_a_key_that_is_not_set_is_explained(self) -> None:
        with self.assertRaisesRegex(gabion.SettingError, "quadrature: not set in .*How the stresses"):
            self.scene["mpm.json:/quadrature"]

    def test_a_file_that_the_scene_lacks(self) -> None:
        soil = gabion.Scene(ROOT / "configs" / "column_collapse")
        with self.assertRaisesRegex(gabion.SettingError, 'has no file "fem.json", allowed: mpm.json'):
            soil["fem.json:/gravity"] = [0, 0]

    def test_folders_without_a_scene(self) -> None:
        with self.assertRaisesRegex(gabion.SettingError, "no such scene folder"):
            gabion.Scene(self.folder / "nowhere")
        with self.assertRaisesRegex(gabion.SettingError, "holds none of"):
            gabion.Scene(self.folder)
        self.write("mpm.json", "{")
        with self.assertRaisesRegex(gabion.SettingError, "mpm.json: not JSON"):
            gabion.Scene(self.folder)

    def test_keys_and_their_words(self) -> None:
        self.assertIn("friction_angle", self.scene.keys(MATERIAL))
        self.assertEqual(self.scene.describe("mpm.json:/time/end"), "End of the run. [s]")
        offered = self.scene._ipython_key_completions_()
        self.assertIn(f"{MATERIAL}/density", offered)
        self.assertIn(f"{MATERIAL}/tension_cutoff", offered)  # known, not set

    def test_every_value_of_every_scene_is_known_and_allowed(self) -> None:
        folders = {path.parent for name in schema.FILES for path in ROOT.glob(f"configs/*/{name}")}
        self.assertGreater(len(folders), 15)
        for folder in sorted(folders):
            scene = gabion.Scene(folder)
            for path in scene.paths():
                scene[path] = scene[path]

    def test_a_saved_scene_has_the_changes(self) -> None:
        self.scene[f"{MATERIAL}/density"] = 1800
        saved = self.scene.save(self.folder / "mine")
        self.assertEqual((saved[f"{MATERIAL}/density"], saved.options), (1800, []))
        with self.assertRaisesRegex(gabion.SettingError, "is there already"):
            self.scene.save(self.folder / "mine")

    def test_the_package_leaves_matplotlib_alone(self) -> None:
        """A notebook keeps its own back end."""
        code = "import gabion, sys; assert 'matplotlib' not in sys.modules"
        done = subprocess.run([sys.executable, "-c", code], env=os.environ | {"PYTHONPATH": str(ROOT)},
                              cwd=self.folder, capture_output=True, text=True, check=False)
        self.assertEqual(done.returncode, 0, done.stderr)

    def test_a_root_without_scripts_is_named(self) -> None:
        done = subprocess.run([sys.executable, "-c", "import gabion"], cwd=self.folder, capture_output=True, text=True,
                              env=os.environ | {"PYTHONPATH": str(ROOT), "GABION_ROOT": str(self.folder)}, check=False)
        self.assertIn(f"GABION_ROOT leads to {self.folder}, which has no scripts/run", done.stderr)


class Install(ScriptCase):
    """Package that pip makes of the folder; tests/participant/test_install.py has pip itself."""

    def made(self, function: str) -> Path:
        backend = str(ROOT / "protocol" / "python")
        code = (f"import os, sys; sys.path.insert(0, {backend!r}); os.chdir({str(ROOT)!r}); import build_wheel; "
                f"print(build_wheel.{function}({str(self.folder)!r}))")
        done = subprocess.run([sys.executable, "-B", "-c", code], capture_output=True, text=True, check=False)
        self.assertEqual(done.returncode, 0, done.stderr)
        wheel = self.folder / done.stdout.strip()
        shutil.unpack_archive(wheel, self.folder / "installed", "zip")
        return wheel

    def test_an_installed_package_finds_the_programs(self) -> None:
        wheel = self.made("build_wheel")
        version = re.search(r"^project\(\w+ VERSION (\S+)", (ROOT / "CMakeLists.txt").read_text(), re.MULTILINE)[1]
        self.assertEqual(wheel.name, f"gabion-{version}-py3-none-any.whl")
        code = "import gabion; print(gabion.__file__, gabion.ROOT)"
        place = self.folder / "installed"
        done = subprocess.run([sys.executable, "-c", code], cwd=self.folder, capture_output=True, text=True,
                              env=os.environ | {"PYTHONPATH": str(place)}, check=False)
        self.assertEqual(done.stdout.split(), [str(place / "gabion" / "__init__.py"), str(ROOT)], done.stderr)

    def test_an_editable_one_names_the_folder(self) -> None:
        self.made("build_editable")
        self.assertEqual((self.folder / "installed" / "gabion.pth").read_text(), f"{ROOT}\n")


class Read(ScriptCase):
    def setUp(self) -> None:
        super().setUp()
        made_up.write_results(self.folder)
        self.results = gabion.Results(self.folder)

    def test_tables_are_arrays(self) -> None:
        self.assertEqual(self.results.probes["structure.A.ux"].shape, (made_up.STEPS + 1,))
        self.assertEqual(self.results.steps["dt"].shape, (made_up.STEPS,))
        with self.assertRaisesRegex(gabion.ResultsError, "no column fxx; there are"):
            self.results.steps["fxx"]
        (self.folder / "iterations.csv").unlink()
        with self.assertRaisesRegex(gabion.ResultsError, "no iterations.csv"):
            self.results.iterations

    def test_frames_are_stacked(self) -> None:
        moved = gabion.stack(self.results.soil, "displacement")
        self.assertEqual(moved.shape[0], len(self.results.soil))
        np.testing.assert_allclose(gabion.stack(self.results.soil) - moved, np.broadcast_to(
            self.results.soil.frame(0).points, moved.shape), atol=1e-15)
        with self.assertRaisesRegex(gabion.ResultsError, "no field speed; there are displacement"):
            gabion.stack(self.results.soil, "speed")

    def test_frames_with_fewer_points_are_not_stacked(self) -> None:
        frames = made_up.soil_frames()
        time, points, cells, fields = frames[-1]
        frames[-1] = time, points[1:], cells, {name: values[1:] for name, values in fields.items()}
        made_up.write_series(self.folder / "mpm", "soil", frames)
        with self.assertRaisesRegex(gabion.ResultsError, "found 3199 to 3200 points"):
            gabion.stack(self.results.soil)

    def test_contacts_and_gauges_by_name(self) -> None:
        made_up.write_contact(self.folder)
        self.assertEqual(gabion.stack(self.results.contacts["wall"], "pressure").shape, (6, 10))
        made_up.write_table(self.folder / "probes.csv", ["time", "soil.toe.section_flux", "soil.toe.depth"],
                            [[0, 0, 0], [1, 2, 3]])
        self.assertEqual(self.results.gauges["toe"]["depth"].tolist(), [0, 3])

    def test_completed_is_what_the_summary_says(self) -> None:
        """One that does not say so did not come to its end: as for the programs, which move results by it."""
        for summary, completed in (({"completed": True}, True), ({"completed": False}, False), ({}, False)):
            (self.folder / "summary.json").write_text(json.dumps(summary))
            self.assertIs(gabion.Results(self.folder).completed, completed)
            self.assertEqual(list(gabion.follow(self.folder))[-1].state.value, "completed" if completed else "failed")

    def test_settings_of_a_run_that_has_ended_are_whole(self) -> None:
        self.write("resolved_config.json", '{"mpm.json": {')
        with self.assertRaisesRegex(gabion.ResultsError, "resolved_config.json: not a complete JSON file"):
            gabion.Results(self.folder).settings("mpm.json")
        (self.folder / "summary.json").unlink()  # under way: half written
        self.assertEqual(gabion.Results(self.folder).settings("mpm.json"), {})

    def test_pictures(self) -> None:
        drawn = self.results.draw("--residuals")
        self.assertTrue(drawn["residuals"]._repr_png_().startswith(b"\x89PNG"))
        with self.assertRaisesRegex(gabion.ResultsError, "no field speed"):
            self.results.draw("--field", "speed")

    def test_pandas_and_xarray_where_they_are(self) -> None:
        for name, export in (("pandas", lambda: gabion.to_pandas(self.results.steps)),
                             ("xarray", lambda: gabion.to_xarray(self.results.soil, "displacement"))):
            with mock.patch.dict(sys.modules, {name: None}), self.assertRaisesRegex(ImportError, f"python3-{name}"):
                export()
        made = mock.Mock()
        made.Dataset.side_effect = lambda axes, coords: {name: (dims, values.shape)
                                                         for name, (dims, values) in axes.items()}
        with mock.patch.dict(sys.modules, {"xarray": made}):
            found = gabion.to_xarray(self.results.soil, "plastic_strain")
        self.assertEqual(found, {"position": (("time", "point", "position_component"), (6, 3200, 2)),
                                 "plastic_strain": (("time", "point"), (6, 3200))})
        made.DataFrame.side_effect = dict
        with mock.patch.dict(sys.modules, {"pandas": made}):
            self.assertEqual(set(gabion.to_pandas(gabion.Table(self.write("a.csv", "step,dt\n1,2\n")))), {"step", "dt"})


if __name__ == "__main__":
    unittest.main()
