#!/usr/bin/python3
# SPDX-License-Identifier: BSD-3-Clause
"""cmake --install: a scene is made and run from the installed tree alone, and all of it can be removed.

    test_install.py BUILD_FOLDER
"""

import json
import os
import subprocess
import sys
import unittest
from pathlib import Path

from script_case import ROOT, ScriptCase

BUILD = Path(sys.argv.pop(1)).resolve()
SAND = {"law": "mohr_coulomb", "density": 1800, "young_modulus": 5e6, "poisson_ratio": 0.3, "friction_angle": 33}
PLAN = {"ground": [[0, 0], [4, 0]], "layers": [{"name": "sand", "bottom": -1, "material": SAND}], "friction": 0.5,
        "cell_size": 0.5, "clear_height": 1, "time": {"end": 0.02, "dt": 0.01}}


class Install(ScriptCase):
    def setUp(self) -> None:
        super().setUp()
        self.prefix = self.folder / "installed"
        self.call("cmake", "--install", BUILD, "--component", "gabion", "--prefix", self.prefix)
        self.tree = self.prefix / "lib/gabion"

    def call(self, *command: object, code: int = 0) -> str:
        environment = {"PATH": f"{self.prefix / 'bin'}:/usr/bin:/bin", "HOME": str(self.folder)}
        environment |= {key: os.environ[key] for key in ("TMPDIR",) if key in os.environ}
        done = subprocess.run([str(word) for word in command], stdout=subprocess.PIPE, stderr=subprocess.STDOUT,
                              text=True,
                              cwd=self.folder, env=environment, timeout=600, check=False)
        self.assertEqual(done.returncode, code, f"{command}\n{done.stdout}")
        return done.stdout

    def test_scene_runs_from_it(self) -> None:
        self.write("plan.json", json.dumps(PLAN))
        self.call("gabion", "section", "plan.json", "scene")
        said = self.call("gabion", "run", "scene", "--no-plots")
        self.assertNotIn(str(ROOT) + "/", said)  # no program of the checkout
        self.assertIn("completed", said)
        summary = json.loads((self.folder / "results/scene/summary.json").read_text(encoding="utf-8"))
        self.assertIs(summary["completed"], True)
        self.call("gabion", "run", self.tree / "configs/slope_section", "--check")
        self.assertIn("oedometer",
                      self.call("gabion", "element-test", "scene", "--test", "oedometer", "--stress", "100e3"))
        self.assertIn(str(self.tree),
                      self.call("/usr/bin/python3", "-c", "import sys; sys.path.insert(0, sys.argv[1]); import "
                                                "gabion; print(gabion.ROOT)",
                                self.prefix / "lib/python3/dist-packages"))

    def test_pages_and_words(self) -> None:
        for name in ("docs/keys/mpm.schema.json", "docs/guide.md", "CITATION.cff", "README.md", "protocol/README.md"):
            self.assertTrue((self.tree / name).is_file(), name)
        self.assertIn("  run\n", self.call("gabion", "--help"))
        for word in ("nothing", "setup", "../run", "plotting"):
            self.assertIn("unknown command", self.call("gabion", word, code=2))
        self.call("gabion", code=2)

    def test_removed(self) -> None:
        own = self.write("installed/lib/gabion/configs/mine/mpm.json", "{}")
        manifest = BUILD / "install_manifest_gabion.txt"
        said = self.call("cmake", "-D", f"manifest={manifest}", "-P", ROOT / "cmake/uninstall.cmake")
        self.assertIn("files that were not installed", said)
        left = [path for path in self.prefix.rglob("*") if not path.is_dir()]
        self.assertEqual(left, [own])
        missing = self.call("cmake", "-D", f"manifest={self.folder / 'none'}", "-P", ROOT / "cmake/uninstall.cmake",
                            code=1)
        self.assertIn("nothing says what was installed", missing)


class Removal(ScriptCase):
    @unittest.skipIf(Path("/usr/lib/gabion").exists(), "a package of Gabion is installed")
    def test_a_folder_that_is_gone_already(self) -> None:
        done = subprocess.run(["sh", ROOT / "cmake" / "prerm"], capture_output=True, text=True, check=False, timeout=60)
        self.assertEqual((done.returncode, done.stderr), (0, ""))


if __name__ == "__main__":
    unittest.main()
