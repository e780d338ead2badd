"""Tetrahedra that fill a box around convex bodies: a Delaunay triangulation of nodes that are closer together near the
bodies.

The mesh follows the surfaces of the convex hulls of the nodes of bodies exactly. The nodes between the bodies are those
of body-centered lattices, each used where edges have about its spacing; they are smoothed, and nodes of flat tetrahedra
are moved at random.
"""

from __future__ import annotations

import itertools
import math
from collections.abc import Callable
from typing import NamedTuple

import numpy as np

from ecume.engine.cells import Integers
from ecume.errors import BadInput
from ecume.units import Array

COARSEST = 0.1
"""Of the width of the channel: the longest edge."""
GROWTH = 0.35
"""How fast edges grow with the distance from bodies."""
FINER = 1.25
"""The spacing of a lattice over that of the next finer one."""
ON_SPHERE = 300
"""Nodes on a sphere at least."""
SHORT = 0.65
"""Of the size of edges: the least distance of nodes."""
CLEAR = 0.35
"""Of the size of edges: the least distance of inner nodes from bodies and sides."""
SMOOTHING = 8
"""Rounds in which inner nodes move to the middle of their neighbors."""
CLEARING = 6
"""Rounds at most in which inner nodes are removed whose tetrahedra reach into bodies."""
FLAT = 0.08
"""Of the volume of a regular tetrahedron with such edges: flatter ones are improved."""
MENDING = 30
"""Rounds at most in which nodes of flat tetrahedra are moved."""
MOST = 12_000
"""Nodes at most: the flow on them takes about a minute."""

Sizes = Callable[[Array], Array]
Flags = np.ndarray[tuple[int, ...], np.dtype[np.bool_]]
Box = tuple[Array, Array]
"""The lower and the upper corner (m)."""
Periodic = tuple[bool, bool, bool]


class Body(NamedTuple):
    """A convex body by nodes on its surface."""

    nodes: Array
    planes: Array
    """(m, 4) outward normals, and minus the distances from the origin"""
    volume: float
    edge: float
    """m: of the triangles on its surface"""

    def beyond(self, places: Array) -> Array:
        """The largest distance of places from the planes of the body; positive outside."""
        found: Array = (places @ self.planes[:, :3].T + self.planes[:, 3]).max(axis=1)
        return found


class Mesh(NamedTuple):
    """The nodes, and the four nodes of each tetrahedron."""

    nodes: Array
    tetrahedra: Integers


def ball(center: tuple[float, ...], radius: float, edge: float = math.inf) -> Body:
    """A polyhedron circumscribed about a sphere, with nodes on a Fibonacci spiral, at most about an edge apart."""
    count = max(ON_SPHERE, math.ceil(4.0 * math.pi * radius**2 / (0.866 * edge**2)))
    k = np.arange(count) + 0.5
    up, turn = 1.0 - 2.0 * k / count, math.pi * (1.0 + math.sqrt(5.0)) * k
    flat = np.sqrt(1.0 - up * up)
    ways = np.stack([flat * np.cos(turn), flat * np.sin(turn), up], axis=1)
    # Scaled so that no facet cuts the sphere.
    far = radius / float(_body_of(ways, 1.0).planes[:, 3].max() * -1.0)
    return _body_of(np.array(center) + far * ways, radius * math.sqrt(4.0 * math.pi / (0.866 * count)))


def polyhedron(vertices: Array, edge: float = math.inf) -> Body:
    """The convex hull of points, with nodes on its surface at most an edge apart."""
    from scipy.spatial import ConvexHull

    hull = ConvexHull(vertices)
    edge = min(edge, 0.35 * (0.75 * hull.volume / math.pi) ** (1.0 / 3.0))
    facets = hull.points[hull.simplices]
    while True:
        lengths = np.sqrt(((np.roll(facets, -1, axis=1) - facets) ** 2).sum(axis=2))
        long = lengths.max(axis=1) > edge
        if not long.any():
            break
        if len(facets) > 4 * MOST:
            raise BadInput("an obstacle needs too many nodes for the flow around it; expected it thicker")
        # The longest edge of each facet is divided; it is the same for both facets that share it.
        cut, which, row = facets[long], lengths[long].argmax(axis=1), np.arange(int(long.sum()))
        a, b, c = (cut[row, (which + k) % 3] for k in range(3))
        middle = 0.5 * (a + b)
        facets = np.concatenate([facets[~long], np.stack([a, middle, c], 1), np.stack([middle, b, c], 1)])
    places = facets.reshape(-1, 3)
    _, first = np.unique(np.round(places / (1e-6 * edge)).astype(np.int64), axis=0, return_index=True)
    return _body_of(places[np.sort(first)], edge)


def _body_of(nodes: Array, edge: float) -> Body:
    from scipy.spatial import ConvexHull

    hull = ConvexHull(nodes)
    return Body(nodes, hull.equations, float(hull.volume), edge)


def gaps_of(bodies: list[Body], low: Array, high: Array) -> list[float]:
    """A lower bound of the distance of each body from the others and the sides; 0 where they touch."""
    found = []
    for k, body in enumerate(bodies):
        sides = float(np.minimum(body.nodes - low, high - body.nodes).min())
        others = [each for m, each in enumerate(bodies) if m != k]
        # The distance from a plane between two bodies.
        apart = [
            max(
                float((one.nodes @ two.planes[:, :3].T + two.planes[:, 3]).min(axis=0).max())
                for one, two in ((body, other), (other, body))
            )
            for other in others
        ]
        found.append(max(0.0, min([sides, *apart])))
    return found


def mesh_of(low: Array, high: Array, bodies: list[Body], periodic: Periodic) -> Mesh:
    """The tetrahedra of a box around bodies; those along two periodic sides are the same. Raises BadInput."""
    mesh = _mesh_of(low, high, bodies, periodic)
    volume = float((high - low).prod()) - sum(body.volume for body in bodies)
    if abs(float(np.abs(volumes(mesh.nodes, mesh.tetrahedra)).sum()) - volume) > 1e-9 * volume:
        raise BadInput(
            "no mesh fits the obstacles; expected them farther apart, or blunter and with fewer faces, such as boxes "
            "and spheres; a flow computed elsewhere is read with flow.field"
        )
    # scikit-fem requires the corners of an element in ascending order.
    return Mesh(mesh.nodes, np.sort(mesh.tetrahedra, axis=1))


def _mesh_of(low: Array, high: Array, bodies: list[Body], periodic: Periodic) -> Mesh:
    """The mesh without the final check for tetrahedra that cut sharp ridges of bodies."""
    size = _sizes(low, high, bodies, periodic)
    extremes = (min(body.edge for body in bodies), COARSEST * width_of(low, high))
    rng = np.random.default_rng(0)
    border = _border((low, high), size, extremes, periodic, rng)
    fixed = np.concatenate([border, *(body.nodes for body in bodies)])
    places = _lattices((low, high), size, extremes, rng)

    def clear(places: Array) -> Flags:
        return _clear(places, size, (low, high), bodies)

    places = places[clear(places)]
    nodes = np.concatenate([fixed, _spaced(places, SHORT * size(places), fixed)])
    if len(nodes) > MOST:
        message = f"the flow around the obstacles needs {len(nodes)} nodes; at most {MOST} are solved at a start. "
        raise BadInput(message + "Expected a shorter channel or larger obstacles, or a flow.field computed elsewhere")
    for _ in range(SMOOTHING):
        moved = _smoothed(nodes, _filled(nodes, bodies, size), len(fixed))
        nodes = np.where(clear(moved)[:, None], moved, nodes)
    nodes = _improved(nodes, len(fixed), lambda each: _filled(each, bodies, size), size, clear, rng)
    for _ in range(CLEARING):
        tetrahedra = _filled(nodes, bodies, size)
        near = np.unique(tetrahedra[_crossing(nodes, tetrahedra, bodies)])
        if not (near >= len(fixed)).any():
            break
        nodes = np.delete(nodes, near[near >= len(fixed)], axis=0)
    return Mesh(nodes, _filled(nodes, bodies, size))


def _crossing(nodes: Array, tetrahedra: Integers, bodies: list[Body]) -> Flags:
    """Whether an edge or a face of each tetrahedron reaches into a body: an inner node is too close to its surface."""
    corners = nodes[tetrahedra]
    parts = [ends for count in (2, 3) for ends in itertools.combinations(range(4), count)]
    middles = np.stack([corners[:, ends].mean(axis=1) for ends in parts], axis=1)
    found = np.zeros(len(tetrahedra), bool)
    for body in bodies:
        depth = body.beyond(middles.reshape(-1, 3)).reshape(len(tetrahedra), len(parts))
        found |= depth.min(axis=1) < -1e-9 * body.edge
    return found


def _sizes(low: Array, high: Array, bodies: list[Body], periodic: Periodic) -> Sizes:
    """The length of edges at places."""
    from scipy.spatial import cKDTree

    sides = high - low
    turns = itertools.product(*((0.0, 1.0, -1.0) if each else (0.0,) for each in periodic))
    copies = [body.nodes + np.array(turn) * sides for turn in turns for body in bodies]
    own = np.concatenate([np.full(len(body.nodes), body.edge) for body in bodies] * (len(copies) // len(bodies)))
    tree, coarsest = cKDTree(np.concatenate(copies)), COARSEST * width_of(low, high)

    def size(places: Array) -> Array:
        far, which = tree.query(places)
        return np.minimum(own[which] + GROWTH * far, coarsest)

    return size


def width_of(low: Array, high: Array) -> float:
    """The smaller side across the channel (m)."""
    return float((high - low)[1:].min())


def _border(
    box: Box, size: Sizes, extremes: tuple[float, float], periodic: Periodic, rng: np.random.Generator
) -> Array:
    """Nodes on the corners, the edges and the sides of the box; those of two periodic sides are the same."""
    low, high = box
    corners = np.where(np.array(list(np.ndindex(2, 2, 2))) == 0, low, high)
    edges = [
        _along_edge(corners[a], corners[b], size)
        for a, b in itertools.combinations(range(8), 2)
        if (corners[a] != corners[b]).sum() == 1
    ]
    rim = np.concatenate([corners, *edges])
    found = [rim]
    for axis in range(3):
        flat = [k for k in range(3) if k != axis]
        for end in (low, high):
            if periodic[axis] and end is high:
                found.append(found[-1] + (high - low) * (np.arange(3) == axis))
                continue

            def size_there(places: Array, axis: int = axis, end: Array = end) -> Array:
                return size(np.insert(places, axis, end[axis], axis=1))

            places = _lattices((low[flat], high[flat]), size_there, extremes, rng)
            on_side = rim[rim[:, axis] == end[axis]][:, flat]
            places = _spaced(places, SHORT * size_there(places), on_side)
            found.append(np.insert(places, axis, end[axis], axis=1))
    return np.concatenate(found)


def _along_edge(a: Array, b: Array, size: Sizes) -> Array:
    """Nodes between two corners, at the distances that the sizes prescribe."""
    share = np.linspace(0.0, 1.0, 400)
    density = float(np.abs(b - a).max()) / size(a + share[:, None] * (b - a))
    total = np.concatenate([[0.0], np.cumsum(0.5 * (density[1:] + density[:-1]) * np.diff(share))])
    count = max(2, math.ceil(total[-1]))
    places: Array = a + np.interp(np.arange(1, count) / count * total[-1], total, share)[:, None] * (b - a)
    return places


LATTICES: dict[int, tuple[tuple[float, ...], tuple[tuple[float, ...], tuple[float, ...]]]] = {
    2: ((1.0, math.sqrt(3.0)), ((0.0, 0.0), (0.5, 0.5))),
    3: ((2.0 / math.sqrt(3.0),) * 3, ((0.0,) * 3, (0.5,) * 3)),
}
"""The sides of the cell of a lattice over the distance of its nodes, and the two nodes in a cell: hexagonal in 2D,
body-centered in 3D."""


def _lattices(box: Box, size: Sizes, extremes: tuple[float, float], rng: np.random.Generator) -> Array:
    """The nodes of lattices, each used where edges have about its spacing, and displaced slightly so that no five are
    on one sphere; extremes = the shortest and the longest edge.
    """
    (low, high), (finest, coarsest) = box, extremes
    cell, base = (np.array(each) for each in LATTICES[len(low)])
    found: list[Array] = []
    spacing = finest
    while True:
        count = np.ceil((high - low) / (spacing * cell)).astype(int) + 1
        if count.prod() > 200 * MOST:
            raise BadInput("the obstacles are too small for the channel around them; use flow.field for their flow")
        grid = np.stack(np.meshgrid(*map(np.arange, count), indexing="ij"), axis=-1).reshape(-1, 1, len(low))
        places = low + ((grid + base).reshape(-1, len(low)) + 0.37) * spacing * cell
        places = places[((places > low) & (places < high)).all(axis=1)]
        lengths = size(places)
        found.append(places[(lengths >= spacing * (1.0 - 1e-9)) & (lengths < FINER * spacing)])
        if spacing * FINER > coarsest:
            break
        spacing *= FINER
    every = np.concatenate(found)
    moved: Array = every + 0.03 * size(every)[:, None] * rng.uniform(-1.0, 1.0, every.shape)
    return np.clip(moved, low + 1e-3 * finest, high - 1e-3 * finest)


def _spaced(places: Array, reach: Array, fixed: Array) -> Array:
    """The positions without those that are too close to a fixed or to an earlier one."""
    from scipy.spatial import cKDTree

    far = cKDTree(fixed).query(places)[0] > reach
    places, reach = places[far], reach[far]
    if not len(places):
        return places
    kept = np.ones(len(places), bool)
    for k, near in enumerate(cKDTree(places).query_ball_point(places, reach)):
        if kept[k]:
            later = np.array(near)
            kept[later[later > k]] = False
    return places[kept]


def _clear(places: Array, size: Sizes, box: Box, bodies: list[Body]) -> Flags:
    """Whether places are far enough from bodies and sides."""
    least = CLEAR * size(places)
    found: Flags = np.minimum(places - box[0], box[1] - places).min(axis=1) > least
    for body in bodies:
        found[found] &= body.beyond(places[found]) > least[found]
    return found


def _outside(places: Array, bodies: list[Body]) -> Flags:
    found = np.ones(len(places), bool)
    for body in bodies:
        found[found] &= body.beyond(places[found]) > 0.0
    return found


def _filled(nodes: Array, bodies: list[Body], size: Sizes) -> Integers:
    """The Delaunay tetrahedra between nodes, without those in bodies and without flat ones on the surfaces."""
    from scipy.spatial import Delaunay

    found = Delaunay(nodes).simplices.astype(np.int64)
    found = found[_outside(nodes[found].mean(axis=1), bodies)]
    flat = np.abs(volumes(nodes, found)) < 1e-9 * size(nodes[found].mean(axis=1)) ** 3
    return found[~flat]


def volumes(nodes: Array, tetrahedra: Integers) -> Array:
    """The volume of each tetrahedron, with a sign."""
    corners = nodes[tetrahedra]
    return np.asarray(np.linalg.det(corners[:, 1:] - corners[:, :1]) / 6.0)


def shapes_of(nodes: Array, tetrahedra: Integers) -> Array:
    """The volume of each tetrahedron over that of a regular one with the same mean square of edges."""
    corners = nodes[tetrahedra]
    square = sum(((corners[:, a] - corners[:, b]) ** 2).sum(axis=1) for a, b in itertools.combinations(range(4), 2))
    found: Array = 6.0 * math.sqrt(2.0) * np.abs(volumes(nodes, tetrahedra)) / (square / 6.0) ** 1.5
    return found


def _smoothed(nodes: Array, tetrahedra: Integers, fixed: int) -> Array:
    """The nodes, with each inner one moved to the center of its neighbors."""
    total, count = np.zeros_like(nodes), np.zeros(len(nodes))
    for a, b in itertools.permutations(range(4), 2):
        for axis in range(3):
            total[:, axis] += np.bincount(tetrahedra[:, a], nodes[tetrahedra[:, b], axis], len(nodes))
        count += np.bincount(tetrahedra[:, a], minlength=len(nodes))
    moved = nodes.copy()
    moved[fixed:] = total[fixed:] / np.maximum(count[fixed:, None], 1.0)
    return moved


def _improved(
    nodes: Array,
    fixed: int,
    filled: Callable[[Array], Integers],
    size: Sizes,
    clear: Callable[[Array], Flags],
    rng: np.random.Generator,
) -> Array:
    """The nodes, with those of flat tetrahedra moved until few or none are flat."""
    tetrahedra = filled(nodes)
    flat = shapes_of(nodes, tetrahedra) < FLAT
    for _ in range(MENDING):
        free = np.unique(tetrahedra[flat])
        free = free[free >= fixed]
        if not len(free):
            break
        moved = nodes.copy()
        moved[free] += 0.12 * size(nodes[free])[:, None] * rng.uniform(-1.0, 1.0, (len(free), 3))
        moved[free] = np.where(clear(moved[free])[:, None], moved[free], nodes[free])
        others = filled(moved)
        flatter = shapes_of(moved, others) < FLAT
        if flatter.sum() < flat.sum():
            nodes, tetrahedra, flat = moved, others, flatter
    return nodes
