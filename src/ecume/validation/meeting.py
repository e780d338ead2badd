"""The time at which two floats released at rest touch, beside an integration of order 8."""

from __future__ import annotations

import math

import numpy as np

from ecume.models.liquids import liquid_of
from ecume.scenes.floating import FloatingScene
from ecume.simulation import simulate
from ecume.validation import float_motion
from ecume.validation.rows import Row, within
from ecume.validation.runner import floating_scene

SIZES = ((1.0, 1.0), (0.6, 0.6), (1.0, 0.6))
"""Radii of both, mm."""
DISTANCES = (4.0, 6.0, 9.0)
"""Of the centers at the start, mm."""
TOLERANCE = 1e-3
"""Over the expected time."""
FRAMES = 400
"""Until they should meet; they get a tenth more."""


def rows() -> list[Row]:
    """The time of meeting for each pair, distance and with or without drag."""
    return [meeting(sizes, distance, drag=drag) for drag in (False, True) for sizes in SIZES for distance in DISTANCES]


def meeting(sizes: tuple[float, float], distance: float, *, drag: bool) -> Row:
    """One pair's time of meeting, in seconds."""
    scene = _scene(sizes, distance, drag, 1.0)
    expected = float_motion.meeting_time(float_motion.bodies_of(scene), 1e-3 * distance, liquid_of(scene))
    computed = _met_after(_scene(sizes, distance, drag, expected / FRAMES))
    name = f"R = {sizes[0]:g} and {sizes[1]:g} mm, {distance:g} mm apart, {'drag' if drag else 'no drag'}: time (s)"
    return within(name, computed, expected, TOLERANCE * expected)


def _scene(sizes: tuple[float, float], distance: float, drag: bool, frame_every: float) -> FloatingScene:
    return floating_scene(
        "meeting",
        [
            *(f"particles[{k}].radius={size} mm" for k, size in enumerate(sizes)),
            f"particles[1].positions=[[{1e-3 * distance}, 0.0]]",
            f"hydrodynamics.drag={'stokes' if drag else 'none'}",
            f"frame_every={frame_every!r}",
            f"duration={1.1 * FRAMES * frame_every!r}",
        ],
    )


def _met_after(scene: FloatingScene) -> float:
    """The moment of touching, from the last frame in which a gap is open; infinite when they do not meet."""
    reach = sum(given.radius for given in scene.particles)
    touching = math.inf
    for frame in simulate(scene):
        gap = float(np.diff(frame.arrays["position"][:, 0])[0]) - reach
        closing = -float(np.diff(frame.arrays["velocity"][:, 0])[0])
        if gap <= 0.0 or (closing <= 0.0 and frame.time > 0.0):
            return touching
        touching = frame.time + gap / closing if closing else math.inf
    return math.inf
