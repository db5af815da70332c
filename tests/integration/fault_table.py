# SPDX-License-Identifier: BSD-3-Clause
"""The fault matrix: what goes wrong, where, and how the run must end. test_faults.py plays it."""

from dataclasses import dataclass

PHASES = ("handshake", "before_solve", "inside_solve", "after_solve", "output")
PARTICIPANTS = ("soil", "structure")
SILENCE, CONNECT, ANSWER, HEARTBEAT = 1.2, 4.0, 3.0, 0.2  # [s] deadlines of the scene
PATIENT = 30.0  # [s] deadline of what does not go wrong
SLOW = 1.8  # [s] longer than the silence deadline, shorter than that for an answer
NEVER = 8.0  # [s]

# Accepted steps when it happens: the rows that steps.csv must have.
STEPS = {"handshake": 0, "before_solve": 2, "inside_solve": 2, "after_solve": 2, "output": 4}


@dataclass(frozen=True)
class Cell:
    """One thing that goes wrong, in one phase, on one side."""

    kind: str
    who: str
    phase: str
    says: tuple[str, ...]  # words of one line of the coupler; of each participant when the coupler is the culprit
    code: int = 4  # exit code of the coupler
    steps: int | None = None  # rows of steps.csv; None: no table

    @property
    def connect(self) -> float:
        """Deadline to connect [s]."""
        return CONNECT if self.phase == "handshake" and self.code != 0 else PATIENT

    @property
    def silence(self) -> float:
        """Deadline of silence [s]: a pause that must be survived may end late on a busy machine."""
        return PATIENT if self.kind == "paused" else SILENCE


def when(phase: str) -> str:
    """Words of the coupler on the phase of a participant that it has lost."""
    return {"inside_solve": 'in phase "solve_step 3 iteration 0"', "output": 'in phase "write_output"'}.get(
        phase, "last sign of life")


def rows(phase: str) -> int:
    """Rows of steps.csv when a participant fails in this phase: before step 3 the other one still accepts step 2."""
    return STEPS[phase] - (phase == "before_solve")


def lost_in_handshake(who: str) -> tuple[str, ...]:
    return f'participants ["{who}"] did not connect', f"limit {CONNECT:g} s"


def process_faults() -> list[Cell]:
    cells = []
    for who in PARTICIPANTS:
        peer = f'participant "{who}"'
        cells += [Cell("killed", who, "handshake", lost_in_handshake(who)),
                  Cell("stopped", who, "handshake", lost_in_handshake(who)),
                  Cell("slow", who, "handshake", (), code=0, steps=5)]
        for phase in PHASES[1:]:
            cells += [
                Cell("killed", who, phase, (peer, "has died", "last sign of life", when(phase)),
                     steps=rows(phase)),
                Cell("stopped", who, phase, (peer, "is silent for", f"limit {SILENCE:g} s", "its process is stopped",
                                             when(phase)), steps=STEPS[phase]),
                Cell("slow", who, phase, (), code=0, steps=5),
            ]
        for phase in ("before_solve", "inside_solve", "after_solve", "output"):
            # In the other phases the participant accepts or writes, and may complete its files.
            cells.append(Cell("never_answers", who, phase, (peer, "is alive but has not answered for",
                                                            f"limit {ANSWER:g} s", "in phase"), steps=rows(phase)))
    for phase in PHASES:
        cells += [Cell("killed", "coupler", phase, ("the coupler (pid", "has died", "last sign of life")),
                  Cell("stopped", "coupler", phase, ("the coupler (pid", "is silent for", f"limit {SILENCE:g} s",
                                                     "its process is stopped")),
                  Cell("paused", "coupler", phase, (), code=0, steps=5)]
    return cells


def handshake_faults() -> list[Cell]:
    refused = {
        "wrong_version": ("was refused", "protocol version: coupler 1.4, participant 2.0"),
        "refused_scene": ("was refused", "scene hash: coupler", "participant 0123"),
        "started_twice": ("was refused", "is connected already"),
        "wrong_sizes": ('participant "WHO" was refused', 'a facet names vertex 3, there are 3'),
        "nan": ('participant "WHO" was refused', '"coordinates:wall" is nan at vertex 0, component 0',),
        "lost_frame": (),
        "garbage": (),
        "truncated": (),
    }
    cells = []
    for kind, words in refused.items():
        for who in PARTICIPANTS:
            says = tuple(word.replace("WHO", who) for word in words) or lost_in_handshake(who)
            cells.append(Cell(kind, who, "handshake", says))
    return cells


def wire_faults() -> list[Cell]:
    cells = []
    for who in PARTICIPANTS:
        peer = f'participant "{who}"'
        sent = "force" if who == "soil" else "displacement"
        other = (peer, "sent a message that is not understood", "last sign of life")
        number = (peer, "expected an answer to", "last sign of life")
        unasked = (peer, "without being asked", "last sign of life")
        lies = {
            ("garbage", "before_solve"): other, ("garbage", "inside_solve"): other,
            ("garbage", "after_solve"): other, ("garbage", "output"): other,
            ("truncated", "before_solve"): other, ("truncated", "inside_solve"): other,
            ("truncated", "after_solve"): other, ("truncated", "output"): other,
            ("lost_frame", "inside_solve"): other,
            ("wrong_sequence", "before_solve"): unasked, ("wrong_sequence", "inside_solve"): number,
            ("wrong_sequence", "after_solve"): unasked, ("wrong_sequence", "output"): number,
            ("wrong_type", "inside_solve"): (peer, 'answered "solve_step" with "accepted"'),
            ("wrong_type", "output"): (peer, 'answered "write_output" with "solved"'),
            ("wrong_sizes", "inside_solve"): (peer, "answered wrongly", f'"{sent}:wall"',
                                              "expected shape [4, 2], found [3, 2]"),
            ("wrong_sizes", "after_solve"): (peer, "answered wrongly", '"probes"', "expected shape [1], found [0]"),
            ("nan", "inside_solve"): (peer, "answered wrongly", f'"{sent}:wall" is nan at vertex 0, component 0'),
        }
        cells += [Cell(kind, who, phase, says, steps=rows(phase))
                  for (kind, phase), says in lies.items()]
        cells.append(Cell("started_twice", who, "inside_solve", (), code=0, steps=5))
    return cells


def port_faults() -> list[Cell]:
    """Another program listens on the port, and never speaks."""
    here = Cell("port_taken", "coupler", "handshake", ("cannot listen on", "Address already in use"), code=2)
    return [here] + [Cell("port_taken", who, "handshake", ("no answer from a coupler", f"within {CONNECT:g} s"))
                     for who in PARTICIPANTS]


def cells() -> list[Cell]:
    return process_faults() + handshake_faults() + wire_faults() + port_faults()
