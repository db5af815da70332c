#!/usr/bin/python3
# SPDX-License-Identifier: BSD-3-Clause
"""Plans of scripts/study: what is wrong is said with its place in the file."""

import json
import re
import unittest

from study_case import ROOT, A, B, StudyCase

from sampling.plan import read_plan
from sampling.reader import PlanError
from sampling.study import Study


class Plans(StudyCase):
    def expect(self, *words: str, **changes: object) -> None:
        values = self.values | changes
        path = self.write("plan.json", json.dumps({key: value for key, value in values.items() if value is not ...}))
        with self.subTest(words=words), self.assertRaises(PlanError) as raised:
            Study(read_plan(path), self.out, None)
        for word in words:
            self.assertIn(word, str(raised.exception))

    def parameter(self, **values: object) -> dict:
        return {"a": {"set": A, **values}}

    def test_what_is_wrong_is_said_with_its_place(self) -> None:
        self.expect("plan.json:/scene: found nothing", scene=...)
        self.expect("plan.json:/scene: ", "nowhere: no such scene folder", scene="nowhere")
        self.expect("plan.json:/sceen: unknown, allowed: scene", "did you mean scene?", sceen="x")
        self.expect("plan.json:/parameters: found {}, allowed: an object with at least one", parameters={})
        self.expect("plan.json:/answers: found nothing", answers=...)
        self.expect("plan.json:/settings: ", 'found "dx" at mpm.json:/time', settings={"mpm.json:/time/dx": 1})
        self.expect("plan.json:/parameters/a: ", 'did you mean "density"?',
                    parameters={"a": {"set": "mpm.json:/bodies/0/material/densty", "list": [1]}})
        self.expect("plan.json:/parameters/a: ", "found -1, allowed: > 0", parameters=self.parameter(list=[-1]))
        self.expect("plan.json:/answers/end/take: found 'max', allowed: one of largest",
                    answers={"end": {"column": "x", "take": "max"}})
        self.expect("plan.json:/answers: found the name of a parameter", answers={"a": {"column": "x", "take": "last"}})
        self.expect("plan.json:/answers: found the name run, allowed: none of run, point",
                    answers={"run": {"column": "x", "take": "last"}})
        self.expect("plan.json:/answers/end/summary", answers={"end": {"summary": "steps"}})
        self.expect("plan.json:/bands/x/table: found 'walls.csv', allowed: one of probes.csv",
                    bands={"x": {"table": "walls.csv", "column": "x"}})
        self.expect("plan.json:/fragility/f/demand: found 'a', allowed: one of end",
                    fragility={"f": {"demand": "a", "capacity": 1, "intensity": "a"}})
        self.expect("plan.json:/fragility/f/capacity: found True, allowed: a number",
                    fragility={"f": {"demand": "end", "capacity": True, "intensity": "a"}})
        self.expect("plan.json:/ranks/mpm: found 0, allowed: a whole number >= 1", ranks={"mpm": 0})
        self.expect("plan.json:/ranks/soil: unknown, allowed: mpm, fem", ranks={"soil": 2})
        self.expect("plan.json:/repeats/set: ", "allowed: a number that is not 0",
                    repeats={"count": 2, "set": "mpm.json:/bodies/0/material/law", "change": 1e-6})

    def test_distributions(self) -> None:
        random = {"method": "random", "runs": 4, "seed": 1}
        for words, values in (
                (("/a: found none of list, range",), {}),
                (("/a: found list and uniform of",), {"list": [1], "uniform": [1, 2]}),
                (("/a/list: found [1, 1], allowed: a list of different values",), {"list": [1, 1]}),
                (("/a/set: unknown, allowed: variants",), {"variants": {"one": {A: 1}}}),
                (("/a/list: found []",), {"list": []}),
                (("/a/uniform: found [2, 1], allowed: [low, high]",), {"uniform": [2, 1]}),
                (("/a/log_uniform: found [0, 1]", "0 < low"), {"log_uniform": [0, 1]}),
                (("/a/normal/deviation: found 0, allowed: a number > 0",), {"normal": {"mean": 1, "deviation": 0}}),
                (("/a/lognormal/variation: found beside median",),
                 {"lognormal": {"median": 1, "log_deviation": 1, "variation": 1}}),
                (("/a/lognormal: found none of median, mean",), {"lognormal": {}}),
                (("/a/range/to: found 1",), {"range": {"from": 1, "to": 1, "count": 2}}),
                (("/a/range/count: found 1",), {"range": {"from": 1, "to": 2, "count": 1}}),
                (("/a/range/from: found -1",), {"range": {"from": -1, "to": 2, "count": 3, "spacing": "log"}})):
            self.expect(*words, parameters=self.parameter(**values), design=random)

    def test_variants(self) -> None:
        for words, variants in ((("/k: ", 'did you mean "density"?'), {"x": {"mpm.json:/bodies/0/material/densty": 1}}),
                                (("/k/variants/x: found 3, allowed: an object",), {"x": 3}),
                                (("/k/variants: found {}",), {}),
                                (("/k/variants: found the name 'a b'",), {"a b": {A: 1}})):
            self.expect(*words, parameters={"k": {"variants": variants}})

    def test_parameters_that_overwrite_each_other(self) -> None:
        one, whole = {"set": A, "list": [1, 2]}, A.rpartition("/")[0]
        design = {"method": "factorial"}
        self.expect("/b: found", A, "overwrites what a sets", parameters={"a": one, "b": {**one}}, design=design)
        self.expect("/b: found", f"{whole}, which overwrites what a sets", design=design,
                    parameters={"a": one, "b": {"set": whole, "list": [{}, {"x": 1}]}})
        self.expect("/b: found", "overwrites what a sets", design=design,
                    parameters={"a": one, "b": {"variants": {"x": {B: 1}, "y": {A: 1}}}})
        self.expect("/b: found", "overwrites what a sets", design=design,
                    parameters={"a": {"variants": {"x": {A: 1}}}, "b": one})
        self.expect("/a: found", f'{A}, which "settings" of the plan sets too', parameters={"a": one}, design=design,
                    settings={A: 2})

    def test_designs(self) -> None:
        sample = self.parameter(uniform=[1, 2])
        both = sample | {"b": {"set": B, "uniform": [1, 2]}}
        for words, design in ((("/design/method: found 'grid', allowed: one of factorial",), {"method": "grid"}),
                              (("/design/runs: found 60", "such as 32 or 64"),
                               {"method": "sobol", "runs": 60, "seed": 1}),
                              (("/design/seed: found nothing",), {"method": "random", "runs": 4}),
                              (("/a: found a distribution",), {"method": "factorial"}),
                              (("/design/cross: found a",),
                               {"method": "random", "runs": 4, "seed": 1, "cross": ["a"]})):
            self.expect(*words, parameters=sample, design=design)
        self.expect("/design/runs: unknown", design={"method": "factorial", "runs": 3})
        random = {"method": "random", "runs": 4, "seed": 1}
        for words, rows in ((("/correlations/0: found ['a', 'a', 0.5]",), [["a", "a", 0.5]]),
                            (("/correlations/0: found ['a', 'b', 1]",), [["a", "b", 1]]),
                            (("/correlations/1: found b and a again",), [["a", "b", 0.5], ["b", "a", 0.5]])):
            self.expect(*words, parameters=both, design=random, correlations=rows)
        three = both | {"c": {"set": "mpm.json:/time/dt", "uniform": [1, 2]}}
        self.expect("contradict each other", parameters=three, design=random,
                    correlations=[["a", "b", 0.9], ["b", "c", 0.9], ["a", "c", -0.9]])

    def test_the_plan_of_the_page(self) -> None:
        page = (ROOT / "docs" / "studies.md").read_text()
        text = re.search(r"^```json\n(.*?)^```$", page, re.MULTILINE | re.DOTALL)[1]
        (self.folder / "configs").symlink_to(ROOT / "configs")
        study = Study(read_plan(self.write("plans/plan.json", text)), self.out, None)
        self.assertEqual(len(study.outcomes), json.loads(text)["design"]["runs"])

    def test_files_that_are_no_plan(self) -> None:
        for text, words in (("{", "not JSON"), ("[]", "an object"),
                            ('{"scene": "a", "scene": "b"}', "found the key 'scene' twice")):
            with self.subTest(text), self.assertRaisesRegex(PlanError, words):
                read_plan(self.write("plan.json", text))
        with self.assertRaisesRegex(PlanError, "no such plan"):
            read_plan(self.folder / "nothing.json")


if __name__ == "__main__":
    unittest.main()
