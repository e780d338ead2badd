"""From a scene with shapes to their parameters; and where they start."""

from __future__ import annotations

import itertools
import math
from collections.abc import Sequence
from typing import Any

import numpy as np

from ecume.engine.cells import Integers
from ecume.engine.outlines import Outlines, Stance, bodies_near, turn_corners, wall_near
from ecume.engine.walls import wall_count
from ecume.errors import Fault, SceneError
from ecume.models.floating.pair_choice import lacks, row_of
from ecume.models.floating.parameters import (
    OVERDAMPED,
    SCHEMES,
    SEMI_IMPLICIT_EULER,
    VELOCITY_VERLET,
    Parameters,
)
from ecume.models.floating.shaped.bodies import Shaped
from ecume.models.floating.shaped.figures import Figure, Skeleton, charges_of
from ecume.models.floating.shaped.forces import pull_pair
from ecume.models.floating.walls.menisci import has_far_field
from ecume.models.floating.walls.shapes import wall_strengths
from ecume.scenes.floating import FloatingScene
from ecume.units import Array

SCHEMES_THAT_TURN = (VELOCITY_VERLET, SEMI_IMPLICIT_EULER, OVERDAMPED)
NEIGHBORS = 6.0
NEARLY = 1.001
"""Over the touching distance: where the stiffness of the pull is measured."""
TURN = 0.2
"""rad: a step is a twentieth of the time for that. Contacts foresee a turn as if tips went straight on."""
FINE = 1e-4
"""Of a radius, or rad: the step of its differences."""


def with_shapes(parameters: Parameters, scene: FloatingScene, kinds: Sequence[Any], number: Integers) -> Parameters:
    """Parameters of floats that turn and touch as what they are. Raises SceneError for what does not go with that."""
    _require_known(parameters, scene)
    figures = [kind.figure for kind in kinds]
    shaped = make_shaped([figures[k] for k in number], drag=bool(scene.motion.drag))
    strength = wall_strengths(scene, parameters.floats._replace(charge=shaped.charge))
    parameters = parameters._replace(many=shaped._replace(wall_strength=strength))
    return parameters._replace(quickest=min(quickest(parameters, number), spinning_time(parameters, scene)))


def make_shaped(figures: Sequence[Figure], *, drag: bool = True) -> Shaped:
    """All bodies in one table."""
    spread = [charges_of(figure) for figure in figures]
    shares = 1.0 if drag else 0.0
    return Shaped(
        outlines=outlines_of([figure.skeleton for figure in figures]),
        place=np.concatenate([places for places, _ in spread]),
        charge=np.concatenate([charges for _, charges in spread]),
        first=_firsts([len(charges) for _, charges in spread]),
        wall_strength=np.zeros((0, 0)),
        inertia=np.array([figure.inertia for figure in figures]),
        friction=shares * np.array([figure.friction for figure in figures]),
        places=_most_places([figure.skeleton for figure in figures]),
    )


def outlines_of(skeletons: Sequence[Skeleton]) -> Outlines:
    """Outlines of all bodies."""
    firsts = _firsts([len(skeleton.corners) for skeleton in skeletons])
    edges = [
        np.array(skeleton.edges, np.int64).reshape(-1, 2) + first
        for skeleton, first in zip(skeletons, firsts, strict=False)
    ]
    return Outlines(
        axes=np.array([skeleton.axes for skeleton in skeletons]),
        rounding=np.array([skeleton.rounding for skeleton in skeletons]),
        corner=np.concatenate([np.reshape(skeleton.corners, (-1, 2)) for skeleton in skeletons]),
        first_corner=firsts,
        edge=np.concatenate(edges),
        first_edge=_firsts([len(skeleton.edges) for skeleton in skeletons]),
    )


def _firsts(counts: Sequence[int]) -> Integers:
    return np.cumsum([0, *counts]).astype(np.int64)


def _most_places(skeletons: Sequence[Skeleton]) -> int:
    """How many places two of these can be near at."""
    corners = max(len(skeleton.corners) for skeleton in skeletons)
    edges = max(len(skeleton.edges) for skeleton in skeletons)
    return 1 + corners + edges + corners * corners + 2 * corners * edges


def _require_known(parameters: Parameters, scene: FloatingScene) -> None:
    known = ", ".join(SCHEMES[scheme] for scheme in SCHEMES_THAT_TURN)
    wrong = [
        (
            "motion.integrator",
            parameters.scheme not in SCHEMES_THAT_TURN,
            f"floats with a shape go by {known}",
        ),
        (
            "interaction.law",
            row_of(parameters).has_force and bool(lacks(parameters, "menisci")),
            f"a float with a shape needs {lacks(parameters, 'menisci')}",
        ),
        (
            "dish.law",
            not has_far_field(parameters),
            "floats with a shape go with a dish's 'meniscus', 'linear' or 'none', without images",
        ),
        (
            "liquid.flow",
            parameters.drift.flows,
            "no flowing surface carries floats with a shape; leave it out",
        ),
        ("motion.temperature", parameters.drift.thermal > 0.0, "floats with a shape have no Brownian motion"),
        ("motion.drag_law", parameters.drift.thickness > 0.0, "floats with a shape have Stokes's drag: 'stokes'"),
        ("motion.added_mass", scene.motion.added_mass, "added mass is known of spheres only"),
        ("interaction.method", scene.interaction.method != "superposition", "floats with a shape are superposed"),
        ("contacts.friction", scene.rubs, "floats with a shape are smooth: leave friction out"),
        (
            "contacts.legacy_coefficient",
            scene.contacts.legacy_coefficient is not None,
            "floats with a shape collide by contacts.restitution",
        ),
    ]
    faults = [Fault(path, message) for path, broken, message in wrong if broken]
    faults += _too_flat(parameters, parameters.walls.disc_radius)
    if faults:
        raise SceneError(faults)


def _too_flat(parameters: Parameters, dish_radius: float) -> list[Fault]:
    """An ellipse whose flank is flatter than the wall would touch it at two places."""
    if float(parameters.floats.radius.max()) < 0.5 * dish_radius:
        return []
    return [Fault("dish.radius", f"{dish_radius:g} m is less than twice the radius of a float with a shape")]


def quickest(parameters: Parameters, number: Integers) -> float:
    """How soon the stiffest pair turns back or relaxes, gliding or turning (s), with six touching neighbors."""
    first = [int(np.flatnonzero(number == kind)[0]) for kind in np.unique(number)]
    found = [_times(parameters, (i, j)) for i, j in itertools.combinations_with_replacement(first, 2)]
    return min(found, default=math.inf)


def spinning_time(parameters: Parameters, scene: FloatingScene) -> float:
    """How soon a float turns by `TURN`, if a blow makes all of the fastest start's energy spin (s)."""
    starts = [*(species.velocity for species in scene.floats), *((row.vx, row.vy) for row in scene.rows)]
    speed = max(math.hypot(*velocity) for velocity in starts)
    spin = speed * math.sqrt(float(np.max(parameters.floats.mass / parameters.many.inertia)))
    return TURN / spin if spin > 0.0 else math.inf


def _times(parameters: Parameters, pair: tuple[int, int]) -> float:
    """The shortest time of two bodies that touch, over how they are turned."""
    times = []
    ways = 0.0, 0.25 * math.pi, 0.5 * math.pi
    for turns in itertools.product(ways, ways):
        glide, turn = _stiffnesses(parameters, pair, turns)
        many, masses = parameters.many, parameters.floats.mass
        for i in pair:
            for stiff, inertia, friction in (
                (glide, masses[i], many.friction[i, :2].min()),
                (turn, many.inertia[i], many.friction[i, 2]),
            ):
                if stiff > 0.0:
                    slow = 0.0 if parameters.scheme == OVERDAMPED else math.sqrt(inertia / (NEIGHBORS * stiff))
                    times.append(max(slow, friction / (NEIGHBORS * stiff)))
    return min(times, default=math.inf)


def _stiffnesses(parameters: Parameters, pair: tuple[int, int], turns: tuple[float, float]) -> tuple[float, float]:
    """|dF/dl| (N/m) and |d torque/d angle| (N m) of two touching bodies, by differences."""
    apart = touching_distance(parameters, pair, turns) * NEARLY
    size = FINE * float(parameters.floats.radius[list(pair)].min())
    near, far = (_pull(parameters, pair, turns, apart + step) for step in (0.0, size))
    turned = _pull(parameters, pair, (turns[0] + FINE, turns[1]), apart)
    return abs(far[0] - near[0]) / size, abs(turned[2] - near[2]) / FINE


def _pull(
    parameters: Parameters, pair: tuple[int, int], turns: tuple[float, float], apart: float
) -> tuple[float, float, float, float]:
    """Forces and torques of two bodies, the second to the right of the first. A kind alone meets its own copy."""
    many: Shaped = parameters.many
    blocks = [slice(many.first[k], many.first[k + 1]) for k in pair]
    two = many._replace(
        charge=np.concatenate([many.charge[block] for block in blocks]),
        first=_firsts([block.stop - block.start for block in blocks]),
    )
    at = np.concatenate([_turned(many.place[block], turn) for block, turn in zip(blocks, turns, strict=True)])
    found: tuple[float, float, float, float] = pull_pair(parameters._replace(many=two), at, (0, 1), (apart, 0.0))
    return found


def _turned(points: Array, angle: float) -> Array:
    c, s = math.cos(angle), math.sin(angle)
    return np.asarray(points @ np.array([[c, s], [-s, c]]))


def touching_distance(parameters: Parameters, pair: tuple[int, int], turns: tuple[float, float]) -> float:
    """How far apart the centers of two bodies are that touch, the second to the right of the first: by halving."""
    outlines = _two(parameters.many.outlines, pair)
    near, far = 0.0, 2.0 * float(parameters.floats.radius[list(pair)].max())
    found = np.zeros((parameters.many.places, 8))
    for _ in range(30):
        middle = 0.5 * (near + far)
        stance = Stance(np.array([[0.0, 0.0], [middle, 0.0]]), np.array(turns), np.zeros_like(outlines.corner))
        turn_corners(outlines, stance)
        total = bodies_near(outlines, stance, 0, 1, far, found)
        apart = total == 0 or float(found[:total, 0].min()) > 0.0
        near, far = (near, middle) if apart and middle > 1e-3 * far else (middle, far)
    return far


def _two(outlines: Outlines, pair: tuple[int, int]) -> Outlines:
    """The outlines of two bodies alone, which may be one and its copy."""
    corners = [slice(outlines.first_corner[k], outlines.first_corner[k + 1]) for k in pair]
    edges = [slice(outlines.first_edge[k], outlines.first_edge[k + 1]) for k in pair]
    first = _firsts([part.stop - part.start for part in corners])
    return Outlines(
        outlines.axes[list(pair)],
        outlines.rounding[list(pair)],
        np.concatenate([outlines.corner[part] for part in corners]),
        first,
        np.concatenate(
            [outlines.edge[e] - c.start + first[k] for k, (e, c) in enumerate(zip(edges, corners, strict=True))]
        ),
        _firsts([part.stop - part.start for part in edges]),
    )


def overlaps(parameters: Parameters, position: Array, angle: Array, reach: float) -> list[tuple[int, int, float]]:
    """Pairs (i, j, gap) nearer than `reach`; a wall number k stands as N + k. For starts and frames: each with each."""
    many, radius, count = parameters.many, parameters.floats.radius, len(position)
    stance = Stance(np.ascontiguousarray(position), np.ascontiguousarray(angle), np.zeros_like(many.outlines.corner))
    turn_corners(many.outlines, stance)
    near, found = np.zeros((many.places, 8)), []
    for i in range(count):
        apart = np.hypot(*(position[i + 1 :] - position[i]).T)
        for j in i + 1 + np.flatnonzero(apart < radius[i] + radius[i + 1 :] + reach):
            total = bodies_near(many.outlines, stance, i, int(j), reach, near)
            if total:
                found.append((i, int(j), float(near[:total, 0].min())))
        for wall in range(wall_count(parameters.walls)):
            total = wall_near(many.outlines, stance, parameters.walls, (i, wall), reach, near)
            if total:
                found.append((i, count + wall, float(near[:total, 0].min())))
    return found
