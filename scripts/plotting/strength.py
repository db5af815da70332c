# SPDX-License-Identifier: BSD-3-Clause
"""The factor of safety that a search of mpm_solver found, in words."""


def strength_search(summary: dict | None) -> str | None:
    """Result of the search in words; None: the run had none."""
    solver = (summary or {}).get("solver")
    search = solver.get("strength_reduction") if isinstance(solver, dict) else None
    if not search:
        return None
    rests = f"{search['equilibrium_with']:.4g}"
    if search["verdict"] == "failure":
        return (f"{search['factor_of_safety']:.4g}: equilibrium with {rests}, none with {search['none_with']:.4g}, "
                f"displacement {search['displacement']:.3g} m")
    if search["verdict"] == "no_failure":
        return f"no failure found: equilibrium still with {rests}"
    return f"none given: Newton's method gave up at {search['none_with']:.4g} before the soil slid, last with {rests}"
