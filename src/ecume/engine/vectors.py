"""Vectors in 2D and 3D for compiled loops: a formula is written once for both.

Every function dispatches on the type of its last argument. In compiled code the components are in registers, and a 2D
vector has no third component that would take time.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, NamedTuple

from ecume._jit import by_type, summed_inside


class Vector2(NamedTuple):
    """A 2D vector."""

    x: float
    y: float


class Vector3(NamedTuple):
    """A 3D vector."""

    x: float
    y: float
    z: float


class Symmetric2(NamedTuple):
    """A symmetric 2 x 2 matrix."""

    xx: float
    yy: float
    xy: float


class Symmetric3(NamedTuple):
    """A symmetric 3 x 3 matrix."""

    xx: float
    yy: float
    zz: float
    xy: float
    xz: float
    yz: float


Vector = Vector2 | Vector3
Symmetric = Symmetric2 | Symmetric3
VECTORS: dict[int, Vector] = {2: Vector2(0.0, 0.0), 3: Vector3(0.0, 0.0, 0.0)}
"""The zero vector for each number of dimensions; its type selects the vector functions."""


def by_dimension(plane: Callable[..., Any], space: Callable[..., Any]) -> Callable[..., Any]:
    """A function that calls `plane` or `space`, depending on the type of its last argument."""
    chosen = {Vector2: plane, Symmetric2: plane, Vector3: space, Symmetric3: space}
    return by_type(chosen.__getitem__)


@summed_inside
def _dot2(a: Vector2, b: Vector2) -> float:
    return a.x * b.x + a.y * b.y


@summed_inside
def _dot3(a: Vector3, b: Vector3) -> float:
    return a.x * b.x + a.y * b.y + a.z * b.z


dot = by_dimension(_dot2, _dot3)
"""dot(a, b): a.b."""


@summed_inside
def _difference2(a: Vector2, b: Vector2) -> Vector2:
    return Vector2(a.x - b.x, a.y - b.y)


@summed_inside
def _difference3(a: Vector3, b: Vector3) -> Vector3:
    return Vector3(a.x - b.x, a.y - b.y, a.z - b.z)


difference = by_dimension(_difference2, _difference3)
"""difference(a, b): a - b."""


@summed_inside
def _plus2(total: Vector2, factor: float, a: Vector2) -> Vector2:
    return Vector2(total.x + factor * a.x, total.y + factor * a.y)


@summed_inside
def _plus3(total: Vector3, factor: float, a: Vector3) -> Vector3:
    return Vector3(total.x + factor * a.x, total.y + factor * a.y, total.z + factor * a.z)


axpy = by_dimension(_plus2, _plus3)
"""plus(total, factor, a): total + factor a."""


@summed_inside
def _scaled2(factor: float, a: Vector2) -> Vector2:
    return Vector2(factor * a.x, factor * a.y)


@summed_inside
def _scaled3(factor: float, a: Vector3) -> Vector3:
    return Vector3(factor * a.x, factor * a.y, factor * a.z)


scaled = by_dimension(_scaled2, _scaled3)
"""scaled(factor, a): factor a."""


@summed_inside
def _zeros2(zero: float, like: Vector2) -> Vector2:
    return Vector2(zero, zero)


@summed_inside
def _zeros3(zero: float, like: Vector3) -> Vector3:
    return Vector3(zero, zero, zero)


zeros = by_dimension(_zeros2, _zeros3)
"""zeros(zero, like): the zero vector, in the precision of `zero`."""


@summed_inside
def _chosen2(x: float, y: float, z: float, like: Vector2) -> Vector2:
    return Vector2(x, y)


@summed_inside
def _chosen3(x: float, y: float, z: float, like: Vector3) -> Vector3:
    return Vector3(x, y, z)


vector_of = by_dimension(_chosen2, _chosen3)
"""vector_of(x, y, z, like): the vector of the first two or of all three components."""


@summed_inside
def _no_matrix2(zero: float, like: Vector2) -> Symmetric2:
    return Symmetric2(zero, zero, zero)


@summed_inside
def _no_matrix3(zero: float, like: Vector3) -> Symmetric3:
    return Symmetric3(zero, zero, zero, zero, zero, zero)


zero_matrix = by_dimension(_no_matrix2, _no_matrix3)
"""zero_matrix(zero, like): the matrix of zeros for vectors like this one."""


@summed_inside
def _plus_square2(total: Symmetric2, factor: float, a: Vector2) -> Symmetric2:
    x, y = factor * a.x, factor * a.y
    return Symmetric2(total.xx + x * a.x, total.yy + y * a.y, total.xy + x * a.y)


@summed_inside
def _plus_square3(total: Symmetric3, factor: float, a: Vector3) -> Symmetric3:
    x, y, z = factor * a.x, factor * a.y, factor * a.z
    return Symmetric3(
        total.xx + x * a.x, total.yy + y * a.y, total.zz + z * a.z,
        total.xy + x * a.y, total.xz + x * a.z, total.yz + y * a.z,
    )  # fmt: skip


plus_square = by_dimension(_plus_square2, _plus_square3)
"""plus_square(total, factor, a): total + factor a a, a symmetric matrix."""


@summed_inside
def _trace2(matrix: Symmetric2) -> float:
    return matrix.xx + matrix.yy


@summed_inside
def _trace3(matrix: Symmetric3) -> float:
    return matrix.xx + matrix.yy + matrix.zz


trace = by_dimension(_trace2, _trace3)
"""trace(matrix): the sum of the diagonal."""


@summed_inside
def _times2(matrix: Symmetric2, a: Vector2) -> Vector2:
    return Vector2(matrix.xx * a.x + matrix.xy * a.y, matrix.xy * a.x + matrix.yy * a.y)


@summed_inside
def _times3(matrix: Symmetric3, a: Vector3) -> Vector3:
    return Vector3(
        matrix.xx * a.x + matrix.xy * a.y + matrix.xz * a.z,
        matrix.xy * a.x + matrix.yy * a.y + matrix.yz * a.z,
        matrix.xz * a.x + matrix.yz * a.y + matrix.zz * a.z,
    )


times = by_dimension(_times2, _times3)
"""times(matrix, a): the matrix times the vector."""


@summed_inside
def _adjugate2(matrix: Symmetric2) -> tuple[Symmetric2, float]:
    return Symmetric2(matrix.yy, matrix.xx, -matrix.xy), matrix.xx * matrix.yy - matrix.xy * matrix.xy


@summed_inside
def _adjugate3(matrix: Symmetric3) -> tuple[Symmetric3, float]:
    xx, yy, zz, xy, xz, yz = matrix
    first, second, third = yy * zz - yz * yz, xz * yz - xy * zz, xy * yz - xz * yy
    found = Symmetric3(first, xx * zz - xz * xz, xx * yy - xy * xy, second, third, xy * xz - xx * yz)
    return found, xx * first + xy * second + xz * third


adjugate = by_dimension(_adjugate2, _adjugate3)
"""adjugate(matrix): the inverse times the determinant, and the determinant."""


@summed_inside
def _store2(table: Any, row: int, i: Any, factor: float, a: Vector2) -> None:
    table[row, i], table[row + 1, i] = factor * a.x, factor * a.y


@summed_inside
def _store3(table: Any, row: int, i: Any, factor: float, a: Vector3) -> None:
    table[row, i], table[row + 1, i], table[row + 2, i] = factor * a.x, factor * a.y, factor * a.z


store_vector = by_dimension(_store2, _store3)
"""store_vector(table, row, i, factor, a): set column i of the rows from `row` on to factor a; a third row stays."""


@summed_inside
def _add2(table: Any, row: int, i: Any, factor: float, a: Vector2) -> None:
    table[row, i] += factor * a.x
    table[row + 1, i] += factor * a.y


@summed_inside
def _add3(table: Any, row: int, i: Any, factor: float, a: Vector3) -> None:
    table[row, i] += factor * a.x
    table[row + 1, i] += factor * a.y
    table[row + 2, i] += factor * a.z


add_vector = by_dimension(_add2, _add3)
"""add_vector(table, row, i, factor, a): add factor a to column i of the rows from `row` on."""
