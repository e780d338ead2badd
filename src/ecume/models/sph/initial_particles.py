"""The liquid's particles at the start."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from ecume.engine.meshes import Cloud
from ecume.engine.shapes import Box, Cells, Flags, Part, Shape, apart, bounds_meet, covered_volume, scaled_to
from ecume.errors import Fault, SceneError
from ecume.laws.enthalpy import density_at_enthalpy
from ecume.models.sph.defaults import held_pull, modified
from ecume.models.sph.open_boundaries import bounds_of
from ecume.models.sph.parameters import Liquid, Material
from ecume.models.sph.solids import free_of, part_of, solids_of
from ecume.models.sph.starting import pressure_in, velocity_in
from ecume.models.sph.tables import Said, said_of, with_said
from ecume.scenes.sph import SphScene
from ecume.units import Array


def liquid_of(scene: SphScene, material: Material) -> Liquid:
    """The particles at the start, with the pressure of their depth."""
    pull = np.zeros(len(scene.tank.low)) if modified(scene) else held_pull(scene)
    generator = np.random.default_rng(scene.seed)
    pieces: list[tuple[Array, Array, Array, Array]] = []
    told: list[Said] = []
    for region, (cells, kept) in zip(scene.fluid, cells_of(scene), strict=True):
        points, shape = cells.centers, part_of(region, scene.spacing)
        head = np.zeros(len(points))
        if pull.any() and scene.method.start == "hydrostatic":
            head = np.linalg.norm(pull) * shape.way_out(points, -pull / np.linalg.norm(pull))
        if region.particles is None:
            points = points + scene.method.jitter * scene.spacing * generator.uniform(-1.0, 1.0, points.shape)
        head += pressure_in(region, scene, points, material.density) / material.density
        pieces.append((points, velocity_in(region, scene, points), head, cells.volumes))
        told.append(said_of(region, kept))
    return with_said(_particles(scene, material, pieces), told)


def cells_of(scene: SphScene) -> list[tuple[Cells, Flags]]:
    """The cells that each region's particles stand for, and which particles of a table were kept (all, without one)."""
    found: list[tuple[Cells, Flags]] = []
    earlier: list[Part] = []
    solids = solids_of(scene)
    for index, region in enumerate(scene.fluid):
        shape = part_of(region, scene.spacing)
        if region.particles is None:
            cells = free_cells(shape, scene.spacing, earlier, solids)
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
    """Where liquid may start: in the tank, and `single` particles, those of a run under way, beyond its open sides."""
    tank = np.array([scene.tank.low, scene.tank.high])
    low, high = np.where(np.isfinite(bounds_of(scene)), bounds_of(scene), tank) if single else tank
    return Box(low, high)


def free_cells(shape: Part, spacing: float, earlier: Sequence[Part], solids: Sequence[Shape]) -> Cells:
    """The cells of a region that neither earlier regions nor solids cover. Their volumes add up to that of the places
    they stand for: what a solid cuts off cells, or leaves of cells too close to it, is spread over all.
    """
    others = [other for other in (*earlier, *solids) if bounds_meet(shape, other)]
    faces = [other.faces() for other in others]
    cells = shape.cells(spacing, np.concatenate(faces) if faces else None)
    if not others:
        return cells
    free = shape.volume() - covered_volume(shape, others)
    return scaled_to(cells.those(apart(cells.centers, earlier) & free_of(cells.centers, solids, spacing)), free)


def _kept(points: Array, earlier: Sequence[Part], solids: Sequence[Shape]) -> Flags:
    """Which single particles are neither where other liquid is nor inside a solid. They keep the distances of the flow
    they were taken from, to those of other tables and to solids, however small.
    """
    others = [part for part in earlier if not isinstance(part, Cloud)]
    return apart(points, others) & free_of(points, solids, 0.0)


def _particles(scene: SphScene, material: Material, pieces: list[tuple[Array, Array, Array, Array]]) -> Liquid:
    """Densities and masses of points where the enthalpy (J/kg) and the volume are known."""
    points, velocity, head, volume = (np.concatenate(parts) for parts in zip(*pieces, strict=True))
    if len(points) == 0:
        raise SceneError([Fault("spacing", f"got {scene.spacing:g} m: no particle fits into the liquid")])
    laws = material.density, material.sound_speed, material.exponent
    density = np.array([density_at_enthalpy(each, *laws) for each in head])
    mass = density * volume
    region = np.repeat(np.arange(len(pieces)), [len(piece[0]) for piece in pieces])
    return Liquid(np.ascontiguousarray(points.T), np.ascontiguousarray(velocity.T), density, mass, region)
