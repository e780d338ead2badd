"""Chains of rough floats that keep their shape or close: the case `chains`."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator
from typing import Any

import numpy as np

from ecume.laws.friction import holding_rolling_friction
from ecume.models.floating.forces.pair_forces import law_of, row_of, two_floats
from ecume.models.floating.setup.scene_parameters import parameters_of
from ecume.scenes.floating import FloatingScene
from ecume.scenes.schema import from_plain
from ecume.simulation import simulate
from ecume.trajectories.frame import Frame
from ecume.units import Angle, Length, Number, Time
from ecume_validation.runner import Row, within

RADIUS: Length = 1e-3
BENDS = (1.3, 2.0, 2.8)
ROUGH = 1.5
"""A coefficient of friction at which no chain slides."""
MOVED = 1e-6
"""rad: an end that moves less has held."""
HALVINGS = 5


def rows() -> list[Row]:
    """Compare thresholds, and the ends of chains after a minute."""
    return [*thresholds(), *one_minute()]


def chain(bend: Angle, rolling: Number, friction: Number = ROUGH, duration: Time = 0.5) -> FloatingScene:
    """Three spheres in contact at rest; `bend` is the angle at the middle one."""
    apart = 2.0 * RADIUS * (1.0 + 1e-7)
    ends: list[Any] = [[apart * math.cos(0.5 * bend), side * apart * math.sin(0.5 * bend)] for side in (1.0, -1.0)]
    scene = from_plain({
        "model": "floating", "duration": duration, "frame_every": duration,
        "liquid": {"density": 1000.0, "viscosity": 0.01, "surface_tension": 0.0728},
        "particles": [{"radius": RADIUS, "density": 1300.0, "contact_angle": 0.5 * math.pi,
                       "positions": [ends[0], [0.0, 0.0], ends[1]]}],
        "contacts": {"friction": friction, "rolling_friction": rolling}, "hydrodynamics": {"drag": "stokes"},
    })  # fmt: skip
    assert isinstance(scene, FloatingScene)  # noqa: S101  # its model is that
    return scene


def bend_after(bend: Angle, rolling: Number, friction: Number = ROUGH) -> Angle:
    """The angle at the sphere in the middle after half a second."""
    *_, last = simulate(chain(bend, rolling, friction))
    one, other = (last.arrays["position"][k] - last.arrays["position"][1] for k in (0, 2))
    return math.acos(float(one @ other) / math.sqrt(float(one @ one) * float(other @ other)))


def holding_coefficient(bend: Angle) -> Number:
    """The coefficient of rolling friction above which the chain keeps its shape, in closed form."""
    parameters = parameters_of(chain(bend, 1.0))
    charge = float(parameters.floats.charge[0])
    pair, law = two_floats(parameters, (RADIUS, RADIUS), (charge, charge)), law_of(parameters)
    pulls = [-float(row_of(parameters).force(far * RADIUS, pair, law)) for far in (2.0, 4.0 * math.sin(0.5 * bend))]
    return holding_rolling_friction(bend, *pulls)


def threshold(closes: Callable[[float], bool], expected: float) -> float:
    """The coefficient below which a chain closes, by bisection between 0.9 and 1.1 times the expected value."""
    low, high = 0.9 * expected, 1.1 * expected
    for _ in range(HALVINGS):
        middle = 0.5 * (low + high)
        low, high = (middle, high) if closes(middle) else (low, middle)
    return 0.5 * (low + high)


def thresholds() -> Iterator[Row]:
    """Coefficients above which simulated chains keep their shape, over those in closed form."""
    for bend in BENDS:
        expected = holding_coefficient(bend)
        found = threshold(lambda rolling, bend=bend: bend_after(bend, rolling) < bend - MOVED, expected)  # type: ignore[misc]
        name = f"{math.degrees(bend):.0f} degrees: coefficient of rolling friction that holds, over the closed form"
        yield within(name, found / expected, 1.0, 0.01)
    bend, expected = BENDS[1], 0.5 * holding_coefficient(BENDS[1])
    found = threshold(lambda friction: bend_after(bend, 3.0, friction) < bend - MOVED, expected)
    name = f"{math.degrees(bend):.0f} degrees: coefficient of friction that holds, over the closed form"
    yield within(name, found / expected, 1.0, 0.01)


def one_minute() -> Iterator[Row]:
    """The distance of the ends after 60 s, in radii."""
    for name, rolling, expected in (("without", 0.0, 2.0), ("with", 0.4, 4.0 * math.sin(0.5 * BENDS[1]))):
        *_, last = simulate(chain(BENDS[1], rolling, duration=60.0))
        yield within(f"60 s {name} rolling friction: distance of the ends, in radii", _ends(last), expected, 1e-3)


def _ends(frame: Frame) -> float:
    position = frame.arrays["position"]
    return float(np.linalg.norm(position[0] - position[2])) / RADIUS
