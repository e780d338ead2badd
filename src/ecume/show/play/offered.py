"""The choices in a page that simulates, and their numbers: kinds of floats, liquids, and shapes of the dish.

The equilibrium of a float follows from a boundary-value problem for its meniscus, which pages do not solve: a page
offers some sizes, densities and contact angles, whose charge, mass and drag are computed here.
"""

from __future__ import annotations

import dataclasses
import itertools
import math
import warnings
from collections.abc import Iterable, Sequence
from typing import Any, NamedTuple

import numpy as np

from ecume.engine.walls import surfaces, wall_count
from ecume.errors import BadInput
from ecume.laws import drag
from ecume.models import MODELS
from ecume.models.floating.dishes import outline_of, wall_strengths, walls_of
from ecume.models.floating.parameters import Floats, Parameters, make_state, make_workspace
from ecume.models.floating.setup.kinds import FloatKind, float_kind
from ecume.models.floating.time_integration.integration import make_scratch
from ecume.models.floating.time_integration.step_size import kick_of, longest_good_step
from ecume.models.liquids import is_under_liquid, liquid_of
from ecume.scenes.floating import DishSpec, FloatingScene, FloatSpec
from ecume.scenes.writing import to_toml
from ecume.show.floating.bowl import view_of
from ecume.show.play.bowl import FASTEST, SHELF, Bowl, slosh_frequency
from ecume.show.play.memory import arguments_of, slots
from ecume.show.style import liquid_color
from ecume.units import Array

ROOM = 120
"""Floats that a page has room for."""
AS_GIVEN = "as given"
LIQUIDS = ("water", "milk", "soapy water")
"""What the dish of a page can be filled with, beside the liquid of the scene."""


class Grid(NamedTuple):
    """The sizes, densities and contact angles that the page offers for each species."""

    size: tuple[float, ...]
    """factors of its radius"""
    density: tuple[float, ...]
    """factors of its density"""
    angle: tuple[float, ...]
    """degrees added to its contact angle"""

    @property
    def usual(self) -> tuple[int, int, int]:
        """The indices at which a species has the values of the scene."""
        return self.size.index(1.0), self.density.index(1.0), self.angle.index(0.0)


FINE = Grid((0.6, 0.8, 1.0, 1.25, 1.6), (0.5, 1.0, 2.0), (-40.0, -20.0, 0.0, 20.0, 40.0))
COARSE = Grid((0.75, 1.0, 1.5), (0.5, 1.0, 2.0), (-30.0, 0.0, 30.0))
WETTEST = 0.1
"""rad: the smallest contact angle that is offered, and the distance of the largest one from pi."""


class Offered(NamedTuple):
    """A kind of float in the page."""

    spec: FloatSpec
    species: int
    choice: tuple[int, int, int]


def offered(kinds: list[FloatSpec], grid: Grid = FINE) -> list[Offered]:
    """All kinds, species by species."""
    found = []
    for number, spec in enumerate(kinds):
        for choice in itertools.product(*map(range, map(len, grid))):
            assert isinstance(spec.contact_angle, float)  # noqa: S101  # see `alone.refusal`
            size, weight, turn = (each[place] for each, place in zip(grid, choice, strict=True))
            wetted = min(max(spec.contact_angle + math.radians(turn), WETTEST), math.pi - WETTEST)
            changed = dataclasses.replace(
                spec, radius=size * spec.radius, density=weight * spec.density, contact_angle=wetted
            )
            found.append(Offered(changed, number, (choice[0], choice[1], choice[2])))
    return found


def species_of(scene: FloatingScene, *, shelf: bool = True) -> list[FloatSpec]:
    """One float of each species of a scene, and one of each kind on the shelf."""
    known = {species.name for species in scene.particles}
    more = [FloatSpec(name=name, **values) for name, values in SHELF.items() if shelf and name not in known]
    bare: dict[str, Any] = {
        "count": 1, "positions": (), "velocities": (), "velocity": (0.0, 0.0),
        "placement": "random", "spacing": None, "ring_radius": None, "center": None,
    }  # fmt: skip
    return [dataclasses.replace(spec, **bare) for spec in (*scene.particles, *more)]


def dishes_of(dish: DishSpec) -> dict[str, DishSpec]:
    """The dish, and dishes of other shapes and of the same area."""
    area = surfaces.area(walls_of(dish))
    side, bare = math.sqrt(area), dataclasses.replace(dish, shape=None)
    shapes: dict[str, dict[str, Any]] = {
        "round": {"radius": math.sqrt(area / math.pi), "size": None, "vertices": None},
        "square": {"radius": None, "size": (side, side), "vertices": None},
        "long": {"radius": None, "size": (math.sqrt(2.0) * side, side / math.sqrt(2.0)), "vertices": None},
    }
    found = {AS_GIVEN: dish}
    for name, shape in shapes.items():
        if (made := dataclasses.replace(bare, **shape)) != bare:
            found[name] = made
    return found


def liquids_of(scene: FloatingScene) -> dict[str, FloatingScene]:
    """The scene with its liquid, and with each liquid that can replace it."""
    found = {AS_GIVEN: scene}
    bare: dict[str, Any] = dict.fromkeys(("density", "viscosity", "surface_tension", "color"))
    for name in () if is_under_liquid(liquid_of(scene)) else LIQUIDS:
        if name != scene.liquid.name:
            filled = dataclasses.replace(scene.liquid, name=name, **bare)
            found[name] = dataclasses.replace(scene, liquid=filled)
    return found


def floats_of(kinds: Sequence[FloatKind | None]) -> Floats:
    """The properties of one float of each kind; NaN where a kind sinks."""

    def each(of: Any) -> Any:
        return np.array([math.nan if kind is None else of(kind) for kind in kinds])

    return Floats(
        radius=each(lambda kind: kind.radius),
        mass=each(lambda kind: kind.mass),
        charge=each(lambda kind: kind.charge),
        relaxation_time=each(lambda kind: drag.relaxation_time(kind.mass, kind.friction)),
        density=each(lambda kind: kind.density),
        contact_angle=each(lambda kind: kind.contact_angle),
        species=np.zeros(len(kinds), np.int64),
    )


def kind_or_none(spec: FloatSpec, scene: FloatingScene) -> FloatKind | None:
    """The kind of float, or None if it sinks."""
    try:
        return float_kind(spec, scene)
    except BadInput:
        return None


class Filled(NamedTuple):
    """Kinds of floats in a liquid. A kind is NaN where it sinks."""

    floats: Floats
    groups: tuple[list[FloatKind], ...]
    """those that float and whose species are as they are, then those of each size or a larger one"""
    ends: tuple[FloatSpec, FloatSpec]
    """the smallest and the largest that float"""


def in_liquid(scene: FloatingScene, every: Sequence[Offered], usual: tuple[int, int, int]) -> Filled:
    """The kinds in the liquid of this scene. Raises BadInput if all sink."""
    found = [kind_or_none(one.spec, scene) for one in every]
    floating = [(kind, one) for kind, one in zip(found, every, strict=True) if kind is not None]
    if not floating:
        raise BadInput("no kind of float that the page offers floats in this liquid")
    sizes = range(1 + max(one.choice[0] for one in every))
    groups = [[kind for kind, one in floating if one.choice == usual]]
    groups += [[kind for kind, one in floating if one.choice[0] >= size] for size in sizes]
    by_size = sorted((one.spec for _, one in floating), key=lambda spec: spec.radius)
    return Filled(floats_of(found), tuple(groups), (by_size[0], by_size[-1]))


def parameters_in(scene: FloatingScene, made: Filled) -> Parameters:
    """The constants of a bowl for floats of all kinds that the page offers."""
    ends = tuple(dataclasses.replace(spec, name=f"end {k}") for k, spec in enumerate(made.ends))
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")  # hide warnings on errors of superposition, which `ecume check` reports
        parameters: Parameters = MODELS["floating"].parameters(dataclasses.replace(scene, particles=ends, rows=()))
    return parameters._replace(drift=parameters.drift._replace(flows=True))


def steps_in(scenes: Iterable[tuple[FloatingScene, Parameters]], made: Filled) -> list[float | None]:
    """The time step (s) in each of these dishes for each group of kinds; None for an empty group. A user may throw any
    float.
    """
    places, found = list(scenes), list[float | None]()
    for group in map(floats_of, made.groups):
        there = len(group.radius) > 0
        found.append(min(_step(parameters, scene, group) for scene, parameters in places) if there else None)
    return found


def _step(parameters: Parameters, scene: FloatingScene, floats: Floats) -> float:
    kick = kick_of(parameters.scheme, 1.0, floats, wall_count(parameters.walls))
    some = parameters._replace(floats=floats, wall_strength=wall_strengths(scene, floats), kick=kick)
    return longest_good_step(some, FASTEST)


def numbers_of(
    scenes: dict[str, FloatingScene], every: Sequence[Offered], usual: tuple[int, int, int]
) -> dict[str, Any]:
    """All numbers of a liquid that the page needs, for each dish by its name."""
    scene = scenes[AS_GIVEN]
    liquid, made = liquid_of(scene), in_liquid(scene, every, usual)
    parameters = {name: parameters_in(one, made) for name, one in scenes.items()}
    steps = steps_in([(scenes[name], one) for name, one in parameters.items()], made)
    scheme = parameters[AS_GIVEN].scheme
    kicks = [step and (step, kick_of(scheme, step, made.floats, 0)) for step in steps]
    return {
        "liquid": {key: getattr(liquid, key) for key in ("density", "surface_tension", "viscosity")},
        "capillary_length": liquid.capillary_length,
        "color": liquid_color(scene.liquid),
        "kinds": {name: _numbers(getattr(made.floats, name)) for name in Floats._fields if name != "species"},
        "steps": [
            one and {"time": one[0], **{name: _numbers(values) for name, values in one[1]._asdict().items()}}
            for one in kicks
        ],
        "dishes": {name: _dish_numbers(one, parameters[name], made.floats) for name, one in scenes.items()},
    }


def _dish_numbers(scene: FloatingScene, parameters: Parameters, floats: Floats) -> dict[str, Any]:
    swing = slosh_frequency(scene)
    return {
        **_strengths(wall_strengths(scene, floats)),
        "swing": swing,
        "current": scene.gravity / swing**2,
        "slots": layout(parameters),
        "toml": _without_floats(to_toml(dataclasses.replace(scene, rows=(), particles=scene.particles[:1]))),
    }


def _strengths(each: Array) -> dict[str, Any]:
    """The strength of the strongest wall for each kind, and the shares of all walls in it: a strength is a product of
    one factor of the wall and one of the float. An ellipse has so many walls that all products would be too much.
    """
    strongest = int(np.argmax(np.max(np.nan_to_num(np.abs(each)), axis=1, initial=0.0)))  # NaN: kinds that sink
    row = each[strongest]
    kind = int(np.argmax(np.nan_to_num(np.abs(row))))
    shares = each[:, kind] / row[kind] if row[kind] else np.ones(len(each))
    return {"strength": _numbers(row), "shares": shares.tolist()}


def _without_floats(text: str) -> str:
    r"""A scene without its tables of particles.

    >>> _without_floats("seed = 1\n\n[[particles]]\nname = 'a'\n\n[dish]\nradius = 1\n")
    'seed = 1\n\n[dish]\nradius = 1\n\n'
    """
    tables = ("\n" + text).split("\n[")
    kept = "\n[".join(table for table in tables if not table.startswith("[particles]]")).strip()
    return f"{kept}\n\n"


def _numbers(values: Any) -> list[float | None]:
    return [value if math.isfinite(value) else None for value in values.tolist()]


def layout(parameters: Parameters) -> list[list[Any]]:
    """The arguments of a bowl with any number of floats: sizes are pairs (a, b), for a floats + b."""
    more, fewer = (slots(_blank(parameters, count)) for count in (ROOM, ROOM - 1))
    found = []
    for (name, kind, shape, value), (_, _, other, _) in zip(more, fewer, strict=True):
        if shape is None:
            finite = not isinstance(value, float) or math.isfinite(value)
            found.append([name, kind, None, value if finite else str(value)])
            continue
        sizes = [[large - small, large - (large - small) * ROOM] for large, small in zip(shape, other, strict=True)]
        found.append([name, kind, sizes, None if any(size[0] for size in sizes) else value])
    return found


def _blank(parameters: Parameters, count: int) -> dict[str, Any]:
    """Arguments with a number of equal floats."""
    first: Any = (np.repeat(values[:1], count) for values in parameters.floats)
    one = Floats(*first)
    walls = wall_count(parameters.walls)
    kick = kick_of(parameters.scheme, 1.0, one, walls)
    strength = np.repeat(parameters.wall_strength[:, :1], count, axis=1)
    sized = parameters._replace(floats=one, kick=kick, wall_strength=strength)
    state = make_state(np.zeros((count, 2)), np.zeros((count, 2)))
    workspace = make_workspace(sized, state, 2.0)
    return arguments_of(sized, state, workspace._replace(scratch=make_scratch(sized, state, workspace)))


class Chapter(NamedTuple):
    """A scene of a page: the data in the header of the page, and the numbers of each liquid."""

    header: dict[str, Any]
    liquids: dict[str, dict[str, Any]]


def chapter(scene: FloatingScene, title: str, colors: Any, *, whole: bool = True) -> Chapter:
    """A scene that a page simulates; with `whole`, also with other liquids and dishes, and with the kinds on the
    shelf.
    """
    bowl = Bowl(scene)
    start, kinds = bowl.present(), species_of(bowl.present(), shelf=whole)
    assert start.dish is not None  # noqa: S101  # see `alone.refusal`
    grid = FINE if whole else COARSE
    every, liquids = offered(kinds, grid), liquids_of(start) if whole else {AS_GIVEN: start}
    dishes = dishes_of(start.dish) if whole else {AS_GIVEN: start.dish}
    found = {
        name: numbers_of(
            {shape: dataclasses.replace(one, dish=dish) for shape, dish in dishes.items()}, every, grid.usual
        )
        for name, one in liquids.items()
    }
    header = {
        "title": title,
        "usual": grid.usual,
        "factors": {"size": grid.size, "density": grid.density, "contact angle": grid.angle},
        "own": bowl.integration.parameters.drift.flow[:2].tolist(),
        "species": [{"name": spec.name, "color": colors(start, spec), "radius": spec.radius} for spec in kinds],
        "floats": [
            [number, *place, *speed]
            for number, spec in enumerate(start.particles)
            for place, speed in zip(spec.positions, spec.velocities, strict=True)
        ],
        "dishes": {
            name: {
                "outline": outline_of(dish).tolist(),
                "view": list(view_of(dataclasses.replace(start, dish=dish), [bowl.frame])),
            }
            for name, dish in dishes.items()
        },
    }
    return Chapter(header, found)
