"""Active floats and floats driven by fields or waves: the cases `activity`, `swimmers` and `waves`."""

from __future__ import annotations

import csv
import math
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np

from ecume.analysis.structure import mean_square_displacement
from ecume.laws.radiated_waves import ripples
from ecume.laws.water_waves import wave_frequency
from ecume.models import MODELS
from ecume.models.floating.forces.activity import Activity
from ecume.models.floating.forces.waves import Waves
from ecume.models.floating.setup.kinds import turning_frictions
from ecume.scenes.floating import FloatingScene
from ecume.scenes.schema import from_plain
from ecume.simulation import simulate
from ecume.units import Array, Length
from ecume_validation.hydrodynamics import Run
from ecume_validation.runner import Row, above, below, within

COUNT, RADIUS, FORCE = 2000, 1e-5, 1e-12
MEMORY, EVERY, FRAMES = 0.5, 0.1, 600
"""The correlation time (s), the time between frames, and their number."""
LAGS = (1, 2, 5, 10)
TORQUE = 6e-17
"""The torque (N m) rotates the heading by more than a radian in one correlation time."""
ACTIVITY_TOLERANCE = 0.01
KINDS = {
    "random force": {"force": FORCE, "persistence": MEMORY},
    "propulsion": {"propulsion": FORCE, "rotational_diffusion": 1.0 / MEMORY},
    "propulsion and torque": {"propulsion": FORCE, "rotational_diffusion": 1.0 / MEMORY, "torque": TORQUE},
}


def activity_rows() -> list[Row]:
    """Compare each kind of activity at several times."""
    return [row for name in KINDS for row in displacements(name)]


def activity_scene_of(name: str) -> FloatingScene:
    """The scene of free floats on a lattice with this kind of activity."""
    bead = {
        "radius": RADIUS, "density": 1500.0, "contact_angle": 1.2, "count": COUNT, "placement": "lattice",
        "spacing": 5e-2,
    }  # fmt: skip
    scene = from_plain({
        "model": "floating", "duration": EVERY * FRAMES, "frame_every": EVERY, "seed": 4, "particles": [bead],
        "activity": KINDS[name], "integration": {"integrator": "overdamped"}, "interaction": {"law": "none"},
        "contacts": {"law": "none"},
    })  # fmt: skip
    assert isinstance(scene, FloatingScene)  # noqa: S101  # its model is that
    return scene


def displacements(name: str) -> Iterator[Row]:
    """The mean squared displacement over its closed form."""
    scene = activity_scene_of(name)
    speed = FORCE * float(MODELS["floating"].parameters(scene).kick.gain[0])
    turning = KINDS[name].get("torque", 0.0) / float(turning_frictions(scene)[0])
    tracks = np.array([frame.arrays["position"] for frame in simulate(scene)])
    found = mean_square_displacement(tracks, LAGS)
    for lag, square in zip(LAGS, found, strict=True):
        ratio = float(square) / persistent_displacement(speed, 1.0 / MEMORY, turning, EVERY * lag)
        yield within(
            f"{name}: displacement squared after {EVERY * lag:g} s, over theory", ratio, 1.0, ACTIVITY_TOLERANCE
        )


def persistent_displacement(speed: float, rate: float, turning: float, time: float) -> float:
    """The mean squared displacement of a velocity with the correlation v^2 e^(-D t) cos(w t): the real part of
    2 v^2 (t/k - (1 - e^(-k t))/k^2) with k = D - i w.
    """
    decay = complex(rate, -turning)
    exponential = np.exp(-decay * time)
    return 2.0 * speed**2 * float(((time / decay) - (1.0 - exponential) / decay**2).real)


RADII = (2.0e-4, 2.5e-4, 3.0e-4)
PLACES = ((-1.2e-3, 0.0), (0.0, 0.0), (1.3e-3, 0.0))
SIDE = 1.4e-3
"""The initial side of the triangle (m)."""
FREQUENCY, PERIODS, PER_PERIOD = 0.2, 6, 200
"""The frequency of the field (Hz), the number of periods, and frames per period."""
SWIMMER_STEP = 2.5e-5
SWIMMER_TOLERANCE = 0.2


def swimmer_rows() -> list[Row]:
    """Compare spheres in a row, and triangles."""
    return [*in_a_row(), *triangles()]


def swimmer_scene_of(radii: tuple[float, ...], places: Any, *, interaction: str = "rotne-prager") -> dict[str, Any]:
    """Steel spheres on a viscous liquid in a vertical field, and a horizontal one that oscillates."""
    spheres = [
        {"radius": radius, "density": 7830.0, "contact_angle": 0.5 * math.pi, "positions": [list(place)]}
        for radius, place in zip(radii, places, strict=True)
    ]
    return {
        "model": "floating", "duration": PERIODS / FREQUENCY, "frame_every": 1.0 / (FREQUENCY * PER_PERIOD),
        "liquid": {"density": 1000.0, "viscosity": 0.05, "surface_tension": 0.0728}, "particles": spheres,
        "integration": {"integrator": "overdamped", "time_step": SWIMMER_STEP},
        "hydrodynamics": {"interaction": interaction},
        "magnetic_field": {"constant": [1e-3, 0.0, 4e-3], "amplitude": [1e-3, 0.0, 0.0],
                           "frequency": FREQUENCY, "susceptibility": 1e6},
    }  # fmt: skip


def motion(scene: dict[str, Any]) -> Array:
    """Simulate a scene. Returns the positions (frames, 3, 2)."""
    return np.array([frame.arrays["position"] for frame in simulate(from_plain(scene))])


def friction_of(scene: dict[str, Any]) -> Array:
    """The friction of each sphere, over that of the first."""
    floats = MODELS["floating"].parameters(from_plain(scene)).floats
    friction = floats.mass / floats.relaxation_time
    return np.asarray(friction / friction[0])


def stroke(track: Array, friction: Array) -> Array:
    """The displacement in the last period (m), of the center weighted by friction."""
    center = (friction[:, None] * track).sum(axis=1) / friction.sum()
    return np.asarray(center[-1] - center[-1 - PER_PERIOD])


def closed_form(track: Array, size: Array) -> Length:
    """The displacement of three spheres in a row in one period, from the area of the loop of their distances: K times
    half the integral of L_1 dL_2 - L_2 dL_1, with K = 3 a_1 a_2 a_3/(a_1 + a_2 + a_3)^2 [1/L_1^2 + 1/L_2^2 - 1/(L_1 +
    L_2)^2]. [golestanian2008].
    """
    one, two = np.diff(track[-1 - PER_PERIOD :, :, 0], axis=1).T
    area = 0.5 * float(np.sum(one[:-1] * np.diff(two) - two[:-1] * np.diff(one)))
    first, second = float(one[:-1].mean()), float(two[:-1].mean())
    near = 1.0 / first**2 + 1.0 / second**2 - 1.0 / (first + second) ** 2
    return 3.0 * float(np.prod(size)) / float(np.sum(size)) ** 2 * near * area


def in_a_row() -> Iterator[Row]:
    """Compare the displacement in a period, its sign, and swimmers without net motion."""
    scene = swimmer_scene_of(RADII, PLACES)
    friction = friction_of(scene)
    track = motion(scene)
    found = float(stroke(track, friction)[0])
    expected = closed_form(track, RADII[0] * friction)
    yield within("in a row: displacement per period, over the closed form", found / expected, 1.0, SWIMMER_TOLERANCE)
    yield above("in a row: displacement toward the smallest sphere (um)", -1e6 * found, 0.5)
    mirrored = swimmer_scene_of(RADII[::-1], [(-x, y) for x, y in PLACES[::-1]])
    turned = float(stroke(motion(mirrored), friction[::-1])[0])
    yield within("in the reverse order: displacement over that before", turned / found, -1.0, 1e-3)
    equal = swimmer_scene_of((RADII[1],) * 3, [(-1.25e-3, 0.0), (0.0, 0.0), (1.25e-3, 0.0)])
    still = float(stroke(motion(equal), np.ones(3))[0])
    yield below("equal spheres: displacement over that of unequal ones", abs(still / found), 1e-6)
    alone = float(stroke(motion(swimmer_scene_of(RADII, PLACES, interaction="none")), friction)[0])
    yield below("without hydrodynamic interaction: displacement over that with it", abs(alone / found), 1e-6)


def triangles() -> Iterator[Row]:
    """Compare three equal spheres with one side along the field, and turned by 180 degrees."""
    low, high = 0.5 * SIDE / math.sqrt(3.0), SIDE / math.sqrt(3.0)
    found = {}
    for up in (1.0, -1.0):
        places = [(-0.5 * SIDE, -up * low), (0.5 * SIDE, -up * low), (0.0, up * high)]
        found[up] = stroke(motion(swimmer_scene_of((RADII[1],) * 3, places)), np.ones(3))
    across = float(found[1.0][1])
    yield above("triangle: displacement per period toward the apex (nm)", 1e9 * across, 1.0)
    yield below("triangle: displacement along the field, over that across it", abs(float(found[1.0][0]) / across), 1e-3)
    yield within(
        "triangle turned by 180 degrees: displacement over that before", float(found[-1.0][1]) / across, -1.0, 1e-3
    )


DATA = Path(__file__).parent / "data" / "waves"
GRAVITY = 9.81
BATH = {"density": 1149.5, "viscosity": 0.01, "surface_tension": 0.067}
"""Water and glycerol, of the public program of the spinners."""
FREQUENCIES = (40.0, 90.0, 250.0)

ARM, POINTS, SPEED, RELAXATION, INERTIA = 5.7e-3, 8, 0.19, 0.53, 0.64e-9
"""Properties of a spinner: length of an arm (m), points on it, free rotation (rad/s), relaxation time (s), moment of
inertia (kg m^2).
"""
SPINNING, SHAKEN, SHARE = 90.0, 1.6 * GRAVITY, 0.15
"""Frequency (Hz), acceleration of the bath (m/s^2), and the relative amplitude of a spinner."""
THIRD = math.pi / 3.0
"""The period of phase differences, by the threefold symmetry of a spinner; they are also equal up to sign."""
LOCKED, STARTS = (27.0, 28.0, 29.0, 30.0), (0.15, 0.9)
"""Distances of spinners (mm), and their initial phase differences (rad)."""
TURNS, WAVE_STEP = 6, 0.01
"""The number of turns of a spinner, and the time step (s)."""

SURFER = {"radius": 2e-3, "density": 1100.0, "disc": {"thickness": 0.5e-3}}
SURFING, PRESS, PROPULSION = 100.0, 1.2e-4, 2e-6
"""Frequency (Hz), force of each source (N), and propulsion (N) of surfers."""
SPACINGS = np.arange(5e-3, 15e-3, 0.8e-3)
"""The initial distances of two surfers side by side (m)."""
APART, SURFED = 0.3, 60.0
"""The distance of pairs from one another (m), and the duration (s)."""


def wave_rows() -> list[Row]:
    """Compare dispersion, surfers and spinners."""
    return [*dispersion(), *surfers(), *spinners()]


def dispersion() -> Iterator[Row]:
    """Compute the frequency of a wave with the kernel's wavelength, over the frequency of the source, without
    viscosity.
    """
    for frequency in FREQUENCIES:
        found = ripples(frequency, 1000.0, 0.07, 1e-9, GRAVITY)
        omega = wave_frequency(2.0 * math.pi / found.wavelength, 1.0, GRAVITY, 0.07 / 1000.0)
        yield within(f"dispersion at {frequency:g} Hz", omega / (2.0 * math.pi * frequency), 1.0, 1e-6)


def surfers() -> Iterator[Row]:
    """Compare the number of stable spacings of two surfers side by side, and their distances."""
    found = np.sort(final_spacings())
    bound = np.split(found, np.flatnonzero(np.diff(found) > 5e-4) + 1)
    spread = max(float(np.ptp(each)) for each in bound)
    spacings = np.array([each.mean() for each in bound])
    length = ripples(SURFING, BATH["density"], BATH["surface_tension"], BATH["viscosity"], GRAVITY).wavelength
    yield above("two surfers side by side: bound states", float(len(bound)), 2.5)
    yield below("two surfers side by side: spread of a bound spacing, over the wavelength", spread / length, 0.02)
    for number, apart in enumerate(np.diff(spacings) / length, 1):
        name = f"bound spacing {number + 1} less spacing {number}, over the wavelength"
        yield within(name, float(apart), 1.0, 0.05)


def final_spacings() -> Array:
    """The final distances of pairs of surfers that swim along y (m), for all `SPACINGS`. Pairs are too far from each
    other to interact by waves.
    """
    starts = enumerate(SPACINGS.tolist())
    places = [[APART * pair + 0.5 * side * start, 0.0] for pair, start in starts for side in (-1, 1)]
    sources = [{"place": [1.2e-3, 0.0], "force": PRESS}, {"place": [-1.2e-3, 0.0], "force": PRESS}]
    scene = from_plain({
        "model": "floating", "duration": SURFED, "frame_every": SURFED, "liquid": BATH, "interaction": {"law": "none"},
        "particles": [{**SURFER, "positions": places}],
        "waves": {"frequency": SURFING, "sources": sources, "headings": [0.5 * math.pi] * len(places)},
        "activity": {"propulsion": PROPULSION},
    })  # fmt: skip
    *_, last = simulate(scene)
    return np.asarray(np.linalg.norm(np.diff(last.arrays["position"].reshape(-1, 2, 2), axis=1)[:, 0], axis=1))


def spinner_points() -> Array:
    """The points of the three curved arms of a spinner (points, 2) (m), from the public program."""
    along = np.linspace(0.0, ARM * math.cos(math.radians(20.0)), POINTS)
    arm = turned(np.column_stack([along, math.tan(math.radians(20.0)) * along]), -math.radians(2.5))
    arm = (arm + np.array([-1.622e-3, 0.876e-3])) * np.array([-1.0, 1.0])
    return np.concatenate([turned(arm, 2.0 * math.pi / 3.0 * number) for number in (0, 2, 1)])


def turned(places: Array, angle: float) -> Array:
    """Places rotated about the origin."""
    c, s = math.cos(angle), math.sin(angle)
    return np.asarray(places @ np.array([[c, s], [-s, c]]))


def spinners() -> Iterator[Row]:
    """Compare the phase differences at which two spinners at a fixed distance lock with measured ones."""
    with (DATA / "published-phases.csv").open(encoding="utf-8") as file:
        measured = [
            (float(row["distance"]), float(row["phase"])) for row in csv.DictReader(file) if row["compared"] == "yes"
        ]
    for distance in LOCKED:
        found = [locked_phase(1e-3 * distance, start) for start in STARTS]
        name = f"spinners {distance:g} mm apart"
        yield below(f"{name}: drift of the phase in a turn (rad)", max(slip for _, slip in found), 0.02)
        for phase in (phase for at, phase in measured if at == distance):
            nearest = min((folded(one) for one, _ in found), key=lambda one: abs(one - phase))
            yield within(f"{name}: phase difference (rad), beside a measured one", nearest, phase, 0.1)


def folded(phase: float) -> float:
    """A phase difference mapped to the range from 0 to pi/3.

    >>> round(folded(2.0 * math.pi / 3.0 - 0.1), 9)
    0.1
    """
    rest = phase % (2.0 * THIRD)
    return min(rest, 2.0 * THIRD - rest)


def locked_phase(distance: float, start: float) -> tuple[float, float]:
    """The phase difference of two spinners after some turns (rad), and its change in the last turn."""
    run = spinner_run(distance, start)
    places, phases = run.state.position.copy(), []
    every = round(2.0 * math.pi / SPEED / WAVE_STEP / 50)
    for _ in range(50 * TURNS):
        for _ in range(every):
            run.advance(1)
            run.state.position[:], run.state.velocity[:] = places, 0.0
        angle = run.state.turning[:, 0] + run.state.active[:, 2]
        phases.append(float(angle[1] - angle[0]))
    last, before = np.mean(phases[-50:]), np.mean(phases[-100:-50])
    return float(last), abs(float(last - before))


def spinner_run(distance: float, start: float) -> Run:
    """Two spinners with the inertia, friction and free rotation of the public program."""
    points = spinner_points()
    omega = 2.0 * math.pi * SPINNING
    force = INERTIA / float(np.sum(points**2)) * SHARE * SHAKEN
    radius = 1.05 * float(np.hypot(*points.T).max())
    scene: dict[str, Any] = {
        "duration": 1.0, "frame_every": 1.0, "liquid": BATH, "interaction": {"law": "none"},
        "particles": [{"radius": radius, "density": 1100.0, "disc": {"thickness": 5e-4},
                       "positions": [[0.0, 0.0], [distance, 0.0]]}],
        "waves": {"frequency": omega / (2.0 * math.pi), "headings": [0.0, start],
                  "sources": [{"place": place, "force": force} for place in points.tolist()]},
        "activity": {"torque": 1e-9},
    }  # fmt: skip
    run = Run(scene)
    parts, count = [], 2
    for part in run.parameters.parts.interactions:
        if isinstance(part, Waves):
            part = part._replace(inertia=np.full(count, INERTIA), friction=np.full(count, INERTIA / RELAXATION))
        if isinstance(part, Activity):
            part = part._replace(turning=np.full(count, SPEED))
        parts.append(part)
    chosen = run.parameters.parts._replace(interactions=tuple(parts))
    run.parameters = run.parameters._replace(parts=chosen, time_step=WAVE_STEP)
    run.workspace = run.model.workspace(run.parameters, run.state, 1.0)
    return run
