"""Steady shear flows of packings in `pieces` that are kept: one flow with one random start each."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from importlib.resources import files
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from ecume.analysis.rheology import CurveFit, herschel_bulkley, over_seeds, steady_state, stress_tensor
from ecume.analysis.series import Mean
from ecume.scenes.load import Scene, from_plain, load_scene, to_plain
from ecume.simulation import simulate
from ecume.trajectories.frame import Frame
from ecume.validation.runner import kept_values, read_table


class Piece(NamedTuple):
    """One rate with one seed."""

    rate: float
    """1/s"""
    seed: int
    shear: Mean
    """the shear stress of the steady state, with its error from block means (N/m)"""
    pressure: Mean
    first_difference: Mean
    settled: bool
    """whether the shear stress is stationary"""
    least_pressure: float
    largest_deflection: float
    """of a contact, over the smaller radius"""
    largest_imbalance: float
    """of the forces on a sphere, over the typical force"""


class Instant(NamedTuple):
    """The numbers of a frame from which a piece is computed."""

    strain: float
    shear: float
    pressure: float
    first_difference: float
    deflection: float
    imbalance: float


def instant(frame: Frame) -> Instant:
    """The numbers of a frame."""
    tensor, numbers = stress_tensor(frame), frame.numbers
    difference = float(tensor[0, 0] - tensor[1, 1])
    return Instant(
        numbers["strain"], numbers["shear_stress"], numbers["pressure"], difference,
        numbers["largest_deflection"], numbers["imbalance"],
    )  # fmt: skip


def piece_of(rate: float, seed: int, instants: Sequence[Instant]) -> Piece:
    """The means over the steady state of the shear stress, after a pre-shear to a strain of 1."""
    flowing = np.array([one for one in instants if one.strain > 1.0])
    shear = steady_state(flowing[:, 1])
    pressure, difference = (steady_state(flowing[:, place]).mean for place in (2, 3))
    least, deflection, imbalance = flowing[:, 2].min(), flowing[:, 4].max(), flowing[:, 5].max()
    return Piece(
        rate, seed, shear.mean, pressure, difference, shear.settled, float(least), float(deflection), float(imbalance)
    )


def kept(scene: Scene, rate: float, folder: Path) -> Piece:
    """The piece of a scene that is kept, or that is computed now."""
    return _read(
        kept_values(scene, folder, lambda: piece_of(rate, scene.seed, [instant(frame) for frame in simulate(scene)]))
    )


def _read(stored: list[Any]) -> Piece:
    means = {place: Mean(*stored[place]) for place in range(2, 5)}
    return Piece(*(means.get(place, value) for place, value in enumerate(stored)))


def template() -> Path:
    """The scene of which all pieces are variations."""
    return Path(str(files("ecume") / "templates" / "sheared-packing.toml"))


def sheared(spheres: int, seed: int, protocol: list[dict[str, float]], duration: float, frames: int,
            changes: Sequence[str] = ()) -> Scene:  # fmt: skip
    """The template `sheared-packing` with other numbers of spheres and another protocol."""
    counts = [f"particles[{kind}].count={spheres // 2}" for kind in range(2)]
    plain = to_plain(load_scene(template(), [f"seed={seed}", *counts, *changes]))
    return from_plain(plain | {"duration": duration, "frame_every": duration / frames, "protocol": protocol})


def fitted(pieces: Sequence[Piece]) -> CurveFit:
    """Herschel and Bulkley's law of the means over seeds."""
    rates, means = means_over_seeds(pieces, lambda one: one.shear)
    return herschel_bulkley(np.array(rates), means)


def friction(shear: Mean, pressure: Mean) -> Mean:
    """The shear stress over the pressure."""
    ratio = shear.value / pressure.value
    return Mean(ratio, abs(ratio) * math.hypot(shear.error / shear.value, pressure.error / pressure.value))


def means_over_seeds(pieces: Sequence[Piece], value: Callable[[Piece], Mean]) -> tuple[list[float], list[Mean]]:
    """The rates, and the mean over seeds at each."""
    rates = sorted({one.rate for one in pieces})
    return rates, [over_seeds([value(one) for one in pieces if one.rate == rate]) for rate in rates]


def computed(case: str, name: str = "computed") -> list[tuple[dict[str, str], Piece]]:
    """The pieces of a table of a case, which were computed with its scenes, each with all columns of its row."""
    return [
        (
            row,
            Piece(
                float(row["rate"]), int(row["seed"]), Mean(float(row["shear_stress"]), float(row["error"])),
                Mean(float(row["pressure"]), float(row["pressure_error"])),
                Mean(float(row["first_difference"]), float(row["first_difference_error"])), row["stationary"] == "1",
                float(row["least_pressure"]), float(row["largest_deflection"]), float(row["largest_imbalance"]),
            ),
        )
        for row in read_table(case, name)
    ]  # fmt: skip
