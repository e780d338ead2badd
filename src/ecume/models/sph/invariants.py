"""What a liquid must not lose: mass, and energy that nobody brings; and how far it may be squeezed."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator

import numpy as np

from ecume.models.invariants import Invariant, Seen, at_most, energy_never_rises, kept, part_of
from ecume.models.sph.parameters import Parameters
from ecume.scenes.sph import SphScene
from ecume.scenes.sph.tank import SIDES

SQUEEZED = 0.2
"""The largest change of density that a weakly compressible liquid may have: one of 1 % is meant."""
RISE = 0.02
"""Of the energy: densities that are diffused and particles that are shifted bring a little."""
TURNED_BACK = 1e-3
"""Hits of the guard, a particle and step."""
FAINT = 0.05
"""Of the speed that is expected: what goes so slowly in a shaken tank has no more energy than layers lose and gain as
they settle.
"""
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
    if not _driven(scene):
        yield energy_never_rises(RISE, _faint(parameters)) if scene.shake is not None else energy_never_rises(RISE)
    if _alone(scene):
        density = parameters.material.density

        def momenta(seen: Seen) -> float:
            return math.sqrt(2.0 * density * seen.first["volume"] * seen.largest["kinetic_energy"])

        yield kept("momentum", ("momentum_x", "momentum_y", "momentum_z"), momenta, DRIFT)


def _faint(parameters: Parameters) -> Callable[[Seen], float]:
    """The energy of a faint motion: a tank that has been shaken for a moment has less, and settles."""
    material = parameters.material
    speed = FAINT * material.fastest
    return lambda seen: 0.5 * material.density * seen.first["volume"] * speed**2


def _kinds(scene: SphScene) -> list[str]:
    """What each side of the tank is."""
    return [getattr(scene.tank, side).kind for side in SIDES[: 2 * len(scene.tank.low)]]


def _driven(scene: SphScene) -> bool:
    """Whether anything does work on the liquid that nobody books; that of a shake is booked, see `power_of_shake`."""
    sides = [getattr(scene.tank, side) for side in SIDES]
    flowing = any(kind in ("inflow", "outflow") for kind in _kinds(scene))
    around = any(
        kind == "periodic" and (scene.gravity or ())[number // 2] != 0.0 for number, kind in enumerate(_kinds(scene))
    )
    hidden = scene.method.surface_tension_model == "cohesion" or scene.method.pressure_split == "original"
    moved = any(side.motion is not None or side.velocity is not None for side in sides)
    return bool(flowing or around or hidden or moved or scene.bodies)


def _alone(scene: SphScene) -> bool:
    """Whether nothing but liquid acts on the liquid."""
    around = all(kind == "periodic" for kind in _kinds(scene))
    pulled = bool(np.any(scene.gravity)) or scene.central_pull is not None
    return around and not (pulled or scene.bodies or scene.obstacles)
