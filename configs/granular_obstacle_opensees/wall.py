# SPDX-License-Identifier: BSD-3-Clause
"""The wall of the obstacle as beams, in equilibrium with its weight. Per metre, as all in 2D: N, N m, kg."""

import openseespy.opensees as ops

LENGTH, THICKNESS, DENSITY, YOUNG, GRAVITY = 0.05, 0.01, 1100.0, 1e6, 9.81
ELEMENTS = 40
AXIS = list(range(1, ELEMENTS + 2))  # nodes, from the foot to the top

ops.wipe()
ops.model("basic", "-ndm", 2, "-ndf", 3)
for node in AXIS:
    ops.node(node, 0.255, LENGTH * (node - 1) / ELEMENTS)
ops.fix(1, 1, 1, 1)
ops.geomTransf("Corotational", 1)
AREA = THICKNESS
INERTIA = THICKNESS**3 / 12
SHEAR = YOUNG / 2  # no Poisson's ratio
ops.section("Elastic", 1, YOUNG, AREA, INERTIA, SHEAR, 5 / 6)
ops.beamIntegration("Legendre", 1, 1, 1)
for node in AXIS[:-1]:
    ops.element("timoshenkoBeamColumn", node, node, node + 1, 1, 1, "-mass", DENSITY * AREA)
for node in AXIS:
    share = 0.5 if node in (AXIS[0], AXIS[-1]) else 1.0
    ops.mass(node, 0.0, 0.0, share * DENSITY * INERTIA * LENGTH / ELEMENTS)  # of the sections' rotation

ops.timeSeries("Constant", 1)
ops.pattern("Plain", 1, 1)
for node in AXIS:
    share = 0.5 if node in (AXIS[0], AXIS[-1]) else 1.0
    ops.load(node, 0.0, -share * DENSITY * AREA * GRAVITY * LENGTH / ELEMENTS, 0.0)
ops.constraints("Plain")
ops.numberer("Plain")
ops.system("BandGeneral")
ops.test("NormDispIncr", 1e-13, 20)
ops.algorithm("Newton")
ops.integrator("LoadControl", 1.0)
ops.analysis("Static")
if ops.analyze(1) != 0:
    raise RuntimeError("no equilibrium under the weight")
ops.setTime(0.0)
