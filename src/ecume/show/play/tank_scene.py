"""Scenes of tanks that can be played with, and what a user adds to them: liquid, a pushed wall, a tilt."""

from __future__ import annotations

import dataclasses
import math
from typing import Any, NamedTuple

import numpy as np
from scipy.spatial import cKDTree

from ecume.engine.shapes import Flags
from ecume.errors import BadInput
from ecume.models.sph.parameters import Drive, Liquid, Material
from ecume.models.sph.setup.building import material_of
from ecume.models.sph.setup.shapes import free_of, solids_of
from ecume.scenes.sph import BaseExcitationSpec, MotionSpec, ParticlesSpec, RegionSpec, SphScene
from ecume.units import Array

MOST = 3000
"""Largest number of particles: with more the motion is too slow to watch."""
ROOM = 0.8
"""How near to the liquid that is there new liquid may begin, in spacings."""
PIECES = 8
"""Straight lines between two looks at the hand: jumps of a wall's speed are bangs in the liquid."""
KINDS = ("wall", "open", "periodic")


class Push(NamedTuple):
    """The path of the left wall: straight lines from time to time."""

    times: tuple[float, ...] = (0.0,)
    places: tuple[float, ...] = (0.0,)
    speed: float = 0.0
    """m/s, at the end"""

    def at(self, now: float) -> float:
        """The displacement of the wall (m)."""
        return float(np.interp(now, self.times, self.places))

    def then(self, now: float, seconds: float, speed: float, since: float) -> Push:
        """Append a constant acceleration to another speed; rows before `since` are dropped. The last row extends beyond
        the end: there the wall still moves.
        """
        kept = [pair for pair in zip(self.times, self.places, strict=True) if since < pair[0] < now]
        passed = seconds * np.arange(PIECES + 1) / PIECES
        way = self.speed * passed + 0.5 * (speed - self.speed) * passed**2 / seconds
        ahead = list(zip((now + passed).tolist(), (self.at(now) + way).tolist(), strict=True))
        beyond = (now + 2.0 * seconds, ahead[-1][1] + speed * seconds)
        times, places = zip((since, self.at(since)), *kept, *ahead, beyond, strict=True)
        return Push(times[since == now :], places[since == now :], speed)

    def drive(self) -> Drive:
        """The path in the form that the model reads."""
        return Drive(np.zeros(1), 0.0, 0.0, 0.0, np.array(self.times), np.array([self.places]))


def require_playable(scene: SphScene) -> None:
    """Raises BadInput for what is no tank to play with."""
    if scene.model != "sph" or len(scene.tank.low) != 2:
        raise BadInput("play supports tanks in 2D; expected a 2D scene of model 'sph'")
    sides = [getattr(scene.tank, name) for name in ("left", "right", "bottom", "top")]
    present = {
        "bodies": bool(scene.bodies),
        "incompressible liquids": scene.method.pressure != "tait",
        "[[passive_tracers]]": bool(scene.passive_tracers),
        "[base_excitation]": scene.base_excitation is not None,
        "[central_force]": scene.central_force is not None,
        "sides that move": any(side.motion is not None for side in sides),
        "in- or outflows": any(side.kind not in KINDS for side in sides),
    }
    there = [name for name, is_there in present.items() if is_there]
    if there:
        raise BadInput(f"play supports tanks of liquid only; this one has {' and '.join(there)}")


def fixed(scene: SphScene) -> SphScene:
    """The scene with its numerical speed of sound written down: it must not follow from what is poured later."""
    material = material_of(scene)
    liquid = dataclasses.replace(scene.liquid, sound_speed=material.sound_speed, maximum_speed=material.fastest)
    return dataclasses.replace(scene, liquid=liquid)


def with_hands(scene: SphScene, pushed: float, more: tuple[float, float]) -> SphScene:
    """The scene with a left wall that stands so far inwards (m), and so much pull beside gravity (m/s^2)."""
    left = dataclasses.replace(scene.tank.left, motion=MotionSpec(times=(0.0,), positions=(pushed,)))
    tank = dataclasses.replace(scene.tank, left=left) if movable(scene) else scene.tank
    return dataclasses.replace(
        scene, tank=tank, base_excitation=BaseExcitationSpec(times=(0.0,), accelerations=(more,))
    )


def movable(scene: SphScene) -> bool:
    """Whether the left wall can be pushed."""
    return scene.tank.left.kind == "wall" and scene.tank.walls == "mirror"


def tilting(scene: SphScene, angle: float) -> tuple[float, float]:
    """The acceleration in a tilted tank beside gravity (m/s^2): gravity, rotated, minus gravity."""
    x, y = scene.gravity or (0.0, 0.0)
    cosine, sine = math.cos(angle), math.sin(angle)
    return x * (cosine - 1.0) - y * sine, x * sine + y * (cosine - 1.0)


def poured(scene: SphScene, material: Material, points: Array) -> Liquid:
    """Liquid at rest at some points (n, 2), as a separate region."""
    count = len(points)
    mass = np.full(count, material.density * scene.spacing**2)
    region = np.full(count, len(scene.fluid), np.int64)
    density = np.full(count, material.density)
    return Liquid(points.T.copy(), np.zeros((2, count)), density, np.zeros(count), mass, region)


def joined(first: Liquid, second: Liquid) -> Liquid:
    """One after the other."""
    parts: Any = zip(first, second, strict=True)
    return Liquid(*(np.concatenate(both, axis=-1) for both in parts))


def those(liquid: Liquid, which: Flags) -> Liquid:
    """Some of it."""
    parts: Any = liquid
    return Liquid(*(np.ascontiguousarray(part[..., which]) for part in parts))


def room_around(scene: SphScene, place: tuple[float, float], reach: float, pushed: float, taken: Array) -> Array:
    """(n, 2) places for liquid on a lattice around a place (m), where there is neither liquid nor a solid."""
    steps = int(reach)
    across = np.arange(-steps, steps + 1) * scene.spacing
    points = np.array([(place[0] + dx, place[1] + dy) for dx in across for dy in across])
    near = np.hypot(*(points - np.array(place)).T) <= reach * scene.spacing
    return with_room(scene, points[near], pushed, taken)


def with_room(scene: SphScene, points: Array, pushed: float, taken: Array) -> Array:
    """The places (n, 2) that are in the tank, free of solids and of liquid."""
    spacing = scene.spacing
    low, high = np.array([scene.tank.low[0] + pushed, scene.tank.low[1]]), np.array(scene.tank.high)
    inside = ((points > low + 0.5 * spacing) & (points < high - 0.5 * spacing)).all(axis=1)
    points = points[inside & free_of(points, solids_of(scene), 2.0 * spacing)]
    free: Array = points[cKDTree(taken).query(points)[0] > ROOM * spacing]
    return free


def pushed_aside(scene: SphScene, liquid: Liquid, pushed: float, rest: float) -> Liquid:
    """The liquid without anything in solids: who stands there goes to the nearest place with room, the highest first,
    and stands still there at the density of rest (kg/m^3). Its mass stays. Raises BadInput where there is no such room.
    """
    within = np.flatnonzero(~free_of(liquid.position.T, solids_of(scene), scene.spacing))
    within = within[np.argsort(-liquid.position[1, within], kind="stable")]
    outside = np.delete(liquid.position, within, axis=1)
    low, high = scene.tank.low, scene.tank.high
    axes = [np.arange(a + 0.5 * scene.spacing, b, scene.spacing) for a, b in zip(low, high, strict=True)]
    places = with_room(scene, np.stack(np.meshgrid(*axes), axis=-1).reshape(-1, 2), pushed, outside.T)
    if len(places) < len(within):
        raise BadInput("the liquid at the gate has no room; scoop out some liquid")
    position, velocity, density = liquid.position.copy(), liquid.velocity.copy(), liquid.density.copy()
    velocity[:, within], density[within] = 0.0, rest
    for one in within:
        nearest = int(np.argmin(((places - position[:, one]) ** 2).sum(axis=1)))
        position[:, one] = places[nearest]
        places = np.delete(places, nearest, axis=0)
    return liquid._replace(position=position, velocity=velocity, density=density)


def regions_of(scene: SphScene, liquid: Liquid) -> tuple[RegionSpec, ...]:
    """The liquid as tables of particles, one for each region that has some left."""
    colors = dict(enumerate(region.color for region in scene.fluid))
    numbers = np.unique(liquid.region).tolist()
    return tuple(_region(those(liquid, liquid.region == number), colors.get(number)) for number in numbers)


def _region(liquid: Liquid, color: str | None) -> RegionSpec:
    particles = ParticlesSpec(
        positions=tuple(map(tuple, liquid.position.T.tolist())),
        velocities=tuple(map(tuple, liquid.velocity.T.tolist())),
        densities=tuple(liquid.density.tolist()),
        masses=tuple(liquid.mass.tolist()),
    )
    return RegionSpec(particles=particles, color=color)
