#!/usr/bin/python3
# SPDX-License-Identifier: BSD-3-Clause
"""scripts/verify with programs that only pretend: rows, failures, crashes, ids, files."""

import csv
import json
import sys
import unittest
from pathlib import Path
from unittest import mock

from script_case import ScriptCase

import measured

HEAD = "test,id,what,exact,computed,unit,measure,value,bound,holds,limitation,seconds"
PERIOD = 'V7_Bar.period,V7,"period, 2D",10,10.005,"s",relative_error,5e-4,1e-3,true,"",1.25'
ORDER = 'V4_Vortex.order,V4,"order in h, linear",2,0.31,"",order,0.31,0.2,true,"stalls",0.5'
TOO_LARGE = 'V7_Bar.energy,V7,"energy",1,0.5,"J",relative_error,0.5,1e-3,false,"",2'
CURVE = ('V4,"error over h","h [m]","error",linear,true,0.1,0.01\n'
         'V4,"error over h","h [m]","error",linear,true,0.05,0.003\n')

# Behaves like a GoogleTest program: lists its suites, writes a report and what it was told to.
PROGRAM = """#!/usr/bin/python3
import json, os, sys
suites, rows, curves, failure, code = json.loads({content!r})
options = dict(part.partition("=")[::2] for part in sys.argv[1:])
if "--gtest_list_tests" in options:
    print("\\n".join(line for name in suites for line in (name.split(".")[0] + ".", "  case")))
    sys.exit(0)
chosen = options.get("--gtest_filter", "").split(":")
keep = lambda name: chosen == [""] or any(name.startswith(c.rstrip("*")) for c in chosen)
rows = [row for row in rows if keep(row)]
if rows:
    open(os.environ["GABION_VERIFICATION_TABLE"], "a").write({head!r} + "\\n" + "\\n".join(rows) + "\\n")
if curves:
    open(os.environ["GABION_VERIFICATION_CURVES"], "a").write(
        "id,figure,x_label,y_label,label,logarithmic,x,y\\n" + curves)
if code < 0:
    os.abort()
cases = []
for name in suites:
    suite, case = name.split(".")
    if keep(name):
        failed = {{"failures": [{{"failure": "bar.cpp:12\\nno"}}]}} if failure == name else {{}}
        cases.append({{"name": suite, "testsuite": [{{"name": case, "result": "COMPLETED", **failed}}]}})
json.dump({{"testsuites": cases}}, open(options["--gtest_output"].removeprefix("json:"), "w"))
sys.exit(code)
"""


class Verify(ScriptCase):
    def program(self, name: str, suites: list[str], rows: list[str], curves: str = "", failure: str = "",
                code: int = 0) -> Path:
        content = json.dumps([suites, rows, curves, failure, code])
        path = self.write(name, PROGRAM.format(content=content, head=HEAD))
        path.chmod(0o755)
        return path

    def verify(self, *programs: Path, options: tuple = ()):
        listing = self.write("programs.txt", "\n".join(["env", *map(str, programs)]) + "\n")
        return self.python_script("verify", "--programs", listing, "--output", self.folder / "out", *options)

    def good_programs(self) -> list[Path]:
        return [self.program("bar", ["V7_Bar.period"], [PERIOD]),
                self.program("vortex", ["V4_Vortex.order"], [ORDER], CURVE)]

    def test_table_figures_and_order_of_ids(self) -> None:
        result = self.verify(*self.good_programs())
        self.assertEqual(result.returncode, 0, result.stderr)
        lines = result.stdout.splitlines()
        self.assertTrue(lines[1].startswith("V4 ") and lines[1].endswith("limit"), lines[1])
        for text in ("period, 2D", "10 s", "10.005 s", "relative 5.0e-04", "<= 0.001", "1.25", "ok"):
            self.assertIn(text, lines[2])
        self.assertIn("limit, V4: stalls", result.stdout)
        self.assertIn("2 rows, 0 failed", result.stdout)
        with (self.folder / "out" / "table.csv").open(newline="") as file:
            rows = list(csv.DictReader(file))
        self.assertEqual([(row["id"], row["verdict"]) for row in rows], [("V4", "limit"), ("V7", "ok")])
        self.assertEqual(float(rows[1]["computed"]), 10.005)
        self.assertIn("| V7 | period, 2D | 10 s |", (self.folder / "out" / "table.md").read_text())
        self.assertTrue((self.folder / "out" / "V4_error_over_h.png").exists())

    def test_page_of_the_table(self) -> None:
        with mock.patch.object(measured, "FOLDER", self.folder / "pages"):
            result = self.verify(*self.good_programs(), options=("--write",))
            self.assertEqual(result.returncode, 0, result.stderr)
            with self.assertRaises(SystemExit):
                self.verify(*self.good_programs(), options=("--write", "V7"))
        lines = (self.folder / "pages" / "verification.md").read_text().splitlines()
        self.assertRegex(lines[2], r"^`scripts/verify`: version .+ cores of ")
        self.assertIn("| V7 | period, 2D | 10 s | 10.005 s | relative 5.0e-04 | <= 0.001 | 1.25 | ok |", lines)
        self.assertIn("- V4: stalls", lines)
        self.assertEqual(lines[-1], "![V4 error over h](V4_error_over_h.png)")
        self.assertTrue((self.folder / "pages" / "V4_error_over_h.png").exists())

    def test_row_beyond_its_bound_fails(self) -> None:
        program = self.program("bar", ["V7_Bar.period", "V7_Bar.energy"], [PERIOD, TOO_LARGE],
                               failure="V7_Bar.energy", code=1)
        result = self.verify(program)
        self.assertEqual(result.returncode, 1)
        self.assertIn("2 rows, 1 failed", result.stdout)
        self.assertRegex(result.stdout, r"V7 +energy .*FAILED")

    def test_other_failure_of_a_case_is_a_row(self) -> None:
        result = self.verify(self.program("bar", ["V7_Bar.period"], [PERIOD], failure="V7_Bar.period", code=1))
        self.assertEqual(result.returncode, 1)
        self.assertIn("period: bar.cpp:12 no", result.stdout)

    def test_case_without_row_fails(self) -> None:
        result = self.verify(self.program("bar", ["V7_Bar.long_period"], []))
        self.assertEqual(result.returncode, 1)
        self.assertRegex(result.stdout, r"V7 +long period: recorded no row .*FAILED")

    def test_crash_keeps_the_rows_before_it(self) -> None:
        result = self.verify(self.program("bar", ["V7_Bar.period"], [PERIOD], code=-6))
        self.assertEqual(result.returncode, 1)
        self.assertIn("10.005 s", result.stdout)
        self.assertRegex(result.stdout, r"bar +ended with exit code -6")

    def test_ids(self) -> None:
        programs = self.good_programs()
        result = self.verify(*programs, options=("V7",))
        self.assertEqual(result.returncode, 0, result.stderr)
        self.assertIn("1 rows, 0 failed", result.stdout)
        self.assertNotIn("V4", result.stdout)

    def test_unknown_id(self) -> None:
        result = self.verify(*self.good_programs(), options=("V7", "V70"))
        self.assertEqual(result.returncode, 2)
        self.assertIn("no problem V70; there are V4, V7", result.stderr)

    def test_missing_list_of_programs(self) -> None:
        result = self.python_script("verify", "--programs", self.folder / "none.txt")
        self.assertEqual(result.returncode, 2)
        self.assertIn("none.txt: not there", result.stderr)

    def test_other_columns_are_refused(self) -> None:
        from verification.table import VerificationError, read_rows
        path = self.write("rows.csv", "id,what\nV7,period\n")
        with self.assertRaisesRegex(VerificationError, "found the columns"):
            read_rows(path)


if __name__ == "__main__":
    unittest.main()
