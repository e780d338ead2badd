"""The game of a tank: liquid is poured and removed, gates open and close, a wall is pushed, the tank is tilted.

The model itself integrates the motion. A push is the motion of a side, a tilt is the acceleration of a shaken tank, and
an open gate is a removed obstacle, so that the game is always a scene, and can be saved.
"""

from __future__ import annotations

import dataclasses
import math
import time
from typing import Any, NamedTuple

import numpy as np
from scipy.spatial import cKDTree

from ecume.engine.shapes import Flags
from ecume.errors import BadInput, Diverged
from ecume.laws.water_waves import wave_frequency
from ecume.models import MODELS
from ecume.models.sph.parameters import Drive, Liquid, Material
from ecume.models.sph.setup.building import material_of
from ecume.models.sph.setup.choices import acoustic_damping_of, artificial_viscosity_of
from ecume.models.sph.setup.shapes import free_of, solids_of
from ecume.models.sph.state import make_state
from ecume.scenes.sph import (
    BaseExcitationSpec,
    GaugeSpec,
    MotionSpec,
    ObstacleSpec,
    ParticlesSpec,
    RegionSpec,
    SphScene,
)
from ecume.show.play.tank_steps import PIECES, tilted
from ecume.simulation import Integration
from ecume.units import Array

MOST = 3000
"""Largest number of particles: with more the motion is too slow to watch."""
ROOM = 0.8
"""The smallest distance of new liquid from existing liquid, in spacings."""
KINDS = ("wall", "open", "periodic")


class Push(NamedTuple):
    """The path of the left wall: linear between given times."""

    times: tuple[float, ...] = (0.0,)
    places: tuple[float, ...] = (0.0,)
    speed: float = 0.0
    """m/s, at the end"""

    def at(self, now: float) -> float:
        """The displacement of the wall (m)."""
        return float(np.interp(now, self.times, self.places))

    def then(self, now: float, seconds: float, speed: float, since: float) -> Push:
        """Append a constant acceleration to another speed; rows before `since` are removed. The last row extends the
        motion beyond the end.
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
    """Raise BadInput for scenes that the game cannot simulate."""
    if scene.model != "sph" or len(scene.tank.low) != 2:
        raise BadInput("play supports tanks in 2D; expected a 2D scene of model 'sph'")
    sides = [getattr(scene.tank, name) for name in ("left", "right", "bottom", "top")]
    present = {
        "bodies": bool(scene.bodies),
        "[second_liquid]": scene.second_liquid is not None,
        "incompressible liquids": scene.method.pressure != "tait",
        "[[passive_tracers]]": bool(scene.passive_tracers),
        "[base_excitation]": scene.base_excitation is not None,
        "[roll]": scene.roll is not None,
        "[central_force]": scene.central_force is not None,
        "sides that move": any(side.motion is not None for side in sides),
        "in- or outflows": any(side.kind not in KINDS for side in sides),
    }
    there = [name for name, is_there in present.items() if is_there]
    if there:
        raise BadInput(f"play supports tanks of liquid only; this one has {' and '.join(there)}")


def fixed(scene: SphScene) -> SphScene:
    """The scene with given speed of sound and artificial damping, so that poured liquid and pushes do not change
    them.
    """
    material = material_of(scene)
    liquid = dataclasses.replace(scene.liquid, sound_speed=material.sound_speed, maximum_speed=material.fastest)
    method = dataclasses.replace(
        scene.method, artificial_viscosity=artificial_viscosity_of(scene), acoustic_damping=acoustic_damping_of(scene)
    )
    return dataclasses.replace(scene, liquid=liquid, method=method)


def with_hands(scene: SphScene, pushed: float, more: tuple[float, float]) -> SphScene:
    """The scene with the left wall displaced inwards (m) and an additional acceleration (m/s^2)."""
    left = dataclasses.replace(scene.tank.left, motion=MotionSpec(times=(0.0,), positions=(pushed,)))
    tank = dataclasses.replace(scene.tank, left=left) if movable(scene) else scene.tank
    return dataclasses.replace(
        scene, tank=tank, base_excitation=BaseExcitationSpec(times=(0.0,), accelerations=(more,))
    )


def left_end(gauge: GaugeSpec) -> float:
    """The least x of a gauge (m)."""
    return min(float(place[0]) for place in (gauge.position, gauge.end) if place is not None)


def movable(scene: SphScene) -> bool:
    """Whether the left wall can be pushed."""
    return scene.tank.left.kind == "wall" and scene.tank.walls == "mirror"


def tilting(scene: SphScene, angle: float) -> tuple[float, float]:
    """The additional acceleration in a tilted tank (m/s^2)."""
    x, y = scene.gravity or (0.0, 0.0)
    return tilted(x, y, angle)


def poured(scene: SphScene, material: Material, points: Array) -> Liquid:
    """Liquid at rest at some points (n, 2), as a separate region."""
    count = len(points)
    mass = np.full(count, material.density * scene.spacing**2)
    region = np.full(count, len(scene.fluid), np.int64)
    density = np.full(count, material.density)
    return Liquid(points.T.copy(), np.zeros((2, count)), density, np.zeros(count), mass, region)


def joined(first: Liquid, second: Liquid) -> Liquid:
    """Both parts of the liquid."""
    parts: Any = zip(first, second, strict=True)
    return Liquid(*(np.concatenate(both, axis=-1) for both in parts))


def those(liquid: Liquid, which: Flags) -> Liquid:
    """A part of the liquid."""
    parts: Any = liquid
    return Liquid(*(np.ascontiguousarray(part[..., which]) for part in parts))


def room_around(scene: SphScene, place: tuple[float, float], reach: float, pushed: float, taken: Array) -> Array:
    """(n, 2) free lattice positions around a point (m), outside of liquid and solids."""
    steps = int(reach)
    across = np.arange(-steps, steps + 1) * scene.spacing
    points = np.array([(place[0] + dx, place[1] + dy) for dx in across for dy in across])
    near = np.hypot(*(points - np.array(place)).T) <= reach * scene.spacing
    return with_room(scene, points[near], pushed, taken)


def with_room(scene: SphScene, points: Array, pushed: float, taken: Array) -> Array:
    """The positions (n, 2) that are in the tank and free of solids and liquid."""
    spacing = scene.spacing
    low, high = np.array([scene.tank.low[0] + pushed, scene.tank.low[1]]), np.array(scene.tank.high)
    inside = ((points > low + 0.5 * spacing) & (points < high - 0.5 * spacing)).all(axis=1)
    points = points[inside & free_of(points, solids_of(scene), 2.0 * spacing)]
    free: Array = points[cKDTree(taken).query(points)[0] > ROOM * spacing]
    return free


def pushed_aside(scene: SphScene, liquid: Liquid, pushed: float, rest: float) -> Liquid:
    """The liquid after moving particles inside solids to the nearest free positions, the highest first, at rest and
    with the density at rest (kg/m^3). Mass is conserved. Raises BadInput without free positions.
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
    """The liquid as tables of particles, one for each region that still has particles."""
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


LONGEST = 0.05
"""s of simulated time at once: a machine that is too slow plays in slow motion, and is not hurried."""
BUDGET = 0.04
"""Seconds of wall time per batch: pages need several updates per second."""
JET = 2.5
"""The radius of poured liquid in spacings."""
LADLE = 4.0
"""The radius of removed liquid in spacings."""
GRASP = 0.15
"""The time (s) in which the wall would reach the pointer, the tank its tilt, and a wall its highest speed."""
PUSHED, STROKE = 0.25, 0.1
"""The largest displacement of a wall, and that of a wave, over the tank's width."""
HURRY = 0.3
"""The largest speed of a wall over the maximum speed of the scene."""
STEEPEST = math.radians(20.0)
"""The largest tilt of a tank."""
STILL = 1e-5
"""The angle (rad) from its tilt within which a tank has reached it, and the displacement of its wall, over its width,
within which that is back: what is put back does not stay a little off for ever.
"""
SOON = 0.2
"""s after which liquid that was calmed and breaks again is not worth keeping."""
CALMED = "The liquid went too fast for its time step: it was brought to rest where it stood."
ANEW = "The liquid could not be brought to rest: the tank was restarted."


class Tank:
    """An open tank. Its scene and state change only during calls."""

    def __init__(self, scene: SphScene) -> None:
        require_playable(scene)
        self.first, self.time, self.news = fixed(scene), 0.0, list[str]()
        self.begin_again()

    def begin_again(self) -> None:
        """Restart with the initial liquid and obstacles."""
        self.aim, self.tilt, self.leaning = 0.0, 0.0, 0.0
        self.wave_since, self.calmed = -math.inf, -math.inf
        self._begin(self.first, Push(), None)

    @property
    def count(self) -> int:
        """The number of particles."""
        return int(self.integration.state.position.shape[1])

    @property
    def pushed(self) -> float:
        """The displacement of the left wall (m)."""
        return self.push.at(self._now)

    def play(self, seconds: float) -> None:
        """Advance by a simulated time, at most `LONGEST`, or as far as `BUDGET` allows. A diverged state is reset to
        rest.
        """
        step = self.integration.parameters.time_step
        steps = max(1, round(min(seconds, LONGEST) / step))
        self._take_hands(steps * step)
        kept, before = self.liquid(), self._step
        try:
            self._integrate(before + steps)
            self.time += (self._step - before) * step
        except Diverged:
            self._calm(kept)

    def pour(self, x: float, y: float) -> None:
        """Add liquid at a position (m) as far as there is free space. Raises BadInput without free space."""
        liquid = self.liquid()
        points = room_around(self.scene, (x, y), JET, self.pushed, liquid.position.T)
        if not len(points):
            raise BadInput("no room for liquid here")
        if self.count + len(points) > MOST:
            raise BadInput(f"the tank has {self.count} particles; expected at most {MOST}; scoop out some liquid")
        self._go_on(joined(liquid, poured(self.scene, self.integration.parameters.material, points)))

    def scoop(self, x: float, y: float) -> None:
        """Remove the liquid around a position (m). Raises BadInput if there would be no liquid to remove, or none would
        remain.
        """
        liquid = self.liquid()
        stays = np.hypot(*(liquid.position - np.array([[x], [y]]))) > LADLE * self.scene.spacing
        if stays.all():
            raise BadInput("no liquid here")
        if not stays.any():
            raise BadInput("the last of it stays")
        self._go_on(those(liquid, stays))

    def open_gate(self) -> None:
        """Remove the first obstacle; hollow obstacles are basins, and not gates. Raises BadInput without obstacles."""
        if all(solid.hollow for solid in self.scene.obstacles):
            raise BadInput("no gate to open")
        opened = dataclasses.replace(self.scene, obstacles=self._obstacles(self.opened + 1))
        self._begin(opened, Push(places=(self.pushed,)), self.liquid())

    @property
    def opened(self) -> int:
        """The number of open gates."""
        return len(self.first.obstacles) - len(self.scene.obstacles)

    def _obstacles(self, opened: int) -> tuple[ObstacleSpec, ...]:
        """The obstacles while this number of gates is open."""
        gates = [number for number, solid in enumerate(self.first.obstacles) if not solid.hollow]
        return tuple(solid for number, solid in enumerate(self.first.obstacles) if number not in gates[:opened])

    def close_gate(self) -> None:
        """Restore the obstacle that was removed last and displace the liquid there. Raises BadInput without an open
        gate, or without space for the liquid.
        """
        if not self.opened:
            raise BadInput("no gate to close")
        closed = dataclasses.replace(self.scene, obstacles=self._obstacles(self.opened - 1))
        rest = self.integration.parameters.material.density
        self._begin(closed, Push(places=(self.pushed,)), pushed_aside(closed, self.liquid(), self.pushed, rest))

    def drag(self, x: float) -> None:
        """Move the left wall toward a pointer at this position (m)."""
        self._require_movable()
        self.aim = min(max(x - self.scene.tank.low[0], 0.0), PUSHED * self.width)
        self.wave_since = -math.inf

    def wave(self) -> None:
        """Push the left wall back and forth once, in one sloshing period of the liquid."""
        self._require_movable()
        self.aim, self.wave_since = 0.0, self.time

    def lean(self, angle: float) -> None:
        """Tilt the tank to this angle (rad); a positive angle lowers its right side."""
        self.tilt = min(max(angle, -STEEPEST), STEEPEST)

    def present(self) -> SphScene:
        """The present scene, from which a simulation can continue, without actions of the player."""
        tank, scene = self.scene.tank, self.scene
        if abs(self.pushed) > STILL * self.width:
            left = tank.low[0] + self.pushed
            scene = dataclasses.replace(
                scene,
                tank=dataclasses.replace(tank, low=(left, *tank.low[1:])),
                gauges=tuple(gauge for gauge in scene.gauges if left_end(gauge) >= left),  # no gauge in the wall
            )
        if self.leaning != 0.0:
            excitation = BaseExcitationSpec(times=(0.0,), accelerations=(self._pull,))
            scene = dataclasses.replace(scene, base_excitation=excitation)
        return dataclasses.replace(scene, fluid=regions_of(self.scene, self.liquid()))

    def liquid(self) -> Liquid:
        """The particles at present, in the order of their numbers."""
        state = self.integration.state
        order = np.argsort(state.identity)
        return Liquid(*(np.ascontiguousarray(getattr(state, name)[..., order]) for name in Liquid._fields))

    @property
    def width(self) -> float:
        """The width of the tank (m)."""
        return float(self.scene.tank.high[0] - self.scene.tank.low[0])

    @property
    def period(self) -> float:
        """The period of sloshing of the liquid with a level surface (s)."""
        depth = float(np.sum(self.integration.state.mass)) / self.integration.parameters.material.density / self.width
        pull = math.hypot(*(self.scene.gravity or ()))
        return 2.0 * math.pi / max(wave_frequency(math.pi / self.width, depth, pull), 1e-9)

    def _begin(self, scene: SphScene, push: Push, liquid: Liquid | None) -> None:
        """Continue with another scene; by default with its initial liquid."""
        model = MODELS["sph"]
        parameters = model.parameters(with_hands(scene, push.at(0.0), (0.0, 0.0)))
        state = model.start(scene, parameters) if liquid is None else make_state(parameters, liquid)
        self.scene, self.push = scene, push
        self.integration = Integration(model, parameters, state, BUDGET / 4.0)

    def _go_on(self, liquid: Liquid) -> None:
        """Continue with other particles."""
        self.push, parameters = Push(places=(self.pushed,)), self.integration.parameters
        self._drive()
        self.integration = Integration(
            self.integration.model, self.integration.parameters, make_state(parameters, liquid), BUDGET / 4.0
        )

    def _integrate(self, end: int) -> None:
        """Integrate step by step, as long as the time budget permits."""
        began = time.perf_counter()
        while self._step < end and time.perf_counter() - began < BUDGET:
            self.integration.go(end - self._step)

    def _calm(self, kept: Liquid) -> None:
        """Bring the liquid to rest in its last valid state, or restart if that was not successful just before."""
        if self.time - self.calmed < SOON:
            self.begin_again()
            self.news.append(ANEW)
            return
        self.calmed = self.time
        self._go_on(kept._replace(velocity=np.zeros_like(kept.velocity)))
        self.news.append(CALMED)

    def _take_hands(self, seconds: float) -> None:
        """Move wall and tilt toward their targets during a time."""
        now = self._now
        way = self.tilt - self.leaning
        self.leaning = self.tilt if abs(way) < STILL else self.leaning + min(1.0, seconds / GRASP) * way
        fastest = HURRY * self.integration.parameters.material.fastest
        target_speed = min(max((self._target - self.pushed) / GRASP, -fastest), fastest)
        more = fastest * seconds / GRASP
        speed = min(max(target_speed, self.push.speed - more), self.push.speed + more)
        self.push = self.push.then(now, seconds, speed, min(float(self.integration.state.clock[1]), now))
        self._drive()

    @property
    def _target(self) -> float:
        """The target position of the wall (m): that of the pointer, or of the wave."""
        phase = (self.time + GRASP - self.wave_since) / self.period
        if phase > 1.0:
            return self.aim
        return 0.5 * STROKE * self.width * (1.0 - math.cos(2.0 * math.pi * phase))

    def _drive(self) -> None:
        """Set the parameters that depend on the player's actions."""
        parameters = self.integration.parameters
        tilt = Drive(np.zeros(1), 0.0, 0.0, 0.0, np.zeros(1), np.array(self._pull)[:, None])
        drives = tuple((side, self.push.drive()) for side, _ in parameters.drives)
        self.integration.parameters = parameters._replace(drives=drives, base_excitation=tilt)

    @property
    def _pull(self) -> tuple[float, float]:
        return tilting(self.scene, self.leaning)

    @property
    def _step(self) -> int:
        return int(self.integration.state.step[0])

    @property
    def _now(self) -> float:
        return float(self.integration.state.clock[0])

    def _require_movable(self) -> None:
        if not movable(self.scene):
            raise BadInput("the left side of this tank is not a movable wall")
