"""Fitted parameters, their paths in a scene, and quantities derived from a scene.

The coordinate of a positive or negative parameter is the logarithm of its magnitude, that of an angle the logit, so
that a fit never leaves the physical range.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Mapping, Sequence
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from ecume.errors import BadInput
from ecume.models import MODELS
from ecume.models.liquids import liquid_of
from ecume.scenes.faults import Path, echo, read_path, suggestion, value_at, written
from ecume.scenes.overrides import KEY, put
from ecume.scenes.schema import ANGLE, unit_of

if TYPE_CHECKING:
    from ecume.scenes.floating import FloatingScene
    from ecume.scenes.schema import Scene
    from ecume.scenes.tracers import TracersScene

MOST = 20


class Free(NamedTuple):
    """One fitted parameter: its name, the paths in the scene that share it, and its initial value.

    For a vector, such as the `force` of soft spheres, the magnitude is fitted; directions and ratios between vectors
    are fixed.
    """

    name: str
    paths: tuple[Path, ...]
    value: float
    unit: str
    shares: tuple[float, ...] = ()
    """the numbers at the paths over the value; default: 1"""

    @property
    def angle(self) -> bool:
        """Whether the parameter is an angle between 0 and pi."""
        return self.paths[0][-1] == ANGLE

    def coordinate(self, value: float) -> float:
        """The coordinate of a value: ln |p|, for an angle ln(p/(pi - p)); the sign is fixed.

        >>> free = Free("x", (("liquid", "viscosity"),), 2.0, "Pa*s")
        >>> round(free.at(free.coordinate(2.0)), 12)
        2.0
        """
        return math.log(value / (math.pi - value)) if self.angle else math.log(abs(value))

    def at(self, coordinate: float) -> float:
        """The value of the parameter at a coordinate; finite even far outside the physical range."""
        bounded = min(max(coordinate, -300.0), 300.0)
        return math.pi / (1.0 + math.exp(-bounded)) if self.angle else math.copysign(math.exp(bounded), self.value)

    def steepness(self, value: float) -> float:
        """The derivative of ln(p) by the coordinate."""
        return 1.0 - value / math.pi if self.angle else 1.0


def free_parameters(plain: Mapping[str, Any], names: Sequence[str]) -> list[Free]:
    """The parameters with these names, or paths such as `particles[0].radius`. Raises BadInput for unknown ones."""
    count = len(names) if any(names) else 0
    if not 1 <= count <= MOST:
        raise BadInput(f"free: got {count} parameters; expected 1 to {MOST}, such as contact_angle,viscosity")
    found = [_free(plain, name) for name in names]
    places = [path for free in found for path in free.paths]
    twice = next((path for path in places if places.count(path) > 1), None)
    if twice is not None:
        raise BadInput(f"free: {written(twice)} is named twice")
    return found


def _free(plain: Mapping[str, Any], name: str) -> Free:
    there = KEY.fullmatch(name) is not None and value_at(plain, read_path(name), None) is not None
    paths = (read_path(name),) if there else tuple(_places(plain, name))
    if not paths:
        raise BadInput(f"free: the scene has no number {name!r}; {suggestion(name, sorted(_numbers(plain)))}")
    values = [value_at(plain, path, None) for path in paths]
    if all(map(_is_vector, values)):
        return _sized(plain, name, paths)
    if len(set(map(str, values))) > 1:
        raise BadInput(f"free: {name} has several values; choose one: {', '.join(map(written, paths))}")
    value = values[0]
    if not isinstance(value, float):
        raise BadInput(f"free: {name} got {echo(value)}; expected a parameter that is a number, and no whole one")
    if value == 0.0 or (paths[0][-1] == ANGLE and not 0.0 < value < math.pi):
        raise BadInput(f"free: {name} starts at {value:g}; give it a start that is not zero (an angle below 180 deg)")
    return Free(name, paths, float(value), unit_of(plain, paths[0]))


def _is_vector(value: Any) -> bool:
    """Whether a value is a list of numbers."""
    return isinstance(value, (list, tuple)) and len(value) > 0 and all(isinstance(part, float) for part in value)


def _sized(plain: Mapping[str, Any], name: str, vectors: Sequence[Path]) -> Free:
    """The parameter for some vectors: the magnitude of the largest, with all components in proportion to it."""
    found: Any = [(path, value_at(plain, path, ())) for path in vectors]
    parts = {(*path, place): part for path, vector in found for place, part in enumerate(vector) if part != 0.0}
    if not parts:
        raise BadInput(f"free: {name} starts at 0; give it a start that is not zero")
    size = max(math.hypot(*vector) for _, vector in found)
    shares = tuple(part / size for part in parts.values())
    return Free(name, tuple(parts), size, unit_of(plain, next(iter(parts))), shares)


def _places(plain: Mapping[str, Any], name: str) -> list[Path]:
    """The paths of a short name: in the lists of particles, otherwise in other tables."""
    found = [path for path in _numbered(plain) if path[-1] == name]
    listed = [path for path in found if any(isinstance(key, int) for key in path)]
    return listed or found[:1]


def _numbers(plain: Mapping[str, Any]) -> set[str]:
    return {str(path[-1]) for path in _numbered(plain)}


def _numbered(value: Any, path: Path = ()) -> Iterator[Path]:
    """The paths of all named numbers and of all lists of numbers."""
    if isinstance(value, Mapping):
        for key, item in value.items():
            yield from _numbered(item, (*path, key))
    elif _is_vector(value) or (isinstance(value, (int, float)) and not isinstance(value, bool)):
        yield path
    elif isinstance(value, (list, tuple)):
        for place, item in enumerate(value):
            if isinstance(item, Mapping):
                yield from _numbered(item, (*path, place))


def with_values(plain: dict[str, Any], free: Sequence[Free], values: Sequence[float]) -> dict[str, Any]:
    """Set values in a scene's plain data. Changes and returns the data."""
    for parameter, value in zip(free, values, strict=True):
        for path, share in zip(parameter.paths, parameter.shares or (1.0,) * len(parameter.paths), strict=True):
            put(plain, path, share * float(value))
    return plain


class Quantity(NamedTuple):
    """A positive quantity derived from a scene."""

    name: str
    value: float
    unit: str


def of_floats(scene: FloatingScene) -> list[Quantity]:
    """The quantities on which the motion depends, for each kind of floats.

    Equal floats far apart move by m x'' = -2 pi gamma A^2 / L K1(r/L) - zeta x': angle and density enter through the
    charge A, the mass m and the friction zeta, and these only through 2 pi gamma A^2 / m and zeta / m. In a viscous
    liquid, where floats have no inertia, only the ratio of the two matters.
    """
    floats = MODELS["floating"].parameters(scene).floats
    names = [kind.name for kind in scene.kinds]
    several, found = len(names) > 1, []
    for number, name in enumerate(names):
        place = int(np.argmax(floats.species == number))
        charge, mass, coasting = (
            abs(float(values[place])) for values in (floats.charge, floats.mass, floats.relaxation_time)
        )
        pull = 2.0 * math.pi * liquid_of(scene).surface_tension * charge**2
        values = [("charge", charge, "m"), ("pull/mass", pull / mass, "m^2/s^2")]
        if math.isfinite(coasting):
            values += [("friction/mass", 1.0 / coasting, "1/s"), ("pull/friction", pull / mass * coasting, "m^2/s")]
        found += [Quantity(f"{word} of {name}" if several else word, value, unit) for word, value, unit in values]
    return found


def of_tracers(scene: TracersScene) -> list[Quantity]:
    """The terminal speed of each kind, and friction over mass, which determines the effect of inertia.

    If relaxation ends before the first picture, density, radius and viscosity affect only the speed.
    """
    bodies = MODELS["tracers"].parameters(scene).bodies
    names, found = [kind.name for kind in scene.kinds], []
    for number, name in enumerate(names):
        place = int(np.argmax(bodies.species == number))
        of = f" of {name}" if len(names) > 1 else ""
        speed, rate = abs(float(bodies.settling[place])), float(bodies.friction[place] / bodies.mass[place])
        found += [Quantity(f"{word}{of}", value, unit) for word, value, unit in (
            ("settling speed", speed if math.isfinite(speed) else 0.0, "m/s"),
            ("friction/mass", 0.0 if bodies.overdamped[place] else rate, "1/s"),
        )]  # fmt: skip
    return found


QUANTITIES: dict[str, Callable[[Any], list[Quantity]]] = {"floating": of_floats, "tracers": of_tracers}


def quantities_of(scene: Scene) -> list[Quantity]:
    """The derived quantities of a scene, without zeros, which have no logarithm; empty if its model does not define
    any.
    """
    if scene.model not in QUANTITIES:
        return []
    return [quantity for quantity in QUANTITIES[scene.model](scene) if quantity.value > 0.0]
