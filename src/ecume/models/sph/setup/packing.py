"""Particle packing: initial positions next to surfaces that no lattice fits, such as discs and slanted obstacles.

The concentration of particles, C = sum_j V_j W, is one in a uniform arrangement. Pressure drives particles down its
gradient, sum_j V_j grad W: from a lattice with gaps at an obstacle, still water starts to slosh. Particles near such
surfaces therefore start where the gradient vanishes: they are moved down the gradient with inertia until it vanishes.
The images and dummies of the walls are those of the run, and the lattice is continued beyond a free surface.

Colagrossi, Bouscasse, Antuono and Marrone, Comput. Phys. Commun. 183 (2012) 1641. [colagrossi2012] The integration is
FIRE: Bitzek et al., Phys. Rev. Lett. 97 (2006) 170201. [bitzek2006]

The file also has sums over a lattice and over its waves. They give constants of the pressure solver for incompressible
liquids, and the limit of particle shifting.
"""

from __future__ import annotations

import itertools
import math
from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from ecume._portable import length
from ecume.engine.cells import Images, Integers, Sides, images_of, positions_of_images
from ecume.engine.shapes import Cells, Flags, Part, Shape, apart
from ecume.laws.incompressible import tensile_weight
from ecume.laws.kernels import Kernel
from ecume.models.sph.setup.choices import kernel_of, smoothing_of
from ecume.models.sph.setup.shapes import dummies_of, gaps_to, obstacle_dummies, part_of, shape_of, solids_of
from ecume.models.sph.setup.walls_and_bodies import STANDOFF, imaging_sides, layers_around, side_of
from ecume.scenes.sph import SphScene
from ecume.units import Array

BAND = 8.0
"""The width of the layer next to an unaligned surface in which particles are moved, in spacings."""
LEAST_GAP, LEAST_DEPTH = STANDOFF, 0.25
"""The smallest distances of a particle from solids and from the faces of its region, in spacings. Solids repel closer
particles.
"""
EVEN = {2: 1e-4, 3: 1e-3}
"""The gradient of the concentration at which packing ends, over one per spacing, by dimension. With 2e-3 particles
shift by as many spacings in the run, and the pressure in a full tank by some percent of that at the floor.
"""
MOST_STEPS = 300
SKIN, LONGEST = 0.4, 0.1
"""The skin of pair lists and the longest displacement of a step, in spacings."""
FIRST_STEP, LAST_STEP, GROWTH, CUT = 0.3, 0.9, 1.1, 0.5
"""The time step of FIRE, in periods of a particle about its place over 2 pi, its largest value, and the factors of its
growth and reduction.
"""
BLEND, FADING, PATIENCE = 0.1, 0.99, 5
"""The fraction of the velocity that is turned into the direction of the force, the factor by which it decreases, and
after how many steps.
"""
TINY = 1e-300


class Particles(NamedTuple):
    """The particles in the sums during packing: moving liquid first, then all fixed particles."""

    position: Array
    """(n, d)"""
    volume: Array
    """(n,)"""
    moving: Integers
    """indices of particles that are moved"""
    sides: Sides
    """with images behind them"""


class Limits(NamedTuple):
    """The region of moved particles."""

    low: Array
    """(m, d)"""
    high: Array
    solids: tuple[Shape, ...]
    least: float
    """m, from solids"""

    def held(self, position: Array) -> Array:
        """The positions, clamped to the limits."""
        position = position.copy()
        for solid in self.solids:
            gap, normal = solid.nearest(position)
            near = gap < self.least
            position[near] += (self.least - gap[near])[:, None] * normal[near]
        held: Array = np.clip(position, self.low, self.high)
        return held


def packed(scene: SphScene, regions: Sequence[Cells], solids: Sequence[Shape]) -> list[Cells]:
    """The cells of all regions, with those near unaligned `solids` moved; unchanged without such solids."""
    drawn = np.concatenate([np.full(len(cells.centers), spec.particles is None)
                            for cells, spec in zip(regions, scene.fluid, strict=True)])  # fmt: skip
    position = np.concatenate([cells.centers for cells in regions])
    near = drawn & (gaps_to(solids, position) < BAND * scene.spacing)
    if not near.any():
        return list(regions)
    particles, limits = _particles(scene, regions, near), _limits(scene, regions, near, solids)
    position[near] = relaxed(particles, limits, kernel_of(scene), (smoothing_of(scene), scene.spacing))
    ends = np.cumsum([len(cells.centers) for cells in regions])
    return [cells._replace(centers=own) for cells, own in zip(regions, np.split(position, ends[:-1]), strict=True)]


def _limits(scene: SphScene, regions: Sequence[Cells], near: Flags, solids: Sequence[Shape]) -> Limits:
    """The region of each moving particle, and the solids."""
    depth = LEAST_DEPTH * scene.spacing
    bounds = [part_of(spec, scene.spacing).bounds() for spec in scene.fluid]
    counts = [len(cells.centers) for cells in regions]
    low, high = (np.repeat(np.array(corners), counts, axis=0)[near] for corners in zip(*bounds, strict=True))
    return Limits(low + depth, high - depth, tuple(solids), LEAST_GAP * scene.spacing)


def _particles(scene: SphScene, regions: Sequence[Cells], near: Flags) -> Particles:
    """Liquid, dummies and the continued lattice within reach of the moving particles."""
    support = kernel_of(scene).support * smoothing_of(scene)
    liquid = np.concatenate([cells.centers for cells in regions]), np.concatenate([cells.volumes for cells in regions])
    still = [*_solid_particles(scene, support), layers_around(scene, support), *_beyond(scene, support)]
    position, volume = (np.concatenate(parts) for parts in zip(liquid, *still, strict=True))
    moving = np.zeros(len(position), bool)
    moving[: len(near)] = near
    from scipy.spatial import cKDTree

    distance, _ = cKDTree(position[moving]).query(position, distance_upper_bound=2.0 * support)
    kept = moving | np.isfinite(distance)
    return Particles(position[kept], volume[kept], np.flatnonzero(moving[kept]), imaging_sides(scene)[0])


def _solid_particles(scene: SphScene, support: float) -> list[tuple[Array, Array]]:
    """Dummies of obstacles and bodies."""
    bodies = [dummies_of(shape_of(spec), scene.spacing, support) for spec in scene.bodies]
    return [*obstacle_dummies(scene, support), *bodies]


def _beyond(scene: SphScene, support: float) -> list[tuple[Array, Array]]:
    """The lattice of each drawn region, continued through its free surface."""
    parts = [part_of(spec, scene.spacing) for spec in scene.fluid]
    solids = solids_of(scene)
    found: list[tuple[Array, Array]] = []
    for spec, part in zip(scene.fluid, parts, strict=True):
        if spec.particles is not None:
            continue
        points, volume = _continued(part, scene.spacing, support)
        free = apart(points, [*parts, *solids]) & _unwalled(scene, points)
        for earlier, _ in found:
            free &= ~np.isfinite(_nearest(points, earlier, 0.7 * scene.spacing))
        found.append((points[free], volume[free]))
    return found


def _nearest(points: Array, others: Array, within: float) -> Array:
    """The distances (N,) to the nearest of the other points; infinite beyond `within`."""
    if len(others) == 0:
        return np.full(len(points), np.inf)
    from scipy.spatial import cKDTree

    return np.asarray(cKDTree(others).query(points, distance_upper_bound=within)[0])


def _continued(part: Part, spacing: float, support: float) -> tuple[Array, Array]:
    """The lattice of a region, extended beyond its bounds by one support."""
    cells, axes, volume = part.cells(spacing), [], 1.0
    layers = math.ceil(support / spacing)
    for axis in range(cells.centers.shape[1]):
        _, first = np.unique(np.round(cells.centers[:, axis] / (1e-6 * spacing)), return_index=True)
        line, width = cells.centers[first, axis], cells.widths[first, axis]
        more = np.arange(1, layers + 1)
        axes.append(np.concatenate([line[0] - width[0] * more[::-1], line, line[-1] + width[-1] * more]))
        volume *= width[0]
    points = np.stack([grid.ravel() for grid in np.meshgrid(*axes, indexing="ij")], axis=1)
    return points, np.full(len(points), volume)


def _unwalled(scene: SphScene, points: Array) -> Flags:
    """Flags of the points that are not behind a side with images or dummies."""
    free = np.ones(len(points), bool)
    for axis in range(points.shape[1]):
        for number, beyond in ((2 * axis, points[:, axis] < scene.tank.low[axis]),
                               (2 * axis + 1, points[:, axis] > scene.tank.high[axis])):  # fmt: skip
            kind = side_of(scene, number).kind
            if kind == "periodic" or (kind == "wall" and scene.tank.walls != "reflect"):
                free &= ~beyond
    return free


def relaxed(particles: Particles, limits: Limits, kernel: Kernel, lengths: tuple[float, float]) -> Array:
    """The positions of the moving particles where the gradient of concentration vanishes; lengths = (smoothing length,
    spacing).
    """
    spacing, moving = lengths[1], particles.moving
    place = limits.held(particles.position[moving])
    speed, back = np.zeros_like(place), np.zeros_like(place)
    time, blend, good = FIRST_STEP, BLEND, 0
    pairs: Pairs | None = None
    for _ in range(MOST_STEPS):
        particles.position[moving] = place
        if pairs is None or _displacement(particles, pairs) > 0.5 * SKIN * spacing:
            pairs = pairs_of(particles, kernel.support * lengths[0] + SKIN * spacing)
        push = along_surfaces(-spacing * concentration_gradient(particles, pairs, kernel, lengths[0]), back)
        if math.sqrt(float((push**2).sum(axis=1).max())) < EVEN[kernel.dim]:
            break
        if float((push * speed).sum()) > 0.0:
            size = math.sqrt(float((speed**2).sum()) / float((push**2).sum()))
            speed = (1.0 - blend) * speed + blend * size * push
            good += 1
            if good > PATIENCE:
                time, blend = min(GROWTH * time, LAST_STEP), FADING * blend
        else:
            speed, time, blend, good = np.zeros_like(speed), CUT * time, BLEND, 0
        speed += time * push
        length = np.sqrt((speed**2).sum(axis=1))
        speed *= np.minimum(1.0, LONGEST / (time * np.maximum(length, TINY)))[:, None]
        there = place + spacing * time * speed
        place = limits.held(there)
        back = np.where(place == there, 0.0, place - there)
        speed = along_surfaces(speed, back)
    return place


def along_surfaces(vectors: Array, back: Array) -> Array:
    """The components of vectors (m, d) that do not press particles against the limits, which moved them by `back`."""
    length = np.sqrt((back**2).sum(axis=1))[:, None]
    normal = back / np.maximum(length, TINY)
    found: Array = vectors - np.minimum((vectors * normal).sum(axis=1), 0.0)[:, None] * normal
    return found


class Pairs(NamedTuple):
    """Pairs of particles of which at least one moves; valid until one has moved too far."""

    one: Integers
    other: Integers
    volume: Array
    """of all particles, images last"""
    images: Images
    reference: Array


def _displacement(particles: Particles, pairs: Pairs) -> float:
    """The largest displacement since the pairs were listed."""
    return math.sqrt(float(((particles.position - pairs.reference) ** 2).sum(axis=1).max()))


def pairs_of(particles: Particles, reach: float) -> Pairs:
    """All pairs closer than the reach."""
    images, volume = images_of(np.ascontiguousarray(particles.position.T), particles.sides, reach), particles.volume
    for first, last in zip(images.start[:-1], images.start[1:], strict=True):
        volume = np.concatenate([volume, volume[images.source[first:last]]])
    all_particles = with_images(particles, images).T
    moves = np.zeros(len(all_particles), bool)
    moves[particles.moving] = True
    from scipy.spatial import cKDTree

    both = cKDTree(all_particles).query_pairs(reach, output_type="ndarray")
    both = both[moves[both].any(axis=1)]
    one, other = np.ascontiguousarray(both[np.lexsort((both[:, 1], both[:, 0]))].T)
    return Pairs(one, other, volume, images, particles.position.copy())


def with_images(particles: Particles, images: Images) -> Array:
    """The positions (d, n) of all particles, images last."""
    position = np.ascontiguousarray(particles.position.T)
    return np.concatenate([position, positions_of_images(position, images, particles.sides)], axis=1)


def distances(particles: Particles, pairs: Pairs) -> tuple[list[Array], Array]:
    """The difference of positions of each pair along each axis, and its distance."""
    away = [line[pairs.one] - line[pairs.other] for line in with_images(particles, pairs.images)]
    square = away[0] * away[0]
    for along in away[1:]:
        square += along * along
    return away, np.sqrt(square)


def concentration_gradient(particles: Particles, pairs: Pairs, kernel: Kernel, length: float) -> Array:
    """The concentration gradient (m, d) at the moving particles, sum_j V_j grad W (1/m)."""
    away, distance = distances(particles, pairs)
    slope = kernel.normalization / length ** (kernel.dim + 2) * np.asarray(kernel.shape_slope(distance / length))
    of_one, of_other = slope * pairs.volume[pairs.other], slope * pairs.volume[pairs.one]
    found = np.empty((len(particles.moving), kernel.dim))
    for axis, along in enumerate(away):
        total = np.bincount(pairs.one, of_one * along, len(pairs.volume))
        total -= np.bincount(pairs.other, of_other * along, len(pairs.volume))
        found[:, axis] = total[particles.moving]
    return found


def concentrations(particles: Particles, kernel: Kernel, length: float) -> Array:
    """The concentration (m,) at the moving particles, sum_j V_j W, which is one in a uniform arrangement."""
    pairs = pairs_of(particles, kernel.support * length)
    weight = np.asarray(kernel.value(distances(particles, pairs)[1], length))
    total = np.bincount(pairs.one, weight * pairs.volume[pairs.other], len(pairs.volume))
    total += np.bincount(pairs.other, weight * pairs.volume[pairs.one], len(pairs.volume))
    found: Array = (total + float(kernel.value(0.0, length)) * pairs.volume)[particles.moving]
    return found


def unevenness(scene: SphScene, regions: Sequence[Cells], solids: Sequence[Shape]) -> float | None:
    """The largest deviation of the concentration from one, for particles next to unaligned solids; None without such
    solids.
    """
    position = np.concatenate([cells.centers for cells in regions])
    near = gaps_to(solids, position) < kernel_of(scene).support * smoothing_of(scene)
    if not near.any():
        return None
    found = concentrations(_particles(scene, regions, near), kernel_of(scene), smoothing_of(scene))
    return float(np.abs(found - 1.0).max())


DISORDER = 0.1
"""The gradient in disordered liquid, over that at a surface."""
WAVES = 33
"""The number of wave numbers along an axis among which the largest eigenvalue is searched."""


def lattice(scene: SphScene) -> Array:
    """The points (n, d) in m of a lattice within the support of the point at the origin, which is excluded."""
    kernel, h = kernel_of(scene), smoothing_of(scene)
    reach = int(np.ceil(kernel.support * h / scene.spacing))
    line = range(-reach, reach + 1)
    points = np.array(list(itertools.product(line, repeat=kernel.dim))) * scene.spacing
    away = np.sqrt((points**2).sum(axis=1))
    near: Array = points[(away > 0.0) & (away < kernel.support * h)]
    return near


def lattice_sum(scene: SphScene, points: Array) -> float:
    """The sum of volumes times kernel at a point of the lattice."""
    kernel, h = kernel_of(scene), smoothing_of(scene)
    away = np.concatenate([[0.0], np.sqrt((points**2).sum(axis=1))])
    return float(scene.spacing**kernel.dim * np.sum(kernel.value(away, h)))


def surface_rows(scene: SphScene, points: Array) -> tuple[Array, Array]:
    """The sums |sum of V grad W| (1/m) and the missing densities, over the density, of the rows of a lattice below a
    flat surface, the deepest first. Rows with less than a tenth of the largest gradient count as full, since disorder
    causes such gradients.
    """
    kernel, h = kernel_of(scene), smoothing_of(scene)
    volume, total = scene.spacing**kernel.dim, lattice_sum(scene, points)
    gradient, value = kernel.gradient(points, h), np.asarray(kernel.value(np.sqrt((points**2).sum(axis=1)), h))
    rows = []
    for depth in range(int(np.ceil(kernel.support * h / scene.spacing))):
        above = points[:, 1] > (depth + 0.5) * scene.spacing
        rows.append((volume * length(gradient[~above].sum(axis=0)), volume * float(value[above].sum()) / total))
    flat = DISORDER * rows[0][0]
    found = [(flat, 0.0), *[row for row in reversed(rows) if row[0] > flat]]
    return np.array([row[0] for row in found]), np.array([row[1] for row in found])


def lattice_coupling(scene: SphScene, points: Array) -> float:
    """The sum -sum_j V_j F_ij (1/m^2) at a point of the lattice."""
    kernel, h = kernel_of(scene), smoothing_of(scene)
    steepness = np.sqrt((kernel.gradient(points, h) ** 2).sum(axis=1) / (points**2).sum(axis=1))
    return float(scene.spacing**kernel.dim * steepness.sum())


def largest_eigenvalue(scene: SphScene, points: Array) -> float:
    """The largest eigenvalue of A over its diagonal in a lattice, among waves along the axes and between them."""
    kernel, h = kernel_of(scene), smoothing_of(scene)
    volume, gradient = scene.spacing**kernel.dim, kernel.gradient(points, h)
    steepness = np.sqrt((gradient**2).sum(axis=1) / (points**2).sum(axis=1))
    phases = wave_vectors(scene, WAVES) @ points.T
    exact = ((volume * np.sin(phases) @ gradient) ** 2).sum(axis=1)
    compact = 2.0 * volume * (1.0 - np.cos(phases)) @ steepness
    own = float(volume**2 * (gradient**2).sum() + 2.0 * volume * steepness.sum())
    return float((exact + compact).max()) / own


def wave_vectors(scene: SphScene, count: int) -> Array:
    """Wave vectors (W, d) in 1/m along the axes and between them, up to the shortest wave that the lattice resolves."""
    dimension = kernel_of(scene).dim
    return np.array(list(itertools.product(np.linspace(0.0, np.pi / scene.spacing, count), repeat=dimension)))


def shifting_limit(scene: SphScene) -> float:
    """The largest product (m^2) of the shifting coefficient and the time with which no small displacement wave of the
    lattice overshoots: the inverse of the largest eigenvalue of minus the derivative of the concentration gradient.
    """
    kernel, h, points = kernel_of(scene), smoothing_of(scene), lattice(scene)
    volume, usual = scene.spacing**kernel.dim, kernel.value(scene.spacing, h)

    def pull(places: Array) -> Array:
        value = np.asarray(kernel.value(np.sqrt((places**2).sum(axis=1)), h))
        found: Array = volume * tensile_weight(value / usual)[:, None] * kernel.gradient(places, h)
        return found

    little = 1e-5 * scene.spacing
    steps = little * np.eye(kernel.dim)
    change = np.stack([(pull(points + step) - pull(points - step)) / (2.0 * little) for step in steps], axis=2)
    waves = wave_vectors(scene, WAVES if kernel.dim == 2 else WAVES // 2 + 1)
    response = np.tensordot(1.0 - np.cos(waves @ points.T), change, axes=1)
    return 1.0 / float(np.linalg.eigvalsh(0.5 * (response + response.transpose(0, 2, 1))).max())
