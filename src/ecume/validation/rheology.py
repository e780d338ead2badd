"""Flow curve of a packing above jamming, over three decades of the shear rate, in pieces that are kept.

A piece is one rate with one seed: see `flow_pieces`.
"""

from __future__ import annotations

import itertools
import math
from collections.abc import Iterator, Sequence
from pathlib import Path

import numpy as np

from ecume.analysis.rheology import CurveFit, power_fit, viscous_number
from ecume.scenes.load import Scene, from_plain, load_scene, to_plain
from ecume.simulation import simulate
from ecume.validation import flow_pieces
from ecume.validation.flow_pieces import Piece, fitted, friction, kept, means_over_seeds, sheared, template
from ecume.validation.runner import Row, above, below, within

RATES, SEEDS = (0.025, 0.08, 0.25, 0.8, 2.5, 8.0, 25.0), (1, 2, 3)
"""1/s; of the random start."""
DOUBLED, LIKE = (0.25, 0.8, 2.5), 0.1
"""Rates that are repeated with twice as many spheres; by how much their stress may differ, relatively."""
SPHERES, FRACTION, STRAIN = 60, 0.87, 10.0
"""In 2D, of two sizes; after a pre-shear to a strain of 1, during which they are compressed from 0.80."""
START, FRAMES = 0.80, 550
LIQUID, DIAMETER = 1.0, 2.4e-3
"""Viscosity (Pa s) and mean diameter (m)."""
PIECES = Path("rheology-pieces")
SETH, TOLERANCE = 0.5, 0.05
"""The exponent of Seth et al. with elastohydrodynamic films, and the tolerance."""
MODULUS, LENGTH, VISCOSITY = 3.0, 2.0, 7.0
"""Factors of a second run in other units."""
SHORT = ("particles[0].count=12", "particles[1].count=12", "cell.volume_fraction=0.80")


def rows() -> list[Row]:
    """All pieces, the fit, the effect of the size, and a run in other units."""
    found = [piece(rate, seed) for rate, seed in itertools.product(RATES, SEEDS)]
    larger = [piece(rate, SEEDS[0], spheres=2 * SPHERES) for rate in DOUBLED]
    return [*rows_of_pieces(found), *rows_of_sizes(found, larger), units()]


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


def rows_of_sizes(pieces: Sequence[Piece], larger: Sequence[Piece]) -> Iterator[Row]:
    """The stress of twice as many spheres over the mean of the others over seeds."""
    means = dict(zip(*means_over_seeds(pieces, lambda one: one.shear), strict=True))
    for one in larger:
        ratio = friction(one.shear, means[one.rate])
        name = f"stress with {2 * SPHERES} spheres / {SPHERES} at {one.rate:g}/s, ± {ratio.error:.3f}"
        yield within(name, ratio.value, 1.0, LIKE)


def friction_curve(pieces: Sequence[Piece]) -> CurveFit:
    """The friction as a power of the viscous number J = eta rate d/P above that of the slowest flows."""
    rates, shears = means_over_seeds(pieces, lambda one: one.shear)
    _, pressures = means_over_seeds(pieces, lambda one: one.pressure)
    numbers = [viscous_number(LIQUID, rate, one.value / DIAMETER) for rate, one in zip(rates, pressures, strict=True)]
    return power_fit(np.array(numbers), list(map(friction, shears, pressures)))


def computed(name: str = "computed") -> list[Piece]:
    """The pieces of the table `computed.csv`, which were computed with the scenes of this case. Those of twice as many
    spheres are in `doubled.csv`.
    """
    return [one for _, one in flow_pieces.computed("rheology", name)]


def piece(rate: float, seed: int, folder: Path = PIECES, spheres: int = SPHERES) -> Piece:
    """A piece that is kept, or one that is computed now."""
    return kept(scene_of(rate, seed, spheres), rate, folder)


def scene_of(rate: float, seed: int, spheres: int = SPHERES) -> Scene:
    """The template `sheared-packing` with fewer spheres and a higher volume fraction."""
    protocol = [{"time": 0.0, "shear_rate": rate}, {"time": 1.0 / rate, "scale": math.sqrt(START / FRACTION)}]
    duration = (STRAIN + 1.0) / rate
    return sheared(spheres, seed, protocol, duration, FRAMES, [f"cell.volume_fraction={START}"])


def units(strain: float = 0.5) -> Row:
    """The stress at the end of a short run whose modulus, lengths and viscosity are multiplied, over its unit."""
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
