"""The motion of floats, integrated by SciPy: the same force laws as in the runs, everything else by other means.

Charge and friction of a float come from ecume's own laws (the case `floating` and the tests judge those). Bessel
functions, the amplitude at the wall and the integration of the motion are SciPy's, or written down here.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any, NamedTuple

import numpy as np
from scipy.integrate import solve_ivp
from scipy.special import i1, k1

from ecume.laws import drag, flotation
from ecume.models.liquids import liquid_of
from ecume.scenes.floating import FloatingScene
from ecume.units import Array

ACCURACY = 1e-12
"""Relative, of the reference."""
LONGEST = 1e4
"""s; whatever is waited for comes before."""


class Body(NamedTuple):
    """A float as a point that is pulled and slowed."""

    radius: float
    mass: float
    charge: float
    friction: float


def bodies_of(scene: FloatingScene) -> list[Body]:
    """The scene's floats, a body for each of its tables, on which drag acts if the scene says so."""
    liquid, bodies = liquid_of(scene), []
    for given in scene.particles:
        assert isinstance(given.contact_angle, float)  # noqa: S101  # the cases' scenes have numbers
        sphere = flotation.Sphere(given.radius, given.density, given.contact_angle)
        balance = flotation.equilibrium(sphere, liquid)
        factor = float(drag.factor_at_filling(balance.filling_angle))
        friction = 6.0 * math.pi * liquid.viscosity * given.radius * factor if scene.hydrodynamics.resists else 0.0
        mass = given.density * 4.0 / 3.0 * math.pi * given.radius**3
        bodies.append(Body(given.radius, mass, balance.charge, friction))
    return bodies


def meeting_time(bodies: Sequence[Body], distance: float, liquid: flotation.Liquid) -> float:
    """The time at which two bodies touch that are released at rest with their centers a distance apart (s)."""
    one, other = bodies
    length, tension = liquid.capillary_length, liquid.surface_tension
    strength = 2.0 * math.pi * tension * one.charge * other.charge / length

    def rate(_: float, y: Array) -> list[float]:
        pull = strength * float(k1((y[1] - y[0]) / length))
        return [y[2], y[3], (pull - one.friction * y[2]) / one.mass, (-pull - other.friction * y[3]) / other.mass]

    def gap(_: float, y: Array) -> float:
        return float(y[1] - y[0]) - one.radius - other.radius

    gap.terminal = True  # type: ignore[attr-defined]  # SciPy's way to stop there
    start = [0.0, distance, 0.0, 0.0]
    found: Any = solve_ivp(rate, (0.0, LONGEST), start, "DOP853", events=gap, rtol=ACCURACY, atol=1e-14)
    return float(found.t_events[0][0])


class Bowl(NamedTuple):
    """A round dish and its liquid."""

    radius: float
    contact_angle: float
    liquid: flotation.Liquid


def place_in_bowl(body: Body, start: float, time: float, bowl: Bowl) -> float:
    """The distance from the axis of a body that was released at rest at the distance `start` from it (m)."""
    return float(_way_in_bowl(body, start, time, bowl).y[0, -1])


def time_in_bowl(body: Body, start: float, way: float, bowl: Bowl) -> float:
    """The time after which a body released at rest at the distance `start` has moved by `way` (s)."""

    def gone(_: float, y: Array) -> float:
        return abs(float(y[0]) - start) - way

    gone.terminal = True  # type: ignore[attr-defined]  # SciPy's way to stop there
    return float(_way_in_bowl(body, start, LONGEST, bowl, gone).t_events[0][0])


def _way_in_bowl(body: Body, start: float, time: float, bowl: Bowl, event: Any = None) -> Any:
    """The meniscus is A_w I0(r/L) / I1(a/L), with the amplitude of the exact plane meniscus."""
    length, tension = bowl.liquid.capillary_length, bowl.liquid.surface_tension
    amplitude = length * _amplitude_over_length(bowl.contact_angle)
    strength = 2.0 * math.pi * tension * body.charge * amplitude / length / float(i1(bowl.radius / length))

    def rate(_: float, y: Array) -> list[float]:
        return [y[1], (-strength * float(i1(y[0] / length)) - body.friction * y[1]) / body.mass]

    return solve_ivp(
        rate, (0.0, time), [start, 0.0], "DOP853", events=event, rtol=ACCURACY, atol=1e-4 * ACCURACY * start
    )


def _amplitude_over_length(contact_angle: float) -> float:
    """The tail of the exact plane profile x = arcosh(2/h) - arcosh(2/h0) + sqrt(4 - h0^2) - sqrt(4 - h^2), where
    arcosh(2/h) becomes ln(4/h); h0 is the height at the wall. [landau1987, par. 61].
    """
    height = math.sqrt(2.0 * (1.0 - math.sin(contact_angle)))
    tail = 4.0 * math.exp(-float(np.arccosh(2.0 / height)) + math.sqrt(4.0 - height**2) - 2.0)
    return math.copysign(tail, math.cos(contact_angle))
