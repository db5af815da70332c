#!/usr/bin/python3
# SPDX-License-Identifier: BSD-3-Clause
"""A form of dolfinx as the structure of a coupled run: checked alone on two ranks, against fem_solver, restarted on two
ranks, and when one of them is killed."""

import os
import shutil
import signal
import time
from pathlib import Path

import launch
from foreign_wall import ROOT, ForeignWall
from launch import Launch, read_table

PROGRAM = str(ROOT / "structures" / "dolfinx" / "dolfinx_structure")
MODEL = ROOT / "configs" / "granular_obstacle_dolfinx" / "structure.py"


def rank_of(structure: Launch, rank: int) -> int:
    """Process number of a rank."""
    wanted = {f"{name}={rank}".encode() for name in ("OMPI_COMM_WORLD_RANK", "PMIX_RANK")}
    found = [pid for pid in structure.alive() if wanted & {*Path(f"/proc/{pid}/environ").read_bytes().split(b"\0")}]
    assert len(found) == 1, f"rank {rank}: found processes {found}"
    return found[0]


class Dolfinx(ForeignWall):
    def setUp(self) -> None:
        super().setUp()
        self.fem["time_integration"] = {"scheme": "bossak", "alpha": -0.3}
        model = MODEL.read_text(encoding="utf-8").replace("[4, 40]", "[2, 10]")  # as the fem_solver of meeting()
        (self.scene / "structure.py").write_text(model, encoding="utf-8")

    def start_structure(self, ranks: int = 1) -> Launch:
        return self.launch_structure(PROGRAM, "--model", str(self.scene / "structure.py"), "--ranks", str(ranks))

    def start_two(self) -> Launch:
        return self.start_structure(ranks=2)

    def test_check_participant_on_two_ranks(self) -> None:
        self.pass_the_check(self.start_two)

    def test_goes_the_way_of_the_finite_elements(self) -> None:
        """The displacement agrees on one rank and on two; both solvers have the same mesh, law and scheme."""
        found = []
        for ranks in (1, 2):
            self.couple(self.start_two if ranks == 2 else self.start_structure)
            index = (self.out / "structure" / "structure.pvd").read_text()
            self.assertGreater(index.count("DataSet"), 1)
            found.append(self.result())
            shutil.rmtree(self.out)
        expected, iterations = self.result_of_finite_elements([2, 10])
        for peak, mean_iterations in found:
            self.assertAlmostEqual(peak / expected, 1, delta=1e-3)
            self.assertAlmostEqual(mean_iterations, iterations, delta=0.2)
        print(f"A: {found}, {expected:.6g}, {iterations:.2f}")

    def test_a_killed_rank_ends_the_run_with_its_name(self) -> None:
        """The rank with the socket, and the other one."""
        self.files["coupler"]["time"]["end"] = 1000
        self.write_scene(self.files)
        for victim in (0, 1):
            with self.subTest(f"rank {victim}"):
                shutil.rmtree(self.out, ignore_errors=True)
                run = self.start(programs=("coupler", "mpm_solver"))
                structure = self.start_structure(ranks=2)
                rows = self.out / "steps.csv"
                run.wait_until(lambda: rows.exists() and rows.read_text().count("\n") > 20, "20 steps")
                os.kill(rank_of(structure, victim), signal.SIGKILL)
                killed = time.monotonic()
                ended = run.wait()
                print(f"rank {victim}: the run ended {time.monotonic() - killed:.2f} s after the kill")
                self.assertEqual(ended.code, 4, ended.text)
                self.assert_says(ended.text, "[cpl] error: ", 'participant "structure"')
                self.assertNotEqual(structure.wait().code, 0)
                run.wait_none_left()
                structure.wait_none_left()
                self.assertGreater(len(read_table(self.out / "steps.csv")), 19)
                self.assertGreater((self.out / "structure" / "structure.pvd").read_text().count("DataSet"), 0)

    def test_restart_on_two_ranks(self) -> None:
        """The later half, from a checkpoint, has the bits of the straight run."""
        self.couple(self.start_two)
        straight = read_table(self.out / "probes.csv")
        shutil.rmtree(self.out)
        half = "coupler.json:/time/end=0.002"
        self.couple(self.start_two, "--set", half)
        first = self.folder / "first"
        self.out.rename(first)
        self.couple(self.start_two, "--restart", str(first))
        again = read_table(self.out / "probes.csv")
        self.assertGreater(len(again), 5)
        self.assertEqual(again[1:], straight[-(len(again) - 1):])


if __name__ == "__main__":
    launch.main()
