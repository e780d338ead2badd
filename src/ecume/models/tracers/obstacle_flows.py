"""Creeping flow in a channel or a periodic array around obstacles, computed once by finite elements (scikit-fem), in
2D.

Velocities are polynomials of fourth order on triangles (Scott and Vogelius), made free of divergence by iterated
penalty [scott1985]: the divergence vanishes everywhere and not only on average, so that particles do not cluster, and
the velocity is zero at walls and obstacles. Discs are approximated by polygons around them. The mesh is a Delaunay
triangulation, finer near obstacles.
"""

from __future__ import annotations

import math
from functools import lru_cache
from typing import Any, NamedTuple

import numpy as np

from ecume._jit import admit, compiled_inside
from ecume.engine.cells import Integers
from ecume.errors import BadInput, install
from ecume.laws import flows
from ecume.models.tracers.simplex_bins import Bins, bins_of
from ecume.units import Array

admit(flows)

EXTRA = "flows"
ROUND = 48
"""The number of sides of the polygon around a disc."""
COARSEST = 0.1
"""The longest edge, over the width of the channel."""
GROWTH = 0.3
"""The growth of edge lengths per distance from obstacles."""
CLOSEST = 0.02
"""The narrowest gap that is resolved, over the width of the channel."""
SHORT = 0.5
"""The edges of a side, over those of another, below which the others near it are shorter, too."""
SAMPLES = 400
"""The points of a side at which the distance of its nodes is evaluated."""
SMOOTHING = 12
"""The number of rounds in which inner nodes move to the mean of their neighbors."""
PENALTY = 1e7
"""The penalty of the divergence, over the viscosity."""
DIVERGENCE = 1e-9
"""The largest permitted divergence, over the mean speed per width."""
TERMS = 15
"""The number of terms of a polynomial of fourth order in two variables."""
EXPONENTS = tuple((i, j) for total in range(5) for i in range(total, -1, -1) for j in (total - i,))

Flags = np.ndarray[tuple[int, ...], np.dtype[np.bool_]]
Outline = tuple[tuple[float, float], ...]
Point = tuple[float, float, float]


class ChannelFlow(NamedTuple):
    """The flow of a channel with obstacles, on triangles."""

    low: tuple[float, float]
    high: tuple[float, float]
    speed: float
    """m/s, the mean speed"""
    bins: Bins
    inverse: Array
    """(T, 6) the corner of each triangle, and the inverse of its edges"""
    along: Array
    """(T, TERMS) coefficients of the velocity along x, over the mean speed"""
    upward: Array


@compiled_inside
def obstacle_velocity(shape: ChannelFlow, x: float, y: float, z: float, time: float) -> Point:
    """The velocity of the flow, which is zero in obstacles; beyond the sides, the velocity at the sides."""
    x = min(max(x, shape.low[0]), shape.high[0])
    z = min(max(z, shape.low[1]), shape.high[1])
    bins = shape.bins
    column = min(int((x - shape.low[0]) / bins.step[0]), bins.first.shape[0] - 1)
    row = min(int((z - shape.low[1]) / bins.step[1]), bins.first.shape[1] - 1)
    for k in range(bins.many[column, row]):
        t = bins.near[bins.first[column, row] + k]
        right, up = x - shape.inverse[t, 0], z - shape.inverse[t, 1]
        a = shape.inverse[t, 2] * right + shape.inverse[t, 3] * up
        b = shape.inverse[t, 4] * right + shape.inverse[t, 5] * up
        if a >= -1e-12 and b >= -1e-12 and a + b <= 1.0 + 1e-12:
            u, w, term, power = 0.0, 0.0, 0, 1.0
            for total in range(5):
                # a^total, a^(total-1) b, ..., b^total
                for j in range(total + 1):
                    power = a ** (total - j) * b**j
                    u += shape.along[t, term] * power
                    w += shape.upward[t, term] * power
                    term += 1
            return shape.speed * u, 0.0, shape.speed * w
    return 0.0, 0.0, 0.0


def channel_flow(
    low: tuple[float, float],
    high: tuple[float, float],
    outlines: tuple[Outline, ...],
    speed: float,
    *,
    periodic: bool = False,
) -> Any:
    """The flow between plates at z = low and high around obstacles, with a given mean speed. With `periodic` a pressure
    gradient drives it; otherwise it enters and leaves as a Poiseuille flow. Raises BadInput without scikit-fem, and for
    obstacles that are too close to each other or to a side. [scott1985].
    """
    return _solved(low, high, outlines, periodic)._replace(speed=speed)


@lru_cache(maxsize=4)
def _solved(
    low: tuple[float, float], high: tuple[float, float], outlines: tuple[Outline, ...], periodic: bool
) -> ChannelFlow:
    nodes, triangles = mesh_of(low, high, [np.array(each) for each in outlines], periodic=periodic)
    along, upward = _velocities(nodes, triangles, (low, high), periodic=periodic)
    corners = nodes[triangles]
    edges = np.stack([corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]], axis=2)
    inverse = np.concatenate([corners[:, 0], np.linalg.inv(edges).reshape(-1, 4)], axis=1)
    return ChannelFlow(low, high, 1.0, bins_of(corners, low, high, math.sqrt(len(corners))), inverse, along, upward)


def disc_outline(center: tuple[float, ...], radius: float) -> Outline:
    """The polygon circumscribed about a disc."""
    angle = 2.0 * math.pi * (np.arange(ROUND) + 0.5) / ROUND
    far = radius / math.cos(math.pi / ROUND)
    return tuple(
        zip((center[0] + far * np.cos(angle)).tolist(), (center[1] + far * np.sin(angle)).tolist(), strict=True)
    )


# --- The mesh


def mesh_of(
    low: tuple[float, float], high: tuple[float, float], outlines: list[Array], *, periodic: bool = False
) -> tuple[Array, Integers]:
    """Nodes and triangles of a box around convex obstacles; with `periodic`, nodes on the left and on the right have
    the same heights. Raises BadInput for obstacles that are too close.
    """
    from scipy.spatial import Delaunay

    width = high[1] - low[1]
    outlines = [each if _area(each) > 0.0 else each[::-1] for each in outlines]
    frame = np.array([low, (high[0], low[1]), high, (low[0], high[1])], float)
    _require_gaps(frame, outlines, CLOSEST * width)
    sized = [_divided(each, 2.0 * width, each, outlines) for each in outlines]
    segments = _segments(sized)

    shift = np.array([high[0] - low[0], 0.0])
    copies = np.concatenate([segments, segments - shift, segments + shift]) if periodic else segments

    def size(places: Array) -> Array:
        return _size(places, copies, width)

    border = _border(frame, size, periodic=periodic)
    fixed = np.concatenate([border, *sized])
    walls = np.concatenate([segments, _segments([border])]) if len(segments) else _segments([border])
    nodes = np.concatenate([fixed, _inner(low, high, size, walls, outlines)])
    for _ in range(SMOOTHING):
        triangles = _outside(nodes, Delaunay(nodes).simplices.astype(np.int64), outlines)
        nodes = _smoothed(nodes, triangles, len(fixed))
    triangles = _outside(nodes, Delaunay(nodes).simplices.astype(np.int64), outlines)
    _require_conforming(nodes, triangles, [border, *sized])
    return nodes, triangles


def _area(outline: Array) -> float:
    following = np.roll(outline, -1, axis=0)
    return 0.5 * float((outline[:, 0] * following[:, 1] - outline[:, 1] * following[:, 0]).sum())


def _segments(outlines: list[Array]) -> Array:
    """The ends (S, 2, 2) of the edges of closed outlines."""
    every = [np.stack([each, np.roll(each, -1, axis=0)], axis=1) for each in outlines]
    return np.concatenate(every) if every else np.zeros((0, 2, 2))


def _distance(places: Array, segments: Array) -> Array:
    """The distance of each place from the nearest segment."""
    if not len(segments):
        return np.full(len(places), np.inf)
    start, way = segments[:, 0], segments[:, 1] - segments[:, 0]
    apart = places[:, None] - start[None]
    share = np.clip((apart * way).sum(axis=2) / (way**2).sum(axis=1), 0.0, 1.0)
    found: Array = np.sqrt(((apart - share[:, :, None] * way) ** 2).sum(axis=2)).min(axis=1)
    return found


def _within(places: Array, outline: Array) -> Flags:
    """Whether places are in a convex outline with counterclockwise corners."""
    way = np.roll(outline, -1, axis=0) - outline
    apart = places[:, None] - outline[None]
    return np.asarray(((way[:, 0] * apart[:, :, 1] - way[:, 1] * apart[:, :, 0]) > 0.0).all(axis=1))


def _require_gaps(frame: Array, outlines: list[Array], least: float) -> None:
    for k, outline in enumerate(outlines):
        rest = _segments([frame, *(each for m, each in enumerate(outlines) if m != k)])
        inside = _within(outline, frame).all() and not any(
            _within(outline, each).any() for m, each in enumerate(outlines) if m != k
        )
        gap = float(min(_distance(outline, rest).min(), _distance(rest[:, 0], _segments([outline])).min()))
        if not inside or gap < least:
            where = f"is {gap:.3g} m from" if inside else "is outside of the channel, or 0 m from"
            message = f"obstacle {k} {where} another or from a side; expected at least {least:.3g} m for the flow "
            raise BadInput(message + "around it")


def _divided(outline: Array, longest: float, own: Array, outlines: list[Array]) -> Array:
    """The outline with additional nodes on long edges: at least 24 in all, and closer ones near other outlines and near
    much shorter edges.
    """
    rest, sides = _segments([each for each in outlines if each is not own]), _segments([outline])
    lengths = np.sqrt(((sides[:, 1] - sides[:, 0]) ** 2).sum(axis=1))
    spacings = []
    for (a, b), side in zip(sides, lengths, strict=True):
        gap = float(_distance(np.array([a, 0.5 * (a + b), b]), rest).min()) if len(rest) else math.inf
        edge = min(longest, float(lengths.sum()) / 24.0, 0.7 * gap)
        spacings.append(float(side) / max(1, math.ceil(float(side) / edge * (1.0 - 1e-9))))
    return np.concatenate(
        [_graded(side, spacing, (sides, np.array(spacings))) for side, spacing in zip(sides, spacings, strict=True)]
    )


def _graded(side: Array, spacing: float, every: tuple[Array, Array]) -> Array:
    """The nodes along a side, without its end, at equal distances that decrease near sides with much shorter edges;
    every = (sides, their spacings).
    """
    (a, b), (sides, spacings) = side, every
    short = spacings < SHORT * spacing
    if not short.any():
        count = round(float(np.hypot(*(b - a))) / spacing)
        return np.asarray(a + (b - a) * np.arange(count)[:, None] / count)
    along = np.linspace(0.0, 1.0, SAMPLES)
    places = a + along[:, None] * (b - a)
    size = np.full(len(along), spacing)
    for other, edge in zip(sides[short], spacings[short], strict=True):
        size = np.minimum(size, edge + GROWTH * _distance(places, other[None]))
    return _spread(side, along, size)


def _spread(side: Array, along: Array, size: Array, least: int = 1) -> Array:
    """The nodes along a side without its end, at least `least`, at distances given by `size` at the fractions `along`
    of it.
    """
    a, b = side
    density = float(np.hypot(*(b - a))) / size
    total = np.concatenate([[0.0], np.cumsum(0.5 * (density[1:] + density[:-1]) * np.diff(along))])
    count = max(least, math.ceil(total[-1]))
    share = np.interp(np.arange(count) / count * total[-1], total, along)
    found: Array = a + share[:, None] * (b - a)
    return found


def _size(places: Array, segments: Array, width: float) -> Array:
    """The length of mesh edges at places."""
    if not len(segments):
        return np.full(len(places), COARSEST * width)
    own = np.sqrt(((segments[:, 1] - segments[:, 0]) ** 2).sum(axis=1))
    best = np.full(len(places), COARSEST * width)
    start, way = segments[:, 0], segments[:, 1] - segments[:, 0]
    apart = places[:, None] - start[None]
    share = np.clip((apart * way).sum(axis=2) / (way**2).sum(axis=1), 0.0, 1.0)
    far = np.sqrt(((apart - share[:, :, None] * way) ** 2).sum(axis=2))
    found: Array = np.minimum(best, (own + GROWTH * far).min(axis=1))
    return found


def _border(frame: Array, size: Any, *, periodic: bool) -> Array:
    """The nodes along the sides of the box (below, right, above, left), at distances given by `size`; with `periodic`,
    nodes on the left and right have the same heights.
    """
    found = []
    along = np.linspace(0.0, 1.0, SAMPLES)
    for side in _segments([frame]):
        found.append(_spread(side, along, size(side[0] + along[:, None] * (side[1] - side[0])), least=2))
    if periodic:
        inner = found[1][:0:-1]
        found[3] = np.concatenate([frame[3:], np.stack([np.full(len(inner), frame[0, 0]), inner[:, 1]], axis=1)])
    return np.concatenate(found)


MOST_PLACES = 1e7
"""The largest number of places in the finest lattice over the whole channel."""


def _inner(
    low: tuple[float, float], high: tuple[float, float], size: Any, walls: Array, outlines: list[Array]
) -> Array:
    """The inner nodes, from hexagonal lattices of several spacings, each used where edges have about its spacing."""
    corners = np.array([low, high], float)
    finest = float(np.sqrt(((walls[:, 1] - walls[:, 0]) ** 2).sum(axis=1)).min())
    places_in_all = float(np.prod((corners[1] - corners[0]) / finest))
    if places_in_all > MOST_PLACES:
        raise BadInput(
            f"the shortest side of the obstacles (of discs, 1/48 of their circumference) is {finest:.3g} m, too short "
            f"for a mesh of the channel; expected at least {finest * math.sqrt(places_in_all / MOST_PLACES):.3g} m, or "
            "a flow computed elsewhere with flow.field"
        )
    found = np.zeros((0, 2))
    spacing, coarsest = finest, COARSEST * (high[1] - low[1])
    while True:
        last = spacing * 1.25 > coarsest
        nx, nz = np.ceil((corners[1] - corners[0]) / (spacing * np.array([1.0, 0.5 * math.sqrt(3.0)]))).astype(int) + 1
        column, row = np.meshgrid(np.arange(nx), np.arange(nz), indexing="ij")
        lattice = np.stack([column + 0.5 * (row % 2), 0.5 * math.sqrt(3.0) * row], axis=-1).reshape(-1, 2) * spacing
        places = corners[0] + lattice
        places = places[((places > corners[0]) & (places < corners[1])).all(axis=1)]
        kept = []
        for part in np.array_split(places, max(1, len(places) // 2000)):
            local = size(part)
            good = (local >= spacing * (1.0 - 1e-9)) & ((local < 1.25 * spacing) | last)
            good[good] &= _distance(part[good], walls) > 0.7 * spacing
            for outline in outlines:
                good[good] &= ~_within(part[good], outline)
            kept.append(part[good])
        found = np.concatenate([found, *kept])
        if last:
            return _spaced(found, size)
        spacing *= 1.25


def _spaced(places: Array, size: Any) -> Array:
    """The positions without those that are too close to an earlier one."""
    from scipy.spatial import cKDTree

    if not len(places):
        return places
    reach, tree = 0.6 * size(places), cKDTree(places)
    kept = np.ones(len(places), bool)
    for k in range(len(places)):
        if kept[k]:
            for m in tree.query_ball_point(places[k], reach[k]):
                kept[m] = kept[m] and m <= k
    return places[kept]


def _outside(nodes: Array, triangles: Integers, outlines: list[Array]) -> Integers:
    """The triangles outside of obstacles with a nonzero area."""
    corners = nodes[triangles]
    one, other = corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]
    double = one[:, 0] * other[:, 1] - one[:, 1] * other[:, 0]
    good = np.abs(double) > 1e-9 * (one**2 + other**2).sum(axis=1)
    middle = corners.mean(axis=1)
    for outline in outlines:
        good &= ~_within(middle, outline)
    # scikit-fem needs the corners of an element in ascending order.
    return np.sort(triangles[good], axis=1).astype(np.int64)


def _smoothed(nodes: Array, triangles: Integers, fixed: int) -> Array:
    """The nodes, with each inner one at the mean of its neighbors."""
    total, count = np.zeros_like(nodes), np.zeros(len(nodes))
    for a, b in ((0, 1), (1, 2), (2, 0)):
        for one, other in ((a, b), (b, a)):
            np.add.at(total, triangles[:, one], nodes[triangles[:, other]])
            np.add.at(count, triangles[:, one], 1.0)
    moved = nodes.copy()
    moved[fixed:] = total[fixed:] / np.maximum(count[fixed:, None], 1.0)
    return moved


def _require_conforming(nodes: Array, triangles: Integers, outlines: list[Array]) -> None:
    """Raise BadInput unless each edge of an outline is an edge of the mesh."""
    pairs = np.sort(np.concatenate([triangles[:, [0, 1]], triangles[:, [1, 2]], triangles[:, [2, 0]]]), axis=1)
    there = set(map(tuple, pairs.tolist()))
    first = 0
    for outline in outlines:
        number = first + np.arange(len(outline))
        for edge in np.sort(np.stack([number, np.roll(number, -1)], axis=1), axis=1).tolist():
            if tuple(edge) not in there:
                at = ", ".join(f"{value:.3g}" for value in nodes[edge[0]])
                raise BadInput(f"no mesh fits the obstacles near ({at}) m; move them apart or simplify them")
        first += len(outline)


# --- The flow


def _velocities(
    nodes: Array, triangles: Integers, box: tuple[tuple[float, float], tuple[float, float]], *, periodic: bool
) -> tuple[Array, Array]:
    """The coefficients of both velocity components on each triangle, at a mean speed of 1."""
    low, high = box
    try:
        import skfem
        from skfem.helpers import ddot, div, grad
    except ImportError as error:
        raise BadInput(f"the flow around obstacles needs scikit-fem: {install(EXTRA)}") from error
    from scipy.sparse import csr_array
    from scipy.sparse.linalg import splu

    mesh = skfem.MeshTri(np.ascontiguousarray(nodes.T), np.ascontiguousarray(triangles.T))
    basis = skfem.Basis(mesh, skfem.ElementVector(skfem.ElementTriP4()), intorder=8)
    stiffness = skfem.BilinearForm(lambda u, v, _: ddot(grad(u), grad(v))).assemble(basis)
    squares = skfem.BilinearForm(lambda u, v, _: div(u) * div(v)).assemble(basis)
    given = basis.get_dofs().flatten()
    fixed, width = np.zeros(basis.N), high[1] - low[1]
    x, z = basis.doflocs[:, given]
    share = (z - low[1]) / width
    along = np.isin(given, basis.get_dofs().all("u^1"))
    left, right = np.abs(x - low[0]) < 1e-9 * width, np.abs(x - high[0]) < 1e-9 * width
    push, source = np.zeros(basis.N), np.arange(basis.N)
    if periodic:
        inner = (share > 1e-9) & (share < 1.0 - 1e-9)
        here, there = (
            (order := np.flatnonzero(side & inner))[np.lexsort((z[order], along[order]))] for side in (left, right)
        )
        source[given[there]] = given[here]
        push = skfem.LinearForm(lambda v, _: v[0]).assemble(basis)
        given = given[~((left | right) & inner)]
    else:
        fixed[given] = np.where(along & (left | right), 6.0 * share * (1.0 - share), 0.0)
    # Values on the right and left are equal: one unknown represents both.
    unknown = np.setdiff1d(np.unique(source), given)
    copies = np.flatnonzero(np.isin(source, unknown))
    spread = csr_array(
        (np.ones(len(copies)), (copies, np.searchsorted(unknown, source[copies]))), (basis.N, len(unknown))
    )
    whole = (stiffness + PENALTY * squares).tocsc()
    factors = splu((spread.T @ whole @ spread).tocsc())
    known, pressure = push - whole @ fixed, np.zeros(basis.N)
    for _ in range(20):
        velocity = fixed + spread @ factors.solve(spread.T @ (known - squares @ pressure))
        pressure += PENALTY * velocity
        # The flux through each cross-section is the integral of the velocity over the area, divided by the length.
        speed = float(push @ velocity) / (width * (high[0] - low[0])) if periodic else 1.0
        slopes = np.asarray(basis.interpolate(velocity).grad)
        if np.abs(slopes[0, 0] + slopes[1, 1]).max() < DIVERGENCE / width * speed:
            velocity /= speed
            break
    else:
        raise BadInput("the flow around obstacles was not found; move them apart or simplify them")
    places = np.array([(i / 4.0, j / 4.0) for i in range(5) for j in range(5 - i)])
    sampled = skfem.Basis(mesh, basis.elem, quadrature=(places.T, np.ones(TERMS)))
    values = np.asarray(sampled.interpolate(velocity))
    powers = np.array([[a**i * b**j for i, j in EXPONENTS] for a, b in places])
    solved = np.linalg.solve(powers, values.reshape(-1, TERMS).T).T.reshape(2, len(triangles), TERMS)
    return np.ascontiguousarray(solved[0]), np.ascontiguousarray(solved[1])
