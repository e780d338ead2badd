"""From a scene to the parts that are its interactions."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from ecume.errors import BadInput, Fault, SceneError
from ecume.laws import drag, flotation
from ecume.laws.dipoles import dipole_force, dipole_strength
from ecume.laws.multipole import Undulated
from ecume.models.floating import corrected, films, many, polar
from ecume.models.floating.forces import Superposed
from ecume.models.floating.kinds import distinct_kinds, moments_of
from ecume.models.floating.options import Built
from ecume.models.floating.pair_choice import summed_law
from ecume.models.floating.parameters import Parameters
from ecume.models.floating.walls.shapes import meniscus_of
from ecume.models.floating.walls.wall_laws import acts
from ecume.models.liquids import liquid_of

if TYPE_CHECKING:
    from ecume.scenes.floating import FloatingScene

Bodies = list[tuple[Any, float]]
RAFT_NEIGHBORS = 6.0


def superposed_of(parameters: Parameters, scene: FloatingScene) -> Built:
    """Floats that interact by the pair law."""
    return Built(Superposed(summed_law(parameters)))


def multipoles_of(parameters: Parameters, scene: FloatingScene) -> Built:
    """All floats on one surface."""
    kinds, number = distinct_kinds(scene)
    dish, bodies, liquid = scene.dish, bodies_of(kinds), liquid_of(scene)
    found = _made(
        lambda: many.make_many([bodies[k] for k in number], liquid, scene.interaction.order, parameters.cutoff)
    )
    if dish is not None and acts(parameters):
        found = meniscus_of(dish).multipoles(found, dish, liquid)
    if not any(kind.rim[1] > 0.0 for kind in kinds):
        return Built(found, stiffer=_stiffer(bodies))
    moment, friction, quickest = _turning(parameters, scene, [kinds[k] for k in number])
    turned = found._replace(inertia=moment, friction=friction, advances_angles=not scene.rubs)
    return Built(turned, quickest, _stiffer(bodies))


def _turning(parameters: Parameters, scene: FloatingScene, every: Sequence[Any]) -> tuple[Any, Any, float]:
    """Of floats that turn: their inertia, m a^2/2, what resists, and how quick the stiffest of them is.

    A rim of height H feels a neighbor that touches as a spring of about 12 pi gamma (m H/4)^2 when it turns, over a^2
    when it shifts, by the law of quadrupoles at l = 2 a; six of them at most.
    """
    liquid = liquid_of(scene)
    mass, radius = parameters.floats.mass, parameters.floats.radius
    resisting = [
        drag.disc_turning_friction(float(a), liquid.viscosity) if scene.hydrodynamics.resists else 0.0 for a in radius
    ]
    moment, friction = 0.5 * mass * radius**2, np.array(resisting)
    height = max(kind.rim[0] * kind.rim[1] for kind in every)
    spring = RAFT_NEIGHBORS * 12.0 * math.pi * liquid.surface_tension * (0.5 * height) ** 2
    turning = np.maximum(np.sqrt(moment / spring), friction / spring)
    shifting = np.sqrt(mass / spring) * radius
    return moment, friction, float(min(turning.min(), shifting.min()))


def corrections_of(parameters: Parameters, scene: FloatingScene) -> Built:
    """Tables for pairs. Raises SceneError where there are too many kinds of floats."""
    kinds, number = distinct_kinds(scene)
    if len(kinds) > corrected.MOST_KINDS:
        raise _fault(
            "interaction.method",
            f"'pair-corrected' needs a table for each pair of kinds, and there are {len(kinds)} of them, more than "
            f"{corrected.MOST_KINDS}; take 'multipole' or 'superposition'",
        )
    bodies = bodies_of(kinds)
    tables = _made(lambda: corrected.make_corrected(bodies, number, liquid_of(scene), parameters.cutoff))
    return Built(tables, stiffer=_stiffer(bodies))


def dipoles_of(parameters: Parameters, scene: FloatingScene) -> Built:
    """Floats that are magnets. Two that touch are a spring of 4 F/l; six of them at most."""
    moment = moments_of(scene)
    radius, walls = parameters.floats.radius, parameters.walls
    touching = 2.0 * float(radius.min())
    across = 2.0 * min(walls.disc_radius, float(np.hypot.reduce(walls.offset)) if len(walls.offset) else math.inf)
    cutoff = min(touching / math.sqrt(scene.interaction.accuracy), across)
    strongest = float(np.abs(moment).max())
    at_contact = dipole_force(touching, dipole_strength(strongest, strongest))
    spring, floats = 2.0 * RAFT_NEIGHBORS * 4.0 * at_contact / touching, parameters.floats
    quickest = float(np.min(np.sqrt(floats.mass / spring)))
    if not parameters.scheme.inertia:
        quickest = float(np.min(floats.mass / floats.relaxation_time)) / spring
    return Built(polar.make_polar(moment, cutoff), quickest, reach=cutoff)


def films_of(parameters: Parameters, scene: FloatingScene) -> Built:
    """Films between floats."""
    asked = scene.hydrodynamics.lubrication
    assert asked is not None  # noqa: S101  # for the type checker: the scene has chosen films
    largest, smallest = float(parameters.floats.radius.max()), float(parameters.floats.radius.min())
    return Built(films.make_films(asked.roughness / smallest, asked.cutoff), reach=asked.cutoff * largest)


def bodies_of(kinds: Sequence[Any]) -> Bodies:
    """Bodies and charges."""
    return [
        (Undulated(kind.body, ((*kind.rim, 0.0),)) if kind.rim[1] > 0.0 else kind.body, kind.charge) for kind in kinds
    ]


def _made(make: Callable[[], Any]) -> Any:
    try:
        return make()
    except BadInput as error:
        raise _fault("interaction.method", str(error)) from None


def _stiffer(bodies: Bodies) -> float:
    discs = [body.disc if isinstance(body, Undulated) else body for body, _ in bodies]
    pinned = any(isinstance(disc, flotation.Disc) and disc.tilting for disc in discs)
    return many.STIFFER if pinned else 2.0


def _fault(path: str, message: str) -> SceneError:
    return SceneError([Fault(path, message)])
