"""Initial positions, velocities and densities of the liquid, with the pressure that balances gravity and the flow.

Positions, velocities and masses that a table or another run gives for single particles take precedence.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from ecume.engine.cells import Integers
from ecume.engine.outlines import Cloud
from ecume.engine.shapes import Box, Cells, Flags, Part, Shape, apart, bounds_meet, covered_volume, scaled_to
from ecume.errors import Fault, SceneError
from ecume.laws.drops import ball_pressure, patch_pressure
from ecume.laws.flows import channel_speed, taylor_green_pressure, taylor_green_velocity
from ecume.laws.states import density_at_enthalpy, tait_density, tait_enthalpy, tait_pressure
from ecume.laws.water_waves import standing_wave_velocity
from ecume.models.sph.parameters import Liquid, Material
from ecume.models.sph.setup.choices import held_pull, modified
from ecume.models.sph.setup.packing import packed
from ecume.models.sph.setup.shapes import free_of, gaps_to, part_of, solids_of
from ecume.models.sph.setup.walls_and_bodies import bounds_of
from ecume.scenes.sph import RegionSpec, SphScene
from ecume.units import Array


class GivenValues(NamedTuple):
    """Given velocities, densities and masses of the particles of a region; NaN if not given."""

    velocity: Array
    """(n, d), zero where none is specified: it is added to the velocity of the region"""
    density: Array
    mass: Array


def given_values(region: RegionSpec, kept: Flags) -> GivenValues:
    """The specified values of the particles that were kept."""
    given, count = region.particles, int(kept.sum())
    unsaid = np.full(count, np.nan)
    if given is None:
        return GivenValues(np.zeros((count, 1)), unsaid, unsaid)
    velocity, density, mass = (
        np.array(each)[kept] if each else None for each in (given.velocities, given.densities, given.masses)
    )
    return GivenValues(
        np.zeros((count, 1)) if velocity is None else velocity,
        unsaid if density is None else density,
        unsaid if mass is None else mass,
    )


def with_given_values(liquid: Liquid, given: list[GivenValues]) -> Liquid:
    """The liquid with the specified values of its regions, in order."""
    dimension = len(liquid.position)
    velocity = np.concatenate([np.broadcast_to(each.velocity, (len(each.density), dimension)) for each in given])
    density, mass = np.concatenate([each.density for each in given]), np.concatenate([each.mass for each in given])
    dense = np.where(np.isnan(density), liquid.density, density)
    return liquid._replace(
        velocity=np.ascontiguousarray(liquid.velocity + velocity.T),
        density=dense,
        mass=np.where(np.isnan(mass), liquid.mass / liquid.density * dense, mass),
    )


TAYLOR_GREEN, STANDING_WAVE, POISEUILLE = "taylor-green", "standing-wave", "poiseuille"


def velocity_in(region: RegionSpec, scene: SphScene, points: Array) -> Array:
    """The initial velocity (N, d) of a region at points."""
    velocity = np.zeros_like(points)
    if region.velocity is not None:
        velocity += np.array(region.velocity)
    if region.velocity_gradient:
        center = np.zeros(points.shape[1]) if region.center is None else np.array(region.center)
        velocity += (points - center) @ np.array(region.velocity_gradient).T
    if region.flow == POISEUILLE:
        up = scene.up_axis
        low, width = scene.tank.low[up], scene.tank.high[up] - scene.tank.low[up]
        velocity[:, 0] += [channel_speed(height - low, width, region.flow_speed) for height in points[:, up]]
    if region.flow == TAYLOR_GREEN:
        x, y = vortex_phases(scene, points)
        velocity[:, 0] += taylor_green_velocity(x, y, region.flow_speed)
        velocity[:, scene.up_axis] += taylor_green_velocity(y, x, -_cross_speed(region, scene))
    elif region.flow == STANDING_WAVE:
        velocity[:, [0, scene.up_axis]] += _wave_velocity(region, scene, points)
    return velocity


def _wave_velocity(region: RegionSpec, scene: SphScene, points: Array) -> Array:
    """The velocity (N, 2) of a standing wave along x and upwards: half a wavelength is the width of the tank, and the
    depth is that of the region.
    """
    low, high, up = scene.tank.low, scene.tank.high, scene.up_axis
    depth = float(part_of(region, scene.spacing).bounds()[1][up]) - low[up]
    lowest = float(points[:, up].min(initial=math.inf))
    if depth <= 0.0 or lowest < low[up]:
        got = f"the liquid is at {min(depth + low[up], lowest):g} m; expected a region above the floor, {low[up]:g} m"
        raise SceneError([Fault("fluid.flow", f"got {STANDING_WAVE!r}; {got}")])
    wave = {"wavenumber": math.pi / (high[0] - low[0]), "depth": depth, "speed": region.flow_speed}
    return np.array([standing_wave_velocity(point[0] - low[0], point[up] - low[up], **wave) for point in points])


def pressure_in(region: RegionSpec, scene: SphScene, points: Array, density: float) -> Array:
    """The gauge pressure (N,) in Pa of the flow in a region, without the hydrostatic part.

    Without this pressure a weakly compressible liquid starts with sound waves, which only viscosity damps.
    """
    if scene.method.initial_pressure == "zero":
        return np.zeros(len(points))
    if region.flow == TAYLOR_GREEN:
        x, y = vortex_phases(scene, points)
        swirl: Array = np.asarray(taylor_green_pressure(x, y, region.flow_speed, _cross_speed(region, scene), density))
        return swirl
    if scene.gravity is None or any(scene.gravity) or not _free(scene):
        return np.zeros(len(points))
    return _deforming(region, scene, points, density)


def vortex_phases(scene: SphScene, points: Array) -> tuple[Array, Array]:
    """Phases (rad) of a vortex pair with the period of the tank."""
    size = np.array(scene.tank.high) - np.array(scene.tank.low)
    phase = 2.0 * math.pi * (points - np.array(scene.tank.low)) / size
    return phase[:, 0], phase[:, scene.up_axis]


def _cross_speed(region: RegionSpec, scene: SphScene) -> float:
    """The speed along the upward axis that makes the divergence zero in a tank that is not a square."""
    size = np.array(scene.tank.high) - np.array(scene.tank.low)
    return float(region.flow_speed * size[scene.up_axis] / size[0])


def _free(scene: SphScene) -> bool:
    return all(getattr(scene.tank, side).kind == "open" for side in scene.sides)


def _deforming(region: RegionSpec, scene: SphScene, points: Array, density: float) -> Array:
    """The pressure in a free ball or square that deforms, zero at its surface."""
    dimension = points.shape[1]
    gradient = np.array(region.velocity_gradient or np.zeros((dimension, dimension)))
    rate = scene.central_force.angular_frequency if scene.central_force else 0.0
    stretching = float(np.trace(gradient @ gradient)) + dimension * rate**2
    if region.radius is not None:
        away = np.linalg.norm(points - np.array(region.center), axis=1)
        return np.array([ball_pressure(r, region.radius, stretching, density, dimension) for r in away])
    if region.low is not None and region.high is not None and dimension == 2:
        low, size = np.array(region.low), np.array(region.high) - np.array(region.low)
        if math.isclose(size[0], size[1]):
            return np.array([patch_pressure(x, y, size[0], stretching, density) for x, y in points - low])
    return np.zeros(len(points))


def liquid_of(scene: SphScene, material: Material, other: Material | None = None) -> Liquid:
    """The particles at the start, with the hydrostatic pressure; `other` is a second liquid."""
    pull = np.zeros(len(scene.tank.low)) if modified(scene) else held_pull(scene)
    generator = np.random.default_rng(scene.seed)
    pieces: list[tuple[Array, Array, Array, Array]] = []
    given: list[GivenValues] = []
    found = cells_of(scene)
    parts = [part_of(region, scene.spacing) for region in scene.fluid]
    regions = packed(scene, [cells for cells, _ in found], unaligned_solids(scene))
    liquids = [other if other is not None and region.liquid == "second" else material for region in scene.fluid]
    for number, (region, cells, (_, kept)) in enumerate(zip(scene.fluid, regions, found, strict=True)):
        points, mine = cells.centers, liquids[number]
        head = np.zeros(len(points))
        if pull.any() and scene.method.initial_pressure == "hydrostatic":
            ways = ways_up(points, -pull / np.linalg.norm(pull), number, parts)
            head = head_below(ways, float(np.linalg.norm(pull)), liquids)
        if region.particles is None:
            points = points + scene.method.jitter * scene.spacing * generator.uniform(-1.0, 1.0, points.shape)
        head += pressure_in(region, scene, points, mine.density) / mine.density
        pieces.append((points, velocity_in(region, scene, points), head, cells.volumes))
        given.append(given_values(region, kept))
    return with_given_values(_particles(scene, liquids, pieces), given)


SEAM = 1e-6
"""Distance beyond the end of a region, relative, within which the next region is connected to it."""


def ways_up(points: Array, up: Array, own: int, parts: Sequence[Part]) -> list[tuple[Array, Integers]]:
    """The heights (N,) of liquid above points of a region (m), with the region of each height: first that region, then
    the regions on top of it.
    """
    way = parts[own].way_out(points, up)
    found: list[tuple[Array, Integers]] = [(way.copy(), np.full(len(points), own))]
    ended = np.zeros(len(points), bool)
    while not ended.all():
        top = points + ((1.0 + SEAM) * way)[:, None] * up
        more, where = np.zeros(len(points)), np.full(len(points), own)
        for number, part in enumerate(parts):
            inside = ~ended & (more == 0.0) & part.inside(top)
            more[inside], where[inside] = part.way_out(top[inside], up), number
        ended |= more == 0.0
        way += more
        found.append((more, where))
    return found


def head_below(ways: list[tuple[Array, Integers]], pull: float, liquids: Sequence[Material]) -> Array:
    """The enthalpy (N,) in J/kg below these heights of liquid. The pressure is continuous where one liquid ends and the
    other begins.
    """
    if all(liquid is liquids[0] for liquid in liquids):
        total = ways[0][0].copy()
        for way, _ in ways[1:]:
            total += way
        return pull * total
    return np.array(
        [column_head([(liquids[where[k]], float(way[k])) for way, where in ways], pull) for k in range(len(ways[0][0]))]
    )


def column_head(column: Sequence[tuple[Material, float]], pull: float) -> float:
    """The enthalpy below a column of liquids with their heights, from the lowest to the highest."""
    head, above = 0.0, column[-1][0]
    for liquid, way in reversed(column):
        if liquid is not above:
            pressure = tait_pressure(density_at_enthalpy(head, *above.laws), *above.laws)
            head = tait_enthalpy(tait_density(pressure, *liquid.laws), *liquid.laws)
        head, above = head + pull * way, liquid
    return head


def cells_of(scene: SphScene) -> list[tuple[Cells, Flags]]:
    """The lattice cells that the particles of each region represent, and flags of the particles of a table that are
    used (all, without a table).
    """
    found: list[tuple[Cells, Flags]] = []
    earlier: list[Part] = []
    solids = solids_of(scene)
    for index, region in enumerate(scene.fluid):
        shape = part_of(region, scene.spacing)
        if region.particles is None:
            cells = free_cells(shape, scene, earlier, solids)
            kept = np.ones(len(cells.centers), bool)
        else:
            cells = shape.cells(scene.spacing)
            kept = _kept(cells.centers, earlier, solids)
            cells = cells.those(kept)
        outside = ~room_of(scene, single=region.particles is not None).inside(cells.centers)
        if outside.any():
            where = tuple(float(f"{x:.4g}") for x in cells.centers[outside][0])
            raise SceneError([Fault(f"fluid[{index}]", f"reaches out of the tank, at {where}")])
        earlier.append(shape)
        found.append((cells, kept))
    return found


def room_of(scene: SphScene, *, single: bool) -> Box:
    """The box in which liquid may start: the tank, and for `single` particles of another run also the space outside its
    open sides.
    """
    tank = np.array([scene.tank.low, scene.tank.high])
    low, high = np.where(np.isfinite(bounds_of(scene)), bounds_of(scene), tank) if single else tank
    return Box(low, high)


ALIGNED = 1e-6
"""Tolerances in spacings: between a face and the next end of a cell, and between distances of symmetric cells."""


def free_cells(shape: Part, scene: SphScene, earlier: Sequence[Part], solids: Sequence[Shape]) -> Cells:
    """The cells of a region that neither earlier regions nor solids cover. The volume that solids cut off cells, and
    that of omitted cells too close to a solid, is distributed over all.
    """
    spacing = scene.spacing
    others = [other for other in (*earlier, *solids) if bounds_meet(shape, other)]
    cells = lattice_of(shape, spacing, others)
    if not others:
        return cells
    free = shape.volume() - covered_volume(shape, others)
    odd = unaligned(shape, cells, [solid for solid in solids if bounds_meet(shape, solid)], spacing)
    fitting = [solid for solid in solids if all(solid is not other for other in odd)]
    cells = cells.those(apart(cells.centers, earlier) & free_of(cells.centers, fitting, spacing))
    if not len(cells.centers):  # earlier regions cover this one
        return cells
    return scaled_to(cells.those(roomiest(cells, odd, free, scene.up_axis)) if odd else cells, free)


MOST_UNEVEN = 0.25
"""The largest relative difference of the edges of a cell in a lattice that ends at all faces."""


def lattice_of(part: Part, spacing: float, others: Sequence[Part]) -> Cells:
    """The lattice of a part of space, which ends at the faces of other parts unless its cells would become too
    uneven.
    """
    faces = [other.faces() for other in others]
    cells = part.cells(spacing, np.concatenate(faces) if faces else None)
    uneven = len(cells.widths) and (cells.widths.max(axis=1) / cells.widths.min(axis=1)).max() > 1.0 + MOST_UNEVEN
    return part.cells(spacing) if uneven and len(others) else cells


def roomiest(cells: Cells, solids: Sequence[Shape], volume: float, up: int) -> Flags:
    """Flags of the cells to use so that their total volume is nearest to `volume`: the cells farthest from the solids.
    Of cells at one height with equal distances, as in a symmetric scene, all or none are used.
    """
    gap, height, close = gaps_to(solids, cells.centers), cells.centers[:, up], ALIGNED * cells.widths.min()
    order = np.lexsort((height, np.round(gap / close)))
    left = cells.volumes.sum() - np.concatenate([[0.0], np.cumsum(cells.volumes[order])])
    alike = (np.abs(np.diff(gap[order])) < close) & (np.abs(np.diff(height[order])) < close)
    misfit = np.where(np.concatenate([[False], alike, [False]]), np.inf, np.abs(left - volume))
    kept = np.ones(len(gap), bool)
    kept[order[: int(np.argmin(misfit))]] = False
    return kept


def unaligned_solids(scene: SphScene) -> list[Shape]:
    """Solids to which the lattice of a region does not fit."""
    solids, found = solids_of(scene), dict[int, Shape]()
    for region in scene.fluid:
        part = part_of(region, scene.spacing)
        near = [solid for solid in solids if bounds_meet(part, solid)]
        if region.particles is None and near:
            cells = lattice_of(part, scene.spacing, near)
            found |= {id(solid): solid for solid in unaligned(part, cells, near, scene.spacing)}
    return list(found.values())


def unaligned(part: Part, cells: Cells, solids: Sequence[Shape], spacing: float) -> list[Shape]:
    """The solids that are not boxes, or boxes with faces at which no cell ends."""
    return [solid for solid in solids if not _fits(part, cells, solid, ALIGNED * spacing)]


def _fits(part: Part, cells: Cells, solid: Shape, close: float) -> bool:
    if not len(solid.faces()) or not len(part.faces()):
        return False
    low, high = part.bounds()
    for axis in range(len(low)):
        ends = (cells.centers - 0.5 * cells.widths)[:, axis]
        for face in solid.faces()[:, axis]:
            if low[axis] < face < high[axis] and float(np.abs(ends - face).min(initial=np.inf)) > close:
                return False
    return True


def _kept(points: Array, earlier: Sequence[Part], solids: Sequence[Shape]) -> Flags:
    """Flags of the single particles that are neither in other liquid nor inside a solid. Their distances from the
    particles of other tables and from solids may be arbitrarily small.
    """
    others = [part for part in earlier if not isinstance(part, Cloud)]
    return apart(points, others) & free_of(points, solids, 0.0)


def _particles(scene: SphScene, liquids: list[Material], pieces: list[tuple[Array, Array, Array, Array]]) -> Liquid:
    """The particles at points with known enthalpy (J/kg) and volume: densities and masses."""
    points, velocity, head, volume = (np.concatenate(parts) for parts in zip(*pieces, strict=True))
    if len(points) == 0:
        raise SceneError([Fault("spacing", f"got {scene.spacing:g} m: no particle fits into the liquid")])
    region = np.repeat(np.arange(len(pieces)), [len(piece[0]) for piece in pieces])
    laws = [each.laws for each in liquids]
    density = np.array([density_at_enthalpy(each, *laws[number]) for each, number in zip(head, region, strict=True)])
    mass = density * volume
    pressure = np.array([each.density for each in liquids])[region] * head
    return Liquid(np.ascontiguousarray(points.T), np.ascontiguousarray(velocity.T), density, pressure, mass, region)
