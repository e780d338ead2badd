"""The loop of all sums over neighbors of a tank. A sum is defined by a formula for a pair and the
fields that it reads.

The quantities of each particle that the formula reads are packed into a record of eight or sixteen numbers; a ninth
number, if there are exactly nine, is read from a separate array. Records of a particle's neighbors are turned into
columns (see `ecume._columns`), and the loop over neighbors, which has no store inside, is vectorized by the compiler.
It is compiled for vectors in 2D or 3D, depending on the scene, and for each kernel type of `kernel_loops`. The order of
summation inside a row is not specified, but it is the same in every run. NaN propagates. Rows are padded with the
particle itself, so that each term must vanish at zero distance.

Signs: `apart` is from i to j, F = (1/r) dW/dr is negative, and the gradient of W at i is -F apart.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any, NamedTuple

import numpy as np

from ecume._columns import RECORD, column, fill_columns, further_column
from ecume._jit import prange, spread, summed_inside, summing
from ecume.engine.cells import Integers
from ecume.engine.neighbor_rows import Lists, Slots, whole
from ecume.engine.vectors import Vector, Vector2, Vector3, by_dimension, difference, dot
from ecume.models.sph.fields import FIELD, Constants, Floats
from ecume.models.sph.rates.kernel_loops import KernelType, written_slope

INDEX = np.uint64
"""The type of all indices: a signed index would be tested for being negative, pair by pair."""
CHUNK = 128
"""The number of particles that one thread processes at a time, with one set of columns."""
SPARE = 8
"""Entries between two columns, so that they do not all fall into the same lines of the cache."""
NOTHING = -1
"""The row of a field that a sum does not read."""
FIRST, FURTHER = INDEX(0), INDEX(RECORD)
POSITION, VECTOR, WEIGHT, VALUE = 0, 3, 6, 7
"""Offsets in a record."""


class Reading(NamedTuple):
    """The rows of the table of fields that a sum reads from each particle, in addition to its position."""

    vector: int = NOTHING
    """the first of three rows"""
    weight: int = NOTHING
    value: int = NOTHING
    signed: bool = False
    """whether the weight is negative for dummies"""
    more: tuple[int, ...] = ()
    """one further row, or eight"""


class Particle(NamedTuple):
    """The numbers of a particle that a formula reads."""

    position: Any
    vector: Any
    weight: float
    value: float
    more: Any
    """one number, eight, or ()"""


class NeighborSum(NamedTuple):
    """A sum over neighbors."""

    loop: Callable[..., None]
    rows: Integers
    """of the table of fields, one for each number of a record"""
    ninth: int
    """the row of a number beside the record"""
    signed: bool


def neighbor_sum(
    reading: Reading, given: Callable[..., Any], zero: Callable[..., Any], pair: Callable[..., Any],
    store: Callable[..., None],
) -> NeighborSum:  # fmt: skip
    """Return the sum defined by four compiled functions.

    given(numbers, settings, like) returns the constants that the formula needs; zero(nought, like) is an empty sum,
    with vectors of the type of `like`; pair(total, apart, slope, own, other, given) is the total with the term of a
    neighbor, where slope = f'(q)/q; store(target, fields, i, total, own, given) stores the sum.
    """
    fill, read_own, read = WAYS[len(reading.more)]
    width = RECORD + len(reading.more)

    def loop(
        target: Floats, fields: Floats, records: Floats, ninth: Floats, lists: Lists, constants: Constants,
        kernel: KernelType, like: Vector, settings: tuple[float, ...],
    ) -> None:  # fmt: skip
        counts, start, neighbor = lists
        end = target.shape[1]
        for chunk in prange((end + CHUNK - 1) // CHUNK):
            room = INDEX(SPARE)
            for particle in range(chunk * CHUNK, min(end, (chunk + 1) * CHUNK)):
                room = max(room, whole(counts[particle]) + INDEX(SPARE))
            columns = np.empty((width, room), records.dtype)
            numbers, across = constants[0], records.T
            inverse, known = numbers.inverse_length, given(numbers, settings, like)
            for particle in range(chunk * CHUNK, min(end, (chunk + 1) * CHUNK)):
                i = INDEX(particle)
                count = whole(counts[i])
                fill(columns, records, ninth, neighbor, INDEX(start[i]), count)
                own = read_own(across, ninth, i, like)
                total = zero(numbers.zero, like)
                for k in range(count):
                    other = read(columns, INDEX(k), like)
                    apart = difference(other.position, own.position)
                    slope = written_slope(math.sqrt(dot(apart, apart)) * inverse, kernel)
                    total = pair(total, apart, slope, own, other, known)
                store(target, fields, i, total, own, known)

    loop.__qualname__ = f"neighbor_sum.{pair.__name__}"  # the name identifies compiled code on disk
    return of_rows(NeighborSum(summing(loop), rows_of(reading), 0, reading.signed), reading)


def of_rows(taken: NeighborSum, reading: Reading) -> NeighborSum:
    """The sum with other rows of fields."""
    ninth = reading.more[0] if len(reading.more) == 1 else FIELD.position
    return taken._replace(rows=rows_of(reading), ninth=ninth)


@summed_inside
def fill_one(
    columns: Floats, records: Floats, ninth: Floats, neighbor: Slots, begin: np.uint64, count: np.uint64
) -> None:  # fmt: skip
    """Copy records of eight numbers into columns."""
    fill_columns(columns, records, neighbor, begin, count, FIRST)


@summed_inside
def fill_nine(
    columns: Floats, records: Floats, ninth: Floats, neighbor: Slots, begin: np.uint64, count: np.uint64
) -> None:  # fmt: skip
    """Copy the records of eight numbers, and the ninth number of each neighbor, into columns."""
    fill_columns(columns, records, neighbor, begin, count, FIRST)
    for k in range(count):
        columns[FURTHER, INDEX(k)] = ninth[INDEX(neighbor[begin + INDEX(k)])]


@summed_inside
def fill_both(
    columns: Floats, records: Floats, ninth: Floats, neighbor: Slots, begin: np.uint64, count: np.uint64
) -> None:  # fmt: skip
    """Copy records of sixteen numbers into columns."""
    fill_columns(columns, records, neighbor, begin, count, FIRST)
    fill_columns(columns, records, neighbor, begin, count, FURTHER)


@summed_inside
def _in_plane(columns: Floats, k: np.uint64, more: Any, like: Vector2) -> Particle:
    x, y, _, u, v, _, weight, value = column(columns, k)
    return Particle(Vector2(x, y), Vector2(u, v), weight, value, more)


@summed_inside
def _in_space(columns: Floats, k: np.uint64, more: Any, like: Vector3) -> Particle:
    x, y, z, u, v, w, weight, value = column(columns, k)
    return Particle(Vector3(x, y, z), Vector3(u, v, w), weight, value, more)


_particle = by_dimension(_in_plane, _in_space)


@summed_inside
def one_particle(columns: Floats, k: np.uint64, like: Vector) -> Particle:
    """The neighbor in record k of eight numbers."""
    found: Particle = _particle(columns, k, (), like)
    return found


@summed_inside
def nine_of(columns: Floats, k: np.uint64, like: Vector) -> Particle:
    """The neighbor in record k of eight numbers, with the ninth number from a separate array."""
    found: Particle = _particle(columns, k, columns[FURTHER, k], like)
    return found


@summed_inside
def further_particle(columns: Floats, k: np.uint64, like: Vector) -> Particle:
    """The neighbor in record k of sixteen numbers."""
    found: Particle = _particle(columns, k, further_column(columns, k), like)
    return found


@summed_inside
def own_one(records: Floats, ninth: Floats, i: np.uint64, like: Vector) -> Particle:
    """The particle i itself, from its record of eight numbers."""
    found: Particle = one_particle(records, i, like)
    return found


@summed_inside
def own_nine(records: Floats, ninth: Floats, i: np.uint64, like: Vector) -> Particle:
    """The particle i itself, with the ninth number from a separate array."""
    found: Particle = _particle(records, i, ninth[i], like)
    return found


@summed_inside
def own_further(records: Floats, ninth: Floats, i: np.uint64, like: Vector) -> Particle:
    """The particle i itself, from its record of sixteen numbers."""
    found: Particle = further_particle(records, i, like)
    return found


WAYS: dict[int, tuple[Callable[..., None], Callable[..., Particle], Callable[..., Particle]]] = {
    0: (fill_one, own_one, one_particle),
    1: (fill_nine, own_nine, nine_of),
    RECORD: (fill_both, own_further, further_particle),
}
"""How columns are filled, and how a particle and a neighbor are read, by how many numbers are beside a record."""


def rows_of(reading: Reading) -> Integers:
    """The row of fields for each number of a record."""
    vector = range(reading.vector, reading.vector + 3) if reading.vector != NOTHING else [NOTHING] * 3
    rows = [*range(FIELD.position, FIELD.position + 3), *vector, reading.weight, reading.value]
    return np.array([*rows, *(reading.more if len(reading.more) == RECORD else ())], np.int64)


@spread
def fill_records(fields: Floats, records: Floats, rows: Integers, signed: bool) -> None:
    """Fill the records (N, 8 or 16) of all particles with these rows of their fields."""
    for i in prange(fields.shape[1]):
        for place in range(len(rows)):
            if rows[place] >= 0:
                records[i, place] = fields[rows[place], i]
        if signed and fields[FIELD.liquid, i] <= 0.0:
            records[i, WEIGHT] = -records[i, WEIGHT]
