#!/usr/bin/python3
# SPDX-License-Identifier: BSD-3-Clause
"""scripts/run --restart: the programs that it starts, and the foreign code of granular_obstacle_external."""

import json
import os
import signal
import subprocess
import unittest
from pathlib import Path

import launch
from launch import IntegrationCase, Launch, meeting
from restart_rows import rows_of_steps, rows_without_seconds
from test_foreign import FOREIGN, ROOT

BEAM_SCENE = ROOT / "configs" / "granular_obstacle_external"
# The scene shortened: a part of the column stands at the wall, and moves towards it.
AT_THE_WALL = ("mpm.json:/bodies/0/mesh/box/low=[0.1975,0]", "mpm.json:/bodies/0/mesh/box/high=[0.2475,0.06]",
               "mpm.json:/bodies/0/mesh/box/cells=[10,12]", "mpm.json:/bodies/0/velocity=[0.5,0]",
               "coupler.json:/output/interval=0.001")
TABLES = ("steps", "probes", "iterations")


class ScriptCase(IntegrationCase):
    def setUp(self) -> None:
        super().setUp()
        if launch.binaries != ROOT / "build" / "release" / "bin":
            self.skipTest("scripts/run uses build/release only")

    def command(self, scene: Path, out: str, *settings: str, options: tuple[str, ...] = ()) -> list[str]:
        command = [str(ROOT / "scripts" / "run"), str(scene), "--output", str(self.folder / out), "--no-plots"]
        command += options
        for setting in settings:
            command += ["--set", setting]
        return command

    def run_script(self, *arguments, code: int = 0, **how) -> str:
        done = subprocess.run(self.command(*arguments, **how), stdin=subprocess.DEVNULL, stdout=subprocess.PIPE,
                              stderr=subprocess.STDOUT, text=True, timeout=launch.TIMEOUT, check=False)
        self.assertEqual(done.returncode, code, done.stdout)
        return done.stdout

    def restart_of(self, out: str) -> tuple[str, str]:
        return "--restart", str(self.folder / out)

    def steps(self, out: str) -> int:
        return len(rows_without_seconds(self.folder / out / "steps.csv")) - 1

    def assert_same_rows(self, out: str, first: int) -> None:
        """Rows of the run in one piece from this step on."""
        last = self.steps("straight")
        for table in TABLES:
            self.assertEqual(rows_of_steps(self.folder / out, table, first, last, whole=True),
                             rows_of_steps(self.folder / "straight", table, first, last), table)


class Programs(ScriptCase):
    """The programs of this project."""

    def test_restart(self) -> None:
        self.write_scene(meeting())
        self.run_script(self.scene, "straight")
        self.run_script(self.scene, "first", "coupler.json:/time/end=0.01")
        text = self.run_script(self.scene, "second", options=self.restart_of("first"))
        self.assert_says(text, "coupler completed")
        self.assert_same_rows("second", self.steps("first") + 1)

    def test_no_checkpoint(self) -> None:
        self.write_scene(meeting())
        text = self.run_script(self.scene, "second", options=self.restart_of("nowhere"), code=2)
        self.assert_says(text, "[cpl] error:", "found no checkpoint")


class Beam(ScriptCase):
    def end_at(self, time: float) -> tuple[str, ...]:
        return (*AT_THE_WALL, f"coupler.json:/time/end={time}")

    def test_restart_after_a_signal(self) -> None:
        """scripts/run is told to stop in contact: the beam stays until its state is in the checkpoint."""
        os.environ["OMPI_MCA_odls_base_sigkill_timeout"] = "6"  # [s] for the step and the checkpoint
        self.addCleanup(os.environ.pop, "OMPI_MCA_odls_base_sigkill_timeout", None)
        run = Launch(self.command(BEAM_SCENE, "first", *self.end_at(1.0)), self.folder)
        self.addCleanup(run.end)
        table = self.folder / "first" / "steps.csv"
        run.wait_until(lambda: table.exists() and table.read_text().count("\n") > 25, "25 steps")
        os.killpg(run.process.pid, signal.SIGINT)  # to all processes of the group, as a terminal does
        self.assertEqual(run.wait().code, 128 + signal.SIGINT)
        del os.environ["OMPI_MCA_odls_base_sigkill_timeout"]
        steps = self.steps("first")
        checkpoints = [path.name for path in (self.folder / "first" / "checkpoints").iterdir()]
        self.assertEqual(checkpoints, [f"step_{steps:06}"], run.text())
        end = self.end_at(2e-4 * (steps + 5))
        self.run_script(BEAM_SCENE, "straight", *end)
        self.run_script(BEAM_SCENE, "second", *end, options=self.restart_of("first"))
        self.assert_same_rows("second", steps + 1)
        names, *rows = rows_without_seconds(self.folder / "straight" / "steps.csv")
        in_contact = [int(row[names.index("step")]) for row in rows if row[names.index("skipped")] == "none"]
        self.assertLess(min(in_contact), 20, "the beam is not loaded before the restart")
        summary = json.loads((self.folder / "second" / "summary.json").read_text())
        self.assertEqual(summary["restart"]["step"], steps)

    def test_another_beam_is_refused(self) -> None:
        """structure.json is the beam's own: the coupler does not know it."""
        scene = self.folder / "scene"
        scene.mkdir()
        for file in BEAM_SCENE.iterdir():
            if file.suffix in (".json", ".py"):
                (scene / file.name).write_bytes(file.read_bytes())
        end = self.end_at(0.001)
        self.run_script(scene, "first", *end[:-1], "coupler.json:/time/end=0.0006")
        beam = json.loads((scene / "structure.json").read_text())
        for change, words in (({"density": 1200}, "structure.json: at /density: found 1200, allowed: 1100"),
                              ({"top_segments": 5}, "structure.json: at /top_segments: found 5, allowed: 4")):
            with self.subTest(change):
                (scene / "structure.json").write_text(json.dumps(beam | change))
                text = self.run_script(scene, "second", *end, options=self.restart_of("first"), code=4)
                self.assert_says(text, "[beam] error: ", words)
                self.assert_says(text, "[cpl] error: ", words)


class OwnLoop(ScriptCase):
    """A foreign code with a time loop of its own."""

    def foreign_scene(self, habit: str) -> Path:
        files = meeting()
        del files["fem"]
        files["mpm"]["interfaces"][0]["penalty"] = 1e7  # with 1e8 round-off decides whether a step is solved
        files["coupler"]["participants"]["structure"]["command"] = ["/usr/bin/python3", *FOREIGN, habit]
        self.write_scene(files)
        return self.scene

    def test_restart(self) -> None:
        scene = self.foreign_scene("good")
        self.run_script(scene, "straight")
        self.run_script(scene, "first", "coupler.json:/time/end=0.01")
        self.run_script(scene, "second", options=self.restart_of("first"))
        self.assert_same_rows("second", self.steps("first") + 1)

    def test_another_surface_is_refused(self) -> None:
        """The scene is the same; the code's surface is not."""
        scene = self.foreign_scene("good")
        self.run_script(scene, "first", "coupler.json:/time/end=0.001")
        os.environ["FOREIGN_STRUCTURE_SHIFT"] = "1e-9"
        self.addCleanup(os.environ.pop, "FOREIGN_STRUCTURE_SHIFT")
        text = self.run_script(scene, "second", options=self.restart_of("first"), code=2)
        self.assert_says(text, "[cpl] error: ", 'participant "structure": found another mesh of interface "wall"')


if __name__ == "__main__":
    launch.main()
