# SPDX-License-Identifier: BSD-3-Clause
"""Small models of OpenSees for the tests, and whether there is an OpenSeesPy."""

import json
import os
import subprocess
from pathlib import Path

PYTHON = os.environ.get("GABION_OPENSEES_PYTHON", "/usr/bin/python3")
LENGTH, THICKNESS, YOUNG, DENSITY = 0.05, 0.01, 1e6, 1100.0
AREA, INERTIA = THICKNESS, THICKNESS**3 / 12

START = """import openseespy.opensees as ops
ops.wipe()
ops.model("basic", "-ndm", {dim}, "-ndf", {unknowns})
"""


def installed() -> bool:
    return subprocess.run([PYTHON, "-c", "import openseespy.opensees"], stdout=subprocess.DEVNULL,
                          stderr=subprocess.DEVNULL, check=False).returncode == 0


def mass() -> str:
    """2 kg in free flight at node 2, wet with node 1, which is fixed."""
    return START.format(dim=2, unknowns=2) + """
ops.node(1, 0.0, 0.0)
ops.node(2, 0.0, 1.0)
ops.fix(1, 1, 1)
ops.mass(2, 2.0, 2.0)
ops.uniaxialMaterial("Elastic", 1, 0.0)
ops.element("truss", 1, 1, 2, 1.0, 1)
"""


def cantilever(elements: int = 10, foot: float = 0.255, fibres: bool = False) -> str:
    """Upright, of the wall's size; fibres: that yield at a strain of 0.5 %. NODES from the foot to the top."""
    section = 'ops.section("Elastic", 1, 1e6, 0.01, 0.01**3 / 12)' if not fibres else \
        """ops.uniaxialMaterial("Steel02", 1, 5e3, 1e6, 0.05, 18.0, 0.925, 0.15)
ops.section("Fiber", 1)
ops.patch("rect", 1, 8, 1, -0.005, -0.5, 0.005, 0.5)"""
    return START.format(dim=2, unknowns=3) + f"""
NODES = list(range(1, {elements + 2}))
for tag in NODES:
    ops.node(tag, {foot}, 0.05 * (tag - 1) / {elements})
ops.fix(1, 1, 1, 1)
ops.geomTransf("Corotational", 1)
{section}
ops.beamIntegration("Lobatto", 1, 1, 3)
for tag in NODES[:-1]:
    ops.element("dispBeamColumn", tag, tag, tag + 1, 1, 1, "-mass", 11.0)
"""


def cantilever_in_tcl(elements: int = 10) -> str:
    return f"""wipe
model BasicBuilder -ndm 2 -ndf 3
set n {elements}
set NODES {{}}
for {{set i 1}} {{$i <= $n + 1}} {{incr i}} {{
  node $i 0.255 [expr {{0.05 * ($i - 1) / $n}}]
  lappend NODES $i
}}
fix 1 1 1 1
geomTransf Corotational 1
section Elastic 1 1e6 0.01 [expr {{0.01**3 / 12}}]
beamIntegration Lobatto 1 1 3
for {{set i 1}} {{$i <= $n}} {{incr i}} {{ element dispBeamColumn $i $i [expr {{$i + 1}}] 1 1 -mass 11.0 }}
"""


def post(elements: int = 8) -> str:
    """1 m upright in space: G J = 100 N m2, E I = 1e4 N m2."""
    return START.format(dim=3, unknowns=6) + f"""
NODES = list(range(1, {elements + 2}))
for tag in NODES:
    ops.node(tag, 0.0, 0.0, (tag - 1) / {elements})
ops.fix(1, 1, 1, 1, 1, 1, 1)
ops.geomTransf("Corotational", 1, 1.0, 0.0, 0.0)
for tag in NODES[:-1]:
    ops.element("elasticBeamColumn", tag, tag, tag + 1, 1.0, 1e9, 1e4, 0.01, 1e-5, 1e-5, 1)
"""


def line(**more: object) -> dict:
    return {"name": "wall", "line": {"nodes": "NODES", "left": 0.005, "right": 0.005, "ends": [0, 2]} | more}


def write(folder: Path, text: str, interface: dict, suffix: str = ".py", **settings: object) -> Path:
    """The model and structure.json; the path of this."""
    (folder / f"model{suffix}").write_text(text, encoding="utf-8")
    path = folder / "structure.json"
    path.write_text(json.dumps({"model": f"model{suffix}", "interfaces": [interface]} | settings), encoding="utf-8")
    return path
