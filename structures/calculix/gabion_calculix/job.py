# SPDX-License-Identifier: BSD-3-Clause
"""The input of ccx: the deck's own steps once, then one *STEP for each solution of a coupled step."""

import json
from collections.abc import Iterable

import numpy as np

from .deck import Card, Deck, DeckError
from .settings import Settings
from .wet_surface import WetSurface

PROCEDURES = ("*STATIC", "*DYNAMIC")
OTHER_PROCEDURES = ("*FREQUENCY", "*BUCKLE", "*HEATTRANSFER", "*MODALDYNAMIC", "*STEADYSTATEDYNAMICS", "*VISCO",
                    "*COUPLEDTEMPERATURE-DISPLACEMENT", "*UNCOUPLEDTEMPERATURE-DISPLACEMENT", "*CFD", "*GREEN",
                    "*SENSITIVITY", "*COMPLEXFREQUENCY", "*ELECTROMAGNETICS", "*CRACKPROPAGATION", "*FEASIBLEDIRECTION",
                    "*ROBUSTDESIGN", "*REFINEMESH", "*SUBSTRUCTUREGENERATE")
HISTORY = ("*PLASTIC", "*CYCLICHARDENING", "*CREEP", "*DEPVAR", "*USERMATERIAL", "*MOHRCOULOMB", "*DAMAGEINITIATION")
HALF_MASS = ("CPE4", "CPS4", "CAX4")
SMALLEST = 1e-98  # [N] that 20 characters hold, which is what ccx reads of a number

Load = tuple[int, int, float]  # node, direction 1 to 3, [N]


def number_text(value: float) -> str:
    """Number in at most 20 characters: ccx ignores the rest of a longer one, its exponent too."""
    return f"{value:.13e}" if abs(value) > SMALLEST else "0."


def loads_of(surfaces: Iterable[WetSurface], forces: dict[str, np.ndarray]) -> list[Load]:
    """All degrees of freedom of all wet nodes, zeros too: a load makes the node of a shell, beam or plane
    element, which ccx expands to a solid, a degree of freedom of its own, so that its displacement does work with
    the force."""
    total: dict[tuple[int, int], float] = {}
    for surface in surfaces:
        force = forces.get(surface.name, np.zeros_like(surface.coordinates)) * surface.thickness
        for node, row in zip(surface.nodes.tolist(), force.tolist()):
            for k, value in enumerate(row):
                total[node, k + 1] = total.get((node, k + 1), 0.0) + value
    return [(node, direction, value) for (node, direction), value in total.items()]


def load_lines(loads: list[Load]) -> list[str]:
    return ["*CLOAD", *(f"{node}, {direction}, {number_text(value)}" for node, direction, value in loads)]


def check_dynamics(deck: Deck) -> None:
    """Refuse what *DYNAMIC of ccx 2.20 does wrong without a warning. Raises DeckError."""
    for card in deck.cards_of("*KINEMATIC"):
        raise card.line.error("*KINEMATIC, with which nothing moves in *DYNAMIC of ccx 2.20",
                              "*RIGID BODY, *DISTRIBUTING, or statics")
    for card in deck.cards_of("*ELEMENT"):
        if card.parameters["TYPE"] in HALF_MASS:
            raise card.line.error(f"TYPE={card.parameters['TYPE']}, which has half of its mass in *DYNAMIC of ccx 2.20",
                                  "CPE3, CPE6, CPE8, CPE8R and the like, or statics")


def check_deck(deck: Deck, surfaces: Iterable[WetSurface]) -> None:
    """Refuse settings of the deck that steps of a coupled run cannot keep. Raises DeckError."""
    wet = {node for surface in surfaces for node in surface.nodes.tolist()}
    for card in deck.cards:
        if card.keyword in OTHER_PROCEDURES or (card.keyword == "*STEP" and "PERTURBATION" in card.parameters):
            raise card.line.error(f'"{card.line.text}"', f"steps of {', '.join(PROCEDURES)}")
        if card.keyword == "*RESTART" and "READ" in card.parameters:
            raise card.line.error("*RESTART, READ", "a deck that starts at the beginning")
        if card.keyword == "*DYNAMIC" and "EXPLICIT" in card.parameters:
            raise card.line.error("*DYNAMIC, EXPLICIT", "implicit steps")
        if card.keyword == "*AMPLITUDE" and card.parameters.get("TIME") != "TOTALTIME":
            raise card.line.error("an *AMPLITUDE over the time of a step, which would begin anew in each coupled step",
                                  "TIME=TOTAL TIME")
        if card.keyword == "*TRANSFORM":
            refuse_wet(card, wet, deck.nodes_of(card.line, card.name("NSET")))
        if card.keyword == "*CLOAD":
            for line in card.data:
                refuse_wet(card, wet, deck.nodes_of(line, line.cells()[0]))


def check_nlgeom(deck: Deck, wanted: bool) -> None:
    """Refuse a start with small displacements before steps with large ones: it is no equilibrium of these. Raises
    DeckError."""
    large = False  # NLGEOM holds until NLGEOM=NO
    for card in deck.cards_of("*STEP"):
        large = card.parameters.get("NLGEOM", "" if large else "NO") != "NO"
        if large != wanted:
            raise card.line.error(f'"{card.line.text}" with "nlgeom": {json.dumps(wanted)} in structure.json',
                                  "NLGEOM on the *STEPs of the deck and true, or neither")


def refuse_wet(card: Card, wet: set[int], nodes: list[int]) -> None:
    if common := sorted(wet & set(nodes)):
        raise card.line.error(f"{card.keyword} at node {common[0]} of a wet surface", "nodes that are not wet")


def keeps_history(deck: Deck) -> str:
    """Lines of a model that make ccx write the history of the material, plastic strains and the like, into its
    restart file, which version 2.20 does only where there is contact: a fixed tetrahedron, and a fixed node far from it
    in possible contact with it. None where nothing is to be kept, or the deck has contact."""
    if not deck.cards_of(*HISTORY) or deck.cards_of("*CONTACTPAIR"):
        return ""
    node, element = max(deck.nodes) + 1, max(deck.elements) + 1
    span = np.array(list(deck.nodes.values()))
    far, size = span.max(axis=0), float(np.ptp(span, axis=0).max())
    corners = far + size * np.array([[10, 10, 10], [11, 10, 10], [10, 11, 10], [10, 10, 11], [20, 20, 20]])
    return "\n".join([
        "*NODE, NSET=GABION_FIXED", *(f"{node + k}, {x:.6e}, {y:.6e}, {z:.6e}" for k, (x, y, z) in enumerate(corners)),
        "*ELEMENT, TYPE=C3D4, ELSET=GABION_FIXED", f"{element}, {node}, {node + 1}, {node + 2}, {node + 3}",
        "*MATERIAL, NAME=GABION_FIXED", "*ELASTIC", "1, 0", "*DENSITY", "1",
        "*SOLID SECTION, ELSET=GABION_FIXED, MATERIAL=GABION_FIXED", "*BOUNDARY", "GABION_FIXED, 1, 3",
        "*SURFACE, NAME=GABION_MASTER", f"{element}, S1", "*SURFACE, NAME=GABION_SLAVE, TYPE=NODE", f"{node + 4}",
        "*SURFACE INTERACTION, NAME=GABION_FAR", "*SURFACE BEHAVIOR, PRESSURE-OVERCLOSURE=LINEAR", "1",
        "*CONTACT PAIR, INTERACTION=GABION_FAR, TYPE=NODE TO SURFACE", "GABION_SLAVE, GABION_MASTER", ""])


def has_steps(deck: Deck) -> bool:
    return bool(deck.cards_of("*STEP"))


def own_steps(deck: Deck, loads: list[Load]) -> str:
    """The whole deck, with what a later step needs: the wet nodes' degrees of freedom and the energy, which ccx wants
    from the first step on, and a restart file of the last one."""
    ends = deck.cards_of("*ENDSTEP")
    if len(ends) != len(deck.cards_of("*STEP")):
        raise DeckError(f"{deck.path}: found {len(deck.cards_of('*STEP'))} *STEP and {len(ends)} *END STEP, allowed: "
                        "as many of both")
    before = {ends[0].first: [*load_lines(loads), "*EL FILE", "ENER"]}
    before[deck.cards_of("*STEP")[0].first] = keeps_history(deck).splitlines()
    before.setdefault(ends[-1].first, []).append("*RESTART, WRITE, FREQUENCY=1")
    written = {k for card in deck.cards_of("*RESTART") for k in range(card.first, card.last)}
    text = []
    for k, line in enumerate(deck.lines):
        text += before.get(k, [])
        if k not in written:
            text.append(line.text)
    return "\n".join(text) + "\n"


def model_text(deck: Deck) -> str:
    """Text of a deck without steps."""
    written = {k for card in deck.cards_of("*RESTART") for k in range(card.first, card.last)}
    return "".join(line.text + "\n" for k, line in enumerate(deck.lines) if k not in written) + keeps_history(deck)


def coupled_step(settings: Settings, begin: str, duration: tuple[float, int], loads: list[Load]) -> str:
    """begin: the model of a first step, or that ccx is to read its restart file; duration: dt [s], in so many equal
    increments."""
    dt, increments = duration
    nlgeom = "" if settings.nlgeom else "=NO"
    procedure = {"dynamic": f"*DYNAMIC, DIRECT, ALPHA={settings.alpha:.6f}",
                 "static": "*STATIC, DIRECT"}[settings.procedure]
    tolerance = number_text(settings.newton_tolerance)
    return "\n".join([
        begin.rstrip("\n"), f"*STEP, NLGEOM{nlgeom}, INC={increments}",
        "*CONTROLS, PARAMETERS=FIELD", f"{tolerance}, {tolerance}, 0., 0., {tolerance}",
        procedure, f"{number_text(dt / increments)}, {number_text(dt)}", *load_lines(loads),
        "*NODE FILE", "*EL FILE", "*RESTART, WRITE, FREQUENCY=1", "*END STEP", ""])


def with_output(job: str, plastic: bool, reactions: tuple[str, ...] = ()) -> str:
    """The last step once more, now with fields written into its .frd, and forces of these node sets into its .dat."""
    stress = "S, E, PEEQ" if plastic else "S, E"
    forces = "".join(f"*NODE PRINT, NSET={name}\nRF\n" for name in reactions)
    return job.replace("*NODE FILE\n*EL FILE\n", f"{forces}*NODE FILE\nU\n*EL FILE\n{stress}\n")


def with_section_forces(job: str) -> str:
    """The last step once more, now with the section forces of beams written into its .frd."""
    return job.replace("*NODE FILE\n*EL FILE\n",
                       "*NODE FILE, OUTPUT=2D\nU\n*EL FILE, OUTPUT=2D, SECTION FORCES\nS\n")
