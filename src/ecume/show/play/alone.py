"""A bowl that a page simulates by itself: the same compiled laws as WebAssembly, and the numbers that it needs.

How a float sits in the surface follows from a boundary-value problem for its meniscus, which no page solves: a page
offers some sizes, densities and contact angles, and has the charge, mass and drag of each from here.
"""

from __future__ import annotations

import base64
import dataclasses
import gzip
import itertools
import json
import math
import warnings
from collections.abc import Sequence
from importlib import resources
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from ecume.engine.walls import wall_count
from ecume.errors import BadInput
from ecume.laws import drag
from ecume.models import MODELS
from ecume.models.floating.dishes import outline_of, wall_strengths
from ecume.models.floating.parameters import Floats, Parameters, make_state, make_workspace
from ecume.models.floating.setup.kinds import FloatKind, float_kind
from ecume.models.floating.time_integration.integration import make_scratch
from ecume.models.floating.time_integration.step_size import kick_of, longest_good_step
from ecume.models.liquids import is_under_liquid, liquid_of
from ecume.scenes.floating import FloatingScene, FloatSpec
from ecume.scenes.writing import to_toml
from ecume.show.floating.bowl import view_of
from ecume.show.play.bowl import FASTEST, GRASP, SHELF, STEEPEST_DISH, Bowl, slosh_frequency
from ecume.show.play.memory import arguments_of, bowl_arguments, slots, types_of
from ecume.show.style import liquid_color
from ecume.show.view.page import ALONE, bundled, data_of, filled, hexadecimal, json_of
from ecume.trajectories.records import write_whole

ROOM = 120
"""Floats that a page has room for."""
LIQUIDS = ("water", "milk", "soapy water")
"""What the dish of a page can be filled with, beside the liquid of the scene."""
SIZES, DENSITIES, ANGLES = (0.75, 1.0, 1.5), (0.5, 1.0, 2.0), (-30.0, 0.0, 30.0)
"""Factors of a species' radius and density, and degrees added to its contact angle, that a page offers."""


class Offered(NamedTuple):
    """A kind of float that the page offers."""

    spec: FloatSpec
    species: int
    choice: tuple[int, int, int]


def offered(kinds: list[FloatSpec]) -> list[Offered]:
    """All kinds, species by species."""
    found = []
    for number, spec in enumerate(kinds):
        for size, weight, angle in itertools.product(*map(range, map(len, (SIZES, DENSITIES, ANGLES)))):
            assert isinstance(spec.contact_angle, float)  # noqa: S101  # see `refusal`
            wetted = min(max(spec.contact_angle + math.radians(ANGLES[angle]), 0.1), math.pi - 0.1)
            changed = dataclasses.replace(
                spec, radius=SIZES[size] * spec.radius, density=DENSITIES[weight] * spec.density, contact_angle=wetted
            )
            found.append(Offered(changed, number, (size, weight, angle)))
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
    """The kind, or None if it sinks."""
    try:
        return float_kind(spec, scene)
    except BadInput:
        return None


class Liquid(NamedTuple):
    """A bowl with a liquid: constants for floats of all kinds that the page offers."""

    parameters: Parameters
    floats: Floats
    """one of each kind, NaN where it sinks"""
    wall_strength: Any
    steps: tuple[float, float]
    """s: the time step where all species are as they are, and that for any"""


def in_liquid(scene: FloatingScene, every: Sequence[Offered]) -> Liquid:
    """The bowl with the liquid of this scene. Raises BadInput if all kinds sink."""
    found = [kind_or_none(one.spec, scene) for one in every]
    there = [kind for kind in found if kind is not None]
    if not there:
        raise BadInput("no kind of float that the page offers floats in this liquid")
    by_size = sorted((one.spec for one in every), key=lambda spec: spec.radius)
    ends = tuple(dataclasses.replace(spec, name=f"end {k}") for k, spec in enumerate((by_size[0], by_size[-1])))
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")  # superposition's errors are reported by `ecume check`
        parameters: Parameters = MODELS["floating"].parameters(dataclasses.replace(scene, particles=ends, rows=()))
    parameters = parameters._replace(drift=parameters.drift._replace(flows=True))
    usual = [kind for kind, one in zip(found, every, strict=True) if kind is not None and one.choice == USUAL]
    steps = _step(parameters, scene, usual or there), _step(parameters, scene, there)
    floats = floats_of(found)
    return Liquid(parameters, floats, wall_strengths(scene, floats), steps)


def numbers_of(scene: FloatingScene, made: Liquid) -> dict[str, Any]:
    """All that the page has of a liquid."""
    liquid, floats, swing = liquid_of(scene), made.floats, slosh_frequency(scene)
    each = {name: getattr(floats, name) for name in Floats._fields if name != "species"}
    each |= {f"wall {number}": row for number, row in enumerate(made.wall_strength)}
    kicks = [(step, kick_of(made.parameters.scheme, step, floats, 0)) for step in made.steps]
    return {
        "liquid": {key: getattr(liquid, key) for key in ("density", "surface_tension", "viscosity")},
        "capillary_length": liquid.capillary_length,
        "color": liquid_color(scene.liquid),
        "swing": swing,
        "current": scene.gravity / swing**2,
        "slots": layout(made.parameters),
        "kinds": {name: _numbers(values) for name, values in each.items()},
        "steps": [
            {"time": step, **{name: _numbers(values) for name, values in kick._asdict().items()}}
            for step, kick in kicks
        ],
        "toml": to_toml(dataclasses.replace(scene, rows=(), particles=scene.particles[:1])),
    }


USUAL = (1, 1, 1)
"""The species as they are."""


def _step(parameters: Parameters, scene: FloatingScene, kinds: Sequence[FloatKind]) -> float:
    """The longest good time step of floats of these kinds, any of which may be thrown."""
    floats = floats_of(kinds)
    kick = kick_of(parameters.scheme, 1.0, floats, wall_count(parameters.walls))
    some = parameters._replace(floats=floats, wall_strength=wall_strengths(scene, floats), kick=kick)
    return longest_good_step(some, FASTEST)


def _numbers(values: Any) -> list[float | None]:
    return [value if math.isfinite(value) else None for value in values.tolist()]


def layout(parameters: Parameters) -> list[list[Any]]:
    """The arguments of a bowl with any number of floats: sizes are pairs (a, b), for a floats + b."""
    more, fewer = (slots(_blank(parameters, count)) for count in (ROOM, ROOM - 1))
    found = []
    for (name, kind, shape, value), (_, _, other, _) in zip(more, fewer, strict=True):
        if shape is None:
            found.append(
                [name, kind, None, value if not isinstance(value, float) or math.isfinite(value) else str(value)]
            )
            continue
        sizes = [[large - small, large - (large - small) * ROOM] for large, small in zip(shape, other, strict=True)]
        found.append([name, kind, sizes, None if any(size[0] for size in sizes) else value])
    return found


def _blank(parameters: Parameters, count: int) -> dict[str, Any]:
    """The arguments with so many equal floats."""
    first: Any = (np.repeat(values[:1], count) for values in parameters.floats)
    one = Floats(*first)
    walls = wall_count(parameters.walls)
    kick = kick_of(parameters.scheme, 1.0, one, walls)
    strength = np.repeat(parameters.wall_strength[:, :1], count, axis=1)
    sized = parameters._replace(floats=one, kick=kick, wall_strength=strength)
    state = make_state(np.zeros((count, 2)), np.zeros((count, 2)))
    workspace = make_workspace(sized, state, 2.0)
    return arguments_of(sized, state, workspace._replace(scratch=make_scratch(sized, state, workspace)))


def refusal(scene: Any) -> str:
    """Why a page cannot simulate a scene by itself; empty if it can."""
    if scene.model != "floating" or scene.dish is None:
        return "a page simulates floats in a dish"
    if any(one.disc or one.shape or one.surface_energies or one.magnetic_moment or isinstance(one.contact_angle, str)
           for one in (*scene.particles, *scene.rows)):  # fmt: skip
        return "a page simulates spheres with a contact angle"
    if scene.rows or any(species.sized for species in scene.particles):
        return "a page simulates species of equal floats"
    if sum(species.count for species in scene.particles) > ROOM:
        return f"a page has room for {ROOM} floats"
    if types_of(bowl_arguments(scene)) != bundled("bowl.types"):
        return "the laws of this scene are not compiled into pages: pages have superposed menisci and plain collisions"
    return ""


def species_of(scene: FloatingScene) -> list[FloatSpec]:
    """One float of each species of a scene, and of what lies on the shelf."""
    shelf = [FloatSpec(name=name, **values) for name, values in SHELF.items()]
    known = {species.name for species in scene.particles}
    every = [*scene.particles, *(spec for spec in shelf if spec.name not in known)]
    alone: dict[str, Any] = {
        "count": 1,
        "positions": (),
        "velocities": (),
        "velocity": (0.0, 0.0),
        "placement": "random",
    }
    return [dataclasses.replace(spec, spacing=None, ring_radius=None, **alone) for spec in every]


def alone(scene: Any) -> str:
    """The page of a bowl that simulates by itself. Raises BadInput for scenes that it cannot."""
    why = refusal(scene)
    if why:
        raise BadInput(why)
    bowl = Bowl(scene)
    start, kinds = bowl.present(), species_of(scene)
    every = offered(kinds)
    liquids = {"as given": numbers_of(start, in_liquid(start, every))}
    bare: dict[str, Any] = dict.fromkeys(("density", "viscosity", "surface_tension", "color"))
    for name in () if is_under_liquid(liquid_of(scene)) else LIQUIDS:
        with_it = dataclasses.replace(start, liquid=dataclasses.replace(start.liquid, name=name, **bare))
        if name != scene.liquid.name:
            liquids[name] = numbers_of(with_it, in_liquid(with_it, every))
    colors = {kind.name: kind.color for kind in start.kinds}
    header = {
        "title": scene.title or "A bowl",
        "outline": outline_of(bowl.dish).tolist(),
        "view": list(view_of(scene, [bowl.frame])),
        "steepest": STEEPEST_DISH,
        "fastest": FASTEST,
        "grasp": GRASP,
        "room": ROOM,
        "own": bowl.integration.parameters.drift.flow[:2].tolist(),
        "species": [
            {"name": spec.name, "color": hexadecimal(str(colors.get(spec.name) or spec.color)), "radius": spec.radius}
            for spec in kinds
        ],
        "usual": USUAL,
        "factors": {"size": SIZES, "density": DENSITIES, "contact angle": ANGLES},
        "floats": [
            [number, *place, *speed]
            for number, spec in enumerate(start.particles)
            for place, speed in zip(spec.positions, spec.velocities, strict=True)
        ],
    }
    packed = gzip.compress(json.dumps(liquids, separators=(",", ":"), allow_nan=False).encode(), 9, mtime=0)
    wasm = resources.files("ecume.show.view").joinpath("bundle", "bowl.wasm").read_bytes()
    data = [
        data_of("toy", "application/json", json_of(header)),
        data_of("liquids", "text/plain", base64.b64encode(packed).decode()),
        data_of("wasm", "text/plain", base64.b64encode(gzip.compress(wasm, 9, mtime=0)).decode()),
        data_of("worker", "text/plain", bundled("solver.js")),
    ]
    return filled(ALONE, str(header["title"]), "\n".join(data), live=False)


def save_alone(scene: Any, target: Path) -> int:
    """Write the page of a bowl to a file; its size in bytes."""
    content = alone(scene).encode()
    write_whole(target, content)
    return len(content)
