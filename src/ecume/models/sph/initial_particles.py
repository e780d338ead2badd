"""The liquid's particles at the start."""

from __future__ import annotations

import numpy as np

from ecume.engine.meshes import Cloud
from ecume.engine.shapes import Box, Flags, Part, Shape, apart, lattice_in
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
    pieces: list[tuple[Array, Array, Array]] = []
    earlier: list[Part] = []
    told: list[Said] = []
    solids = solids_of(scene)
    for index, region in enumerate(scene.fluid):
        shape = part_of(region, scene.spacing)
        given = region.particles
        points = lattice_in(shape, scene.spacing) if given is None else np.array(given.positions)
        kept = _kept(scene, points, earlier, solids, single=given is not None)
        points = points[kept]
        outside = ~room_of(scene, single=given is not None).inside(points)
        if outside.any():
            where = tuple(float(f"{x:.4g}") for x in points[outside][0])
            raise SceneError([Fault(f"fluid[{index}]", f"reaches out of the tank, at {where}")])
        earlier.append(shape)
        head = np.zeros(len(points))
        if pull.any() and scene.method.initial_pressure == "hydrostatic":
            head = np.linalg.norm(pull) * shape.way_out(points, -pull / np.linalg.norm(pull))
        if given is None:
            points = points + scene.method.jitter * scene.spacing * generator.uniform(-1.0, 1.0, points.shape)
        head += pressure_in(region, scene, points, material.density) / material.density
        pieces.append((points, velocity_in(region, scene, points), head))
        told.append(said_of(region, kept))
    return with_said(_particles(scene, material, pieces), told)


def room_of(scene: SphScene, *, single: bool) -> Box:
    """Where liquid may start: in the tank, and `single` particles, those of a run under way, beyond its open sides."""
    tank = np.array([scene.tank.low, scene.tank.high])
    low, high = np.where(np.isfinite(bounds_of(scene)), bounds_of(scene), tank) if single else tank
    return Box(low, high)


def _kept(scene: SphScene, points: Array, earlier: list[Part], solids: list[Shape], *, single: bool) -> Flags:
    """Who is neither where other liquid is nor too close to a solid. `single` particles keep the distances of the flow
    they were taken from, to those of other tables and to solids, however small.
    """
    others = [part for part in earlier if not (single and isinstance(part, Cloud))]
    return apart(points, others) & free_of(points, solids, 0.0 if single else scene.spacing)


def _particles(scene: SphScene, material: Material, pieces: list[tuple[Array, Array, Array]]) -> Liquid:
    """Densities and masses of points where the enthalpy (J/kg) is known."""
    points, velocity, head = (np.concatenate(parts) for parts in zip(*pieces, strict=True))
    if len(points) == 0:
        raise SceneError([Fault("spacing", f"came {scene.spacing:g} m: no particle fits into the liquid")])
    laws = material.density, material.sound_speed, material.exponent
    density = np.array([density_at_enthalpy(each, *laws) for each in head])
    mass = density * scene.spacing ** points.shape[1]
    region = np.repeat(np.arange(len(pieces)), [len(piece[0]) for piece in pieces])
    return Liquid(np.ascontiguousarray(points.T), np.ascontiguousarray(velocity.T), density, mass, region)
