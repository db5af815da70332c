#!/usr/bin/python3
# SPDX-License-Identifier: BSD-3-Clause
"""Facets that leave an interface: said by a structure and taken by a soil, with a loop of its own and driven."""

import unittest

import numpy as np
from fake_coupler import SEGMENTS, SQUARE, ParticipantCase
from gabion_participant import AcceptReport, InterfaceMesh, Participant, Solver, StepReport, UsageError, serve
from gabion_participant.message import Message

LEFT = SEGMENTS[1:]  # after the first facet has left
NONE = np.zeros((0, 2), dtype=int)


class BreakingWall(Solver):
    """A structure whose first facet leaves in the second step, the other one in the third."""

    def __init__(self) -> None:
        self.count = 0

    def interfaces(self) -> list[InterfaceMesh]:
        return [InterfaceMesh("wall", SQUARE, SEGMENTS)]

    def facets(self) -> dict[str, np.ndarray]:
        return {"wall": (SEGMENTS, SEGMENTS, LEFT)[self.count] if self.count < 3 else []}

    def solve_step(self, _request, _received):
        return {"wall": np.zeros((3, 2))}, StepReport()

    def accept_step(self, _request, _solved):
        self.count += 1
        return AcceptReport()

    def save_state(self) -> bytes:
        return bytes([self.count])

    def load_state(self, state: bytes) -> None:
        self.count = state[0]


class Facets(ParticipantCase):
    def participant(self, receives: str = "force") -> Participant:
        participant = Participant(self.settings(receives=receives))
        participant.set_interface("wall", SQUARE, SEGMENTS)
        return participant

    def finish(self) -> None:
        self.coupler.ask("finish")
        self.assertEqual(self.end(), "")

    def step(self, number: int) -> Message:
        """The answer to the acceptance of a step."""
        self.coupler.solve(number, 1.0)
        return self.coupler.accept(number)

    def expect_facets(self, reply: Message, facets: np.ndarray | None) -> None:
        """Those of an answer "accepted"; None: it has none."""
        self.assertEqual(reply.type, "accepted")
        if facets is None:
            self.assertNotIn("facets:wall", reply.arrays)
        else:
            np.testing.assert_array_equal(reply.arrays["facets:wall"], facets)
            self.assertEqual(reply.arrays["facets:wall"].shape, (len(facets), 2))

    def expect_run_of_a_structure(self) -> None:
        """Facets are sent where they change, and all of them after a state is loaded."""
        hello = self.coupler.welcome()
        self.assertIs(hello.fields["interfaces"][0]["facets_may_change"], True)
        self.assertNotIn("takes_facets", hello.fields)
        np.testing.assert_array_equal(hello.arrays["facets:wall"], SEGMENTS)
        for number, facets in ((1, None), (2, LEFT), (3, NONE), (4, None)):
            self.expect_facets(self.step(number), facets)
            if number == 2:
                saved = self.coupler.ask("save")
        self.coupler.ask("load", saved.arrays, state=saved.fields["state"])
        self.coupler.begin_again_at(2)
        self.expect_facets(self.step(3), NONE)
        self.finish()

    def test_a_driven_structure(self) -> None:
        self.start(lambda: serve(BreakingWall(), self.settings()))
        self.expect_run_of_a_structure()

    def test_a_structure_with_a_loop_of_its_own(self) -> None:
        wall = BreakingWall()
        participant = self.participant()

        def load(state: bytes) -> None:
            wall.load_state(state)
            participant.write_facets("wall", wall.facets()["wall"])

        def run() -> None:
            participant.set_facets_may_change("wall")
            participant.set_state(wall.save_state, load)
            participant.initialize()
            while participant.is_coupling_ongoing():
                participant.requires_writing_checkpoint()
                participant.write_data("wall", np.zeros((3, 2)))
                participant.advance(participant.get_max_time_step_size())
                if not participant.requires_reading_checkpoint():
                    wall.accept_step(None, True)
                    participant.write_facets("wall", wall.facets()["wall"])

        self.start(run)
        self.expect_run_of_a_structure()

    def test_a_soil_takes_them_between_steps(self) -> None:
        participant, calls = self.participant("displacement"), []

        def run() -> None:
            participant.on_set_facets(lambda facets: calls.append(facets["wall"].tolist()))
            participant.initialize()
            while participant.is_coupling_ongoing():
                calls.append(participant.requires_writing_checkpoint())
                participant.write_data("wall", np.zeros((3, 2)))
                participant.advance(participant.get_max_time_step_size())
                participant.requires_reading_checkpoint()

        self.start(run)
        self.assertIs(self.coupler.welcome().fields["takes_facets"], True)
        self.coupler.ask("solve_step", {"displacement:wall": SQUARE}, step=1, iteration=0, time=0.0, dt=0.1)
        self.coupler.accept(1)
        for facets in (LEFT, NONE):
            self.assertEqual(self.coupler.ask("set_facets", {"facets:wall": facets}).type, "facets_set")
        self.coupler.ask("solve_step", {"displacement:wall": SQUARE}, step=2, iteration=0, time=0.1, dt=0.1)
        self.coupler.accept(2)
        self.finish()
        self.assertEqual(calls, [True, LEFT.tolist(), [], True])

    def test_a_driven_soil_takes_them(self) -> None:
        class Soil(BreakingWall):
            taken: list[dict[str, np.ndarray]] = []

            def set_facets(self, facets: dict[str, np.ndarray]) -> None:
                self.taken.append(facets)

        self.start(lambda: serve(Soil(), self.settings(receives="displacement")))
        self.assertIs(self.coupler.welcome().fields["takes_facets"], True)
        self.assertEqual(self.coupler.ask("set_facets", {"facets:wall": LEFT}).type, "facets_set")
        self.coupler.ask("solve_step", {"displacement:wall": SQUARE}, step=1, iteration=0, time=0.0, dt=0.1)
        self.expect_facets(self.coupler.accept(1), None)
        self.finish()
        np.testing.assert_array_equal(Soil.taken[0]["wall"], LEFT)

    def test_what_cannot_be_is_told_the_coupler(self) -> None:
        def soil(take):
            participant = self.participant("displacement")
            if take:
                participant.on_set_facets(take)
            return participant

        for take, facets, words in ((None, LEFT, 'asked for "set_facets", which this participant'),
                                    (print, LEFT + 2, "a facet names vertex 4, there are 3"),
                                    (print, LEFT - 2, "a facet names vertex -1")):
            with self.subTest(words):
                participant = soil(take)
                self.start(participant.initialize)
                self.assertIs(self.coupler.welcome().fields.get("takes_facets", False), take is not None)
                self.assertEqual(self.coupler.ask("set_facets", {"facets:wall": facets}).type, "abort")
                self.assertIn(words, self.end())
                participant.finalize()
                self.coupler.begin_again()

    def test_a_state_without_facets_is_refused(self) -> None:
        participant = self.participant()
        participant.set_facets_may_change("wall")
        participant.set_state(lambda: b"", lambda _: None)
        self.start(participant.initialize)
        self.coupler.welcome()
        saved = self.coupler.ask("save")
        self.assertEqual(self.coupler.ask("load", saved.arrays, state=saved.fields["state"]).type, "abort")
        self.assertIn('no facets were written for "wall"', self.end())
        participant.finalize()

    def test_wrong_facets_of_a_driven_structure_end_the_run(self) -> None:
        for facets, words in (({"wall": LEFT + 2}, "found vertices 3 to 4"), ({"wall": LEFT * 1.0}, "found float64"),
                              ({"wall": [[0, 1, 2]]}, "of shape .1, 3."), ({}, "found interfaces")):
            with self.subTest(words):
                wall = BreakingWall()
                self.start(lambda: serve(wall, self.settings()))
                self.coupler.welcome()
                self.coupler.solve(1, 1.0)
                wall.facets = lambda: facets
                self.assertEqual(self.coupler.accept(1).type, "abort")
                self.assertRegex(self.end(), words)
                self.coupler.begin_again()

    def test_wrong_calls_are_named(self) -> None:
        def bare(participant: Participant) -> None:
            participant.set_interface("points", SQUARE)
            participant.set_facets_may_change("points")

        def early(participant: Participant) -> None:
            participant.set_facets_may_change("wall")
            participant.write_facets("wall", LEFT)

        for receives, words, body in (
                ("force", 'found interface "roof", allowed: wall', lambda p: p.set_facets_may_change("roof")),
                ("force", 'found interface "points" without facets', bare),
                ("force", 'found interface "wall", allowed: those of set_facets_may_change',
                 lambda p: p.write_facets("wall", LEFT)),
                ("force", "allowed after an accepted step", early),
                ("force", "on_set_facets: found a participant that receives force", lambda p: p.on_set_facets(print)),
                ("displacement", "that sends force, allowed: one that sends displacement",
                 lambda p: p.set_facets_may_change("wall"))):
            with self.subTest(words), self.assertRaisesRegex(UsageError, words):
                body(self.participant(receives))


if __name__ == "__main__":
    unittest.main()
