"""Comparisons of ecume with published numbers: `ecume validate`.

Start with `CASES`, the table of cases. Each case is a function that runs it and returns `runner.Row`s: `rows` in the
module with its name, or a function in a module for several cases of one subject. Its scene, its tables and a README
with their sources are in `data/CASE`. `runner` reads and runs scenes, and compares the numbers of rows.
"""

from __future__ import annotations

import importlib
from collections.abc import Callable
from typing import NamedTuple

from ecume_validation.runner import Row


class Case(NamedTuple):
    """A subject of comparison."""

    name: str
    summary: str
    long: bool
    """whether it takes minutes rather than seconds"""
    rows: Callable[[], list[Row]]
    module: str
    """the module with its function"""


def _case(name: str, summary: str, *, long: bool = False, place: str = "") -> Case:
    """A case; `place` is MODULE:FUNCTION, by default the function `rows` of the module of its name."""
    module, function = f"ecume_validation.{place or name.replace('-', '_') + ':rows'}".split(":")

    def rows() -> list[Row]:
        # Imported on use, so that `ecume --help` reads the table without loading the compiler.
        found: list[Row] = getattr(importlib.import_module(module), function)()
        return found

    return Case(name, summary, long, rows, module)


CASES: dict[str, Case] = {
    case.name: case
    for case in (
        _case(
            "floating",
            "Floating bodies, sinking limits, menisci, walls and drag, against an independent computation",
            place="float_forces:sphere_rows",
        ),
        _case(
            "multipole",
            "Discs and spheres beyond superposition, against an independent computation",
            place="float_forces:multipole_rows",
        ),
        _case(
            "shapes",
            "Ellipsoids, needles, squares, stars: forces, torques, docking, collisions",
            place="float_forces:shape_rows",
        ),
        _case("kernels", "Smoothing kernels: what a kernel must be, an independent computation, published numbers"),
        _case(
            "reflection",
            "Walls that reflect: billiards, bouncing balls, wedges, circles, no escapes",
            long=True,
            place="tracers:reflection_rows",
        ),
        _case(
            "surface-tension",
            "Drops in 2D: rounding, oscillation, damping, pressure inside",
            place="drops:tension_rows",
        ),
        _case("wetting", "Drops on plates and liquid between plates: contact angles, weight, rise", long=True),
        _case("capillary-rise", "Liquid that rises between plates over time, beside Bosanquet's equation", long=True),
        _case("sliding-drops", "Drops that slide down a plate: speeds, drag and shape beside theory", long=True),
        _case(
            "drops-in-space", "Balls of liquid: swinging, fading, pressure inside", long=True, place="drops:ball_rows"
        ),
        _case(
            "settling",
            "Grains in water: terminal speeds, diffusion, and the equilibrium of both",
            place="tracers:settling_rows",
        ),
        _case(
            "tracers-flows",
            "Tracers in flows: dispersion, walls, settling layers, vortices, impaction, deposition, lift",
            long=True,
        ),
        _case("meeting", "When two floats released at rest meet, against SciPy's DOP853", place="floats:meeting_rows"),
        _case(
            "raft",
            "Nineteen floats gather to a raft: overlap, energy, momentum at two steps",
            long=True,
            place="floats:raft_rows",
        ),
        _case("hydrodynamics", "Floats that move one another by the flow: rafts, pairs, diffusion, thermal weights"),
        _case(
            "activity",
            "Active floats: mean squared displacement of persistent and of circling motion",
            place="driven_floats:activity_rows",
        ),
        _case(
            "swimmers",
            "Three beads that swim in an oscillating magnetic field, beside the closed form",
            long=True,
            place="driven_floats:swimmer_rows",
        ),
        _case(
            "waves",
            "Floats that radiate waves: dispersion, bound surfers, spinners beside measured phases",
            place="driven_floats:wave_rows",
        ),
        _case(
            "surfactant",
            "Camphor discs: speeds and bound pairs beside closed forms, exponent of the speed beside a measured one",
            place="surfactant:surfactant_rows",
        ),
        _case(
            "barrier",
            "Floats in front of a moving barrier: forces, work, friction of the walls beside them, beside closed forms",
            place="barriers:rows",
        ),
        _case("chains", "Chains of three rough spheres: friction that keeps them bent, beside closed forms"),
        _case(
            "clusters",
            "Six small spheres: weights of rigid clusters with and without menisci, entropy production",
            long=True,
        ),
        _case(
            "hard-discs",
            "Brownian hard discs: pair distribution, pressure, walls, bound pairs, beside Monte Carlo",
            long=True,
        ),
        _case(
            "walls", "How floats leave and climb the wall of a dish, against SciPy's DOP853", place="floats:wall_rows"
        ),
        _case(
            "integrators",
            "The orders of the integrators, and the energy over a million steps",
            place="floats:integrator_rows",
        ),
        _case(
            "two-spheres", "Two soft spheres opening and closing, against the closed form", place="spheres:pair_rows"
        ),
        _case("t1", "Four soft spheres that swap neighbors, against an independent solution", place="spheres:t1_rows"),
        _case(
            "packing",
            "Soft packings sheared to a strain of 10: balance, pressure, stress",
            long=True,
            place="spheres:packing_rows",
        ),
        _case("rheology", "A soft packing above jamming: its flow curve over three decades, in pieces", long=True),
        _case("soft-glasses", "A packing with elastohydrodynamic films: the exponent of its flow curve", long=True),
        _case("suspensions", "Nearly rigid spheres: friction, jamming and thickening, beside fits", long=True),
        _case(
            "permeation",
            "Liquid that permeates packings: Terzaghi's consolidation, late and early starts under stress",
            long=True,
        ),
        _case("tank", "A tank at rest, out of order at the start: pressure, level, speed, creep", long=True),
        _case("tank-schemes", "The tank at rest with other walls and kernels: what holds, what fails", long=True),
        _case("random-tanks", "Still water beside discs, balls and slanted surfaces in random tanks", long=True),
        _case("dam-break", "Dam breaks, against other codes' fronts and pressures and three experiments", long=True),
        _case("rolling-tank", "Impacts of water in a tank that rolls, beside an experiment (SPHERIC 10)", long=True),
        _case("dam-break-obstacle", "A dam break in 3D against a box, beside an experiment", long=True),
        _case(
            "incompressible",
            "Liquids without sound waves: rest, vortices, a dam break, beside tait",
            long=True,
        ),
        _case("two-liquids", "Two liquids: rest, waves, Rayleigh-Taylor, a rising bubble beside a grid", long=True),
        _case("standing-wave", "How fast a wave in a viscous liquid swings and dies, against exact roots", long=True),
        _case("sloshing", "How a tank that is shaken a little rises at its walls, against potential flow", long=True),
        _case(
            "taylor-green",
            "Vortices that fade, against the exact flow and another package",
            long=True,
            place="full_tanks:vortex_rows",
        ),
        _case(
            "poiseuille",
            "Channels that start, by a pull and by a plate, against their series",
            long=True,
            place="full_tanks:channel_rows",
        ),
        _case(
            "cavity", "A square driven by its lid, against corrected tables", long=True, place="full_tanks:cavity_rows"
        ),
        _case(
            "patch",
            "A spinning square of liquid: negative pressure, held together by shifting",
            place="full_tanks:patch_rows",
        ),
        _case(
            "drops",
            "Drops that are stretched and that swing, against exact motions",
            long=True,
            place="drops:drop_rows",
        ),
        _case(
            "fitting", "Parameters from noisy tracks: how often 95 % intervals hold the truth, in 100 fits", long=True
        ),
        _case("rest", "Sixty pieces of cereal come to rest within ten minutes, in milk and in syrup", long=True),
    )
}
