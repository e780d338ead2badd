"""Dispersion of particles: displacements, residence times, breakthrough, concentration, deposition.

All functions read the frames of a run. Errors are standard errors: of groups of particles for moments, of counts
otherwise. Particles are included while they are inside. `dataset` makes a dataset of xarray in which each particle is a
trajectory, by the CF conventions.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, NamedTuple

import numpy as np

from ecume.analysis.series import Flags, inside, times, tracks, unwrapped
from ecume.errors import BadInput, install
from ecume.trajectories.frame import Frame
from ecume.units import Array

Frames = Sequence[Frame]

GROUPS = 10
"""Groups of particles, between which moments are compared for their errors."""


EPOCH = "1970-01-01"
"""The date at time 0 in files: the CF conventions have no times without one."""


class Course(NamedTuple):
    """A quantity over time, with its standard error."""

    time: Array
    """(T,) s"""
    value: Array
    """(T, ...)"""
    error: Array
    """(T, ...)"""


def _paths(frames: Frames) -> Array:
    """Tracks (T, N, d) of the particles that are inside in all frames. If particles enter later, displacements of all
    particles by the number of frames since they entered, NaN after their exit. Raises BadInput for fewer than two
    particles.
    """
    paths = tracks(frames)
    there = np.isfinite(paths).all(axis=2)
    entered = there.argmax(axis=0) if len(frames) else np.zeros(paths.shape[1], int)
    if entered.any():
        return _since_entering(paths[:, there.any(axis=0)], entered[there.any(axis=0)], times(frames))
    whole = there.all(axis=0)
    if whole.sum() < 2:
        raise BadInput(f"{int(whole.sum())} particles are inside in all frames; expected two or more")
    return paths[:, whole]


def _since_entering(paths: Array, entered: Any, instants: Array) -> Array:
    """Displacements by the number of frames since each particle entered, as long as at least two are inside."""
    intervals = np.diff(instants)
    if not np.allclose(intervals, intervals[0], rtol=1e-6):
        raise BadInput("particles enter during the run, and intervals between frames differ; expected equal ones")
    row = np.arange(len(paths))[:, None] + entered
    moved = np.take_along_axis(paths, np.minimum(row, len(paths) - 1)[:, :, None], axis=0)
    moved[row >= len(paths)] = np.nan
    moved -= moved[0]
    enough = (np.isfinite(moved[:, :, 0]).sum(axis=1) >= 2).argmin() or len(moved)
    return np.asarray(moved[:enough])


def _mean(values: Array) -> Array:
    """The mean over the particles (T, N, d) that are inside."""
    with np.errstate(invalid="ignore"):
        found: Array = np.nansum(values, axis=1) / np.isfinite(values).sum(axis=1)
    return found


def _of_groups(values: Array, measure: Any) -> tuple[Array, Array]:
    """A measure of (T, N, ...) over particles, and its error from groups of particles, each of which contains early and
    late ones.
    """
    groups = min(GROUPS, values.shape[1] // 2)
    parts = np.array([measure(values[:, group::groups]) for group in range(groups)])
    spread = parts.std(axis=0, ddof=1) if len(parts) > 1 else np.full_like(parts[0], np.nan)
    return np.asarray(measure(values)), spread / np.sqrt(len(parts))


def displacements(frames: Frames, *, without_drift: bool = False) -> Course:
    """The mean square displacement since the first frame along each axis, (T, d) in m^2; with `without_drift` minus the
    square of the mean displacement. It includes the particles that are inside in all frames. If particles enter later,
    it includes all as long as they are inside, as a function of the time since they entered.
    """

    def measure(way: Array) -> Array:
        square = _mean(way**2)
        return square - _mean(way) ** 2 if without_drift else square

    paths = _paths(frames)
    return Course(times(frames)[: len(paths)] - _shift(frames, paths), *_of_groups(paths - paths[0], measure))


def _shift(frames: Frames, paths: Array) -> float:
    """The time (s) of the first frame, or 0 if particles enter and paths begin at their entry."""
    return frames[0].time if len(frames) and not paths[0].any() else 0.0


def dispersion_coefficient(frames: Frames, axis: int = 0) -> Course:
    """Half the rate at which the variance along an axis grows (m^2/s), at the middle between frames; at long times, the
    dispersion coefficient of Taylor and Aris in a channel. It includes the particles that are inside in all frames. If
    some leave, the remaining ones are slow, and only the frames before the first exit describe the spreading of a
    pulse. If particles enter during the run, displacements are functions of the time since they entered, for particles
    inside at both ends of an interval.
    """
    if len(frames) < 2:
        raise BadInput("the rate of dispersion needs two frames or more")
    paths = _paths(frames)
    instants = times(frames)[: len(paths)] - _shift(frames, paths)
    span, paths = np.diff(instants), paths[:, :, axis]

    def measure(way: Array) -> Array:
        start = np.where(np.isfinite(way[1:]), way[:-1], np.nan)
        grown = [_mean(each**2) - _mean(each) ** 2 for each in (start, way[1:])]
        return np.asarray(0.5 * (grown[1] - grown[0]) / span)

    return Course(0.5 * (instants[1:] + instants[:-1]), *_of_groups(paths, measure))


class Residence(NamedTuple):
    """The residence times of particles that have left; entry and exit are assumed halfway between frames."""

    times: Array
    """(n,) s"""
    mean: float
    error: float
    remaining: int
    """particles that are still inside"""


def residence_times(frames: Frames) -> Residence:
    """The times between the entry of a particle, or the first frame, and its exit."""
    instants = times(frames)
    count = len(frames[-1].arrays["position"])
    entered, left = np.full(count, np.nan), np.full(count, np.nan)
    for k, frame in enumerate(frames):
        there = np.flatnonzero(np.isnan(entered[: len(frame.arrays["position"])]))
        between = 0.5 * (instants[k] + instants[max(k - 1, 0)])
        entered[there] = between
        gone = ~inside(frame)
        fresh = np.flatnonzero(gone & np.isnan(left[: len(gone)]))
        left[fresh] = between if k else -np.inf  # they left before the first frame
    stayed = (left - entered)[np.isfinite(left)]
    error = float(stayed.std(ddof=1) / np.sqrt(len(stayed))) if len(stayed) > 1 else float("nan")
    mean = float(stayed.mean()) if len(stayed) else float("nan")
    return Residence(stayed, mean, error, int(np.isnan(left).sum()))


def breakthrough(frames: Frames, opening: int = 0) -> Course:
    """The fraction of all particles so far that have left through an opening, over time."""
    openings = _openings(frames[0]) if len(frames) else 0
    if not 0 <= opening < openings:
        raise BadInput(f"got opening {opening}; the run has {openings}, numbered from 0")
    shares, errors = [], []
    for frame in frames:
        left, count = np.asarray(frame.arrays["left"]), len(frame.arrays["left"])
        share = float((left == opening).sum()) / count
        shares.append(share)
        errors.append(np.sqrt(share * (1.0 - share) / count))
    return Course(times(frames), np.array(shares), np.array(errors))


def concentration(frames: Frames, edges: Array, axis: int = 0) -> Course:
    """The number of particles per length between edges along an axis, (T, n) in 1/m."""
    counts = np.array([np.histogram(frame.arrays["position"][inside(frame), axis], edges)[0] for frame in frames])
    widths = np.diff(edges)
    return Course(times(frames), counts / widths, np.sqrt(counts) / widths)


def _openings(frame: Frame) -> int:
    return sum(name.startswith("left_through_opening_") for name in frame.numbers)


def _sticking_walls(frame: Frame) -> list[int]:
    return sorted(int(name.rpartition("_")[2]) for name in frame.numbers if name.startswith("deposited_on_wall_"))


def deposited(frame: Frame, wall: int | None = None) -> Flags:
    """Flags (N,) of the particles that adhere to a sticking wall; by default, to any such wall."""
    walls = _sticking_walls(frame)
    openings = _openings(frame)
    if wall is not None and wall not in walls:
        raise BadInput(f"wall {wall} does not hold particles; those that do: {walls or 'none'}")
    left = np.asarray(frame.arrays["left"])
    return np.asarray((left >= openings) & bool(walls) if wall is None else left == openings + walls.index(wall))


def present(frame: Frame) -> Flags:
    """Flags (N,) of the particles that are inside or stick to a wall, which pictures show. In frames without a record
    of particles that left, all flags are set.
    """
    return inside(frame) | deposited(frame) if "left" in frame.arrays else inside(frame)


class Deposition(NamedTuple):
    """The number of particles on walls, by position."""

    edges: Array
    """m"""
    density: Array
    """(n,) 1/m"""
    error: Array


def deposition(frame: Frame, edges: Array, axis: int = 0, wall: int | None = None) -> Deposition:
    """The number of deposited particles per length along an axis."""
    counts, _ = np.histogram(frame.arrays["position"][deposited(frame, wall), axis], edges)
    return Deposition(edges, counts / np.diff(edges), np.sqrt(counts) / np.diff(edges))


class Efficiency(NamedTuple):
    """The fraction of particles that a collector retains."""

    value: float
    error: float


def collector_efficiency(frame: Frame, wall: int | None = None, species: int | None = None) -> Efficiency:
    """The number of deposited particles over that of all that are deposited or have left, for all particles or for one
    species by its number.
    """
    own = np.full(len(frame.arrays["left"]), True) if species is None else frame.arrays["species"] == species
    held, gone = int((deposited(frame, wall) & own).sum()), int((~inside(frame) & own).sum())
    if not gone:
        raise BadInput("no particle is deposited or has left; expected a longer run")
    share = held / gone
    return Efficiency(share, float(np.sqrt(share * (1.0 - share) / gone)))


def dataset(frames: Frames) -> Any:
    """The paths as a dataset of xarray with the dimensions `trajectory` and `obs`, for NetCDF files by the CF
    conventions. Positions are NaN where a particle is neither inside nor on a sticking wall; the flags `left` describe
    its location. Times are seconds since 1970-01-01. Raises BadInput without xarray.
    """
    try:
        import xarray
    except ImportError as error:
        raise BadInput(f"datasets need xarray: {install('flows')}") from error
    paths = tracks(frames)
    rows = ("trajectory", "obs")
    instants = np.tile(times(frames), (paths.shape[1], 1))
    described = {"x": "position along x", "y": "position along y", "z": "height"}
    names = ("x", "y") if paths.shape[2] == 2 else ("x", "y", "z")
    left = np.full(paths.shape[:2], NOT_YET)
    for path, where, frame in zip(paths, left, frames, strict=True):
        count = len(frame.arrays["position"])
        where[:count] = np.where(inside(frame), -1, frame.arrays.get("left", -1))
        held = present(frame) & ~inside(frame)
        path[:count][held] = unwrapped(frame)[held]
    values: dict[str, Any] = {
        "time": (rows, instants, {"units": f"seconds since {EPOCH}", "standard_name": "time", "axis": "T"}),
        **{name: (rows, paths[:, :, axis].T, {"units": "m", "long_name": described[name], "axis": name.upper()})
           for axis, name in enumerate(names)},
        "left": (rows, left.T, {"long_name": "where the particle is", **_flags(frames[-1])}),
    }  # fmt: skip
    for name in ("radius", "density", "species"):
        if name in frames[-1].arrays:
            units = {} if name == "species" else {"units": frames[-1].units.get(name, "1")}
            values[name] = ("trajectory", frames[-1].arrays[name], units)
    number = np.arange(paths.shape[1])
    attributes = {"featureType": "trajectory", "Conventions": "CF-1.8", "source": "ecume"}
    return xarray.Dataset(values, {"trajectory": ("trajectory", number, {"cf_role": "trajectory_id"})}, attributes)


NOT_YET = -2
"""In `left` of datasets: particles that have not yet entered."""


def _flags(frame: Frame) -> dict[str, Any]:
    """The values of `left` in datasets, and their meanings, by the CF conventions."""
    holes = [f"left_through_opening_{m}" for m in range(_openings(frame))]
    walls = [f"on_wall_{wall}" for wall in _sticking_walls(frame)]
    meanings = ["not_yet_entered", "inside", *holes, *walls]
    return {"flag_values": np.arange(len(meanings)) + NOT_YET, "flag_meanings": " ".join(meanings)}
