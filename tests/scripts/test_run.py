#!/usr/bin/python3
# SPDX-License-Identifier: BSD-3-Clause
"""scripts/run refuses what it cannot do before it installs, builds or starts anything.

What it starts it ends when a command fails.
"""

import json
import os
import re
import shutil
import signal
import subprocess
import time
import unittest
from pathlib import Path

from script_case import ROOT, ScriptCase


class Usage(ScriptCase):
    def expect_refusal(self, *arguments: object, words: str) -> None:
        result = self.script("run", *arguments)
        self.assertEqual(result.returncode, 2, result.stderr)
        self.assertIn(words, result.stderr)
        self.assertEqual(result.stdout, "")

    def scene(self, *files: str) -> str:
        for file in files:
            self.write(f"scene/{file}", "{}")
        return str(self.folder / "scene")

    def test_help(self) -> None:
        result = self.script("run", "--help")
        self.assertEqual(result.returncode, 0)
        self.assertIn("--ranks mpm=N,fem=N", result.stdout)

    def test_no_scene(self) -> None:
        self.expect_refusal(words="which scene?")

    def test_scene_that_is_not_there(self) -> None:
        self.expect_refusal(self.folder / "nowhere", words="no such scene folder; there are: configs/")

    def test_two_scenes(self) -> None:
        self.expect_refusal("a", "b", words="one scene at a time")

    def test_unknown_option(self) -> None:
        self.expect_refusal("a", "--outptu", words="unknown option --outptu")

    def test_option_without_value(self) -> None:
        for option in ("--output", "--restart"):
            self.expect_refusal("a", option, words=f"{option} needs a value")

    def test_results_in_the_scene(self) -> None:
        scene = self.scene("mpm.json")
        self.expect_refusal(scene, "--output", f"{scene}/", words="the folder of the scene itself")

    def test_ranks(self) -> None:
        scene = self.scene("mpm.json")
        for found in ("soil=2", "mpm=0", "2", "mpm=2,fem=x", "mpm=auto", "auto,mpm=2", "Auto"):
            self.expect_refusal(scene, "--ranks", found, words="allowed: auto, or mpm=N,fem=N")

    def test_empty_scene(self) -> None:
        self.expect_refusal(self.scene("notes.txt"), words="none of coupler.json, mpm.json, fem.json")

    def test_check_of_a_participant_without_coupler(self) -> None:
        self.expect_refusal(self.scene("mpm.json"), "--check-participant", "soil", words="has no coupler.json")

    def test_both_checks(self) -> None:
        self.expect_refusal(self.scene("coupler.json"), "--check", "--check-participant", "soil", words="one at a time")

    def test_two_solvers_without_coupler(self) -> None:
        self.expect_refusal(self.scene("mpm.json", "fem.json"), words="no coupler.json")


SETUP = """
root={folder} build={folder} binaries={folder}/bin has_sources=1 python=/usr/bin/python3 PATH={folder}/bin:$PATH
say() {{ printf '%s\\n' "$*" >&2; }}
die() {{ say "$*"; exit 2; }}
install_packages() {{ :; }}
build_targets() {{ :; }}
"""
COUPLER = """#!/bin/bash
if [[ $* == *--list-participants* ]]; then
  printf '%s\\0' 'tcp://127.0.0.1:*' plate '' 1 {command}
  exit
fi
trap 'echo the coupler was asked to end; exit 5' TERM
{first}
for ((i = 0; i < {tenths}; ++i)); do sleep 0.1; done
echo nobody came
exit 4
"""
MPIRUN = """#!/bin/bash
if [[ $1 == --version ]]; then echo 'mpirun (Open MPI) 4.1.4'; exit; fi
trap 'echo mpirun was hit; exit 139' TERM
{folder}/bin/coupler &
wait $!
code=$?
for ((i = 0; i < {tenths}; ++i)); do sleep 0.1; done
exit $code
"""


class MadeUpCase(ScriptCase):
    """scripts/run with programs that only look like ours."""

    def made_up(self, coupler: str, mpirun: str) -> list[object]:
        """The words that start scripts/run."""
        self.write("scene/coupler.json", json.dumps({}))
        self.write("scripts/setup", SETUP.format(folder=self.folder))
        self.write("bin/coupler", coupler).chmod(0o755)
        self.write("bin/mpirun", mpirun).chmod(0o755)
        shutil.copy(ROOT / "scripts" / "run", self.folder / "scripts" / "run")
        (self.folder / "scripts" / "running").unlink(missing_ok=True)
        (self.folder / "scripts" / "running").symlink_to(ROOT / "scripts" / "running")
        return [self.folder / "scripts" / "run", self.folder / "scene", "--no-plots"]


class FailedCommand(MadeUpCase):
    """Commands of participants that end at once, with a coupler and an mpirun that never were."""

    def run_with(self, command: str, coupler: int, mpirun: int, first: str = ":") -> tuple[int, list[str], float]:
        """The coupler waits for the command, mpirun takes its time to end after the coupler [s/10].

        first: what the coupler does before it waits

        returns: exit code, lines but those of what is started, seconds until the output ends
        """
        words = self.made_up(COUPLER.format(command=command, tenths=coupler, first=first),
                             MPIRUN.format(folder=self.folder, tenths=mpirun))
        start = time.monotonic()
        done = subprocess.run(words, text=True, stdout=subprocess.PIPE, stderr=subprocess.STDOUT,
                              timeout=300, check=False)
        return done.returncode, done.stdout.splitlines()[2:], time.monotonic() - start

    def test_is_named_at_once_and_once(self) -> None:
        code, lines, _ = self.run_with("false", coupler=15, mpirun=0)
        self.assertEqual(code, 4)
        self.assertEqual(lines[:2], ["plate ended with exit code 1", "nobody came"])
        self.assertEqual(lines[2:], ["The run failed with exit code 4."])

    def test_results_are_named_when_they_are_of_this_run(self) -> None:
        results = self.folder / "results" / "scene"
        marker = self.write("results/scene/.gabion_results", "coupler\n")
        os.utime(marker, (0, 0))
        _, lines, _ = self.run_with("false", coupler=2, mpirun=0)
        self.assertEqual(lines[-1], "The run failed with exit code 4.")
        _, lines, _ = self.run_with("false", coupler=2, mpirun=0, first=f"echo coupler >{marker}")
        self.assertEqual(lines[-1], f"The run failed with exit code 4. Results so far: {results}")

    def test_program_that_does_not_exist(self) -> None:
        code, lines, _ = self.run_with("no_such_program", coupler=15, mpirun=0)
        self.assertEqual(code, 4)
        self.assertIn("no_such_program", lines[0])
        self.assertEqual(lines[1:3], ["plate ended with exit code 127", "nobody came"])

    def test_coupler_that_goes_on_is_ended(self) -> None:
        code, lines, seconds = self.run_with("false", coupler=300, mpirun=0)
        self.assertEqual(code, 5)
        self.assertEqual(lines[:2], ["plate ended with exit code 1", "the coupler was asked to end"])
        self.assertGreater(seconds, 10)

    def test_command_that_is_stopped_is_ended(self) -> None:
        self.write("bin/stopper", "#!/bin/bash\nkill -STOP $$\n").chmod(0o755)
        code, lines, _ = self.run_with("stopper", coupler=5, mpirun=0)
        self.assertEqual(code, 4)
        self.assertIn("plate did not end by itself", lines)

    def test_mpirun_that_is_ending_is_left_alone(self) -> None:
        code, lines, _ = self.run_with("false", coupler=30, mpirun=85)
        self.assertEqual(code, 4, lines)
        self.assertNotIn("mpirun was hit", lines)


ADVISER = """#!/bin/bash
echo "$*" >>{folder}/asked
echo a warning >&2
printf '%b' '{answer}'
exit {code}
"""
SHOWS_RANKS = """#!/bin/bash
if [[ $1 == --version ]]; then echo 'mpirun (Open MPI) 4.1.4'; exit; fi
while (($#)); do [[ $1 != -n ]] || echo "$(basename "$3") on $2"; shift; done
exit 7
"""
TWO_PROGRAMS = """#!/bin/bash
[[ $* == *--list-participants* ]] || exit 1
printf '%s\\0' 'tcp://127.0.0.1:*' soil mpm_solver 0 structure fem_solver 0
"""


class AdvisedRanks(MadeUpCase):
    """scripts/run asks mpm_solver how many ranks pay."""

    def run_with(self, answer: str, *options: str, code: int = 0, coupled: bool = False) -> list[str]:
        """Lines that are said, without those of commands: each program with its ranks, and what led to them."""
        words = self.made_up(TWO_PROGRAMS, SHOWS_RANKS)
        for solver in ("mpm", "fem"):
            self.write(f"scene/{solver}.json", "{}")
        if not coupled:
            (self.folder / "scene" / "coupler.json").unlink()
            (self.folder / "scene" / "fem.json").unlink()
        text = ADVISER.format(folder=self.folder, answer=answer, code=code)
        self.write("bin/mpm_solver", text).chmod(0o755)
        (self.folder / "asked").unlink(missing_ok=True)
        done = subprocess.run([*words, *options], text=True, stdout=subprocess.PIPE, stderr=subprocess.STDOUT,
                              timeout=600, check=False)
        self.assertEqual(done.returncode, 7, done.stdout)
        return [line for line in done.stdout.splitlines() if not line.startswith(("OPENBLAS_", "The run failed"))]

    @property
    def asked(self) -> str:
        file = self.folder / "asked"
        return file.read_text(encoding="utf-8") if file.exists() else ""

    def test_those_that_pay_are_taken_and_named(self) -> None:
        said = ["mpm_solver: ranks: 3 (many points; --ranks mpm=N gives another number)", "mpm_solver on 3"]
        for options in ((), ("--ranks", "auto")):
            self.assertEqual(self.run_with(r"3\0many points\0", *options), said)

    def test_settings_of_the_command_line_reach_the_question(self) -> None:
        self.run_with(r"1\0few points\0", "--set", "mpm.json:/basis=gimp")
        self.assertIn("/scene --advise-ranks 0 --set mpm.json:/basis=gimp", self.asked)

    def test_one_rank_is_named_to_those_who_ask(self) -> None:
        self.assertEqual(self.run_with(r"1\0few points\0"), ["mpm_solver on 1"])
        self.assertEqual(self.run_with(r"1\0few points\0", "--ranks", "auto"),
                         ["mpm_solver: ranks: 1 (few points; --ranks mpm=N gives another number)", "mpm_solver on 1"])

    def test_number_that_is_given_holds(self) -> None:
        for words in (["--ranks", "mpm=2"], ["--ranks", "auto", "--ranks", "mpm=2"]):
            self.assertEqual(self.run_with(r"3\0many points\0", *words), ["mpm_solver on 2"])
            self.assertEqual(self.asked, "")

    def test_structure_keeps_one(self) -> None:
        names = self.run_with(r"3\0many points\0", coupled=True)[1:]
        self.assertEqual(names, ["coupler on 1", "mpm_solver on 3", "fem_solver on 1"])
        names = self.run_with(r"3\0many points\0", "--ranks", "fem=2", coupled=True)[1:]
        self.assertEqual(names, ["coupler on 1", "mpm_solver on 3", "fem_solver on 2"])

    def test_program_that_does_not_answer_runs_on_one(self) -> None:
        """mpm_solver reports its faults in the run, not when it is asked."""
        for answer, code in (("", 2), (r"3\0many points\0", 2), ("", 0), (r"many\0points\0", 0), (r"0\0\0", 0)):
            self.assertEqual(self.run_with(answer, code=code), ["mpm_solver on 1"], answer)
        self.assertEqual(self.run_with("", "--ranks", "auto", code=2),
                         ["mpm_solver: ranks: 1 (it gave no advice)", "mpm_solver on 1"])

    def test_what_is_asked_for_last_holds(self) -> None:
        said = self.run_with(r"3\0many points\0", "--ranks", "mpm=2", "--ranks", "auto")
        self.assertEqual(said[-1], "mpm_solver on 3")

    def test_check_of_a_participant_keeps_one(self) -> None:
        names = self.run_with(r"3\0many points\0", "--check-participant", "soil", coupled=True)
        self.assertEqual((names, self.asked), (["coupler on 1", "mpm_solver on 1"], ""))


FIVE = """#!/bin/bash
if [[ $1 == --version ]]; then echo 'mpirun (Open MPI) 5.0.7'; exit; fi
printf '%s\\n' "$@" >{folder}/words
env >{folder}/environment
"""


class OpenMpi5(MadeUpCase):
    """Other names and options than those of Open MPI 4, and no colons."""

    def words_of(self, *options: str) -> list[str]:
        """Arguments of mpirun."""
        command = self.made_up("#!/bin/bash\nprintf '%s\\0' 'tcp://127.0.0.1:*' soil mpm_solver 0 wall fem_solver 0\n",
                               FIVE.format(folder=self.folder))
        subprocess.run([*command, *options], capture_output=True, check=False, timeout=600)
        return (self.folder / "words").read_text().splitlines()

    def test_words_and_names(self) -> None:
        words = self.words_of("--ranks", "mpm=2")
        self.assertNotIn("-q", words)
        self.assertNotIn(":", words)
        launched = words[words.index("-n"):]
        self.assertEqual(launched[1], "4")  # ranks
        self.assertTrue(launched[2].endswith("scripts/running/by_rank"), launched)
        programs = " ".join(launched[3:]).split(" :: ")
        self.assertEqual([Path(part.split()[2]).name for part in programs], ["coupler", "mpm_solver", "fem_solver"])
        self.assertEqual([part.split()[1] for part in programs], ["1", "2", "1"])
        environment = (self.folder / "environment").read_text()
        self.assertIn("PRTE_MCA_prte_allowed_exit_without_sync=1\n", environment)
        self.assertIn("OMPI_MCA_smsc=^cma\n", environment)
        self.assertNotIn("vader", environment)

    def test_launcher_that_is_none(self) -> None:
        for said in ("HYDRA", "HYDRA build details: Version: 4.0.2", ""):
            command = self.made_up("#!/bin/bash\nprintf '%s\\0' 'tcp://127.0.0.1:*'\n",
                                   f"#!/bin/bash\necho '{said}'\n")
            done = subprocess.run(command, capture_output=True, text=True, check=False, timeout=600)
            self.assertEqual(done.returncode, 2, said)
            self.assertIn("mpirun is not Open MPI's", done.stderr)

    def test_each_rank_becomes_its_program(self) -> None:
        line = ["-n", "1", "echo", "a", "b c", "::", "-n", "2", "echo", "*"]
        for variable in ("OMPI_COMM_WORLD_RANK", "PMIX_RANK"):
            said = [self.by_rank(line, {variable: str(rank)}) for rank in range(4)]
            self.assertEqual(said[:3], [(0, "a b c\n"), (0, "*\n"), (0, "*\n")])
            self.assertEqual(said[3][0], 2)
            self.assertIn("rank 3 has no program", said[3][1])
        self.assertIn("no rank", self.by_rank(line, {})[1])
        for wrong in (["echo"], ["-n", "0", "echo"], ["-n", "1"], ["-n", "1", "::", "-n", "1", "echo"]):
            code, said = self.by_rank(wrong, {"OMPI_COMM_WORLD_RANK": "0"})
            self.assertEqual(code, 2, said)
            self.assertIn("allowed: -n NUMBER PROGRAM", said)

    def by_rank(self, words: list[str], environment: dict[str, str]) -> tuple[int, str]:
        """Exit code and output."""
        done = subprocess.run([str(ROOT / "scripts/running/by_rank"), *words], text=True,
                              env={"PATH": "/usr/bin:/bin"} | environment,
                              stdout=subprocess.PIPE, stderr=subprocess.STDOUT, check=False)
        return done.returncode, done.stdout


LONE_COUPLER = """#!/usr/bin/python3
import ctypes, signal, sys
if "--list-participants" in sys.argv:
    print("tcp://127.0.0.1:*", end="\\0")
    sys.exit()
ctypes.CDLL(None).prctl(15, b"coupler")  # as a compiled program is called
both = {signal.SIGINT, signal.SIGTERM}
signal.pthread_sigmask(signal.SIG_BLOCK, both)  # where both wait, the one of the lower number is taken: SIGINT
print("begun", flush=True)
print("the coupler got", int(signal.sigwait(both)), flush=True)
sys.exit(5)
"""
OTHER_SIGNAL = """#!/usr/bin/python3
import signal, subprocess, sys
if "--version" in sys.argv:
    print("mpirun (Open MPI) {version}")
    sys.exit()
coupler = subprocess.Popen(["{folder}/bin/coupler"])
signal.signal(signal.SIGTERM, lambda *_: coupler.poll() is None and coupler.send_signal(signal.SIGTERM))
sys.exit(coupler.wait())
"""
KILLS_AT_ONCE = OTHER_SIGNAL.replace("coupler.poll() is None and coupler.send_signal(signal.SIGTERM)",
                                     "(print('mpirun kills', flush=True), coupler.kill())")
STOPPED = """#!/bin/bash
if [[ $1 == --version ]]; then echo 'mpirun (Open MPI) {version}'; exit; fi
trap '' TERM
sleep 600 &
echo "child $!"
echo begun
kill -STOP $$
echo goes on
while :; do sleep 0.1; done
"""


class Stopped(MadeUpCase):
    """scripts/run gets a signal."""

    def stop(self, mpirun: str, number: signal.Signals, version: str = "4.1.4", pause: int = 0) -> tuple[int, str]:
        """Exit code and output, after the programs have started.

        pause: of scripts/run, after it has started mpirun [s]
        """
        words = self.made_up(LONE_COUPLER, mpirun.format(folder=self.folder, version=version))
        script = words[0].read_text()
        self.assertEqual(script.count("\nlaunched=$!\n"), 1)
        words[0].write_text(script.replace("\nlaunched=$!\n", f"\nlaunched=$!\nsleep {pause}\n"))
        with subprocess.Popen(words, text=True, stdout=subprocess.PIPE, stderr=subprocess.STDOUT) as run:
            said = ""
            while "begun" not in said:
                line = run.stdout.readline()
                self.assertTrue(line, said)
                said += line
            run.send_signal(number)
            said += run.stdout.read()
            return run.wait(), said

    def test_programs_get_the_signal_itself(self) -> None:
        """mpirun makes SIGTERM of each."""
        for number in (signal.SIGINT, signal.SIGTERM):
            code, said = self.stop(OTHER_SIGNAL, number)
            self.assertEqual(code, 128 + number, said)
            self.assertIn(f"the coupler got {number.value}\n", said)
            self.assertEqual(said.count("the coupler got"), 1)
            self.assertIn("Stopped.", said)

    def test_signal_while_the_programs_are_started(self) -> None:
        code, said = self.stop(OTHER_SIGNAL, signal.SIGTERM, pause=3)
        self.assertEqual(code, 143, said)
        self.assertIn("the coupler got 15\n", said)
        self.assertIn("Stopped.", said)

    def test_programs_have_their_time_when_mpirun_kills_at_once(self) -> None:
        """mpirun of Open MPI 5 gives them 0.25 s: it is asked after the programs have ended, and then has."""
        for number in (signal.SIGINT, signal.SIGTERM):
            code, said = self.stop(KILLS_AT_ONCE, number, "5.0.7")
            self.assertEqual(code, 128 + number, said)
            self.assertIn(f"the coupler got {number.value}\n", said)
            self.assertIn("Stopped.", said)
            self.assertNotIn("mpirun kills", said)

    def test_mpirun_that_does_not_end(self) -> None:
        """mpirun is stopped, and no SIGTERM ends it when it goes on: it is killed with all that it has started."""
        self.expect_kill("4.1.4")
        self.expect_kill("5.0.7")

    def expect_kill(self, version: str) -> None:
        code, said = self.stop(STOPPED, signal.SIGTERM, version)
        self.assertEqual(code, 143, said)
        self.assertIn("goes on", said)
        child = int(re.search(r"child (\d+)", said)[1])
        status = Path(f"/proc/{child}/status")
        self.assertTrue(not status.exists() or "State:\tZ" in status.read_text(), "it still runs")


if __name__ == "__main__":
    unittest.main()
