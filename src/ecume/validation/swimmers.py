"""Three spheres that swim in an oscillating magnetic field: direction, reversal and speed."""

from __future__ import annotations

import math
from collections.abc import Iterator
from typing import Any

import numpy as np

from ecume.models import MODELS
from ecume.scenes.schema import from_plain
from ecume.simulation import simulate
from ecume.units import Array, Length
from ecume.validation.rows import Row, above, below, within

RADII = (2.0e-4, 2.5e-4, 3.0e-4)
PLACES = ((-1.2e-3, 0.0), (0.0, 0.0), (1.3e-3, 0.0))
SIDE = 1.4e-3
"""Of the triangle at the start (m)."""
FREQUENCY, PERIODS, PER_PERIOD = 0.2, 6, 200
"""Of the field (Hz); the swimmer is followed for so many periods, with so many frames each."""
STEP = 2.5e-5
TOLERANCE = 0.2


def rows() -> list[Row]:
    """Rows of spheres, then triangles."""
    return [*in_a_row(), *triangles()]


def scene_of(radii: tuple[float, ...], places: Any, *, interaction: str = "rotne-prager") -> dict[str, Any]:
    """Steel spheres on a viscous liquid in a vertical field, and a horizontal one that oscillates."""
    spheres = [
        {"radius": radius, "density": 7830.0, "contact_angle": 0.5 * math.pi, "positions": [list(place)]}
        for radius, place in zip(radii, places, strict=True)
    ]
    return {
        "model": "floating", "duration": PERIODS / FREQUENCY, "frame_every": 1.0 / (FREQUENCY * PER_PERIOD),
        "liquid": {"density": 1000.0, "viscosity": 0.05, "surface_tension": 0.0728}, "particles": spheres,
        "integration": {"integrator": "overdamped", "time_step": STEP},
        "hydrodynamics": {"interaction": interaction},
        "magnetic_field": {"constant": [1e-3, 0.0, 4e-3], "amplitude": [1e-3, 0.0, 0.0],
                           "frequency": FREQUENCY, "susceptibility": 1e6},
    }  # fmt: skip


def motion(scene: dict[str, Any]) -> Array:
    """The positions (frames, 3, 2) of a run."""
    return np.array([frame.arrays["position"] for frame in simulate(from_plain(scene))])


def friction_of(scene: dict[str, Any]) -> Array:
    """The drag of each sphere, over that of the first."""
    floats = MODELS["floating"].parameters(from_plain(scene)).floats
    friction = floats.mass / floats.relaxation_time
    return np.asarray(friction / friction[0])


def stroke(track: Array, friction: Array) -> Array:
    """The displacement (m) in the last period, of the center weighted by drag."""
    center = (friction[:, None] * track).sum(axis=1) / friction.sum()
    return np.asarray(center[-1] - center[-1 - PER_PERIOD])


def closed_form(track: Array, size: Array) -> Length:
    """The displacement of three spheres in a row in one period, by the area of the loop of their distances:
    K times half the integral of L_1 dL_2 - L_2 dL_1, with
    K = 3 a_1 a_2 a_3/(a_1 + a_2 + a_3)^2 [1/L_1^2 + 1/L_2^2 - 1/(L_1 + L_2)^2]. [golestanian2008].
    """
    one, two = np.diff(track[-1 - PER_PERIOD :, :, 0], axis=1).T
    area = 0.5 * float(np.sum(one[:-1] * np.diff(two) - two[:-1] * np.diff(one)))
    first, second = float(one[:-1].mean()), float(two[:-1].mean())
    near = 1.0 / first**2 + 1.0 / second**2 - 1.0 / (first + second) ** 2
    return 3.0 * float(np.prod(size)) / float(np.sum(size)) ** 2 * near * area


def in_a_row() -> Iterator[Row]:
    """The displacement in a period, its sign, and what has none."""
    scene = scene_of(RADII, PLACES)
    friction = friction_of(scene)
    track = motion(scene)
    found = float(stroke(track, friction)[0])
    expected = closed_form(track, RADII[0] * friction)
    yield within("in a row: displacement per period, over the closed form", found / expected, 1.0, TOLERANCE)
    yield above("in a row: displacement toward the smallest sphere (um)", -1e6 * found, 0.5)
    mirrored = scene_of(RADII[::-1], [(-x, y) for x, y in PLACES[::-1]])
    turned = float(stroke(motion(mirrored), friction[::-1])[0])
    yield within("in the reverse order: displacement over that before", turned / found, -1.0, 1e-3)
    equal = scene_of((RADII[1],) * 3, [(-1.25e-3, 0.0), (0.0, 0.0), (1.25e-3, 0.0)])
    still = float(stroke(motion(equal), np.ones(3))[0])
    yield below("equal spheres: displacement over that of unequal ones", abs(still / found), 1e-6)
    alone = float(stroke(motion(scene_of(RADII, PLACES, interaction="none")), friction)[0])
    yield below("without hydrodynamic interaction: displacement over that with it", abs(alone / found), 1e-6)


def triangles() -> Iterator[Row]:
    """Three equal spheres with one side along the field, and upside down."""
    low, high = 0.5 * SIDE / math.sqrt(3.0), SIDE / math.sqrt(3.0)
    found = {}
    for up in (1.0, -1.0):
        places = [(-0.5 * SIDE, -up * low), (0.5 * SIDE, -up * low), (0.0, up * high)]
        found[up] = stroke(motion(scene_of((RADII[1],) * 3, places)), np.ones(3))
    across = float(found[1.0][1])
    yield above("triangle: displacement per period toward the apex (nm)", 1e9 * across, 1.0)
    yield below("triangle: displacement along the field, over that across it", abs(float(found[1.0][0]) / across), 1e-3)
    yield within(
        "triangle turned by 180 degrees: displacement over that before", float(found[-1.0][1]) / across, -1.0, 1e-3
    )
