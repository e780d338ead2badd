"""Every pair of options of floating scenes: which can be combined, and the page that says so.

`python -m tests.contracts.float_options` writes the page anew.
"""

from __future__ import annotations

import functools
import itertools
from collections.abc import Callable
from pathlib import Path
from typing import Any

from tests.models.floating.bowls import scene_of

from ecume.errors import SceneError
from ecume.models import MODELS
from ecume.models.floating.forces import multipoles

PAGE = Path(__file__).parents[2] / "docs" / "physics" / "floating-compatibility.md"
FLOATING = MODELS["floating"]
PLACES = [(0.0, 0.0), (1.1e-4, 2e-5), (-3e-5, 1.4e-4)]

OPTIONS: dict[str, tuple[str, dict[str, str]]] = {
    "no pair law": ("law", {"interaction": 'law = "none"\n'}),
    "one-sided law": ("law", {"interaction": 'law = "one-sided-legacy"\n'}),
    "pair-corrected": ("method", {"interaction": 'method = "pair-corrected"\n'}),
    "multipole": ("method", {"interaction": 'method = "multipole"\norder = 2\n'}),
    "grid": ("sum", {"interaction": 'summation = "grid"\n'}),
    "single precision": ("precision", {"interaction": 'precision = "single"\n'}),
    "dipoles": ("dipoles", {"particles": "magnetic_moment = 1e-10\n"}),
    "shapes": ("shapes", {"more": '[[particles]]\nradius = 3e-5\ndensity = 2000.0\ncontact_angle = 1.5\n'
               'positions = [[-1.5e-4, -5e-5]]\nshape = { kind = "ellipsoid", width = 2.5e-5 }\n'}),
    "flow of neighbors": ("flow of neighbors", {"hydrodynamics": 'interaction = "rotne-prager"\n'}),
    "films": ("films", {"hydrodynamics": "lubrication = { roughness = 1e-8 }\n"}),
    "springs": ("contacts", {"contacts": 'law = "spring-dashpot"\nstiffness = 1.0\nrestitution = 0.5\n'}),
    "no contacts": ("contacts", {"contacts": 'law = "none"\n'}),
    "legacy contacts": ("contacts", {"contacts": "legacy_coefficient = 0.5\n"}),
    "friction": ("contacts", {"contacts": "friction = 0.3\n"}),
    "rolling friction": ("contacts", {"contacts": "friction = 0.3\nrolling_friction = 0.1\n"}),
    "velocity-verlet": ("integrator", {"integration": 'integrator = "velocity-verlet"\n'}),
    "explicit-euler": ("integrator", {"integration": 'integrator = "explicit-euler"\n'}),
    "semi-implicit-euler": ("integrator", {"integration": 'integrator = "semi-implicit-euler"\n'}),
    "stormer-verlet": ("integrator", {"integration": 'integrator = "stormer-verlet"\n'}),
    "rk4": ("integrator", {"integration": 'integrator = "rk4"\n'}),
    "overdamped": ("integrator", {"integration": 'integrator = "overdamped"\n'}),
    "round dish": ("dish", {"dish": "radius = 1e-3\nrestitution = 0.5\n"}),
    "square dish": ("dish", {"dish": "size = [8e-3, 8e-3]\nrestitution = 0.5\n"}),
    "wall profile": ("dish", {"dish": 'radius = 1e-3\nrestitution = 0.5\nlaw = "profile"\n'}),
    "dish in motion": ("dish", {"dish": "radius = 1e-3\nrestitution = 0.5\n"
                       "motion = { amplitude = 1e-5, frequency = 2.0 }\n"}),
    "barrier": ("dish", {"dish": 'size = [8e-3, 8e-3]\nrestitution = 0.5\nlaw = "none"\n'
                "barrier = { velocity = 0.01, start = 3.85999e-3 }\n"}),
    "periodic cell": ("dish", {"cell": "size = [0.1, 0.1]\n", "interaction": "accuracy = 1e-2\n"}),
    "surfactant in a dish": ("dish", {
        "dish": "radius = 1e-3\nrestitution = 0.5\n",
        "surfactant": "diffusivity = 1e-6\ntension_slope = 1.0\nspacing = 2.5e-5\n"
                      "[[surfactant.sources]]\nrelease = 1e-15\n",
    }),
    "flow": ("flow", {"flow": "rotation_rate = 1.0\n"}),
    "active forces": ("activity", {"activity": "force = 1e-12\npersistence = 0.1\npropulsion = 1e-12\n"}),
    "waves": ("waves", {"waves": "frequency = 100.0\n[[waves.sources]]\nplace = [1e-5, 0.0]\nforce = 1e-7\n"}),
    "magnetic field": ("dipoles", {"magnetic_field": "constant = [1e-3, 0.0, 2e-3]\nsusceptibility = 10.0\n"}),
    "noise": ("noise", {"hydrodynamics": "brownian = true\n", "liquid": "temperature = 300.0\n"}),
    "fast drag": ("drag", {"hydrodynamics": 'drag = "schiller-naumann"\n'}),
    "added mass": ("mass", {"hydrodynamics": "added_mass = true\n"}),
}  # fmt: skip
"""What it is a choice of, and the lines that a scene has for it, table by table."""
SUPPORT = dict.fromkeys(("films", "noise", "flow of neighbors"), 'integrator = "overdamped"\n')
"""The integrator that an option takes where the other one chooses none."""
INERTIA = {"velocity-verlet", "explicit-euler", "semi-implicit-euler", "stormer-verlet"}
"""Integrators with which collisions between Brownian floats must be elastic."""
NEW = {
    ("pair-corrected", "dipoles"),
    ("pair-corrected", "films"),
    ("pair-corrected", "springs"),
    ("multipole", "dipoles"),
    ("multipole", "films"),
    ("multipole", "springs"),
    ("grid", "dipoles"),
    ("grid", "films"),
    ("grid", "springs"),
    ("grid", "friction"),
    ("grid", "stormer-verlet"),
    ("grid", "rk4"),
    ("grid", "rolling friction"),
    ("dipoles", "films"),
    ("dipoles", "springs"),
    ("dipoles", "friction"),
    ("dipoles", "rolling friction"),
    ("films", "friction"),
    ("films", "rolling friction"),
    ("shapes", "noise"),
    ("dipoles", "shapes"),
    ("shapes", "wall profile"),
    ("shapes", "dish in motion"),
    ("shapes", "flow"),
    ("shapes", "active forces"),
    ("films", "velocity-verlet"),
    ("films", "explicit-euler"),
    ("stormer-verlet", "active forces"),
    ("stormer-verlet", "dish in motion"),
    ("stormer-verlet", "fast drag"),
    ("rk4", "dish in motion"),
    ("shapes", "barrier"),
    ("shapes", "periodic cell"),
    ("shapes", "waves"),
    ("one-sided law", "dipoles"),
    ("one-sided law", "films"),
    ("one-sided law", "springs"),
    ("one-sided law", "friction"),
    ("one-sided law", "rolling friction"),
    ("one-sided law", "magnetic field"),
    ("multipole", "waves"),
    ("friction", "stormer-verlet"),
    ("friction", "rk4"),
    ("friction", "waves"),
    ("rolling friction", "stormer-verlet"),
    ("rolling friction", "rk4"),
    ("rolling friction", "waves"),
    ("velocity-verlet", "noise"),
    ("explicit-euler", "noise"),
    ("semi-implicit-euler", "noise"),
    ("stormer-verlet", "noise"),
}
"""Pairs that used to be refused."""


def shorten_tables(replace: Callable[[Any, str, Any], None]) -> None:
    """Make tables of corrected pairs with few nodes and orders, which are as smooth and take no minutes."""
    replace(multipoles, "NODES", 9)
    replace(multipoles, "ORDER", 2)


DRIVEN = ("cell", "flow", "activity", "magnetic_field", "waves", "surfactant")
TABLES = ("liquid", *DRIVEN, "dish", "integration", "hydrodynamics", "contacts", "interaction")


def scene_with(*names: str) -> Any:
    """Three different small floats at rest with these options."""
    tables = dict.fromkeys(("particles", "more", *TABLES), "")
    for name in names:
        for table, lines in OPTIONS[name][1].items():
            tables[table] += lines
    if "noise" in names and INERTIA & set(names):
        tables["contacts"] += "restitution = 1.0\n"
    if "integrator" not in tables["integration"]:
        tables["integration"] += next((SUPPORT[name] for name in names if name in SUPPORT), "")
    floats = "".join(
        f"[[particles]]\nradius = {radius}\ndensity = {density}\ncontact_angle = 1.5\npositions = [{list(place)}]\n"
        f"{tables['particles']}"
        for place, radius, density in zip(PLACES, (3e-5, 3e-5, 2.7e-5), (2000.0, 200.0, 1500.0), strict=True)
    )
    dish = f"[dish]\n{tables['dish']}" if tables["dish"] else ""
    dish += "".join(f"[{table}]\n{tables[table]}" for table in DRIVEN if tables[table])
    rest = "".join(
        f"[{table}]\n{tables[table]}" for table in ("integration", "hydrodynamics", "contacts", "interaction")
    )
    liquid = f"[liquid]\ndensity = 1000.0\nviscosity = 1e-3\nsurface_tension = 0.0728\n{tables['liquid']}"
    return scene_of(f"{liquid}{floats}{tables['more']}{dish}{rest}", duration=1e-6, frame_every=1e-7)


def pairs() -> list[tuple[str, str]]:
    """All pairs of options that can be chosen together."""
    return [(one, two) for one, two in itertools.combinations(OPTIONS, 2) if OPTIONS[one][0] != OPTIONS[two][0]]


@functools.cache
def refusal(*names: str) -> str:
    """The reason why a scene with these options is refused; empty if it is accepted."""
    try:
        FLOATING.parameters(scene_with(*names))
    except SceneError as error:
        return str(error)
    return ""


def page() -> str:
    """The page: a table of all pairs, and the reasons of refusals."""
    found = {pair: refusal(*pair) for pair in pairs()}
    letters = {name: str(number) for number, name in enumerate(OPTIONS, 1)}

    def cell(one: str, two: str) -> str:
        pair = (one, two) if (one, two) in found else (two, one)
        if pair not in found:
            return ""
        return "--" if found[pair] else "new" if pair in NEW else "yes"

    lines = [
        "# Options of floats that can be combined",
        "",
        "Made by `python -m tests.contracts.float_options` from the tables of the model.",
        "`tests/contracts/test_float_options.py` runs every pair for some steps.",
        "`yes`: works, as it did before options were compared by what they need; `new`: used to be refused;",
        "`--`: refused, for the reason below. Empty: choices of the same thing.",
        "",
        "| | option | " + " | ".join(letters.values()) + " |",
        "|---|---|" + "---|" * len(letters),
    ]
    lines += [f"| {letters[one]} | {one} | " + " | ".join(cell(one, two) for two in OPTIONS) + " |" for one in OPTIONS]
    lines += ["", "## Refused pairs", "", "| options | reason |", "|---|---|"]
    for (one, two), why in found.items():
        if why:
            said = why.removeprefix("scene: ").replace("\n", " ").replace("|", "/")
            lines.append(f"| {one}, {two} | {said} |")
    return "\n".join(lines) + "\n"


if __name__ == "__main__":
    shorten_tables(setattr)
    PAGE.write_text(page(), encoding="utf-8")
