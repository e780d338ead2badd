"""The names of the figures of each model, available without importing the code that draws them."""

from __future__ import annotations

from ecume.errors import BadInput
from ecume.scenes.faults import suggestion

FIGURE_NAMES = {
    "floating": (
        "energies",
        "kinetic-energy",
        "clusters",
        "paths",
        "force-law",
        "bowl",
        "order",
        "pair-distribution",
        "displacement",
        "approach",
        "distance",
        "shapes",
        "raft-sizes",
        "topologies",
        "transitions",
        "sizes",
        "samples",
    ),
    "sph": (
        "energies",
        "kinetic-energy",
        "pressure",
        "dynamic-pressure",
        "front",
        "center",
        "snapshot",
        "velocity",
        "surface",
        "gauges",
        "forces",
        "samples",
    ),
    "tracers": (
        "energies",
        "displacement",
        "heights",
        "profile",
        "hits",
        "spreading",
        "dispersion",
        "residence",
        "breakthrough",
        "concentration",
        "deposition",
        "efficiency",
        "sizes",
        "samples",
    ),
    "soft": (
        "gaps",
        "forces",
        "elastic-energy",
        "stress",
        "gap-distribution",
        "coordination",
        "viscosity",
        "swaps",
        "nonaffine",
        "across",
        "steady-state",
        "flow-curve",
        "viscous-number",
        "normal-stresses",
        "viscosity-fraction",
        "creep",
        "moduli",
        "large-oscillation",
        "start-up",
        "relaxation",
        "recovery",
        "packing",
        "sizes",
        "samples",
    ),
}
"""The names for `ecume plot --what`, by model."""

NUMBER = "number:"
"""The prefix of the figure of a number over time, followed by the name of the number."""


ELSEWHERE_CALLED = {"msd": "displacement", "g(r)": "pair-distribution", "rdf": "pair-distribution", "gap": "distance"}
"""Names that figures have in other programs."""


def require_figure(model: str, name: str) -> None:
    """Raise BadInput if a model of the table has no figure with this name."""
    known = FIGURE_NAMES.get(model, ())
    if known and name not in known and not name.startswith(NUMBER):
        usual = ELSEWHERE_CALLED.get(name.lower(), name)
        others = [other for other, names in FIGURE_NAMES.items() if usual in names]
        if usual in known:
            raise BadInput(f"no such figure as {name!r}; did you mean {usual}?")
        if others:
            raise BadInput(f"{usual} is a figure of the model {' and '.join(others)}; this run is of the model {model}")
        raise BadInput(f"no such figure as {name!r}; {suggestion(name, known)}")
