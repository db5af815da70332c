#!/usr/bin/python3
# SPDX-License-Identifier: BSD-3-Clause
"""The words on a run that scripts/watch and scripts/report share."""

import json
import unittest

from made_up_results import KINDS, REASON, write_kind
from script_case import ScriptCase

STEPS = "step,time,dt,iterations,status,cuts,soil_work,work_sum,soil.busy_seconds,soil.message_seconds,wall_seconds\n"


class VerdictCase(ScriptCase):
    def said(self) -> dict[str, list[tuple[str, str]]]:
        """Topic -> kinds and texts."""
        from plotting.live import Run  # noqa: PLC0415
        from plotting.verdict import verdict  # noqa: PLC0415
        run = Run(self.folder)
        run.read_on()
        found: dict[str, list[tuple[str, str]]] = {}
        for statement in verdict(run):
            found.setdefault(statement.topic, []).append((statement.kind, statement.text))
        return found

    def one(self, topic: str) -> tuple[str, str]:
        said = self.said()
        self.assertEqual(len(said.get(topic, [])), 1, said)
        return said[topic][0]


class Ends(VerdictCase):
    def test_each_kind(self) -> None:
        expected = {
            "finished": ("good", "Completed: 500 steps to t = 0.5 s in 12 s."),
            "cut": ("good", "Completed: 500 steps to t = 0.5 s in 12 s."),
            "failed": ("bad", f"Failed after 500 steps to t = 0.5 s: {REASON}."),
            "stopped": ("note", "Stopped after 500 steps to t = 0.5 s: interrupted by signal 15 (Terminated). It can "
                                "go "
                        "on from step 500: scripts/run SCENE --restart "),
            "unfinished": ("note",
                           "Running: 500 steps to t = 0.5 s of 1 s (50 %). All that follows is of these steps."),
            "killed": ("bad", "Killed, or running on another machine: 500 steps to t = 0.5 s, no summary.json, no new "
                              "row "
                       "for "),
        }
        self.assertEqual(set(expected), set(KINDS))
        for kind, (judged, text) in expected.items():
            with self.subTest(kind):
                self.setUp()
                write_kind(self.folder, kind)
                found = self.one("end")
                self.assertEqual(found[0], judged)
                self.assertTrue(found[1].startswith(text), found[1])

    def test_the_word_in_front(self) -> None:
        from plotting.live import Run  # noqa: PLC0415
        from plotting.verdict import headline  # noqa: PLC0415
        words = {"finished": "completed", "cut": "completed", "failed": "failed", "stopped": "stopped",
                 "unfinished": "running", "killed": "killed"}
        for kind in KINDS:
            run = Run(write_kind(self.folder / kind, kind))
            run.read_on()
            self.assertEqual(headline(run), words[kind])

    def test_nobody_can_be_asked(self) -> None:
        """There is no log, as in a run without coupler: only time tells."""
        write_kind(self.folder, "killed")
        (self.folder / "coupler.log").unlink()
        kind, text = self.one("end")
        self.assertEqual(kind, "bad")
        self.assertIn("Killed, or in a step that takes long", text)


class Words(VerdictCase):
    def test_cuts_and_why(self) -> None:
        write_kind(self.folder, "cut")
        kind, text = self.one("cuts")
        self.assertEqual(kind, "note")
        self.assertEqual(text, "3 cuts of the step size, first in step 251 before t = 0.251 s. "
                               'Why: 2 × "soil": Newton: iteration limit reached; 1 × the residual grows.')
        (self.folder / "coupler.log").unlink()
        self.assertIn("Why: 3 × diverged.", self.one("cuts")[1])

    def test_no_cut(self) -> None:
        write_kind(self.folder, "finished")
        self.assertEqual(self.one("cuts"), ("good", "No step was cut."))

    def test_convergence(self) -> None:
        write_kind(self.folder, "finished")
        self.assertEqual(self.one("convergence"),
                         ("good", "Every step converged: 350 in contact with 5 iterations each, "
                                                           "5 at most; 150 without contact."))
        text = (self.folder / "steps.csv").read_text()
        (self.folder / "steps.csv").write_text(text.replace("converged", "limit_reached", 2))
        kind, text = self.one("convergence")
        self.assertEqual(kind, "bad")
        self.assertEqual(text, "2 steps were accepted without convergence (2 limit reached), the first is step 151 at "
                               "t = 0.151 s.")

    def test_convergence_that_is_not_asked(self) -> None:
        self.write("steps.csv", STEPS + "1,0.1,0.1,1,explicit,0,1,0,0.5,0.1,1\n")
        self.assertEqual(self.one("convergence")[0], "note")
        self.write("steps.csv", "step,time,dt,newton_iterations,cuts,wall_seconds\n1,0.1,0.1,3,0,1\n2,0.2,0.1,6,0,1\n")
        self.assertEqual(self.one("convergence"),
                         ("good", "Every step converged: 4.5 Newton iterations each, 6 at most."))
        self.write("steps.csv", STEPS)
        self.assertNotIn("convergence", self.said())

    def test_slow_steps_and_who_was_waited_for(self) -> None:
        quick = "".join(f"{k},0.{k},0.1,2,converged,0,1,0,0.006,0.002,0.01\n" for k in range(1, 10))
        self.write("steps.csv", STEPS + quick)
        self.assertEqual(self.one("time"),
                         ("good", "A step took 10 ms on average, 10 ms in the median. The coupler "
                                                    "waited for: soil 60 %, messages 20 %. No step was slow."))
        self.write("steps.csv", STEPS + quick + "17,1.0,0.1,2,converged,0,1,0,0.01,1.8,1.91\n")
        kind, text = self.one("time")
        self.assertEqual(kind, "note")
        self.assertIn("1 slow step, over 10 times that, took 96 % of the time; the slowest is step 17 with 1.91 s; 94 "
                      "% of that was for messages.", text)

    def test_work_of_the_coupling(self) -> None:
        for made, kind, word in ((1e-4, "good", "made 0.01 %"), (-5e-3, "note", "took 0.5 %"),
                                 (0.2, "bad", "made 20 %")):
            self.write("steps.csv", STEPS + f"1,0.1,0.1,2,converged,0,-1,{made},0,0,1\n")
            self.assertEqual(self.one("energy"), (kind, f"The coupling {word} of the work that it passed on."))


class Ledgers(VerdictCase):
    HEAD = ("time,soil.gravity_work,soil.energy_balance,soil.created_energy,soil.momentum_x,soil.momentum_error_x\n"
            "0,0,0,0,0,0\n")

    def test_soil(self) -> None:
        for row, energy, momentum in (
                ("1,10,1e-4,0,2,0", ("good",
                                     "closed. Of the 10 J/m that were exchanged, 0.001 % are missing and 0 % were"),
                 ("good", "closed. Missing: 0 % of 2 kg m/s/m, the largest momentum, or")),
                ("1,10,0,-0.05,2,0.01", ("note", "closed. Of the 10 J/m"), ("note", "closed. Missing: 0.5 %")),
                ("1,10,2,0,2,1", ("bad", "not closed. Of the 10 J/m that were exchanged, 20 % are missing"),
                 ("bad", "not closed. Missing: 50 %")),
                ("1,10,0,3,2,0", ("bad",
                                  "not closed. Of the 10 J/m that were exchanged, 0 % are missing and 30 % were"),
                 ("good", "closed"))):
            self.write("probes.csv", f"{self.HEAD}{row}\n")
            said = self.said()
            for topic, (kind, words) in (("energy", energy), ("momentum", momentum)):
                self.assertEqual(said[topic][0][0], kind, said)
                self.assertIn(f"{topic.capitalize()} of soil: {words}", said[topic][0][1])

    def test_momentum_of_soil_at_rest(self) -> None:
        head = ("time,soil.mass,soil.gravity_work,soil.energy_balance,soil.momentum_y,soil.momentum_error_y\n"
                "0,480,0,0,0,0\n")
        for error, kind in ((0.01, "good"), (0.1, "note"), (0.3, "bad")):
            self.write("probes.csv", f"{head}1,480,0.5,0,0.37,{error}\n")
            self.assertEqual(self.said()["momentum"][0][0], kind)

    def test_structure(self) -> None:
        head = "time,fence.kinetic_energy,fence.elastic_energy,fence.external_work,soil.momentum_z\n0,0,1,0,0\n"
        lost = "it lost 25 % of the 2 J that came in, by its time integration"
        for row, kind, words in (("1,1,1.5,2,0", "good", lost),
                                 ("1,1,2.5,2,0", "bad", "it has 25 % more than the 2 J that came in"),
                                 ("1,4,1,2,0", "bad", "it has 100 % more than the 2 J that came in; waves that are "
                                                      "shorter than the step ring in it")):
            self.write("probes.csv", f"{head}{row}\n")
            self.assertEqual(self.one("energy"), (kind, f"Energy of fence: {words}."))

    def test_structure_whose_supports_worked_before_the_start(self) -> None:
        self.write("probes.csv", "time,kinetic_energy,elastic_energy,external_work\n0,0,200,200\n1,50,149,200\n")
        self.assertEqual(self.one("energy"),
                         ("good", "Energy of structure: it lost 0.5 % of the 200 J/m that came in, by "
                                                      "its time integration."))

    def test_structure_in_statics(self) -> None:
        self.write("probes.csv", "time,kinetic_energy,elastic_energy,external_work\n0,0,0,0\n1,0,1,2\n")
        self.assertIn("lost 50 % of the 2 J/m that came in, by loads that act at once", self.one("energy")[1])

    def test_structure_that_dissipates(self) -> None:
        head = "time,net.kinetic_energy,net.elastic_energy,net.external_work,net.brake_work,x.mass,soil.momentum_z\n"
        self.write("probes.csv", head + "0,0,0,0,0,1,0\n1,1,3,100,95,1,0\n")
        self.assertEqual(self.one("energy"), ("good", "Energy of net: it lost 1 % of the 100 J that came in, by its "
                                                      "time integration; brakes took 95 %."))
        self.write("probes.csv", head + "0,0,0,0,0,1,0\n1,1,9,100,95,1,0\n")
        self.assertEqual(self.one("energy"), ("bad", "Energy of net: it has 5 % more than the 100 J that came in; "
                                                     "brakes took 95 %."))

    def test_damping_that_makes_energy(self) -> None:
        head = "time,wall.kinetic_energy,wall.external_work,wall.damping_work\n0,0,0,0\n"
        self.write("probes.csv", head + "1,1,1,-0.5\n2,1,1,0.2\n")
        self.assertIn(("bad", "Damping of wall created 0.5 J/m; it must only dissipate."), self.said()["energy"])
        self.write("probes.csv", head + "1,1,1,0.5\n")
        self.assertEqual(len(self.said()["energy"]), 1)

    def test_a_run_without_coupler(self) -> None:
        self.write("probes.csv", self.HEAD.replace("soil.", "") + "1,10,0,0,2,0\n")
        self.write("summary.json", json.dumps({"completed": True}))
        self.assertIn("Energy of soil: closed", self.one("energy")[1])


if __name__ == "__main__":
    unittest.main()
