"""Drops that slide down a plate, in 2D: their speed, their shape, and the force on the plate."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from ecume.scenes.sph import SphScene
from ecume.simulation import simulate
from ecume.trajectories.frame import Frame
from ecume_validation.contact_lines import SLIP, line_friction
from ecume_validation.runner import Row, sph_scene, within

LASTS = {60: "40 ms", 90: "40 ms", 120: "80 ms"}
"""Contact angles (degrees), and how long it takes drops to slide steadily."""
LATE = 0.75
"""The share of the time after which a drop slides steadily."""
FITTED = 90
"""The angle whose drag the slip length is from."""


class Slide(NamedTuple):
    """Means over the last quarter of a run."""

    speed: float
    """of the center (m/s)"""
    force: float
    """of the liquid on the plate, along it (N/m)"""
    weight: float
    """its part along the plate (N/m)"""
    center: float
    """the height of the center (m)"""


class Wedge(NamedTuple):
    """A drop at rest: a segment of a circle; and the drag of its two wedges."""

    center: float
    """the height of its center (m)"""
    drag: float
    """over viscosity and speed"""


def rows() -> list[Row]:
    """Compare drops of three angles, of twice the weight, of twice the viscosity, and on a plate that moves."""
    slides = {angle: slide([f"liquid.contact_angle={angle} deg", f"duration={LASTS[angle]}"]) for angle in LASTS}
    own = slides[FITTED]
    heavy, viscous = slide(["gravity=[8.0, 0.0]"]), slide(["liquid.viscosity=40 mPa*s"])
    held = slide([f"tank.bottom={{velocity=[{-own.speed!r}, 0.0]}}"])
    viscosity = sph_scene("sliding_drops").liquid.viscosity or math.nan
    return [
        *(row for angle, one in slides.items() for row in rows_of(angle, one, viscosity)),
        within("twice the weight: speed over that of the first", heavy.speed / own.speed, 2.0, 0.1),
        within("twice the viscosity: speed over that of the first", viscous.speed / own.speed, 0.5, 0.025),
        within("a plate that moves up: speed over that of the plate", held.speed / own.speed, 0.0, 0.02),
    ]


def rows_of(angle: int, found: Slide, viscosity: float) -> list[Row]:
    """Rows on a drop of a contact angle (degrees)."""
    name, wedge = f"{angle} degrees", wedge_of(math.radians(angle), sph_scene("sliding_drops"))
    drag = found.force / (viscosity * found.speed)
    return [
        within(f"{name}: force on the plate over the weight along it", found.force / found.weight, 1.0, 0.05),
        within(f"{name}: height of the center over that at rest", found.center / wedge.center, 1.0, 0.05),
        *([within(f"{name}: drag over viscosity and speed", drag, wedge.drag, 0.1 * wedge.drag)] * (angle != FITTED)),
    ]


def wedge_of(angle: float, scene: SphScene) -> Wedge:
    """The segment of a circle with the area of the drop, and the drag of wedges half as long as its base."""
    (block,) = scene.fluid
    area = math.prod(high - low for low, high in zip(block.low or (), block.high or (), strict=True))
    radius = math.sqrt(area / (angle - math.sin(angle) * math.cos(angle)))
    half = radius * math.sin(angle)
    center = 2.0 / 3.0 * half**3 / area - radius * math.cos(angle)
    return Wedge(center, 2.0 * line_friction(angle, half, SLIP * scene.spacing))


def slide(changes: Sequence[str]) -> Slide:
    """Run the scene of the case with changes."""
    scene = sph_scene("sliding_drops", changes)
    pull = (scene.gravity or (math.nan,))[0]
    late = [_of(frame, pull) for frame in simulate(scene) if frame.time > LATE * scene.duration]
    return Slide(*(float(mean) for mean in np.mean(late, axis=0)))


def _of(frame: Frame, pull: float) -> Slide:
    mass = frame.arrays["mass"]
    speed = mass @ frame.arrays["velocity"][:, 0] / mass.sum()
    center = mass @ frame.arrays["position"][:, 1] / mass.sum()
    return Slide(float(speed), frame.numbers["bottom_force_x"], pull * float(mass.sum()), float(center))
