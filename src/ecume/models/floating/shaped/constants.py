"""The constants of floats with shapes: the tables of all bodies, and their time scales."""

from __future__ import annotations

import itertools
import math
from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np

from ecume.engine.cells import Integers
from ecume.engine.outlines import Outlines, Stance, bodies_near, turn_corners
from ecume.errors import Fault, SceneError
from ecume.models.floating.dishes import wall_strengths
from ecume.models.floating.forces.flow_and_noise import fastest_at_nodes
from ecume.models.floating.options import Built
from ecume.models.floating.parameters import Parameters
from ecume.models.floating.setup.kinds import distinct_kinds
from ecume.models.floating.setup.places import given_places
from ecume.models.floating.shaped.bodies import Shaped, body_pair_forces
from ecume.models.floating.shaped.shapes import Figure, Skeleton, charges_of, inner_radius
from ecume.models.floating.time_integration.step_size import GOOD
from ecume.units import Array

if TYPE_CHECKING:
    from ecume.scenes.floating import FloatingScene


NEIGHBORS = 6.0
NEARLY = 1.001
"""Distance over the touching distance at which the stiffness of the attraction is computed."""

TURN = 0.2
"""rad: the time step is a twentieth of the time for this rotation, since contacts predict tips along straight lines."""

MOST_SHAPES = 100_000
"""The largest number of floats with a shape. Each has ten to a hundred charges, so that a step sums over about 1e9
pairs.
"""

DIFFERENCE = 1e-4
"""Step of finite differences, over the radius or in rad."""


def shapes_of(parameters: Parameters, scene: FloatingScene) -> Built:
    """Return floats that turn and touch at their outlines. Raises SceneError if they are too large for the dish."""
    if faults := [*_too_many(len(parameters.floats.radius)), *_too_flat(parameters, parameters.walls.disc_radius)]:
        raise SceneError(faults)
    kinds, number = distinct_kinds(scene)
    figures = [kind.figure for kind in kinds]
    shaped = make_shaped([figures[k] for k in number], drag=scene.hydrodynamics.resists)
    strength = wall_strengths(scene, parameters.floats._replace(charge=shaped.charge))
    shaped = shaped._replace(wall_strength=strength)
    widths = np.array([inner_radius(figure.skeleton) for figure in figures])[number]
    times = [shortest_time(shaped, parameters, number), spinning_time(shaped, parameters, scene), flow_time(parameters)]
    return Built(shaped, min(*times, diffusion_time(shaped, parameters.drift.thermal, widths)))


def diffusion_time(shaped: Shaped, thermal: float, width: Array) -> float:
    """The time scale (s) of diffusion. In a step of GOOD times this scale, noise moves a body by at most GOOD of its
    `width` and rotates it by at most GOOD rad (r.m.s. along one axis).
    """
    if thermal == 0.0:
        return math.inf
    moving = width**2 * shaped.friction[:, :2].min(axis=1)
    return GOOD / (2.0 * thermal) * min(float(moving.min()), float(shaped.friction[:, 2].min()))


def make_shaped(figures: Sequence[Figure], *, drag: bool = True) -> Shaped:
    """Return the tables of all bodies."""
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
        elongation=np.array([figure.elongation for figure in figures]),
        places=_most_places([figure.skeleton for figure in figures]),
    )


def outlines_of(skeletons: Sequence[Skeleton]) -> Outlines:
    """Return the outlines of all bodies."""
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
    """The largest number of contact points of two bodies."""
    corners = max(len(skeleton.corners) for skeleton in skeletons)
    edges = max(len(skeleton.edges) for skeleton in skeletons)
    return 1 + corners + edges + corners * corners + 2 * corners * edges


def _too_many(count: int) -> list[Fault]:
    """The fault that there are too many floats for sums over the charges of each pair."""
    if count <= MOST_SHAPES:
        return []
    return [Fault("particles", f"got {count} floats in a scene with shapes; expected at most {MOST_SHAPES}")]


def _too_flat(parameters: Parameters, dish_radius: float) -> list[Fault]:
    """The fault that a float is so large that it would touch a round wall at two points."""
    if float(parameters.floats.radius.max()) < 0.5 * dish_radius:
        return []
    return [Fault("dish.radius", f"{dish_radius:g} m is less than twice the radius of a float with a shape")]


def shortest_time(shaped: Shaped, parameters: Parameters, number: Integers) -> float:
    """The shortest time scale (s) of oscillation or relaxation of a pair, for six touching neighbors."""
    first = [int(np.flatnonzero(number == kind)[0]) for kind in np.unique(number)]
    found = [_times(shaped, parameters, (i, j)) for i, j in itertools.combinations_with_replacement(first, 2)]
    return min(found, default=math.inf)


def spinning_time(shaped: Shaped, parameters: Parameters, scene: FloatingScene) -> float:
    """The time (s) in which a float turns by `TURN`, at its initial spin or if the whole initial kinetic energy becomes
    rotation.
    """
    starts = given_places(scene).velocity
    speed = float(np.hypot(starts[:, 0], starts[:, 1]).max())
    spin = speed * math.sqrt(float(np.max(parameters.floats.mass / shaped.inertia)))
    spin += max((abs(row.spin) for row in scene.rows), default=0.0)
    return TURN / spin if spin > 0.0 else math.inf


def flow_time(parameters: Parameters) -> float:
    """The time (s) in which the flow of the surface turns a float by `TURN`, at least."""
    drift = parameters.drift
    rate = float(np.abs(drift.flow[2:]).sum()) + fastest_at_nodes(drift) / float(parameters.floats.radius.min())
    return TURN / rate if rate > 0.0 else math.inf


def _times(shaped: Shaped, parameters: Parameters, pair: tuple[int, int]) -> float:
    """The shortest time scale (s) of two touching bodies, over all their angles."""
    times = []
    ways = 0.0, 0.25 * math.pi, 0.5 * math.pi
    for turns in itertools.product(ways, ways):
        glide, turn = _stiffnesses(shaped, parameters, pair, turns)
        masses = parameters.floats.mass
        for i in pair:
            for stiff, inertia, friction in (
                (glide, masses[i], shaped.friction[i, :2].min()),
                (turn, shaped.inertia[i], shaped.friction[i, 2]),
            ):
                if stiff > 0.0:
                    slow = 0.0 if not parameters.scheme.inertia else math.sqrt(inertia / (NEIGHBORS * stiff))
                    times.append(max(slow, friction / (NEIGHBORS * stiff)))
    return min(times, default=math.inf)


def _stiffnesses(
    shaped: Shaped, parameters: Parameters, pair: tuple[int, int], turns: tuple[float, float]
) -> tuple[float, float]:
    """The stiffnesses |dF/dl| (N/m) and |d torque/d angle| (N m) of two touching bodies, by finite differences."""
    apart = touching_distance(shaped, parameters, pair, turns) * NEARLY
    size = DIFFERENCE * float(parameters.floats.radius[list(pair)].min())
    near, far = (_pull(shaped, parameters, pair, turns, apart + step) for step in (0.0, size))
    turned = _pull(shaped, parameters, pair, (turns[0] + DIFFERENCE, turns[1]), apart)
    return abs(far[0] - near[0]) / size, abs(turned[2] - near[2]) / DIFFERENCE


def _pull(
    shaped: Shaped, parameters: Parameters, pair: tuple[int, int], turns: tuple[float, float], apart: float
) -> tuple[float, float, float, float]:
    """The forces and torques of two bodies, the second to the right of the first."""
    blocks = [slice(shaped.first[k], shaped.first[k + 1]) for k in pair]
    two = shaped._replace(
        charge=np.concatenate([shaped.charge[block] for block in blocks]),
        first=_firsts([block.stop - block.start for block in blocks]),
    )
    at = np.concatenate([_turned(shaped.place[block], turn) for block, turn in zip(blocks, turns, strict=True)])
    found: tuple[float, float, float, float] = body_pair_forces(two, parameters, at, (0, 1), (apart, 0.0))
    return found


def _turned(points: Array, angle: float) -> Array:
    c, s = math.cos(angle), math.sin(angle)
    return np.asarray(points @ np.array([[c, s], [-s, c]]))


def touching_distance(
    shaped: Shaped, parameters: Parameters, pair: tuple[int, int], turns: tuple[float, float]
) -> float:
    """The distance of the centers of two touching bodies, the second to the right of the first, by bisection."""
    outlines = _two(shaped.outlines, pair)
    near, far = 0.0, 2.0 * float(parameters.floats.radius[list(pair)].max())
    found = np.zeros((shaped.places, 8))
    for _ in range(30):
        middle = 0.5 * (near + far)
        stance = Stance(np.array([[0.0, 0.0], [middle, 0.0]]), np.array(turns), np.zeros_like(outlines.corner))
        turn_corners(outlines, stance)
        total = bodies_near(outlines, stance, 0, 1, far, found)
        apart = total == 0 or float(found[:total, 0].min()) > 0.0
        near, far = (near, middle) if apart and middle > 1e-3 * far else (middle, far)
    return far


def _two(outlines: Outlines, pair: tuple[int, int]) -> Outlines:
    """The outlines of two bodies; both may be the same body."""
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
