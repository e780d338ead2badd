"""The pressure of an incompressible liquid in a step: the equation for it, its solver, and its effect on velocities.

**The condition** (`project`). The pressure conserves the density of each particle. With the excess s_i of the density
over that at rest, and the compression c_i(v) by the flow, liquid with a free surface has

    p_i >= 0,   s'_i + time c_i(v) <= 0,   p_i (s'_i + time c_i(v)) = 0,
    s' = max(s, 0)/10 + min(s, 0) + time^2 [tr(G G) - (tr G)^2]/2 :

it resists compression, and not separation [gerszewski2013]. s_i counts the missing neighbors above a flat surface as
liquid, see `missing_density`; a single drop may approach others until its density is that at rest. The last term, with
the gradient G of the velocity, is the compression of second order by motion on straight lines within the step. For
liquid that fills its tank the equation has no bounds, and a tenth of s_i. Its pressure is determined up to a constant,
which is chosen so that the lowest pressure at walls is zero, and the lowest of particles the weight of half a spacing.
With a mean of zero the upper half of still water would be in tension, in which particles clump. A pressure that is
positive everywhere pushes them apart, since in a disordered neighborhood a constant pressure does not cancel exactly.

**The matrix** (`System`), A p = b, is never stored: two sums over neighbors multiply with it. Signs are those of
`rates.sums`: displacements are from i to j, F = (1/r) dW/dr is negative, and g_ij = F x_ij is the gradient of the
kernel at j. Volumes V are constant. With T_i = sum_j V_j g_ij, where dummies count twice,

    acceleration   a_i = [p_i T_i + sum_j V_j p_j g_ij] / rho
    compression    c_i = sum_j V_j g_ij.v_j - T_i.v_i = -div v
    compact        l_i = (2/rho) [D_i p_i + sum_j V_j p_j F_ij].

The sums over j are over liquid and its images. At a dummy, pressure and velocity are those of the particle itself,
mirrored at the wall. With the weights V_i the compression is the adjoint of the acceleration, with opposite sign, so
that -c(a(p)) is symmetric and not negative: its projection is exact [ihmsen2014]. It does not resist pressures that
alternate from particle to particle, which would grow without bound. l(p) is the Laplacian of [cummins1999]: it resists
these most, but does not remove the divergence completely. The matrix A is the mean of both, time^2 [-c(a(p)) + l(p)]/2.
D_i = -sum_j V_j F_ij; at a free surface, D_i is the value of a full lattice: missing neighbors represent air with a
pressure of zero [nair2014].

Behind walls the pressure continues hydrostatically under gravity G. This part of the pressures of images and dummies is
known, and so are its acceleration r and its Laplacian m. At rest div(r + a(p)) = -div G between mirrors, while m + l(p)
= 0: therefore the two have separate sources, see `known_compression`. A dummy next to liquid with the acceleration u
continues the pressure by rho (G - u).x_iw, see `flights`. With u = 0 dummies supported half of the weight of a jet next
to them, which rose twice as high.

**The solver** (`solve`) is MPRGP, modified proportioning with reduced gradient projections [dostal2005], for A x >= b,
x >= 0, (A x - b) x = 0: conjugate gradients among the x that are positive, a projected step of fixed length where one
reaches zero, and a release of those at zero whose constraint is violated most. The number of iterations grows like that
of conjugate gradients, with the square root of the condition number. Without bounds it is the method of conjugate
gradients.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import NamedTuple

import numpy as np

from ecume._jit import admit, prange, summing
from ecume._portable import dot
from ecume.engine.cells import Integers
from ecume.engine.neighbor_rows import Lists, whole
from ecume.engine.shapes import Flags
from ecume.laws import incompressible
from ecume.laws.incompressible import correction, density_excess, free_correction, straight_motion_excess
from ecume.models.sph.boundaries.forces_on_solids import chains_of, roots_of
from ecume.models.sph.boundaries.rigid_bodies import with_moved_solids
from ecume.models.sph.fields import FIELD, Constants, Floats
from ecume.models.sph.parameters import Parameters, Projection
from ecume.models.sph.rates.kernel_loops import KernelType, kernel_type, value_of, written_slope
from ecume.models.sph.rates.neighbor_sums import INDEX
from ecume.models.sph.rates.right_hand_side import fill
from ecume.models.sph.report.energy_budget import forces_work, power_of_forces
from ecume.models.sph.state import ITERATIONS, MOST_ITERATIONS, RATE, RESIDUAL, WORK, WORST, State, Workspace
from ecume.units import Array

admit(incompressible)

PROPORTION = 1.0
"""Gamma: how large the gradients at zero may be, relative to the others, before they are released."""


class Problem(NamedTuple):
    """A linear problem with bounds, in scaled unknowns."""

    apply: Callable[[Array], Array]
    """the product A x"""
    right: Array
    """b"""
    bounded: bool
    """whether x >= 0"""
    step: float
    """the length of projected steps: up to twice the inverse of the largest eigenvalue"""
    error: Callable[[Array], float]
    """the error of a projected gradient, compared with the tolerance"""


class Solution(NamedTuple):
    """The result of the solver."""

    x: Array
    gradient: Array
    """the projected gradient, zero at the solution"""
    error: float
    iterations: int


def solve(problem: Problem, guess: Array, tolerance: float, most: int) -> Solution:
    """The solution within the tolerance, or the last iterate after `most` products with A."""
    x = np.maximum(guess, 0.0) if problem.bounded else guess.copy()
    gradient = problem.apply(x) - problem.right
    free, chopped = _split(problem, x, gradient)
    direction, count = free.copy(), 1
    error = problem.error(free + chopped)
    while error > tolerance and count < most:
        reduced = np.minimum(x / problem.step, free) if problem.bounded else free
        if dot(chopped, chopped) <= PROPORTION**2 * dot(reduced, free):
            ahead = problem.apply(direction)
            curvature = dot(direction, ahead)
            if curvature <= 0.0:  # only rounding errors remain along this direction
                break
            length = dot(gradient, direction) / curvature
            farthest = _farthest(x, direction) if problem.bounded else np.inf
            if length <= farthest:
                x = x - length * direction
                gradient = gradient - length * ahead
                free, chopped = _split(problem, x, gradient)
                direction = free - dot(free, ahead) / curvature * direction
            else:
                x = x - farthest * direction
                gradient = gradient - farthest * ahead
                free, _ = _split(problem, x, gradient)
                x = np.maximum(x - problem.step * free, 0.0)
                gradient = problem.apply(x) - problem.right
                free, chopped = _split(problem, x, gradient)
                direction, count = free.copy(), count + 1
        else:
            ahead = problem.apply(chopped)
            curvature = dot(chopped, ahead)
            if curvature <= 0.0:
                break
            length = dot(gradient, chopped) / curvature
            x = x - length * chopped
            gradient = gradient - length * ahead
            free, chopped = _split(problem, x, gradient)
            direction = free.copy()
        count += 1
        error = problem.error(free + chopped)
    return Solution(x, free + chopped, error, count)


def _split(problem: Problem, x: Array, gradient: Array) -> tuple[Array, Array]:
    """The gradient with respect to the positive x, and the part of the gradient of the zero x that would increase
    them.
    """
    if not problem.bounded:
        return gradient, np.zeros_like(gradient)
    inside = x > 0.0
    return np.where(inside, gradient, 0.0), np.where(inside, 0.0, np.minimum(gradient, 0.0))


def _farthest(x: Array, direction: Array) -> float:
    """The longest step against the direction for which all x remain positive or zero."""
    falling = direction > 0.0
    return float((x[falling] / direction[falling]).min(initial=np.inf))


class System(NamedTuple):
    """The equation of one step; N particles of liquid, and columns for dummies and images as well."""

    gradient: Array
    """(d + 1, N, room) 1/m^(d+1): g_ij, and F_ij in 1/m^(d+2)"""
    closing: Array
    """(d, N) 1/m: T_i"""
    compact: Array
    """(N,) 1/m^2: D_i"""
    summed: Array
    """(N,) sum of V_j W_ij, itself included"""
    steepness: Array
    """(N,) 1/m: |sum of V_j g_ij|, dummies included like liquid"""
    resting: Array
    """(d, N) m/s^2: the acceleration r by the pressures of images where that of the liquid is zero"""
    lifting: Array
    """(d, N) m/s^2: the same by dummies, before liquid at rest"""
    behind: Array
    """(d, d, N): B, by which it changes with the acceleration of the liquid, r - B u"""
    held: Array
    """(N,) 1/s^2: the Laplacian l of these pressures"""
    diagonal: Array
    """(N,) 1/Pa: of A"""
    volume: Array
    """(N,)"""
    weight: Array
    """(columns,) volumes of liquid and images, zero for dummies"""
    root: Integers
    """(columns,) the particle of the liquid of which each column is an image, or which it is; 0 for dummies"""
    sign: Array
    """(d, columns) -1 for components whose sign mirrors change, 0 for dummies"""
    lists: Lists
    density: float
    time: float


def assemble(now: Parameters, settings: Projection, workspace: Workspace, time: float) -> System:
    """The equation at the present positions, from fields filled with zero pressures."""
    lists, table = workspace.lists, workspace.fields.table
    d, count = now.dimension, workspace.rates.shape[1]
    gradient, (closing, resting, lifting) = np.empty((d + 1, int(lists.start[count]))), np.empty((3, d, count))
    behind = np.empty((d, d, count))
    compact, held, diagonal, summed, slant = np.empty((5, count))
    pull = np.concatenate([now.gravity, now.pull_center - now.origin, [now.pull_rate]])
    sum_gradients(
        closing, table, lists, now.constants, kernel_type(now.constants), pull,
        (now.material.density, time, settings.full if settings.free_surface else 0.0),
        gradient, resting, lifting, behind, slant, compact, summed, held, diagonal,
    )  # fmt: skip
    root, sign = mirrored(now, workspace)
    liquid = root < count
    root = np.where(liquid, root, 0)
    volume = workspace.fields.volume[:count].astype(np.float64)
    return System(
        gradient, closing, compact, summed, slant, resting, lifting, behind, held, diagonal, volume,
        volume[root] * liquid, root, sign * liquid, lists, now.material.density, time,
    )  # fmt: skip


def mirrored(now: Parameters, workspace: Workspace) -> tuple[Integers, Array]:
    """The original particle of each image, and the signs of its vector components."""
    images, real, d = workspace.images, len(workspace.lists.counts), now.dimension
    root = np.concatenate([np.arange(real), roots_of(images, real)])
    sign, chains, sides = np.ones((d, len(root))), chains_of(images, real), now.boundary.sides
    for side in np.flatnonzero(sides.mirrors):
        turned = real + np.flatnonzero(chains >> side & 1)
        sign[:, turned] *= (1.0 - 2.0 * np.abs(sides.normal[side]))[:, None]
    return root, sign


@summing
def sum_gradients(
    closing: Array, fields: Floats, lists: Lists, constants: Constants, kernel: KernelType, pull: Array,
    numbers: tuple[float, float, float], gradient: Array, resting: Array, lifting: Array, moved: Array, slant: Array,
    compact: Array, summed: Array, held: Array, diagonal: Array,
) -> None:  # fmt: skip
    """Fill the arrays of the equation: g_ij and F_ij, T_i, D_i, the sums of kernels, the accelerations at zero
    pressure, and the diagonal of A. `pull` contains gravity, then the center and the rate of the central force;
    `numbers` contains the density, the time, and the smallest D, dummies included.
    """
    code, dimension = constants[0].kernel, INDEX(closing.shape[0])
    inverse, scale = constants[0].inverse_length, constants[0].slope_factor
    factor = scale / (inverse * inverse)  # the normalization of the kernel
    density, time, full = numbers
    rate = pull[2 * dimension] * pull[2 * dimension]
    zero, one, lighter, deep = 0.0, 1.0, 1.0 / density, closing.shape[0] == 3
    counts, start, neighbor = lists
    for particle in prange(closing.shape[1]):
        i, row = INDEX(particle), INDEX(start[particle])
        count = INDEX(counts[i])
        for k in range(whole(counts[i])):
            gradient[dimension, row + INDEX(k)] = 0.0
        for axis in range(dimension):
            x = fields[FIELD.position + axis, i]
            for k in range(whole(counts[i])):
                along = fields[FIELD.position + axis, INDEX(neighbor[row + INDEX(k)])] - x
                gradient[axis, row + INDEX(k)] = along
                gradient[dimension, row + INDEX(k)] += along * along
        own = fields[FIELD.volume, i]
        total = own * value_of(zero * inverse, code)
        for k in range(count):
            value = value_of(math.sqrt(gradient[dimension, row + INDEX(k)]) * inverse, code)
            total += fields[FIELD.volume, INDEX(neighbor[row + INDEX(k)])] * value
        squares, near, behind, rest = zero, zero, zero, zero
        tx, ty, tz, sx, sy, sz = zero, zero, zero, zero, zero, zero
        rx, ry, rz, lx, ly, lz = zero, zero, zero, zero, zero, zero
        xx, xy, xz, yy, yz, zz = zero, zero, zero, zero, zero, zero
        for k in range(count):
            j, square = INDEX(neighbor[row + INDEX(k)]), gradient[dimension, row + INDEX(k)]
            volume, liquid = fields[FIELD.volume, j], fields[FIELD.liquid, j]
            slope = scale * written_slope(math.sqrt(square) * inverse, kernel)
            counted, dummy = volume * slope, one - liquid
            dx, dy, dz = gradient[0, row + INDEX(k)], gradient[1, row + INDEX(k)], zero
            rise = (pull[0] - rate * (fields[FIELD.position, j] - pull[dimension])) * dx
            rise += (pull[1] - rate * (fields[FIELD.position + 1, j] - pull[dimension + 1])) * dy
            if deep:
                dz = gradient[2, row + INDEX(k)]
                rise += (pull[2] - rate * (fields[FIELD.position + 2, j] - pull[dimension + 2])) * dz
                gradient[2, row + INDEX(k)] = slope * dz
            gradient[0, row + INDEX(k)] = slope * dx
            gradient[1, row + INDEX(k)] = slope * dy
            gradient[dimension, row + INDEX(k)] = slope
            push, lift = counted * liquid * fields[FIELD.pressure, j] * lighter, counted * dummy * rise
            twice = counted * (one + dummy)
            tx, ty, tz = tx + twice * dx, ty + twice * dy, tz + twice * dz
            sx, sy, sz = sx + counted * dx, sy + counted * dy, sz + counted * dz
            rx, ry, rz = rx + push * dx, ry + push * dy, rz + push * dz
            lx, ly, lz = lx + lift * dx, ly + lift * dy, lz + lift * dz
            wall = counted * dummy
            xx, xy, xz = xx + wall * dx * dx, xy + wall * dx * dy, xz + wall * dx * dz
            yy, yz, zz = yy + wall * dy * dy, yz + wall * dy * dz, zz + wall * dz * dz
            squares += liquid * counted * slope * square
            near -= liquid * counted
            behind -= dummy * counted
            rest += push + lift
        closing[0, i], closing[1, i] = tx, ty
        resting[0, i], resting[1, i], lifting[0, i], lifting[1, i] = rx, ry, lx, ly
        moved[0, 0, i], moved[0, 1, i], moved[1, 0, i], moved[1, 1, i] = xx, xy, xy, yy
        if deep:
            closing[2, i], resting[2, i], lifting[2, i] = tz, rz, lz
            moved[0, 2, i], moved[1, 2, i], moved[2, 0, i], moved[2, 1, i], moved[2, 2, i] = xz, yz, xz, yz, zz
        closed, steep = tx * tx + ty * ty + tz * tz, sx * sx + sy * sy + sz * sz
        slant[i] = math.sqrt(steep)
        held[i] = rest + rest
        summed[i] = factor * total
        compact[i] = max(near, full - behind)
        diagonal[i] = incompressible.diagonal(own * squares + closed, compact[i], density, time)


def accelerations(system: System, pressure: Array) -> Array:
    """The accelerations a(p), (d, N) in m/s^2."""
    return _sums_of_pressure(system, pressure)[:-1]


def _sums_of_pressure(system: System, pressure: Array) -> Array:
    """The sums a(p) and l(p), (d + 1, N)."""
    found = np.empty((len(system.closing) + 1, len(pressure)))
    carried = system.weight * pressure[system.root]
    sum_pressure(
        found, system.gradient, system.closing, system.compact, pressure, carried, system.lists, system.density
    )
    return found


def applied(system: System, pressure: Array) -> Array:
    """The product A p: the relative decrease of density in the step."""
    sums = _sums_of_pressure(system, pressure)
    exact = -compressions(system, sums[:-1])
    return incompressible.decrease(exact, sums[-1], system.time)


def compressions(system: System, velocity: Array) -> Array:
    """The compressions c(v) (N,) in 1/s, with walls at rest."""
    return compressions_of(system, velocity, system.weight * system.sign * velocity[:, system.root])


def gravity_at(now: Parameters, position: Array) -> Array:
    """Gravity and the central acceleration (d, N) in m/s^2."""
    found: Array = now.gravity[:, None] - now.pull_rate**2 * (position - now.pull_center[:, None])
    return found


def known_compression(system: System, resting: Array, gravity: Array) -> Array:
    """The mean (N,) in 1/s^2 of the sources: c(r) for -c(a(p)), and -c(G) - m for l(p). m is that of dummies next to
    liquid at rest; their acceleration has no effect, since -c(G) - m of dummies is zero.
    """
    found: Array = 0.5 * (compressions(system, resting - gravity) - system.held)
    return found


def compressions_of(system: System, velocity: Array, carried: Array) -> Array:
    """The compressions c(v) (N,) in 1/s; `carried` (d, columns) is volume times velocity, doubled for dummies."""
    found = np.empty(velocity.shape[1])
    sum_compression(found, system.gradient, system.closing, velocity, carried, system.lists)
    return found


def moving_compressions(system: System, workspace: Workspace, velocity: Array) -> Array:
    """The compressions c(v) (N,) in 1/s with moving walls, from filled fields."""
    fields = workspace.fields
    carried = fields.volume * (2.0 - fields.liquid) * fields.velocity[: len(velocity)]
    return compressions_of(system, velocity, carried.astype(np.float64))


def excess_of_motion(system: System, workspace: Workspace, state: State) -> Array:
    """The excess of density (N,) by motion on straight lines. The velocity is that before the kick by other forces,
    which conserves the density; the filled fields contain the velocity after this kick.
    """
    fields = workspace.fields
    kick = system.time * state.acceleration
    before = fields.velocity[: len(kick)] - system.sign * kick[:, system.root]
    carried = (fields.volume * (2.0 - fields.liquid) * before).astype(np.float64)
    found = np.empty((2, kick.shape[1]))
    sum_velocity_gradient(found, system.gradient, system.closing, state.velocity - kick, carried, system.lists)
    return straight_motion_excess(found[0], found[1], system.time)


@summing
def sum_pressure(
    found: Array, gradient: Array, closing: Array, compact: Array, pressure: Array, carried: Array, lists: Lists,
    density: float,
) -> None:  # fmt: skip
    """Sum a_i = [p_i T_i + sum_j V_j p_j g_ij]/rho, and l_i = (2/rho)[D_i p_i + sum_j V_j p_j F_ij]."""
    counts, start, neighbor = lists
    dimension, deep = INDEX(closing.shape[0]), closing.shape[0] == 3
    for particle in prange(closing.shape[1]):
        i, row = INDEX(particle), INDEX(start[particle])
        ax, ay, az, laplacian = 0.0, 0.0, 0.0, 0.0
        for k in range(whole(counts[i])):
            other = carried[INDEX(neighbor[row + INDEX(k)])]
            ax += gradient[0, row + INDEX(k)] * other
            ay += gradient[1, row + INDEX(k)] * other
            laplacian += gradient[dimension, row + INDEX(k)] * other
            if deep:
                az += gradient[2, row + INDEX(k)] * other
        own = pressure[i]
        found[0, i] = (ax + own * closing[0, i]) / density
        found[1, i] = (ay + own * closing[1, i]) / density
        if deep:
            found[2, i] = (az + own * closing[2, i]) / density
        found[dimension, i] = 2.0 * (laplacian + own * compact[i]) / density


@summing
def sum_compression(
    found: Array, gradient: Array, closing: Array, velocity: Array, carried: Array, lists: Lists
) -> None:
    """Sum the compressions c_i = sum_j V_j g_ij.v_j - T_i.v_i."""
    counts, start, neighbor = lists
    deep = closing.shape[0] == 3
    for particle in prange(len(found)):
        i, row, total = INDEX(particle), INDEX(start[particle]), 0.0
        for k in range(whole(counts[i])):
            j = INDEX(neighbor[row + INDEX(k)])
            total += gradient[0, row + INDEX(k)] * carried[0, j] + gradient[1, row + INDEX(k)] * carried[1, j]
            if deep:
                total += gradient[2, row + INDEX(k)] * carried[2, j]
        own = closing[0, i] * velocity[0, i] + closing[1, i] * velocity[1, i]
        if deep:
            own += closing[2, i] * velocity[2, i]
        found[i] = total - own


@summing
def sum_velocity_gradient(
    found: Array, gradient: Array, closing: Array, velocity: Array, carried: Array, lists: Lists
) -> None:
    """Sum -G_ab = sum_j V_j v_j,a g_ij,b - T_i,b v_i,a, minus the gradients of the velocity; store tr G and tr(G G)."""
    counts, start, neighbor = lists
    deep = closing.shape[0] == 3
    for particle in prange(closing.shape[1]):
        i, row = INDEX(particle), INDEX(start[particle])
        xx, xy, xz, yx, yy, yz, zx, zy, zz = 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0
        for k in range(whole(counts[i])):
            j = INDEX(neighbor[row + INDEX(k)])
            u, v = carried[0, j], carried[1, j]
            gx, gy = gradient[0, row + INDEX(k)], gradient[1, row + INDEX(k)]
            xx += u * gx
            xy += u * gy
            yx += v * gx
            yy += v * gy
            if deep:
                w, gz = carried[2, j], gradient[2, row + INDEX(k)]
                xz += u * gz
                yz += v * gz
                zx += w * gx
                zy += w * gy
                zz += w * gz
        u, v, tx, ty = velocity[0, i], velocity[1, i], closing[0, i], closing[1, i]
        xx, xy, yx, yy = xx - u * tx, xy - u * ty, yx - v * tx, yy - v * ty
        if deep:
            w, tz = velocity[2, i], closing[2, i]
            xz, yz, zx, zy, zz = xz - u * tz, yz - v * tz, zx - w * tx, zy - w * ty, zz - w * tz
        found[0, i] = -(xx + yy + zz)
        found[1, i] = xx * xx + yy * yy + zz * zz + 2.0 * (xy * yx + xz * zx + yz * zy)


def project(parameters: Parameters, state: State, workspace: Workspace, time: float) -> tuple[System, Array]:
    """Solve for the pressure, and change the velocities by it; return the solved equation, and the accelerations u of
    `flights`.
    """
    settings = parameters.projection
    if settings is None:
        raise ValueError("got a compressible liquid; expected one with a Projection")
    now = with_moved_solids(parameters, state)
    fill(now, state._replace(pressure=np.zeros_like(state.pressure)), workspace)
    system, gravity = assemble(now, settings, workspace, time), gravity_at(now, state.position)
    flight = np.zeros_like(gravity)
    if settings.free_surface:
        flight = flights(now, system, state, gravity, settings.uppermost)
    resting = system.resting + system.lifting - (system.behind * flight).sum(axis=1)
    summed = density_excess(system.summed, settings.lattice_sum)
    excess = summed + missing_density(system, settings)
    corrected = free_correction(excess) if settings.free_surface else correction(excess)
    corrected += excess_of_motion(system, workspace, state)
    stretch = moving_compressions(system, workspace, state.velocity)
    right = corrected + time * (stretch + time * known_compression(system, resting, gravity))
    found = pressures(system, right, state.pressure, settings)
    push = resting + accelerations(system, found.x)
    add_remaining_work(state, system, found.x, stretch + time * compressions(system, push))
    state.pressure[...] = found.x
    state.velocity[...] += time * push
    counted = np.maximum(summed, 0.0) if settings.free_surface else summed
    state.density[...] = now.material.density * (1.0 + counted)
    record(state, found)
    if forces_work(parameters):
        fill(now, state, workspace)
        # Values that are not finite are reported by the time integration.
        with np.errstate(over="ignore", invalid="ignore"):
            state.budget[RATE] = power_of_forces(now, state, workspace)
    return system, flight


def flights(now: Parameters, system: System, state: State, gravity: Array, uppermost: float) -> Array:
    """The mean acceleration u (d, N) in m/s^2 of the neighbors of each particle near dummies, from the pressures of the
    previous step. Where these are zero, in free flight, u is G; elsewhere |G - u| is at most |G|.

    With b = a(p) + r of images, the acceleration is u = G + b + B (G - u), so that (1 + B) u = G + b + B G.
    """
    dummies = np.asarray(system.behind.any(axis=(0, 1)))
    if not (state.ready[0] and dummies.any() and now.gravity.any()) or now.pull_rate > 0.0:
        return np.zeros_like(gravity)
    d, count = gravity.shape
    still = gravity + accelerations(system, state.pressure) + system.resting + system.lifting
    values = np.concatenate([still, system.behind.reshape(d * d, count)])
    sums = np.zeros((d * d + d + 1, count))
    sum_neighbors(sums, dummies, system.gradient, system.weight, values, system.root, system.sign, system.lists)
    mean = sums[:-1] / np.where(sums[-1] == 0.0, 1.0, sums[-1])
    matrix = np.eye(d) + mean[d:].reshape(d, d, count).transpose(2, 0, 1)
    borne = gravity - np.linalg.solve(matrix, mean[:d].T[:, :, None])[:, :, 0].T
    size = np.sqrt((borne**2).sum(axis=0) / (gravity**2).sum(axis=0))
    borne *= np.clip(state.pressure / uppermost, 0.0, 1.0) / np.maximum(size, 1.0)
    found: Array = np.where(dummies, gravity - borne, 0.0)
    return found


@summing
def sum_neighbors(
    found: Array, chosen: Flags, gradient: Array, weight: Array, values: Array, root: Integers, sign: Array,
    lists: Lists,
) -> None:  # fmt: skip
    """Sum V_j F_ij times vectors and matrices of the liquid around the chosen particles, mirrored in images; the last
    row is the sum of V_j F_ij.
    """
    counts, start, neighbor = lists
    dimension, rows = len(sign), len(values)
    for particle in prange(len(chosen)):
        i, row = INDEX(particle), INDEX(start[particle])
        if not chosen[i]:
            continue
        for k in range(counts[i]):
            j = INDEX(neighbor[row + INDEX(k)])
            share, source = weight[j] * gradient[dimension, row + INDEX(k)], INDEX(root[j])
            found[rows, i] += share
            for axis in range(dimension):
                turned = share * sign[axis, j]
                found[axis, i] += turned * values[axis, source]
                for other in range(dimension):
                    place = dimension * (axis + 1) + other
                    found[place, i] += turned * sign[other, j] * values[place, source]


def add_remaining_work(state: State, system: System, pressure: Array, compression: Array) -> None:
    """Add the work of the pressure in a step on the compression c (N,) by the final velocities, minus time sum_i V_i
    p_i c_i. Without compression the pressure only dissipates, (time^2/2) sum_i m_i a_i^2; liquid that is too dense at
    an impact expands against its pressure.
    """
    work = -system.time * dot(system.volume, pressure * compression)
    state.budget[WORK] += work
    state.numerical[WORK] += work


def mean_of(system: System, values: Array) -> float:
    """The mean over the volume."""
    return float(np.sum(system.volume * values) / np.sum(system.volume))


def missing_density(system: System, settings: Projection) -> Array:
    """The part of the density of particles at a free surface that is missing because of the empty space above, over the
    density at rest.

    It is that of a row of a lattice below a flat surface with the same sum of gradients. Where that sum is small, as in
    drops and between approaching surfaces, the density is low because particles are missing, and such liquid may
    approach other liquid.
    """
    if not settings.free_surface:
        return np.zeros(len(system.summed))
    found: Array = np.interp(system.steepness, settings.steepness, settings.missing)
    return found


def pressures(system: System, right: Array, guess: Array, settings: Projection) -> Solution:
    """The pressures, and the remaining error of the density of each particle.

    Unknowns are scaled with the diagonal of V A, where V are the volumes, so that the matrix is symmetric.
    """
    scale = 1.0 / np.sqrt(system.volume * system.diagonal)
    weight = scale * system.volume
    if not settings.free_surface:
        right = right - mean_of(system, right)

    def scaled(x: Array) -> Array:
        return weight * applied(system, scale * x)

    def error(gradient: Array) -> float:
        return math.sqrt(float(np.mean((gradient / weight) ** 2)))

    problem = Problem(scaled, weight * right, settings.free_surface, settings.step, error)
    found = solve(problem, guess / scale, settings.tolerance, settings.iterations)
    pressure = scale * found.x
    if not settings.free_surface:
        pressure += settings.uppermost - pressure.min()
    return found._replace(x=pressure, gradient=found.gradient / weight)


def record(state: State, found: Solution) -> None:
    """Count iterations, and store the remaining error."""
    state.tally[ITERATIONS] += found.iterations
    state.tally[MOST_ITERATIONS] = max(state.tally[MOST_ITERATIONS], found.iterations)
    state.tally[RESIDUAL] = found.error
    state.tally[WORST] = state.identity[int(np.argmax(np.abs(found.gradient)))]


def failed(projection: Projection, state: State) -> bool:
    """Whether the solver did not reach its tolerance in the last step."""
    return not state.tally[RESIDUAL] <= projection.tolerance
