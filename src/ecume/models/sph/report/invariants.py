"""Invariants of a tank: mass, energy minus work, momentum of isolated liquid; and the limit of compression."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator

import numpy as np

from ecume.models.invariants import Invariant, Seen, at_most, energy_never_rises, kept, part_of
from ecume.models.sph.parameters import Parameters
from ecume.models.sph.report.energy_budget import has_unbudgeted_work
from ecume.scenes.sph import SphScene
from ecume.scenes.sph.tank import SIDES

SQUEEZED = 0.2
"""The largest change of density that a weakly compressible liquid may have: one of 1 % is meant."""
RISE = 0.02
"""Of the energy: densities that are diffused and particles that are shifted bring a little."""
TURNED_BACK = 1e-3
"""Hits of the guard, a particle and step."""
FAINT = 0.05
"""Of the speed that is expected: what goes so slowly has no more energy than layers lose and gain as they settle."""
DRIFT = 1e-6
"""Of momentum."""


def invariants(scene: SphScene, parameters: Parameters) -> list[Invariant]:
    """The rows of a scene."""
    return list(_rows(scene, parameters))


def _rows(scene: SphScene, parameters: Parameters) -> Iterator[Invariant]:
    volume = scene.spacing ** len(scene.tank.low)
    yield at_most("mass", "particles that are lost", "lost", 0.0)
    yield at_most("density", "its largest change, over the density at rest", "density_change", SQUEEZED)

    def turned_back(seen: Seen) -> float:
        return part_of(seen.now["guard_hits"] * volume, seen.first["volume"] * max(seen.now["step"], 1.0))

    yield Invariant("guard", "particles turned back behind a wall, a particle and step", TURNED_BACK, turned_back)
    if not has_unbudgeted_work(parameters):
        yield energy_never_rises(RISE, _faint(parameters))
    if _alone(scene):
        density = parameters.material.density

        def momenta(seen: Seen) -> float:
            return math.sqrt(2.0 * density * seen.first["volume"] * seen.largest["kinetic_energy"])

        yield kept("momentum", ("momentum_x", "momentum_y", "momentum_z"), momenta, DRIFT)


def _faint(parameters: Parameters) -> Callable[[Seen], float]:
    """The energy of a faint motion, and of a weight that is lifted by a particle's size: a liquid at rest moves by some
    hundredths of that while its layers settle.
    """
    material = parameters.material
    pull = float(np.linalg.norm(parameters.gravity))
    each = material.density * (0.5 * (FAINT * material.fastest) ** 2 + pull * parameters.spacing)
    return lambda seen: each * seen.first["volume"]


def _kinds(scene: SphScene) -> list[str]:
    """The kind of each side of the tank."""
    return [getattr(scene.tank, side).kind for side in SIDES[: 2 * len(scene.tank.low)]]


def _alone(scene: SphScene) -> bool:
    """Whether no external force acts on the liquid."""
    around = all(kind == "periodic" for kind in _kinds(scene))
    pulled = bool(np.any(scene.gravity)) or scene.central_force is not None
    return around and not (pulled or scene.bodies or scene.obstacles)
