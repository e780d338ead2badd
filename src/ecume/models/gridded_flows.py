"""Flows on grids: their interpolation, divergence-free or linear, and the fit to velocities at nodes.

In 2D the divergence-free flow is the curl of a stream function, bicubic in each cell (Hermite). Its slopes at the nodes
are the velocities there; its values fit the fluxes through the edges of cells by least squares. The velocity is
continuous, its divergence is zero up to rounding, its error is of third order in the spacing, and no liquid crosses
edges between nodes on land. In 3D the fluxes through the faces of cells are made divergence-free by least squares, and
each component varies linearly along its axis in a cell [pollock1988]: this field is divergence-free as well, but of
first order.

Between two instants velocities change linearly; before the first and after the last they are constant, as are those
beyond the grid.
"""

from __future__ import annotations

import math
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from ecume._jit import compiled_inside
from ecume.models.stream_fits import Edges, Fits
from ecume.units import Array

Point = tuple[float, float, float]
Flags = NDArray[np.bool_]


class Grid(NamedTuple):
    """Velocities at the nodes of a grid of equal steps, at some instants; NaN on land."""

    low: tuple[float, ...]
    step: tuple[float, ...]
    """of each axis, m"""
    times: Array
    """(T,) s; one if the flow is steady"""
    velocity: Array
    """(T, n_x, ..., d) m/s"""


class StreamField(NamedTuple):
    """A flow in 2D as a stream function."""

    low: tuple[float, float]
    step: tuple[float, float]
    density: tuple[float, float]
    """cells per meter"""
    times: Array
    nodes: Array
    """(T, n_x, n_z, 4): the stream function, its slopes along x and z, and the mixed one, per cell"""


class FaceField(NamedTuple):
    """A flow in 3D as velocities normal to the faces of cells."""

    low: Point
    step: Point
    density: Point
    """cells per meter"""
    times: Array
    along: Array
    """(T, n_x, n_y - 1, n_z - 1) m/s"""
    across: Array
    """(T, n_x - 1, n_y, n_z - 1) m/s"""
    upward: Array
    """(T, n_x - 1, n_y - 1, n_z) m/s"""


class LinearField(NamedTuple):
    """Velocities at nodes, linear in each cell; in 2D with one layer across."""

    low: Point
    step: Point
    density: Point
    """cells per meter"""
    times: Array
    nodes: Array
    """(T, n_x, n_y, n_z, 3) m/s"""


# --- Places in grids


@compiled_inside
def cell_of(place: float, low: float, density: float, count: int) -> tuple[int, float]:
    """The cell of a coordinate among `count` nodes, `density` per meter, and the position in the cell from 0 to 1;
    beyond the grid, its edge.
    """
    if count < 2:
        return 0, 0.0
    along = min(max((place - low) * density, 0.0), count - 1.0)
    cell = min(int(along), count - 2)
    return cell, along - cell


@compiled_inside
def moment_of(times: Array, time: float) -> tuple[int, float]:
    """The last instant before a time, and the weight of the next one."""
    if len(times) < 2 or time <= times[0]:
        return 0, 0.0
    k = min(int(np.searchsorted(times, time)) - 1, len(times) - 2)
    return k, min((time - times[k]) / (times[k + 1] - times[k]), 1.0)


# --- Velocities, for compiled code: see `named_flows`


@compiled_inside
def stream_velocity_in(nodes: Array, k: int, cell: tuple[int, int], place: Point) -> tuple[float, float]:
    """The velocity in a cell from its bicubic stream function, over spacings; place = (s, t, 0) in the cell."""
    (i, j), s, t = cell, place[0], place[1]
    left, right = nodes[k, i], nodes[k, i + 1]
    # Cubic Hermite polynomials of the slopes at both ends and of the second value minus the first, and their
    # derivatives.
    a, b0, b1 = s * s * (3.0 - 2.0 * s), s * (1.0 - s) ** 2, s * s * (s - 1.0)
    c, d0, d1 = t * t * (3.0 - 2.0 * t), t * (1.0 - t) ** 2, t * t * (t - 1.0)
    da, db0, db1 = 6.0 * s * (1.0 - s), (1.0 - s) * (1.0 - 3.0 * s), s * (3.0 * s - 2.0)
    dc, dd0, dd1 = 6.0 * t * (1.0 - t), (1.0 - t) * (1.0 - 3.0 * t), t * (3.0 * t - 2.0)
    # Along the lower and upper edges of the cell: changes of the function and of its slope along x.
    near, tilt = left[j + 1, 0] - left[j, 0], left[j + 1, 1] - left[j, 1]
    far, lean = right[j + 1, 0] - right[j, 0], right[j + 1, 1] - right[j, 1]
    u_near = dc * near + dd0 * left[j, 2] + dd1 * left[j + 1, 2]
    u_tilt = dc * tilt + dd0 * left[j, 3] + dd1 * left[j + 1, 3]
    u_far = dc * far + dd0 * right[j, 2] + dd1 * right[j + 1, 2]
    u_lean = dc * lean + dd0 * right[j, 3] + dd1 * right[j + 1, 3]
    w_tilt = left[j, 1] + c * tilt + d0 * left[j, 3] + d1 * left[j + 1, 3]
    w_lean = right[j, 1] + c * lean + d0 * right[j, 3] + d1 * right[j + 1, 3]
    change = right[j, 0] - left[j, 0] + c * (far - near)
    change += d0 * (right[j, 2] - left[j, 2]) + d1 * (right[j + 1, 2] - left[j + 1, 2])
    along = u_near + a * (u_far - u_near) + b0 * u_tilt + b1 * u_lean
    return along, -(da * change + db0 * w_tilt + db1 * w_lean)


@compiled_inside
def stream_velocity(shape: StreamField, x: float, y: float, z: float, time: float) -> Point:
    """The velocity as the curl of the stream function."""
    nodes, low, density = shape.nodes, shape.low, shape.density
    i, s = cell_of(x, low[0], density[0], nodes.shape[1])
    j, t = cell_of(z, low[1], density[1], nodes.shape[2])
    k, late = moment_of(shape.times, time)
    u, w = stream_velocity_in(nodes, k, (i, j), (s, t, 0.0))
    if late > 0.0:
        next_u, next_w = stream_velocity_in(nodes, k + 1, (i, j), (s, t, 0.0))
        u, w = u + late * (next_u - u), w + late * (next_w - w)
    return u * density[1], 0.0, w * density[0]


@compiled_inside
def between(values: Array, k: int, late: float, place: tuple[int, int, int]) -> float:
    """A value interpolated between two instants."""
    i, j, m = place
    found: float = values[k, i, j, m]
    if late > 0.0:
        found += late * (values[k + 1, i, j, m] - found)
    return found


@compiled_inside
def face_velocity(shape: FaceField, x: float, y: float, z: float, time: float) -> Point:
    """The velocity, each component of which is linear along its axis. [pollock1988]."""
    low, density, along, across, upward = shape.low, shape.density, shape.along, shape.across, shape.upward
    i, r = cell_of(x, low[0], density[0], along.shape[1])
    j, s = cell_of(y, low[1], density[1], across.shape[2])
    m, t = cell_of(z, low[2], density[2], upward.shape[3])
    k, late = moment_of(shape.times, time)
    return (
        (1.0 - r) * between(along, k, late, (i, j, m)) + r * between(along, k, late, (i + 1, j, m)),
        (1.0 - s) * between(across, k, late, (i, j, m)) + s * between(across, k, late, (i, j + 1, m)),
        (1.0 - t) * between(upward, k, late, (i, j, m)) + t * between(upward, k, late, (i, j, m + 1)),
    )


@compiled_inside
def linear_in_layer(nodes: Array, k: int, cell: tuple[int, int, int], place: tuple[float, float]) -> Point:
    """The velocity in a layer of nodes of the same y, linear along x and z."""
    (i, j, m), (r, t) = cell, place
    left, right = nodes[k, i, j], nodes[k, i + 1, j]
    a, b, c, d = (1.0 - r) * (1.0 - t), (1.0 - r) * t, r * (1.0 - t), r * t
    return (
        a * left[m, 0] + b * left[m + 1, 0] + c * right[m, 0] + d * right[m + 1, 0],
        a * left[m, 1] + b * left[m + 1, 1] + c * right[m, 1] + d * right[m + 1, 1],
        a * left[m, 2] + b * left[m + 1, 2] + c * right[m, 2] + d * right[m + 1, 2],
    )


@compiled_inside
def linear_at(nodes: Array, k: int, cell: tuple[int, int, int], place: Point) -> Point:
    """The velocity at an instant, linear along each axis."""
    i, j, m = cell
    found = linear_in_layer(nodes, k, cell, (place[0], place[2]))
    if nodes.shape[2] > 1:
        farther = linear_in_layer(nodes, k, (i, j + 1, m), (place[0], place[2]))
        found = mixed(found, farther, place[1])
    return found


@compiled_inside
def mixed(one: Point, other: Point, share: float) -> Point:
    """The weighted mean of two velocities; `share` is the weight of the other."""
    return (
        one[0] + share * (other[0] - one[0]),
        one[1] + share * (other[1] - one[1]),
        one[2] + share * (other[2] - one[2]),
    )


@compiled_inside
def linear_velocity(shape: LinearField, x: float, y: float, z: float, time: float) -> Point:
    """The velocity, linear in each cell along each axis."""
    low, density, nodes = shape.low, shape.density, shape.nodes
    i, r = cell_of(x, low[0], density[0], nodes.shape[1])
    j, s = cell_of(y, low[1], density[1], nodes.shape[2])
    m, t = cell_of(z, low[2], density[2], nodes.shape[3])
    k, late = moment_of(shape.times, time)
    found = linear_at(nodes, k, (i, j, m), (r, s, t))
    if late > 0.0:
        found = mixed(found, linear_at(nodes, k + 1, (i, j, m), (r, s, t)), late)
    return found


# --- From velocities at nodes


class Fitted(NamedTuple):
    """A field for compiled code, and the part of a file's velocities that it does not represent."""

    shape: Any
    removed: float
    """the part of the fluxes that is divergence and was removed: root of mean squares, over that of the fluxes"""


def fitted(grid: Grid, interpolation: str, wrapped: tuple[int, ...] = ()) -> Fitted:
    """The field of a grid, with divergence-free or linear interpolation. Without divergence it is periodic along the
    axes `wrapped`, whose last nodes are the first ones of the next period.
    """
    if interpolation == "linear":
        return Fitted(_linear_field(grid), 0.0)
    return _stream_field(grid, wrapped) if len(grid.low) == 2 else _face_field(grid, wrapped)


def _linear_field(grid: Grid) -> LinearField:
    velocity = np.nan_to_num(grid.velocity)  # on land the liquid is at rest
    if len(grid.low) == 3:
        low, step, density = _three(grid.low), _three(grid.step), _three(_densities(grid.step))
        return LinearField(low, step, density, grid.times, np.ascontiguousarray(velocity))
    nodes = np.zeros((*velocity.shape[:2], 1, velocity.shape[2], 3))
    nodes[:, :, 0, :, 0], nodes[:, :, 0, :, 2] = velocity[..., 0], velocity[..., 1]
    (x, z), (width, height), (across, up) = grid.low, grid.step, _densities(grid.step)
    return LinearField((x, 0.0, z), (width, 1.0, height), (across, 1.0, up), grid.times, nodes)


def _densities(steps: tuple[float, ...]) -> tuple[float, ...]:
    return tuple(1.0 / step for step in steps)


def velocities_at_nodes(shape: StreamField | LinearField) -> tuple[Array, Array]:
    """The velocities along x and z of a field in 2D at its nodes (m/s)."""
    if isinstance(shape, LinearField):
        return shape.nodes[..., 0], shape.nodes[..., 2]
    return shape.nodes[..., 2] / shape.step[1], -shape.nodes[..., 1] / shape.step[0]


def _three(values: tuple[float, ...]) -> Point:
    x, y, z = values
    return x, y, z


def _stream_field(grid: Grid, wrapped: tuple[int, ...]) -> Fitted:
    """The bicubic stream function of each instant."""
    made, errors = [], []
    fits = Fits()
    for velocity in grid.velocity:
        nodes, error = _stream_nodes(velocity, grid.step, wrapped, fits)
        made.append(nodes)
        errors.append(error)
    low, step = (grid.low[0], grid.low[1]), (grid.step[0], grid.step[1])
    across, up = _densities(grid.step)
    return Fitted(StreamField(low, step, (across, up), grid.times, np.array(made)), max(errors))


SPARE = 2
"""Nodes beyond each periodic side that differences near it need."""


def _stream_nodes(
    velocity: Array, step: tuple[float, ...], wrapped: tuple[int, ...], fits: Fits
) -> tuple[Array, float]:
    whole = velocity
    for axis in wrapped:
        period = whole.shape[axis] - 1
        whole = np.take(whole, np.arange(-SPARE, period + 1 + SPARE) % period, axis)
    inside = tuple(slice(SPARE, -SPARE) if axis in wrapped else slice(None) for axis in (0, 1))
    land: Flags = np.asarray(np.isnan(whole).any(axis=-1))
    u, w = (np.where(land, 0.0, whole[..., axis]) for axis in (0, 1))
    # Fluxes through edges along z and along x, with the signs of the increments of the stream function.
    up, along = step[1] * _line_integrals(u, land, 1)[inside], -step[0] * _line_integrals(w, land, 0)[inside]
    mixed = 0.5 * (_slope(u, 0) * step[1] - _slope(w, 1) * step[0])
    mixed = np.where(_grown(land), 0.0, mixed)[inside]
    u, w, land = u[inside], w[inside], land[inside]
    value = fits.of(_shut_edges(u, w, land, wrapped))(along, up)
    misfit = np.concatenate([(np.diff(value, axis=0) - along).ravel(), (np.diff(value, axis=1) - up).ravel()])
    flux = np.concatenate([along.ravel(), up.ravel()])
    nodes = np.stack([value, -w * step[0], u * step[1], mixed], axis=-1)
    return np.ascontiguousarray(nodes), float(np.sqrt(np.mean(misfit**2) / max(np.mean(flux**2), 1e-300)))


def _line_integrals(values: Array, land: Flags, axis: int) -> Array:
    """Means between neighboring nodes along an axis, of fourth order where four nodes in a row are in the liquid."""
    f, dry = np.moveaxis(values, axis, 0), np.moveaxis(land, axis, 0)
    mean = 0.5 * (f[1:] + f[:-1])
    if len(f) >= 4:
        wet = ~(dry[:-3] | dry[1:-2] | dry[2:-1] | dry[3:])
        better = (13.0 * (f[1:-2] + f[2:-1]) - f[:-3] - f[3:]) / 24.0
        mean[1:-1] = np.where(wet, better, mean[1:-1])
        # At the ends, the parabola through three nodes is used.
        for end, a, b, c in ((0, f[0], f[1], f[2]), (-1, f[-1], f[-2], f[-3])):
            wet_end = ~np.moveaxis(land, axis, 0)[[0, 1, 2] if end == 0 else [-1, -2, -3]].any(axis=0)
            mean[end] = np.where(wet_end, (5.0 * a + 8.0 * b - c) / 12.0, mean[end])
    return np.moveaxis(mean, 0, axis)


def _slope(values: Array, axis: int) -> Array:
    """The change of values per cell, by central differences."""
    slope: Array = np.gradient(values, axis=axis, edge_order=2 if values.shape[axis] > 2 else 1)
    return slope


def _grown(land: Flags) -> Flags:
    """Land and the nodes next to it."""
    found = land.copy()
    found[1:] |= land[:-1]
    found[:-1] |= land[1:]
    found[:, 1:] |= land[:, :-1]
    found[:, :-1] |= land[:, 1:]
    return found


STILL = 1e-9
"""The velocity over the largest one below which it is that of a wall."""


def _shut_edges(u: Array, w: Array, land: Flags, wrapped: tuple[int, ...]) -> Edges:
    """Flags of the edges along x and along z that no liquid crosses: edges between nodes on land, and those on sides of
    the grid that are walls, where the fit would otherwise have a flux.
    """
    along, up = land[:-1] & land[1:], land[:, :-1] & land[:, 1:]
    quiet = STILL * max(float(np.abs(u).max()), float(np.abs(w).max()))
    for side in (0, -1):
        if 1 not in wrapped:
            still = np.abs(w[:, side]) <= quiet
            along[:, side] |= still[:-1] & still[1:]
        if 0 not in wrapped:
            still = np.abs(u[side]) <= quiet
            up[side] |= still[:-1] & still[1:]
    return Edges(along, up, wrapped)


def _face_field(grid: Grid, wrapped: tuple[int, ...]) -> Fitted:
    """The divergence-free fluxes through faces at each instant."""
    made, errors = [], []
    for velocity in grid.velocity:
        faces, error = _faces(velocity, grid.step, wrapped)
        made.append(faces)
        errors.append(error)
    along, across, upward = (np.ascontiguousarray(np.array([faces[axis] for faces in made])) for axis in range(3))
    low, step, density = _three(grid.low), _three(grid.step), _three(_densities(grid.step))
    return Fitted(FaceField(low, step, density, grid.times, along, across, upward), max(errors))


def _faces(velocity: Array, step: tuple[float, ...], wrapped: tuple[int, ...]) -> tuple[list[Array], float]:
    land: Flags = np.asarray(np.isnan(velocity).any(axis=-1))
    still = np.where(land[..., None], 0.0, velocity)
    area = [step[1] * step[2], step[0] * step[2], step[0] * step[1]]
    fluxes, shut = list[Array](), list[Flags]()
    quiet = STILL * float(np.abs(still).max())
    for axis in range(3):
        flux, dry = area[axis] * still[..., axis], land.copy()
        for other in range(3):
            if other != axis:
                near, far = _halves(flux, other)
                flux = 0.5 * (near + far)
                near_dry, far_dry = _halves(dry, other)
                dry = near_dry & far_dry
        if axis not in wrapped:
            _shut_sides(dry, still[..., axis], axis, quiet)
        fluxes.append(flux)
        shut.append(dry)
    before = math.sqrt(np.mean(np.concatenate([flux.ravel() for flux in fluxes]) ** 2))
    changed = _without_divergence(fluxes, shut, wrapped)
    removed = np.concatenate([(new - old).ravel() for new, old in zip(changed, fluxes, strict=True)])
    error = math.sqrt(np.mean(removed**2)) / max(before, 1e-300)
    return [flux / area[axis] for axis, flux in enumerate(changed)], error


def _shut_sides(shut: Flags, velocity: Array, axis: int, quiet: float) -> None:
    """Set the flags of faces on those sides of the grid across an axis that are walls: no velocity along the axis is
    above `quiet` at their nodes. The smallest change of fluxes would otherwise lead liquid through them.
    """
    for side in (0, -1):
        still = np.abs(np.take(velocity, side, axis)) <= quiet
        shut[(slice(None),) * axis + (side,)] |= still[:-1, :-1] & still[1:, :-1] & still[:-1, 1:] & still[1:, 1:]


def _halves(values: Any, axis: int) -> tuple[Any, Any]:
    """The values without the last one, and without the first one, along an axis."""
    count = values.shape[axis]
    return np.take(values, range(count - 1), axis), np.take(values, range(1, count), axis)


def _without_divergence(fluxes: list[Array], shut: list[Flags], wrapped: tuple[int, ...]) -> list[Array]:
    """The fluxes through faces after the smallest change that removes the divergence of all cells; zero through shut
    faces. Along the axes `wrapped` the last faces are the first ones.
    """
    from scipy import sparse
    from scipy.sparse.linalg import cg

    shape = tuple(fluxes[0].shape[axis] - (axis == 0) for axis in range(3))
    number = np.arange(math.prod(shape)).reshape(shape)
    sizes = [flux.size for flux in fluxes]
    starts = [0, sizes[0], sizes[0] + sizes[1]]
    rows, columns, signs = [], [], []
    for axis in range(3):
        faces = starts[axis] + np.arange(sizes[axis]).reshape(fluxes[axis].shape)
        if axis in wrapped:
            faces = np.take(faces, [*range(faces.shape[axis] - 1), 0], axis)
        lower, upper = _halves(faces, axis)
        for side, sign in ((lower, -1.0), (upper, 1.0)):
            rows.append(number.ravel())
            columns.append(side.ravel())
            signs.append(np.full(number.size, sign))
    rate = sparse.csr_array(
        (np.concatenate(signs), (np.concatenate(rows), np.concatenate(columns))), (number.size, sum(sizes))
    )
    open_faces = 1.0 - np.concatenate([each.ravel() for each in shut])
    flux = open_faces * np.concatenate([each.ravel() for each in fluxes])
    balance = rate @ sparse.diags_array(open_faces) @ rate.T + 1e-14 * sparse.eye_array(number.size)
    pressure, _ = cg(balance, rate @ flux, rtol=1e-12, atol=0.0, maxiter=20 * max(shape) + 2000)
    flux = flux - open_faces * (rate.T @ pressure)
    found = [
        flux[start : start + size].reshape(like.shape) for start, size, like in zip(starts, sizes, fluxes, strict=True)
    ]
    for axis in wrapped:
        found[axis] = np.take(found[axis], [*range(found[axis].shape[axis] - 1), 0], axis)
    return found


GRIDDED_VELOCITIES: dict[type, Any] = {
    StreamField: stream_velocity,
    FaceField: face_velocity,
    LinearField: linear_velocity,
}
