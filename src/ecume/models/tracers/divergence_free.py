"""Correction of velocities on tetrahedra, after which their divergence vanishes everywhere instead of only on average.

A solution with quadratic velocities has a divergence in each tetrahedron. First the fluxes through faces are corrected
by least squares so that the net flux into each tetrahedron is zero; the corrections are cubic bubbles on faces. The
remaining divergence is removed within each tetrahedron. Its center divides it into four parts, on which continuous
cubics that vanish on its surface can have any divergence with zero mean [zhang2005]. The result is continuous, and zero
where the solution is zero on surfaces.
"""

from __future__ import annotations

import itertools
import math
from functools import cache
from typing import Any

import numpy as np

from ecume.engine.cells import Integers
from ecume.units import Array

Exponents = tuple[int, int, int]


def exponents(degree: int) -> tuple[Exponents, ...]:
    """The exponents of all monomials in three variables up to a degree, in the order of `obstacle_flows_3d`."""
    return tuple(
        (i, j, total - i - j)
        for total in range(degree + 1)
        for i in range(total, -1, -1)
        for j in range(total - i, -1, -1)
    )


CUBICS, QUADRATICS = exponents(3), exponents(2)
IN_CUBICS = [CUBICS.index(each) for each in QUADRATICS]
CORNERS = np.array([[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]])
"""Of the tetrahedron with the coordinates of monomials."""
MEAN = np.array([math.prod(map(math.factorial, each)) / math.factorial(sum(each) + 3) for each in QUADRATICS])
"""Integrals of quadratic monomials over that tetrahedron."""


def monomials(places: Array, powers: tuple[Exponents, ...]) -> Array:
    """The values of monomials at some positions, in the last axis."""
    found: Array = np.stack([np.prod(places ** np.array(each), axis=-1) for each in powers], axis=-1)
    return found


@cache
def slopes() -> Array:
    """The coefficients (3, 10, 20) of the derivative along each axis of each cubic monomial."""
    found = np.zeros((3, len(QUADRATICS), len(CUBICS)))
    for column, powers in enumerate(CUBICS):
        for axis in range(3):
            if powers[axis]:
                lower = tuple(each - (k == axis) for k, each in enumerate(powers))
                found[axis, QUADRATICS.index(lower), column] = powers[axis]
    return found


def _product(one: Array, other: Array) -> Array:
    """The product of two polynomials as cubic coefficients; higher terms must vanish."""
    found = np.zeros(len(CUBICS))
    for (a, p), (b, q) in itertools.product(enumerate(CUBICS), enumerate(CUBICS)):
        if one[a] and other[b]:
            found[CUBICS.index((p[0] + q[0], p[1] + q[1], p[2] + q[2]))] += one[a] * other[b]
    return found


@cache
def face_bubbles() -> Array:
    """The coefficients (4, 20) of the product of the barycentric coordinates of the corners of the face opposite to
    each corner.
    """
    linear = np.zeros((4, len(CUBICS)))
    linear[0, CUBICS.index((0, 0, 0))] = 1.0
    for k, powers in enumerate(((1, 0, 0), (0, 1, 0), (0, 0, 1)), 1):
        linear[0, CUBICS.index(powers)], linear[k, CUBICS.index(powers)] = -1.0, 1.0
    others = [[k for k in range(4) if k != corner] for corner in range(4)]
    return np.array([_product(_product(linear[a], linear[b]), linear[c]) for a, b, c in others])


@cache
def inner_correction() -> Array:
    """The coefficients (4, 20, 3, 10), in each of the four parts, of the field that vanishes on the surface and whose
    divergence is minus the one given by its 10 coefficients, without its mean.
    """
    weights = np.array([each for each in itertools.product(range(4), repeat=4) if sum(each) == 3]) / 3.0
    basis: dict[tuple[int, ...], Array] = {}
    for part in range(4):
        corners = CORNERS.copy()
        corners[part] = CORNERS.mean(axis=0)
        places = weights @ corners
        for place, column in zip(places, np.linalg.inv(monomials(places, CUBICS)).T, strict=True):
            if min(1.0 - place.sum(), *place) > 1e-9:
                key = tuple(np.round(12.0 * place).astype(int).tolist())
                basis.setdefault(key, np.zeros((4, len(CUBICS))))[part] = column
    nodes = np.array(list(basis.values()))
    divergence = np.einsum("aqc,nsc->sqna", slopes(), nodes).reshape(4 * len(QUADRATICS), -1)
    without_mean = np.eye(len(QUADRATICS))
    without_mean[0] -= MEAN / MEAN[0]
    required = np.tile(-without_mean, (4, 1))
    shares = np.linalg.lstsq(divergence, required, rcond=1e-10)[0].reshape(len(nodes), 3, len(QUADRATICS))
    found: Array = np.einsum("nsc,nap->scap", nodes, shares)
    return found


def without_divergence(mesh: Any, quadratic: Array, pairs: Integers) -> tuple[Array, Array]:
    """The coefficients (T, 4, 20, 3) in the parts of each tetrahedron, in coordinates along its edges, and (T, 12) its
    corner and the inverse of its edges. `mesh` is that of scikit-fem; quadratic (T, 10, 3) are the coefficients of the
    solution; pairs (P, 2) are the faces on two periodic sides that are equivalent. [zhang2005].
    """
    corners = mesh.p.T[mesh.t.T]
    edges = np.stack([corners[:, k] - corners[:, 0] for k in (1, 2, 3)], axis=2)
    size, inverse = np.linalg.det(edges), np.linalg.inv(edges)

    def divergence(cubic: Array) -> Array:
        """The divergence times the determinant: that of the field in coordinates along the edges, whose fluxes are the
        same.
        """
        found: Array = np.einsum("aqc,t,tak,tck->tq", slopes(), size, inverse, cubic, optimize=True)
        return found

    cubic = np.zeros((len(corners), len(CUBICS), 3))
    cubic[:, IN_CUBICS] = quadratic
    outflow = divergence(cubic) @ MEAN * np.sign(size)
    cubic += _through_faces(mesh, outflow, pairs)
    inner = np.einsum("scap,tp->tsca", inner_correction(), divergence(cubic), optimize=True)
    scaled = edges / size[:, None, None]
    full = cubic[:, None] + np.einsum("tka,tsca->tsck", scaled, inner, optimize=True)
    return np.ascontiguousarray(full), np.concatenate([corners[:, 0], inverse.reshape(-1, 9)], axis=1)


def _through_faces(mesh: Any, outflow: Array, pairs: Integers) -> Array:
    """The cubics (T, 20, 3) with the smallest fluxes through faces that cancel the net outflow of each tetrahedron."""
    from scipy.sparse import csr_array
    from scipy.sparse.linalg import cg

    one, other = mesh.f2t[0].copy(), mesh.f2t[1].copy()
    same = np.arange(len(one))
    same[pairs[:, 1]] = pairs[:, 0]
    other[pairs[:, 0]] = one[pairs[:, 1]]
    inner = np.flatnonzero((other >= 0) & (same == np.arange(len(one))))
    signs, column = np.repeat([1.0, -1.0], len(inner)), np.tile(np.arange(len(inner)), 2)
    balance = csr_array((signs, (np.concatenate([one[inner], other[inner]]), column)), (len(outflow), len(inner)))
    potential, failed = cg(balance @ balance.T, outflow.mean() - outflow, rtol=1e-12, atol=0.0, maxiter=20_000)
    assert failed == 0  # noqa: S101  # the graph of tetrahedra is connected
    flux = np.zeros(len(one))
    flux[inner] = balance.T @ potential
    # The integral of a bubble over its face is a sixtieth of the area.
    a, b, c = mesh.p.T[mesh.facets]
    normal = np.cross(b - a, c - a)
    away = (a + b + c) / 3.0 - mesh.p.T[mesh.t.T[one]].mean(axis=1)
    normal *= np.sign((normal * away).sum(axis=1))[:, None]
    carried = (120.0 * flux / (normal**2).sum(axis=1))[:, None] * normal
    found = np.zeros((len(outflow), len(CUBICS), 3))
    for faces in mesh.t2f:
        corner = (mesh.t.T[:, :, None] == mesh.facets[:, faces].T[:, None, :]).any(axis=2).argmin(axis=1)
        found += face_bubbles()[corner][:, :, None] * carried[same[faces]][:, None, :]
    return found
