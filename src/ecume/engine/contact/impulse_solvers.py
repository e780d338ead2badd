"""Solvers for the impulses of all contacts of a step: projected Gauss-Seidel sweeps by islands, and an exact active-set
method.

`solve` is the place to start. In Moreau's and Jean's time stepping the unknowns are the impulses p >= 0 of a
step, complementary to the conditions n.(w_j - w_i) >= bound. `w` is the velocity with which particles move during the
step, so that with bound = -gap/dt no two overlap afterwards: contacts act before they close. The linear complementarity
problem is solved by projected Gauss-Seidel sweeps, accelerated by the nonsmooth conjugate gradients of
Silcowitz-Hansen, Niebe & Erleben (2010), until the residual is below the goal, however many sweeps that takes: with a
fixed number of sweeps large rafts would slowly overlap.

Contacts that are connected by movable bodies form an island. Each island is solved separately with as many sweeps as it
needs, and islands without impulses are skipped. Otherwise the pairs that most islands consist of would be iterated
until the largest island converges.

`solve_by_active_set` is exact, for the few islands on which sweeps do not converge. A raft that is braced by more
contacts than it has degrees of freedom has self-stresses, along which impulses can change without changing any
velocity. Sweeps then creep along one of them by the thousand, until a contact opens. The velocities are nevertheless
unique: they are the nearest to the given ones, in the norm of kinetic energy, that break no condition. This is least
distance programming, which becomes nonnegative least squares [lawson1974, chapter 23]: minimize |E u - f| over u >= 0,
with the contacts' directions and bounds as the columns of E. The method is direct, and its cost grows with the cube of
the number of contacts: see LARGEST.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from ecume._jit import compiled, compiled_apart, compiled_inside
from ecume.engine.cells import Integers
from ecume.engine.contact.contacts import Contacts, apply_impulses
from ecume.units import Array

MOST_SWEEPS = 20_000
PATIENCE = 128
"""Sweeps after which the residual should have halved."""
CONVERGED = 1e-7
"""The target residual, as a fraction of the largest approach velocity."""
SWEEPS_BEFORE_ACTIVE_SET = 4_000
"""Sweeps after which a small island is solved by the active-set method."""
LEAST_FOR_ISLANDS = 64
"""Fewer contacts are treated as one island."""


Choice = NDArray[np.bool_]
Span = tuple[int, int]
"""A range of contacts."""
ContactBodies = tuple[Integers, Integers, Array]
"""first, second, normal"""
Impulses = tuple[Array, Array, Array, Array, Array, Array]
"""impulse, bound, weight, change, direction, scratch"""
Motion = tuple[Array, Array]
"""velocity, mobility"""


@compiled_inside
def bodies_of(contacts: Contacts) -> ContactBodies:
    """The bodies and normals of contacts, as a tuple for the loops."""
    return contacts.first, contacts.second, contacts.normal


@compiled_inside
def impulses_of(contacts: Contacts) -> Impulses:
    """The impulses and their conditions, as a tuple for the loops."""
    c = contacts
    return c.impulse, c.bound, c.weight, c.change, c.direction, c.scratch


class Islands(NamedTuple):
    """Contacts by island, ascending in each; only islands with an impulse, or a change in the last sweep."""

    rows: Integers
    """(n,)"""
    first: Integers
    """(islands + 1,) offsets into `rows`"""


# In the loops below every array has a local name, and none is passed to a function that is not inlined: see
# `ecume.engine.contact.contacts`.


@compiled
def islands_of(contacts: Contacts, mobility: Array) -> Islands:
    """Connected components of the contact graph, in the order of their lowest bodies."""
    total, impulse, change = contacts.total[0], contacts.impulse, contacts.change
    busy = np.empty(total, np.bool_)
    for row in range(total):
        busy[row] = impulse[row] != 0.0 or change[row] != 0.0
    return islands_among(contacts.first, contacts.second, busy, mobility)


@compiled
def islands_among(first_body: Integers, second_body: Integers, busy: Choice, mobility: Array) -> Islands:
    """The islands of the first len(busy) contacts that contain at least one busy contact; fixed bodies do not connect
    contacts.
    """
    total = len(busy)
    island = _island_of_each(first_body[:total], second_body[:total], mobility)
    active, ends = np.zeros(len(mobility), np.bool_), np.zeros(len(mobility) + 1, np.int64)
    for row in range(total):
        if busy[row]:
            active[island[row]] = True
    for row in range(total):
        ends[island[row] + 1] += 1 if active[island[row]] else 0
    first, islands = np.zeros(len(mobility) + 1, np.int64), 0
    for name in range(len(mobility)):
        if ends[name + 1] > 0:
            islands += 1
            first[islands] = first[islands - 1] + ends[name + 1]
        ends[name + 1] += ends[name]
    rows = np.empty(first[islands], np.int64)
    for row in range(total):
        name = island[row]
        if active[name]:
            rows[ends[name]] = row
            ends[name] += 1
    return Islands(rows, first[: islands + 1])


@compiled
def _island_of_each(first: Integers, second: Integers, mobility: Array) -> Integers:
    """The island of each contact, named by its lowest body: union-find with path halving."""
    parent = np.arange(len(mobility))
    for row in range(len(first)):
        i, j = first[row], second[row]
        if mobility[i] > 0.0 and mobility[j] > 0.0:
            while parent[i] != i:
                parent[i] = parent[parent[i]]
                i = parent[i]
            while parent[j] != j:
                parent[j] = parent[parent[j]]
                j = parent[j]
            parent[max(i, j)] = min(i, j)
    # A parent is never higher than its child.
    for i in range(len(mobility)):
        parent[i] = parent[parent[i]]
    island = np.empty(len(first), np.int64)
    for row in range(len(first)):
        island[row] = parent[first[row]] if mobility[first[row]] > 0.0 else parent[second[row]]
    return island


@compiled
def contacts_of_rows(contacts: Contacts, rows: Integers) -> Contacts:
    """A contiguous copy of some contacts."""
    count = len(rows)
    first, second, normal = np.empty(count, np.int64), np.empty(count, np.int64), np.empty((count, 2))
    gap, bound, weight, impulse, change = (
        np.empty(count),
        np.empty(count),
        np.empty(count),
        np.empty(count),
        np.empty(count),
    )
    for place in range(count):
        row = rows[place]
        first[place], second[place] = contacts.first[row], contacts.second[row]
        normal[place, 0], normal[place, 1] = contacts.normal[row, 0], contacts.normal[row, 1]
        gap[place], bound[place], weight[place] = contacts.gap[row], contacts.bound[row], contacts.weight[row]
        impulse[place], change[place] = contacts.impulse[row], contacts.change[row]
    total = np.empty(1, np.int64)
    total[0] = count
    return Contacts(total, first, second, normal, gap, bound, weight, impulse, change, np.zeros(count), np.zeros(count))


@compiled_inside
def _sweep(span: Span, bodies: ContactBodies, unknowns: Impulses, motion: Motion) -> float:
    """Perform one projected Gauss-Seidel sweep over a range. Returns the largest change, as a relative velocity."""
    first, second, normal = bodies
    impulse, bound, weight, change, _, _ = unknowns
    velocity, mobility = motion
    largest = 0.0
    for row in range(np.uint64(span[0]), np.uint64(span[1])):
        i, j = np.uint64(first[row]), np.uint64(second[row])
        x, y = normal[row, 0], normal[row, 1]
        speed = x * (velocity[j, 0] - velocity[i, 0]) + y * (velocity[j, 1] - velocity[i, 1])
        new = max(impulse[row] + weight[row] * (bound[row] - speed), 0.0)
        step = new - impulse[row]
        impulse[row], change[row] = new, step
        on_i, on_j = mobility[i] * step, mobility[j] * step
        velocity[i, 0] -= on_i * x
        velocity[i, 1] -= on_i * y
        velocity[j, 0] += on_j * x
        velocity[j, 1] += on_j * y
        largest = max(largest, abs(on_i) + abs(on_j))
    return largest


@compiled_inside
def _residual(span: Span, bodies: ContactBodies, unknowns: Impulses, velocity: Array) -> float:
    """The largest violation of the complementarity conditions in a range (m/s)."""
    first, second, normal = bodies
    impulse, bound, weight, _, _, _ = unknowns
    worst = 0.0
    for row in range(np.uint64(span[0]), np.uint64(span[1])):
        i, j = np.uint64(first[row]), np.uint64(second[row])
        along_x = normal[row, 0] * (velocity[j, 0] - velocity[i, 0])
        excess = along_x + normal[row, 1] * (velocity[j, 1] - velocity[i, 1]) - bound[row]
        if weight[row] > 0.0:
            worst = max(worst, -excess, min(excess, impulse[row] / weight[row]))
    return worst


@compiled_inside
def _accelerate(span: Span, bodies: ContactBodies, unknowns: Impulses, motion: Motion, ratio: float) -> None:
    """Step along the conjugate direction: p = max(p + ratio d, 0), then d = ratio d + the change of the last sweep."""
    first, second, normal = bodies
    impulse, _, _, change, direction, step = unknowns
    velocity, mobility = motion
    for row in range(np.uint64(span[0]), np.uint64(span[1])):
        along, old = ratio * direction[row], impulse[row]
        impulse[row] = max(old + along, 0.0)
        step[row] = impulse[row] - old
        direction[row] = along + change[row]
    if ratio > 0.0:
        for row in range(np.uint64(span[0]), np.uint64(span[1])):
            i, j = np.uint64(first[row]), np.uint64(second[row])
            on_i, on_j = mobility[i] * step[row], mobility[j] * step[row]
            velocity[i, 0] -= on_i * normal[row, 0]
            velocity[i, 1] -= on_i * normal[row, 1]
            velocity[j, 0] += on_j * normal[row, 0]
            velocity[j, 1] += on_j * normal[row, 1]


@compiled
def residual(contacts: Contacts, velocity: Array) -> float:
    """The largest violation of the complementarity conditions (m/s): penetration, or impulse on separating bodies."""
    return _residual((0, contacts.total[0]), bodies_of(contacts), impulses_of(contacts), velocity)


class Tolerance(NamedTuple):
    """Convergence criteria, as residuals (m/s)."""

    target: float
    acceptable: float
    """accepted if the residual no longer decreases"""


@compiled
def solve(contacts: Contacts, velocity: Array, mobility: Array, tolerance: Tolerance) -> int:
    """Solve for the impulses and change `velocity` by them, until the residual is below the goal.

    The initial guess is `contacts.impulse`. Returns the largest number of sweeps of an island, MOST_SWEEPS + 1 without
    convergence.
    """
    if begin(contacts, velocity, mobility, tolerance):
        return 1
    if contacts.total[0] < LEAST_FOR_ISLANDS:
        return solve_islands(contacts, np.array([0, contacts.total[0]]), velocity, mobility, tolerance)
    islands = islands_of(contacts, mobility)
    some = contacts_of_rows(contacts, islands.rows)
    sweeps = solve_islands(some, islands.first, velocity, mobility, tolerance)
    scatter_impulses(contacts, islands.rows, some)
    return sweeps


@compiled
def begin(contacts: Contacts, velocity: Array, mobility: Array, tolerance: Tolerance) -> bool:
    """Do the first sweep; return whether it converged."""
    span, bodies, unknowns = (0, contacts.total[0]), bodies_of(contacts), impulses_of(contacts)
    apply_impulses(contacts, contacts.impulse, velocity, mobility)
    largest = _sweep(span, bodies, unknowns, (velocity, mobility))
    return bool(largest <= tolerance.target and _residual(span, bodies, unknowns, velocity) <= tolerance.target)


@compiled
def solve_islands(contacts: Contacts, first: Integers, velocity: Array, mobility: Array, tolerance: Tolerance) -> int:
    """Do all further sweeps of each island; return the largest number of sweeps of one."""
    bodies, unknowns, most = bodies_of(contacts), impulses_of(contacts), 1
    for island in range(len(first) - 1):
        span = first[island], first[island + 1]
        if not _residual(span, bodies, unknowns, velocity) <= tolerance.target:
            small = span[1] - span[0] <= LARGEST
            sweeps = _iterate(
                span,
                bodies,
                unknowns,
                (velocity, mobility),
                tolerance,
                SWEEPS_BEFORE_ACTIVE_SET if small else MOST_SWEEPS,
            )
            if (
                small
                and sweeps > SWEEPS_BEFORE_ACTIVE_SET
                and not solve_by_active_set(contacts, span, velocity, mobility, tolerance)
            ):
                sweeps = _iterate(span, bodies, unknowns, (velocity, mobility), tolerance, MOST_SWEEPS)
            most = max(most, sweeps)
    return most


@compiled
def solve_by_active_set(contacts: Contacts, span: Span, velocity: Array, mobility: Array, tolerance: Tolerance) -> bool:
    """Solve an island by the active-set method; return whether the result is accepted. Nothing changes otherwise."""
    rows = _solvable(contacts, span)
    some = contacts_of_rows(contacts, rows)
    slower = velocity.copy()
    if not nearest_velocity(some.first, some.second, some.normal, some.bound, some.impulse, velocity, mobility):
        return False
    before = contacts_of_rows(contacts, rows)
    scatter_impulses(contacts, rows, some)
    left = _residual(span, bodies_of(contacts), impulses_of(contacts), velocity)
    if left <= max(tolerance.target, tolerance.acceptable):
        return True
    scatter_impulses(contacts, rows, before)
    for body in range(len(velocity)):
        velocity[body, 0], velocity[body, 1] = slower[body, 0], slower[body, 1]
    return False


@compiled
def _solvable(contacts: Contacts, span: Span) -> Integers:
    """The rows of an island that can have an impulse."""
    rows, found = np.empty(span[1] - span[0], np.int64), 0
    for row in range(span[0], span[1]):
        if contacts.bound[row] > -np.inf and contacts.weight[row] > 0.0:
            rows[found] = row
            found += 1
    return rows[:found]


@compiled_inside
def _iterate(
    span: Span, bodies: ContactBodies, unknowns: Impulses, motion: Motion, tolerance: Tolerance, most: int
) -> int:
    """Do the sweeps of an island after the first; return the number of all, `most` + 1 without convergence."""
    velocity, change, direction = motion[0], unknowns[3], unknowns[4]
    for row in range(span[0], span[1]):
        direction[row] = 0.0
    square_before, residual_before = 0.0, np.inf
    for sweep in range(2, most + 1):
        square = 0.0
        for row in range(span[0], span[1]):
            square += change[row] ** 2
        # A growing gradient means that the active set changed: restart the conjugate directions.
        ratio = square / square_before if 0.0 < square <= square_before else 0.0
        _accelerate(span, bodies, unknowns, motion, ratio)
        square_before = square
        largest = _sweep(span, bodies, unknowns, motion)
        if largest <= tolerance.target and _residual(span, bodies, unknowns, velocity) <= tolerance.target:
            return sweep
        if sweep % PATIENCE == 0:
            # In an overconstrained raft, rounding of the gaps lets impulses drift without end along self-stresses,
            # which change no velocity.
            left = _residual(span, bodies, unknowns, velocity)
            if left <= tolerance.acceptable and left > 0.5 * residual_before:
                return sweep
            residual_before = left
    return most + 1


@compiled
def scatter_impulses(contacts: Contacts, rows: Integers, some: Contacts) -> None:
    """Copy the impulses of `some` back to their rows."""
    impulse, solved = contacts.impulse, some.impulse
    for place in range(len(rows)):
        impulse[rows[place]] = solved[place]


LARGEST = 128
"""The largest number of contacts of an island for the active-set method, which takes about a tenth of a second for it;
larger islands are left to sweeps.
"""
DEPENDENT = 1e-10
"""The norm of a column's component orthogonal to the others, over its own norm, below which it counts as dependent."""
OPTIMAL = 1e-13
"""The largest gradient that still counts as zero, where the longest columns are about one."""
FEASIBLE = 1e-12
"""The last component of the residual below which no velocity fulfills all conditions."""


@compiled_apart("int64[:]", "int64[:]", "float64[:,:]", "float64[:]", "float64[:]", "float64[:,:]", "float64[:]")
def nearest_velocity(
    first: Integers, second: Integers, normal: Array, bound: Array, impulse: Array, velocity: Array, mobility: Array
) -> bool:
    """Solve contacts exactly, starting from impulses that are already included in `velocity`; change both. Return
    False, without a change, if no solution was found.
    """
    pair = first, second, normal
    place, bodies = numbered(first, second, len(mobility))
    matrix, strength = _columns(pair, place, bodies, mobility)
    free = velocity.copy()
    _push(pair, impulse, -1.0, free, mobility)
    if not least_distance(matrix, strength, _needs(pair, bound, free), impulse):
        return False
    for body in range(len(velocity)):
        velocity[body, 0], velocity[body, 1] = free[body, 0], free[body, 1]
    _push(pair, impulse, 1.0, velocity, mobility)
    return True


@compiled
def least_distance(matrix: Array, strength: float, need: Array, impulse: Array) -> bool:
    """Solve for the impulses of the least change of the velocities, in the norm of kinetic energy, that closes the
    `need` of each contact (m/s). The columns of `matrix` are the responses to unit impulses in this norm over
    `strength`, its last row is empty; `impulse` is the initial guess. False, without a change, without a solution.
    """
    scale = 0.0
    for k in range(len(need)):
        scale = max(scale, abs(need[k]) if need[k] == need[k] else np.inf)
    if not strength > 0.0 or not 0.0 < scale < np.inf:
        return False
    right, guess = np.zeros(len(matrix)), np.empty(len(need), np.bool_)
    right[len(right) - 1] = 1.0
    for k in range(len(need)):
        matrix[len(matrix) - 1, k] = need[k] / scale
        guess[k] = impulse[k] > 0.0
    solution, found = nonnegative_least_squares(matrix, right, guess)
    explained = 0.0
    for k in range(len(need)):
        explained += matrix[len(matrix) - 1, k] * solution[k]
    rest = 1.0 - explained
    if not found or not rest > FEASIBLE:
        return False
    for k in range(len(need)):
        impulse[k] = solution[k] * (scale / (rest * strength * strength))
    return True


@compiled
def numbered(first: Integers, second: Integers, count: int) -> tuple[Integers, int]:
    """The new index of each body that takes part, in ascending order, and the number of these bodies."""
    place, bodies = np.zeros(count, np.int64), 0
    for k in range(len(first)):
        place[first[k]] = place[second[k]] = 1
    for body in range(count):
        if place[body] > 0:
            place[body] = bodies
            bodies += 1
    return place, bodies


@compiled
def _columns(
    pair: tuple[Integers, Integers, Array], place: Integers, bodies: int, mobility: Array
) -> tuple[Array, float]:
    """The responses to unit impulses in the norm of kinetic energy, divided by the largest of their lengths, and that
    length; zero if no body moves. The last row remains empty.
    """
    first, second, normal = pair
    matrix, longest = np.zeros((2 * bodies + 1, len(normal))), 0.0
    for k in range(len(normal)):
        longest = max(longest, mobility[first[k]] + mobility[second[k]])
    strength = np.sqrt(longest)
    if not strength > 0.0:
        return matrix, 0.0
    for k in range(len(normal)):
        i, j = first[k], second[k]
        for axis in range(2):
            matrix[2 * place[i] + axis, k] = -np.sqrt(mobility[i]) * normal[k, axis] / strength
            matrix[2 * place[j] + axis, k] = np.sqrt(mobility[j]) * normal[k, axis] / strength
    return matrix, strength


@compiled
def _push(
    pair: tuple[Integers, Integers, Array], impulse: Array, sign: float, velocity: Array, mobility: Array
) -> None:
    first, second, normal = pair
    for k in range(len(first)):
        i, j = first[k], second[k]
        for axis in range(2):
            velocity[i, axis] -= mobility[i] * (sign * impulse[k]) * normal[k, axis]
            velocity[j, axis] += mobility[j] * (sign * impulse[k]) * normal[k, axis]


@compiled
def _needs(pair: tuple[Integers, Integers, Array], bound: Array, velocity: Array) -> Array:
    """The difference between the bound and the normal velocity of each contact (m/s)."""
    first, second, normal = pair
    need = np.empty(len(first))
    for k in range(len(first)):
        i, j = first[k], second[k]
        along_x = normal[k, 0] * (velocity[j, 0] - velocity[i, 0])
        need[k] = bound[k] - along_x - normal[k, 1] * (velocity[j, 1] - velocity[i, 1])
    return need


@compiled
def nonnegative_least_squares(matrix: Array, right: Array, guess: Choice) -> tuple[Array, bool]:
    """The u >= 0 that minimizes |matrix u - right|, and whether it was found. `guess` flags the components that may
    initially be positive. Algorithm NNLS of [lawson1974], with modified Gram-Schmidt for least squares.
    """
    count = matrix.shape[1]
    solution, passive, barred = np.zeros(count), np.empty(count, np.bool_), np.zeros(count, np.bool_)
    for k in range(count):
        passive[k] = guess[k]
        solution[k] = 1.0 if passive[k] else 0.0
    settled = _settle(matrix, right, solution, passive)
    for _ in range(10 * count):
        if not settled:
            return solution, False
        rest = _rest(matrix, right, solution)
        entering, steepest = -1, OPTIMAL
        for k in range(count):
            gradient = 0.0
            for row in range(len(rest)):
                gradient += matrix[row, k] * rest[row]
            if not passive[k] and not barred[k] and gradient > steepest:
                entering, steepest = k, gradient
        if entering < 0:
            return solution, True
        passive[entering] = True
        settled = _settle(matrix, right, solution, passive)
        # A column that leaves at once is dependent to rounding: it would enter and leave endlessly.
        barred[entering] = not passive[entering]
        if not barred[entering]:
            for k in range(count):
                barred[k] = False
    return solution, False


@compiled
def _rest(matrix: Array, right: Array, solution: Array) -> Array:
    """The residual right - matrix solution."""
    total = np.zeros(len(matrix))
    for k in range(len(solution)):
        if solution[k] != 0.0:
            for row in range(len(matrix)):
                total[row] += matrix[row, k] * solution[k]
    for row in range(len(matrix)):
        total[row] = right[row] - total[row]
    return total


@compiled
def _settle(matrix: Array, right: Array, solution: Array, passive: Choice) -> bool:
    """Solve least squares for the passive components; components that would become negative leave
    the set, one by one.
    """
    for _ in range(2 * len(solution) + 2):
        target = _least_squares(matrix, right, passive)
        share = 1.0
        for k in range(len(solution)):
            if passive[k] and target[k] <= 0.0:
                share = min(share, solution[k] / (solution[k] - target[k]) if solution[k] > 0.0 else 0.0)
        stays = True
        for k in range(len(solution)):
            blocks = passive[k] and target[k] <= 0.0
            solution[k] += share * (target[k] - solution[k])
            if not passive[k] or (blocks and solution[k] <= 1e-14 * abs(target[k])):
                stays = stays and not passive[k]
                solution[k], passive[k] = 0.0, False
        if share == 1.0 and stays:
            return True
    return False


@compiled
def _least_squares(matrix: Array, right: Array, passive: Choice) -> Array:
    """The least squares solution of the passive components by modified Gram-Schmidt; dependent columns leave the
    passive set.
    """
    rows, columns = matrix.shape
    basis, upper, column = np.empty((columns, rows)), np.zeros((columns, columns)), np.empty(rows)
    who, kept = np.empty(columns, np.int64), 0
    for k in range(columns):
        if not passive[k]:
            continue
        for row in range(rows):
            column[row] = matrix[row, k]
        length = _length(column)
        for _ in range(2):  # two orthogonalizations suffice
            for other in range(kept):
                along = 0.0
                for row in range(rows):
                    along += basis[other, row] * column[row]
                upper[other, kept] += along
                for row in range(rows):
                    column[row] -= along * basis[other, row]
        left = _length(column)
        if left <= DEPENDENT * length:
            for other in range(kept):
                upper[other, kept] = 0.0
            passive[k] = False
            continue
        for row in range(rows):
            basis[kept, row] = column[row] / left
        upper[kept, kept], who[kept] = left, k
        kept += 1
    solution, shares = np.zeros(columns), np.zeros(kept)
    for row in range(rows):
        column[row] = right[row]
    for place in range(kept):
        for row in range(rows):
            shares[place] += basis[place, row] * column[row]
        for row in range(rows):
            column[row] -= shares[place] * basis[place, row]
    for place in range(kept - 1, -1, -1):
        value = shares[place]
        for other in range(place + 1, kept):
            value -= upper[place, other] * solution[who[other]]
        solution[who[place]] = value / upper[place, place]
    return solution


@compiled_inside
def _length(column: Array) -> float:
    square = 0.0
    for row in range(len(column)):
        square += column[row] * column[row]
    return float(np.sqrt(square))
