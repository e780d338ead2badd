"""Flows without a free surface, and a spinning square: the cases `taylor-green`, `poiseuille`, `cavity` and `patch`."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from ecume.laws.drops import patch_pressure
from ecume.laws.flows import couette_start, poiseuille_start, taylor_green_decay, taylor_green_velocity
from ecume.laws.kernels import kernel
from ecume.simulation import simulate
from ecume.trajectories.frame import Frame
from ecume.units import Array
from ecume_validation.runner import Row, above, below, case_scene, frames_of, read_table, within

VORTEX_SIDES = (25, 50)
VORTEX_VISCOSITY = 0.01
RATE = taylor_green_decay(2.0 * math.pi, 2.0 * math.pi, VORTEX_VISCOSITY)


class Course(NamedTuple):
    """The time series of a run, relative to the exact flow."""

    time: Array
    error: Array
    """mean error of speeds"""
    fastest: Array
    energy: Array
    volume: Array


def vortex_rows() -> list[Row]:
    """Compare runs with both resolutions, and the finer one with the published run."""
    courses = {side: vortex_course(side) for side in VORTEX_SIDES}
    errors = [float(courses[side].error[1:].max()) for side in VORTEX_SIDES]
    coarse = [below(f"{VORTEX_SIDES[0]} a side: largest error", errors[0], 0.06)]
    return [*coarse, *of_the_finer(courses[VORTEX_SIDES[1]]), above("order of the largest error", order(errors), 1.0)]


def of_the_finer(found: Course) -> list[Row]:
    """Compare the finer run with the exact flow and with PySPH."""
    swing = float(np.abs(found.fastest - 1.0).max())
    name = f"{VORTEX_SIDES[1]} a side"
    return [
        below(f"{name}: largest error", float(found.error[1:].max()), 0.03),
        below(f"{name}: largest speed over the exact one, off by", swing, 0.02),
        within(f"{name}: energy at the end over the exact one", float(found.energy[-1]), 1.0, 0.04),
        within(f"{name}: volume at the end", float(found.volume[-1]), 1.0, 0.002),
        *beside_published(found),
    ]


def beside_published(found: Course) -> list[Row]:
    """Compare the error at the nearest frame with the published one."""
    return [
        below(
            f"below PySPH's {case['scheme']}: error at t = {case['time']}",
            float(found.error[np.argmin(np.abs(found.time - float(case["time"])))]),
            float(case["error"]),
        )
        for case in read_table("taylor_green")
    ]


def vortex_course(side: int) -> Course:
    """Run the vortices at one resolution."""
    scene = case_scene("taylor_green", [f"spacing={1.0 / side!r}"])
    return Course(*np.array([judged(frame) for frame in simulate(scene)]).T)


def judged(frame: Frame) -> tuple[float, ...]:
    """The quantities of one frame."""
    faded = math.exp(-RATE * frame.time)
    x, y = 2.0 * math.pi * frame.arrays["position"].T
    exact = faded * np.hypot(taylor_green_velocity(x, y, 1.0), taylor_green_velocity(y, x, -1.0))
    speed = np.hypot(*frame.arrays["velocity"].T)
    error = float(np.abs(speed - exact).mean() / exact.mean())
    numbers = frame.numbers
    return (
        frame.time,
        error,
        float(speed.max()) / faded,
        numbers["kinetic_energy"] / (0.25 * faded**2),
        numbers["volume"],
    )


def order(errors: list[float]) -> float:
    """The order of convergence when the spacing is halved."""
    return math.log2(errors[0] / errors[1])


ACROSS = (15, 30)
CHANNEL_VISCOSITY = 0.1
EARLIEST = 0.225
"""The time (s), tau = 0.0225, before which the layer at the wall is thinner than a smoothing length."""
DRIVEN = {"poiseuille": "gravity=[0.8, 0.0]", "couette": "tank.top={velocity=[1.0, 0.0]}"}
CHANNEL_WALLS = ("mirror", "dummy")


def channel_rows() -> list[Row]:
    """Compare the series, then the runs."""
    return [*series(), *(row for flow in DRIVEN for walls in CHANNEL_WALLS for row in channel(flow, walls))]


def series() -> list[Row]:
    """The largest difference of ecume's series from the table, one row per flow."""
    worst = dict.fromkeys(DRIVEN, 0.0)
    for case in read_table("poiseuille", "independent"):
        found = exact(case["flow"], float(case["height"]), float(case["tau"]) / CHANNEL_VISCOSITY)
        worst[case["flow"]] = max(worst[case["flow"]], abs(found - float(case["speed"])))
    return [below(f"{flow}: series off the table by", off, 1e-7) for flow, off in worst.items()]


def channel(flow: str, walls: str) -> list[Row]:
    """Compare one flow with one kind of walls at both resolutions."""
    bound = float(read_table("poiseuille")[0]["largest_error"])
    errors = [largest_error(flow, [DRIVEN[flow], f"tank.walls={walls}", f"spacing={1.0 / n!r}"]) for n in ACROSS]
    name = f"{flow}, {walls}"
    return [
        below(f"{name}: largest error, {ACROSS[0]} across", errors[0], 4.0 * bound),
        below(f"{name}: largest error, {ACROSS[1]} across", errors[1], bound),
        above(f"{name}: order", math.log2(errors[0] / errors[1]), 1.3),
    ]


def largest_error(flow: str, changes: Sequence[str]) -> float:
    """The largest error of all particles over all frames."""
    frames = [frame for frame in frames_of("poiseuille", changes) if frame.time >= EARLIEST - 1e-9]
    return max(error(flow, frame) for frame in frames)


def error(flow: str, frame: Frame) -> float:
    """The largest error in a frame."""
    speed, height = frame.arrays["velocity"][:, 0], np.clip(frame.arrays["position"][:, 1], 0.0, 1.0)
    return float(np.abs(speed - [exact(flow, y, frame.time) for y in height]).max())


def exact(flow: str, height: float, time: float) -> float:
    """The exact speed, in units of the largest final speed."""
    if flow == "couette":
        return couette_start(height, time, 1.0, CHANNEL_VISCOSITY, 1.0)
    return poiseuille_start(height, time, 1.0, CHANNEL_VISCOSITY, 8.0 * CHANNEL_VISCOSITY)


CAVITY_SIDES = (25, 50)
STEADY = 12.0
LINES = {"u": 0, "v": 1}
CAVITY_WALLS = ((0, 0.0, (0.0, 0.0)), (0, 1.0, (0.0, 0.0)), (1, 0.0, (0.0, 0.0)), (1, 1.0, (2.0, 0.0)))
"""Axis and place of each wall, and twice its velocity."""


class Found(NamedTuple):
    """The errors and the volume of a run."""

    errors: dict[str, float]
    """the largest on each line"""
    volume: float


def cavity_rows() -> list[Row]:
    """Compare runs of both resolutions."""
    coarse, fine = (found(side) for side in CAVITY_SIDES)
    largest = [max(one.errors.values()) for one in (coarse, fine)]
    published = read_table("cavity")
    peers = {case["line"]: float(case["value"]) for case in published if case["quantity"] == "largest error"}
    return [
        below(f"{CAVITY_SIDES[0]} a side: largest error", largest[0], 0.03),
        *(below(f"{CAVITY_SIDES[1]} a side: largest error of {line}", fine.errors[line], 0.015) for line in LINES),
        *(
            below(f"{CAVITY_SIDES[1]} a side: error of {line} below PySPH's", fine.errors[line], peers[line])
            for line in LINES
        ),
        above("order of the largest error", math.log2(largest[0] / largest[1]), 1.0),
        within("volume at the end", fine.volume, 1.0, 0.005),
    ]


def found(side: int) -> Found:
    """Run one resolution, and return the errors of the velocities on the lines, averaged over the last frames."""
    frames = [frame for frame in frames_of("cavity", [f"spacing={1.0 / side!r}"]) if frame.time >= STEADY]
    errors = {}
    for line, component in LINES.items():
        places, expected = table(line)
        found = np.mean([velocity_at(frame, places, 2.0 / side)[:, component] for frame in frames], axis=0)
        errors[line] = float(np.abs(found - expected).max())
    return Found(errors, frames[-1].numbers["volume"])


def table(line: str) -> tuple[Array, Array]:
    """The places and velocities of a published table (n, 2)."""
    cases = [case for case in read_table("cavity", "independent") if case["line"] == line]
    along = np.array([float(case["place"]) for case in cases])
    middle = np.full(len(along), 0.5)
    places = np.stack([middle, along] if line == "u" else [along, middle], axis=1)
    return places, np.array([float(case["velocity"]) for case in cases])


def velocity_at(frame: Frame, places: Array, smoothing: float) -> Array:
    """The velocities at places (n, 2), from a linear fit to the surrounding particles with the kernel as weight."""
    position, velocity = completed(frame, 2.0 * smoothing)
    shape, fitted = kernel("wendland-c2", dim=2), []
    for place in places:
        away = position - place
        weight = np.asarray(shape.value(np.hypot(*away.T), smoothing))
        near = weight > 0.0
        basis = np.column_stack([np.ones(int(near.sum())), away[near]])
        weighed = basis.T * weight[near]
        fitted.append(np.linalg.solve(weighed @ basis, weighed @ velocity[near])[0])
    return np.array(fitted)


def completed(frame: Frame, reach: float) -> tuple[Array, Array]:
    """Positions and velocities of the particles, and of their mirror images at walls."""
    position, velocity = frame.arrays["position"], frame.arrays["velocity"]
    for axis, wall, twice in CAVITY_WALLS:
        near = np.abs(position[:, axis] - wall) < reach
        image = position[near].copy()
        image[:, axis] = 2.0 * wall - image[:, axis]
        position = np.concatenate([position, image])
        velocity = np.concatenate([velocity, np.array(twice) - velocity[near]])
    return position, velocity


MIDDLE = -147.34
"""The initial pressure in the middle (Pa)."""


def patch_rows() -> list[Row]:
    """Compare the series, then runs of two resolutions, then a run without shifting."""
    coarse, fine, bare = patch_course(0.05), patch_course(0.025), patch_course(0.025, "method.shifting=none")
    return [
        below("series off the table by", off_the_table(), 1e-6),
        within("20 a side: pressure in the middle (Pa)", early(coarse), MIDDLE, 7.4),
        within("40 a side: pressure in the middle (Pa)", early(fine), MIDDLE, 7.4),
        within("angular momentum, shifted", spin(fine[-1]) / spin(fine[0]), 1.0, 0.005),
        within("angular momentum, not shifted", spin(bare[-1]) / spin(bare[0]), 1.0, 0.005),
        above("energy of motion left", fine[-1].numbers["kinetic_energy"] / fine[0].numbers["kinetic_energy"], 0.95),
        within("volume", fine[-1].numbers["volume"], 1.0, 0.005),
        above("nearest neighbors, shifted", nearest(fine[-1]), 0.8),
        below("nearest neighbors, not shifted", nearest(bare[-1]), 0.8),
    ]


def patch_course(spacing: float, *changes: str) -> list[Frame]:
    """One run."""
    return list(frames_of("patch", [f"spacing={spacing!r}", *changes]))


def off_the_table() -> float:
    """The largest difference of ecume's series from the table."""
    table = [[float(value) for value in case.values()] for case in read_table("patch", "independent")]
    return max(abs(patch_pressure(x, y, 1.0, -2.0, 1.0) - pressure) for x, y, pressure in table)


def early(frames: list[Frame]) -> float:
    """The mean pressure in the middle (Pa), while sound crosses the patch a few times."""
    first = [frame for frame in frames if 0.0 < frame.time < 0.35]
    return float(np.mean([frame.arrays["pressure"][inner(frame, 0.1)].mean() for frame in first]))


def inner(frame: Frame, radius: float) -> np.typing.NDArray[np.bool_]:
    """The particles near the middle."""
    near: np.typing.NDArray[np.bool_] = np.hypot(*frame.arrays["position"].T) < radius
    return near


def spin(frame: Frame) -> float:
    """Angular momentum (kg m^2/s)."""
    x, v = frame.arrays["position"], frame.arrays["velocity"]
    return float(np.sum(frame.arrays["mass"] * (x[:, 0] * v[:, 1] - x[:, 1] * v[:, 0])))


def nearest(frame: Frame) -> float:
    """The mean distance of nearest neighbors in the middle, over that of a lattice with the same number density."""
    place = frame.arrays["position"][inner(frame, 0.25)]
    apart = np.linalg.norm(place[:, None] - place[None], axis=2) + 10.0 * np.eye(len(place))
    lattice = np.sqrt(np.pi * 0.25**2 / len(place))
    return float(apart.min(axis=1).mean() / lattice)
