"""Suspensions of nearly rigid spheres: friction over the viscous number without contact friction, the divergence of the
viscosity with and without it, and shear thickening by a critical load.

Results are stored as pieces: see `rheology`.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Mapping, Sequence
from pathlib import Path
from typing import NamedTuple

import numpy as np

from ecume.analysis.rheology import Divergence, over_seeds, viscosity_divergence
from ecume.analysis.series import Mean
from ecume.errors import BadInput
from ecume.scenes.schema import Scene
from ecume_validation import rheology
from ecume_validation.rheology import Piece, kept, sheared
from ecume_validation.runner import Row, above, below, within

SPHERES, STRAIN, FRAMES_PER_STRAIN = 50, 3.0, 50
"""Number of spheres (in 2D, of two sizes), strain, and frames per strain; a pre-shear to a strain of 1 compresses dense
packings. Flows that are not stationary are computed again to twice the strain.
"""
LOOSE = 0.76
"""The volume fraction at which random starts of denser packings begin."""
RATE, VISCOSITY, DIAMETER = 0.1, 1.0, 2.4e-3
"""1/s, with 2e-6 of modulus over viscosity; Pa s; the mean diameter (m)"""
FOLDER = Path("suspension-pieces")
ROUGH = ("films.friction_coefficient=1.0", 'films.roughness="20 um"')
LAWS = {
    "frictionless": (),
    "frictional": ('films.friction="coulomb"', *ROUGH),
    "critical-load": ('films.friction="critical-load"', 'films.critical_load="40 uN"', *ROUGH),
}
SEEDS = {"frictionless": (1,), "frictional": (1, 2, 3), "critical-load": (1,)}
"""Seeds of the random starts, by law. With friction, a single path decides whether the viscosities determine where they
diverge, and rounding decides the path.
"""
JAMMED, NEAR, THICKER = 0.8415, 0.2, 3.0
"""The volume fraction at which frictionless discs jam [olsson2007], the tolerance of the published friction, and the
least increase of the viscosity.
"""
NUMERICS = ("integration.tolerance=0.01",)


class Flow(NamedTuple):
    """The parameters of a sheared suspension."""

    law: str
    """a row of `LAWS`"""
    fraction: float
    rate: float = RATE
    """1/s"""


DIVERGING = {
    "frictionless": tuple(Flow("frictionless", fraction) for fraction in (0.70, 0.76, 0.80, 0.82)),
    "frictional": tuple(Flow("frictional", fraction) for fraction in (0.62, 0.68, 0.72, 0.76)),
}
DENSE = 0.80
"""A volume fraction between those of jamming with and without friction."""
THICKENING = tuple(Flow("critical-load", DENSE, rate) for rate in (0.01, 0.04, 0.16))
THIN, THICK = 0, 2
"""Indices of rates at which forces are well below the critical load, and above it."""
FLOWS = (*DIVERGING["frictionless"], *DIVERGING["frictional"], *THICKENING)


def piece(flow: Flow, seed: int, folder: Path = FOLDER) -> Piece:
    """A stored piece, or one that is computed now; if it is not stationary, up to twice the strain."""
    found = kept(scene_of(flow, seed), flow.rate, folder)
    return found if found.settled else kept(scene_of(flow, seed, 2.0 * STRAIN), flow.rate, folder)


def merged(pieces: Sequence[Piece]) -> Piece:
    """The means over the seeds of a flow, with errors from the spread of the seeds, and the extremes of all runs."""
    shear = over_seeds([one.shear for one in pieces])
    pressure = over_seeds([one.pressure for one in pieces])
    difference = over_seeds([one.first_difference for one in pieces])
    return Piece(
        pieces[0].rate, 0, shear, pressure, difference, all(one.settled for one in pieces),
        min(one.least_pressure for one in pieces), max(one.largest_deflection for one in pieces),
        max(one.largest_imbalance for one in pieces),
    )  # fmt: skip


def scene_of(flow: Flow, seed: int, strain: float = STRAIN) -> Scene:
    """The template `sheared-packing` with fewer spheres and other rates, volume fractions and contact friction."""
    start = min(flow.fraction, LOOSE)
    protocol = [{"time": 0.0, "shear_rate": flow.rate}]
    if start < flow.fraction:
        protocol.append({"time": 1.0 / flow.rate, "scale": math.sqrt(start / flow.fraction)})
    duration, frames = (strain + 1.0) / flow.rate, round(FRAMES_PER_STRAIN * (strain + 1.0))
    changes = [f"cell.volume_fraction={start}", *LAWS[flow.law], *NUMERICS]
    return sheared(SPHERES, seed, protocol, duration, frames, changes)


def rows() -> list[Row]:
    """Compare the means over seeds, and derived quantities."""
    return list(rows_of_pieces({flow: merged([piece(flow, seed) for seed in SEEDS[flow.law]]) for flow in FLOWS}))


def computed() -> dict[Flow, Piece]:
    """The means over seeds of the pieces in the table `computed.csv`, which were computed with the scenes of this
    case.
    """
    found: dict[Flow, list[Piece]] = {}
    for row, one in rheology.pieces_of("suspensions"):
        found.setdefault(Flow(row["law"], float(row["volume_fraction"]), one.rate), []).append(one)
    return {flow: merged(pieces) for flow, pieces in found.items()}


def rows_of_pieces(pieces: Mapping[Flow, Piece]) -> Iterator[Row]:
    """Rows on friction over the viscous number, on the divergence of the viscosity, and on thickening by friction."""
    yield below("largest force left on a sphere", max(one.largest_imbalance for one in pieces.values()), 1e-8)
    yield within(
        "flows whose shear stress is stationary in all runs",
        sum(one.settled for one in pieces.values()),
        len(pieces),
        0.0,
    )
    for flow in DIVERGING["frictionless"]:
        number, friction = friction_point(pieces[flow])
        name = f"friction without contact friction at J = {number.value:.2g}, φ = {flow.fraction:g}"
        expected = published_friction(number.value)
        yield within(f"{name}, ± {friction.error:.2g}; Morris and Boulay", friction.value, expected, NEAR * expected)
    yield from _rows_of_jamming(pieces)
    thin, thick = (viscosity(pieces[flow]) for flow in (THICKENING[THIN], THICKENING[THICK]))
    ratio = thick.value / thin.value
    error = ratio * math.hypot(thick.error / thick.value, thin.error / thin.value)
    yield above(f"thickening above the critical load at φ = {DENSE:g}, ± {error:.2g}", ratio, THICKER)


def _rows_of_jamming(pieces: Mapping[Flow, Piece]) -> Iterator[Row]:
    smooth, rough = (jamming(pieces, law) for law in ("frictionless", "frictional"))
    pressed, end = jamming(pieces, "frictionless", pressure_viscosity), smooth.fraction
    name = "volume fraction of jamming"
    yield within(f"{name}, ± {end.error:.3f}; Olsson and Teitel", end.value, JAMMED, 0.02)
    end = pressed.fraction
    yield within(f"{name} from the pressure, ± {end.error:.3f}; Olsson and Teitel", end.value, JAMMED, 0.02)
    worst = float(np.max([one.misfit for one in (smooth, pressed, rough)]))
    yield below("largest misfit of the divergences, per degree of freedom", worst, 3.0)
    yield above(f"{name}, above the fraction that thickens", smooth.fraction.value, DENSE)
    end = rough.fraction
    yield below(f"{name} with μ = 1, ± {end.error:.3f}; below", end.value, DENSE)


def published_friction(number: float) -> float:
    """The friction of a suspension at a viscous number J: mu = K_s/K + J + 5/2 phi_m sqrt(J/K), K = 0.8 K_n.

    From the viscosities of [morris1999], eta_s = 1 + 5/2 phi/(1 - x) + K_s x^2/(1 - x)^2 and, across the planes of
    shear, 0.8 K_n x^2/(1 - x)^2, with x = phi/phi_m, K_s = 0.1, K_n = 0.75 and phi_m = 0.68.

    >>> round(published_friction(0.0), 4), round(published_friction(0.1), 3)
    (0.1667, 0.961)
    """
    across = 0.8 * 0.75
    return 0.1 / across + number + 2.5 * 0.68 * math.sqrt(number / across)


def friction_point(piece: Piece) -> tuple[Mean, Mean]:
    """The viscous number J and the friction mu of a piece: the shear stress including that of the liquid, over the
    normal stress across the shear planes.
    """
    pressure = piece.pressure.value + 0.5 * piece.first_difference.value
    error = math.hypot(piece.pressure.error, 0.5 * piece.first_difference.error) / pressure
    liquid = VISCOSITY * piece.rate * DIAMETER
    number, friction = liquid / pressure, (piece.shear.value + liquid) / pressure
    slip = piece.shear.error / (piece.shear.value + liquid)
    return Mean(number, number * error), Mean(friction, friction * math.hypot(error, slip))


def viscosity(piece: Piece) -> Mean:
    """The shear stress of the spheres over that of the pure liquid."""
    unit = VISCOSITY * piece.rate * DIAMETER
    return Mean(piece.shear.value / unit, piece.shear.error / unit)


def pressure_viscosity(piece: Piece) -> Mean:
    """The pressure over the shear stress of the pure liquid, which diverges where the viscosity diverges."""
    unit = VISCOSITY * piece.rate * DIAMETER
    return Mean(piece.pressure.value / unit, piece.pressure.error / unit)


def jamming(pieces: Mapping[Flow, Piece], law: str, diverging: Callable[[Piece], Mean] = viscosity) -> Divergence:
    """The volume fraction at which a viscosity diverges; the exponent is fitted as well. NaN, which meets no row, where
    the viscosities do not determine it.
    """
    flows = DIVERGING[law]
    fractions = np.array([flow.fraction for flow in flows])
    try:
        return viscosity_divergence(fractions, [diverging(pieces[flow]) for flow in flows])
    except BadInput:
        unknown = Mean(math.nan, math.nan)
        return Divergence(unknown, unknown, unknown, math.nan)
