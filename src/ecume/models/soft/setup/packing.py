"""Random dense starts: points at random in the box, pushed apart until no two spheres are nearer than a gap."""

from __future__ import annotations

import math

import numpy as np
from scipy.optimize import minimize

from ecume.engine.walls import nearest_points
from ecume.errors import Fault, SceneError
from ecume.models.soft.contacts.contact_list import neighbors, wall_gaps
from ecume.models.soft.loading.cell import Box, box_of, shape_at
from ecume.models.soft.loading.protocol import drive_at
from ecume.models.soft.parameters import Parameters
from ecume.scenes.soft import SoftScene, sides_of
from ecume.units import Array
from ecume.value_texts import with_prefix

GAP = 1e-2
"""Of the smallest radius."""
WIDER = 1.05
"""Spheres are pushed apart as if their gap were this much wider, so that it is there when they have nearly stopped."""
WAY_OUT = "expected a larger cell.size, a smaller cell.volume_fraction or a smaller cell.minimum_gap"
ROUNDS, PUSHES = 20, 400
"""Of the minimization: at most so many rounds of so many evaluations."""


def places(scene: SoftScene, parameters: Parameters) -> Array:
    """The initial positions: as given, or random from the seed of the scene."""
    given = [place for species in scene.particles for place in species.positions]
    if all(species.count is None for species in scene.particles):
        return np.array(given, np.float64)
    random = np.random.default_rng(scene.seed)
    box = box_of(parameters.box, shape_at(parameters.box, drive_at(parameters.protocol, 0.0)), parameters.dimensions)
    ends = np.where(box.sides > 0.0, box.sides, sides_of(scene) or 0.0)
    position = random.uniform(size=(len(parameters.radius), parameters.dimensions)) * ends
    begin = 0
    for species in scene.particles:
        end = begin + (species.count or len(species.positions))
        if species.positions:
            position[begin:end] = species.positions
        begin = end
    least = (
        GAP * float(parameters.radius.min())
        if scene.cell is None or scene.cell.minimum_gap is None
        else scene.cell.minimum_gap
    )
    _require_room(parameters, np.where(box.sides > 0.0, ends, ends + 2.0 * parameters.radius.max()), least)
    return pushed_apart(parameters, position, box, least)


def _require_room(parameters: Parameters, ends: Array, least: float) -> None:
    """Raise SceneError if spheres with half of the least gap around each would fill more than the whole region."""
    unit = math.pi if parameters.dimensions == 2 else 4.0 / 3.0 * math.pi
    filled = unit * float(((parameters.radius + 0.5 * least) ** parameters.dimensions).sum()) / float(np.prod(ends))
    if filled > 1.0:
        message = f"spheres with gaps of {with_prefix(least, 'm', 3)} would fill {filled:.3g} times the region"
        raise SceneError([Fault("cell.size", f"{message}; {WAY_OUT}")])


def pushed_apart(parameters: Parameters, position: Array, box: Box, least: float) -> Array:
    """The nearest places, more or less, without gaps below `least`: overlaps cost their square. Raises SceneError."""
    wide = parameters._replace(contacts=parameters.contacts._replace(fade_from=WIDER * least))
    unit, walls = float(parameters.radius.min()), parameters.walls.surfaces
    points = nearest_points(walls)

    def cost(flat: Array) -> tuple[float, Array]:
        pair, _, between = neighbors(wide, flat.reshape(position.shape) * unit, box)
        length = np.linalg.norm(between, axis=1)
        overlap = (parameters.radius[pair].sum(axis=1) + WIDER * least - length) / unit
        push = (overlap / np.maximum(length, 1e-12 * unit))[:, None] * between
        slope = np.zeros_like(position)
        np.add.at(slope, pair[:, 0], push)
        np.add.at(slope, pair[:, 1], -push)
        to_wall = wall_gaps(parameters, flat.reshape(position.shape) * unit, points)
        inside = np.maximum(WIDER * least - to_wall, 0.0)
        for wall, normal in enumerate(walls.place[:, : position.shape[1]]):
            slope -= inside[:, wall, None] / unit * normal
        return 0.5 * float((overlap**2).sum() + ((inside / unit) ** 2).sum()), slope.ravel()

    flat = position.ravel() / unit
    tight = parameters._replace(contacts=parameters.contacts._replace(fade_from=least))
    for _ in range(ROUNDS):
        flat = minimize(
            cost, flat, jac=True, method="L-BFGS-B", options={"maxiter": PUSHES, "ftol": 0.0, "gtol": 1e-12}
        ).x
        found = np.asarray(flat.reshape(position.shape) * unit)
        if not len(neighbors(tight, found, box)[0]) and (wall_gaps(parameters, found, points) >= least).all():
            return found
    message = f"no places were found with gaps of {with_prefix(least, 'm', 3)} everywhere"
    raise SceneError([Fault("cell.size", f"{message}; {WAY_OUT}")])
