"""Surfactant at the surface: floats that release it, its concentration on a grid, and the force of its gradient.

The concentration obeys dc/dt + div(u c) = D lap c - k c + s: finite volumes on a regular grid in a dish or a periodic
cell. A time step is divided into steps below the limit of diffusion, and each of these into upwind advection,
diffusion, release and an exact loss. Fluxes are exchanged between cells, so that mass is conserved to rounding. No
surfactant crosses the wall of a dish. The free energy changes in these four parts of a step, and diffusion never
increases it.

A float releases surfactant over its disc. The resultant of the surface tension on its perimeter is the integral of the
gradient over its area (Gauss), with the same weights as the release. On a periodic grid a float at rest therefore
exerts no force on itself at any position, and the forces of two equal sources are opposite.

Array expressions are as fast as compiled loops here, and need no compilation.
"""

from __future__ import annotations

import math
from functools import partial
from typing import TYPE_CHECKING, Any, NamedTuple, cast

import numpy as np
from numpy.typing import NDArray

from ecume.engine.neighbors import NeighborLists
from ecume.engine.walls import Walls, rings, wall_count
from ecume.engine.walls.rings import wall_distance
from ecume.laws import camphor
from ecume.models.floating.forces.flow_and_noise import current_at, varies
from ecume.models.floating.options import Built, scene_error
from ecume.models.floating.parameters import WORK, Parameters, State, SurfactantState, Workspace
from ecume.models.invariants import Invariant, NumberHistory, part_of
from ecume.models.liquids import liquid_of
from ecume.units import Array, duration_text, with_prefix

if TYPE_CHECKING:
    from collections.abc import Callable

    from ecume.scenes.floating import FloatingScene

CELLS_PER_RADIUS = 3.0
"""Cells of the default grid in the smallest radius of a float."""
FEWEST_PER_RADIUS = 1.0
"""Coarser grids are refused."""
MOST_CELLS = 4_000_000
PAIRS_PER_CELL = 5.0
"""Pairs that cost as much time as a cell in a step of diffusion, measured: 23 ns on large grids, 50 ns on small."""
RADII = 4.0
"""The time scale of motion in radii over the highest possible speed: a good step is a fifth of a radius, of second
order.
"""
SAFE = 0.8
"""Over the longest stable step of the finite volumes."""
RELEASED, LOST, BY_RELEASE, BY_DIFFUSION, BY_FLOW, BY_LOSS = range(6)
"""Indices of `SurfactantState.surfactant`: masses, and changes of the free energy."""


class Surfactant(NamedTuple):
    """Constants of the surfactant and its grid."""

    release: Array
    """(N,) kg/s"""
    diffusivity: float
    loss_rate: float
    slope: float
    """N m/kg: the fall of the surface tension per concentration"""
    largest_fall: float
    """N/m"""
    reference: float
    """kg/m^2: the concentration at which the surface tension would vanish"""
    low: Array
    """(2,) m: the corner of the grid"""
    width: Array
    """(2,) m: of a cell"""
    wet: NDArray[np.bool_]
    """(X, Y) whether a cell is in the dish"""
    along: Array
    """(X, Y) 1 where surfactant passes between cell i and i + 1 along x, the last and the first in a periodic cell"""
    across: Array
    """(X, Y) the same along y"""
    flows: bool
    """whether the flow of the surface carries the surfactant along"""
    start: Array
    """(X, Y) kg/m^2"""


class SurfactantScratch(NamedTuple):
    """The arrays of the state, and scratch arrays of a step."""

    concentration: Array
    totals: Array
    force: Array
    """(N, 2) N, at the current positions"""
    before: Array
    """(N, 2) N, at the beginning of the step"""
    moved: Array
    """(N, 2) m/s: displacement over time step"""
    speeds: tuple[Array, Array] | None
    """of a steady flow: see `face_speeds`"""
    energy: Array
    """(1,) J: the free energy of the present concentration"""


Row = tuple[str, str, str]
"""A row of `ecume check`."""


class Weights(NamedTuple):
    """The cells of each float and their weights, of which the sum is 1."""

    i: NDArray[np.int64]
    j: NDArray[np.int64]
    """(N, K, K)"""
    weight: Array
    """(N, K, K)"""


def centers_of(part: Surfactant) -> tuple[Array, Array]:
    """The centers of the cells along x and y (m)."""
    nx, ny = part.wet.shape
    x, y = (low + (np.arange(n) + 0.5) * h for low, n, h in zip(part.low, (nx, ny), part.width, strict=True))
    return x, y


def weights_at(part: Surfactant, position: Array, radius: Array) -> Weights:
    """The share of each cell in the discs: one inside, decreasing to zero across a cell at the perimeter."""
    h = float(part.width.max())
    reach = math.ceil((float(radius.max()) + h) / float(part.width.min()))
    offset = np.arange(-reach, reach + 2)
    place = (position - part.low) / part.width - 0.5
    first = np.floor(place).astype(np.int64)
    i = first[:, 0, None, None] + offset[None, :, None] + 0 * offset[None, None, :]
    j = first[:, 1, None, None] + offset[None, None, :] + 0 * offset[None, :, None]
    x = (i - place[:, 0, None, None]) * part.width[0]
    y = (j - place[:, 1, None, None]) * part.width[1]
    weight = np.clip((radius[:, None, None] - np.hypot(x, y)) / h + 0.5, 0.0, 1.0)
    nx, ny = part.wet.shape
    inside = (i >= 0) & (i < nx) & (j >= 0) & (j < ny)
    i, j = i % nx, j % ny
    # In a periodic cell the grid contains every position; in a dish it does not.
    weight = weight * (part.wet[i, j] & (inside | bool(part.along[-1].any())))
    return Weights(i, j, weight / weight.sum(axis=(1, 2))[:, None, None])


def tension_gradient(part: Surfactant, concentration: Array) -> tuple[Array, Array]:
    """The gradient of the surface tension at the centers of cells (N/m^2); its normal part is zero at walls."""
    fall = np.minimum(part.slope * concentration, part.largest_fall)
    found = []
    for axis, passable in ((0, part.along), (1, part.across)):
        ahead = passable * (np.roll(fall, -1, axis) - fall)
        found.append(-(ahead + np.roll(ahead, 1, axis)) / (2.0 * part.width[axis]))
    return found[0], found[1]


def tension_forces(part: Surfactant, concentration: Array, position: Array, radius: Array) -> Array:
    """The resultant (N) of the surface tension on the perimeter of each float, (N, 2)."""
    cells = weights_at(part, position, radius)
    x, y = tension_gradient(part, concentration)
    area = math.pi * radius**2
    return np.stack([area * (cells.weight * each[cells.i, cells.j]).sum(axis=(1, 2)) for each in (x, y)], axis=1)


def surfactant_forces(
    part: Surfactant, scratch: SurfactantScratch, parameters: Parameters, position: Array, lists: NeighborLists,
    force: Array,
) -> None:  # fmt: skip
    """Add the forces of the gradient of the surface tension."""
    scratch.force[:] = tension_forces(part, scratch.concentration, position, parameters.floats.radius)
    force += scratch.force


def no_surfactant_energy(
    part: Surfactant, scratch: Any, parameters: Parameters, state: State, workspace: Workspace
) -> tuple[float, float]:
    """Return zero: the forces depend on the past of the floats, and their work is injected work."""
    return 0.0, 0.0


def advance_surfactant(
    part: Surfactant, scratch: SurfactantScratch, parameters: Parameters, state: State, first: bool
) -> None:
    """Advance the concentration by one time step before the floats move; floats release surfactant at the middle of
    their path in the step. After the step, add the work of the surface tension, by the mean of its forces at both ends.
    """
    c, step = scratch.concentration, parameters.time_step
    if not first:
        state.tally[WORK] += 0.5 * step * float(np.sum((scratch.before + scratch.force) * scratch.moved))
        return
    scratch.before[:] = scratch.force
    midway = state.position + 0.5 * step * state.velocity
    source = released(part, midway, parameters.floats.radius)
    speeds = scratch.speeds
    if part.flows and speeds is None:
        speeds = face_speeds(part, parameters, (float(state.step[0]) + 0.5) * step)
    count = math.ceil(step / longest_step(part, speeds))
    changes: dict[int, Callable[[], None]] = {}
    if speeds is not None:
        changes[BY_FLOW] = partial(carry, part, c, speeds, step / count)
    changes[BY_DIFFUSION] = partial(diffuse, part, c, step / count)
    if source is not None:
        changes[BY_RELEASE] = partial(add, c, step / count * source)
    if part.loss_rate > 0.0:
        changes[BY_LOSS] = partial(lose, part, scratch, step / count)
    for _ in range(count):
        for term, change in changes.items():
            change()
            before, scratch.energy[0] = float(scratch.energy[0]), free_energy(part, c)
            scratch.totals[term] += scratch.energy[0] - before
    scratch.totals[RELEASED] += step * float(part.release.sum())


def released(part: Surfactant, position: Array, radius: Array) -> Array | None:
    """The release of all floats into each cell (kg/(m^2 s)); None if no float releases surfactant."""
    sources = np.flatnonzero(part.release)
    if not len(sources):
        return None
    found, cells = np.zeros(part.wet.shape), weights_at(part, position[sources], radius[sources])
    mass = part.release[sources][:, None, None] * cells.weight
    np.add.at(found, (cells.i, cells.j), mass / float(np.prod(part.width)))
    return found


def diffuse(part: Surfactant, c: Array, time: float) -> None:
    """Exchange the fluxes of diffusion between cells. Each new value is a mean over neighbors, so that no convex
    function increases.
    """
    change = np.zeros_like(c)
    for axis, passable in ((0, part.along), (1, part.across)):
        flux = passable * (c - np.roll(c, -1, axis))
        change += (np.roll(flux, 1, axis) - flux) * (time * part.diffusivity / part.width[axis] ** 2)
    c += change


def add(c: Array, more: Array) -> None:
    c += more


def carry(part: Surfactant, c: Array, speeds: tuple[Array, Array], time: float) -> None:
    """Exchange the upwind fluxes of the flow between cells."""
    change = np.zeros_like(c)
    for axis in (0, 1):
        flux = np.maximum(speeds[axis], 0.0) * c + np.minimum(speeds[axis], 0.0) * np.roll(c, -1, axis)
        change += (np.roll(flux, 1, axis) - flux) * (time / part.width[axis])
    c += change


def lose(part: Surfactant, scratch: SurfactantScratch, time: float) -> None:
    """Evaporate and dissolve surfactant."""
    kept = math.exp(-part.loss_rate * time)
    scratch.totals[LOST] += (1.0 - kept) * float(np.prod(part.width)) * float(scratch.concentration.sum())
    scratch.concentration[:] *= kept


def free_energy(part: Surfactant, c: Array) -> float:
    """The free energy of the surfactant at the surface (J)."""
    density = camphor.free_energy(c, part.slope, part.reference, part.largest_fall)
    return float(np.prod(part.width)) * float(np.sum(density))


def face_speeds(part: Surfactant, parameters: Parameters, time: float) -> tuple[Array, Array]:
    """The velocities of the surface normal to the faces of cells (m/s); zero at walls."""
    x, y = centers_of(part)
    half = 0.5 * part.width
    u, v = np.zeros(part.wet.shape), np.zeros(part.wet.shape)
    for i, j in zip(*np.nonzero(part.wet), strict=True):
        u[i, j] = current_at(parameters.drift, time, float(x[i] + half[0]), float(y[j]))[0]
        v[i, j] = current_at(parameters.drift, time, float(x[i]), float(y[j] + half[1]))[1]
    return u * part.along, v * part.across


def longest_step(part: Surfactant, speeds: tuple[Array, Array] | None) -> float:
    """The longest step of the finite volumes (s), in which no concentration becomes negative."""
    rate = 2.0 * part.diffusivity * float(np.sum(part.width**-2.0))
    if speeds is not None:
        rate += 2.0 * sum(float(np.abs(each).max()) / width for each, width in zip(speeds, part.width, strict=True))
    return SAFE / rate if rate > 0.0 else math.inf


def keep_motion(
    part: Surfactant, scratch: SurfactantScratch, parameters: Parameters, state: State, workspace: Workspace
) -> None:
    """Keep the displacement of a step, for the work that is added at its end."""
    scratch.moved[:] = workspace.midstep_velocity[: len(scratch.moved)]


def with_surfactant(part: Surfactant, state: State) -> State:
    """Return the state with the concentration at the start."""
    return cast(State, SurfactantState(*state, part.start.copy(), np.zeros(6)))


def make_surfactant_scratch(
    part: Surfactant, parameters: Parameters, state: State, workspace: Workspace
) -> SurfactantScratch:
    """Return the workspace."""
    own = cast(SurfactantState, state)
    force, before, moved = (np.zeros_like(state.position) for _ in range(3))
    steady = part.flows and not varies(parameters.drift)
    speeds = face_speeds(part, parameters, 0.0) if steady else None
    energy = np.array([free_energy(part, own.concentration)])
    return SurfactantScratch(own.concentration, own.surfactant, force, before, moved, speeds, energy)


def surfactant_numbers(part: Surfactant, state: State) -> dict[str, tuple[float, str]]:
    """The mass and the free energy of the surfactant at the surface, and their changes since the start."""
    own = cast(SurfactantState, state)
    totals = own.surfactant.tolist()
    return {
        "surfactant": (float(np.prod(part.width)) * float(own.concentration.sum()), "kg"),
        "surfactant_released": (totals[RELEASED], "kg"),
        "surfactant_lost": (totals[LOST], "kg"),
        "surfactant_energy": (free_energy(part, own.concentration), "J"),
        "surfactant_energy_released": (totals[BY_RELEASE], "J"),
        "surfactant_energy_dissipated": (0.0 - totals[BY_DIFFUSION], "J"),
        "surfactant_energy_carried": (totals[BY_FLOW], "J"),
        "surfactant_energy_lost": (0.0 - totals[BY_LOSS], "J"),
    }  # adding zero removes the sign of -0.0


def _missing_mass(seen: NumberHistory) -> float:
    """The relative error of the mass balance: the mass at the surface minus the initial and released mass plus the
    losses.
    """
    there, start = seen.now["surfactant"], seen.first["surfactant"]
    released, lost = (seen.now[name] - seen.first[name] for name in ("surfactant_released", "surfactant_lost"))
    return part_of(abs(there + lost - start - released), start + released)


def _missing_energy(seen: NumberHistory) -> float:
    """The free energy that the terms of its budget do not explain, over the sum of the magnitudes of all terms."""
    terms = {"": -1.0, "_released": 1.0, "_dissipated": -1.0, "_carried": 1.0, "_lost": -1.0}
    names = {f"surfactant_energy{name}": sign for name, sign in terms.items()}
    missing = sum(sign * (seen.now[name] - seen.first[name]) for name, sign in names.items())
    return part_of(abs(missing), sum(abs(seen.now[name]) for name in names))


def _undone(seen: NumberHistory) -> float:
    """The decrease of the energy dissipated by diffusion since its maximum, over the maximum; zero if it never
    decreases.
    """
    name = "surfactant_energy_dissipated"
    return part_of(seen.largest[name] - seen.now[name], seen.largest[name])


BUDGETS = (
    Invariant("surfactant", "its mass that is not accounted for, over all of it", 1e-9, _missing_mass),
    Invariant("free energy", "that of the surfactant that is not accounted for, over its terms", 1e-9, _missing_energy),
    Invariant("diffusion", "free energy of the surfactant that it returned, over what it dissipated", 1e-9, _undone),
)


# --- From a scene


def surfactant_of(parameters: Parameters, scene: FloatingScene) -> Built:
    """The surfactant of a scene, and its time scales. Raises SceneError."""
    given, floats = scene.surfactant, parameters.floats
    assert given is not None  # noqa: S101  # for the type checker: the scene has chosen it
    names = [name for name, *_ in scene.kinds]
    release = np.zeros(len(floats.radius))
    for number, source in enumerate(given.sources):
        if source.species and source.species not in names:
            known = ", ".join(map(repr, names))
            path = f"surfactant.sources[{number}].species"
            raise scene_error(path, f"got {source.species!r}; expected a name among {known}")
        release += source.release * np.array([source.species in ("", names[one]) for one in floats.species])
    part = _on_grid(parameters, scene, release)
    return Built(part, shortest_time=min(_time_of_sources(part, parameters), _time_of_drops(part, parameters)))


def _time_of_sources(part: Surfactant, parameters: Parameters) -> float:
    """The shortest time scale of sources (s), by their repulsion and by self-propulsion."""
    floats, strongest = parameters.floats, part.slope * float(part.release.max(initial=0.0))
    if strongest == 0.0:
        return math.inf
    # Two floats repel each other at most like a spring of stiffness b S/(2 pi D).
    repelled = _time_on_springs(parameters, np.full_like(floats.radius, strongest / (2.0 * math.pi * part.diffusivity)))
    fastest = np.sqrt(strongest * floats.relaxation_time / floats.mass)
    return min(repelled, RADII * float((floats.radius / fastest).min()))


def _time_of_drops(part: Surfactant, parameters: Parameters) -> float:
    """The shortest time scale (s) in the steepest initial gradient, which diffusion flattens later."""
    steepest = float(np.hypot(*tension_gradient(part, part.start)).max())
    # The stiffness is the force over the radius.
    return RADII * _time_on_springs(parameters, math.pi * parameters.floats.radius * steepest) if steepest else math.inf


def _time_on_springs(parameters: Parameters, stiffness: Array) -> float:
    """The shortest time (s) of floats on springs with a stiffness (N/m): of oscillation, or of relaxation if drag
    dominates.
    """
    floats = parameters.floats
    oscillation = np.sqrt(floats.mass / stiffness) if parameters.scheme.inertia else 0.0
    return float(np.maximum(oscillation, floats.mass / floats.relaxation_time / stiffness).min())


def _on_grid(parameters: Parameters, scene: FloatingScene, release: Array) -> Surfactant:
    given, radius = scene.surfactant, float(parameters.floats.radius.min())
    assert given is not None  # noqa: S101  # the caller looked
    periodic = scene.cell is not None
    low, high = (np.zeros(2), np.array(scene.sides)) if periodic else map(np.array, rings.bounds(parameters.walls))
    spacing = radius / CELLS_PER_RADIUS if given.spacing is None else given.spacing
    if spacing > radius / FEWEST_PER_RADIUS:
        message = f"got {spacing:g} m; expected at most the smallest radius of a float, {radius:g} m"
        raise scene_error("surfactant.spacing", message)
    counts = np.maximum(np.ceil((high - low) / spacing * (1.0 - 1e-9)), 4).astype(int)
    if math.prod(counts.tolist()) > MOST_CELLS:
        message = f"{spacing:g} m makes {math.prod(counts.tolist()):.2g} cells; expected at most {MOST_CELLS:.0e}"
        raise scene_error("surfactant.spacing", message)
    width, tension = (high - low) / counts, liquid_of(scene).surface_tension
    if given.largest_fall is not None and given.largest_fall > tension:
        message = f"got {given.largest_fall:g} N/m; expected at most the surface tension, {tension:g} N/m"
        raise scene_error("surfactant.largest_fall", message)
    x, y = (start + (np.arange(n) + 0.5) * h for start, n, h in zip(low, counts, width, strict=True))
    wet = np.ones(counts.tolist(), bool) if periodic else _inside(parameters.walls, x, y)
    along, across = ((wet & np.roll(wet, -1, axis)).astype(np.float64) for axis in (0, 1))
    if not periodic:
        along[-1, :], across[:, -1] = 0.0, 0.0
    part = Surfactant(
        release, given.diffusivity, given.loss_rate, given.tension_slope,
        tension if given.largest_fall is None else given.largest_fall, tension / given.tension_slope, low, width, wet,
        along, across,
        given.advected and parameters.drift.flows, np.zeros(wet.shape),
    )  # fmt: skip
    for number, drop in enumerate(given.drops):
        where = (float(drop.position[0]), float(drop.position[1]))
        if not periodic and not _inside(parameters.walls, np.array(where[:1]), np.array(where[1:]))[0, 0]:
            raise scene_error(
                f"surfactant.drops[{number}].position", f"got {list(where)} m; expected a place in the dish"
            )
        size = np.array([max(drop.radius, float(width.max()))])
        cells = weights_at(part, np.array([where]), size)
        np.add.at(part.start, (cells.i, cells.j), drop.mass * cells.weight / float(np.prod(width)))
    return part


def _inside(walls: Walls, x: Array, y: Array) -> NDArray[np.bool_]:
    """Whether the centers of cells are inside of all walls."""
    return np.array(
        [[all(wall_distance(walls, k, a, b)[0] > 0.0 for k in range(wall_count(walls))) for b in y.tolist()]
         for a in x.tolist()]
    )  # fmt: skip


def surfactant_work(part: Surfactant, time_step: float) -> float:
    """The work of a time step, in units of a pair: of forces, and of steps of diffusion."""
    return PAIRS_PER_CELL * part.wet.size * (1.0 + math.ceil(time_step / longest_step(part, None)))


def surfactant_lines(part: Surfactant, parameters: Parameters) -> list[Row]:
    """The rows of `ecume check`: the grid, the range of the surfactant, and the speed of a single float."""
    nx, ny = part.wet.shape
    count = math.ceil(parameters.time_step / longest_step(part, None))
    rows = [("surfactant", f"{nx} x {ny} cells", f"of {with_prefix(float(part.width.max()), 'm', 3)}; "
             f"{count} step{'s' * (count > 1)} of diffusion in each time step")]  # fmt: skip
    if part.loss_rate > 0.0:
        far, long = math.sqrt(part.diffusivity / part.loss_rate), 1.0 / part.loss_rate
        rows.append(("range of the surfactant", with_prefix(far, "m", 3), f"it is lost after {duration_text(long)}"))
    for release in dict.fromkeys(part.release[part.release > 0.0].tolist()):
        alike = np.flatnonzero(part.release == release)
        by_size = alike[np.argsort(parameters.floats.radius[alike])]
        ends = dict.fromkeys(parameters.floats.radius[by_size[[0, -1]]].tolist())
        for i in by_size[[0, -1]][: len(ends)]:
            rows.append(_swimming(part, parameters, int(i), part.slope * release, of_size=len(ends) > 1))
    return rows


def _swimming(part: Surfactant, parameters: Parameters, i: int, drive: float, *, of_size: bool) -> Row:
    """The self-propulsion speed of a single float."""
    floats, radius = parameters.floats, float(parameters.floats.radius[i])
    friction = float(floats.mass[i] / floats.relaxation_time[i])
    speed = camphor.swimming_speed(
        friction, radius, drive, part.diffusivity, part.loss_rate, parameters.drift.thickness
    )
    remark = "of a lone float"
    if of_size:
        remark += f" with the radius {with_prefix(radius, 'm', 3)}"
    remark += " on an infinite surface"
    if part.loss_rate == 0.0:
        remark += "; without loss any release makes it swim, however slowly"
    else:
        ratio = camphor.threshold_friction(radius, drive, part.diffusivity, part.loss_rate) / friction
        remark += f", released {ratio:.3g} times as fast as it takes to swim"
    return "swimming speed", with_prefix(speed, "m/s", 3) if speed > 0.0 else "0 (at rest)", remark
