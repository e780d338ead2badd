"""Behind the walls: nobody gets out. In a smooth flow nobody tries, and the count of hits says so.

Whoever is found outside after a drift flies it again through `ecume.engine.walls`: first surface hit, what remains of
the step, second surface, and on. With walls = "reflect" there is nothing else that holds the liquid.
"""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np

from ecume._jit import prange, spread
from ecume._portable import dot
from ecume.engine.cells import Integers
from ecume.engine.shapes import Ball, Flags, Polygon, Shape
from ecume.engine.walls import Sheet, Surfaces, box, disc, outside, planes, polygon, reflect_all, sheet, together
from ecume.engine.walls.sheets import RESTITUTION, SIZE, SPEED, gap_to, inward_normal, worst_gap
from ecume.engine.walls.surfaces import PLANE
from ecume.errors import BadInput, Fault, SceneError
from ecume.models.sph.solids import shape_of
from ecume.scenes.sph import SIDES, SphScene
from ecume.units import Array

OFF = 1e-3
"""How far off the walls the guard keeps particles, in spacings."""
STANDOFF = 0.1
"""Who is closer than this, in spacings, is pushed off (see `standoff`). Wider ones slow the front of a dam break."""


class Guard(NamedTuple):
    """The surfaces that turn particles back."""

    sheet: Sheet
    owner: Integers
    """(K,) the side or obstacle that each surface belongs to"""
    radius: float
    """m, how far off the surface everyone is kept"""
    reach: float
    """m, who is closer than this is pushed off; zero where walls do nothing but reflect"""


def guard_of(scene: SphScene) -> Guard:
    """All sides that are walls, and all obstacles."""
    pieces, owner, restitution = [], list[int](), list[float]()
    low, high = np.array(scene.tank.low), np.array(scene.tank.high)
    for number, name in enumerate(SIDES[: 2 * len(low)]):
        if getattr(scene.tank, name).kind == "wall":
            normal = (1.0 - 2.0 * (number % 2)) * np.eye(len(low))[number // 2]
            pieces.append(planes([high if number % 2 else low], [normal]))
            owner.append(number)
            restitution.append(scene.tank.restitution)
    for index, spec in enumerate(scene.obstacles):
        pieces.append(_obstacle(shape_of(spec), f"obstacles[{index}]"))
        owner += [2 * len(low) + index] * len(pieces[-1].kind)
        own = scene.tank.restitution if spec.restitution is None else spec.restitution
        restitution += [own] * len(pieces[-1].kind)
    walls = together(*pieces) if pieces else box(low.tolist(), high.tolist())._replace(**_nothing(len(low)))
    packed = sheet(walls, np.array(restitution))
    reach = STANDOFF * scene.spacing * (scene.tank.walls != "reflect")
    return Guard(packed, np.array(owner, np.int64), OFF * scene.spacing, reach)


def _nothing(dimension: int) -> dict[str, Any]:
    none = np.zeros(0, np.int64)
    return {
        "kind": none,
        "place": np.zeros((0, 3)),
        "size": np.zeros(0),
        "velocity": np.zeros((0, 3)),
        "face": np.zeros((0, 2), np.int64),
    }


def _obstacle(shape: Shape, path: str) -> Surfaces:
    try:
        if isinstance(shape, Ball):
            return outside(disc(tuple(shape.center), shape.radius))
        low, high = shape.bounds()
        return outside(polygon(shape.vertices) if isinstance(shape, Polygon) else box(low.tolist(), high.tolist()))
    except BadInput as error:
        raise SceneError([Fault(f"{path}.vertices", str(error))]) from error


@spread
def flag_outside(position: Array, kind: Integers, number: Array, radius: float, out: Flags) -> None:
    """Who is behind a surface, or closer to it than the radius."""
    for i in prange(position.shape[1]):
        z = position[2, i] if position.shape[0] == 3 else 0.0
        gap, _ = worst_gap(kind, number, (position[0, i], position[1, i], z), 0.0)
        out[i] = gap < radius


def turn_back(guard: Guard, position: Array, velocity: Array, transport: Array, time: float) -> Integers:
    """Let whoever is outside after a drift of that time fly it again, in place; (K,) the hits at each surface."""
    hits = np.zeros(len(guard.owner), np.int64)
    out = np.zeros(position.shape[1], np.bool_)
    if not len(hits):
        return hits
    flag_outside(position, guard.sheet.kind, guard.sheet.number, guard.radius, out)
    if not out.any():
        return hits
    before = velocity[:, out] + transport[:, out]
    x = np.ascontiguousarray((position[:, out] - time * before).T)
    v = before.T.copy()  # a copy in any case: columns that were picked may lie the other way round in memory
    fate = np.zeros(len(x), np.int64)
    tally = (np.zeros_like(fate), fate, hits)
    earlier = _as_before(guard.sheet, time)
    reflect_all(x, v, np.zeros((1, x.shape[1])), time, earlier, np.array([guard.radius]), tally)
    for i in np.flatnonzero(fate < 0):
        x[i] = position[:, np.flatnonzero(out)[i]]
        _push_inside(guard, x[i], v[i], hits)
    position[:, out] = x.T
    velocity[:, out] += v.T - before
    return hits


def _as_before(packed: Sheet, time: float) -> Sheet:
    """Where moving planes were at the start of the drift; the engine moves them on."""
    number = packed.number.copy()
    flat = packed.kind[:, 0] == PLANE
    way = time * (number[:, :3] * number[:, SPEED : SPEED + 3]).sum(axis=1)
    number[flat, SIZE] -= way[flat]
    return packed._replace(number=number)


def _push_inside(guard: Guard, x: Array, v: Array, hits: Integers) -> None:
    """Who started outside, since a wall came over it, is put onto the wall and goes no further into it."""
    kind, number = guard.sheet.kind, guard.sheet.number
    for _ in range(4):
        here = (x[0], x[1], x[2] if len(x) == 3 else 0.0)
        gap, k = worst_gap(kind, number, here, 0.0)
        if gap >= guard.radius:
            return
        normal = np.array(inward_normal(kind, number, k, here, 0.0))[: len(x)]
        x += (guard.radius * (1.0 + 1e-9) - gap_to(kind, number, k, here, 0.0)) * normal
        approach = dot(v - number[k, SPEED : SPEED + len(x)], normal)
        if approach < 0.0:
            v -= (1.0 + number[k, RESTITUTION]) * approach * normal
        hits[k] += 1
