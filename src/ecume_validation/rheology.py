"""The flow curve of a packing above jamming, over three decades of the shear rate.

The result of each rate and seed is stored as a piece.
"""

from __future__ import annotations

import itertools
import math
from collections.abc import Callable, Iterator, Sequence
from importlib.resources import files
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from ecume.analysis.rheology import (
    CurveFit,
    herschel_bulkley,
    over_seeds,
    power_fit,
    steady_state,
    stress_tensor,
    viscous_number,
)
from ecume.analysis.series import Mean
from ecume.scenes.load import load_scene
from ecume.scenes.schema import Scene, from_plain, to_plain
from ecume.simulation import simulate
from ecume.trajectories.frame import Frame
from ecume_validation.runner import Row, above, below, kept_values, read_table, within


class Piece(NamedTuple):
    """The result for one rate and seed."""

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
    """The quantities of a frame."""
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
    """The stored piece of a scene, or the one computed now."""
    return _read(
        kept_values(scene, folder, lambda: piece_of(rate, scene.seed, [instant(frame) for frame in simulate(scene)]))
    )


def _read(stored: list[Any]) -> Piece:
    means = {place: Mean(*stored[place]) for place in range(2, 5)}
    return Piece(*(means.get(place, value) for place, value in enumerate(stored)))


def template() -> Path:
    """The base scene of all pieces."""
    return Path(str(files("ecume") / "templates" / "sheared-packing.toml"))


def sheared(spheres: int, seed: int, protocol: list[dict[str, float]], duration: float, frames: int,
            changes: Sequence[str] = ()) -> Scene:  # fmt: skip
    """The template `sheared-packing` with other numbers of spheres and another protocol."""
    counts = [f"particles[{kind}].count={spheres // 2}" for kind in range(2)]
    plain = to_plain(load_scene(template(), [f"seed={seed}", *counts, *changes]))
    return from_plain(plain | {"duration": duration, "frame_every": duration / frames, "protocol": protocol})


def fitted(pieces: Sequence[Piece]) -> CurveFit:
    """The fit of Herschel and Bulkley's law to the means over seeds."""
    rates, means = means_over_seeds(pieces, lambda one: one.shear)
    return herschel_bulkley(np.array(rates), means)


def friction(shear: Mean, pressure: Mean) -> Mean:
    """The shear stress over the pressure."""
    ratio = shear.value / pressure.value
    return Mean(ratio, abs(ratio) * math.hypot(shear.error / shear.value, pressure.error / pressure.value))


def means_over_seeds(pieces: Sequence[Piece], value: Callable[[Piece], Mean]) -> tuple[list[float], list[Mean]]:
    """The rates, and the mean over seeds at each rate."""
    rates = sorted({one.rate for one in pieces})
    return rates, [over_seeds([value(one) for one in pieces if one.rate == rate]) for rate in rates]


def pieces_of(case: str, name: str = "computed") -> list[tuple[dict[str, str], Piece]]:
    """The pieces in a table of a case, which were computed with its scenes and contain all columns of a row."""
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


RATES, SEEDS = (0.025, 0.08, 0.25, 0.8, 2.5, 8.0, 25.0), (1, 2, 3)
"""Shear rates (1/s), and seeds of the random start."""
DOUBLED, LIKE = (0.25, 0.8, 2.5), 0.1
"""Rates that are repeated with twice as many spheres, and the tolerated relative difference of their stress."""
SPHERES, FRACTION, STRAIN = 60, 0.87, 10.0
"""Number of spheres (in 2D, of two sizes), volume fraction, and strain after a pre-shear to a strain of 1, which
compresses them from 0.80.
"""
START, FRAMES = 0.80, 550
LIQUID, DIAMETER = 1.0, 2.4e-3
"""Viscosity (Pa s) and mean diameter (m)."""
PIECES = Path("rheology-pieces")
SETH, TOLERANCE = 0.5, 0.05
"""The exponent of Seth et al. for elastohydrodynamic films, and its tolerance."""
MODULUS, LENGTH, VISCOSITY = 3.0, 2.0, 7.0
"""Factors of a run in other units."""
SHORT = ("particles[0].count=12", "particles[1].count=12", "cell.volume_fraction=0.80")


def rows() -> list[Row]:
    """Compare all pieces, the fit, the effect of the size, and a run in other units."""
    found = [piece(rate, seed) for rate, seed in itertools.product(RATES, SEEDS)]
    larger = [piece(rate, SEEDS[0], spheres=2 * SPHERES) for rate in DOUBLED]
    return [*rows_of_pieces(found), *rows_of_sizes(found, larger), units()]


def rows_of_pieces(pieces: Sequence[Piece]) -> Iterator[Row]:
    """Rows on each steady flow, and on the fitted flow curve."""
    yield above("smallest pressure of all runs (N/m)", min(one.least_pressure for one in pieces), 0.0)
    yield below("largest force left on a sphere", max(one.largest_imbalance for one in pieces), 1e-8)
    yield within("runs whose shear stress is stationary", sum(one.settled for one in pieces), len(pieces), 0.0)
    fit = fitted(pieces)
    name = f"exponent of the default laws, ± {fit.exponent.error:.3f}; Seth et al. with elastohydrodynamic films: 0.5"
    yield within(name, fit.exponent.value, SETH, TOLERANCE)
    yield above(f"yield stress (N/m), ± {fit.offset.error:.2g}", fit.offset.value, 0.0)
    yield below("misfit of Herschel and Bulkley's law, per degree of freedom", fit.misfit, 3.0)


def rows_of_sizes(pieces: Sequence[Piece], larger: Sequence[Piece]) -> Iterator[Row]:
    """Rows on the stress with twice as many spheres, over the mean of the other runs over seeds."""
    means = dict(zip(*means_over_seeds(pieces, lambda one: one.shear), strict=True))
    for one in larger:
        ratio = friction(one.shear, means[one.rate])
        name = f"stress with {2 * SPHERES} spheres / {SPHERES} at {one.rate:g}/s, ± {ratio.error:.3f}"
        yield within(name, ratio.value, 1.0, LIKE)


def friction_curve(pieces: Sequence[Piece]) -> CurveFit:
    """The fit of a power law of the viscous number J = eta rate d/P to the friction minus that of the slowest flows."""
    rates, shears = means_over_seeds(pieces, lambda one: one.shear)
    _, pressures = means_over_seeds(pieces, lambda one: one.pressure)
    numbers = [viscous_number(LIQUID, rate, one.value / DIAMETER) for rate, one in zip(rates, pressures, strict=True)]
    return power_fit(np.array(numbers), list(map(friction, shears, pressures)))


def computed(name: str = "computed") -> list[Piece]:
    """The pieces in the table `computed.csv`, which were computed with the scenes of this case. Those with twice as
    many spheres are in `doubled.csv`.
    """
    return [one for _, one in pieces_of("rheology", name)]


def piece(rate: float, seed: int, folder: Path = PIECES, spheres: int = SPHERES) -> Piece:
    """A stored piece, or one that is computed now."""
    return kept(scene_of(rate, seed, spheres), rate, folder)


def scene_of(rate: float, seed: int, spheres: int = SPHERES) -> Scene:
    """The template `sheared-packing` with fewer spheres and a higher volume fraction."""
    protocol = [{"time": 0.0, "shear_rate": rate}, {"time": 1.0 / rate, "scale": math.sqrt(START / FRACTION)}]
    duration = (STRAIN + 1.0) / rate
    return sheared(spheres, seed, protocol, duration, FRAMES, [f"cell.volume_fraction={START}"])


def units(strain: float = 0.5) -> Row:
    """A row on the final stress of a short run, over its unit, when modulus, lengths and viscosity are multiplied by
    factors.
    """
    first, second = (final_stress(strain, factors) for factors in ((1.0, 1.0, 1.0), (MODULUS, LENGTH, VISCOSITY)))
    return within("stress in other units of E, R and η", second / (MODULUS * LENGTH) / first, 1.0, 1e-6)


def final_stress(strain: float, factors: tuple[float, float, float]) -> float:
    """The shear stress at a strain, with modulus, lengths and viscosity times these factors (N/m)."""
    modulus, length, viscosity = factors
    plain = to_plain(load_scene(template(), SHORT))
    duration = strain / 0.25 * viscosity / modulus
    for species in plain["particles"]:
        species["radius"] *= length
        species["modulus"] *= modulus
    plain["liquid"]["viscosity"] *= viscosity
    plain["long_range_forces"]["steric_strength"] *= modulus * length**2
    plain["long_range_forces"]["steric_length"] *= length
    plain["cell"]["size"] = [length * side for side in plain["cell"]["size"]]
    plain["cell"]["minimum_gap"] *= length
    plain |= {"duration": duration, "frame_every": duration}
    plain["protocol"] = [{"time": 0.0, "shear_rate": strain / duration}]
    return list(simulate(from_plain(plain)))[-1].numbers["shear_stress"]
