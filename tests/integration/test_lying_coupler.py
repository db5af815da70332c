#!/usr/bin/python3
# SPDX-License-Identifier: BSD-3-Clause
"""The real solvers under a coupler that lies: each lie ends the solver at once, with an error that names the lie, and
`abort` to the coupler."""

import signal
import subprocess
import sys
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

import numpy as np

sys.path[:0] = [str(Path(__file__).resolve().parent.parent / "participant")]
import launch  # noqa: E402
from fake_coupler import FakeCoupler  # noqa: E402
from gabion_participant.message import Message, encode  # noqa: E402
from launch import IntegrationCase, Launch, meeting  # noqa: E402

DT = 5e-4  # [s]
WORKERS = 6  # lies at once: they mostly wait


class Liar(IntegrationCase):
    """A coupler that lies once, to one solver."""

    def setUp(self) -> None:
        super().setUp()
        files = meeting()
        files["coupler"]["coupling"]["on_limit"] = "accept"
        self.write_scene(files)

    def begin(self, program: str) -> None:
        """A solver that was welcomed, and has accepted step 1."""
        self.coupler = FakeCoupler()
        self.addCleanup(self.coupler.close)
        self.solver = Launch([str(launch.binaries / program), str(self.scene), "--output", str(self.out), "--coupler",
                              self.coupler.endpoint], self.folder)
        self.addCleanup(self.solver.end)
        hello = self.coupler.welcome(run={"end": 1.0, "output": str(self.out), "checkpoints": True})
        self.quantity = hello.fields["receives"]["quantity"]
        self.shape = hello.arrays["coordinates:wall"].shape
        self.assertEqual(self.coupler.ask("solve_step", self.values(), **self.step(1)).type, "solved")
        self.assertEqual(self.accept(1).type, "accepted")

    def values(self, **changes: object) -> dict[str, np.ndarray]:
        """Values of an undeformed interface without load, with changes: shape, value, name."""
        how = {"shape": self.shape, "value": 0.0, "name": "wall"} | changes
        array = np.zeros(how["shape"])
        array[-1, -1] = how["value"]
        return {f"{self.quantity}:{how['name']}": array}

    def step(self, number: int, **changes: object) -> dict:
        return {"step": number, "iteration": 0, "time": DT * (number - 1), "dt": DT} | changes

    def accept(self, number: int, **changes: object) -> Message:
        fields = self.step(number) | {"solved": True, "write_output": False} | changes
        return self.coupler.ask("accept_step", **fields)

    def expect_end(self, words: str, lie) -> None:
        """The lie is told; the solver says so, tells the coupler, and ends."""
        lie()
        self.assertEqual(self.coupler.receive().type, "abort")
        ended = self.solver.wait()
        self.assertNotIn(ended.code, (0, -signal.SIGSEGV, -signal.SIGABRT), ended.text)
        self.assert_says(ended.text, "error: ", words)

    def lies(self) -> dict[str, object]:
        """Message of the solver -> lie that it was told."""
        quantity = self.quantity
        ask, values, step = self.coupler.request, self.values, self.step

        def frames(*frames: bytes):
            return lambda: self.coupler.send_frames(list(frames))

        def solve(arrays: dict, **changes: object):
            return lambda: ask("solve_step", arrays, **step(2, **changes))

        good = encode(Message("solve_step", 9, step(2), values()))
        two = {f"{quantity}:roof": np.zeros(self.shape)}
        after = "after step 1 was accepted, expected step 2"
        of_one_rank = {"ranks": 1, "facts": [{}], "reals": {}, "integers": {}}
        rows, columns = self.shape
        return {
            f'"{quantity}:wall": expected shape [{rows}, {columns}], found [{rows - 1}, {columns}]':
                solve(values(shape=(rows - 1, columns))),
            f"expected shape [{rows}, {columns}], found [{rows}, {columns + 1}]":
                solve(values(shape=(rows, columns + 1))),
            f'"{quantity}:wall" is nan at vertex {rows - 1}, component {columns - 1}': solve(values(value=np.nan)),
            f'"{quantity}:wall" is -inf at vertex': solve(values(value=-np.inf)),
            f'expected an array "{quantity}:wall" of shape [{rows}, {columns}], found none':
                solve(values(name="fence")),
            "expected 1 arrays, found 2": solve(values() | two),
            "expected a number > 0, found 0": solve(values(), dt=0.0),
            "expected a number > 0, found -1": solve(values(), dt=-1.0),
            'field "iteration": expected a count': solve(values(), iteration=-1),
            f"asks for step 3 {after}": lambda: ask("solve_step", values(), **step(3)),
            f"asks for step 1 {after}": lambda: ask("solve_step", values(), **step(1)),
            "asks for step 2 from 0.25 s, but the accepted state is that of 0.0005 s": solve(values(), time=0.25),
            "accepts step 2, which has no solution":
                lambda: ask("accept_step", **step(2), solved=True, write_output=False),
            'asked for "dance"': lambda: ask("dance"),
            "is not understood: header frame is not JSON": frames(b"\xff\x00garbage", b"more"),
            "expected a frame of": frames(good[0], good[1][:-3]),
            "found 0 frames": frames(good[0]),
            "with sequence number 1 after 2": lambda: self.coupler.send(Message("reject_step", 1)),
            "saved state: found no number of MPI ranks": lambda: ask("load", {"real:u": np.zeros(3)}, state={}),
            'saved state: "u" has 3 values, its ranks had 300000': lambda: ask(
                "load", {"real:u": np.zeros(3)}, state=of_one_rank | {"reals": {"u": [300000]}}),
            "is missing": lambda: ask("load", state=of_one_rank),
            'field "state": expected an object': lambda: ask("load", {}, state=[1]),
        }

    def tell(self, program: str, words: str) -> None:
        self.begin(program)
        self.expect_end(words, self.lies()[words])

    def accept_another(self, program: str) -> None:
        """Another step is accepted than the solver has solved."""
        self.begin(program)
        self.coupler.ask("solve_step", self.values(), **self.step(2))
        self.expect_end("accepts step 2 with dt 0.001 s, but the solution is that of step 2 with dt 0.0005 s",
                        lambda: self.coupler.request("accept_step", **self.step(2, dt=1e-3), solved=True,
                                                     write_output=False))

    def spoil_state(self, program: str) -> None:
        """The solver's own state, whole at first; then with one number that points nowhere."""
        self.begin(program)
        saved = self.coupler.ask("save")
        self.assertEqual(saved.type, "saved")
        probes = self.coupler.ask("load", saved.arrays, state=saved.fields["state"]).arrays["probes"]
        solved = self.coupler.ask("solve_step", self.values(), **self.step(2))
        self.assertEqual(solved.type, "solved")
        self.assertEqual(self.coupler.ask("reject_step").type, "rejected")
        self.assertEqual(probes.tobytes(), self.coupler.ask("load", saved.arrays, state=saved.fields["state"])
                         .arrays["probes"].tobytes())
        name, value, words = {
            "mpm_solver": ("integer:points.cell", 160, "saved state: points.cell: found 160, allowed: 0 to 159"),
            "fem_solver": ("integer:rescue", 77, 'saved state: "rescue" is no method of solution')}[program]
        saved.arrays[name][-1] = value
        self.expect_end(words, lambda: self.coupler.request("load", saved.arrays, state=saved.fields["state"]))

    def names(self, program: str) -> list[str]:
        self.begin(program)
        return list(self.lies())


class Lies(IntegrationCase):
    def tell_all(self, program: str) -> None:
        words = []
        asked = Liar()
        self.assertEqual(asked.problem_of(lambda: words.extend(asked.names(program))), "")
        with ThreadPoolExecutor(WORKERS) as pool:
            problems = list(pool.map(lambda lie: (liar := Liar()).problem_of(lambda: liar.tell(program, lie)), words))
        for lie, problem in zip(words, problems):
            with self.subTest(lie):
                self.assertEqual(problem, "")
        for lie in (Liar.accept_another, Liar.spoil_state):
            with self.subTest(lie.__name__):
                liar = Liar()
                self.assertEqual(liar.problem_of(lambda: lie(liar, program)), "")

    def test_soil(self) -> None:
        self.tell_all("mpm_solver")

    def test_structure(self) -> None:
        self.tell_all("fem_solver")


if __name__ == "__main__":
    launch.main()
