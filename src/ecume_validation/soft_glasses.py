"""The flow curve of a packing with elastohydrodynamic films, as in soft particle glasses, over three decades of the
shear rate.

Results are stored as pieces: see `rheology`.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path

import numpy as np

from ecume.analysis.rheology import FEWEST_POINTS, CurveFit, power_fit
from ecume.scenes.schema import Scene
from ecume_validation import rheology
from ecume_validation.rheology import Piece, fitted, friction, kept, sheared
from ecume_validation.runner import Row, above, below, within

RATES = {0.87: (0.025, 0.14, 0.8, 4.5, 25.0), 0.90: (0.14, 0.8, 4.5, 25.0), 1.00: (0.8, 4.5, 25.0)}
"""Shear rates (1/s) at each volume fraction. Soft glasses of the paper are 1.1 to 1.4 times as dense as at jamming;
1.00 is 1.19.
"""
FITTED = tuple(fraction for fraction, rates in RATES.items() if len(rates) >= FEWEST_POINTS)
"""Volume fractions with enough rates for a fit."""
SEED = 1
"""The seed of the random start."""
SPHERES, START, STRAIN = 60, 0.80, 6.0
"""Number of spheres (in 2D, of two sizes), initial volume fraction, and strain; they are compressed during a pre-shear
to a strain of 1.
"""
FRAMES_PER_STRAIN = 50
FLOWS = tuple((fraction, rate) for fraction, rates in RATES.items() for rate in rates)
DOUBLED = ((0.87, 4.5), (0.87, 25.0))
"""The flows that are repeated with twice as many spheres."""
LIKE = 0.1
"""The tolerated relative difference of their stress."""
FOLDER = Path("soft-glass-pieces")
EXPONENT, TOLERANCE = 0.5, 0.05
"""The exponent of the published stress law of soft particle glasses, and its tolerance."""
MODULUS, VISCOSITY, RADIUS = 5e4, 1.0, 1.2e-3
"""Pa; Pa s; the mean radius (m)"""
LAWS = ("rotation=false", 'films.interface="elastohydrodynamic"', 'films.prefactors="physical"')
"""The laws of the published model: spheres do not rotate, contacts are Hertzian."""
NUMERICS = ("integration.tolerance=0.01",)


def rows() -> list[Row]:
    """Compare all pieces and the fits."""
    pieces = {flow: piece(*flow) for flow in FLOWS}
    larger = {flow: piece(*flow, spheres=2 * SPHERES) for flow in DOUBLED}
    return [*rows_of_pieces(pieces), *rows_of_sizes(pieces, larger)]


def rows_of_pieces(pieces: Mapping[tuple[float, float], Piece]) -> Iterator[Row]:
    """Rows on each steady flow, and on the fitted flow curves."""
    every = list(pieces.values())
    yield above("smallest pressure of all runs (N/m)", min(one.least_pressure for one in every), 0.0)
    yield below("largest force left on a sphere", max(one.largest_imbalance for one in every), 1e-8)
    yield within("runs whose shear stress is stationary", sum(one.settled for one in every), len(every), 0.0)
    for fraction in FITTED:
        fit, at = curve(pieces, fraction), f"φ = {fraction:g}"
        name = f"exponent at {at}, ± {fit.exponent.error:.3f}; Seth et al.: 0.5"
        yield within(name, fit.exponent.value, EXPONENT, TOLERANCE)
        yield above(f"yield stress at {at} (N/m), ± {fit.offset.error:.2g}", fit.offset.value, 0.0)
        yield below(f"misfit of Herschel and Bulkley's law at {at}, per degree of freedom", fit.misfit, 3.0)
    common = friction_curve(every)
    name = f"exponent of the friction over the film number, ± {common.exponent.error:.3f}; of a film: 0.5"
    yield within(name, common.exponent.value, EXPONENT, TOLERANCE)
    yield below("misfit of the friction at all volume fractions, per degree of freedom", common.misfit, 3.0)


def rows_of_sizes(
    pieces: Mapping[tuple[float, float], Piece], larger: Mapping[tuple[float, float], Piece]
) -> Iterator[Row]:
    """Rows on the stress with twice as many spheres, over that of the others."""
    for flow, one in larger.items():
        few = pieces[flow].shear
        ratio = one.shear.value / few.value
        error = ratio * math.hypot(one.shear.error / one.shear.value, few.error / few.value)
        yield within(f"stress with {2 * SPHERES} spheres / {SPHERES} at {flow[1]:g}/s, ± {error:.3f}", ratio, 1.0, LIKE)


def curve(pieces: Mapping[tuple[float, float], Piece], fraction: float) -> CurveFit:
    """The fit of Herschel and Bulkley's law at a volume fraction."""
    return fitted([pieces[fraction, rate] for rate in RATES[fraction]])


def film_number(piece: Piece) -> float:
    """The number K = (eta rate/E) (P/(E R))^(-2/3), which determines the ratio of tangential to normal forces in a
    film.

    Sliding with the speed u transmits the force T ~ sqrt(eta u N a). In a Hertzian contact a ~ R (N/(E R^2))^(1/3);
    with u ~ rate R and N ~ P R in 2D, T/N ~ sqrt(eta u a/N) ~ sqrt(K). At constant area the pressure, and therefore N,
    increases with the rate.
    """
    pressure = piece.pressure.value / (MODULUS * RADIUS)
    return VISCOSITY * piece.rate / MODULUS / math.cbrt(pressure) ** 2


def friction_curve(pieces: Sequence[Piece]) -> CurveFit:
    """The fit of a power law of the film number to the friction minus that of the slowest flows, for all volume
    fractions together.
    """
    ordered = sorted(pieces, key=film_number)
    return power_fit(
        np.array([film_number(one) for one in ordered]), [friction(one.shear, one.pressure) for one in ordered]
    )


def computed(name: str = "computed") -> dict[tuple[float, float], Piece]:
    """The pieces in the table `computed.csv`, which were computed with the scenes of this case, by volume fraction and
    rate. Those with twice as many spheres are in `doubled.csv`.
    """
    return {(float(row["volume_fraction"]), one.rate): one for row, one in rheology.pieces_of("soft_glasses", name)}


def piece(fraction: float, rate: float, folder: Path = FOLDER, spheres: int = SPHERES) -> Piece:
    """A stored piece, or one that is computed now."""
    return kept(scene_of(fraction, rate, spheres), rate, folder)


def scene_of(fraction: float, rate: float, spheres: int = SPHERES) -> Scene:
    """The template `sheared-packing` with fewer spheres, a higher volume fraction and the published laws."""
    protocol = [{"time": 0.0, "shear_rate": rate}, {"time": 1.0 / rate, "scale": math.sqrt(START / fraction)}]
    frames = round(FRAMES_PER_STRAIN * (STRAIN + 1.0))
    changes = [f"cell.volume_fraction={START}", *LAWS, *NUMERICS]
    return sheared(spheres, SEED, protocol, (STRAIN + 1.0) / rate, frames, changes)
