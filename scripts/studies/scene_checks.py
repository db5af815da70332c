# SPDX-License-Identifier: BSD-3-Clause
"""Four coupled scenes against closed forms and their own balances."""

from studies import gate_checks, posts_checks, slope_checks, terrain_checks
from studies.runner import Runner
from studies.scene_course import course

HEAD = ["check", "expected", "found"]


def scene_checks(runner: Runner) -> None:
    """Coupled scenes against what theory says of them: beams, sliding blocks, earth pressure, balances, gauges."""
    gate = runner.run(gate_checks.SCENE, gate_checks.SCENE, [])
    fine = runner.run("gate_fine", gate_checks.SCENE, gate_checks.FINE)
    laid = runner.run("gate_laid", gate_checks.SCENE, gate_checks.LAID)
    ramped = runner.run("gate_ramped", gate_checks.SCENE, gate_checks.RAMPED)
    slope = runner.run(slope_checks.SCENE, slope_checks.SCENE, [])
    posts = runner.run(posts_checks.SCENE, posts_checks.SCENE, [])
    terrain = runner.run(terrain_checks.SCENE, terrain_checks.SCENE, [])
    tables = {gate_checks.SCENE: gate_checks.gate_rows(gate, fine, laid, ramped),
              slope_checks.SCENE: slope_checks.slope_rows(slope),
              posts_checks.SCENE: posts_checks.posts_rows(posts),
              terrain_checks.SCENE: terrain_checks.terrain_rows(terrain)}
    for scene, rows in tables.items():
        runner.report(HEAD, rows, scene)
    runner.report(terrain_checks.gauge_head(),
                  [terrain_checks.largest_row(terrain, gauge) for gauge in terrain_checks.GAUGES], "gauges")
    runner.report(["scene", "what", "value"], course(gate, slope, posts, terrain), "course")
    runner.remark("in the plane per metre; end: mean of the last 0.16, 1, 0.2, 1.2 s of the scenes in their order, of "
                  "the gate that does not move 0.1 s; `expected` by the theory named after the colon, with forces and "
                  "momentum of the same run; gauges: largest values; course: the end is the last instant")


STUDIES = {scene_checks.__name__: scene_checks}
