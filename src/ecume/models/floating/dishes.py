"""The shapes of dishes, and the menisci at their walls: heights, and forces on floats, also for compiled code.

There are five kinds of menisci, one record each: inside a round wall (`ROUND`), between two round walls
(`BETWEEN_ROUND`), between two pairs of facing walls (`FACING`, and `LEANING` in a tilted dish), and along the tangents
of an ellipse (`OVAL`), which is also the cut of a tilted round dish by the level surface. Compiled code selects a law
by its number.

Exact menisci and mirror images have no closed formula. A table has heights and image energies of a unit charge with
their slopes, at distances evenly spaced in their logarithm, and a cubic Hermite polynomial between them. Forces are the
slopes of the polynomial, so that energy is conserved.

`SHAPES` is the table of the shapes of a dish. A row contains everything that depends on the shape. Distances, normals,
the region inside, the outline in pictures and on pages, and the places where floats can start follow from the surfaces
(`ecume.engine.walls`).
"""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Callable, Mapping
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from ecume._jit import admit, compiled_inside
from ecume.engine.walls import Surfaces, Walls, enclosed_by, no_walls, rings, surfaces, wall_count
from ecume.engine.walls.rings import is_inner, wall_distance
from ecume.errors import BadInput
from ecume.laws import capillarity, flotation, meniscus, ring_meniscus, special
from ecume.laws.capillarity import (
    dish_energy,
    dish_force,
    plane_wall_energy,
    plane_wall_force,
    two_point_legacy_energy,
    two_point_legacy_force,
)
from ecume.laws.ring_meniscus import inner_wall_energy, inner_wall_force
from ecume.models.floating.options import scene_error
from ecume.models.floating.parameters import CAPILLARY_LENGTH, Floats, Parameters
from ecume.models.liquids import liquid_of
from ecume.units import Array

if TYPE_CHECKING:
    from ecume.scenes.floating import DishSpec, FloatingScene

admit(special, capillarity, ring_meniscus)

NO_WALL_LAW, DISH, LEGACY_DISH, PLANE, TABLED, RING = range(6)
"""Laws of walls in compiled code: no meniscus; the far field of `meniscus` and `linear` in a round dish; that of
`two-point-legacy`; the far field at plane walls; a table, for exact profiles and images; the far field in a ring.
"""
HEIGHT, IMAGE = 2, 4
"""Rows of a table: each of these two, and its slope over ln(d) below it. Row 0 starts with ln(d) of the first node and
the step; row 1 holds the distances.
"""


@compiled_inside
def acts(parameters: Parameters) -> bool:
    """Whether walls exert forces on floats at a distance."""
    return parameters.wall_law != NO_WALL_LAW


def is_far_field(wall_law: int) -> bool:
    """Whether the walls have the meniscus of superposition without images, or no meniscus, as other methods require."""
    return wall_law in (NO_WALL_LAW, DISH, PLANE, RING)


def wall_stiffness(parameters: Parameters) -> float:
    """The largest |dF/dd| of the walls on any float (N/m), at the smallest possible distance."""
    if parameters.wall_law == PLANE and wall_count(parameters.walls) > APART:
        return _stiffness_together(parameters)
    if parameters.wall_law == RING:
        return _stiffness_in_ring(parameters)
    strongest = float(np.max(np.abs(parameters.wall_strength), initial=0.0))
    if parameters.wall_law != TABLED:
        return strongest / float(parameters.pair[CAPILLARY_LENGTH]) ** 2
    floats, distance = parameters.floats, parameters.wall_table[1]
    near = distance >= float(np.min(floats.radius))
    stiffness = 0.0
    for row, strength in ((HEIGHT, strongest), (IMAGE, parameters.image_strength * float(np.max(floats.charge**2)))):
        force = parameters.wall_table[row + 1] / distance
        stiffness += strength * float(np.max(np.abs(np.gradient(force, distance)[near])))
    return stiffness


def _stiffness_in_ring(parameters: Parameters) -> float:
    """The largest |dF/dd| at the outer wall, and beside the inner one, where it is that of K1, K0 + K1/r, in lengths
    of L.
    """
    length = float(parameters.pair[CAPILLARY_LENGTH])
    outer, inner = np.abs(parameters.wall_strength).max(axis=1, initial=0.0).tolist()
    b = rings.inner_radius_of(parameters.walls) / length
    x = b + float(np.min(parameters.floats.radius)) / length
    bent = special.scaled_bessel_k0(x) + special.scaled_bessel_k1(x) / x
    return float(outer + inner * bent / special.scaled_bessel_k1(b) * math.exp(b - x)) / length**2


APART = 4
"""The number of walls of a rectangle, whose menisci do not overlap, as do those of more walls."""


def _stiffness_together(parameters: Parameters) -> float:
    """The largest |dF/dd| of the menisci of all walls together on any float (N/m), at the corners between them."""
    walls, length = parameters.walls, float(parameters.pair[CAPILLARY_LENGTH])
    strength = parameters.wall_strength[:, np.argmax(np.abs(parameters.wall_strength).sum(axis=0))]
    away = surfaces.corners(walls) @ walls.normal.T - walls.offset
    bent = np.exp(-away / length) * strength / length**2
    curvature = np.einsum("ck,ki,kj->cij", bent, walls.normal, walls.normal)
    return float(np.abs(np.linalg.eigvalsh(curvature)).max(initial=0.0))


@compiled_inside
def wall_force(
    parameters: Parameters, number: int, place: tuple[float, float], strength: float, charge: float
) -> tuple[float, float, float]:
    """The force of wall `number` on a charge at `place` (N), positive away from the wall, and the normal of the
    wall.
    """
    walls, length, (x, y) = parameters.walls, parameters.pair[CAPILLARY_LENGTH], place
    distance, inward_x, inward_y = wall_distance(walls, number, x, y)
    if parameters.wall_law == PLANE:
        away = plane_wall_force(distance, strength, length)
    elif parameters.wall_law == DISH:
        away = dish_force(math.sqrt(x * x + y * y), strength, length, walls.disc_radius)
    elif parameters.wall_law == TABLED:
        mirrored = parameters.image_strength * charge * charge
        away = -strength * tabled(parameters.wall_table, HEIGHT, distance)[1]
        away -= mirrored * tabled(parameters.wall_table, IMAGE, distance)[1]
    elif parameters.wall_law == RING and is_inner(walls, number):
        away = inner_wall_force(math.sqrt(x * x + y * y), strength, length, walls.offset[-1])
    elif parameters.wall_law == RING:
        away = dish_force(math.sqrt(x * x + y * y), strength, length, walls.disc_radius)
    else:
        away = two_point_legacy_force(math.sqrt(x * x + y * y), strength, length, walls.disc_radius)
    return away, inward_x, inward_y


@compiled_inside
def wall_energy(
    parameters: Parameters, number: int, place: tuple[float, float], strength: float, charge: float
) -> tuple[float, float]:
    """The energy (J) of a charge at a position near wall `number`: in the meniscus of the wall, and with its mirror
    image.
    """
    walls, length, (x, y) = parameters.walls, parameters.pair[CAPILLARY_LENGTH], place
    if parameters.wall_law == PLANE:
        return plane_wall_energy(wall_distance(walls, number, x, y)[0], strength, length), 0.0
    if parameters.wall_law == DISH:
        return dish_energy(math.sqrt(x * x + y * y), strength, length, walls.disc_radius), 0.0
    if parameters.wall_law == TABLED:
        distance = wall_distance(walls, number, x, y)[0]
        mirrored = parameters.image_strength * charge * charge
        height, image = tabled(parameters.wall_table, HEIGHT, distance), tabled(parameters.wall_table, IMAGE, distance)
        return strength * height[0], mirrored * image[0]
    if parameters.wall_law == RING and is_inner(walls, number):
        return inner_wall_energy(math.sqrt(x * x + y * y), strength, length, walls.offset[-1]), 0.0
    if parameters.wall_law == RING:
        return dish_energy(math.sqrt(x * x + y * y), strength, length, walls.disc_radius), 0.0
    return two_point_legacy_energy(math.sqrt(x * x + y * y), strength, length, walls.disc_radius), 0.0


@compiled_inside
def tabled(table: Array, row: int, distance: float) -> tuple[float, float]:
    """A tabulated quantity and its slope over the distance; beyond the table, their values at its end."""
    start, step = table[0, 0], table[0, 1]
    last = table.shape[1] - 1
    within = min(max(distance, table[1, 0]), table[1, last])
    place = min(max((math.log(within) - start) / step, 0.0), float(last))
    left = min(int(place), last - 1)
    t = place - left
    u = 1.0 - t
    rise = table[row, left + 1] - table[row, left]
    before, after = step * table[row + 1, left] - rise, rise - step * table[row + 1, left + 1]
    value = u * table[row, left] + t * table[row, left + 1] + t * u * (u * before + t * after)
    slope = rise + (1.0 - 2.0 * t) * (u * before + t * after) + t * u * (after - before)
    return value, slope / (step * within)


NODES = 600
FAR = 30.0
"""The cutoff of plane walls in capillary lengths, from contact with the largest float."""
HUGGING = 0.01
"""Distance from the wall over the radius of the dish below which the image force is that of a plane wall. It is up to
one percent too weak there, where the sums over images are too long."""


class MultipoleWalls(NamedTuple):
    """The kinds of walls that multipoles can have, each a function that returns multipoles with these walls."""

    round: Callable[[Any, float, float], Any]
    """round(multipoles, radius, contact_angle)"""
    facing: Callable[[Any, tuple[float, float], float, flotation.Liquid], Any]
    """facing(multipoles, size, contact_angle, liquid)"""


class Meniscus(NamedTuple):
    """A kind of meniscus at the walls of a dish, and everything that depends on it."""

    laws: Mapping[str, int]
    """the compiled law for each name that `dish.law` may have"""
    amplitudes: Callable[[DishSpec, flotation.Liquid, str], list[float]]
    """amplitudes(dish, liquid, theory): the far amplitude of each wall's meniscus (m)"""
    tabled_amplitudes: Callable[[DishSpec, flotation.Liquid, str], list[float]]
    """the same, as the table of heights is scaled"""
    farthest: Callable[[DishSpec, flotation.Liquid, float], float]
    """farthest(dish, liquid, largest): the distance (m) from a wall to which tables reach"""
    heights: Callable[[DishSpec, flotation.Liquid, Array], Array]
    """heights(dish, liquid, distance): of a wall's meniscus, over its tabled amplitude"""
    images: Callable[[DishSpec, flotation.Liquid, Array], Array]
    """images(dish, liquid, distance): the energy of a charge in its mirror image, over 2 pi gamma A^2"""
    field: Callable[[DishSpec, flotation.Liquid, Array, Array], Array]
    """field(dish, liquid, x, y): the height on a grid (m), shape (y, x), for pictures"""
    multipoles: Callable[[MultipoleWalls, Any, DishSpec, flotation.Liquid], Any] | None
    """multipoles(walls, multipoles, dish, liquid): the multipoles of all floats between these walls; None if walls of
    this kind have no known echoes
    """
    mirrors: bool = True
    """whether a mirror image at the nearest wall is known"""


# --- the kinds --------------------------------------------------------------------------------------------------------


def _round_amplitudes(dish: DishSpec, liquid: flotation.Liquid, theory: str) -> list[float]:
    return [meniscus.AMPLITUDES[theory](dish.contact_angle, liquid)]


def _round_tabled_amplitudes(dish: DishSpec, liquid: flotation.Liquid, theory: str) -> list[float]:
    _round_amplitudes(dish, liquid, theory)  # refuses angles outside of the range of the theory
    return [liquid.capillary_length]


def _radius(dish: DishSpec) -> float:
    assert dish.radius is not None  # noqa: S101  # the shape requires it
    return dish.radius


def _round_heights(dish: DishSpec, liquid: flotation.Liquid, distance: Array) -> Array:
    theory = {"meniscus": "amplitude", "linear": "linear", "profile": "nonlinear"}[str(dish.law)]
    r, radius = np.maximum(_radius(dish) - distance, 0.0), _radius(dish)
    height = meniscus.dish_height(r, radius, dish.contact_angle, liquid, theory)
    return np.asarray(height) / liquid.capillary_length


def _round_images(dish: DishSpec, liquid: flotation.Liquid, distance: Array) -> Array:
    """The image energy -(1/2) sum_m c_m I_m^2 in a dish."""
    radius, length = _radius(dish), liquid.capillary_length
    plane, away = _plane_images(dish, liquid, distance), distance >= HUGGING * radius
    sums = meniscus.dish_sums((radius - distance[away]) / length, radius / length, meniscus.WALLS[dish.image])
    energy = -0.5 * sums.height
    # Closer to the wall, the energy is that of a plane wall plus a constant.
    beside = energy[0] - plane[away][0]
    return np.concatenate([plane[~away] + beside, energy])


def _round_field(dish: DishSpec, liquid: flotation.Liquid, x: Array, y: Array) -> Array:
    r = np.minimum(np.hypot(x, y[:, None]), _radius(dish))
    height = meniscus.dish_height(r=r, dish_radius=_radius(dish), contact_angle=dish.contact_angle, liquid=liquid)
    return np.asarray(height)


def _round_multipoles(walls: MultipoleWalls, many_floats: Any, dish: DishSpec, liquid: flotation.Liquid) -> Any:
    return walls.round(many_floats, _radius(dish), dish.contact_angle)


ROUND = Meniscus(
    {"meniscus": DISH, "linear": DISH, "profile": TABLED, "two-point-legacy": LEGACY_DISH, "none": NO_WALL_LAW},
    _round_amplitudes,
    _round_tabled_amplitudes,
    lambda dish, liquid, largest: _radius(dish),
    _round_heights,
    _round_images,
    _round_field,
    _round_multipoles,
)


def _sides(dish: DishSpec) -> tuple[float, float]:
    assert dish.size is not None  # noqa: S101  # the shape requires it
    return dish.size


def _facing_amplitudes(dish: DishSpec, liquid: flotation.Liquid, theory: str) -> list[float]:
    """The amplitudes of the left, lower, right and upper wall; a wall that leans has its own."""
    outward = np.array([[-1.0, 0.0], [0.0, -1.0], [1.0, 0.0], [0.0, 1.0]])
    each = np.asarray(meniscus.inclinations(outward, tilt_of(dish))).tolist()
    alone = [meniscus.inclined_amplitude(dish.contact_angle, lean, liquid, theory) for lean in each]
    (left, right), (low, high) = (
        meniscus.facing_pair(alone[axis], alone[axis + 2], side, liquid) for axis, side in enumerate(_cut_sides(dish))
    )
    return [left, low, right, high]


def _cut_sides(dish: DishSpec) -> list[float]:
    """The sides of a rectangle in the level surface: longer along the direction of the tilt. Raises SceneError if the
    tilt is along neither.
    """
    tilt, sides = tilt_of(dish), list(_sides(dish))
    if tilt.angle == 0.0:
        return sides
    quarters = tilt.direction / (0.5 * math.pi)
    if abs(quarters - round(quarters)) > 1e-9:
        got = f"got {math.degrees(tilt.direction):g} deg for a rectangle with menisci"
        known = "the menisci of walls that do not meet at right angles are not known"
        raise scene_error("dish.tilt.direction", f"{got}; expected a multiple of 90 deg, or dish.law = 'none': {known}")
    sides[round(quarters) % 2] /= math.cos(tilt.angle)
    return sides


def _plane_heights(dish: DishSpec, liquid: flotation.Liquid, distance: Array) -> Array:
    if dish.law != "profile":
        return np.exp(-distance / liquid.capillary_length)
    amplitude = meniscus.wall_amplitude(dish.contact_angle, liquid)
    if amplitude == 0.0:
        return np.zeros_like(distance)
    return np.asarray(meniscus.plane_height(distance, dish.contact_angle, liquid)) / amplitude


def _plane_images(dish: DishSpec, liquid: flotation.Liquid, distance: Array) -> Array:
    """The image energy -(1/2) K0(2 d/L) at a plane wall."""
    from scipy.special import k0

    energy: Array = -0.5 * meniscus.WALLS[dish.image] * k0(2.0 * distance / liquid.capillary_length)
    return energy


def _facing_field(dish: DishSpec, liquid: flotation.Liquid, x: Array, y: Array) -> Array:
    amplitudes = _facing_amplitudes(dish, liquid, "amplitude")
    across, along = (
        _between(nodes, side, amplitudes[axis::2], liquid)
        for axis, (nodes, side) in enumerate(zip((x, y), _cut_sides(dish), strict=True))
    )
    return np.asarray(across + along[:, None])


def _between(nodes: Array, side: float, amplitudes: list[float], liquid: flotation.Liquid) -> Array:
    """The height between two facing walls with these amplitudes, the lower wall first."""
    apart = np.maximum(side / 2 + np.stack([nodes, -nodes]), 0.0)
    return np.asarray(np.array(amplitudes) @ np.exp(-apart / liquid.capillary_length))


def _facing_multipoles(walls: MultipoleWalls, many_floats: Any, dish: DishSpec, liquid: flotation.Liquid) -> Any:
    return walls.facing(many_floats, _sides(dish), dish.contact_angle, liquid)


FACING = Meniscus(
    {"meniscus": PLANE, "linear": PLANE, "profile": TABLED, "none": NO_WALL_LAW},
    _facing_amplitudes,
    _facing_amplitudes,
    lambda dish, liquid, largest: FAR * liquid.capillary_length + largest,
    _plane_heights,
    _plane_images,
    _facing_field,
    _facing_multipoles,
)


def _oval_amplitudes(dish: DishSpec, liquid: flotation.Liquid, theory: str) -> list[float]:
    oval = meniscus.Oval(_axes(dish), tilt_of(dish))
    found = meniscus.oval_amplitudes(oval, AROUND, dish.contact_angle, liquid, theory)
    return [float(each) for each in np.asarray(found)]


def _axes(dish: DishSpec) -> tuple[float, float]:
    """The lengths of the axes of an ellipse, or of a circle that is described as one (m)."""
    return _sides(dish) if dish.radius is None else (2.0 * dish.radius, 2.0 * dish.radius)


def _oval_field(dish: DishSpec, liquid: flotation.Liquid, x: Array, y: Array) -> Array:
    walls, length = walls_of(dish), liquid.capillary_length
    height = np.zeros((len(y), len(x)))
    amplitudes = _oval_amplitudes(dish, liquid, "amplitude")
    for normal, offset, amplitude in zip(walls.normal, walls.offset, amplitudes, strict=True):
        away = normal[0] * x + normal[1] * y[:, None] - offset
        height += amplitude * np.exp(-np.maximum(away, 0.0) / length)
    return height


OVAL = Meniscus(
    {"meniscus": PLANE, "linear": PLANE, "none": NO_WALL_LAW},
    _oval_amplitudes,
    _oval_amplitudes,
    lambda dish, liquid, largest: FAR * liquid.capillary_length + largest,
    _plane_heights,
    _plane_images,
    _oval_field,
    None,
    mirrors=False,
)


def _radii(dish: DishSpec) -> tuple[float, float]:
    assert dish.inner_radius is not None  # noqa: S101  # the shape requires it
    return _radius(dish), dish.inner_radius


def _angles(dish: DishSpec) -> tuple[float, float]:
    inner = dish.inner_contact_angle
    return dish.contact_angle, dish.contact_angle if inner is None else inner


def _ring_amplitudes(dish: DishSpec, liquid: flotation.Liquid, theory: str) -> list[float]:
    return list(ring_meniscus.ring_amplitudes(_radii(dish), _angles(dish), liquid, theory))


def _ring_field(dish: DishSpec, liquid: flotation.Liquid, x: Array, y: Array) -> Array:
    outer, inner = _radii(dish)
    # Interpolated between radii, since each height takes Bessel functions.
    r = np.linspace(inner, outer, RADII)
    height = np.asarray(ring_meniscus.ring_height(r, (outer, inner), _angles(dish), liquid))
    return np.asarray(np.interp(np.hypot(x, y[:, None]), r, height))


RADII = 400
"""The number of radii at which the height in a ring is computed for pictures."""
BETWEEN_ROUND = Meniscus(
    {"meniscus": RING, "linear": RING, "none": NO_WALL_LAW},
    _ring_amplitudes,
    _ring_amplitudes,
    lambda dish, liquid, largest: _radius(dish),
    _plane_heights,
    _plane_images,
    _ring_field,
    None,
    mirrors=False,
)
LEANING = FACING._replace(
    laws={name: law for name, law in FACING.laws.items() if law != TABLED}, multipoles=None, mirrors=False
)
"""Between two pairs of facing walls of a tilted dish."""


# --- choices of a scene -----------------------------------------------------------------------------------------------


def law_of(dish: DishSpec, found: Meniscus) -> int:
    """The compiled law of the walls of a dish with this kind of meniscus. Raises SceneError for other laws."""
    law = str(dish.law)
    if law not in found.laws:
        known = ", ".join(repr(name) for name in found.laws)
        raise scene_error(
            "dish.law", f"got {law!r}, which is not known for this shape of the dish; expected one of {known}"
        )
    code = found.laws[law]
    if dish.image == "none":
        return code
    if not found.mirrors:
        named = {"ellipse": "an ellipse", "ring": "a ring"}
        where = "a tilted dish" if dish.tilt is not None else named[name_of(dish)]
        raise scene_error(
            "dish.image", f"got {dish.image!r} in {where}; expected 'none': no image at its wall is known"
        )
    if code == LEGACY_DISH:
        raise scene_error("dish.image", f"{dish.law!r} has no images; expected image = 'none', or another law")
    return TABLED


def strengths(scene: FloatingScene, floats: Floats, found: Meniscus, count: int) -> Array:
    """(walls, N) in J: the strength of the meniscus of each of these walls for each float."""
    dish, liquid = scene.dish, liquid_of(scene)
    assert dish is not None  # noqa: S101  # only asked with a dish
    tension, law = liquid.surface_tension, law_of(dish, found)
    if law == LEGACY_DISH:
        bonds = (floats.radius / liquid.capillary_length) ** 2
        wall_ratio = (dish.density - liquid.gas_density) / liquid.density_difference
        weight = flotation.weight_number(wall_ratio, dish.contact_angle)
        rows = [
            capillarity.legacy_wall_strength(tension, radius, bond, weight)
            for radius, bond in zip(floats.radius, bonds, strict=True)
        ]
        return np.array([rows])
    amplitudes = [0.0] * count
    if dish.law != "none":
        amplitudes_of = found.tabled_amplitudes if law == TABLED else found.amplitudes
        try:
            amplitudes = amplitudes_of(dish, liquid, "linear" if dish.law == "linear" else "amplitude")
        except BadInput as error:
            # A SceneError names its key.
            raise (scene_error("dish.law", str(error)) if type(error) is BadInput else error) from None
    if len(amplitudes) != count:  # a wrong length would let compiled loops read beyond the end
        raise scene_error("dish", f"the shape has {count} walls; got menisci of {len(amplitudes)}")
    charges, number = np.unique(floats.charge, return_inverse=True)
    each = [[capillarity.wall_strength(tension, charge, wall) for charge in charges.tolist()] for wall in amplitudes]
    # In the order of C, as without menisci: for another order each time step is compiled once more.
    return np.take(np.array(each), number, axis=1)


def no_table() -> Array:
    """Return the empty table for walls that follow a formula."""
    return np.zeros((6, 2))


def heights_and_images(dish: DishSpec, liquid: flotation.Liquid, radii: tuple[float, float], found: Meniscus) -> Array:
    """The table of heights and image energies over the distance from a wall, for floats from the smallest to the
    largest radius.
    """
    if law_of(dish, found) != TABLED:
        return no_table()
    smallest, largest = radii
    farthest = found.farthest(dish, liquid, largest)
    logarithms = np.linspace(math.log(0.5 * smallest), math.log(farthest), NODES)
    distance = np.exp(logarithms)
    distance[-1] = farthest
    table = np.zeros((6, NODES))
    table[0, :2] = logarithms[0], logarithms[1] - logarithms[0]
    table[1] = distance
    none = np.zeros_like(distance)
    heights = none if dish.law == "none" else found.heights(dish, liquid, distance)
    mirrored = none if dish.image == "none" else found.images(dish, liquid, distance)
    for row, values in ((HEIGHT, heights), (IMAGE, mirrored)):
        table[row], table[row + 1] = values, _slopes(logarithms, values)
    return table


def _slopes(logarithms: Array, values: Array) -> Array:
    from scipy.interpolate import CubicSpline

    slopes: Array = CubicSpline(logarithms, values)(logarithms, 1)
    return slopes


FIRST_MODE = 1.8411837813406593
"""The first zero of J1'."""


AROUND = 2.0 * np.pi * np.concatenate([np.arange(0, 64, 2), np.arange(1, 64, 2)]) / 64.0
"""Where the sides of an elliptic dish touch the ellipse (a cos t, b sin t). Its corners are outside by 0.12 % of the
ellipse. Every other side comes first: viewers cut the surface of the liquid by 32 lines.
"""


def ellipse(size: tuple[float, float]) -> Surfaces:
    """The inside of 64 tangents of an ellipse with these lengths of its axes (m)."""
    touch, outward = meniscus.oval_tangents(size, AROUND)
    return surfaces.planes(touch, -outward)


class Shape(NamedTuple):
    """A row of the table: the shape of a dish and everything that depends on it."""

    key: str
    """the key of `[dish]` that gives its size: `radius`, `size` or `vertices`"""
    surfaces: Callable[[Any], Surfaces]
    """surfaces(the value of that key): a convex 2D shape around the origin"""
    meniscus: Meniscus | None
    """the menisci at the walls; None if they are not known"""
    no_meniscus: str = ""
    """the reason if they are not known"""
    tilted: Meniscus | None = None
    """the menisci at the walls of a tilted dish"""
    wavenumber: Callable[[Walls], float] = lambda walls: FIRST_MODE * math.sqrt(math.pi / rings.area(walls))
    """of the first sloshing mode (1/m). Default: that of a circle of the same area, the largest for that area"""


SHAPES = {
    "round": Shape(
        "radius",
        lambda radius: surfaces.disc((0.0, 0.0), radius),
        ROUND,
        tilted=OVAL,
        wavenumber=lambda walls: FIRST_MODE / walls.disc_radius,
    ),
    "ring": Shape("radius", lambda radius: surfaces.disc((0.0, 0.0), radius), BETWEEN_ROUND),
    "rectangle": Shape(
        "size",
        lambda size: surfaces.box((-0.5 * size[0], -0.5 * size[1]), (0.5 * size[0], 0.5 * size[1])),
        FACING,
        tilted=LEANING,
        wavenumber=lambda walls: 0.5 * math.pi / max(surfaces.bounds(walls)[1]),
    ),
    "ellipse": Shape("size", ellipse, OVAL, tilted=OVAL),
    "polygon": Shape(
        "vertices",
        surfaces.polygon,
        None,
        no_meniscus="the menisci of two walls meet in a corner, and they are known for right angles only",
    ),
}
"""The shapes by the names of `dish.shape`."""
UNNAMED = {"radius": "round", "size": "rectangle", "vertices": "polygon"}
"""The shape of a dish without a name, by the key of its size."""


def name_of(dish: DishSpec) -> str:
    """The name of the shape of a dish. Raises SceneError for an unknown name, or a wrong key for the size."""
    given = next(key for key in UNNAMED if getattr(dish, key) is not None)
    name = dish.shape or ("ring" if dish.inner_radius is not None else UNNAMED[given])
    if name not in SHAPES:
        raise scene_error("dish.shape", f"got {name!r}; expected one of {', '.join(map(repr, SHAPES))}")
    if SHAPES[name].key != given:
        raise scene_error(f"dish.{given}", f"a dish of the shape {name!r} takes {SHAPES[name].key!r}; got {given!r}")
    return name


def walls_of(dish: DishSpec | None) -> Walls:
    """The walls, at least a radius away from all centers; empty without a dish. Raises SceneError for a shape that is
    not convex, or does not contain the origin.
    """
    if dish is None:
        return no_walls()
    row = SHAPES[name_of(dish)]
    # A round wall that closes has flat leaves, as an iris has; one that is tilted is an ellipse in the level surface.
    flat = dish.radius is not None and (dish.barrier is not None or dish.tilt is not None)
    try:
        walls = enclosed_by(ellipse(_axes(dish)) if flat else row.surfaces(getattr(dish, row.key)))
    except BadInput as fault:
        raise scene_error(f"dish.{row.key}", str(fault)) from fault
    if dish.inner_radius is not None:
        return rings.ring(walls, dish.inner_radius)
    return walls if dish.tilt is None else _cut_level(walls, tilt_of(dish))


def tilt_of(dish: DishSpec) -> meniscus.Tilt:
    """The tilt of a dish; by default none."""
    return meniscus.LEVEL if dish.tilt is None else meniscus.Tilt(dish.tilt.angle, dish.tilt.direction)


def _cut_level(walls: Walls, tilt: meniscus.Tilt) -> Walls:
    """The lines of the walls of a tilted dish in the level surface."""
    outward = np.asarray(meniscus.level_normals(-walls.normal, tilt))
    return walls._replace(normal=-outward, offset=walls.offset / np.cos(meniscus.inclinations(-walls.normal, tilt)))


def outline_of(dish: DishSpec) -> Array:
    """The outer edge of the dish as points of a polygon, counterclockwise, (n, 2) m."""
    return rings.outline(walls_of(dish))


def sloshing_wavenumber(dish: DishSpec) -> float:
    """The wavenumber of the first sloshing mode (1/m) in the upright dish; in a rectangle along its longer side."""
    return SHAPES[name_of(dish)].wavenumber(walls_of(dataclasses.replace(dish, tilt=None)))


def meniscus_of(dish: DishSpec) -> Meniscus:
    """The kind of meniscus at the walls of a dish. Raises SceneError if it is not known."""
    name = name_of(dish)
    row = SHAPES[name]
    found = row.meniscus if dish.tilt is None else row.tilted
    if found is None:
        path, got = ("dish.law", dish.law) if dish.law != "none" else ("dish.image", dish.image)
        raise scene_error(path, f"got {got!r} for the shape {name!r}; expected 'none': {row.no_meniscus}")
    return found


def _has_meniscus(dish: DishSpec | None) -> bool:
    return dish is not None and not (dish.law == "none" and dish.image == "none")


def echoes_known(dish: DishSpec | None) -> bool:
    """Whether multipoles between the walls of a dish are known, or its walls have no menisci."""
    return dish is None or not _has_meniscus(dish) or meniscus_of(dish).multipoles is not None


def wall_law_of(scene: FloatingScene) -> int:
    """The compiled law that the walls follow."""
    dish = scene.dish
    return law_of(dish, meniscus_of(dish)) if dish and _has_meniscus(dish) else NO_WALL_LAW


def wall_strengths(scene: FloatingScene, floats: Floats) -> Array:
    """(walls, N) in J: the strength of the meniscus of each wall for each float."""
    dish, count = scene.dish, wall_count(walls_of(scene.dish))
    if dish is None or not _has_meniscus(dish):
        return np.zeros((count, len(floats.radius)))
    return strengths(scene, floats, meniscus_of(dish), count)


def wall_table_of(scene: FloatingScene, radii: tuple[float, float]) -> Array:
    """The table of the walls, or an empty one."""
    dish = scene.dish
    if dish is None or not _has_meniscus(dish):
        return no_table()
    return heights_and_images(dish, liquid_of(scene), radii, meniscus_of(dish))


def field_of(dish: DishSpec | None, liquid: flotation.Liquid, x: Array, y: Array, advance: float = 0.0) -> Array:
    """The height of the menisci of the walls alone (m), shape (y, x), for pictures; `advance` is the distance of a
    barrier from its side (m).
    """
    if dish is None or dish.law == "none":
        return np.zeros((len(y), len(x)))
    if dish.barrier is not None:
        dish, x, y = _in_front_of_barrier(dish, x, y, advance)
    return meniscus_of(dish).field(dish, liquid, x, y)


def _in_front_of_barrier(dish: DishSpec, x: Array, y: Array, advance: float) -> tuple[DishSpec, Array, Array]:
    """The part of the dish in front of a barrier, and the positions in its frame, whose origin is its center."""
    barrier, sides, places = dish.barrier, list(_sides(dish)), [x, y]
    assert barrier is not None  # noqa: S101  # the caller looked
    axis = 0 if barrier.side in ("left", "right") else 1
    sides[axis] -= (2.0 if barrier.both else 1.0) * advance
    shift = 0.0 if barrier.both else 0.5 * advance * (1.0 if barrier.side in ("right", "top") else -1.0)
    places[axis] = places[axis] + shift
    return dataclasses.replace(dish, size=(sides[0], sides[1]), barrier=None), places[0], places[1]


def behind_barrier(dish: DishSpec | None, advance: float) -> list[Array]:
    """The parts of the dish behind a barrier at this distance from its side, for pictures: rectangles (4, 2) m. The
    barrier is the line from the second to the third corner.
    """
    if dish is None or dish.barrier is None:
        return []
    if dish.barrier.side == ALL:
        return _behind_closing_wall(walls_of(dish), advance)
    half, found = 0.5 * np.array(_sides(dish)), []
    for side in [dish.barrier.side, *([_OPPOSITE[dish.barrier.side]] if dish.barrier.both else [])]:
        axis, outward = (0 if side in ("left", "right") else 1), (1.0 if side in ("right", "top") else -1.0)
        reach = outward * half[axis], outward * (half[axis] - advance)
        corners = np.zeros((4, 2))
        corners[:, axis] = reach[0], reach[1], reach[1], reach[0]
        corners[:, 1 - axis] = half[1 - axis] * np.array([-1.0, -1.0, 1.0, 1.0])
        found.append(corners)
    return found


ALL = "all"
"""The side of a barrier that is the whole wall of a dish."""


def _behind_closing_wall(walls: Walls, advance: float) -> list[Array]:
    """The parts between a wall that closes and its place at the start, one behind each line."""
    outer = surfaces.corners(walls)
    inner = surfaces.corners(walls._replace(offset=walls.offset + advance))
    each = zip(outer, inner, np.roll(inner, -1, axis=0), np.roll(outer, -1, axis=0), strict=True)
    return [np.array(corners) for corners in each]


_OPPOSITE = {"left": "right", "right": "left", "bottom": "top", "top": "bottom"}
