"""Floats that release surfactant, such as camphor discs: the case `surfactant`.

Speeds and forces on the grid are compared with closed forms on an infinite surface, and with bound states; the
dependence of the speed on the radius is compared with the published one.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from typing import Any, NamedTuple

import numpy as np

from ecume.laws import camphor
from ecume.laws.capillarity import pair_force
from ecume.laws.drag import disc_friction
from ecume.models import MODELS
from ecume.scenes.schema import from_plain
from ecume.simulation import simulate
from ecume.units import Array, Length
from ecume_validation.runner import Row, above, below, read_table, within

WATER = {"density": 998.0, "viscosity": 1e-3, "surface_tension": 0.0728}
SYRUP = {"density": 1000.0, "viscosity": 0.1, "surface_tension": 0.072}
SLOPE, DIFFUSIVITY = 10.0, 1e-4
"""N m/kg and m^2/s."""
LEVEL = 0.5 * math.pi

RADIUS, LOSS, RELEASE = 1.5e-3, 20.0, 4e-7
"""Of the disc that swims: m, 1/s, kg/s."""
SWIM, SWIM_STEP = 0.2, 2.5e-4
SPACINGS = (7.5e-4, 3.75e-4)
"""m: two and four cells per radius."""


def surfactant_rows() -> list[Row]:
    """Compare a single disc, the dependence on its radius, a bound pair of sources, and a source with an inert
    float.
    """
    return [*lone_disc(), *sizes(), *bound_sources(), *source_and_inert_float()]


def surfactant(loss_rate: float, spacing: Length, release: float, species: str = "") -> dict[str, Any]:
    """The table of a surfactant."""
    return {
        "diffusivity": DIFFUSIVITY, "tension_slope": SLOPE, "loss_rate": loss_rate, "spacing": spacing,
        "sources": [{"release": release, "species": species}],
    }  # fmt: skip


def lone_disc() -> Iterator[Row]:
    """The speed of a single disc on two grids, over that in closed form."""
    coarse, fine = (1.0 - swimming(spacing) for spacing in SPACINGS)
    yield within("lone disc, 4 cells per radius: speed over the closed form", 1.0 - fine, 1.0, 0.05)
    yield below("lone disc, 4 cells per radius: error of the speed over that with 2", fine / coarse, 0.5)


def swimming(spacing: Length) -> float:
    """The speed of a disc in a cell, over that in closed form."""
    scene = from_plain({
        "model": "floating", "duration": SWIM, "frame_every": SWIM, "liquid": WATER, "cell": {"size": [0.06, 0.06]},
        "surfactant": surfactant(LOSS, spacing, RELEASE), "interaction": {"law": "none"},
        "hydrodynamics": {"drag": "stokes"}, "integration": {"integrator": "overdamped", "time_step": SWIM_STEP},
        "particles": [{"radius": RADIUS, "density": 980.0, "contact_angle": LEVEL, "positions": [[0.03, 0.03]],
                       "velocity": [0.38, 0.15]}],
    })  # fmt: skip
    floats = MODELS["floating"].parameters(scene).floats
    friction = float(floats.mass[0] / floats.relaxation_time[0])
    *_, last = simulate(scene)
    law = camphor.swimming_speed(friction, RADIUS, SLOPE * RELEASE, DIFFUSIVITY, LOSS)
    return float(np.hypot(*last.arrays["velocity"][0])) / law


RADII = (1e-3, 15e-3)
"""m, as measured."""
PER_AREA = 0.02
"""kg/(m^2 s): a release in proportion to the area."""
VISCOSITY, DENSITY = 1e-3, 998.0


def sizes() -> Iterator[Row]:
    """Compare the exponent of the speed over the radius, with two laws of drag, with the measured one."""
    measured = next(float(row["value"]) for row in read_table("surfactant") if row["quantity"] == "exponent")
    stokes = exponent([stokes_speed(radius) for radius in RADII])
    yield within("exponent of speed over radius, Stokes drag; the published plane model has 1/2", stokes, 0.5, 0.02)
    yield within("exponent with Stokes drag beside the measured one", stokes, measured, 0.05)
    fast = exponent([fast_speed(radius) for radius in RADII])
    yield within("exponent with drag at finite Reynolds number beside the measured one", fast, measured, 0.05)


def exponent(speeds: list[float]) -> float:
    """The exponent of speeds over `RADII`."""
    return math.log(speeds[1] / speeds[0]) / math.log(RADII[1] / RADII[0])


def stokes_speed(radius: Length) -> float:
    """The speed (m/s) of a disc with one wet side, without loss of surfactant."""
    drive = SLOPE * PER_AREA * math.pi * radius**2
    return camphor.swimming_speed(disc_friction(radius, VISCOSITY), radius, drive, 1e-8, 0.0)


def fast_speed(radius: Length) -> float:
    """The speed (m/s) of such a disc with a drag that depends on its Reynolds number."""
    drive = SLOPE * PER_AREA * math.pi * radius**2
    return camphor.swimming_speed(disc_friction(radius, VISCOSITY), radius, drive, 1e-8, 0.0, DENSITY / VISCOSITY)


RADIUS_OF_PAIR, BOUND, SHORT, FINE = 1e-3, 3.5e-3, 100.0, 2.5e-4
"""Of bound spheres: radius and distance in closed form (m), loss rate (1/s), and spacing of the grid (m)."""


class Pair(NamedTuple):
    """Two equal spheres on a viscous liquid; one or both release surfactant."""

    density: float
    both: bool
    start: Array
    """(2, 2) m"""
    duration: float

    def scene(self, release: float) -> Any:
        """The scene of the pair in a dish with a level surface."""
        sphere = {"radius": RADIUS_OF_PAIR, "density": self.density, "contact_angle": LEVEL}
        spheres = [{**sphere, "name": name, "positions": [place]}
                   for name, place in zip(("source", "inert"), self.start.tolist(), strict=True)]  # fmt: skip
        return from_plain({
            "model": "floating", "duration": self.duration, "frame_every": self.duration / 20, "liquid": SYRUP,
            "dish": {"radius": 0.012, "contact_angle": LEVEL}, "particles": spheres, "gravity": 9.81,
            "surfactant": surfactant(SHORT, FINE, release, "" if self.both else "source"),
            "hydrodynamics": {"drag": "stokes"}, "integration": {"integrator": "overdamped", "time_step": 4e-3},
        })  # fmt: skip

    def release(self) -> tuple[float, float]:
        """The release at which they are bound at `BOUND` (kg/s), and its ratio to that at which a single sphere swims.

        Two sources: their repulsion balances the attraction F of their menisci. A source and an inert sphere move at a
        speed v with F = (zeta - f) v, where f v is the propulsion of the source, and repulsion - F = zeta v.
        """
        floats = MODELS["floating"].parameters(self.scene(1e-9)).floats
        length = math.sqrt(SYRUP["surface_tension"] / (SYRUP["density"] * 9.81))
        strength = 2.0 * math.pi * SYRUP["surface_tension"] * float(floats.charge[0]) ** 2
        attraction = -pair_force(BOUND, strength, length)
        per_release = camphor.source_repulsion(BOUND, RADIUS_OF_PAIR, SLOPE, DIFFUSIVITY, SHORT)
        threshold = camphor.threshold_friction(RADIUS_OF_PAIR, SLOPE, DIFFUSIVITY, SHORT)
        swims = float(floats.mass[0] / floats.relaxation_time[0]) / threshold
        ratio, times = 0.0, 1.0
        for _ in range(1 if self.both else 20):
            times = 1.0 if self.both else 1.0 + 1.0 / (1.0 - ratio)
            ratio = times * attraction / per_release / swims
        return times * attraction / per_release, ratio

    def tracks(self) -> Array:
        """The positions over time, (frames, 2, 2) m."""
        return np.array([frame.arrays["position"] for frame in simulate(self.scene(self.release()[0]))])


def apart(tracks: Array) -> Array:
    """The distance of the spheres in each frame (m)."""
    return np.asarray(np.hypot(*(tracks[:, 1] - tracks[:, 0]).T))


def bound_sources() -> Iterator[Row]:
    """Compare the distance of two sources that repel by surfactant and attract by menisci, approached from both
    sides.
    """
    for start in (2.6e-3, 4.2e-3):
        pair = Pair(3000.0, True, np.array([[-0.5 * start, 0.0], [0.5 * start, 0.0]]), 2.0)
        name = f"two sources from {1e3 * start:g} mm: bound distance over the closed form"
        yield within(name, float(apart(pair.tracks())[-1]) / BOUND, 1.0, 0.02)


def source_and_inert_float() -> Iterator[Row]:
    """Compare the motion of a source and an inert sphere: a single source is at rest; the pair swims with the inert
    sphere in front.
    """
    source, heading = np.array([-2e-3, -1e-3]), np.array([math.cos(0.4), math.sin(0.4)])
    pair = Pair(1500.0, False, np.array([source, source + 3.3e-3 * heading]), 6.0)
    tracks = pair.tracks()
    distance, motion = apart(tracks), tracks[-1].mean(axis=0) - tracks[-5].mean(axis=0)
    ahead = (tracks[-1, 1] - tracks[-1, 0]) / distance[-1]
    yield below("source alone: release over that at which it swims", pair.release()[1], 1.0)
    yield above("source and inert sphere: displacement in 1.2 s (mm)", 1e3 * float(np.hypot(*motion)), 0.5)
    front = float(ahead @ motion / np.hypot(*motion))
    yield within("source and inert sphere: cosine of the inert one to the front", front, 1.0, 1e-3)
    spread = float(np.ptp(distance[-5:])) / float(distance[-1])
    yield below("source and inert sphere: change of their distance in 1.2 s, over it", spread, 0.01)
    name = "source and inert sphere: distance over the closed form for slow motion"
    yield within(name, float(distance[-1]) / BOUND, 1.0, 0.03)
