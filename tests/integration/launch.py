# SPDX-License-Identifier: BSD-3-Clause
"""Parts that the integration tests share: a tiny scene, launches of the real programs, readers of results.

Every test is called with the folder of the programs: `test_X.py BIN_FOLDER [unittest options]`.
"""

import copy
import csv
import json
import os
import random
import shutil
import signal
import socket
import subprocess
import sys
import tempfile
import time
import traceback
import unittest
import uuid
import xml.etree.ElementTree
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

import h5py

sys.path.append(str(Path(__file__).resolve().parents[2] / "scripts"))
from running.mpi import find_launcher  # noqa: E402

LAUNCHER = find_launcher()
PROGRAMS = ("coupler", "mpm_solver", "fem_solver")
ONE_THREAD = {"OPENBLAS_NUM_THREADS": "1", "OMP_NUM_THREADS": "1", "OMP_THREAD_LIMIT": "1", **LAUNCHER.environment}
MARK = "GABION_TEST_LAUNCH"  # environment variable by which processes of a launch are found
TIMEOUT = 300  # [s] ends a launch that hangs; no test is judged by its time

binaries = Path()  # set by main()

COUPLER = {
    "time": {"end": 0.0125, "dt": 5e-4, "dt_min": 1e-6},
    "output": {"interval": 0.0025},
    "participants": {"soil": {"sends": "force"}, "structure": {"sends": "displacement"}},
    "interfaces": [{"name": "wall", "soil": "soil", "structure": "structure"}],
    "coupling": {
        "max_iterations": 20,
        "convergence": {
            "displacement": {"absolute": 1e-5, "relative": 1e-5, "floor": 1e-9},
            "force": {"absolute": 1e-3, "relative": 1e-5, "floor": 1e-7},
        },
        "mapping": {"tolerance": 1e-6},
    },
}
FEM = {
    "dimension": 2,
    "mesh": {"box": {"low": [0.25, 0], "high": [0.26, 0.05], "cells": [2, 10], "type": "quad4"}},
    "material": {"law": "neo_hookean", "density": 1100, "young_modulus": 1e6, "poisson_ratio": 0},
    "gravity": [0, -9.81],
    "initial_equilibrium": True,
    "supports": [{"group": "bottom"}],
    "interfaces": [{"name": "wall", "groups": ["left", "top", "right"]}],
    "probes": [{"name": "A", "point": [0.25, 0.05]}],
}
MPM = {
    "dimension": 2,
    "grid": {"box": {"low": [0, 0], "high": [0.4, 0.16], "cells": [20, 8], "type": "quad4"}},
    "basis": "linear",
    "walls": [{"group": "bottom", "condition": "slip"}, {"group": "left", "condition": "slip"}],
    "gravity": [0, -9.81],
    "locking": {"method": "none"},  # stiff enough at the first contact for a step to be cut
    "bodies": [{
        "name": "soil",
        "mesh": {"box": {"low": [0.16, 0], "high": [0.24, 0.06], "cells": [4, 3], "type": "quad4"}},
        "points_per_cell": 4,
        "velocity": [0.5, 0],
        "material": {"law": "mohr_coulomb", "density": 2650, "young_modulus": 840e3, "poisson_ratio": 0.3,
                     "friction_angle": 19.8, "dilation_angle": 0, "cohesion": 0},
    }],
    "interfaces": [{
        "name": "wall",
        "surface": {"polyline": [[0.26, 0], [0.26, 0.05], [0.25, 0.05], [0.25, 0]], "spacing": 0.01},
        "method": "boundary_points",
        "penalty": 1e8,
    }],
}
ALONE = {"time": {"end": 0.005, "dt": 1e-3, "dt_min": 1e-5}, "output": {"interval": 0.002}}


def meeting() -> dict[str, dict]:
    """Soil that runs into the wall: contact from step 18 on, cut steps soon after."""
    return copy.deepcopy({"coupler": COUPLER, "mpm": MPM, "fem": FEM})


def endless(in_contact: bool) -> dict[str, dict]:
    """A run of hours, in contact from the first step, or never."""
    files = meeting()
    body = files["mpm"]["bodies"][0]
    left, speed = (0.165, 0.2) if in_contact else (0.0, 0.0)
    body["mesh"]["box"].update(low=[left, 0], high=[left + 0.08, 0.06])
    body["velocity"] = [speed, 0]
    files["mpm"]["interfaces"][0]["penalty"] = 1e6
    if not in_contact:
        files["mpm"]["walls"].append({"group": "right", "condition": "slip"})
        body["material"] = {"law": "hencky_elastic", "density": 2650, "young_modulus": 840e3, "poisson_ratio": 0.3}
    files["coupler"]["time"]["end"] = 1000
    files["coupler"]["output"]["interval"] = 0.02
    files["coupler"]["coupling"]["on_limit"] = "accept"
    return files


reservations: list[socket.socket] = []  # one for each port that this test was given


def free_endpoint() -> str:
    """Endpoint at which a coupler can listen, of a port that the system does not give to connections by itself. It
    stays this test's: a participant may go on to knock after its coupler's end, and must not reach another test's."""
    for port in random.SystemRandom().sample(range(20000, 32000), 100):
        reservation = socket.socket(socket.AF_UNIX)
        try:
            reservation.bind(f"\0gabion_test_port_{port}")
            with socket.socket() as free:
                free.bind(("127.0.0.1", port))
        except OSError:
            reservation.close()
            continue
        reservations.append(reservation)
        return f"tcp://127.0.0.1:{port}"
    raise OSError("none of 100 ports is free")


@dataclass
class Ended:
    """A launch that ended: exit code, all that it printed, and how long it took [s]."""

    code: int
    text: str
    seconds: float


class Launch:
    """One mpirun line under way."""

    def __init__(self, command: list[str], folder: Path, working: Path | None = None) -> None:
        """folder: of what it prints; working: where it runs, None: here."""
        self.mark = uuid.uuid4().hex
        self.text_file = folder / f"printed_{self.mark}.txt"
        environment = {**os.environ, **ONE_THREAD, MARK: self.mark}
        self.start = time.monotonic()
        with self.text_file.open("w", encoding="utf-8") as out:
            self.process = subprocess.Popen(command, stdin=subprocess.DEVNULL, stdout=out, stderr=subprocess.STDOUT,
                                            env=environment, cwd=working, start_new_session=True)

    def text(self) -> str:
        return self.text_file.read_text(encoding="utf-8", errors="replace")

    def alive(self) -> dict[int, str]:
        """Process id -> program, for all processes of this launch that still run, mpirun included."""
        found = {}
        wanted = f"{MARK}={self.mark}".encode()
        for entry in Path("/proc").glob("[0-9]*"):
            try:
                if wanted in (entry / "environ").read_bytes().split(b"\0"):
                    found[int(entry.name)] = (entry / "comm").read_text().strip()
            except OSError:
                pass  # it ended meanwhile, or is a zombie
        return found

    def pid_of(self, program: str) -> int:
        pids = [pid for pid, name in self.alive().items() if name == program]
        assert len(pids) == 1, f"{program}: found processes {pids}"
        return pids[0]

    def wait_until(self, condition, what: str) -> None:
        while not condition():
            if self.process.poll() is not None:
                raise AssertionError(f"the launch ended before {what}:\n{self.text()}")
            if time.monotonic() - self.start > TIMEOUT:
                raise AssertionError(f"not within {TIMEOUT} s: {what}:\n{self.text()}")
            time.sleep(0.02)

    def wait_programs_gone(self) -> float:
        """Wait until no program is alive. @returns how long that took [s]"""
        begin = time.monotonic()
        while any(name in PROGRAMS for name in self.alive().values()):
            if time.monotonic() - begin > TIMEOUT:
                raise AssertionError(f"alive after {TIMEOUT} s: {self.alive()}\n{self.text()}")
            time.sleep(0.02)
        return time.monotonic() - begin

    def wait_none_left(self) -> None:
        """Wait until no process is left: mpirun may end a moment before the last one that it has killed."""
        begin = time.monotonic()
        while self.alive():
            if time.monotonic() - begin > TIMEOUT:
                raise AssertionError(f"alive after {TIMEOUT} s: {self.alive()}\n{self.text()}")
            time.sleep(0.02)

    def wait(self) -> Ended:
        code = self.process.wait(timeout=TIMEOUT)
        return Ended(code, self.text(), time.monotonic() - self.start)

    def end(self) -> None:
        for pid in self.alive():
            try:
                os.kill(pid, signal.SIGKILL)
            except ProcessLookupError:
                pass
        self.process.wait(timeout=TIMEOUT)


class IntegrationCase(unittest.TestCase):
    """Has a folder of its own with `scene` and `out`; leaves no process behind, or fails."""

    def setUp(self) -> None:
        self.folder = Path(tempfile.mkdtemp(prefix="gabion_"))
        self.addCleanup(shutil.rmtree, self.folder)
        self.scene, self.out = self.folder / "scene", self.folder / "out"

    def problem_of(self, action: Callable[[], None]) -> str:
        """Fault of an action of this object in a folder of its own, empty: none. For cases that run side by side, each
        an object."""
        self.setUp()
        try:
            action()
            return ""
        except Exception:  # noqa: BLE001 - the other cases go on
            return traceback.format_exc()
        finally:
            self.doCleanups()

    def write_scene(self, files: dict[str, dict]) -> None:
        self.scene.mkdir(exist_ok=True)
        for name, content in files.items():
            (self.scene / f"{name}.json").write_text(json.dumps(content, indent=1), encoding="utf-8")

    def start(self, *options: str, programs: tuple[str, ...] = PROGRAMS, ranks: dict[str, int] | None = None,
              own: dict[str, list[str]] | None = None, ignored_signal: str = "") -> Launch:
        """Start programs on the scene in one mpirun line. `own`: options of one program."""
        trapped = ["/bin/sh", "-c", f"trap '' {ignored_signal}; exec \"$@\"", "sh"] if ignored_signal else []
        common = [str(self.scene), "--output", str(self.out), *options]
        launched = [((ranks or {}).get(program, 1),
                     [*trapped, str(binaries / program), *common, *(own or {}).get(program, [])])
                    for program in programs]
        launch = Launch(LAUNCHER.command(launched), self.folder)
        self.addCleanup(launch.end)
        return launch

    def start_and_step(self, num_steps: int = 50, **how) -> Launch:
        """Start a coupled run and wait until it has accepted so many steps."""
        run = self.start(**how)
        rows = self.out / "steps.csv"
        run.wait_until(lambda: rows.exists() and rows.read_text().count("\n") > num_steps, f"{num_steps} steps")
        return run

    def run_launch(self, *options: str, code: int, **how) -> Ended:
        """Run to the end; the exit code must be this one, and no process may be left."""
        launch = self.start(*options, **how)
        ended = launch.wait()
        self.assertEqual(ended.code, code, ended.text)
        launch.wait_none_left()
        return ended

    def run_program(self, program: str, *arguments: object, code: int) -> Ended:
        """Run one program without mpirun."""
        begin = time.monotonic()
        done = subprocess.run([str(binaries / program), *map(str, arguments)], stdin=subprocess.DEVNULL, text=True,
                              stdout=subprocess.PIPE, stderr=subprocess.STDOUT, env={**os.environ, **ONE_THREAD},
                              timeout=TIMEOUT, check=False)
        self.assertEqual(done.returncode, code, done.stdout)
        return Ended(done.returncode, done.stdout, time.monotonic() - begin)

    def assert_says(self, text: str, *words: str) -> None:
        """One line holds all the words."""
        self.assertTrue(any(all(word in line for word in words) for line in text.splitlines()), f"{words} in:\n{text}")

    def assert_frames_open(self, folder: Path, name: str) -> list[float]:
        """Every frame that the XDMF file names can be read in full. Returns their times [s]."""
        times = []
        for grid in xml.etree.ElementTree.parse(folder / f"{name}.xdmf").iter("Grid"):
            if grid.get("GridType") != "Uniform":
                continue
            times.append(float(grid.find("Time").get("Value")))
            for item in grid.iter("DataItem"):
                file, path = item.text.split(":")
                with h5py.File(folder / file, "r") as frame:
                    shape = [int(n) for n in item.get("Dimensions").split()]
                    self.assertEqual(list(frame[path][()].shape), shape, f"{file}:{path}")
        return times


def read_table(path: Path) -> list[dict[str, str]]:
    """Rows of a CSV file, all of which must be whole."""
    text = path.read_text(encoding="utf-8")
    assert text.endswith("\n"), f"{path}: the last row is not complete"
    rows = list(csv.reader(text.splitlines()))
    for row in rows:
        assert len(row) == len(rows[0]), f"{path}: row {row} has not {len(rows[0])} cells"
    return [dict(zip(rows[0], row)) for row in rows[1:]]


def main() -> None:
    global binaries
    binaries = Path(sys.argv.pop(1)).resolve()
    unittest.main(module="__main__", verbosity=2)
