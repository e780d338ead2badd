"""The game of a bowl: floats are dropped, dragged and removed, the dish is tilted, the liquid is changed.

Every change of the floats or of the liquid creates a new scene that starts from the present state, so that the game is
always a scene, and can be saved. The model itself integrates the motion.

In a tilted dish the liquid sloshes: the surface oscillates about the level with the frequency of its first mode. In the
middle of the dish, where the mode is plane, the liquid flows with u = s' g / omega^2, where s is the slope of the
surface relative to the dish. This follows from dh/dt = phi_z and u = phi_x of the potential J1(k r) cos(phi) cosh(k (z
+ H)) [lamb1932, art. 191]. The current carries the floats.
"""

from __future__ import annotations

import dataclasses
import math
import re
import warnings
from collections.abc import Sequence
from typing import Any, NamedTuple

import numpy as np

from ecume.engine.walls import rings
from ecume.errors import BadInput, Diverged, SceneError
from ecume.laws.water_waves import wave_frequency
from ecume.models import MODELS
from ecume.models.floating.dishes import sloshing_wavenumber, walls_of
from ecume.models.liquids import liquid_of
from ecume.scenes.floating import FloatingScene, FloatSpec
from ecume.simulation import Integration
from ecume.trajectories.frame import Frame
from ecume.units import Array

DEPTH = 0.02
"""The depth of the liquid (m), which scenes of floats do not specify."""
DAMPING = 0.08
"""The damping ratio of sloshing, as observed in bowls of some centimeters."""


class Slosh(NamedTuple):
    """The slopes of the surface relative to the dish along x and y, and their rates (1/s)."""

    slope: tuple[float, float] = (0.0, 0.0)
    rate: tuple[float, float] = (0.0, 0.0)


def slosh_frequency(scene: FloatingScene) -> float:
    """The angular frequency of the first sloshing mode (1/s)."""
    liquid = liquid_of(scene)
    dish: Any = scene.dish  # games require a dish
    tension = liquid.surface_tension / liquid.density
    return float(wave_frequency(sloshing_wavenumber(dish), DEPTH, liquid.gravity, tension))


def swung(slosh: Slosh, tilt: tuple[float, float], scene: FloatingScene, seconds: float) -> Slosh:
    """The exact state of sloshing after a time under a constant small tilt (rad)."""
    omega = slosh_frequency(scene)
    both = [swung_along(s, v, aim, omega, seconds) for s, v, aim in zip(slosh.slope, slosh.rate, tilt, strict=True)]
    return Slosh((both[0][0], both[1][0]), (both[0][1], both[1][1]))


def swung_along(slope: float, rate: float, aim: float, omega: float, seconds: float) -> tuple[float, float]:
    """The slope along one axis, and its rate: S'' = -omega^2 (s - aim) - 2 zeta omega s', solved over the time."""
    decay, swing = DAMPING * omega, omega * math.sqrt(1.0 - DAMPING**2)
    away = slope - aim
    along = (rate + decay * away) / swing
    fade, c, s = math.exp(-decay * seconds), math.cos(swing * seconds), math.sin(swing * seconds)
    later = fade * (away * c + along * s)
    return aim + later, -decay * later + fade * swing * (along * c - away * s)


def current(slosh: Slosh, scene: FloatingScene) -> tuple[float, float]:
    """The velocity of the liquid in the middle of the dish (m/s)."""
    per_rate = scene.gravity / slosh_frequency(scene) ** 2
    return slosh.rate[0] * per_rate, slosh.rate[1] * per_rate


STEEPEST_DISH = 0.2
"""The largest tilt of a dish (rad)."""
FASTEST = 0.15
"""m/s: a hand drags no faster, and throws no faster."""
GRASP = 0.05
"""The time (s) in which a dragged float would reach the pointer."""
LONGEST = 0.1
"""s of simulated time at once: a machine that is too slow plays in slow motion, and is not hurried."""
ROOM = 1.02
"""The smallest distance of centers from a new float, in sums of radii."""
SOON = 0.2
"""s after which floats that were brought to rest and diverge again are put back to where the last change left them."""
CALMED = "The floats went too fast for their time step: they were brought to rest where they were."
PUT_BACK = "The floats could not be brought to rest: they are back where the last change left them."
TRIES = 60
"""The number of positions tried around the requested one."""

SHELF: dict[str, dict[str, Any]] = {
    "cereal": {"radius": 1.5e-3, "density": 300.0, "contact_angle": math.radians(70.0), "color": "#f5deb3"},
    "bead": {"radius": 1.2e-3, "density": 1250.0, "contact_angle": math.radians(95.0), "color": "#b2182b"},
    "bubble": {"radius": 1.8e-3, "density": 40.0, "contact_angle": math.radians(25.0), "color": "#a6d8f0"},
}
"""Species that can be added to any bowl: light floats rise at the wall, heavy ones move away from it."""


CHANGED = ("surface_tension", "viscosity", "density", "contact_angle", "radius")
"""Numbers that can be changed while one plays."""


class Hand(NamedTuple):
    """A dragged float, and the position of the pointer (m)."""

    one: int
    x: float
    y: float


class Bowl:
    """An open bowl. Its scene and state only change during calls."""

    def __init__(self, scene: FloatingScene) -> None:
        if scene.model != "floating" or scene.dish is None:
            raise BadInput("expected a scene of model 'floating' with a [dish]")
        if scene.dish.barrier is not None:
            raise BadInput("got a dish with a barrier; expected sides at rest: a game starts its scene at each change")
        if scene.dish.tilt is not None:
            raise BadInput("got a tilted dish; expected no dish.tilt: a game tilts the dish itself, and it sloshes")
        if scene.dish.inner_radius is not None:
            raise BadInput("got a ring; expected a dish without an inner wall: liquid sloshes around it, not across")
        self.hand: Hand | None = None
        self.slosh, self.tilt = Slosh(), (0.0, 0.0)
        self.time, self.calmed, self.news = 0.0, -math.inf, list[str]()
        self._begin(scene)
        self.first = self.scene

    @property
    def dish(self) -> Any:
        """The wall around them."""
        return self.scene.dish

    @property
    def frame(self) -> Frame:
        """The present frame."""
        return self.integration.observe()

    def play(self, seconds: float) -> None:
        """Advance by a simulated time, at most `LONGEST`. A diverged state is reset to rest at its previous
        positions.
        """
        step = self.integration.parameters.time_step
        steps = max(1, round(min(seconds, LONGEST) / step))
        kept = self.integration.state.position.copy()
        self.slosh = swung(self.slosh, self.tilt, self.scene, steps * step)
        self._flow[:2] = self._own + current(self.slosh, self.scene)
        self._drag()
        try:
            end = int(self.integration.state.step[0]) + steps
            while (left := end - int(self.integration.state.step[0])) > 0:
                self.integration.go(left)
            self.time += steps * step
        except Diverged:
            self._calm(kept)

    def grasp(self, one: int, x: float, y: float) -> None:
        """Drag a float toward a position. Raises BadInput if no float has this number."""
        if not 0 <= one < len(self.integration.state.position):
            raise BadInput(f"there is no float {one}")
        self.hand = Hand(one, x, y)

    def release(self) -> None:
        """Release the dragged float, which keeps its velocity."""
        self.hand = None

    def drop(self, name: str, x: float, y: float) -> None:
        """Add a float of a species of the bowl or of `SHELF` near a position (m)."""
        scene = self.present()
        known = {species.name: index for index, species in enumerate(scene.particles)}
        if name not in known and name not in SHELF:
            raise BadInput(f"there is no {name!r} to drop; expected one of {', '.join({**known, **SHELF})}")
        taken = known.get(name)
        radius = scene.particles[taken].radius if taken is not None else SHELF[name]["radius"]
        place = self._room_near(x, y, radius)
        if taken is None:
            new = FloatSpec(name=name, positions=(place,), **SHELF[name])
            self._begin(dataclasses.replace(scene, particles=(*scene.particles, new)))
            return
        old = scene.particles[taken]
        more = dataclasses.replace(
            old, count=old.count + 1, positions=(*old.positions, place), velocities=(*old.velocities, (0.0, 0.0))
        )
        self._begin(_with(scene, taken, more))

    def take(self, one: int) -> None:
        """Remove a float, except the last one."""
        frame, scene = self.frame, self.present()
        if not 0 <= one < len(frame.arrays["species"]):
            raise BadInput(f"there is no float {one}")
        if len(frame.arrays["species"]) == 1:
            raise BadInput("the last float cannot be removed")
        kind = int(frame.arrays["species"][one])
        within = int(np.count_nonzero(frame.arrays["species"][:one] == kind))
        old = scene.particles[kind]
        if old.count == 1:
            left = tuple(species for index, species in enumerate(scene.particles) if index != kind)
            self._begin(dataclasses.replace(scene, particles=left))
            return
        kept = [index for index in range(old.count) if index != within]
        fewer = dataclasses.replace(
            old,
            count=old.count - 1,
            positions=tuple(old.positions[index] for index in kept),
            velocities=tuple(old.velocities[index] for index in kept),
        )
        self._begin(_with(scene, kind, fewer))

    def begin_again(self) -> None:
        """Restart from the initial scene."""
        self.slosh, self.tilt, self.time, self.calmed = Slosh(), (0.0, 0.0), 0.0, -math.inf
        self._begin(self.first, fresh=True)

    def forces(self) -> Array:
        """The forces on the floats in the last step, (N, 2) N."""
        found: Array = self.integration.workspace.force
        return found

    def change(self, part: str, key: str, value: float) -> None:
        """Change a number of the `liquid` or the `dish`, or of a species by its name, such as its contact angle.

        Raises BadInput for invalid values, and if a float would sink; the bowl is then unchanged.
        """
        scene, number = self.present(), {key: value}
        names = [species.name for species in scene.particles]
        if part not in ("liquid", "dish", *names) or key not in CHANGED:
            raise BadInput(f"there is no {part}.{key} to change; expected liquid, dish, {', '.join(names)}")
        try:
            if part in names:
                place = names.index(part)
                changed = _with(scene, place, _replaced(scene.particles[place], number))
            else:
                changed = dataclasses.replace(scene, **{part: _replaced(getattr(scene, part), number)})
            self._begin(changed)
        except (TypeError, ValueError, SceneError) as fault:
            raise BadInput(f"{part}.{key} = {value:g}: {_warnings_in_plain_words(fault)}") from None

    def present(self) -> FloatingScene:
        """The present scene, from which a simulation can continue."""
        arrays = self.frame.arrays
        return placed(self.scene, arrays["position"], arrays["velocity"], arrays["species"])

    def _begin(self, scene: FloatingScene, *, fresh: bool = False) -> None:
        """Continue with another scene from the present positions; unless `fresh`, also with the present surfactant."""
        model, former = MODELS["floating"], None if fresh else getattr(self, "integration", None)
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")  # hide warnings on errors of superposition, which `ecume check` reports
            parameters = model.parameters(_with_throws(scene))
            state = model.start(_with_throws(scene), parameters)
        self._flow, self._own = parameters.drift.flow.copy(), parameters.drift.flow[:2].copy()
        drift = parameters.drift._replace(flow=self._flow, flows=True)
        given = [v for species in scene.particles for v in (species.velocities or [species.velocity] * species.count)]
        given += [(row.vx, row.vy) for row in scene.rows]
        state.velocity[:] = np.array(given).reshape(-1, 2)
        if former is not None:
            _keep_surfactant(former.state, state)
        self.scene, self.hand = placed(scene, state.position, state.velocity, parameters.floats.species), None
        self.integration, self.last = Integration(model, parameters._replace(drift=drift), state, LONGEST), self.scene

    def _calm(self, kept: Array) -> None:
        """Bring the floats to rest at their last positions, or, if that was not successful just before, at those of the
        last change.
        """
        again, last = self.time - self.calmed < SOON, self.last
        species = self.integration.parameters.floats.species
        self.slosh, self.calmed = Slosh(), self.time
        self._begin(_stilled(last) if again else placed(self.scene, kept, np.zeros_like(kept), species))
        self.last = last
        self.news.append(PUT_BACK if again else CALMED)

    def _drag(self) -> None:
        if self.hand is None:
            return
        state = self.integration.state
        way = (np.array([self.hand.x, self.hand.y]) - state.position[self.hand.one]) / GRASP
        state.velocity[self.hand.one] = way * min(1.0, FASTEST / max(float(np.hypot(*way)), 1e-300))

    def _room_near(self, x: float, y: float, radius: float) -> tuple[float, float]:
        """The nearest of some positions on a spiral at which a float of this radius touches no other float and no
        wall.
        """
        arrays = self.frame.arrays
        for number in range(TRIES):
            away, angle = 0.5 * radius * math.sqrt(number), 2.4 * number
            place = (x + away * math.cos(angle), y + away * math.sin(angle))
            apart = np.hypot(*(arrays["position"] - place).T)
            if _inside(self.scene.dish, place, radius) and (apart > ROOM * (arrays["radius"] + radius)).all():
                return place
        raise BadInput("no room here")


def _inside(dish: Any, place: tuple[float, float], radius: float) -> bool:
    return min(rings.clearances(walls_of(dish), place)) > ROOM * radius


def placed(scene: FloatingScene, position: Array, velocity: Array, species: Array) -> FloatingScene:
    """A scene whose floats have these positions and velocities; rows of one species become one table."""
    kinds = list(scene.kinds)
    made = []
    for index, kind in enumerate(kinds):
        here = species == index
        like = _like(scene, kind.name)
        places = tuple(map(tuple, position[here].tolist()))
        speeds = tuple(map(tuple, velocity[here].tolist()))
        made.append(
            dataclasses.replace(
                like,
                count=len(places),
                placement="random",
                spacing=None,
                ring_radius=None,
                center=None,
                color=kind.color,
                positions=places,
                velocities=speeds,
                velocity=(0.0, 0.0),
            )
        )
    return dataclasses.replace(scene, particles=tuple(made), rows=())


def _like(scene: FloatingScene, name: str) -> FloatSpec:
    """A table with the properties of the floats of a species."""
    for species in scene.particles:
        if species.name == name:
            return species
    row = next(row for row in scene.rows if row.species_name == name)
    others = [other for other in scene.rows if other.species_name == name]
    if any((other.radius, other.density) != (row.radius, row.density) for other in others):
        raise BadInput(f"floats of {name} differ among themselves; give each kind a different name")
    kept = ("radius", "density", "contact_angle", "surface_energies", "disc", "shape")
    what: dict[str, Any] = {key: getattr(row, key) for key in kept}
    return FloatSpec(name=name, **what)


def _stilled(scene: FloatingScene) -> FloatingScene:
    """The scene with all floats at rest, for a scene without rows."""
    rest = (dataclasses.replace(species, velocities=(), velocity=(0.0, 0.0)) for species in scene.particles)
    return dataclasses.replace(scene, particles=tuple(rest))


def _replaced(part: Any, number: dict[str, float]) -> Any:
    return dataclasses.replace(part, **number)


def _keep_surfactant(former: Any, state: Any) -> None:
    """Copy the surfactant of a state into another one, if both have one on the same grid."""
    there, here = (getattr(each, "concentration", None) for each in (former, state))
    if there is not None and here is not None and there.shape == here.shape:
        here[:], state.surfactant[:] = there, former.surfactant


def _with(scene: FloatingScene, place: int, species: FloatSpec) -> FloatingScene:
    return dataclasses.replace(scene, particles=(*scene.particles[:place], species, *scene.particles[place + 1 :]))


def _with_throws(scene: FloatingScene) -> FloatingScene:
    """The scene that determines the time step, in which a user may throw any float."""
    launched = [dataclasses.replace(species, velocities=(), velocity=(FASTEST, 0.0)) for species in scene.particles]
    integration = dataclasses.replace(scene.integration, time_step=None)
    return dataclasses.replace(scene, particles=tuple(launched), integration=integration)


SINKS = re.compile(r"an? (\w+) of [^;]*? sinks: [^;]*; take ")
"""The part of `FloaterSinks`'s message with dimensionless numbers, up to the remedy."""


def _warnings_in_plain_words(fault: Exception) -> str:
    """The warnings of the check of a scene, in one line without technical details."""
    if isinstance(fault, SceneError):
        messages = dict.fromkeys(one.message for one in fault.faults)
        return SINKS.sub(r"this \1 would sink; take ", "; ".join(messages))
    errors: Sequence[Any] = getattr(fault, "errors", list)()
    return "; ".join(str(error["msg"]) for error in errors) or str(fault)
