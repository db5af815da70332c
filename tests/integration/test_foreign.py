#!/usr/bin/python3
# SPDX-License-Identifier: BSD-3-Clause
"""A structure that is a foreign code: started by hand, started by scripts/run, checked, lost."""

import json
import os
import re
import subprocess
import unittest
from pathlib import Path

import launch
from launch import IntegrationCase, Launch, free_endpoint, meeting, read_table

ROOT = Path(__file__).resolve().parent.parent.parent
FOREIGN = [str(Path(__file__).resolve().parent / "foreign_structure.py")]
BEAM = [str(ROOT / "configs" / "granular_obstacle_external" / "structure.py")]
PRECICE = ROOT / "tests" / "participant" / "precice_case"
PYTHON = "/usr/bin/python3"


class ForeignCase(IntegrationCase):
    def setUp(self) -> None:
        super().setUp()
        self.files = meeting()
        self.files["mpm"]["interfaces"][0]["penalty"] = 1e7  # with 1e8 round-off decides whether a step is solved
        self.fem = self.files.pop("fem")

    def by_hand(self, *command: str) -> Launch:
        os.environ["PYTHONPATH"] = str(ROOT / "protocol" / "python")
        started = Launch(list(command), self.folder)
        self.addCleanup(started.end)
        return started


class ByHand(ForeignCase):
    """The endpoint stands in coupler.json, and everybody knows it."""

    def setUp(self) -> None:
        super().setUp()
        self.endpoint = free_endpoint()
        everywhere = self.endpoint.replace("127.0.0.1", "0.0.0.0")
        self.files["coupler"]["protocol"] = {"endpoint": everywhere}
        self.write_scene(self.files)

    def start_coupler_and_soil(self) -> Launch:
        return self.start(programs=("coupler", "mpm_solver"))

    def test_all_three_separately(self) -> None:
        """The beam of granular_obstacle_external, whose tip moves as that of the finite elements."""
        arguments = (str(self.scene), "--output", str(self.out))
        coupler = self.by_hand(str(launch.binaries / "coupler"), *arguments)
        coupler.wait_until(lambda: self.out.exists(), "the folder of results")
        soil = self.by_hand(str(launch.binaries / "mpm_solver"), *arguments, "--coupler", self.endpoint)
        structure = self.by_hand(PYTHON, *BEAM, "--coupler", self.endpoint)
        for each in (coupler, soil, structure):
            ended = each.wait()
            self.assertEqual(ended.code, 0, ended.text)
        self.assert_says(coupler.text(), 'participant "structure" (structure.py', "gives no hash of its scene")
        summary = json.loads((self.out / "summary.json").read_text())
        self.assertIs(summary["completed"], True)
        self.assertGreater(summary["steps_in_contact"], 5)
        self.assertEqual(summary["participants"]["structure"]["program"], "structure.py")
        outline = read_table(self.out / "beam" / "outline.csv")
        self.assertEqual(float(outline[-1]["time"]), summary["end_time"])
        self.compare_with_finite_elements()

    def compare_with_finite_elements(self) -> None:
        def peak(folder: Path) -> float:
            return max(float(row["structure.A.ux"]) for row in read_table(folder / "probes.csv"))

        beam = peak(self.out)
        self.fem["mesh"]["box"]["cells"] = [4, 40]
        self.fem["time_integration"] = {"scheme": "bossak", "alpha": -0.3}
        del self.files["coupler"]["protocol"]
        self.write_scene(self.files | {"fem": self.fem})
        self.run_launch(code=0)
        self.assertGreater(beam, 1e-5)
        self.assertAlmostEqual(beam / peak(self.out), 1, delta=0.1)

    def test_coupler_and_soil_in_one_launch(self) -> None:
        run = self.start_coupler_and_soil()
        structure = self.by_hand(PYTHON, *FOREIGN, "good", "--coupler", self.endpoint)
        for each in (run, structure):
            ended = each.wait()
            self.assertEqual(ended.code, 0, ended.text)
        summary = json.loads((self.out / "summary.json").read_text())
        self.assertIs(summary["completed"], True)
        self.assertGreater(summary["steps_in_contact"], 5)
        self.assertEqual(summary["accepted_unconverged"], 0)

    def test_an_adapter_for_precice(self) -> None:
        """The adapter runs unchanged, with steps of its own and names mapped by gabion_names.json; the coupler cuts its
        dt."""
        run = self.start_coupler_and_soil()
        structure = self.by_hand(PYTHON, "-m", "gabion_participant.precice_names", str(PRECICE / "adapter.py"),
                                 str(PRECICE / "precice-config.xml"), "2e-4", "--coupler", self.endpoint)
        for each in (run, structure):
            ended = each.wait()
            self.assertEqual(ended.code, 0, ended.text)
        self.assert_says(structure.text(), "UserWarning: max-time is 1 s in ", "which decides")
        summary = json.loads((self.out / "summary.json").read_text())
        self.assertIs(summary["completed"], True)
        self.assertGreater(summary["steps_in_contact"], 5)
        self.assertEqual(summary["accepted_unconverged"], 0)
        accepted = [line.split() for line in structure.text().splitlines() if re.match(r"[\d.]+ \S+$", line)]
        self.assertEqual(len(accepted), summary["steps"])
        self.assertAlmostEqual(float(accepted[-1][0]), summary["end_time"], delta=1e-6)
        self.assertGreater(max(float(ux) for _, ux in accepted), 1e-5)

    def test_a_foreign_code_that_dies(self) -> None:
        run = self.start_coupler_and_soil()
        structure = self.by_hand(PYTHON, *FOREIGN, "dies", "--coupler", self.endpoint)
        self.assertEqual(structure.wait().code, 9)
        ended = run.wait()
        self.assertEqual(ended.code, 4, ended.text)
        self.assert_says(ended.text, "[cpl] error: ", 'participant "structure" (foreign_structure', "died")
        run.wait_none_left()


class Check(ForeignCase):
    def check(self, habit: str, code: int, *options: str) -> str:
        endpoint = free_endpoint()
        self.write_scene(self.files)
        coupler = self.by_hand(str(launch.binaries / "coupler"), str(self.scene), "--output", str(self.out),
                               "--check-participant", "structure", "--coupler", endpoint, *options)
        self.by_hand(PYTHON, *FOREIGN, habit, "--coupler", endpoint)
        ended = coupler.wait()
        self.assertEqual(ended.code, code, ended.text)
        self.assertFalse(self.out.exists())
        return ended.text

    def test_a_good_one(self) -> None:
        text = self.check("good", 0, "--amplitude", "2.5")
        self.assert_says(text, "the same bits after reject_step ", "passed")
        self.assert_says(text, "the same steps after save, other steps and load", "passed")
        self.assert_says(text, "the end", "passed")
        self.assertNotIn("FAILED", text)

    def test_one_that_keeps_what_was_rejected(self) -> None:
        text = self.check("keeps", 1)
        self.assert_says(text, "the same bits after reject_step ", "FAILED", "differs by", '"wall", vertex')
        self.assert_says(text, "[cpl] error: ", 'participant "structure" failed a check and would spoil a coupled run')

    def test_one_that_dies(self) -> None:
        text = self.check("dies", 1)
        self.assert_says(text, "it stays", "FAILED", 'lost in "step 3: the same bits after reject_step"', "died")
        self.assertNotIn("the end", text)

    def test_one_that_sleeps(self) -> None:
        self.files["coupler"]["protocol"] = {"answer_deadline": 5}
        text = self.check("sleeps", 1)
        self.assert_says(text, "at most 5 s for each of its answers")
        self.assert_says(text, 'waiting for participant "structure"', ", solve_step ", ", since 3 s")
        self.assert_says(text, "it stays", "FAILED", "has not answered", "limit 5 s")
        self.assertLess(text.index("an accepted step "), text.index("it stays"))

    def test_a_minute_for_an_answer_unless_the_scene_says_more(self) -> None:
        self.assert_says(self.check("dies", 1), "at most 60 s for each of its answers")

    def test_a_name_that_is_no_participant(self) -> None:
        self.write_scene(self.files)
        ended = self.run_program("coupler", self.scene, "--check-participant", "fence", code=2)
        self.assert_says(ended.text, 'found "fence", allowed: a participant of coupler.json')

    def test_our_own_solvers(self) -> None:
        for name, program in (("structure", "fem_solver"), ("soil", "mpm_solver")):
            with self.subTest(name):
                self.write_scene(meeting())
                ended = self.run_launch(code=0, programs=("coupler", program),
                                        own={"coupler": ["--check-participant", name]})
                self.assert_says(ended.text, "the same steps after save, other steps and load", "passed")
                self.assert_says(ended.text, "the end", "passed")


class ByScript(ForeignCase):
    """scripts/run starts the commands of coupler.json."""

    def run_script(self, habit: str, *options: str) -> subprocess.CompletedProcess:
        if launch.binaries != ROOT / "build" / "release" / "bin":
            self.skipTest("scripts/run uses build/release only")
        self.files["coupler"]["participants"]["structure"]["command"] = [PYTHON, *FOREIGN, habit]
        self.files["coupler"]["protocol"] = {"connect_deadline": 20}
        self.write_scene(self.files)
        return subprocess.run([ROOT / "scripts" / "run", self.scene, "--output", self.out, "--no-plots", *options],
                              stdin=subprocess.DEVNULL, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True,
                              timeout=launch.TIMEOUT, check=False)

    def test_a_whole_run(self) -> None:
        done = self.run_script("good")
        self.assertEqual(done.returncode, 0, done.stdout)
        self.assert_says(done.stdout, "structure: cd ", "foreign_structure.py good --coupler tcp://127.0.0.1:")
        self.assertIs(json.loads((self.out / "summary.json").read_text())["completed"], True)

    def test_a_command_that_does_not_start(self) -> None:
        done = self.run_script("fails")
        self.assertNotEqual(done.returncode, 0, done.stdout)
        self.assert_says(done.stdout, "this code does not start")
        self.assert_says(done.stdout, "structure ended with exit code 3")

    def test_a_command_that_dies(self) -> None:
        done = self.run_script("dies")
        self.assertEqual(done.returncode, 4, done.stdout)
        self.assert_says(done.stdout, 'participant "structure"', "died")

    def test_check(self) -> None:
        for habit, code in (("good", 0), ("keeps", 1)):
            with self.subTest(habit):
                done = self.run_script(habit, "--check-participant", "structure")
                self.assertEqual(done.returncode, code, done.stdout)
                self.assert_says(done.stdout, "the same bits after reject_step ", "FAILED" if code else "passed")


if __name__ == "__main__":
    launch.main()
