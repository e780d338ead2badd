"""A scene moves in the same way in any units of mass, length and time: no law holds a constant with a dimension.

Every number of a scene is rescaled by its unit. Scales are powers of two, so that hardly a bit changes by rounding.
"""

from __future__ import annotations

import itertools
import math
from functools import cache
from typing import Any, NamedTuple

import numpy as np
import pint
import pytest
from tests.torture.regression import SCENES as EXAMPLES

from ecume.models import MODELS
from ecume.models.model import CROWDED, DONE, EXCHANGE
from ecume.scenes.load import load_scene
from ecume.scenes.schema import from_plain, to_plain, unit_of

pytestmark = pytest.mark.compiled


class Scales(NamedTuple):
    """The factors of numbers that measure mass, length and time."""

    mass: float
    length: float
    time: float

    def of(self, dimension: tuple[float, float, float, float, float]) -> float:
        """The factor of a quantity with these powers of mass, length, time, temperature and current. Boltzmann's
        constant and the permeability of the vacuum are not scaled.
        """
        mass, length, time, temperature, current = dimension
        energy = self.mass * self.length**2 / self.time**2
        ampere = math.sqrt(energy / self.length)
        return self.mass**mass * self.length**length * self.time**time * energy**temperature * ampere**current


HEAVIER, LARGER = Scales(mass=8.0, length=1.0, time=1.0), Scales(mass=64.0, length=4.0, time=8.0)
"""The second keeps densities."""

LONG = {"docking-quadrupoles", "ellipsoids-docking", "pattern-formation", "settling-packing"}
"""Compile time steps that no other test needs."""


@cache
def powers(symbol: str) -> tuple[float, float, float, float, float]:
    """The powers of mass, length, time, temperature and current in a unit."""
    found = pint.application_registry.Quantity(1.0, symbol).dimensionality
    return tuple(float(found[f"[{name}]"]) for name in ("mass", "length", "time", "temperature", "current"))  # type: ignore[return-value]


def rescaled(plain: dict[str, Any], value: Any, scales: Scales, path: tuple[Any, ...] = ()) -> Any:
    """The scene in other units."""
    if isinstance(value, dict):
        return {key: rescaled(plain, each, scales, (*path, key)) for key, each in value.items()}
    if isinstance(value, list | tuple):
        return [rescaled(plain, each, scales, (*path, index)) for index, each in enumerate(value)]
    if isinstance(value, float):
        return value * scales.of(powers(unit_of(plain, path)))
    return value


def moved(scene: Any, steps: int) -> Any:
    """The frame after some steps."""
    model = MODELS[scene.model]
    parameters = model.parameters(scene)
    state = model.start(scene, parameters)
    room, workspace = 1.0, model.workspace(parameters, state, 1.0)
    while int(state.step[0]) < steps:
        status = model.advance(parameters, state, workspace, steps - int(state.step[0]))
        assert status in (DONE, EXCHANGE, CROWDED)
        if status == EXCHANGE:
            state = model.exchange(parameters, state)
        room *= 2.0 if status == CROWDED else 1.0
        workspace = model.workspace(parameters, state, room)
    return model.observe(parameters, state, workspace)


WITHIN = {"floating": 1e-9, "sph": 1e-9, "tracers": 1e-9, "soft": 1e-6}
"""Of the largest. Soft spheres are integrated to a tolerance of 1e-5: an iteration that rounding ends earlier shows."""
WATER = {"name": "", "density": 998.2, "viscosity": 1.0016e-3}


def explicit(plain: dict[str, Any]) -> dict[str, Any]:
    """The scene without properties that come from a table of liquids, or from defaults that are numbers."""
    liquid = plain["liquid"]
    if liquid.get("name"):
        liquid |= {key: value for key, value in WATER.items() if key in liquid}
    if plain["model"] == "sph" and liquid["density"] is None:
        liquid["density"] = 1000.0
    return plain


def compare(name: str, scales: Scales, steps: int = 12) -> None:
    plain = explicit(to_plain(load_scene(EXAMPLES[name])))
    one = moved(from_plain(plain), steps)
    other = moved(from_plain(rescaled(plain, plain, scales)), steps)
    dimensions = {"position": (0, 1, 0, 0, 0), "velocity": (0, 1, -1, 0, 0)}
    for array, dimension in dimensions.items():
        if array in one.arrays:
            expected = scales.of(dimension) * one.arrays[array]
            size = np.abs(expected).max()
            atol = WITHIN[plain["model"]] * size
            np.testing.assert_allclose(other.arrays[array], expected, rtol=0, atol=atol, err_msg=array)
    assert other.time == pytest.approx(scales.time * one.time, rel=WITHIN[plain["model"]])


@pytest.mark.sampled(3)
@pytest.mark.parametrize(
    ("name", "scales"),
    [
        pytest.param(name, scales, marks=[pytest.mark.long] * (name in LONG))
        for name, scales in itertools.product(sorted(EXAMPLES), (HEAVIER, LARGER))
    ],
)
def test_an_example_moves_in_the_same_way_in_other_units(name, scales):
    compare(name, scales)
