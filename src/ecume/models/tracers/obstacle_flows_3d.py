"""Creeping flow in a duct, or between plates, around obstacles in 3D, solved once by finite elements (scikit-fem).

Velocities are quadratic and pressures linear on tetrahedra [taylor1973], and then made free of divergence everywhere
(`divergence_free`), so that particles do not cluster. The velocity is zero at walls and obstacles. Spheres are replaced
by circumscribed polyhedra.
"""

from __future__ import annotations

from collections.abc import Callable
from functools import lru_cache
from typing import Any, Literal, NamedTuple

import numpy as np

from ecume._jit import compiled_inside
from ecume.engine.cells import Integers
from ecume.errors import BadInput, install
from ecume.laws import carrier_flows, flows
from ecume.models.tracers import divergence_free
from ecume.models.tracers.obstacle_flows import EXTRA
from ecume.models.tracers.simplex_bins import Bins, bins_of
from ecume.models.tracers.tetrahedral_mesh import (
    COARSEST,
    Body,
    Box,
    Mesh,
    Periodic,
    ball,
    gaps_of,
    mesh_of,
    polyhedron,
    width_of,
)
from ecume.units import Array

CLOSEST = 0.05
"""Of the width of the channel: the narrowest gap that is resolved."""
ACCURATE = 1e-8
"""Of the divergence of the first guess: where pressures have converged."""
ROUNDS = 500
"""Of the conjugate gradients at most."""

Point = tuple[float, float, float]
Sphere = tuple[Point, float]
Corners = tuple[Point, ...]
Velocities = Callable[[Array], Array]
"""(n, 3) velocities at places on the sides of the box."""
Inflow = Literal["channel", "duct"]
"""How the liquid enters and leaves: as between plates, or as in a rectangular duct."""


class SolidFlow(NamedTuple):
    """The flow of a duct with obstacles, on tetrahedra in four parts."""

    low: Point
    high: Point
    speed: float
    """m/s, the mean speed"""
    bins: Bins
    inverse: Array
    """(T, 12) the first corner of each tetrahedron, and the inverse of its edges"""
    cubic: Array
    """(T, 4, 20, 3) coefficients of the velocity over the mean one in each part"""


@compiled_inside
def solid_obstacle_velocity(shape: SolidFlow, x: float, y: float, z: float, time: float) -> Point:
    """The velocity of the flow, which is zero in obstacles; beyond the sides, the velocity at the sides."""
    bins, inverse = shape.bins, shape.inverse
    x = min(max(x, shape.low[0]), shape.high[0])
    y = min(max(y, shape.low[1]), shape.high[1])
    z = min(max(z, shape.low[2]), shape.high[2])
    i = min(int((x - shape.low[0]) / bins.step[0]), bins.first.shape[0] - 1)
    j = min(int((y - shape.low[1]) / bins.step[1]), bins.first.shape[1] - 1)
    k = min(int((z - shape.low[2]) / bins.step[2]), bins.first.shape[2] - 1)
    for m in range(bins.many[i, j, k]):
        t = bins.near[bins.first[i, j, k] + m]
        dx, dy, dz = x - inverse[t, 0], y - inverse[t, 1], z - inverse[t, 2]
        a = inverse[t, 3] * dx + inverse[t, 4] * dy + inverse[t, 5] * dz
        b = inverse[t, 6] * dx + inverse[t, 7] * dy + inverse[t, 8] * dz
        c = inverse[t, 9] * dx + inverse[t, 10] * dy + inverse[t, 11] * dz
        rest = 1.0 - a - b - c
        if a >= -1e-12 and b >= -1e-12 and c >= -1e-12 and rest >= -1e-12:
            # In the part with the smallest coordinate, the center takes the place of the corner of that coordinate.
            part, least = 0, rest
            if a < least:
                part, least = 1, a
            if b < least:
                part, least = 2, b
            if c < least:
                part = 3
            u, v, w, term = 0.0, 0.0, 0.0, 0
            for total in range(4):
                for first in range(total, -1, -1):
                    for second in range(total - first, -1, -1):
                        power = a**first * b**second * c ** (total - first - second)
                        u += shape.cubic[t, part, term, 0] * power
                        v += shape.cubic[t, part, term, 1] * power
                        w += shape.cubic[t, part, term, 2] * power
                        term += 1
            return shape.speed * u, shape.speed * v, shape.speed * w
    return 0.0, 0.0, 0.0


def solid_flow(
    low: Point,
    high: Point,
    obstacles: tuple[Sphere | Corners, ...],
    speed: float,
    inflow: Inflow,
    periodic: Periodic,
) -> Any:
    """The flow along x, with a mean speed, in a box around spheres (center, radius) and convex polyhedra (corners).
    `periodic` contains the axes along which the flow repeats; if x is one of them, a pressure gradient drives the flow.
    Raises BadInput for obstacles that are too close to each other or to a side, or need too many elements, and without
    scikit-fem. [taylor1973; zhang2005].
    """
    return _solved(low, high, obstacles, inflow, periodic)._replace(speed=speed)


def inflow_of(low: Array, high: Array, inflow: Inflow) -> Velocities:
    """The velocities at both ends of a channel, at a mean speed of 1; zero at its other sides."""
    (_, width, depth), middle = high - low, 0.5 * (low + high)
    middling = carrier_flows.duct_mean(float(width), float(depth)) if inflow == "duct" else 1.0

    def speed(across: float, up: float) -> float:
        if inflow == "channel":
            return flows.channel_speed(0.5 * depth - up, depth, 1.0)
        return carrier_flows.duct_speed(across, up, float(width), float(depth), 1.0 / middling)

    def velocities(places: Array) -> Array:
        found = np.zeros_like(places)
        ends = _at(places[:, 0], low[0], (low, high)) | _at(places[:, 0], high[0], (low, high))
        away = np.abs(places - middle)
        walls = _at(away[:, 2], 0.5 * depth, (low, high))
        if inflow == "duct":
            walls |= _at(away[:, 1], 0.5 * width, (low, high))
        for i in np.flatnonzero(ends & ~walls):
            found[i, 0] = speed(float(away[i, 1]), float(away[i, 2]))
        return found

    return velocities


@lru_cache(maxsize=2)
def _solved(
    low: Point, high: Point, obstacles: tuple[Sphere | Corners, ...], inflow: Inflow, periodic: Periodic
) -> SolidFlow:
    box = (np.array(low), np.array(high))
    mesh = mesh_of(*box, bodies_of(obstacles, box), periodic)
    return shape_of(solved(mesh, box, inflow_of(*box, inflow), periodic), low, high)


def shape_of(solution: Solution, low: Point, high: Point) -> SolidFlow:
    """The divergence-free flow of a solution."""
    cubic, inverse = divergence_free.without_divergence(solution.mesh, solution.quadratic, solution.pairs)
    corners = solution.mesh.p.T[solution.mesh.t.T]
    bins = bins_of(corners, low, high, 1.5 * len(corners) ** (1.0 / 3.0))
    return SolidFlow(low, high, 1.0, bins, inverse, cubic)


def bodies_of(obstacles: tuple[Sphere | Corners, ...], box: Box) -> list[Body]:
    """The obstacles, with shorter edges where gaps are narrow. Raises BadInput for gaps that are too narrow."""
    width = width_of(*box)
    gaps = gaps_of([_body(each, COARSEST * width) for each in obstacles], *box)
    for k, gap in enumerate(gaps):
        if gap < CLOSEST * width:
            raise BadInput(
                f"obstacle {k} is {gap:.3g} m from another or from a side; expected at least {CLOSEST * width:.3g} m "
                "for the flow around it"
            )
    return [_body(each, min(COARSEST * width, 0.7 * gap)) for each, gap in zip(obstacles, gaps, strict=True)]


def _body(obstacle: Sphere | Corners, edge: float) -> Body:
    if isinstance(obstacle[1], float):
        return ball(obstacle[0], obstacle[1], edge)
    return polyhedron(np.array(obstacle), edge)


class Solution(NamedTuple):
    """Velocities on the mesh of scikit-fem."""

    mesh: Any
    quadratic: Array
    """(T, 10, 3) coefficients in coordinates along the edges of each tetrahedron"""
    pairs: Integers
    """(P, 2) faces on two periodic sides that are the same"""


def solved(mesh: Mesh, box: Box, given_at: Velocities, periodic: Periodic, *, balanced: bool = True) -> Solution:
    """Solve Stokes's equations with given velocities at obstacles and at sides that are not periodic. If `balanced`,
    the velocities at both ends are scaled to a mean speed of 1. Raises BadInput without scikit-fem.
    """
    try:
        import skfem
    except ImportError as error:
        raise BadInput(f"the flow around obstacles needs scikit-fem: {install(EXTRA)}") from error
    grid = skfem.MeshTet(np.ascontiguousarray(mesh.nodes.T), np.ascontiguousarray(mesh.tetrahedra.T))
    basis = skfem.Basis(grid, skfem.ElementTetP2(), intorder=3)
    faces, pairs = _faces_of(grid, box, periodic)
    velocity = np.zeros((basis.N, 3))
    given = basis.get_dofs(faces).flatten()
    velocity[given] = given_at(basis.doflocs[:, given].T)
    if balanced and not periodic[0]:
        _balance(velocity, grid, basis, faces, box)
    inner = np.setdiff1d(np.arange(basis.N), given)
    velocity = _stokes(basis, velocity, inner, _copies(basis.doflocs, box, periodic), box, driven=periodic[0])
    places = np.array([each for each in np.ndindex(3, 3, 3) if sum(each) < 3]) / 2.0
    sampled = skfem.Basis(grid, basis.elem, quadrature=(places.T, np.ones(len(places))))
    values = np.stack([np.asarray(sampled.interpolate(np.ascontiguousarray(each))) for each in velocity.T], axis=-1)
    powers = np.linalg.inv(divergence_free.monomials(places, divergence_free.QUADRATICS))
    return Solution(grid, np.einsum("cp,tpk->tck", powers, values), pairs)


def _at(places: Array, value: float, box: Box) -> np.ndarray[tuple[int, ...], np.dtype[np.bool_]]:
    return np.asarray(np.abs(places - value) < 1e-9 * float((box[1] - box[0]).min()))


def _twins(left: Array, right: Array) -> Integers:
    """The index of the position on the left that corresponds to each one on the right."""
    from scipy.spatial import cKDTree

    far, which = cKDTree(left).query(right)
    if len(left) != len(right) or float(np.max(far)) > 1e-9 * float(np.ptp(left, axis=0).max()):
        raise BadInput("no mesh of the obstacles is the same on both periodic sides; move them away from the sides")
    return np.asarray(which, np.int64)


def _faces_of(grid: Any, box: Box, periodic: Periodic) -> tuple[Integers, Integers]:
    """The faces on which velocities are given, and the pairs of equivalent faces on periodic sides."""
    border = grid.boundary_facets()
    middle = grid.p[:, grid.facets[:, border]].mean(axis=1)
    kept, pairs = np.ones(len(border), bool), [np.zeros((0, 2), np.int64)]
    for axis in range(3):
        if periodic[axis]:
            here, there = (np.flatnonzero(_at(middle[axis], end[axis], box)) for end in box)
            flat = [k for k in range(3) if k != axis]
            which = _twins(middle[flat][:, here].T, middle[flat][:, there].T)
            pairs.append(np.stack([border[here[which]], border[there]], axis=1))
            kept[here] = kept[there] = False
    return border[kept], np.concatenate(pairs)


def _copies(places: Array, box: Box, periodic: Periodic) -> Integers:
    """The index of the node that represents each node: nodes on upper periodic sides are represented by those on lower
    ones.
    """
    found = np.arange(places.shape[1])
    for axis in range(3):
        if periodic[axis]:
            here, there = (np.flatnonzero(_at(places[axis], end[axis], box)) for end in box)
            flat = [k for k in range(3) if k != axis]
            found[there] = here[_twins(places[flat][:, here].T, places[flat][:, there].T)]
    for _ in range(2):
        found = found[found]
    return found


def _balance(velocity: Array, grid: Any, basis: Any, faces: Integers, box: Box) -> None:
    """Scale the velocities along x on both ends, so that the mean speed is 1 there."""
    import skfem

    middle = grid.p[0, grid.facets[:, faces]].mean(axis=0)
    area = float((box[1] - box[0])[1:].prod())
    for end in box:
        side = skfem.FacetBasis(grid, basis.elem, facets=faces[_at(middle, end[0], box)], intorder=2)
        through = float(skfem.LinearForm(lambda v, _: v).assemble(side) @ velocity[:, 0])
        nodes = _at(basis.doflocs[0], end[0], box)
        velocity[nodes, 0] *= area / through


def _stokes(basis: Any, velocity: Array, inner: Integers, copies: Integers, box: Box, *, driven: bool) -> Array:
    """The velocities at all nodes, given at all but the inner ones. If `driven`, a pressure gradient along x drives the
    flow to a mean speed of 1. The pressure is computed by conjugate gradients, preconditioned with the mass matrix.
    """
    import skfem
    from scipy.sparse.linalg import splu

    linear = basis.with_element(skfem.ElementTetP1())
    stiffness = skfem.BilinearForm(lambda u, v, _: sum(u.grad[k] * v.grad[k] for k in range(3))).assemble(basis)
    slopes = [skfem.BilinearForm(lambda u, q, _, k=k: u.grad[k] * q).assemble(basis, linear) for k in range(3)]
    push, mass = (skfem.LinearForm(lambda v, _: v).assemble(each) for each in (basis, linear))
    inner = inner[np.isin(copies[inner], inner)]
    spread = _spread(copies, np.unique(copies[inner]), inner, basis.N)
    nodes = copies[: linear.N]
    gather = _spread(nodes, np.unique(nodes), np.arange(linear.N), linear.N)
    mass = gather.T @ mass
    options = {"SymmetricMode": True}
    matrix = (spread.T @ stiffness @ spread).tocsc()
    factors = splu(matrix, permc_spec="MMD_AT_PLUS_A", diag_pivot_thresh=0.0, options=options)
    divergence = [(gather.T @ each @ spread).tocsr() for each in slopes]
    force = spread.T @ (-(stiffness @ velocity))
    if driven:
        force[:, 0] += spread.T @ push
    found = factors.solve(force)
    # In a corner of the box all velocities may be given, and the pressure there has no effect.
    weights = np.asarray(sum(abs(each) for each in divergence).sum(axis=1)).ravel()
    coupled = np.flatnonzero(weights > 1e-9 * weights.max())
    divergence, mass = [each[coupled] for each in divergence], mass[coupled]
    left = -gather.T @ sum(slopes[k] @ velocity[:, k] for k in range(3))

    def flow_of(pressure: Array) -> Array:
        solution: Array = factors.solve(np.stack([each.T @ pressure for each in divergence], axis=1))
        return solution

    def divergence_of(flow: Array) -> Array:
        return np.asarray(sum(each @ flow[:, k] for k, each in enumerate(divergence)))

    right = left[coupled] - divergence_of(found)
    found += flow_of(_pressure(right, mass, lambda each: divergence_of(flow_of(each))))
    whole: Array = velocity + spread @ found
    if driven:
        # The flux through each section is the integral of the velocity over the volume, divided by the length.
        whole *= float((box[1] - box[0]).prod()) / float(push @ whole[:, 0])
    return whole


def _spread(copies: Integers, unknown: Integers, nodes: Integers, count: int) -> Any:
    """The matrix that maps the unknowns to the nodes that they represent."""
    from scipy.sparse import csr_array

    entries = (np.ones(len(nodes)), (nodes, np.searchsorted(unknown, copies[nodes])))
    return csr_array(entries, (count, len(unknown)))


def _pressure(right: Array, mass: Array, apply: Callable[[Array], Array]) -> Array:
    """The pressure by conjugate gradients, determined up to a constant. Raises BadInput if they do not converge."""

    def weighted(residual: Array) -> Array:
        return np.asarray(residual / mass - residual.sum() / mass.sum())

    pressure, residual = np.zeros_like(right), right.copy()
    ahead = weighted(residual)
    square = float(residual @ ahead)
    target = ACCURATE**2 * square
    for _ in range(ROUNDS):
        if square <= target:
            return pressure
        image = apply(ahead)
        step = square / float(ahead @ image)
        pressure += step * ahead
        residual -= step * image
        following = weighted(residual)
        square, former = float(residual @ following), square
        ahead = following + square / former * ahead
    raise BadInput("the flow around obstacles was not found; move them apart or simplify them")
