#!/usr/bin/python3
# SPDX-License-Identifier: BSD-3-Clause
"""The measures of scripts/bench on runs whose answers are known, and each study as a whole."""

import contextlib
import csv
import io
import json
import platform
import re
import unittest
from pathlib import Path
from unittest import mock

import numpy as np
from script_case import ROOT, ScriptCase

import made_up_results as made_up
import measured
from plotting.results import Results, ResultsError
from studies import codes, contact, coupling, ensemble, instructions
from studies.columns import COLLAPSE, FACTORS, columns, compare
from studies.coupled import FORCE_LIMITS, LIMITS, STUDIES, acceleration, error_vs_time, speed, tolerance
from studies.measures import Curve, Measured, relative_rms
from studies.outcome import beyond, largest_rise, outcome, verdict
from studies.run_out import height_law, run_out, run_out_law
from studies.runner import Attempt, Runner, Start
from studies.stability import cases, families, folder, stability
from studies.throw import LEVELS, Throw, sample


class ProgramTest(ScriptCase):
    def test_lists_every_study(self) -> None:
        shown = self.script("bench", "--help")
        self.assertEqual(shown.returncode, 0, shown.stderr)
        for study in (speed, error_vs_time, acceleration, columns, run_out, coupling.coupling, stability):
            self.assertRegex(shown.stdout, rf"(?m)^  {study.__name__} +{re.escape(study.__doc__)}$")
            self.assertTrue((measured.FOLDER / f"{study.__name__}.md").exists(), study.__name__)


class RanksOfRuns(ScriptCase):
    def test_they_do_not_follow_from_the_machine(self) -> None:
        def words(start: Start) -> list[str]:
            return Runner(self.folder, False, [], start)._command(self.folder / "run", "scene", [])

        self.assertEqual(words(Start())[-2:], ["--ranks", "mpm=1"])
        self.assertEqual(words(Start(words=("--ranks", "mpm=2")))[-2:], ["--ranks", "mpm=2"])  # the last one holds


class MadeUpRunner(Runner):
    """Writes made-up results instead of running. scale_of: label -> scale of displacement and force."""

    scales: dict[str, float] = {}

    def run(self, label: str, scene: str, settings: list[str]) -> Measured:
        scale = self.scales.get(label, 1.0)
        return Measured(Results(made_up.write_results(self.folder / label, scale)))


class MadeUpColumn(Runner):
    """Columns of soil that stay as they are; `broken` names runs that fail."""

    broken: tuple[str, ...] = ()

    def run(self, label: str, scene: str, settings: list[str]) -> Measured:
        if label in self.broken:
            raise ResultsError(f"{label}: the run failed with exit code 3")
        width = 0.2 if scene == COLLAPSE else 0.1
        x, y = np.meshgrid(np.arange(0.001, width, 0.002), np.arange(0.001, 0.1, 0.002))
        points = np.column_stack([x.ravel(), y.ravel(), np.zeros(x.size)])
        frames = [(time, points, None, {"displacement": np.zeros_like(points)}) for time in (0.0, 1.0)]
        made_up.write_series(self.folder / label / "mpm", "soil", frames)
        summary = {"completed": True, "steps": 10, "newton_iterations": 45, "cuts": 1, "cpu_seconds": 2.5}
        (self.folder / label / "summary.json").write_text(json.dumps(summary))
        return Measured(Results(self.folder / label))


class WrittenPage(ScriptCase):
    """Page that --write makes of a study."""

    def setUp(self) -> None:
        super().setUp()
        self.pages = self.folder / "measured"
        patch = mock.patch.object(measured, "FOLDER", self.pages)
        patch.start()
        self.addCleanup(patch.stop)

    def write_page(self, *options: str) -> str:
        def made_up_run(runner: Runner, label: str, scene: str, settings: list[str]) -> Measured:
            return Measured(Results(made_up.write_results(runner.folder / label, 1)))

        with mock.patch.object(Runner, "run", made_up_run):
            result = self.python_script("bench", "mesh_convergence", "--output", self.folder / "out", *options)
        self.assertEqual(result.returncode, 0, result.stderr)
        return result.stdout

    def test_page_has_source_table_and_figure(self) -> None:
        self.write_page("--write", "--set", "coupler.json:/time/dt=1e-4")
        title, source, table, *_, last = (self.pages / "mesh_convergence.md").read_text().rstrip("\n").split("\n\n")
        self.assertTrue(title.startswith("# A's displacement"), title)
        self.assertRegex(source.replace("\n", " "),
                         r"^`scripts/bench mesh_convergence --set coupler.json:/time/dt=1e-4`: "
                         r"version \d+\.\d+\.\d+, \d+ cores of .+, \d{4}-\d\d-\d\d$")
        self.assertNotIn(platform.node(), source.split())
        head = ["model", "peak of A [mm]", "at t [s]", "residual [mm]", "impulse [N s/m]", "run time [s]"]
        lines = table.splitlines()
        self.assertEqual(lines[:2], [f"| {' | '.join(head)} |", "| --- | --- | --- | --- | --- | --- |"])
        self.assertRegex(lines[2], r"^\| h = 5 mm \| 4 \| 0\.\d+ \| \d\.\d+ \| 7 \| 12.5 \|$")
        self.assertEqual(last, "![mesh convergence](mesh_convergence.png)")
        self.assertTrue((self.pages / "mesh_convergence.png").exists())

    def test_what_is_written_by_hand_stays(self) -> None:
        page = self.write("measured/mesh_convergence.md", "# Old\n\n**Question:** which?\n**Answer:** this.\n\nold\n\n"
                          "## What it shows\n\nThis | stays.\n")
        self.write_page("--write")
        text = page.read_text()
        self.assertTrue(text.endswith(".png)\n\n## What it shows\n\nThis | stays.\n"), text)
        self.assertNotIn("old", text)
        title, opening, source, *_ = text.split("\n\n")
        self.assertTrue(title.startswith("# A's displacement"), title)
        self.assertEqual(opening, "**Question:** which?\n**Answer:** this.")
        self.assertTrue(source.startswith("`scripts/bench mesh_convergence`"), source)

    def test_prose_is_wrapped_and_tables_are_not(self) -> None:
        words = "word " * 40
        lines = measured.wrapped(f"| {words}|\n- {words.strip()}").splitlines()
        self.assertEqual(lines[0], f"| {words}|")
        self.assertTrue(all(len(line) <= 120 for line in lines[1:]), lines)
        self.assertTrue(lines[2].startswith("  word"))

    def test_nothing_is_written_without_the_option(self) -> None:
        self.write_page()
        self.assertFalse(self.pages.exists())


class Measures(ScriptCase):
    def test_relative_rms(self) -> None:
        time = np.linspace(0, 1, 101)
        reference = Curve(time, np.sin(time))
        self.assertAlmostEqual(relative_rms(Curve(time, 1.1 * np.sin(time)), reference), 0.1, places=12)
        coarse = Curve(time[::10], np.sin(time[::10]))
        self.assertLess(relative_rms(coarse, reference), 1e-3)

    def test_run_that_stopped_early_is_refused(self) -> None:
        time = np.linspace(0, 1, 11)
        with self.assertRaisesRegex(ResultsError, "end at 0.9 s and 1 s"):
            relative_rms(Curve(time[:-1], time[:-1]), Curve(time, time))

    def test_mean_of_last(self) -> None:
        time = np.array([0.0, 0.5, 0.93, 1.0])  # uneven steps, linear values: exact
        self.assertAlmostEqual(Curve(time, 2 * time).mean_of_last(0.1), 1.9, places=12)

    def test_force_and_impulse(self) -> None:
        run = Measured(Results(made_up.write_results(self.folder, scale=2, iterations=7)))
        self.assertAlmostEqual(run.impulse().values[-1], 2 * made_up.FORCE * (made_up.END - made_up.CONTACT), places=9)
        self.assertAlmostEqual(run.force().mean_of_last(0.1), 2 * made_up.FORCE, places=9)
        self.assertEqual(set(run.iterations_in_contact()), {7})

    def test_unfinished_run_is_refused(self) -> None:
        made_up.write_results(self.folder)
        (self.folder / "summary.json").write_text(json.dumps({"completed": False, "reason": "x"}))
        with self.assertRaisesRegex(ResultsError, "did not come to its end"):
            Measured(Results(self.folder))


class Ensembles(ScriptCase):
    def asked_for(self, make) -> list[tuple[str, list[str]]]:
        """Label and settings of each run that `make` asks a runner for."""
        runs = []

        class Recording(Runner):
            def run(self, label: str, scene: str, settings: list[str]) -> Measured:
                runs.append((label, settings))
                return Measured(Results(made_up.write_results(self.folder / label)))

        self.assertEqual(len(make(Recording(self.folder, reuse=False, settings=[]))), len(runs))
        return sorted(runs)

    def test_members_have_the_wall_at_places_over_a_cell(self) -> None:
        runs = self.asked_for(
            lambda runner: ensemble.over_places(runner, "a, b", "granular_obstacle", ["x"], 2, 0.005))
        self.assertEqual([label for label, _ in runs], ["a_b_0", "a_b_1"])
        for way, (_, settings) in zip((-0.00125, 0.00125), runs):
            values = {key: json.loads(value) for key, _, value in (text.partition("=") for text in settings[1:])}
            surface = values.pop("mpm.json:/interfaces/0/surface/polyline")
            expected = [[0.26, 0], [0.26, 0.05], [0.25, 0.05], [0.25, 0]]
            np.testing.assert_allclose(surface, np.array(expected) + [way, 0])
            for key, point in {"mesh/box/low": [0.25, 0], "mesh/box/high": [0.26, 0.05],
                               "probes/0/point": [0.25, 0.05]}.items():
                np.testing.assert_allclose(values.pop(f"fem.json:/{key}"), np.array(point) + [way, 0])
            self.assertEqual(values, {})

    def test_members_differ_in_their_modulus(self) -> None:
        runs = self.asked_for(
            lambda runner: ensemble.with_other_modulus(runner, "a", "granular_obstacle", ["x"], 2, 1e-3))
        self.assertEqual(runs, [("a_0", ["x"]),
                                ("a_1", ["x", f"mpm.json:/bodies/0/material/young_modulus={840e3 * 1.001!r}"])])

    def test_error_is_that_off_a_line_over_the_places(self) -> None:
        self.assertAlmostEqual(ensemble.error([1.0, 2.0, 3.0]), 0)
        self.assertAlmostEqual(ensemble.deviation([0.0, 3.0, 0.0]), np.sqrt(6))  # off the line y = 1
        self.assertAlmostEqual(ensemble.error([5.0, 8.0, 5.0]), np.sqrt(2))

    def test_mean_has_the_digits_that_its_error_allows(self) -> None:
        self.assertEqual(ensemble.mean_and_error([1.0, 4.0, 1.0]), "2.0 ± 1.4")
        self.assertEqual(ensemble.mean_and_error([100.0, 400.0, 100.0]), "200 ± 141")
        self.assertEqual(ensemble.mean_and_error([5.0, 5.0, 5.0]), "5.0000 ± 0.0000")

    def test_range_is_that_of_the_means(self) -> None:
        runs = {name: [Measured(Results(made_up.write_results(self.folder / f"{name}{k}", scale)))
                       for k, scale in enumerate(scales)]
                for name, scales in {"one": (0.9, 1.2, 0.9), "other": (1.1, 1.4, 1.1)}.items()}
        with contextlib.redirect_stdout(io.StringIO()):
            contact.report_range(Runner(self.folder, False, []), runs, "forms")
        for row in list(csv.reader((self.folder / "forms.csv").read_text().splitlines()))[1:]:
            np.testing.assert_allclose([float(value) for value in row[1:]],  # means 1, 1.2; deviation 0.1 sqrt(6)
                                       [20 / 1.1, 10 * np.sqrt(2) / 1.1, 10 * np.sqrt(6) / 1.1], rtol=1e-6)

    def test_order_only_where_the_differences_are_clear(self) -> None:
        def of(*scales: float) -> list[Measured]:
            return [Measured(Results(made_up.write_results(self.folder / f"{k}_{scale}", scale)))
                    for k, scale in enumerate(scales)]

        with contextlib.redirect_stdout(io.StringIO()):
            for name, finest in (("clear", 1.016), ("unclear", 1.075)):
                sizes = {"5": of(1.4, 1.403, 1.4), "2.5": of(1.1, 1.103, 1.1),
                         "1.25": of(finest, finest + 0.03, finest)}
                contact.report_orders(Runner(self.folder, False, []), sizes, name)
        for name, exact in (("clear", np.log2(0.3 / 0.075)), ("unclear", None)):
            for row in list(csv.reader((self.folder / f"{name}.csv").read_text().splitlines()))[1:]:
                if exact is None:
                    self.assertEqual(row[3], "none")
                else:
                    self.assertAlmostEqual(float(row[3]), exact, places=6)


class Stability(ScriptCase):
    def test_every_case_has_its_name_and_the_base_comes_first(self) -> None:
        names = [case.name for case in cases()]
        self.assertEqual(names[0], "base")
        self.assertEqual(len(set(names)), len(names))
        self.assertEqual(sum(name.startswith("E_x") for name in names), 15)

    def test_the_sweep_has_two_hundred_runs_in_folders_of_their_own(self) -> None:
        folders = [folder(family, case) for family, listed in families().items() for case in listed]
        self.assertGreaterEqual(len(folders), 200)
        self.assertEqual(len(set(folders)), len(folders))

    def test_samples_are_the_same_each_time_and_within_the_levels(self) -> None:
        drawn = sample(Throw(), 16, seed=3)
        self.assertEqual(drawn, sample(Throw(), 16, seed=3))
        for name, levels in LEVELS.items():
            values = [getattr(throw, name) for throw in drawn.values()]
            self.assertTrue(all(levels[0] <= value <= levels[-1] for value in values), name)
            self.assertGreater(len(set(values)), 3, name)

    def test_verdict_names_causes_and_refuses_an_end_without_one(self) -> None:
        self.assertEqual(verdict({"completed": True}), "end")
        reason = "step 3 at time 0.25 s failed with dt = 1 s and no smaller dt is allowed (dt_min = 1 s): x; y"
        self.assertEqual(verdict({"completed": False, "reason": reason, "end_time": 0.25}), "0.25 s: x")
        with self.assertRaisesRegex(ResultsError, "without a reason"):
            verdict({"completed": False, "end_time": 0.25})

    def test_points_beyond_a_bent_wall(self) -> None:
        face = np.array([[1, 0], [1.5, 0.5], [1, 1]])
        points = np.array([[1.2, 0.5], [1.2, 0.1], [0.9, 0.9], [1.6, 0.5], [1.01, -0.5], [0.9, -0.5]])
        self.assertEqual(beyond(face, points).tolist(), [False, True, False, True, True, False])

    def test_largest_rise_counts_from_the_lowest_value_before(self) -> None:
        self.assertEqual(largest_rise(np.array([5.0, 2.0, 3.0, 1.0, 2.5, 2.0])), 1.5)

    def test_a_run_that_left_nothing_is_not_named(self) -> None:
        found = outcome(Attempt(134, None), None)
        self.assertFalse(found.named)
        self.assertEqual(found.faults, ["exit code 134, nothing written"])


class Studies(ScriptCase):
    def table(self, study, scales: dict[str, float]) -> list[list[str]]:
        runner = MadeUpRunner(self.folder, reuse=False, settings=[])
        runner.scales = scales
        with contextlib.redirect_stdout(io.StringIO()):
            study(runner)
        with (self.folder / "table.csv").open(newline="") as file:
            return list(csv.reader(file))[1:]

    def test_error_vs_time(self) -> None:
        rows = self.table(error_vs_time, {"dt_1_ms": 1.2, "time_error_0.004": 1.1, "time_error_0.008": 0.7,
                                          "explicit_dt_0.5_ms": 1.4, "explicit_limits": 0.8})
        sizes = ["1", "0.5", "0.2", "0.1", "0.05", "0.025"]
        names = [f"dt {size} ms" for size in sizes] + [f"time_error {e}" for e in ("0.008", "0.004", "0.002", "0.001")]
        names += [*(f"explicit, dt {size} ms" for size in sizes[:5]), "explicit, limits"]
        names += [f"explicit, dt {size} ms, wide" for size in sizes[:3]]
        self.assertEqual([row[0] for row in rows], names)
        for errors in (9, 10):
            self.assertEqual(rows[5][errors], "")
            found = [float(row[errors]) for row in rows[:5] + rows[6:]]
            exact = [0.2, 0, 0, 0, 0, 0.3, 0.1, 0, 0, 0, 0.4, 0, 0, 0, 0.2, 0, 0, 0]
            np.testing.assert_allclose(found, exact, atol=1e-12)
        self.assertAlmostEqual(float(rows[0][3]), 1.2 * 2e3 * made_up.AMPLITUDE, places=2)  # 1 - cos: twice
        self.assertAlmostEqual(float(rows[7][5]), 1.1 * made_up.FORCE, places=9)

    def test_tolerance(self) -> None:
        rows = self.table(tolerance, {"force_0.01_N": 1.1, "force_0.1_N": 0.7})
        self.assertEqual([float(row[0]) for row in rows], FORCE_LIMITS)
        for errors in (10, 11):
            self.assertEqual(rows[0][errors], "")
            found = [float(row[errors]) for row in rows[1:]]
            np.testing.assert_allclose(found, [0, 0, 0, 0.1, 0, 0.3], atol=1e-12)
        self.assertAlmostEqual(float(rows[-1][6]), 0.7 * made_up.FORCE, places=9)

    def test_fixed_steps_switch_every_limit_off(self) -> None:
        schema = json.loads((ROOT / "docs" / "keys" / "mpm.schema.json").read_text())
        limits = schema["definitions"]["step_control"]["properties"]
        self.assertEqual(set(limits), set(LIMITS))

    def test_speed(self) -> None:
        free, contact = self.table(speed, {})
        self.assertEqual(free[:2], ["free flow", "150"])
        np.testing.assert_allclose([float(value) for value in free[2:]], [10, 7, 0, 2, 0], atol=1e-12)
        np.testing.assert_allclose([float(value) for value in contact[2:]], [10, 5, 1, 2, 1], atol=1e-12)
        tables = {name: list(csv.reader((self.folder / f"{name}.csv").read_text().splitlines()))[1]
                  for name in ("later iterations", "output")}
        # Five iterations of 2 ms each, of which the soil has 2 ms in the first, 1 ms in a later one.
        np.testing.assert_allclose([float(value) for value in tables["later iterations"][1:]],
                                   [350, 5, 3, 1, 4 / 6, 4 / 10], atol=1e-12)
        np.testing.assert_allclose([float(value) for value in tables["output"][1:]], [10, 0.2, 0.02], atol=1e-12)

    def test_codes(self) -> None:
        """Parts and rest add up to the step; a code that is not there is named."""
        with mock.patch.object(codes, "CODES", {"one": codes.Code("granular_obstacle", "sh"),
                                                "other": codes.Code("granular_obstacle_other", "no/such/program")}):
            out = io.StringIO()
            runner = MadeUpRunner(self.folder, reuse=False, settings=[])
            with contextlib.redirect_stdout(out):
                codes.codes(runner)
        rows = list(csv.DictReader((self.folder / "table.csv").open(newline="")))
        self.assertEqual([row.pop("structure") for row in rows], ["one"])
        self.assertIn("not here: other (no/such/program)", out.getvalue())
        self.assertEqual(float(rows[0]["iterations a step"]), 5)
        np.testing.assert_allclose([float(rows[0][name]) for name in codes.HEAD[3:]], [10, 5, 1, 2, 1, 1, 0.2])

    def test_every_code_has_its_scene(self) -> None:
        for name, code in codes.CODES.items():
            self.assertTrue((ROOT / "configs" / code.scene / "coupler.json").is_file(), name)

    def test_failed_run_stands_in_the_table(self) -> None:
        class Failing(MadeUpRunner):
            def run(self, label, scene, settings):
                if label == "constant":
                    raise ResultsError("constant: the run failed with exit code 3")
                return super().run(label, scene, settings)

        with contextlib.redirect_stdout(io.StringIO()):
            acceleration(Failing(self.folder, reuse=False, settings=[]))
        text = (self.folder / "table.csv").read_text()
        self.assertIn("constant,failed", text)
        self.assertIn("MVQN,5.0,5,0,12.5", text)

    def test_every_study_runs(self) -> None:
        for name, study in STUDIES.items():
            with self.subTest(name):
                self.assertTrue(self.table(study, {}))


class Coupling(ScriptCase):
    """The tables of coupling_benchmark, made up here."""

    def program(self, grid_row: str, code: int = 0) -> None:
        text = ('#!/bin/sh\ncase $1 in\n'
                'affine) printf "m,mvqn\\n2,11 8\\n";;\ntube) printf "method,mean\\nmvqn,8.3\\n";;\n'
                f'grid) printf "filter,mean,max\\n{grid_row}\\n";;\n'
                'overhead) printf "$2,$3,100,60,30,10,12\\n";;\nesac\n'
                f'exit {code}\n')
        binary = self.write("coupling_benchmark", text)
        binary.chmod(0o755)
        for name, value in (("BINARY", binary), ("SETUP", "/bin/true")):
            self.addCleanup(setattr, coupling, name, getattr(coupling, name))
            setattr(coupling, name, value)

    def run_study(self) -> str:
        out = io.StringIO()
        with contextlib.redirect_stdout(out):
            coupling.coupling(Runner(self.folder / "out", reuse=False, settings=[]))
        return out.getvalue()

    def test_tables_are_printed_and_written(self) -> None:
        self.program("qr2,failed,60")
        printed = self.run_study()
        self.assertIn("1 of 1 settings of MVQN failed", printed)
        rows = list(csv.reader((self.folder / "out" / "overhead.csv").open(newline="")))
        self.assertEqual(len(rows), 1 + 9)
        self.assertEqual(rows[-1], ["iqn_ils", "10000", "100", "60", "30", "10", "12", "29000"])

    def test_a_program_that_fails_or_cannot_be_built_is_an_error(self) -> None:
        self.program("qr2,8,20", code=1)
        with self.assertRaisesRegex(ResultsError, "coupling_benchmark affine: exit code 1"):
            self.run_study()
        coupling.SETUP = "/bin/false"
        with self.assertRaisesRegex(ResultsError, "coupling_benchmark could not be built"):
            self.run_study()


class Instructions(unittest.TestCase):
    def test_a_row_is_the_difference_of_two_runs(self) -> None:
        few = instructions.Count(points=100, newton=6, krylov=20, total=9_000_000, stress=4_000_000, solve=2_000_000)
        many = instructions.Count(points=100, newton=10, krylov=40, total=17_000_000, stress=8_000_000,
                                  solve=3_000_000)
        self.assertEqual(instructions.row("form", 2, few, many),
                         ["form", 100, 2, 5, 4, 2, "50 %", "12 %", 20_000])

    def test_inclusive_counts_are_read_by_name(self) -> None:
        listing = ("--------\n"
                   " 9,000 (90.0%)  ???:gabion::mpm::InternalForces<2>::evaluate(std::span<double>) [mpm_solver]\n"
                   " 1,234 (12.3%)  ???:gabion::LinearSolver<2>::solve(std::span<double>) [mpm_solver]\n"
                   " 1,200 (12.0%)  ???:gabion::LinearSolver<2>::Implementation::solve(int) [mpm_solver]\n")
        self.assertEqual(instructions.inclusive(listing, r"gabion::LinearSolver<\d>::solve"), 1234)
        self.assertEqual(instructions.inclusive(listing, r"gabion::mpm::InternalForces<\d>::evaluate"), 9000)
        self.assertEqual(instructions.inclusive(listing, "gabion::mpm::Absent"), 0)

    def test_laws_are_compared_with_the_first_in_the_same_state(self) -> None:
        def count(folder: Path, settings: dict, steps: int) -> instructions.Count:
            plastic, tresca = "yielding" in folder.name, settings["bodies"][0]["material"]["law"] == "tresca"
            stress = (1000 if plastic else 400) * (2 if tresca else 1)
            return instructions.Count(points=10, newton=2 * steps, krylov=0, total=2 * steps * 10 * 3000,
                                      stress=2 * steps * 10 * stress, solve=0)

        with (mock.patch.object(instructions, "count", count), mock.patch.object(instructions, "check_state"),
              contextlib.redirect_stdout(io.StringIO())):
            rows = {row[0]: row[1:] for row in instructions.law_rows(Path("unused"))}
        self.assertEqual(rows["Mohr-Coulomb"], [400, 1, 3000, 1000, 1, 3000])
        self.assertEqual(rows["Tresca"], [800, 2, 3000, 2000, 2, 3000])
        self.assertEqual(rows["Newtonian fluid"], ["", "", "", 1000, 1, 3000])

    def test_a_block_in_another_state_than_its_row_says_is_an_error(self) -> None:
        for state, strain in (("elastic", [0, 1e-4]), ("yielding", [0, 1e-4])):
            frame = mock.Mock(fields={"plastic_strain": np.array(strain)})
            with mock.patch.object(instructions, "Results") as results:
                results.return_value.frames_of_soil.return_value.frame.return_value = frame
                with self.assertRaisesRegex(ResultsError, f"Tresca, {state}: 50 %"):
                    instructions.check_state(Path("unused"), state, "Tresca")

    def test_without_valgrind_it_says_how_to_get_it(self) -> None:
        with mock.patch.object(instructions.shutil, "which", return_value=None):
            with self.assertRaisesRegex(ResultsError, "apt-get install .* valgrind"):
                instructions.instructions(Runner(Path("unused"), reuse=False, settings=[]))


class Columns(ScriptCase):
    def rows(self, study, broken: tuple[str, ...] = ()) -> list[list[str]]:
        runner = MadeUpColumn(self.folder, reuse=False, settings=[])
        runner.broken = broken
        with contextlib.redirect_stdout(io.StringIO()):
            study(runner)
        with (self.folder / "table.csv").open(newline="") as file:
            return list(csv.reader(file))[1:]

    def test_soil_that_stayed(self) -> None:
        row = self.rows(lambda runner: compare(runner, {"as it was": []}))[0]
        self.assertEqual(row[0], "as it was")
        self.assertAlmostEqual(float(row[2]), 100 - 48.1, delta=1)  # at the gate: 100 mm, measured 48.1 mm
        self.assertAlmostEqual(float(row[3]), 0.1988)
        self.assertAlmostEqual(float(row[4]), 0.2, delta=1e-3)
        self.assertEqual([float(value) for value in row[6:]], [1, 4.5, 1, 2.5])

    def test_failed_run_stands_in_the_table(self) -> None:
        rows = self.rows(lambda runner: compare(runner, FACTORS), broken=("TPIC",))
        self.assertEqual(len(rows), len(FACTORS))
        self.assertEqual([row[1] for row in rows if row[0] == "TPIC"], ["failed"])

    def test_studies_run(self) -> None:
        self.assertEqual(len(self.rows(columns)), 11)
        rows = self.rows(run_out)
        self.assertEqual([float(row[0]) for row in rows], [0.5, 1, 2, 5])
        self.assertAlmostEqual(float(rows[1][4]), 1, delta=0.02)  # height by width of a square column

    def test_laws(self) -> None:
        np.testing.assert_allclose([run_out_law(a) for a in (0.5, 1, 2, 5)], [0.6, 1.2, 3.016, 5.556], rtol=1e-3)
        np.testing.assert_allclose([height_law(a) for a in (0.5, 1, 2, 5)], [0.5, 1, 1.3195, 1.9037], rtol=1e-4)


if __name__ == "__main__":
    unittest.main()
