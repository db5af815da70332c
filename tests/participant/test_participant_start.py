#!/usr/bin/python3
# SPDX-License-Identifier: BSD-3-Clause
"""Participant: where interfaces begin, said by a structure and taken by a soil."""

import unittest

import numpy as np
from fake_coupler import SEGMENTS, SQUARE, ParticipantCase
from gabion_participant import Participant, UsageError

START = np.array([[0.0, 0.5], [1.0 / 3, -0.25], [1e-300, 2.0]])  # [m]


class Start(ParticipantCase):
    def participant(self, receives: str = "force") -> Participant:
        participant = Participant(self.settings(receives=receives))
        participant.set_interface("wall", SQUARE, SEGMENTS)
        participant.set_probes({"top": 1.0})
        return participant

    def finish(self) -> None:
        self.coupler.ask("finish")
        self.assertEqual(self.end(), "")
        self.coupler.begin_again()

    def test_a_structure_says_where_it_begins(self) -> None:
        for last in (START, np.zeros((3, 2))):
            participant = self.participant()
            participant.set_start_displacement("wall", 2 * START)
            participant.set_start_displacement("wall", last)  # the last one holds
            self.start(participant.initialize)
            hello = self.coupler.welcome()
            self.assertIs(hello.fields["takes_start"], False)
            if last.any():
                np.testing.assert_array_equal(hello.arrays["displacement:wall"], START)
            else:
                self.assertNotIn("displacement:wall", hello.arrays)
            self.finish()

    def test_a_soil_takes_it_before_its_first_step(self) -> None:
        participant, calls = self.participant("displacement"), []

        def take(displacements: dict[str, np.ndarray]) -> None:
            calls.append(displacements["wall"].tolist())
            participant.set_probes({"top": 7.0})

        def run() -> None:
            participant.on_set_start(take)
            participant.set_output(lambda _: calls.append("write"))
            participant.initialize()
            while participant.is_coupling_ongoing():
                calls.append(participant.requires_writing_checkpoint())
                calls.append(participant.read_data("wall").tolist())
                participant.write_data("wall", np.zeros((3, 2)))
                participant.advance(participant.get_max_time_step_size())

        self.start(run)
        self.assertIs(self.coupler.welcome().fields["takes_start"], True)
        reply = self.coupler.ask("set_start", {"displacement:wall": START})
        self.assertEqual((reply.type, reply.arrays["probes"].tolist()), ("start_set", [7.0]))
        self.coupler.ask("write_output", time=0.0)
        self.coupler.ask("solve_step", {"displacement:wall": START}, step=1, iteration=0, time=0.0, dt=0.1)
        self.assertEqual(self.coupler.accept(1).arrays["probes"].tolist(), [7.0])
        self.finish()
        self.assertEqual(calls, [START.tolist(), "write", True, START.tolist()])  # total, from the reference

    def test_what_cannot_be_is_told_the_coupler(self) -> None:
        def fail(_: dict[str, np.ndarray]) -> None:
            raise ValueError("soil inside the wall")

        for take, words in ((fail, "soil inside the wall"), (None, 'asked for "set_start", which this participant')):
            participant = self.participant("displacement")
            if take:
                participant.on_set_start(take)
            self.start(participant.initialize)
            self.assertIs(self.coupler.welcome().fields["takes_start"], take is not None)
            self.assertEqual(self.coupler.ask("set_start", {"displacement:wall": START}).type, "abort")
            self.assertIn(words, self.end())
            participant.finalize()
            self.coupler.begin_again()

    def test_wrong_calls_are_named(self) -> None:
        for receives, words, body in (
                ("force", 'found interface "roof", allowed: wall', lambda p: p.set_start_displacement("roof", START)),
                ("force", "found shape .2, 2. for", lambda p: p.set_start_displacement("wall", START[:2])),
                ("force", "found NaN or infinity", lambda p: p.set_start_displacement("wall", START * np.inf)),
                ("force", "on_set_start: found a participant that receives force", lambda p: p.on_set_start(print)),
                ("displacement", "that sends force, allowed: one that sends displacement",
                 lambda p: p.set_start_displacement("wall", START))):
            with self.subTest(words), np.errstate(invalid="ignore"), self.assertRaisesRegex(UsageError, words):
                body(self.participant(receives))


if __name__ == "__main__":
    unittest.main()
