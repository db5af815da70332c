#!/usr/bin/python3
# SPDX-License-Identifier: BSD-3-Clause
"""Launches by mpirun of Open MPI 4 and 5: the Python function, scripts/run and the job script say the same."""

import os
import subprocess
import unittest
from pathlib import Path
from unittest import mock

from script_case import ROOT, ScriptCase

from running.mpi import BY_RANK, LauncherError, find_launcher, launcher_of

VERSIONS = {4: "mpirun (Open MPI) 4.1.4\n\nReport bugs to http://www.open-mpi.org/community/help/\n",
            5: "mpirun (Open MPI) 5.0.7\n\nReport bugs to https://www.open-mpi.org/community/help/\n"}
OTHERS = ("", "HYDRA build details:\n    Version:      4.0.2\n", "Intel(R) MPI Library for Linux* OS, Version 2021.9\n",
          "mpirun (Open MPI) unknown\n")
# An mpirun of Open MPI that writes down what it is given.
MPIRUN = """#!/bin/bash
if [[ $1 == --version ]]; then printf '%s' '{version}'; exit; fi
printf '%s\\n' "$@" >{folder}/words
env >{folder}/environment
"""
SETUP = """
root={folder} build={folder} binaries={folder}/bin has_sources=1 python=/usr/bin/python3 PATH={folder}/bin:$PATH
say() {{ :; }}
die() {{ printf '%s\\n' "$*" >&2; exit 2; }}
install_packages() {{ :; }}
build_targets() {{ :; }}
"""
COUPLER = "#!/bin/bash\nprintf '%s\\0' 'tcp://127.0.0.1:*' soil mpm_solver 0 wall fem_solver 0\n"
NAMES = ("OMPI_MCA_btl_vader_single_copy_mechanism", "OMPI_MCA_orte_allowed_exit_without_sync", "OMPI_MCA_smsc",
         "PRTE_MCA_prte_allowed_exit_without_sync")


class Launches(ScriptCase):
    def setUp(self) -> None:
        super().setUp()
        path = f"{self.folder}/bin:{os.environ['PATH']}"
        clean = {name: value for name, value in os.environ.items() if name not in NAMES}
        patch = mock.patch.dict(os.environ, clean | {"PATH": path}, clear=True)
        patch.start()
        self.addCleanup(patch.stop)

    def made_up(self, version: str) -> None:
        self.write("bin/mpirun", MPIRUN.format(version=version, folder=self.folder)).chmod(0o755)

    def launched(self) -> tuple[list[str], dict[str, str]]:
        """Words of the launch, and what of its environment depends on the version."""
        lines = (self.folder / "environment").read_text().splitlines()
        environment = dict(line.split("=", 1) for line in lines if "=" in line)
        return ((self.folder / "words").read_text().splitlines(),
                {name: environment[name] for name in NAMES if name in environment})

    def test_words_of_each_version(self) -> None:
        programs = [(1, ["a", "x"]), (2, ["b"]), (1, ["c", "y"])]
        root = ["--allow-run-as-root"] if os.geteuid() == 0 else []
        common = ["--oversubscribe", "--bind-to", "none", *root]
        four, five = (launcher_of(VERSIONS[major]) for major in (4, 5))
        self.assertEqual(four.command(programs), ["mpirun", "-q", *common, "-n", "1", "a", "x", ":", "-n", "2", "b",
                                                  ":", "-n", "1", "c", "y"])
        self.assertEqual(five.command(programs), ["mpirun", *common, "-n", "4", str(BY_RANK), "-n", "1", "a", "x",
                                                  "::", "-n", "2", "b", "::", "-n", "1", "c", "y"])
        self.assertEqual(five.command(programs[1:2]), ["mpirun", *common, "-n", "2", "b"])
        self.assertFalse(set(four.environment) & set(five.environment))
        self.assertEqual({*four.environment, *five.environment}, {*NAMES})
        self.assertEqual(launcher_of("mpirun (Open MPI) 10.0.1").environment, five.environment)

    def test_others_are_refused(self) -> None:
        for version in OTHERS:
            with self.assertRaisesRegex(LauncherError, "allowed: that of Open MPI"):
                launcher_of(version)
        with mock.patch.dict(os.environ, {"PATH": str(self.folder)}), self.assertRaisesRegex(LauncherError, "mpirun"):
            find_launcher()

    def test_programs_say_that_there_is_none(self) -> None:
        program = ROOT / "structures" / "dolfinx" / "dolfinx_structure"
        with mock.patch.dict(os.environ, {"PATH": str(self.folder)}):
            done = subprocess.run(["/usr/bin/python3", program, "--coupler", "tcp://127.0.0.1:1", "--ranks", "2"],
                                  capture_output=True, text=True, check=False, timeout=600)
            studies = [self.python_script("bench", name, "--output", self.folder / name)
                       for name in ("ranks", "structure_ranks")]
        for name, each in (("dolfinx_structure", done), *(("scripts/bench", each) for each in studies)):
            self.assertEqual((each.returncode, each.stderr),
                             (2, f"{name}: mpirun: No such file or directory, allowed: that of Open MPI in PATH\n"))

    def test_the_one_in_the_path_is_asked(self) -> None:
        for major, version in VERSIONS.items():
            self.made_up(version)
            self.assertEqual(find_launcher().major, major)

    def test_scripts_run_says_the_same(self) -> None:
        self.write("scene/coupler.json", "{}")
        self.write("scripts/setup", SETUP.format(folder=self.folder))
        self.write("bin/coupler", COUPLER).chmod(0o755)
        script = self.write("scripts/run", (ROOT / "scripts" / "run").read_text(encoding="utf-8"))
        (self.folder / "scripts" / "running").symlink_to(ROOT / "scripts" / "running")
        for major, version in VERSIONS.items():
            self.made_up(version)
            subprocess.run(["bash", script, self.folder / "scene", "--no-plots", "--ranks", "mpm=2"],
                           capture_output=True, check=False, timeout=600)
            words, environment = self.launched()
            separator = ":" if major == 4 else "::"
            first = words.index("-n") if major == 4 else words.index("-n", words.index("-n") + 1)
            parts = " ".join(words[first:]).split(f" {separator} ")
            programs = [(int(part.split()[1]), part.split()[2:]) for part in parts]
            self.assertEqual([(ranks, Path(name[0]).name) for ranks, name in programs],
                             [(1, "coupler"), (2, "mpm_solver"), (1, "fem_solver")])
            wanted = ["mpirun", *words]
            found = find_launcher().command(programs)
            if major == 5:  # scripts/run names it by the folder in which it is
                wanted[wanted.index(str(self.folder / "scripts" / "running" / "by_rank"))] = str(BY_RANK)
            self.assertEqual(found, wanted)
            self.assertEqual(environment, find_launcher().environment)

    def job(self, **changes: str) -> subprocess.CompletedProcess:
        environment = os.environ | {"SCENE": "scene", "OUTPUT": str(self.folder / "out"), "BIN": "bin",
                                    "BY_RANK": str(BY_RANK), "MPM_RANKS": "3", "FEM_RANKS": "2"} | changes
        return subprocess.run(["bash", ROOT / "scripts" / "templates" / "slurm" / "gabion.sbatch"], env=environment,
                              capture_output=True, text=True, check=False, timeout=600)

    def test_the_job_script_starts_the_same(self) -> None:
        out = ["scene", "--output", str(self.folder / "out" / "part_1")]
        programs = [(1, ["bin/coupler", *out]), (3, ["bin/mpm_solver", *out]), (2, ["bin/fem_solver", *out])]
        for version in VERSIONS.values():
            self.made_up(version)
            launcher = find_launcher()
            self.job(LAUNCH=" ".join(launcher.words))
            words, environment = self.launched()
            self.assertEqual(["mpirun", *words], launcher.command(programs))
            self.assertLessEqual(environment.items(), launcher.environment.items())
            self.assertEqual(len(environment), 1)  # a node is no container
        refused = self.job(BY_RANK="nowhere")
        self.assertEqual(refused.returncode, 2)
        self.assertIn("BY_RANK: no program nowhere", refused.stderr)


if __name__ == "__main__":
    unittest.main()
