"""What the scene's gauges read: numbers of every frame."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from ecume.engine.interpolation import added, dry, near, planes
from ecume.laws.kernels import kernel
from ecume.models.sph.parameters import Gauge, PressureReference
from ecume.models.sph.report.pressures import PRESSURES
from ecume.models.sph.state import State
from ecume.scenes.sph import SphScene
from ecume.scenes.sph.tank import TankSpec
from ecume.units import Array

KERNEL = "wendland-c2"
QUADRATURE = 200
"""Points an axis for how much of a gauge's surroundings is in the tank."""
ACROSS = 6
"""Points along the line of a sensor, or along a radius and around a disc."""

Readings = tuple[dict[str, float], dict[str, str]]
"""Numbers, and their units."""


def gauges_of(scene: SphScene, reach: float) -> tuple[Gauge, ...]:
    """The gauges of a scene, rows of gauges as single ones."""
    found = []
    for spec in scene.gauges:
        first = np.array(spec.position)
        places = [first] if spec.end is None else np.linspace(first, np.array(spec.end), spec.count or 2)
        for number, place in enumerate(places, 1):
            name = spec.name if spec.end is None else f"{spec.name}_{number}"
            area = sensing_area(scene.tank, place, spec.diameter or 0.0)
            found.append(Gauge(name, place, area, spec.quantities, _ground(scene, place, reach)))
    return tuple(found)


def sensing_area(tank: TankSpec, place: Array, diameter: float) -> Array:
    """(n, d) points that share the sensing area of a sensor evenly, along the nearest side of the tank and within it;
    the place alone without a diameter.
    """
    if diameter == 0.0:
        return place[None]
    low, high = np.array(tank.low), np.array(tank.high)
    across = int(np.argmin(np.minimum(place - low, high - place)))
    along = [axis for axis in range(len(place)) if axis != across]
    points = np.tile(place, (ACROSS * (ACROSS if len(along) > 1 else 1), 1))
    share = (np.arange(ACROSS) + 0.5) / ACROSS
    if len(along) == 1:
        points[:, along[0]] += (share - 0.5) * diameter
    else:  # rings of equal areas
        radius, angle = np.meshgrid(0.5 * diameter * np.sqrt(share), 2.0 * np.pi * share)
        points[:, along] += np.stack([(radius * np.cos(angle)).ravel(), (radius * np.sin(angle)).ravel()], axis=1)
    inside: Array = points[((points >= low) & (points <= high)).all(axis=1)]
    return inside if len(inside) else place[None]


def _ground(scene: SphScene, place: Array, reach: float) -> float:
    """The kernel's integral over the tank's floor around a gauge."""
    level = [axis for axis in range(len(place)) if axis != 1]
    shape = kernel(KERNEL, dim=len(level))
    axes = [reach * ((np.arange(QUADRATURE) + 0.5) / (0.5 * QUADRATURE) - 1.0)] * len(level)
    away = np.stack([axis.ravel() for axis in np.meshgrid(*axes, indexing="ij")], axis=1)
    weight = np.asarray(shape.value(np.linalg.norm(away, axis=1), reach / shape.support))
    there = place[level] + away
    low, high = np.array(scene.tank.low)[level], np.array(scene.tank.high)[level]
    inside = ((there > low) & (there < high)).all(axis=1)
    return float(weight[inside].sum() / weight.sum())


def readings(
    gauges: tuple[Gauge, ...], state: State, pressure: Array, reach: float, reference: PressureReference
) -> Readings:
    """The values of all gauges; summed in the initial order of particles, so that they do not depend on sorting."""
    numbers, units = dict[str, float](), dict[str, str]()
    if gauges:
        order = np.argsort(state.identity)
        position, velocity = state.position[:, order].T, state.velocity[:, order].T
        table = np.column_stack([velocity, pressure[order], (state.mass / state.density)[order]])
        for gauge in gauges:
            for name, value, unit in _read(gauge, position, table, reach, reference):
                numbers[f"{gauge.name}_{name}"], units[f"{gauge.name}_{name}"] = value, unit
    return numbers, units


def _read(
    gauge: Gauge, position: Array, table: Array, reach: float, reference: PressureReference
) -> Iterator[tuple[str, float, str]]:
    """Name, value and unit of each number; `table` holds velocity, pressure and volume of the particles."""
    dimension = position.shape[1]
    kinds = [name for name in PRESSURES if name in gauge.measures]
    if kinds or "velocity" in gauge.measures:
        *velocity, pressure = np.mean(
            [_at_place(point, position, table, reach) for point in gauge.area], axis=0
        ).tolist()
        middle = gauge.area.mean(axis=0, keepdims=True)
        for name in kinds:
            yield name, float(PRESSURES[name](reference, np.array([pressure]), middle)[0]), "Pa"
        if "velocity" in gauge.measures:
            yield from ((f"velocity_{axis}", value, "m/s") for axis, value in zip("xyz", velocity, strict=False))
    if "level" in gauge.measures:
        level = np.array([axis for axis in range(dimension) if axis != 1])
        yield "level", _depth(gauge, position[:, level], gauge.place[level], table[:, -1], reach), "m"


def _at_place(place: Array, position: Array, table: Array, reach: float) -> list[float]:
    """Velocity and pressure there, exact for what grows linearly; zero where it is dry."""
    close = (np.abs(position - place) < reach).all(axis=1)
    pairs = near(place[None], position[close], reach)
    shape = kernel(KERNEL, dim=len(place))
    weight = table[close, -1][pairs.particle] * shape.value(pairs.distance, reach / shape.support)
    if dry(pairs, weight)[0]:
        return [0.0] * (table.shape[1] - 1)
    found: list[float] = planes(pairs, weight, table[close, :-1])[0].tolist()
    return found


def _depth(gauge: Gauge, level: Array, place: Array, volume: Array, reach: float) -> float:
    """The volume of liquid around a place of the floor, per area of the floor."""
    close = (np.abs(level - place) < reach).all(axis=1)
    pairs = near(place[None], level[close], reach)
    shape = kernel(KERNEL, dim=len(place))
    weight = volume[close][pairs.particle] * shape.value(pairs.distance, reach / shape.support)
    return float(added(pairs, weight)[0]) / gauge.ground
