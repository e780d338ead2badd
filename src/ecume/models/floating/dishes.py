"""A scene's dish: its walls, the law that they follow, and how strongly they act on each float."""

from __future__ import annotations

import numpy as np

from ecume.engine.walls import Walls
from ecume.engine.walls import dishes as wall_shapes
from ecume.errors import BadInput, Fault, SceneError
from ecume.laws import capillarity, flotation, meniscus
from ecume.models.floating.parameters import DISH, LEGACY_DISH, NO_WALL_LAW, PLANE, TABLED, Floats
from ecume.models.floating.wall_tables import WallKind, wall_table
from ecume.models.liquids import liquid_of
from ecume.scenes.floating import FloatingScene
from ecume.units import Array


def walls_of(scene: FloatingScene) -> Walls:
    """The dish as walls that centers keep a radius away from."""
    if scene.dish is None:
        return wall_shapes.no_walls()
    if scene.dish.radius is not None:
        return wall_shapes.disc(scene.dish.radius)
    assert scene.dish.size is not None  # noqa: S101  # the schema asks for exactly one of the two
    width, height = scene.dish.size
    return wall_shapes.box((-0.5 * width, -0.5 * height), (0.5 * width, 0.5 * height))


def wall_law_of(scene: FloatingScene) -> int:
    """Which compiled law the walls follow."""
    dish = scene.dish
    if dish is None or (dish.law == "none" and dish.image == "none"):
        return NO_WALL_LAW
    if dish.law == "two-point-legacy":
        if dish.radius is None:
            raise _fault("dish.law", f"{dish.law!r} is for round dishes; a rectangular one has the others")
        if dish.image != "none":
            raise _fault("dish.image", f"{dish.law!r} knows no images; leave them out, or take another law")
        return LEGACY_DISH
    if dish.image != "none" or dish.law == "profile":
        return TABLED
    return PLANE if dish.radius is None else DISH


def wall_strengths(scene: FloatingScene, floats: Floats) -> Array:
    """(walls, N) in J: how strongly each wall's meniscus acts on each float."""
    law, liquid = wall_law_of(scene), liquid_of(scene)
    count = wall_shapes.wall_count(walls_of(scene))
    if law == NO_WALL_LAW or scene.dish is None:
        return np.zeros((count, len(floats.radius)))
    tension = liquid.surface_tension
    if law == LEGACY_DISH:
        bonds = (floats.radius / liquid.capillary_length) ** 2
        wall_ratio = (scene.dish.density - liquid.gas_density) / liquid.density_difference
        weight = flotation.weight_number(wall_ratio, scene.dish.contact_angle)
        rows = [
            capillarity.legacy_wall_strength(tension, radius, bond, weight)
            for radius, bond in zip(floats.radius, bonds, strict=True)
        ]
        return np.array([rows])
    amplitudes = _amplitudes(scene, liquid) if scene.dish.law != "none" else [0.0] * count
    if len(amplitudes) != count:  # compiled loops would read beyond the end
        raise _fault("dish", f"the shape has {count} walls, and {scene.dish.law!r} knows menisci of {len(amplitudes)}")
    return np.array(
        [[capillarity.wall_strength(tension, charge, wall) for charge in floats.charge] for wall in amplitudes]
    )


def _amplitudes(scene: FloatingScene, liquid: flotation.Liquid) -> list[float]:
    """Far amplitude of each wall's meniscus (m); a table of a round dish is in capillary lengths."""
    dish = scene.dish
    assert dish is not None  # noqa: S101  # only asked with a dish
    angle, theory = dish.contact_angle, "linear" if dish.law == "linear" else "amplitude"
    try:
        if dish.size is None:
            alone = meniscus.AMPLITUDES[theory](angle, liquid)
            return [liquid.capillary_length if wall_law_of(scene) == TABLED else alone]
        across, along = (meniscus.facing_amplitude(side, angle, liquid, theory) for side in dish.size)
    except BadInput as error:
        raise _fault("dish.law", str(error)) from None
    return [across, along, across, along]


def wall_table_of(scene: FloatingScene, smallest: float) -> Array:
    """The walls' table, or an empty one."""
    dish = scene.dish
    if dish is None or wall_law_of(scene) != TABLED:
        return np.zeros((6, 2))
    assert dish.law is not None  # noqa: S101  # the scene has filled it in
    kind = WallKind(dish.contact_angle, dish.law, dish.image, dish.radius)
    return wall_table(kind, liquid_of(scene), 0.5 * smallest)


def _fault(path: str, message: str) -> SceneError:
    return SceneError([Fault(path, message)])
