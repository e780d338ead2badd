"""Still water in random tanks with discs, balls, boxes and slanted surfaces, which has to remain at rest.

The result of each tank is stored as a piece: see `runner`.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from ecume.scenes.schema import from_plain
from ecume.scenes.sph import SphScene
from ecume.simulation import simulate
from ecume.units import Array
from ecume_validation.runner import Row, below, kept_values, within

COUNT = {2: 176, 3: 24}
LAYERS = {2: (8, 18), 3: (7, 9)}
"""The range of particles across the smallest extent, by dimension."""
TIME, FRAMES = 2.0, 8
"""The duration (s) and the number of frames."""
GRAVITY = 9.81
MOST_SPEED, MOST_ERROR, MOST_SCATTER, MOST_RISE, MOST_CHANGE = 0.02, 0.1, 0.02, 1e-4, 1e-3
"""Limits in units of sqrt(g H), of rho g H (twice), of rho g H times the volume, and of the volume."""
USUAL_SPEED, USUAL_ERROR = 0.01, 0.02
"""Limits for half of the tanks."""
FOLDER = Path("random-tank-pieces")

Obstacles = list[dict[str, Any]]
Dice = np.random.Generator


def _turned(size: Array, rng: Dice, corners: int) -> Obstacles:
    """A regular polygon with a random orientation."""
    angle = rng.uniform(0.0, 1.5) + 2.0 * np.pi * np.arange(corners) / corners
    reach = rng.uniform(0.18, 0.28) * size.min()
    center = size * rng.uniform(0.4, 0.6, 2)
    return [{"vertices": (center + reach * np.stack([np.cos(angle), np.sin(angle)], axis=1)).tolist()}]


def _ball(size: Array, rng: Dice) -> Obstacles:
    """A disc or ball in the liquid."""
    share = (0.12, 0.22) if len(size) == 2 else (0.2, 0.3)
    return [{"center": (size * rng.uniform(0.4, 0.6, len(size))).tolist(), "radius": rng.uniform(*share) * size.min()}]


def _mound(size: Array, rng: Dice) -> Obstacles:
    """Half a disc or ball on the floor."""
    center = size * rng.uniform(0.4, 0.6, len(size))
    center[1] = 0.0
    return [{"center": center.tolist(), "radius": rng.uniform(0.2, 0.3) * size.min()}]


def _wedge(size: Array, rng: Dice) -> Obstacles:
    """A slope at the right wall."""
    width, depth = size
    base = rng.uniform(0.3, 0.6) * size.min()
    top = min(base * rng.uniform(0.4, 1.5), 0.9 * depth)
    return [{"vertices": [[width - base, 0.0], [width, 0.0], [width, top]]}]


def _hopper(size: Array, rng: Dice) -> Obstacles:
    """Slanted walls on both sides, higher than the liquid."""
    width, high = size[0], 2.5 * size[1]
    base = rng.uniform(0.2, 0.4) * width
    left = [[0.0, 0.0], [base, 0.0], [0.0, high]]
    return [{"vertices": left}, {"vertices": [[width - x, y] for x, y in left]}]


def _ramp(size: Array, rng: Dice) -> Obstacles:
    """A slanted floor."""
    width, depth = size
    return [{"vertices": [[0.0, 0.0], [width, 0.0], [width, rng.uniform(0.2, 0.6) * depth]]}]


def _pier(size: Array, rng: Dice) -> Obstacles:
    """A trapezoid on the floor."""
    width, depth = size
    middle = rng.uniform(0.4, 0.6) * width
    base, top = 0.25 * width, 0.12 * width
    low = [[middle - base, 0.0], [middle + base, 0.0]]
    return [{"vertices": [*low, [middle + top, 0.5 * depth], [middle - top, 0.5 * depth]]}]


def _block(size: Array, rng: Dice) -> Obstacles:
    """A box on the floor."""
    low, high = size * rng.uniform(0.1, 0.5, len(size)), size * rng.uniform(0.2, 0.4, len(size))
    low[1] = 0.0
    return [{"low": low.tolist(), "high": (low + high).tolist()}]


KINDS: Mapping[int, tuple[Callable[[Array, Dice], Obstacles], ...]] = {
    2: (
        _ball, _mound, _wedge, _hopper, _ramp, _pier, _block,
        lambda size, rng: _turned(size, rng, 4), lambda size, rng: _turned(size, rng, 6),
    ),
    3: (_ball, _mound, _block),
}  # fmt: skip
"""Kinds of obstacles by dimension."""


class Rest(NamedTuple):
    """The deviations from rest at the end."""

    full: bool
    """whether the tank has a lid on the liquid"""
    speed: float
    """largest, over sqrt(g H)"""
    error: float
    """root mean square of the pressure minus rho g (H - y), over rho g H, with the drawn level H"""
    scatter: float
    """the same with the fitted level: if rows of particles do not fit between walls, the level differs by up to half a
    row
    """
    change: float
    """of the volume, relative"""
    rise: float
    """of energy minus work, over rho g H times the volume"""
    lost: float
    """number of particles"""


def rows() -> list[Row]:
    """Compare tanks in 2D, then in 3D with a free surface and with a lid on the liquid."""
    plane, space = ([kept(random_tank(dimension, seed)) for seed in range(COUNT[dimension])] for dimension in (2, 3))
    groups = {
        "2D": plane,
        "3D, free surface": [each for each in space if not each.full],
        "3D, full": [each for each in space if each.full],
    }
    return [row for name, found in groups.items() if found for row in rows_of(f"{name}, {len(found)} tanks", found)]


def random_tank(dimension: int, seed: int) -> SphScene:
    """A tank with random proportions, obstacle, walls and top."""
    rng = np.random.default_rng([dimension, seed])
    size = rng.uniform(0.2, 1.0) * np.array([1.0, rng.uniform(0.5, 1.3), rng.uniform(0.6, 1.2)])[:dimension]
    high = size.copy()
    high[1] *= rng.choice([1.0, rng.uniform(1.1, 2.0)])
    walls = str(rng.choice(["mirror", "dummy"]))
    spacing = size.min() / rng.integers(*LAYERS[dimension]) * rng.uniform(0.95, 1.05)
    obstacles = KINDS[dimension][seed % len(KINDS[dimension])](size, rng)
    scene = from_plain(
        {
            "model": "sph", "duration": TIME, "frame_every": TIME / FRAMES, "spacing": float(spacing),
            "tank": {"high": high.tolist(), "walls": walls}, "obstacles": obstacles,
            "fluid": [{"low": [0.0] * dimension, "high": size.tolist()}],
        }
    )  # fmt: skip
    assert isinstance(scene, SphScene)  # noqa: S101  # the model says so
    return scene


def kept(scene: SphScene, folder: Path = FOLDER) -> Rest:
    """The stored result of a tank, or the one computed now."""
    return Rest(*kept_values(scene, folder, lambda: rest(scene)))


def rest(scene: SphScene) -> Rest:
    """Run a tank and measure its last frame."""
    frames, density = list(simulate(scene)), 1000.0
    depth, volume = (scene.fluid[0].high or ())[1], frames[0].numbers["volume"]
    last, unit = frames[-1], density * GRAVITY * depth
    error = last.arrays["pressure"] / unit - (1.0 - last.arrays["position"][:, 1] / depth)
    energy = np.array([each.numbers["total_energy"] - each.numbers["injected_work"] for each in frames])
    return Rest(
        full=scene.tank.high[1] == depth,
        speed=last.numbers["largest_speed"] / math.sqrt(GRAVITY * depth),
        error=float(np.sqrt(np.mean(error**2))),
        scatter=float(np.std(error)),
        change=abs(last.numbers["volume"] / volume - 1.0),
        rise=float((energy - np.minimum.accumulate(energy)).max()) / (unit * volume),
        lost=last.numbers["particles_lost"],
    )


def rows_of(name: str, found: list[Rest]) -> list[Row]:
    """Rows on the worst tank of a group."""
    speed, error = [each.speed for each in found], [each.error for each in found]
    return [
        below(f"{name}: largest speed, over sqrt(g H)", max(speed), MOST_SPEED),
        below(f"{name}: median of the largest speeds", float(np.median(speed)), USUAL_SPEED),
        below(f"{name}: error of the pressure, over rho g H", max(error), MOST_ERROR),
        below(f"{name}: median error of the pressure", float(np.median(error)), USUAL_ERROR),
        below(f"{name}: the largest from the liquid's own level", max(each.scatter for each in found), MOST_SCATTER),
        below(f"{name}: change of the volume", max(each.change for each in found), MOST_CHANGE),
        below(f"{name}: rise of energy minus work", max(each.rise for each in found), MOST_RISE),
        within(f"{name}: particles lost", sum(each.lost for each in found), 0.0, 0.0),
    ]
