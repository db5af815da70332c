# SPDX-License-Identifier: BSD-3-Clause
"""A study with a program that only looks like ours."""

import csv
import json
import os
import signal
import subprocess
from pathlib import Path
from unittest import mock

from script_case import ROOT, ScriptCase

from plotting.style import Figure, plt
from sampling.evaluation import Evaluation
from studies.runner import Runner

# Answers a + b t for settings a, b; fails where a is 9, and notes that it ran.
PROGRAM = """#!/usr/bin/python3 -S
import json, os, sys
words = sys.argv[1:]
out = words[words.index("--output") + 1]
settings = [words[k + 1].partition("=") for k, word in enumerate(words) if word == "--set"]
a, b = (float(next((value for path, _, value in settings if path.endswith(key)), 1)) for key in ("density", "modulus"))
open(os.environ["RAN"], "a").write(f"{a:g} {b:g}\\n")
os.makedirs(out, exist_ok=True)
with open(out + "/probes.csv", "w") as table:
    table.write("time,x\\n" + "".join(f"{t},{a + b * t}\\n" for t in (0, 0.5, 1)))
bad = a == 9
summary = {"completed": not bad, "steps": 2} | ({"reason": "step 1: no solution"} if bad else {})
json.dump(summary, open(out + "/summary.json", "w"))
if bad:
    print("[mpm] error: no solution")
sys.exit(3 if bad else 0)
"""
A, B = (f"mpm.json:/bodies/0/material/{key}" for key in ("density", "young_modulus"))


PICTURE = Evaluation.picture


class StudyCase(ScriptCase):
    def setUp(self) -> None:
        super().setUp()
        self.ran = self.folder / "ran"
        self.program = self.write("program", PROGRAM)
        self.program.chmod(0o755)
        self.write("scene/mpm.json", (ROOT / "configs" / "column_run_out" / "mpm.json").read_text())
        self.out = self.folder / "out"
        self.values = {
            "scene": "scene",
            "parameters": {"a": {"set": A, "list": [1, 2, 3]},
                           "b": {"set": B, "range": {"from": 10, "to": 20, "count": 2}}},
            "design": {"method": "factorial"},
            "answers": {"end": {"column": "x", "take": "last"}},
        }

        def command(runner: Runner, output: Path, scene: str, settings: list[str]) -> list[str]:
            words = [word for each in settings for word in ("--set", each)]
            return [str(self.program), scene, "--output", str(output), *words]

        self.drawn: list[str] = []

        def picture(evaluation: Evaluation, figure: Figure, name: str) -> None:
            self.drawn.append(name)
            plt.close(figure)

        for patch in (mock.patch.object(Runner, "_command", command), mock.patch.object(Evaluation, "picture", picture),
                      mock.patch.dict(os.environ, {"RAN": str(self.ran)})):
            patch.start()
            self.addCleanup(patch.stop)
        for number in (signal.SIGTERM, signal.SIGINT, signal.SIGHUP):
            self.addCleanup(signal.signal, number, signal.getsignal(number))

    def plan(self) -> Path:
        return self.write("plan.json", json.dumps(self.values))

    def study(self, *options: object, code: int = 0, out: Path | None = None) -> subprocess.CompletedProcess:
        done = self.python_script("study", self.plan(), "--output", out or self.out, *options)
        self.assertEqual(done.returncode, code, done.stdout + done.stderr)
        return done

    def rows(self, name: str = "runs", out: Path | None = None) -> list[dict[str, str]]:
        with ((out or self.out) / f"{name}.csv").open(newline="") as file:
            return list(csv.DictReader(file))

    def num_ran(self) -> int:
        return len(self.ran.read_text().splitlines()) if self.ran.exists() else 0
