"""Two soft spheres, pulled apart and pressed together: the simulation against the closed forms."""

from __future__ import annotations

import math
from collections.abc import Iterator

from ecume.laws.soft_pair import SoftPair, passage_time
from ecume.models.soft.setup import prefactors_of
from ecume.scenes.soft import FilmSpec, IntegrationSpec, SoftLiquid, SoftScene, SphereSpec
from ecume.simulation import simulate
from ecume.validation.rows import Row, within

FORCES = (1e-6, 1e-4, 1e-3, 1e-2)
"""In E R^2."""
PASSAGES = ((1e-2, 1e-1), (1e-3, 1.0), (1e-2, 1e-3))
"""Gaps in R, opening and closing."""
TOLERANCE = 1e-6


def rows() -> list[Row]:
    """The gap at the time that the closed form says."""
    return [*passages("paper"), *passages("physical")]


def passages(prefactors: str) -> Iterator[Row]:
    """Rigid to soft, opening and closing."""
    for force in FORCES:
        for begin, end in PASSAGES:
            name = f"{prefactors}, F = {force:g} E R^2, from {begin:g} R: gap (R)"
            yield within(name, _end(begin, end, force, prefactors), end, TOLERANCE * end)


def _end(begin: float, end: float, force: float, prefactors: str) -> float:
    """The simulated gap when it should be `end`."""
    films = FilmSpec(prefactors=prefactors)
    pull = math.copysign(force, end - begin)
    time = passage_time(SoftPair(1.0, 1.0, force, prefactors_of(films)), pull, begin, end)
    scene = SoftScene(
        duration=time,
        frame_every=time,
        liquid=SoftLiquid(viscosity=force),
        particles=tuple(
            SphereSpec(radius=1.0, modulus=1.0, positions=((side * (1.0 + begin / 2), 0.0),), force=(side * pull, 0.0))
            for side in (-1.0, 1.0)
        ),
        films=films,
        integration=IntegrationSpec(tolerance=1e-10),
    )
    (*_, last) = simulate(scene)
    return last.numbers["smallest_gap"]
