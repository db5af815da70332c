#!/usr/bin/python3
# SPDX-License-Identifier: BSD-3-Clause
"""Samples of scripts/study and what it computes from answers, against closed forms."""

import unittest

import numpy as np
from scipy import stats
from script_case import ScriptCase

import made_up_results as made_up
from plotting.results import Results, ResultsError
from sampling.answers import TAKES, Answer, curve_of
from sampling.design import Design, points_of
from sampling.parameters import KEYS, Parameter, read_parameter
from sampling.reader import PlanReader
from sampling.statistics import Fit, Level, band_of, fit_fragility, levels_of, sobol_indices, standard_error
from studies.measures import Curve


def parameter(name: str, **values: object) -> Parameter:
    return read_parameter(name, PlanReader({"set": "mpm.json:/time/end", **values}, "plan.json:", KEYS))


def sample(parameters: list[Parameter], design: Design, correlations: object = None) -> np.ndarray:
    matrix = np.eye(len(parameters)) if correlations is None else np.array(correlations)
    return np.array([list(point.values()) for point in points_of(parameters, design, matrix)])


class Samples(unittest.TestCase):
    def test_distributions_have_their_moments(self) -> None:
        shares = (np.arange(20000) + 0.5) / 20000
        of_log = np.sqrt((np.e**2 - 1) / 2 - (np.e - 1) ** 2)
        for values, mean, deviation in (({"uniform": [1, 3]}, 2, 1 / np.sqrt(3)),
                                        ({"normal": {"mean": 5, "deviation": 2}}, 5, 2),
                                        ({"lognormal": {"mean": 3, "variation": 0.2}}, 3, 0.6),
                                        ({"log_uniform": [1, np.e]}, np.e - 1, of_log)):
            drawn = parameter("a", **values).at(shares)
            np.testing.assert_allclose([np.mean(drawn), np.std(drawn)], [mean, deviation], rtol=2e-3)
        self.assertAlmostEqual(parameter("a", lognormal={"median": 3, "log_deviation": 0.2}).at(
            np.array([stats.norm.cdf(1)]))[0], 3 * np.exp(0.2))

    def test_ranges_keep_whole_numbers_whole(self) -> None:
        self.assertEqual(parameter("a", range={"from": 2, "to": 6, "count": 3}).levels, (2, 4, 6))
        self.assertIsInstance(parameter("a", range={"from": 2, "to": 6, "count": 3}).levels[1], int)
        self.assertEqual(parameter("a", range={"from": 0, "to": 1, "count": 3}).levels, (0, 0.5, 1))
        logarithmic = parameter("a", range={"from": 1, "to": 100, "count": 3, "spacing": "log"})
        np.testing.assert_allclose(logarithmic.levels, [1, 10, 100])

    def test_a_latin_hypercube_has_a_point_in_each_part(self) -> None:
        both = [parameter(name, uniform=[0, 8]) for name in "ab"]
        points = sample(both, Design("latin_hypercube", "", 8, 5))
        for column in points.T:
            self.assertEqual(sorted(np.floor(column)), list(range(8)))

    def test_samples_are_the_same_each_time_and_others_with_another_seed(self) -> None:
        one = [parameter("a", uniform=[0, 1])]
        for method in ("random", "latin_hypercube", "sobol", "sobol_indices"):
            first, again, other = (sample(one, Design(method, "", 8, seed)) for seed in (1, 1, 2))
            np.testing.assert_array_equal(first, again)
            self.assertFalse(np.any(first == other), method)

    def test_a_larger_sobol_sample_begins_with_the_smaller_one(self) -> None:
        """A study that is extended keeps its runs for that reason."""
        one = [parameter("a", uniform=[0, 1])]
        small, large = (sample(one, Design("sobol", "", count, 1)) for count in (8, 16))
        np.testing.assert_array_equal(large[:8], small)

    def test_correlated_parameters_keep_their_distributions(self) -> None:
        two = [parameter("a", normal={"mean": 5, "deviation": 2}),
               parameter("b", lognormal={"median": 1, "log_deviation": 0.5})]
        a, b = sample(two, Design("sobol", "", 4096, 1), [[1, -0.6], [-0.6, 1]]).T
        self.assertAlmostEqual(float(np.corrcoef(a, np.log(b))[0, 1]), -0.6, delta=0.01)
        np.testing.assert_allclose([a.mean(), a.std(), np.median(b), np.log(b).std()], [5, 2, 1, 0.5], rtol=0.01)

    def test_crossed_levels_meet_the_same_sample(self) -> None:
        both = [parameter("v", list=[1, 2]), parameter("a", uniform=[0, 1])]
        points = sample(both, Design("random", "", 4, 1, ("v",)))
        self.assertEqual(points[:, 0].tolist(), [1] * 4 + [2] * 4)
        np.testing.assert_array_equal(points[:4, 1], points[4:, 1])


class Statistics(unittest.TestCase):
    def test_sobol_indices_of_ishigami(self) -> None:
        """Ishigami and Homma (1990), a = 7, b = 0.1: closed forms."""
        angles = [parameter(name, uniform=[-np.pi, np.pi]) for name in "xyz"]
        x, y, z = sample(angles, Design("sobol_indices", "", 4096, 1)).T
        found = sobol_indices((np.sin(x) + 7 * np.sin(y) ** 2 + 0.1 * z**4 * np.sin(x)).reshape(-1, 5))
        np.testing.assert_allclose(found.first, [0.3139, 0.4424, 0], atol=0.01)
        np.testing.assert_allclose(found.total, [0.5576, 0.4424, 0.2437], atol=0.01)
        self.assertTrue(np.all(found.total_ends[0] < found.total) and np.all(found.total < found.total_ends[1]))

    def test_answers_that_are_all_the_same_have_no_indices(self) -> None:
        self.assertTrue(np.isnan(sobol_indices(np.full((8, 4), 3.0)).first).all())

    def test_fragility_is_found_again(self) -> None:
        random = np.random.default_rng(1)
        intensity = random.uniform(0.5, 6, 4000)
        exceeded = random.random(4000) < Fit(2.0, 0.4).at(intensity)
        fit = fit_fragility(intensity, exceeded)
        np.testing.assert_allclose([fit.median, fit.deviation], [2.0, 0.4], rtol=0.05)
        self.assertAlmostEqual(float(fit.at(np.array(fit.median))), 0.5)
        scaled = fit_fragility(1e6 * intensity, exceeded)
        np.testing.assert_allclose([scaled.median, scaled.deviation], [1e6 * fit.median, fit.deviation], rtol=1e-4)

    def test_runs_that_do_not_say_the_curve_are_named(self) -> None:
        for intensity, exceeded, words in (([1, 2, 3, 4], [0, 0, 0, 0], "in no runs"),
                                           ([1, 2, 3, 4], [1, 1, 1, 1], "in all runs"),
                                           ([1, 2, 3, 4], [0, 0, 1, 1], "not how steep"),
                                           ([0, 2, 3, 4], [0, 1, 0, 1], "> 0"),
                                           ([1, 2, 3, 4], [1, 1, 0, 0], "less often at larger")):
            self.assertIn(words, fit_fragility(np.array(intensity, dtype=float), np.array(exceeded, dtype=bool)))

    def test_levels(self) -> None:
        levels = levels_of(np.array([2.0, 1, 1, 2]), np.array([True, False, True, True]))
        self.assertEqual(levels, [Level(1, 2, 1), Level(2, 2, 2)])
        grouped = levels_of(np.arange(64.0), np.arange(64) >= 32)
        self.assertEqual([level.share for level in grouped], [0] * 4 + [1] * 4)
        self.assertAlmostEqual(Level(1, 4, 0).ends[1], 1 - 0.025**0.25)
        self.assertAlmostEqual(Level(1, 4, 4).ends[0], 0.025**0.25)

    def test_standard_error_and_bands(self) -> None:
        self.assertAlmostEqual(standard_error(np.array([1.0, 2, 3])), 1 / np.sqrt(3))
        time = np.array([0, 0.3, 1.0])
        longer = Curve(np.array([0, 2.0]), np.array([0, 4.0]))
        band = band_of([*(Curve(time, slope * time) for slope in range(5)), longer])
        self.assertEqual((band.time[-1], band.ends), (1.0, (1.0, 2.0)))
        np.testing.assert_allclose(band.mean, 2 * band.time)
        np.testing.assert_allclose(band.quantiles[2], 2 * band.time)
        np.testing.assert_allclose(band.error[-1], np.std([0, 1, 2, 3, 4, 2], ddof=1) / np.sqrt(6))


class Answers(ScriptCase):
    def test_numbers_of_a_column(self) -> None:
        made_up.write_table(self.folder / "probes.csv", ["time", "x"], [[0, 0], [1, -4], [3, 2], [4, ""]])
        exact = {"largest": 2, "smallest": -4, "peak": -4, "time_of_peak": 1, "last": 2, "mean": -4 / 3, "integral": -4}
        self.assertEqual(set(exact), set(TAKES))
        for take, value in exact.items():
            self.assertAlmostEqual(Answer("a", "probes.csv", "x", take).of(Results(self.folder)), value, msg=take)
        self.assertAlmostEqual(Answer("a", "probes.csv", "x", {"mean_of_last": 1}).of(Results(self.folder)), 0.5)

    def test_what_is_not_there(self) -> None:
        made_up.write_table(self.folder / "probes.csv", ["time", "x", "word"], [[0, "", "a"]])
        self.write("summary.json", '{"steps": 3, "program": "x", "solver": {"points": 7}}')
        results = Results(self.folder)
        for words, asked in (("no number in the column x", lambda: curve_of(results, "probes.csv", "x")),
                             ("word is a column of texts", lambda: curve_of(results, "probes.csv", "word")),
                             ("no steps.csv", lambda: curve_of(results, "steps.csv", "x")),
                             ("nothing at /stepps; there are steps",
                              lambda: Answer("a", pointer="/stepps").of(results)),
                             ("found 'x' at /program", lambda: Answer("a", pointer="/program").of(results))):
            with self.assertRaisesRegex(ResultsError, words):
                asked()
        self.assertEqual(Answer("a", pointer="/solver/points").of(results), 7)


if __name__ == "__main__":
    unittest.main()
