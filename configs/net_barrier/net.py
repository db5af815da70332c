# SPDX-License-Identifier: BSD-3-Clause
"""A net of steel ropes across a channel, between two posts that ropes with brakes hold from uphill. SI units.

x downhill, y across, z normal to the bed. The net is in the plane x = 1, its edges are on the posts and on the bed.
"""

import openseespy.opensees as ops

WIDTH, HEIGHT = 0.8, 0.5
ACROSS, UP = 16, 10  # meshes
STEEL, ROPE, MESH = 210e9, 100e9, 20e9  # Young's modulus [Pa], by the metallic section
NET_AREA, TOP_AREA, STAY_AREA = 3e-6, 17e-6, 17e-6  # metallic [m2]
NET_MASS = 3.0  # [kg/m2], with a fine mesh that holds the soil
TENSION = 1e-3  # strain of the ropes across as built
SLACK = 0.01  # of the stiffness of a rope in compression
FOOT = 1000.0  # [N m] a radian, of the feet of the posts
BRAKE = 250.0  # [N] at which the brakes of the stays run
TOP_MASS = 0.15  # [kg/m]


def node(i: int, k: int) -> int:
    return 1 + i * (UP + 1) + k


def supports() -> None:
    """Posts on feet that turn about y against a spring, the net pegged to the bed; ropes have no rotations."""
    for i in range(ACROSS + 1):
        post = i in (0, ACROSS)
        for k in range(UP + 1):
            ops.node(node(i, k), 1.0, WIDTH * i / ACROSS, HEIGHT * k / UP)
            fixed = int(k == 0)
            stiff = int(fixed or not post)
            ops.fix(node(i, k), fixed, fixed, fixed, stiff, int(not post), stiff)
    for number, i in enumerate((0, ACROSS)):
        ops.node(1001 + number, 0.4, WIDTH * i / ACROSS, 0.0)  # anchors of the stays
        ops.node(1011 + number, 1.0, WIDTH * i / ACROSS, 0.0)  # of the springs of the feet
        for tag in (1001 + number, 1011 + number):
            ops.fix(tag, 1, 1, 1, 1, 1, 1)


def materials() -> None:
    """1: steel of the posts; 2, 12: net, taut and not as built; 3: brake, slack once it has run; 4: top rope; 5:
    foot."""
    ops.uniaxialMaterial("Steel02", 1, 235e6, STEEL, 0.01, 18.0, 0.925, 0.15)
    ops.uniaxialMaterial("Elastic", 12, MESH, 0.0, SLACK * MESH)
    ops.uniaxialMaterial("InitStrainMaterial", 2, 12, TENSION)
    ops.uniaxialMaterial("Elastic", 13, ROPE, 0.0, SLACK * ROPE)
    ops.uniaxialMaterial("InitStrainMaterial", 4, 13, 0.2 * TENSION)
    ops.uniaxialMaterial("Elastic", 5, FOOT)
    ops.uniaxialMaterial("ElasticPPGap", 3, ROPE, BRAKE / STAY_AREA, 0.0, 0.0, "damage")


def posts() -> list[int]:
    """Tubes of 42.4 x 2.6 mm in fibres."""
    ops.section("Fiber", 1, "-GJ", 80e9 * 1.29e-7)
    ops.patch("circ", 1, 16, 2, 0.0, 0.0, 0.0186, 0.0212, 0.0, 360.0)
    ops.beamIntegration("Lobatto", 1, 1, 3)
    ops.geomTransf("Corotational", 1, 1.0, 0.0, 0.0)
    tags = []
    for first, i in ((2001, 0), (2101, ACROSS)):
        for k in range(UP):
            ops.element("dispBeamColumn", first + k, node(i, k), node(i, k + 1), 1, 1, "-mass", 2.55, "-cMass")
            tags.append(first + k)
        ops.element("zeroLength", first + 50, 1011 + int(i > 0), node(i, 0), "-mat", 5, "-dir", 5)
    return tags


def ropes() -> None:
    """Across: 10000 + 100 k + i, the top rope at k = UP; upwards: 20000 + 100 k + i; stays 3001, 3002."""
    for i in range(ACROSS):
        for k in range(1, UP + 1):
            rope = (TOP_AREA, 4) if k == UP else (NET_AREA, 2)
            ops.element("corotTruss", 10000 + 100 * k + i, node(i, k), node(i + 1, k), *rope)
    for i in range(1, ACROSS):
        for k in range(UP):
            ops.element("corotTruss", 20000 + 100 * k + i, node(i, k), node(i, k + 1), NET_AREA, 12)
    for number, i in enumerate((0, ACROSS)):
        ops.element("corotTruss", 3001 + number, 1001 + number, node(i, UP), STAY_AREA, 3)


def masses() -> None:
    """Write the masses of the net and its top rope; posts bring their own."""
    for i in range(ACROSS + 1):
        for k in range(1, UP + 1):
            part = (0.5 if i in (0, ACROSS) else 1) * (0.5 if k == UP else 1)
            mass = part * NET_MASS * WIDTH * HEIGHT / ACROSS / UP + (TOP_MASS * WIDTH / ACROSS if k == UP else 0.0)
            ops.mass(node(i, k), mass, mass, mass, 0.0, 0.0, 0.0)


def tighten() -> None:
    """The equilibrium of ropes and posts without weight, with which the run starts."""
    ops.constraints("Plain")
    ops.numberer("RCM")
    ops.system("BandGeneral")
    ops.test("NormDispIncr", 1e-12, 100)
    ops.algorithm("Newton")
    ops.integrator("LoadControl", 0.0)
    ops.analysis("Static")
    if ops.analyze(1) != 0:
        raise RuntimeError("no equilibrium of the ropes as built")


ops.wipe()
ops.model("basic", "-ndm", 3, "-ndf", 6)
supports()
materials()
POSTS = posts()
ropes()
masses()
tighten()
# Meshes of the net, their normals uphill.
NET = [[node(i, k), node(i, k + 1), node(i + 1, k + 1), node(i + 1, k)] for i in range(ACROSS) for k in range(UP)]
