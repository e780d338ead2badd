"""The shapes that a dish can have: `SHAPES`, the table of them.

A row holds everything that depends on the shape. Distances, normals, the region inside, its outline in pictures and
on pages, and the places where floats can start follow from its surfaces (`ecume.engine.walls`).
"""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from ecume.engine import walls as surfaces
from ecume.engine.walls import Surfaces, Walls, enclosed_by, enclosures, no_walls, wall_count
from ecume.laws import flotation
from ecume.models.floating import menisci
from ecume.models.floating.menisci import FACING, ROUND, Meniscus
from ecume.models.floating.options import scene_error
from ecume.models.floating.parameters import Floats
from ecume.models.liquids import liquid_of
from ecume.units import Array

if TYPE_CHECKING:
    from ecume.scenes.floating import DishSpec, FloatingScene


FIRST_MODE = 1.8411837813406593
"""The first zero of J1'."""


class Shape(NamedTuple):
    """A row of the table: the shape of a dish and everything that depends on it."""

    key: str
    """the key of `[dish]` that gives its size, `radius` or `size`"""
    surfaces: Callable[[Any], Surfaces]
    """surfaces(the value of that key): a convex 2D shape around the origin"""
    meniscus: Meniscus | None
    """the menisci at the walls; None if they are not known"""
    no_meniscus: str = ""
    """the reason if they are not known"""
    wavenumber: Callable[[Walls], float] = lambda walls: FIRST_MODE * math.sqrt(math.pi / enclosures.area(walls))
    """of the first sloshing mode (1/m). Default: that of a circle of the same area, the largest for that area"""


SHAPES = {
    "round": Shape(
        "radius",
        lambda radius: surfaces.disc((0.0, 0.0), radius),
        ROUND,
        wavenumber=lambda walls: FIRST_MODE / walls.disc_radius,
    ),
    "rectangle": Shape(
        "size",
        lambda size: surfaces.box((-0.5 * size[0], -0.5 * size[1]), (0.5 * size[0], 0.5 * size[1])),
        FACING,
        wavenumber=lambda walls: 0.5 * math.pi / max(enclosures.bounds(walls)[1]),
    ),
}
"""By the names of `dish.shape`. Without a name, the first row that takes the given key."""


def name_of(dish: DishSpec) -> str:
    """The name of the shape of a dish. Raises SceneError for an unknown name, or a wrong key for the size."""
    given = next(row.key for row in SHAPES.values() if getattr(dish, row.key) is not None)
    name = dish.shape or next(name for name, row in SHAPES.items() if row.key == given)
    if name not in SHAPES:
        raise scene_error("dish.shape", f"got {name!r}; expected one of {', '.join(map(repr, SHAPES))}")
    if SHAPES[name].key != given:
        raise scene_error(f"dish.{given}", f"a dish of the shape {name!r} takes {SHAPES[name].key!r}; got {given!r}")
    return name


def walls_of(dish: DishSpec | None) -> Walls:
    """The walls, at least a radius away from all centers; no walls without a dish."""
    if dish is None:
        return no_walls()
    row = SHAPES[name_of(dish)]
    return enclosed_by(row.surfaces(getattr(dish, row.key)))


def outline_of(dish: DishSpec) -> Array:
    """The edge of the dish as points of a polygon, counterclockwise, (n, 2) m."""
    return enclosures.outline(walls_of(dish))


def sloshing_wavenumber(dish: DishSpec) -> float:
    """The wavenumber of the first sloshing mode (1/m); in a rectangle along its longer side."""
    return SHAPES[name_of(dish)].wavenumber(walls_of(dish))


def meniscus_of(dish: DishSpec) -> Meniscus:
    """The kind of meniscus at the walls of a dish. Raises SceneError if it is not known."""
    name = name_of(dish)
    row = SHAPES[name]
    if row.meniscus is None:
        path, got = ("dish.law", dish.law) if dish.law != "none" else ("dish.image", dish.image)
        raise scene_error(path, f"got {got!r} for the shape {name!r}; expected 'none': {row.no_meniscus}")
    return row.meniscus


def _has_meniscus(dish: DishSpec | None) -> bool:
    return dish is not None and not (dish.law == "none" and dish.image == "none")


def wall_law_of(scene: FloatingScene) -> int:
    """The compiled law that the walls follow."""
    dish = scene.dish
    return menisci.law_of(dish, meniscus_of(dish)) if dish and _has_meniscus(dish) else menisci.NO_WALL_LAW


def wall_strengths(scene: FloatingScene, floats: Floats) -> Array:
    """(walls, N) in J: the strength of the meniscus of each wall for each float."""
    dish, count = scene.dish, wall_count(walls_of(scene.dish))
    if dish is None or not _has_meniscus(dish):
        return np.zeros((count, len(floats.radius)))
    return menisci.strengths(scene, floats, meniscus_of(dish), count)


def wall_table_of(scene: FloatingScene, radii: tuple[float, float]) -> Array:
    """The table of the walls, or an empty one."""
    dish = scene.dish
    if dish is None or not _has_meniscus(dish):
        return menisci.no_table()
    return menisci.wall_table(dish, liquid_of(scene), radii, meniscus_of(dish))


def field_of(dish: DishSpec | None, liquid: flotation.Liquid, x: Array, y: Array) -> Array:
    """The height of the menisci of the walls alone (m), shape (y, x), for pictures."""
    if dish is None or dish.law == "none":
        return np.zeros((len(y), len(x)))
    return meniscus_of(dish).field(dish, liquid, x, y)
