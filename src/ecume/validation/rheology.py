"""Flow curve of a packing above jamming, over three decades of the shear rate, in pieces that are kept.

A piece is one rate with one seed. Finished pieces are in the folder `rheology-pieces` of the working directory, each
named by the digest of its scene: an interrupted case continues with the pieces that are missing.
"""

from __future__ import annotations

import hashlib
import itertools
import json
import math
from collections.abc import Iterator, Sequence
from importlib.resources import files
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from ecume.analysis.rheology import CurveFit, herschel_bulkley, over_seeds, steady_state, stress_tensor
from ecume.analysis.series import Mean
from ecume.scenes.load import load_scene
from ecume.scenes.schema import Scene, from_plain, to_plain
from ecume.simulation import simulate
from ecume.trajectories.frame import Frame
from ecume.validation.rows import Row, above, below, within
from ecume.validation.runner import read_table

RATES, SEEDS = (0.025, 0.08, 0.25, 0.8, 2.5, 8.0, 25.0), (1, 2, 3)
"""1/s; of the random start."""
SPHERES, FRACTION, STRAIN = 60, 0.87, 10.0
"""In 2D, of two sizes; after a pre-shear to a strain of 1, during which they are compressed from 0.80."""
START, FRAMES = 0.80, 550
PIECES = Path("rheology-pieces")
SETH, TOLERANCE = 0.5, 0.05
"""The exponent of Seth et al. with elastohydrodynamic films, and the tolerance."""
MODULUS, LENGTH, VISCOSITY = 3.0, 2.0, 7.0
"""Factors of a second run in other units."""
SHORT = ("particles[0].count=12", "particles[1].count=12", "cell.volume_fraction=0.80")


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


def rows() -> list[Row]:
    """All pieces, the fit, and a run in other units."""
    found = [piece(rate, seed) for rate, seed in itertools.product(RATES, SEEDS)]
    return [*rows_of_pieces(found), units()]


def rows_of_pieces(pieces: Sequence[Piece]) -> Iterator[Row]:
    """What holds in each steady flow, and the fitted flow curve."""
    yield above("smallest pressure of all runs (N/m)", min(one.least_pressure for one in pieces), 0.0)
    yield below("largest force left on a sphere", max(one.largest_imbalance for one in pieces), 1e-8)
    yield within("runs whose shear stress is stationary", sum(one.settled for one in pieces), len(pieces), 0.0)
    fit = fitted(pieces)
    name = f"exponent of the default laws, ± {fit.exponent.error:.3f}; Seth et al. with elastohydrodynamic films: 0.5"
    yield within(name, fit.exponent.value, SETH, TOLERANCE)
    yield above(f"yield stress (N/m), ± {fit.offset.error:.2g}", fit.offset.value, 0.0)
    yield below("misfit of Herschel and Bulkley's law, per degree of freedom", fit.misfit, 3.0)


def fitted(pieces: Sequence[Piece]) -> CurveFit:
    """Herschel and Bulkley's law of the means over seeds."""
    rates = sorted({one.rate for one in pieces})
    means = [over_seeds([one.shear for one in pieces if one.rate == rate]) for rate in rates]
    return herschel_bulkley(np.array(rates), means)


def computed() -> list[Piece]:
    """The pieces of the table `computed.csv`, which were computed with the scenes of this case."""
    return [
        Piece(
            float(row["rate"]), int(row["seed"]), Mean(float(row["shear_stress"]), float(row["error"])),
            Mean(float(row["pressure"]), float(row["pressure_error"])),
            Mean(float(row["first_difference"]), float(row["first_difference_error"])), row["stationary"] == "1",
            float(row["least_pressure"]), float(row["largest_deflection"]), float(row["largest_imbalance"]),
        )
        for row in read_table("rheology", "computed")
    ]  # fmt: skip


def piece(rate: float, seed: int, folder: Path = PIECES) -> Piece:
    """A piece that is kept, or one that is computed now."""
    scene = scene_of(rate, seed)
    path = folder / f"{digest(scene)}.json"
    if path.is_file():
        return _read(json.loads(path.read_text(encoding="utf-8")))
    found = piece_of(rate, seed, [instant(frame) for frame in simulate(scene)])
    folder.mkdir(parents=True, exist_ok=True)
    # Complete or absent: the file takes its name when all of it is written.
    partial = path.with_suffix(".part")
    partial.write_text(json.dumps(found), encoding="utf-8")
    partial.replace(path)
    return found


def _read(stored: list[Any]) -> Piece:
    means = {place: Mean(*stored[place]) for place in range(2, 5)}
    return Piece(*(means.get(place, value) for place, value in enumerate(stored)))


def digest(scene: Scene) -> str:
    """The name of a piece: a digest of its complete scene."""
    return hashlib.sha256(json.dumps(to_plain(scene), sort_keys=True).encode()).hexdigest()[:16]


def scene_of(rate: float, seed: int) -> Scene:
    """The template `sheared-packing` with fewer spheres and a higher volume fraction."""
    half = SPHERES // 2
    changes = [f"seed={seed}", f"particles[0].count={half}", f"particles[1].count={half}"]
    plain = to_plain(load_scene(_template(), [*changes, f"cell.volume_fraction={START}"]))
    duration = (STRAIN + 1.0) / rate
    protocol = [
        {"time": 0.0, "shear_rate": rate},
        {"time": 1.0 / rate, "scale": math.sqrt(START / FRACTION)},
    ]
    return from_plain(plain | {"duration": duration, "frame_every": duration / FRAMES, "protocol": protocol})


def _template() -> Path:
    return Path(str(files("ecume") / "templates" / "sheared-packing.toml"))


def instant(frame: Frame) -> Instant:
    """The numbers of a frame."""
    tensor, numbers = stress_tensor(frame), frame.numbers
    difference = float(tensor[0, 0] - tensor[1, 1])
    return Instant(
        numbers["strain"], numbers["shear_stress"], numbers["pressure"], difference,
        numbers["largest_deflection"], numbers["imbalance"],
    )  # fmt: skip


def piece_of(rate: float, seed: int, instants: Sequence[Instant]) -> Piece:
    """The means over the steady state of the shear stress, after the pre-shear."""
    flowing = np.array([one for one in instants if one.strain > 1.0])
    shear = steady_state(flowing[:, 1])
    pressure, difference = (steady_state(flowing[:, place]).mean for place in (2, 3))
    least, deflection, imbalance = flowing[:, 2].min(), flowing[:, 4].max(), flowing[:, 5].max()
    return Piece(
        rate, seed, shear.mean, pressure, difference, shear.settled, float(least), float(deflection), float(imbalance)
    )


def units(strain: float = 0.5) -> Row:
    """The stress at the end of a short run whose modulus, lengths and viscosity are multiplied, over its unit."""
    first, second = (final_stress(strain, factors) for factors in ((1.0, 1.0, 1.0), (MODULUS, LENGTH, VISCOSITY)))
    return within("stress in other units of E, R and η", second / (MODULUS * LENGTH) / first, 1.0, 1e-6)


def final_stress(strain: float, factors: tuple[float, float, float]) -> float:
    """The shear stress at a strain, with modulus, lengths and viscosity times these factors (N/m)."""
    modulus, length, viscosity = factors
    plain = to_plain(load_scene(_template(), SHORT))
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
