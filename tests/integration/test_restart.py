#!/usr/bin/python3
# SPDX-License-Identifier: BSD-3-Clause
"""A run that goes on from a checkpoint gives the rows of the straight run, byte for byte but for wall times."""

import json
import os
import shutil
import signal
import zlib
from pathlib import Path

import launch
import restart_table
from launch import IntegrationCase, endless, meeting
from restart_rows import rows_of_steps, rows_without_seconds

MESH = Path(__file__).resolve().parent.parent / "unit" / "mesh" / "data" / "plate.msh"
TABLES = ("steps", "probes")


class RestartCase(IntegrationCase):
    tables: tuple[str, ...] = TABLES

    def launch_into(self, out: str, *options: str, code: int = 0, **how) -> launch.Ended:
        self.out = self.folder / out
        return self.run_launch(*options, code=code, **how)

    def assert_same_rows(self, restarted: str = "second", straight: str = "straight", first_step: int = 1) -> None:
        """The tables of the restarted run are the ends of those of the straight one."""
        for table in self.tables:
            new = rows_without_seconds(self.folder / restarted / f"{table}.csv")
            old = rows_without_seconds(self.folder / straight / f"{table}.csv")
            self.assertEqual(new[0], old[0])
            self.assertGreater(len(new), 1, table)
            self.assertEqual(new[1:], old[-(len(new) - 1):], table)
            if table == "steps":
                self.assertEqual(int(new[1][0]), first_step)

    def summary(self, out: str) -> dict:
        return json.loads((self.folder / out / "summary.json").read_text())

    def checkpoints(self, out: str) -> list[str]:
        return sorted(path.name for path in (self.folder / out / "checkpoints").glob("step_*"))

    def last_step(self, out: str) -> int:
        """Step of the last whole checkpoint; 0: there is none."""
        whole = (self.folder / out / "checkpoints").glob("step_*/manifest.json")
        return max((int(path.parent.name.removeprefix("step_")) for path in whole), default=0)


def soil_alone() -> dict:
    return restart_table.alone(restart_table.soil(), 0.03)


def structure_alone(linear: dict) -> dict:
    return restart_table.alone(restart_table.structure(linear_solver=linear), 0.02)


class Alone(RestartCase):
    def in_two_parts(self, program: str, file: str, part: float, **how) -> None:
        """Run to `part` of the end, then on to the end; compare with the run in one piece."""
        alone = {"programs": (program,), **how}
        end = json.loads((self.scene / f"{file}.json").read_text())["time"]["end"]
        self.launch_into("straight", **alone)
        self.launch_into("first", "--set", f"{file}.json:/time/end={part * end}", **alone)
        first = self.folder / "first"
        self.launch_into("second", "--restart", str(first), "--set", f"{file}.json:/output/interval=0.004", **alone)
        steps = self.summary("first")["steps"]
        self.assert_same_rows(first_step=steps + 1)
        restart = self.summary("second")["restart"]
        self.assertEqual(restart["step"], steps)
        self.assertEqual(restart["from"], str(first / "checkpoints" / f"step_{steps:06}"))
        self.assertEqual(restart["time"], self.summary("first")["end_time"])
        self.assertEqual(self.summary("second")["steps"], self.summary("straight")["steps"] - steps)
        self.assertNotIn("restart", self.summary("straight"))

    def test_soil(self) -> None:
        self.write_scene({"mpm": soil_alone()})
        self.in_two_parts("mpm_solver", "mpm", 0.5)

    def test_soil_on_two_ranks(self) -> None:
        self.write_scene({"mpm": soil_alone()})
        self.in_two_parts("mpm_solver", "mpm", 0.5, ranks={"mpm_solver": 2})
        for ranks in (1, 3):
            self.goes_on_with(ranks, "mpm_solver")

    def goes_on_with(self, ranks: int, program: str) -> None:
        """The run goes on with another number of ranks: the probes are the same but for rounding."""
        self.launch_into("third", "--restart", str(self.folder / "first"), programs=(program,), ranks={program: ranks})
        second, third = (rows_without_seconds(self.folder / run / "probes.csv") for run in ("second", "third"))
        self.assertEqual(len(second), len(third))
        for expected, found in zip(second[1:], third[1:], strict=True):
            for name, a, b in zip(second[0], expected, found, strict=True):
                self.assertAlmostEqual(float(a), float(b), delta=1e-6 * (1e-3 + abs(float(a))), msg=name)

    def test_structure(self) -> None:
        for linear in ({"method": "lu"}, {"method": "mumps"}, {"method": "cg"},
                       {"method": "cg", "preconditioner": "multigrid"},
                       {"method": "cg", "max_iterations": 2}):  # which fails, and is left alone for some steps
            with self.subTest(linear):
                self.write_scene({"fem": structure_alone(linear)})
                self.in_two_parts("fem_solver", "fem", 0.3)

    def test_structure_on_more_ranks(self) -> None:
        self.write_scene({"fem": structure_alone({"method": "mumps"})})
        self.in_two_parts("fem_solver", "fem", 0.3)
        self.goes_on_with(2, "fem_solver")

    def test_last_checkpoint_after_kill(self) -> None:
        files = {"mpm": soil_alone()}
        files["mpm"]["checkpoint"] = {"steps": 4}
        self.write_scene(files)
        self.out = self.folder / "first"
        run = self.start("--set", "mpm.json:/time/end=1000", programs=("mpm_solver",))
        run.wait_until(lambda: self.last_step("first") >= 12, "12 steps")
        os.kill(run.pid_of("mpm_solver"), signal.SIGKILL)
        run.wait()
        end = f"mpm.json:/time/end={(self.last_step('first') + 20) * files['mpm']['time']['dt']}"
        self.assertLessEqual(len(self.checkpoints("first")), 2)
        # A crash may leave a folder without manifest, which does not count.
        (self.folder / "first" / "checkpoints" / "step_999999").mkdir()
        self.launch_into("straight", "--set", end, programs=("mpm_solver",))
        self.launch_into("second", "--restart", str(self.folder / "first"), "--set", end, programs=("mpm_solver",))
        self.assert_same_rows(first_step=self.summary("second")["restart"]["step"] + 1)
        self.assertEqual(self.summary("second")["restart"]["step"] % 4, 0)
        self.assertEqual(len(self.checkpoints("second")), 1)

    def test_sigterm(self) -> None:
        files = {"mpm": soil_alone()}
        files["mpm"]["checkpoint"] = {}
        self.write_scene(files)
        self.out = self.folder / "first"
        run = self.start("--set", "mpm.json:/time/end=1000", programs=("mpm_solver",))
        steps = self.out / "steps.csv"
        run.wait_until(lambda: steps.exists() and steps.read_text().count("\n") > 5, "5 steps")
        self.assertFalse((self.out / "checkpoints").exists())
        os.kill(run.pid_of("mpm_solver"), signal.SIGTERM)
        ended = run.wait()
        self.assertEqual(ended.code, 128 + signal.SIGTERM, ended.text)
        self.assert_says(ended.text, "interrupted by signal 15")
        self.assert_says(ended.text, "checkpoint of step")
        step = len(rows_without_seconds(steps)) - 1
        self.assertEqual(self.checkpoints("first"), [f"step_{step:06}"])
        end = 1e-3 * (step + 10)
        self.launch_into("straight", "--set", f"mpm.json:/time/end={end}", programs=("mpm_solver",))
        self.launch_into("second", "--set", f"mpm.json:/time/end={end}", "--restart", str(self.folder / "first"),
                         programs=("mpm_solver",))
        self.assert_same_rows(first_step=step + 1)

    def refused(self, *words: str, restart: str = "first", out: str = "second", options: tuple[str, ...] = (),
                code: int = 2) -> None:
        with self.subTest(words[0]):
            ended = self.launch_into(out, "--restart", str(self.folder / restart), *options, code=code,
                                     programs=("mpm_solver",))
            self.assert_says(ended.text, "error:", *words)

    def test_wrong_restarts(self) -> None:
        files = {"mpm": soil_alone()}
        self.write_scene(files)
        self.launch_into("first", "--set", "mpm.json:/time/end=0.005", programs=("mpm_solver",))
        self.refused("mpm.json: at /bodies/0/material/young_modulus", "found 900000.0", "allowed: 840000.0",
                     options=("--set", "mpm.json:/bodies/0/material/young_modulus=9e5"))
        self.refused("mpm.json: at /time/dt:", "found 0.002", "allowed: 0.001",
                     options=("--set", "mpm.json:/time/dt=2e-3"))
        self.refused("mpm.json: at /tpic:", "found true", "allowed: nothing", options=("--set", "mpm.json:/tpic=true"))
        self.refused("is at 0.005 s", "/time/end", options=("--set", "mpm.json:/time/end=0.005"))
        self.refused("found no checkpoint", restart="nowhere")
        self.refused("would be replaced by the new results", out="first")
        manifest = self.folder / "first" / "checkpoints" / "step_000005" / "manifest.json"
        content = json.loads(manifest.read_text())
        manifest.write_text(json.dumps({**content, "format": 99}))
        self.refused("at /format", "found 99", "allowed: 1, 2")
        manifest.write_text(json.dumps({**content, "program": "fem_solver"}))
        self.refused("at /program", 'found "fem_solver"', 'allowed: "mpm_solver"')
        manifest.write_text(json.dumps(content))
        self.launch_into("second", "--restart", str(self.folder / "first"), programs=("mpm_solver",))
        for state in manifest.parent.glob("*.h5"):
            whole = state.read_bytes()
            state.write_bytes(whole[:-100] + bytes([whole[-100] ^ 1]) + whole[-99:])
            self.refused(f"{state.name}: found bytes of CRC-32", f'the manifest says "{zlib.crc32(whole):08x}"',
                         "without --restart", code=4)
            state.write_bytes(whole)

    def test_changed_mesh_file(self) -> None:
        """Another place of one node, in a file that fem.json names."""
        structure = restart_table.structure(mesh={"file": "plate.msh"}, supports=[{"group": "outside"}],
                                            probes=[{"name": "A", "point": [1.25, 0.5]}])
        structure["loads"][0]["point"] = [1.25, 0.5]
        self.write_scene({"fem": restart_table.alone(structure, 0.004)})
        mesh = self.scene / "plate.msh"
        shutil.copy(MESH, mesh)
        self.launch_into("first", "--set", "fem.json:/time/end=0.002", programs=("fem_solver",))
        text = mesh.read_text()
        self.assertEqual(text.count("\n1.25 0.5 0\n"), 1)
        mesh.write_text(text.replace("\n1.25 0.5 0\n", "\n1.25 0.50001 0\n"))
        ended = self.launch_into("second", "--restart", str(self.folder / "first"), code=2, programs=("fem_solver",))
        self.assert_says(ended.text, "error:", "fem.json: at /mesh/file: found", "plate.msh",
                         "the contents of that file")
        mesh.write_text(text)
        self.launch_into("second", "--restart", str(self.folder / "first"), programs=("fem_solver",))

    def test_wrong_settings(self) -> None:
        for value, words in (('{"steps": 0}', "/checkpoint/steps"), ('{"minutes": 0}', "/checkpoint/minutes"),
                             ('{"hours": 1}', "/checkpoint/hours")):
            with self.subTest(value):
                self.write_scene({"mpm": soil_alone()})
                ended = self.run_program("mpm_solver", self.scene, "--check", "--set",
                                         f"mpm.json:/checkpoint={value}", code=2)
                self.assert_says(ended.text, "mpm.json: at " + words)


class Coupled(RestartCase):
    """The soil meets the wall at step 18; history of mvqn from then on, steps that are cut."""

    tables = (*TABLES, "iterations")

    def two_parts(self, files: dict[str, dict], step: int, **how) -> None:
        """Run in one piece; run to this step and go on from there."""
        self.write_scene(files)
        self.launch_into("straight", **how)
        rows = rows_without_seconds(self.folder / "straight" / "steps.csv")
        time = rows[step][rows[0].index("time")]
        self.launch_into("first", "--set", f"coupler.json:/time/end={time}", **how)
        self.launch_into("second", "--restart", str(self.folder / "first"), **how)
        self.assert_same_rows(first_step=step + 1)
        restart = self.summary("second")["restart"]
        self.assertEqual((restart["step"], restart["time"]), (step, float(time)))

    def test_out_of_contact(self) -> None:
        self.two_parts(meeting(), 6)

    def test_in_contact_on_two_ranks(self) -> None:
        self.two_parts(meeting(), 24, ranks={"mpm_solver": 2, "fem_solver": 2})
        columns = rows_without_seconds(self.folder / "second" / "iterations.csv")
        used = columns[0].index("columns")
        self.assertGreater(max(int(row[used]) for row in columns[1:6]), 2)  # history of earlier steps
        checkpoint = next((self.folder / "second" / "checkpoints").iterdir())
        manifest = json.loads((checkpoint / "manifest.json").read_text())
        self.assertEqual(manifest["own_files"], ["soil", "structure"])  # which did not go through the coupler
        self.assertEqual(manifest["bytes"], {path.stem: path.stat().st_size for path in checkpoint.glob("*.h5")})
        self.assertEqual(manifest["crc32"],
                         {path.stem: f"{zlib.crc32(path.read_bytes()):08x}" for path in checkpoint.glob("*.h5")})

    def test_other_methods_in_contact(self) -> None:
        for method in ("iqn_ils", "aitken"):
            with self.subTest(method):
                files = meeting()
                files["coupler"]["coupling"]["acceleration"] = {"method": method}
                self.two_parts(files, 22)

    def test_deformed_positions(self) -> None:
        files = meeting()
        mapping = {"tolerance": 1e-3, "positions": "deformed", "moved": 1e-4}
        files["coupler"]["coupling"]["mapping"] = mapping
        # Off the structure's surface: on it the map would stay what it was.
        files["mpm"]["interfaces"][0]["surface"]["polyline"] = [[0.2602, 0], [0.2602, 0.0502], [0.2498, 0.0502],
                                                                [0.2498, 0]]
        self.two_parts(files, 20)  # before the first cut: on the raster of dt
        for part in ("first", "second"):
            self.assertGreater(self.summary(part)["mapping"]["wall"]["set_ups"], 1)

    def test_sigterm(self) -> None:
        files = endless(in_contact=True)
        files["coupler"]["checkpoint"] = {"minutes": 60}
        self.write_scene(files)
        self.out = self.folder / "first"
        run = self.start_and_step(20)
        os.kill(run.process.pid, signal.SIGTERM)
        ended = run.wait()
        self.assertNotEqual(ended.code, 0)
        log = (self.out / "coupler.log").read_text()
        self.assert_says(log, "interrupted by signal 15")
        self.assert_says(log, "checkpoint of step")
        step = len(rows_without_seconds(self.out / "steps.csv")) - 1
        self.assertEqual(self.checkpoints("first"), [f"step_{step:06}"])
        end = 5e-4 * (step + 10)
        self.launch_into("straight", "--set", f"coupler.json:/time/end={end}")
        self.launch_into("second", "--restart", str(self.folder / "first"), "--set", f"coupler.json:/time/end={end}")
        self.assert_same_rows(first_step=step + 1)

    def test_at_every_step(self) -> None:
        """Elastic soil that meets a stiff wall and bounces: each step is a run of its own."""
        files = meeting()
        files["mpm"] |= {"gravity": [0, 0]}
        files["mpm"]["bodies"][0] |= {"velocity": [2.0, 0], "material": {
            "law": "hencky_elastic", "density": 2650, "young_modulus": 3e6, "poisson_ratio": 0}}
        files["mpm"]["interfaces"][0]["mode"] = "slip"
        files["fem"]["material"]["young_modulus"] = 1e9
        files["coupler"]["time"] |= {"end": 0.017, "dt": 1e-3}
        self.write_scene(files)
        self.launch_into("straight")
        straight, options = self.out, []
        names, *steps = rows_without_seconds(straight / "steps.csv")
        closed = [int(row[names.index("soil.closed_points")]) for row in steps]
        self.assertTrue(closed[1] == 0 and max(closed) > 0 and closed[-2] == 0, closed)
        self.assertEqual({row[names.index("cuts")] for row in steps}, {"0"})  # no step was tried beyond an end
        for row in steps:
            step, time = int(row[names.index("step")]), row[names.index("time")]
            self.launch_into(f"to_{step}", *options, "--set", f"coupler.json:/time/end={time}")
            for table in self.tables:
                self.assertEqual(rows_of_steps(self.out, table, step, step, whole=step > 1),
                                 rows_of_steps(straight, table, step, step), f"{table} of step {step}")
            options = ["--restart", str(self.out)]

    def test_changed_scene_is_refused(self) -> None:
        self.write_scene(meeting())
        self.launch_into("first", "--set", "coupler.json:/time/end=0.001")
        for setting, *words in (
                ("fem.json:/material/density=1200", "fem.json: at /material/density: found 1200, allowed: 1100"),
                ("coupler.json:/coupling/max_iterations=21", "coupler.json: at /coupling/max_iterations: found 21"),
                ("mpm.json:/bodies/0/velocity=[0.6,0]", "mpm.json: at /bodies/0/velocity/0: found 0.6, allowed: 0.5")):
            with self.subTest(setting):
                ended = self.launch_into("second", "--restart", str(self.folder / "first"), "--set", setting, code=2)
                self.assert_says(ended.text, "[cpl] error:", *words)


if __name__ == "__main__":
    launch.main()
